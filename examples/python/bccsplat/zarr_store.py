"""A .bcc4 file as a read-only store of zarr (format 2): frames and levels, with the metadata of OME-NGFF 0.4.

    group = zarr.open_group(bccsplat.zarr_store.Store("smoke.bcc4"), mode="r")
    group["0"][12, 0, 10]      # level 0: [t, c, z, y, x]; frame 12, channel 0, plane z = 10

Any reader of zarr that takes a store, and any that knows multiscales, sees each level as an array of its own. A chunk is a
frame of a channel, cut at the bricks of the file where it is large, made when it is read: nothing is written anywhere.
"""
from __future__ import annotations

import json
import re
from importlib import import_module
from typing import Any, Iterator

import numpy as np

from .field_array import FieldArray, brick_samples, chunk_samples
from .places import Places
from .shared import Path, SharedFile

storage: Any = import_module("zarr.storage")
errors: Any = import_module("zarr.errors")

# Values in a chunk: 8 MiB.
_CHUNK_VALUES = 1 << 21

# What NGFF calls the units that files have.
_UNITS = {"m": "meter", "cm": "centimeter", "mm": "millimeter", "um": "micrometer", "µm": "micrometer", "nm": "nanometer",
          "km": "kilometer", "s": "second", "sec": "second", "seconds": "second", "ms": "millisecond", "us": "microsecond",
          "min": "minute", "minutes": "minute", "h": "hour", "hours": "hour", "d": "day", "days": "day"}


def spacing_of(places: Places, axis: int) -> tuple[float, float]:
    """Distance and first place of the samples of an even axis, along which others are numbers."""
    if not places.is_even(axis):
        return 1.0, 0.0
    if places.are_numbers(axis):  # as long as the axis is, which lies oblique
        column = places.affine[:3, axis]
        return float(np.copysign(np.linalg.norm(column), column[axis])), float(places.affine[axis, 3])
    first, second = places.at(axis, [0, 1])
    return float(second - first), float(first)


