"""LazyArray: what arrays [t, z, y, x] that are read where they are indexed have of a numpy array."""
from __future__ import annotations

from typing import Any, Iterator

import numpy as np

from .arrays import Array


class LazyArray:
    """The part of Volume and FieldArray that follows from their shape."""

    dtype = np.dtype(np.float32)

    @property
    def shape(self) -> tuple[int, ...]:
        """Counts along t, z, y, x."""
        raise NotImplementedError

    @property
    def ndim(self) -> int:
        """4: [t, z, y, x]."""
        return 4

    @property
    def size(self) -> int:
        """Number of values."""
        return int(np.prod(self.shape, dtype=np.int64))

    @property
    def nbytes(self) -> int:
        """Bytes of all values, as they will be in memory; those of a file are info().bytes_file."""
        return self.size * self.dtype.itemsize

    def astype(self, dtype: Any) -> Array:
        """All values as an array of another type."""
        return np.asarray(self).astype(dtype, copy=False)

    def __getitem__(self, key: Any) -> Array:
        raise NotImplementedError

    def __len__(self) -> int:
        return self.shape[0]

    def __iter__(self) -> Iterator[Array]:
        """What there is at each position of time, one after the other."""
        return (self[n] for n in range(len(self)))
