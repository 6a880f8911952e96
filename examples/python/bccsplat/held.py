"""What a variable of xarray holds of a file, told by the arrays that it is made of: nothing is read."""
from __future__ import annotations

from importlib import import_module
from typing import Any

import numpy as np

from .arrays import Array
from .field_array import FieldArray

indexing: Any = import_module("xarray.core.indexing")

_WRAPPERS = (indexing.MemoryCachedArray, indexing.CopyOnWriteArray)


def field_of(variable: Any) -> tuple[FieldArray, list[Array]] | None:
    """The array that a variable reads from, and which of its positions along t, z, y and x, of axes that an integer dropped
    one; None of a variable that is loaded, calculated, of dask, or was picked along paths."""
    data, keys = variable._data, []
    while True:
        if isinstance(data, _WRAPPERS):
            data = data.array
        elif type(data) is indexing.LazilyIndexedArray:
            keys.append(data.key.tuple)
            data = data.array
        else:
            break
    field, kept = getattr(data, "field", None), getattr(data, "kept", None)
    if not isinstance(field, FieldArray) or kept is None:
        return None
    taken = [np.arange(len(axis)) for axis in field.axes]
    free = [n for n, there in enumerate(kept) if there]  # axes that the next key has an entry for
    for key in reversed(keys):
        for n, entry in zip(free, key):
            taken[n] = np.atleast_1d(taken[n][entry])
        free = [n for n, entry in zip(free, key) if isinstance(entry, slice) or np.ndim(entry)]
    return field, [axis[at] for axis, at in zip(field.axes, taken)]


def is_loaded(variable: Any) -> bool:
    """Whether its values are in memory, so that comparing them computes nothing but what the file has there."""
    return bool(variable._in_memory)
