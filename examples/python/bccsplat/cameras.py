"""Cameras: views that fit a box, that look at a point, and as matrices."""
from __future__ import annotations

from ctypes import byref
from typing import Sequence

import numpy as np

from . import _abi
from ._library import call, choose
from .arrays import Array


def fit_camera(bounds: Sequence[float], width: int, height: int, *, rotate_x: float = 20, rotate_y: float = 30,
               side: int | str | None = None, projection: int | str | None = None) -> _abi.Camera:
    """A view that a box of the world fills (x0 y0 z0 x1 y1 z1, such as Slice.seen_bounds or Scene.bounds), from a side
    (such as Volume.side; None: x to the right, y up), turned by angles in degrees."""
    fit = _abi.Fit(projection=choose("PROJECTION", projection), side=choose("SIDE", side), rotate_x_degrees=rotate_x,
                   rotate_y_degrees=rotate_y)
    fit.bounds[:] = [*bounds]
    camera = _abi.Camera()
    call("fit_camera", byref(fit), width, height, byref(camera))
    return camera


def look_at(position: Sequence[float], target: Sequence[float], up: Sequence[float] = (0, 1, 0), *,
            ortho_height: float | None = None, fovy_degrees: float | None = None) -> _abi.Camera:
    """A camera in world space: orthographic by the height of the image plane or perspective by its angle."""
    if (ortho_height is None) == (fovy_degrees is None):
        raise ValueError("give one of ortho_height and fovy_degrees")
    camera = _abi.Camera(ortho_height=ortho_height or 0.0, fovy_degrees=fovy_degrees or 0.0,
                         projection=_abi.PROJECTION_ORTHOGRAPHIC if fovy_degrees is None
                         else _abi.PROJECTION_PERSPECTIVE)
    camera.position[:], camera.target[:], camera.up[:] = [*position], [*target], [*up]
    return camera


def camera_matrices(camera: _abi.Camera, width: int, height: int, near: float, far: float,
                    depth_range: int | str | None = None, y_down: bool = False) -> tuple[Array, Array]:
    """world_to_view and projection of a camera, 4x4 each."""
    world_to_view, projection = np.empty((4, 4)), np.empty((4, 4))
    call("camera_get_matrices", byref(camera), width, height, near, far, choose("DEPTH_RANGE", depth_range), int(y_down),
         world_to_view.ctypes.data, projection.ctypes.data)
    return world_to_view, projection
