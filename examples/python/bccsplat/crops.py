"""Crops of a series in random order, for training: read piece by piece, so that what one decodes serves the others."""
from __future__ import annotations

from typing import TYPE_CHECKING, Iterator, Sequence

import numpy as np

from .arrays import Array
from .field_array import FieldArray, chunk_frames

if TYPE_CHECKING:
    from .volume import Volume

# A piece is read as a whole where its crops together hold at least this share of its values.
_WORTH = .25


def pieces_of(shape: Sequence[int], size: Sequence[int], slabs: Sequence[int], memory: int) -> list[tuple[range, range]]:
    """Frames and rows along z that crops of a piece begin with: of a slab of the file, and of as many rows as memory has
    room for. Each place is in one of them."""
    found, begin, frame = [], 0, 4 * shape[2] * shape[3]
    for frames in slabs:
        first = range(begin, min(begin + frames, shape[0] - size[0] + 1))
        begin += frames
        if first:
            rows = max(1, memory // (frame * (len(first) + size[0] - 1)) - size[1] + 1)
            last = shape[1] - size[1] + 1
            found += [(first, range(z, min(z + rows, last))) for z in range(0, last, rows)]
    return found


def crops_of(volume: Volume, size: Sequence[int], seed: int, count: int | None, channel: int, part: tuple[int, int],
             memory: int) -> Iterator[tuple[tuple[int, ...], Array]]:
    """See Volume.crops."""
    shape = volume.shape
    if len(size) != 4 or not all(0 < n <= whole for n, whole in zip(size, shape)):
        raise ValueError("a crop has a size along t, z, y and x, each at most that of the series, %r, not %r" %
                         (shape, tuple(size)))
    worker, of = part
    if not 0 <= worker < of:
        raise ValueError("part is (number, of how many), such as (0, 4) to (3, 4), not %r" % (part,))
    total = int(np.ceil(np.prod([whole / n for whole, n in zip(shape, size)]))) if count is None else count
    pieces = pieces_of(shape, size, chunk_frames(volume), memory)
    chances = np.array([len(frames) * len(rows) for frames, rows in pieces], np.float64)
    random = np.random.default_rng(seed)
    counts = np.bincount(random.choice(len(pieces), total, p=chances / chances.sum()), minlength=len(pieces))
    order = random.permutation(len(pieces))
    mine = order[worker::of] if len(pieces) >= 2 * of else order  # few pieces: each worker has some of the crops of all
    for n in mine:
        wanted = int(counts[n]) if mine is not order or of == 1 else int(counts[n] // of + (worker < counts[n] % of))
        frames, rows = pieces[int(n)]
        yield from _crops_of_piece(FieldArray.whole(volume, channel), size, frames, rows, wanted,
                                   np.random.default_rng([seed, int(n), worker]))


def _crops_of_piece(field: FieldArray, size: Sequence[int], frames: range, rows: range, wanted: int,
                    random: np.random.Generator) -> Iterator[tuple[tuple[int, ...], Array]]:
    shape = field.shape
    ends = (frames.stop + size[0] - 1, rows.stop + size[1] - 1)
    whole = (ends[0] - frames.start) * (ends[1] - rows.start) * shape[2] * shape[3]
    held = field[frames.start:ends[0], rows.start:ends[1]] if wanted * np.prod(size) >= _WORTH * whole else None
    for _ in range(wanted):
        corner = (int(random.integers(frames.start, frames.stop)), int(random.integers(rows.start, rows.stop)),
                  *(int(random.integers(n - m + 1)) for n, m in zip(shape[2:], size[2:])))
        key = tuple(slice(at, at + n) for at, n in zip(corner, size))
        if held is None:
            yield corner, field[key]
        else:
            yield corner, held[tuple(slice(entry.start - first, entry.stop - first)
                                     for entry, first in zip(key, (frames.start, rows.start, 0, 0)))].copy()
