"""The tool bcc4 that comes with the package: where it is, and the command `bcc4` of a wheel."""
from __future__ import annotations

import os
import shutil
import sys


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


def main() -> None:
    """Becomes the tool of this package, with the arguments of the process."""
    inside = inside_path()
    if not os.path.exists(inside):
        sys.exit("this installation of bccsplat has no tool inside: install a wheel of it, or the package bccsplat-tools")
    os.execv(inside, ["bcc4", *sys.argv[1:]])
