#!/usr/bin/env python3
"""How well a picture divides: a table for 1 to 4096 workers of one processor each, from times that are measured on one.

    farm/efficiency.py --work 148 --start 0.62 --part 3.9e6 --merge 0.0036e-6 --width 400 --height 300 --samples 128

Every worker renders one part, all begin at once, and what they have written is moved over one line and joined by one process in the end.
"""
import argparse


def ranges(parts, samples, pixels):
    """Ranges of samples that `bhs render --part` chooses (src/parts/choice.rs); each has sums of all pixels."""
    up = lambda a, b: -(-a // b)
    return min(max(up(parts, up(parts, 64)), up(parts, pixels)), samples)


def main():
    read = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    read.add_argument("--work", type=float, required=True, help="processor time of all samples (s)")
    read.add_argument("--start", type=float, required=True, help="processor time until the first sample (s)")
    read.add_argument("--part", type=float, required=True, help="size of a part of all pixels (bytes)")
    read.add_argument("--merge", type=float, required=True, help="time to join, for each byte (s)")
    read.add_argument("--line", type=float, default=1e8, help="bytes that are moved in a second (1e8)")
    read.add_argument("--width", type=int, required=True)
    read.add_argument("--height", type=int, required=True)
    read.add_argument("--samples", type=int, required=True)
    read.add_argument("--uneven", type=float, default=1.5, help="the slowest window over the mean, where windows divide (1.5)")
    a = read.parse_args()
    print("| workers | start | render | move | join | all | speed-up | processor time | what limits it |")
    print("|--:|--:|--:|--:|--:|--:|--:|--:|---|")
    workers = 1
    while workers <= 4096:
        count = ranges(workers, a.samples, a.width * a.height)
        render = a.work / workers * (a.uneven if count < workers else 1.0)
        size = a.part * count if workers > 1 else 0.0
        move, join = size / a.line, size * a.merge
        times = {"start": a.start, "render": render, "moving": move, "joining": join}
        total = sum(times.values())
        most = max((t, name) for name, t in times.items())[1]
        cost = (a.work + workers * a.start + join) / (a.work + a.start)
        print(f"| {workers} | {a.start:.1f} s | {render:.1f} s | {move:.1f} s | {join:.1f} s | {total:.1f} s "
              f"| {(a.work + a.start) / total:.1f} | {cost:.2f} | {most} |")
        workers *= 4


main()