class Store(storage.Store):  # type: ignore[misc]
    """The store. Keys are texts, values bytes; arrays "0", "1", ... are the levels, [t, c, z, y, x] of float32.

    path: of the file. kernel, cache_bytes, salvage: as of Volume. It can be sent to other processes. Whatever would write
    raises zarr.errors.ReadOnlyError.
    """

    _readable, _writeable, _erasable, _listable = True, False, False, True

    def __init__(self, path: Path, *, kernel: str | None = None, cache_bytes: int = 0, salvage: int = 0) -> None:
        self.file = SharedFile(path, kernel=kernel, cache_bytes=cache_bytes, salvage=salvage)
        volume = self.file.volume
        self._levels = range(volume.info().level_count + 1)
        self._channels = volume.info().channel_count
        self._fields = [[FieldArray.whole(self.file, c, n) for c in range(self._channels)] for n in self._levels]
        self._chunks = [self._chunk_shape(n) for n in self._levels]
        self._texts = {key: json.dumps(made, indent=1).encode() for key, made in self._metadata().items()}

    def _shape(self, level: int) -> tuple[int, ...]:
        nt, nz, ny, nx = self._fields[level][0].shape
        return nt, self._channels, nz, ny, nx

    def _chunk_shape(self, level: int) -> tuple[int, ...]:
        space = chunk_samples(self._shape(level)[2:], brick_samples(self.file.volume, level), _CHUNK_VALUES)
        return (1, 1, *space)

    def _metadata(self) -> dict[str, Any]:
        made: dict[str, Any] = {".zgroup": {"zarr_format": 2}, ".zattrs": self._attributes()}
        for n in self._levels:
            made["%d/.zarray" % n] = {"zarr_format": 2, "shape": self._shape(n), "chunks": self._chunks[n], "dtype": "<f4",
                                      "compressor": None, "filters": None, "fill_value": "NaN", "order": "C",
                                      "dimension_separator": "/"}
            made["%d/.zattrs" % n] = {"_ARRAY_DIMENSIONS": ["time", "channel", "z", "y", "x"]}
        made[".zmetadata"] = {"zarr_consolidated_format": 1, "metadata": dict(made)}
        return made

    def _attributes(self) -> dict[str, Any]:
        """Multiscales and channels of OME-NGFF, and what it has no place for: all times, the affine, and the coordinates of
        unevenly spaced axes, along which its own are numbers of samples."""
        volume, info = self.file.volume, self.file.volume.info()
        places = Places(volume)
        step = (info.time_last - info.time_first) / max(1, info.dims[3] - 1) or 1.0
        spacing, origin = zip(*(spacing_of(places, a) for a in (2, 1, 0)))
        kinds = [("t", "time", info.time_unit), ("c", "channel", ""),
                 *(("xyz"[a], "space", places.unit(a) if places.is_even(a) else "") for a in (2, 1, 0))]
        axes = [{"name": name, "type": kind, **({"unit": _UNITS.get(unit, unit)} if unit else {})}
                for name, kind, unit in kinds]
        datasets = [{"path": str(n), "coordinateTransformations": [
            {"type": "scale", "scale": [step, 1.0, *(d * 2**n for d in spacing)]},
            {"type": "translation", "translation": [info.time_first, 0.0, *origin]}]} for n in self._levels]
        uneven = {"xyz"[a]: {"coordinates": places.at(a, self._fields[0][0].axes[3 - a]).tolist(), "unit": places.unit(a)}
                  for a in range(3) if not places.is_even(a)}
        channels = []
        for c in range(self._channels):
            channel = volume.channel_info(c)
            low, high = channel.range[:]
            channels.append({"label": channel.name, "color": "FFFFFF", "active": True,
                             "window": {"min": low, "max": high, "start": low, "end": high}})
        return {"multiscales": [{"version": "0.4", "name": "bcc4", "axes": axes, "datasets": datasets}],
                "omero": {"channels": channels},
                "bcc4": {"times": volume.times().tolist(), "affine": places.affine.reshape(-1).tolist(),
                         "axes": uneven, "attributes": volume.attributes()}}

    def _place(self, key: str) -> tuple[int, list[int]] | None:
        """Level and numbers of a chunk along t, c, z, y, x; None where the key is none of a chunk."""
        if not isinstance(key, str) or not re.fullmatch(r"(0|[1-9]\d*)(/(0|[1-9]\d*)){5}", key):
            return None
        level, *numbers = map(int, key.split("/"))
        if level not in self._levels or any(n >= count for n, count in zip(numbers, self._counts(level))):
            return None
        return level, numbers

    def _counts(self, level: int) -> list[int]:
        return [-(-size // chunk) for size, chunk in zip(self._shape(level), self._chunks[level])]

    def __getitem__(self, key: str) -> bytes:
        if key in self._texts:
            return self._texts[key]
        place = self._place(key)
        if place is None:
            raise KeyError(key)
        level, (t, c, *numbers) = place
        sizes = self._chunks[level][2:]
        begins = [n * size for n, size in zip(numbers, sizes)]
        found = self._fields[level][c][(t, *(slice(b, b + size) for b, size in zip(begins, sizes)))]
        if found.shape == sizes:
            return found.astype("<f4", copy=False).tobytes()
        full = np.full(sizes, np.nan, "<f4")  # chunks at the ends are as large as others
        full[tuple(slice(0, n) for n in found.shape)] = found
        return full.tobytes()

    def __contains__(self, key: object) -> bool:
        return isinstance(key, str) and (key in self._texts or self._place(key) is not None)

    def __iter__(self) -> Iterator[str]:
        yield from self._texts
        for n in self._levels:
            for numbers in np.ndindex(*self._counts(n)):
                yield "/".join(map(str, (n, *numbers)))

    def __len__(self) -> int:
        return len(self._texts) + sum(int(np.prod(self._counts(n))) for n in self._levels)

    def listdir(self, path: str = "") -> list[str]:
        """Names in a folder of keys."""
        parts = [part for part in path.strip("/").split("/") if part]
        if not parts:
            return sorted({key.split("/")[0] for key in self._texts})
        depth = len(parts) - 1
        if not re.fullmatch(r"\d+(/\d+){0,5}", "/".join(parts)) or int(parts[0]) not in self._levels or depth > 4:
            return []
        counts = self._counts(int(parts[0]))
        if any(int(part) >= count for part, count in zip(parts[1:], counts)):
            return []
        numbers = [str(n) for n in range(counts[depth])]
        return numbers if depth else [".zarray", ".zattrs", *numbers]

    def getsize(self, path: str = "") -> int:
        """Bytes of the values of a key or directly in a folder."""
        keys = [path] if path in self else ["/".join(filter(None, (path.strip("/"), name))) for name in self.listdir(path)]
        return sum(self._size(key) for key in keys if key in self)

    def _size(self, key: str) -> int:
        if key in self._texts:
            return len(self._texts[key])
        return 4 * int(np.prod(self._chunks[int(key.split("/")[0])]))

    def _refuse(self, *_arguments: Any, **_named: Any) -> Any:
        raise errors.ReadOnlyError()

    __setitem__ = __delitem__ = clear = pop = popitem = update = setdefault = rmdir = rename = _refuse
