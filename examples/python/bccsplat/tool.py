"""The tool bcc4 that comes with the package: where it is, and the command `bcc4` of a wheel."""
from __future__ import annotations

import argparse
import os
import shutil
import sys
from typing import Sequence


def tool_path() -> str | None:
    """The path of the tool: BCCSPLAT_TOOL, else the one inside this package, else `bcc4` in the search path; None where
    there is none."""
    if "BCCSPLAT_TOOL" in os.environ:
        return os.environ["BCCSPLAT_TOOL"]
    inside = inside_path()
    return inside if os.path.exists(inside) else shutil.which("bcc4")


def inside_path() -> str:
    """Where a wheel has the tool."""
    return os.path.join(os.path.dirname(os.path.abspath(__file__)), "bin", "bcc4")


def view(arguments: Sequence[str]) -> None:
    """bcc4 view FILE [--page FOLDER] [--port N] by this package: a wheel has no server for the tool."""
    from . import Error, open
    parser = argparse.ArgumentParser("bcc4 view", description="Look at a .bcc4 file in a browser on this machine.")
    parser.add_argument("file", metavar="FILE", help="a .bcc4 file")
    parser.add_argument("--page", metavar="FOLDER", help="of the viewer, as examples/web/build.sh makes it (default: installed)")
    parser.add_argument("--port", type=int, default=0, help="of 127.0.0.1 (default: any that is free)")
    given = parser.parse_args(arguments)
    try:
        viewing = open(given.file).view(page=given.page, port=given.port)  # open says what is wrong before a browser does
    except (Error, OSError, OverflowError) as error:
        sys.exit("bcc4: %s" % error)
    print(viewing.url, flush=True)
    print("Open this link in a browser; Ctrl-C ends.", file=sys.stderr, flush=True)
    viewing.wait()


def main() -> None:
    """Becomes the tool of this package, with the arguments of the process."""
    if sys.argv[1:2] == ["view"]:
        return view(sys.argv[2:])
    inside = inside_path()
    if not os.path.exists(inside):
        sys.exit("this installation of bccsplat has no tool inside: install a wheel of it, or the package bccsplat-tools")
    os.execv(inside, ["bcc4", *sys.argv[1:]])
