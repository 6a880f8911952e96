"""FieldArray: the field of a volume at places of index space, as an array [t, z, y, x] that is read when it is asked for."""
from __future__ import annotations

from typing import Any, Sequence, Union

import numpy as np

from . import _abi
from .arrays import Array
from .errors import Error
from .lazy_array import LazyArray
from .shared import SharedFile
from .slices import Slice
from .volume import Volume

# What an axis may be indexed with: an integer, a slice, or a list of integers or booleans.
Key = Union[int, slice, Sequence[int], Array]

AXES = ("t", "z", "y", "x")
# Frames of so few values are evaluated point by point, all of them in one call.
_FEW = 64


def index_positions(count: int, level: int) -> Array:
    """Positions [n] (float64, index units) of the samples of an axis of `count` samples at a level."""
    return np.arange(0, count, 1 << level, dtype=np.float64)


def entry_of(entry: Any) -> Any:
    """One entry of a key: an integer, a slice, or an array of one dimension; IndexError of what numpy takes otherwise."""
    if isinstance(entry, (slice, str, bytes)):
        return entry
    found = np.asarray(entry)
    if entry is None or found.ndim > 1 or (found.ndim == 0 and found.dtype == np.bool_):
        raise IndexError("%s is no frame and no sample: give whole numbers, slices, or a list of one dimension; "
                         "numpy.asarray(volume) takes all that numpy knows" %
                         (found if found.ndim == 0 else "an array of shape %r" % (found.shape,)))
    return found[()] if found.ndim == 0 else found if found.size else found.astype(np.int64)


def full_key(key: Any, dimensions: int) -> tuple[Any, ...]:
    """The key with one entry of entry_of for each dimension, as numpy reads it."""
    entries = list(key) if isinstance(key, tuple) else [key]
    where = [n for n, entry in enumerate(entries) if entry is Ellipsis]
    if len(where) > 1 or len(entries) - len(where) > dimensions:
        raise IndexError("too many indices: there are %d dimensions" % dimensions)
    rest = [slice(None)] * (dimensions - len(entries) + len(where))
    at = where[0] if where else len(entries)
    return tuple(entry_of(entry) for entry in (*entries[:at], *rest, *entries[at + len(where):]))


def dropped(key: tuple[Any, ...]) -> tuple[Any, ...]:
    """What takes the axes of a full key that were given an integer out of an array that still has them."""
    return tuple(0 if np.ndim(entry) == 0 and not isinstance(entry, slice) else slice(None) for entry in key)


def as_numpy(picked: FieldArray, key: tuple[Any, ...]) -> Array:
    """What numpy makes of a full key, of the array that it selects: an axis with a list comes first where a slice stands
    between it and an integer. IndexError of several lists, which numpy pairs."""
    lists = [n for n, entry in enumerate(key) if np.ndim(entry) == 1]
    if len(lists) > 1:
        raise IndexError("lists for several axes, which numpy pairs: give one, and index what comes by the other; for all "
                         "pairs field().select(key).read()")
    whole, taken = picked.read(), [n for n, entry in enumerate(key) if not isinstance(entry, slice)]
    if lists and taken != [*range(taken[0], taken[-1] + 1)]:
        whole, key = np.moveaxis(whole, lists[0], 0), (key[lists[0]], *key[:lists[0]], *key[lists[0] + 1:])
    return np.asarray(whole[dropped(key)])


def check_moments(t: Any) -> None:
    """IndexError of what is no frame, moment, slice or list of these."""
    if isinstance(t, slice):
        if any(isinstance(end, (float, np.floating)) for end in (t.start, t.stop, t.step)):
            raise IndexError("a slice of frames has whole numbers, not %r: list moments between them, such as "
                             "volume[numpy.arange(1.5, 3, 0.5)]" % (t,))
        return
    if isinstance(t, (str, bytes)):
        raise IndexError("%r is no frame: a channel by its name is volume.field(%r)" % (t, t))
    moments = np.asarray(t)
    if moments.dtype.kind not in "iufb" or not np.isfinite(moments).all():
        raise IndexError("%r is no frame: give a number, a slice, or a list of numbers" % (t,))


class GridAxis:
    """An equally spaced axis that holds the wanted positions, and which of its samples they are."""

    def __init__(self, positions: Array) -> None:
        unique = np.unique(positions)
        steps = np.diff(unique)
        self.origin, self.step = float(unique[0]), 1.0
        self.exact = True
        if len(steps):
            whole = np.array_equal(unique, np.rint(unique))
            self.step = float(np.gcd.reduce(steps.astype(np.int64))) if whole else float(steps.mean())
            self.exact = whole or bool(np.allclose(steps, self.step, rtol=1e-9, atol=0))
        self.count = int(round((float(unique[-1]) - self.origin) / self.step)) + 1
        take = np.rint((positions - self.origin) / self.step).astype(np.int64)
        self.take: Array | None = None if np.array_equal(take, np.arange(self.count)) else take


