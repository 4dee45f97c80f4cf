"""Make study folders of public measured sets: `python -m softsample.measured ROOT TARGET`."""

import argparse
import sys
from collections.abc import Sequence
from pathlib import Path

from softsample.errors import SoftsampleError
from softsample.measured.folder import write_studies


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command line; prints the study folders and returns the exit status."""
    parser = argparse.ArgumentParser(prog="python -m softsample.measured", description=__doc__)
    parser.add_argument("root", type=Path, help="folder that holds the sets, one folder a set")
    parser.add_argument("target", type=Path, help="folder that the study folders are written to")
    parser.add_argument("wanted", nargs="*", metavar="SET", help="sets or studies (default: all)")
    given = parser.parse_args(arguments)
    try:
        print(*write_studies(given.root, given.target, given.wanted), sep="\n")
    except (SoftsampleError, OSError) as error:
        print(error, file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
