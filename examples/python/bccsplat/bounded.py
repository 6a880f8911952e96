"""Writing by a bound in dB, which the tool finds the coarsest coding for: the array goes to it as a NRRD file."""
from __future__ import annotations

import os
import subprocess
import tempfile
from typing import Any, BinaryIO, Mapping, Sequence

import numpy as np

from .arrays import Array
from .shared import Path
from .tool import tool_path

_TYPES = {"u1": "uint8", "u2": "uint16", "u4": "uint32", "i1": "int8", "i2": "int16", "i4": "int32", "f4": "float",
          "f8": "double"}


def save_bounded(path: Path, series: Any, *, psnr: float, times: Sequence[float], affine: Array, name: str,
                 unit: str | None, spatial_unit: str | None, time_unit: str | None, attributes: Mapping[str, str],
                 nonfinite: str, overwrite: bool) -> None:
    """Imports frames [t, z, y, x] so that the file has at least `psnr` dB; needs room for them beside `path`."""
    tool = tool_path()
    if tool is None:
        raise NotImplementedError("psnr= needs the tool bcc4, which finds the coding, and none is installed: set "
                                  "BCCSPLAT_TOOL to it, or give abs_error=, which the library keeps by itself")
    if attributes:
        raise NotImplementedError("psnr= goes through the tool, which takes no attributes: leave them out")
    folder = os.path.dirname(os.path.abspath(os.fspath(path)))
    with tempfile.TemporaryDirectory(prefix=".bccsplat-", dir=folder) as scratch:
        source = os.path.join(scratch, "source.nrrd")
        with open(source, "wb") as file:
            write_nrrd(file, series, times, affine, {"content": name, "sample units": unit}, spatial_unit, time_unit)
        run = subprocess.run([tool, "import", source, "--psnr", repr(float(psnr)), "--on-nonfinite", nonfinite, "--quiet",
                              "-o", os.fspath(path), *(["--overwrite"] if overwrite else [])],
                             capture_output=True, text=True)
    if run.returncode:
        raise RuntimeError(run.stderr.strip() or "bcc4 import ended with %d" % run.returncode)


def write_nrrd(file: BinaryIO, series: Any, times: Sequence[float], affine: Array, texts: Mapping[str, str | None],
               spatial_unit: str | None, time_unit: str | None) -> None:
    """Writes frames [t, z, y, x] with their places and times as NRRD, one frame in memory at a time."""
    nt, nz, ny, nx = series.shape
    first = np.asarray(series[0])
    known = first.dtype.str[1:] in _TYPES
    stored = (first.dtype if known else np.dtype("f8" if first.dtype.itemsize == 8 else "f4")).newbyteorder("<")

    def vector(column: int) -> str:
        return "(%s)" % ",".join(repr(float(value)) for value in affine[:3, column])

    lines = ["NRRD0005", "type: " + _TYPES[stored.str[1:]], "dimension: 4", "sizes: %d %d %d %d" % (nx, ny, nz, nt),
             "encoding: raw", "endian: little", "space dimension: 3",
             "space directions: %s none" % " ".join(vector(axis) for axis in range(3)), "space origin: " + vector(3),
             "kinds: space space space time"]
    if spatial_unit:
        lines.append("space units: " + " ".join(['"%s"' % spatial_unit] * 3))
    lines += ["%s: %s" % (key, text) for key, text in texts.items() if text]
    lines.append("axis 3 index type:=numeric")
    lines.append("axis 3 index values:=" + " ".join(repr(float(time)) for time in times))
    if time_unit:
        lines.append("axis 3 index unit:=" + time_unit)
    file.write(("\n".join(lines) + "\n\n").encode())
    for t in range(nt):
        file.write(np.ascontiguousarray(series[t], stored).tobytes())
