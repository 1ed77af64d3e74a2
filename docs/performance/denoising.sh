#!/bin/sh
# What denoising does to the error of a picture, and what recording its layers costs: the tables of docs/performance.md, "Denoising".
#     docs/performance/denoising.sh [FOLDER]
# Renders the scenes at 200x150 with few samples, with and without --denoise, and with many and another seed: the truth, whose own noise is taken off
# the errors. The noise of a mean m of two halves a and b is known from one of them: (a - m)^2 = (a - b)^2 / 4.
# Pictures that are in FOLDER already are not rendered again. Then times both in turn, unless ROUNDS is 0. Half an hour on two idle cores.
set -eu
root=$(cd -- "$(dirname -- "$0")/../.." && pwd)
folder=${1:-$(mktemp -d)}
bhs=${BHS:-$root/bhs}
samples=${SAMPLES:-4 8 16}
truth=${TRUTH:-1024}
rounds=${ROUNDS:-5}
mkdir -p "$folder"
# Fetches the library if need be; afterwards the program itself is called.
"$root/bhs" denoise --version >/dev/null 2>&1 || true

render() {
    name=$1 && shift
    [ -f "$folder/$name.exr" ] || "$bhs" render "$root/scenes/$scene.bhs" --resolution 200x150 --quiet -o "$folder/$name.exr" "$@"
}

relative_mse() {
    "$bhs" compare "$folder/$1.exr" "$folder/$2.exr" --json | sed -n 's/.*"relative_mse": \([0-9.e+-]*\),*/\1/p'
}

number() {
    sed -n "/\"processor_seconds\"/,/}/s/.*\"$2\": \\([0-9.e+-]*\\),*/\\1/p" "$folder/$1.json"
}

echo "| scene | samples | relative MSE, noisy | denoised | ratio |"
echo "|---|---|---|---|---|"
for scene in gold_dragon spheres_hole cornell_hole; do
    render "$scene.truth" --spp "$truth" --seed 1001
    render "$scene.half" --spp $((truth / 2)) --seed 1001
    own=$(relative_mse "$scene.half" "$scene.truth")
    for n in $samples; do
        render "$scene.noisy$n" --spp "$n"
        render "$scene.denoised$n" --spp "$n" --denoise
        noisy=$(relative_mse "$scene.noisy$n" "$scene.truth")
        denoised=$(relative_mse "$scene.denoised$n" "$scene.truth")
        awk -v s="$scene" -v n="$n" -v own="$own" -v a="$noisy" -v b="$denoised" \
            'BEGIN { a -= own; b -= own; printf "| `%s` | %d | %.2e | %.2e | %.1f |\n", s, n, a, b, a / b }'
    done
done
[ "$rounds" -gt 0 ] || exit 0

echo
echo "| scene | processor time of rendering with --denoise over that without: median of $rounds, least, largest |"
echo "|---|---|"
for scene in gold_dragon spheres_hole cornell_hole; do
    : >"$folder/ratios"
    round=0
    while [ "$round" -lt "$rounds" ]; do
        for flag in "" --denoise; do
            # Without a flag there is no word.
            "$bhs" render "$root/scenes/$scene.bhs" --resolution 200x150 --spp 8 --quiet $flag -o "$folder/timed.exr" \
                --stats "$folder/timed$flag.json"
        done
        echo "$(number timed--denoise render) $(number timed render)" | awk '{ print $1 / $2 }' >>"$folder/ratios"
        round=$((round + 1))
    done
    sort -n "$folder/ratios" | awk -v s="$scene" '{ r[NR] = $1 } END { printf "| `%s` | %.3f, %.3f, %.3f |\n", s, r[int((NR + 1) / 2)], r[1], r[NR] }'
done
