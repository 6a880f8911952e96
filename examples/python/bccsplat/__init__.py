"""bccsplat: time-varying volumes on the D4* lattice, as numpy arrays.

    import bccsplat

    bccsplat.save("smoke.bcc4", array, dt=0.04, spacing=0.5)   # [t, z, y, x]; abs_error=.01 keeps a bound
    volume = bccsplat.open("smoke.bcc4")                       # or "https://...", of which parts are read
    volume[12.5]                                               # [z, y, x] between frames 12 and 13
    volume.show(0.5).save("smoke.png")                         # drawn at time 0.5; a notebook shows it
    volume.view().open()                                       # in a browser, to turn and play

With xarray: xarray.open_dataset("smoke.bcc4", engine="bccsplat"), and dataset.bcc4 (bccsplat.accessor); with zarr:
bccsplat.zarr_store.Store("smoke.bcc4"). Thirty tasks, in a few lines each: tests/examples/python_tasks_test.py.

Underneath is the whole C interface: a class or method here is the C call of the same name, and include/bccsplat.h is their
manual. Arrays are indexed [z, y, x] (x fastest) and are passed without a copy where their type allows. Info structs are the
C structs. Constants are given by name: lattice="d4star", quality="fine", mode="maximum". What is created is released with
its last reference; a with block releases it at once.
"""
from __future__ import annotations

from . import _abi as abi
from ._library import native
from .cameras import camera_matrices, fit_camera, look_at
from .cancel import CancelToken
from .device import Device
from .errors import Cancelled, Error, Status, WouldBlock
from .field_array import FieldArray
from .files import open as open  # not in __all__: a name of a builtin
from .files import save
from .pictures import Picture, Plane, draw
from .plan import Plan
from .render import Frame, RenderOptions, Renderer, TransferFunction, View, box_clips
from .scene import Scene
from .shared import SharedFile, default_device
from .slices import Slice
from .tool import tool_path
from .viewing import Viewing
from .volume import Volume
from .writer import Channel, Writer, join_parts, join_streams

__all__ = ["CancelToken", "Cancelled", "Channel", "Device", "Error", "FieldArray", "Frame", "Picture", "Plane", "Plan",
           "RenderOptions", "Renderer", "Scene", "SharedFile", "Slice", "Status", "TransferFunction", "View", "Viewing", "Volume",
           "WouldBlock", "Writer", "abi", "box_clips", "build_info", "camera_matrices", "default_device", "draw",
           "fit_camera", "join_parts", "join_streams", "kernel_names", "look_at", "save", "tool_path", "version"]


__version__ = "%d.%d.%d" % (abi.VERSION_MAJOR, abi.VERSION_MINOR, abi.VERSION_PATCH)


def version() -> tuple[int, int, int]:
    """Of the library at run time."""
    number: int = native.bccsplat_version()
    return number // 10000, number // 100 % 100, number % 100


def build_info() -> dict[str, str]:
    """How the library was built."""
    return dict(part.split("=", 1) for part in native.bccsplat_build_info().decode().split("; "))


def kernel_names() -> list[str]:
    """Of the kernels of reconstruction, "default" first."""
    found: list[str] = []
    while name := native.bccsplat_kernel_name(len(found)):
        found.append(name.decode())
    return found
