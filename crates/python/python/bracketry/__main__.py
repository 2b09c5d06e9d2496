"""The command ``bracketry``: ``python -m bracketry``, or ``bracketry`` where the package is installed."""

import signal
import sys

from bracketry._native import run_command


def main() -> int:
    """Run the command with the arguments of the interpreter; return its exit code."""
    # Ctrl-C ends the command at once, as it does without an interpreter around it.
    signal.signal(signal.SIGINT, signal.SIG_DFL)
    return run_command(["bracketry", *sys.argv[1:]])


if __name__ == "__main__":
    sys.exit(main())
