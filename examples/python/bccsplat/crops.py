"""Crops of a series in random order, for training: read slab by slab, so that what a crop decodes serves others too."""
from __future__ import annotations

from typing import TYPE_CHECKING, Iterator, Sequence

import numpy as np

from .arrays import Array
from .field_array import FieldArray, chunk_frames

if TYPE_CHECKING:
    from .volume import Volume


def crops_of(volume: Volume, size: Sequence[int], seed: int, count: int | None, channel: int,
             part: tuple[int, int]) -> Iterator[tuple[tuple[int, ...], Array]]:
    """See Volume.crops."""
    shape = volume.shape
    if len(size) != 4 or not all(0 < n <= whole for n, whole in zip(size, shape)):
        raise ValueError("a crop has a size along t, z, y and x, each at most that of the series, %r, not %r" %
                         (shape, tuple(size)))
    index, of = part
    if not 0 <= index < of:
        raise ValueError("part is (number, of how many), such as (0, 4) to (3, 4), not %r" % (part,))
    random = np.random.default_rng([seed, index])
    begins = [0]  # frames that slabs of the file begin with, as far as a crop fits behind them
    for frames in chunk_frames(volume)[:-1]:
        begins.append(begins[-1] + frames)
    lengths = chunk_frames(volume)
    slabs = [(begin, min(begin + length, shape[0] - size[0] + 1)) for begin, length in zip(begins, lengths)]
    slabs = [(begin, end) for begin, end in slabs if begin < end]
    total = int(np.ceil(np.prod([whole / n for whole, n in zip(shape, size)]))) if count is None else count
    share = total // of + (index < total % of)
    ways = np.array([end - begin for begin, end in slabs], np.float64)
    wanted = np.bincount(random.choice(len(slabs), share, p=ways / ways.sum()), minlength=len(slabs))
    field = FieldArray.whole(volume, channel)
    for n in random.permutation(len(slabs)):
        begin, end = slabs[n]
        for _ in range(wanted[n]):
            corner = (int(random.integers(begin, end)),
                      *(int(random.integers(whole - n + 1)) for whole, n in zip(shape[1:], size[1:])))
            yield corner, field[tuple(slice(at, at + n) for at, n in zip(corner, size))]
