"""The program: `pneutherm` and `python -m pneutherm`."""

import signal
import sys

from . import _native


def main() -> int:
    """Does what the command line says and returns the exit code."""
    # Ctrl-C ends the program at once, as it does outside Python; what is being written has a temporary name.
    signal.signal(signal.SIGINT, signal.SIG_DFL)
    return _native.run(["pneutherm", *sys.argv[1:]])


if __name__ == "__main__":
    sys.exit(main())
