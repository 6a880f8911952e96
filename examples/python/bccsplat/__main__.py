"""python3 -m bccsplat FILE.bcc4 OUT.png [TIME]: a picture in the default view; without TIME the middle of the series."""
from __future__ import annotations

import sys

from . import Device, Error, Frame, Renderer, Volume


def main(path: str, picture: str, time: str | None = None) -> None:
    with Device() as device, Volume(device, path) as volume, Renderer(device) as renderer:
        middle = (volume.info().dims[3] - 1) / 2
        renderer.set_slice(volume.slice(frame=middle if time is None else volume.time_to_index(float(time))))
        frame = Frame(device, 512, 512)
        renderer.render(frame)
        frame.save_png(picture, overwrite=True)


if __name__ == "__main__":
    if len(sys.argv) not in (3, 4):
        sys.exit(__doc__)
    try:
        main(*sys.argv[1:])
    except Error as error:
        sys.exit(str(error))
