"""python3 -m bccsplat: versions, and what is in this installation.
python3 -m bccsplat FILE.bcc4 OUT.png [TIME]: a picture in the default view; without TIME the middle of the series. An
existing picture is not replaced."""
from __future__ import annotations

import os
import subprocess
import sys
from importlib.util import find_spec

from . import Device, Error, Frame, Renderer, Volume, abi, build_info, tool_path, version
from ._library import native


def main(path: str, picture: str, time: str | None = None) -> None:
    """Draws a file to a PNG of 512 x 512 pixels."""
    with Device() as device, Volume(device, path) as volume, Renderer(device) as renderer:
        middle = (volume.info().dims[3] - 1) / 2
        renderer.set_slice(volume.slice(frame=middle if time is None else volume.time_to_index(float(time)), space="even"))
        frame = Frame(device, 512, 512)
        renderer.render(frame)
        frame.save_png(picture)


def contents() -> dict[str, str]:
    """What is installed, in words: versions, the library, the tool, and which optional packages there are."""
    here = os.path.dirname(os.path.abspath(__file__))
    found = {"bccsplat": "%d.%d.%d, ABI %d" % (*version(), abi.ABI_VERSION), "package": here,
             "library": str(native._name)}
    found.update(build_info())
    tool = tool_path()
    found["tool"] = "none" if tool is None else tool
    if tool is not None:
        told = subprocess.run([tool, "--version"], capture_output=True, text=True)
        lines = told.stdout.splitlines()
        found["tool is"] = lines[0] if lines else "none that runs: " + told.stderr.strip()
    inside = os.path.join(here, "lib")
    if os.path.isdir(inside):
        found["inside"] = ", ".join(sorted(os.listdir(inside)))
    optional = ("xarray", "dask", "distributed", "zarr", "matplotlib")
    found["optional packages"] = ", ".join("%s %s" % (name, "yes" if find_spec(name) else "no") for name in optional)
    return found


def print_contents() -> None:
    """Prints contents, a line for each."""
    found = contents()
    width = max(map(len, found))
    for key, text in found.items():
        print("%-*s  %s" % (width, key, text))


if __name__ == "__main__":
    if len(sys.argv) == 1:
        print_contents()
    elif len(sys.argv) not in (3, 4):
        sys.exit(__doc__)
    else:
        try:
            main(*sys.argv[1:])
        except (Error, ValueError) as error:
            sys.exit(str(error))
