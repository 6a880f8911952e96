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


def are_drawable(pixels: Array, shape: tuple[int, ...]) -> bool:
    """Whether a picture can be drawn into a caller's array: float32, writable, rows apart and pixels together."""
    steps = (4 * int(np.prod(shape[2:])), 4)[:len(shape) - 1]
    return (pixels.dtype == np.float32 and pixels.shape == shape and pixels.strides[1:] == steps and pixels.flags.writeable
            and (shape[0] == 1 or abs(pixels.strides[0]) >= shape[1] * steps[0]))


def bytes_of(source: Any) -> Array:
    """The bytes that an object of Python lends, uint8; TypeError of what has none."""
    try:
        return np.frombuffer(source, np.uint8)
    except TypeError:
        raise TypeError("a file is a path, its bytes, or (size, read_at), not %r" % (source,)) from None


def points_of(points: Any, coordinates: int) -> Array:
    """Points [..., coordinates] as doubles; ValueError of another shape."""
    at = np.ascontiguousarray(numbers_of(points, "points"))
    if at.ndim == 0 or at.shape[-1] != coordinates:
        raise ValueError("points must have shape [..., %d], not %r" % (coordinates, at.shape))
    return at


def numbers_of(values: Any, what: str, shape: tuple[int, ...] | None = None) -> Array:
    """Values as doubles, of a shape if one is given, to which a single number is spread; ValueError that says `what` they
    are where that cannot be."""
    try:
        found = np.asarray(values, np.float64)
        return found if shape is None else np.broadcast_to(found, shape)
    except (TypeError, ValueError):
        raise ValueError("%s must be numbers%s, not %r" %
                         (what, "" if shape is None else " of shape %r" % (shape,), values)) from None


def corners_of(box: Any) -> Array | None:
    """The six numbers of a box ((x0, y0, z0), (x1, y1, z1)); None for none."""
    if box is None:
        return None
    found = np.ascontiguousarray(numbers_of(box, "box"))
    if found.size != 6:
        raise ValueError("box must be two corners ((x0, y0, z0), (x1, y1, z1)) in index units, not %r" % (box,))
    return found.reshape(6)
