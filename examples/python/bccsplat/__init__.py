"""bccsplat: time-varying volumes on the D4* lattice, through ctypes and numpy.

    from bccsplat import Device, Frame, Renderer, Volume

    with Device() as device, Volume(device, "smoke.bcc4") as volume, Renderer(device) as renderer:
        renderer.set_slice(volume.slice(frame=3.5))
        frame = Frame(device, 512, 512)
        renderer.render(frame)
        frame.save_png("smoke.png", overwrite=True)

include/bccsplat.h is the manual: a class or method here is the C call of the same name. Arrays are indexed
[z, y, x] (x fastest) and are passed without a copy where their type allows. Info structs are the C structs.
Constants are given by name: lattice="d4star", quality="fine", mode="maximum".
"""
from __future__ import annotations

from . import _abi as abi
from ._library import Cancelled, Error, Status, WouldBlock, native
from .cancel import CancelToken
from .device import Device
from .render import (Frame, RenderOptions, Renderer, TransferFunction, View, box_clips, camera_matrices, fit_camera,
                     look_at)
from .scene import Scene
from .volume import Slice, Volume
from .writer import Channel, Writer, join_parts, join_streams

__all__ = ["CancelToken", "Cancelled", "Channel", "Device", "Error", "Frame", "RenderOptions", "Renderer", "Scene", "Slice",
           "Status", "TransferFunction", "View", "Volume", "WouldBlock", "Writer", "abi", "box_clips", "build_info",
           "camera_matrices", "fit_camera", "join_parts", "join_streams", "kernel_names", "look_at", "version"]


def version() -> tuple[int, int, int]:
    """Of the library at run time."""
    number: int = native.bccsplat_version()
    return number // 10000, number // 100 % 100, number % 100


def build_info() -> dict[str, str]:
    """How the library was built."""
    return dict(part.split("=", 1) for part in native.bccsplat_build_info().decode().split("; "))


def kernel_names() -> list[str]:
    found: list[str] = []
    while name := native.bccsplat_kernel_name(len(found)):
        found.append(name.decode())
    return found