class FieldArray(LazyArray):
    """The field of one channel at the outer product of positions along t, z, y and x, float32.

    source: a Volume, or a SharedFile, with which the array can be sent to other processes.
    axes: positions along t (frame numbers), z, y, x in index units, float64; each may lie between samples.
    level: of the volume, 0 the finest. Indexing reads the box and the frames that it needs and no others. Outside the
    samples of space and in holes values are NaN; frames outside the series raise Error or IndexError. Where a frame has 64
    values or fewer they are evaluated as points, which gives the same but for rounding.
    """

    def __init__(self, source: Volume | SharedFile, axes: Sequence[Array], channel: int = 0, level: int = 0) -> None:
        self.source, self.channel, self.level = source, channel, level
        self.axes = tuple(np.asarray(axis, np.float64).reshape(-1) for axis in axes)

    @classmethod
    def whole(cls, source: Volume | SharedFile, channel: int = 0, level: int = 0) -> FieldArray:
        """All frames and samples of a level: every 2**level-th sample along x, y and z."""
        volume = source if isinstance(source, Volume) else source.volume
        nx, ny, nz, nt = volume.info().dims[:]
        if not 0 <= level <= volume.info().level_count:
            raise ValueError("there is no level %d: the file has the levels 0 to %d" % (level, volume.info().level_count))
        return cls(source, [index_positions(nt, 0), *(index_positions(n, level) for n in (nz, ny, nx))], channel, level)

    @property
    def volume(self) -> Volume:
        """The open volume behind it."""
        return self.source if isinstance(self.source, Volume) else self.source.volume

    @property
    def shape(self) -> tuple[int, ...]:
        """Counts along t, z, y, x."""
        return tuple(len(axis) for axis in self.axes)

    def select(self, key: Any) -> FieldArray:
        """The array of some of the positions, nothing of which is read: integers, slices, lists and boolean masks, each
        for its own axis. Axes given an integer stay, with one position."""
        chosen = []
        for name, axis, entry in zip(AXES, self.axes, full_key(key, self.ndim)):
            if isinstance(entry, (int, np.integer)) and not -len(axis) <= entry < len(axis):
                raise IndexError("index %d is out of bounds for axis %s of %d" % (entry, name, len(axis)))
            try:
                chosen.append(axis[entry])
            except (IndexError, TypeError):
                raise IndexError("axis %s of %d is indexed by whole numbers, slices and lists of these, not by %r; between "
                                 "samples, evaluate takes points" % (name, len(axis), entry)) from None
        return FieldArray(self.source, chosen, self.channel, self.level)

    def __getitem__(self, key: Any) -> Array:
        """Values float32 as of a numpy array, with one list or mask at most."""
        full = full_key(key, self.ndim)
        return as_numpy(self.select(full), full)

    def __array__(self, dtype: Any = None, copy: bool | None = None) -> Array:
        return np.asarray(self.read(), dtype)

    def read(self, out: Array | None = None) -> Array:
        """All values [t, z, y, x], float32; `out`: a contiguous float32 array of that shape, which is filled."""
        values = np.empty(self.shape, np.float32) if out is None else out
        if self.size and self.level == 0 and self.size <= _FEW * len(self):
            self._evaluate_points(values)
        elif self.size:
            space = [GridAxis(axis) for axis in self.axes[:0:-1]]  # x, y, z
            for n, frame in enumerate(self.axes[0]):
                self._read_frame(float(frame), space, values[n])
        return values

    def _evaluate_points(self, values: Array) -> None:
        last = self.volume.info().dims[3] - 1 + self.volume.info().time_periodic
        if (outside := self.axes[0][(self.axes[0] < 0) | (self.axes[0] > last)]).size:
            raise IndexError("frame %g is outside the series, 0 to %d" % (outside[0], last))
        t, z, y, x = np.meshgrid(*self.axes, indexing="ij")
        evaluate_or_nan(self.volume, np.stack([x, y, z, t], -1), values, channel=self.channel)

    def _read_frame(self, frame: float, space: list[GridAxis], out: Array) -> None:
        if self.level == 0 and self._is_stored(frame, space):
            self.volume.read_frame(int(frame), [int(axis.origin) for axis in space],
                                   [int(axis.origin) + axis.count for axis in space], self.channel, out)
            return
        box = self._box()
        if box is None:
            out[...] = np.nan
            return
        cut = Slice.at(self.volume, frame, channel=self.channel, level=self.level, **box)
        if not all(axis.exact for axis in space):
            out[...] = self._evaluate(cut)
            return
        origin, step, dims = ([getattr(axis, name) for axis in space] for name in ("origin", "step", "count"))
        taken = [axis.take for axis in space[::-1]]
        if all(take is None for take in taken):
            cut.sample_grid(origin, step, dims, out=out)
            return
        found = cut.sample_grid(origin, step, dims)
        out[...] = found[np.ix_(*(np.arange(n) if take is None else take for take, n in zip(taken, found.shape)))]

    def _is_stored(self, frame: float, space: list[GridAxis]) -> bool:
        """Whether these are samples of the source, one beside the other, in a frame of it."""
        dims = self.volume.info().dims
        return (frame.is_integer() and 0 <= frame < dims[3] and
                all(axis.take is None and axis.step == 1 and axis.origin.is_integer() and 0 <= axis.origin and
                    axis.origin + axis.count <= n for axis, n in zip(space, dims)))

    def _box(self) -> dict[str, Any] | None:
        """The option of a slice that reads no more than the positions need; none where that is all of it."""
        low = np.array([axis.min() for axis in self.axes[:0:-1]])
        high = np.array([axis.max() for axis in self.axes[:0:-1]])
        info = self.volume.info()
        last = np.array([n - 1 + (info.periodic_axes >> a & 1) for a, n in enumerate(info.dims[:3])], np.float64)
        if (low > last).any() or (high < 0).any():
            return None
        whole = (low <= 0).all() and (high >= last - (1 << self.level) + 1).all()
        return {} if whole else {"box": [np.maximum(low, 0), np.minimum(high, last)]}

    def _evaluate(self, cut: Slice) -> Array:
        z, y, x = np.meshgrid(*self.axes[1:], indexing="ij")
        points = np.stack([x, y, z], -1)
        values = np.full(points.shape[:-1], np.nan, np.float32)
        return evaluate_or_nan(cut, points, values)


