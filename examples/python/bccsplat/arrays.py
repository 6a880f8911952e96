"""Arrays as the library takes and fills them."""
from __future__ import annotations

from typing import Any

import numpy as np

Array = np.ndarray[Any, np.dtype[Any]]


def floats_of(out: Array | None, shape: tuple[int, ...]) -> Array:
    """The caller's array, if it is one that can be written to directly, or a new one."""
    if out is None:
        return np.empty(shape, np.float32)
    if out.shape != shape or out.dtype != np.float32 or not out.flags.c_contiguous or not out.flags.writeable:
        raise ValueError("out must be a contiguous float32 array of shape %r" % (shape,))
    return out


def points_of(points: Any, coordinates: int) -> Array:
    """Points [..., coordinates] as doubles; ValueError of another shape."""
    at = np.ascontiguousarray(points, np.float64)
    if at.ndim == 0 or at.shape[-1] != coordinates:
        raise ValueError("points must have shape [..., %d], not %r" % (coordinates, at.shape))
    return at
