"""The program `bhs`: what the command of this name and `python -m bhs` run."""

import signal
import sys

from . import _bhs


def main() -> None:
    """Runs the program with the words of the command line. It does not return."""
    # The program listens to signals itself.
    signal.signal(signal.SIGINT, signal.SIG_DFL)
    _bhs.run(["bhs", *sys.argv[1:]])


if __name__ == "__main__":
    main()