def evaluate_or_nan(field: Volume | Slice, points: Array, values: Array, **options: Any) -> Array:
    """`values` (float32), filled at points; NaN outside the domain and in holes."""
    try:
        field.evaluate(points, out=values, **options)
    except Error as error:
        if error.status not in (_abi.ERROR_OUT_OF_DOMAIN, _abi.ERROR_HOLE):
            raise
    return values


def chunk_frames(volume: Volume, level: int = 0) -> tuple[int, ...]:
    """Numbers of frames, in order, that lie in one slab of a level each: frames of one are read together."""
    info, at = volume.info(), volume.level_info(level)
    frames, per_slab = info.dims[3], at.slab_layers
    if frames == 1:
        return (1,)
    distance = at.scales[3] / (np.sqrt(2) if info.lattice == _abi.LATTICE_D4STAR else 1)
    extra = at.layer_count - int(np.ceil((frames - 1) / distance - 1e-9)) - 1
    lead = extra // 4 * 2  # of those before frame 0, an even number, there are as many behind the last frame
    starts = np.ceil((np.arange(0, at.layer_count, per_slab) - lead) * distance - 1e-9)
    starts = np.unique(np.clip(starts, 0, frames))
    return tuple(int(n) for n in np.diff([*starts[starts < frames], frames]) if n > 0)


def chunk_samples(shape: Sequence[int], bricks: Sequence[float], most: int) -> tuple[int, int, int]:
    """Samples along z, y, x of chunks that are whole bricks (bricks: samples in one along z, y, x) and that hold at most
    `most` samples, or one brick: halved along the longest axis until they do."""
    counts = [int(n) for n in shape]
    while counts[0] * counts[1] * counts[2] > most:
        axis = max(range(3), key=lambda a: counts[a])
        smaller = int(np.ceil(np.ceil(counts[axis] / 2) / bricks[axis]) * bricks[axis])
        if smaller >= counts[axis]:
            break
        counts[axis] = smaller
    return counts[0], counts[1], counts[2]


def brick_samples(volume: Volume, level: int) -> list[float]:
    """Samples of a level along z, y, x that are stored together: 16 sites of a coset, or a tile of 64 of wavelets."""
    info, at = volume.info(), volume.level_info(level)
    edge = 64 if info.store == _abi.STORE_WAVELETS else 16
    planes = 1 if info.lattice == _abi.LATTICE_CC else np.sqrt(2)
    return [max(1.0, round(edge * planes * at.scales[a] / (1 << level))) for a in (2, 1, 0)]
