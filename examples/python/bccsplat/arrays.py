"""Arrays as the library takes and fills them."""
from __future__ import annotations

import operator
from typing import Any

import numpy as np

Array = np.ndarray[Any, np.dtype[Any]]
_ma: Any = np.ma  # whose functions have no types


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


def loaded(values: Any) -> Array:
    """An array, masked or not, of anything that is like one: arrays of dask are computed, lists put together."""
    if isinstance(values, (list, tuple)) and values and not np.isscalar(values[0]):
        parts = [loaded(value) for value in values]
        if any(isinstance(part, np.ma.MaskedArray) for part in parts):
            return np.asanyarray(_ma.stack(parts))
    return np.asanyarray(values.compute() if hasattr(values, "compute") else values)


def unmasked(values: Any) -> Array:
    """The same without a mask: what one of numpy.ma hides, as netCDF4 has it, is NaN, and whole numbers are floats then."""
    found = loaded(values)
    if not _ma.is_masked(found):
        return np.asarray(found)
    hidden: Array = _ma.filled(found.astype(np.promote_types(found.dtype, np.float16)), np.nan)
    return hidden


def fills_of(variable: Any) -> Array:
    """The values that stand for missing data, as the attributes _FillValue and missing_value of a variable of netCDF4,
    h5py, zarr or xarray say."""
    attributes = getattr(variable, "attrs", None)
    said = [getattr(variable, name, None) if attributes is None else attributes.get(name)
            for name in ("_FillValue", "missing_value")]
    numbers = [np.ravel(fill) for fill in said if np.asarray(fill).dtype.kind in "iuf"]
    fills: Array = np.concatenate(numbers) if numbers else np.empty(0)
    if getattr(variable, "scale", False) is True:  # netCDF4 scales them with the values
        fills = fills * getattr(variable, "scale_factor", 1) + getattr(variable, "add_offset", 0)
    return fills


def masked(values: Any, fills: Array) -> Array:
    """An array as of loaded, with a mask where it has fill values. One that has a mask has these in it already."""
    found = loaded(values)
    if isinstance(found, np.ma.MaskedArray) or not fills.size:
        return found
    same = fills.astype(found.dtype) if found.dtype.kind == "f" else fills
    hidden: Array = _ma.array(found, mask=np.isin(found, same))
    return hidden


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
        given = unmasked(values)
        if given.dtype.kind in "mM":  # whose numbers are of any unit
            raise TypeError
        found = given.astype(np.float64, copy=False)
        return found if shape is None else np.broadcast_to(found, shape)
    except (TypeError, ValueError):
        raise ValueError("%s must be numbers%s, not %r" %
                         (what, "" if shape is None else " of shape %r" % (shape,), values)) from None


def whole(number: Any, what: str) -> int:
    """A whole number of any type of integers; TypeError of others, which would be cut short."""
    try:
        return operator.index(number)
    except TypeError:
        raise TypeError("%s must be a whole number, not %r" % (what, number)) from None


def corners_of(box: Any) -> Array | None:
    """The six numbers of a box ((x0, y0, z0), (x1, y1, z1)); None for none."""
    if box is None:
        return None
    found = np.ascontiguousarray(numbers_of(box, "box"))
    if found.size != 6:
        raise ValueError("box must be two corners ((x0, y0, z0), (x1, y1, z1)) in index units, not %r" % (box,))
    return found.reshape(6)


def affine_of(affine: Any) -> Array:
    """A caller's affine as [4, 4]; ValueError of another shape, and of zeros, which mean none to the library."""
    found = numbers_of(affine, "affine")
    if found.size != 16:
        raise ValueError("affine must be [4, 4], from (x, y, z, 1) of samples to the world, not of shape %r" %
                         (found.shape,))
    if not found.any():
        raise ValueError("affine is all zeros: it must take samples to places apart; leave it out for an identity")
    return found.reshape(4, 4)
