"""The engine "bccsplat" of xarray: .bcc4 files as datasets (time, z, y, x) that are read where they are indexed.

    ds = xarray.open_dataset("smoke.bcc4", engine="bccsplat", chunks={})   # dask chunks along the file's slabs
    ds = xarray.open_dataset("smoke.bcc4", engine="bccsplat", level=1)     # a coarser level

Of dask arrays each chunk is read where it is computed, by any thread or process. dataset.bcc4 is in bccsplat.accessor.
"""
from __future__ import annotations

import os
from importlib import import_module
from typing import Any, Iterable, Sequence

import numpy as np

from .arrays import Array
from .field_array import FieldArray, brick_samples, chunk_frames, chunk_samples, dropped
from .shared import SharedFile
from .volume import Volume

# Optional packages, whose types are not looked at.
xarray: Any = import_module("xarray")
indexing: Any = import_module("xarray.core.indexing")
backends: Any = import_module("xarray.backends")

# Words for calendars that CF writes otherwise.
_CALENDARS = {"360": "360_day", "365": "365_day", "366": "366_day"}

# Values in one preferred chunk: 128 MiB.
_CHUNK_VALUES = 1 << 25

DIMENSIONS = ("time", "z", "y", "x")
_WORLD_AXES = {"x": 0, "y": 1, "z": 2}


class LazyField(backends.BackendArray):  # type: ignore[misc]
    """A FieldArray as xarray indexes it. kept: which of the axes t, z, y, x there are; others have one position."""

    def __init__(self, field: FieldArray, kept: Sequence[bool] = (True,) * 4) -> None:
        self.field, self.kept = field, tuple(kept)
        self.shape = tuple(count for count, there in zip(field.shape, kept) if there)
        self.dtype = field.dtype

    def __getitem__(self, key: Any) -> Any:
        return indexing.explicit_indexing_adapter(key, self.shape, indexing.IndexingSupport.OUTER, self._outer)

    def _outer(self, key: tuple[Any, ...]) -> Array:
        entries = iter(key)
        full = tuple(next(entries) if there else 0 for there in self.kept)
        return np.asarray(self.field.select(full).read()[dropped(full)])


def lazy_variable(field: FieldArray, attrs: dict[str, Any], kept: Sequence[bool] = (True,) * 4) -> Any:
    """A variable of xarray of which nothing is read yet."""
    data = indexing.LazilyIndexedArray(LazyField(field, kept))
    dims = tuple(name for name, there in zip(DIMENSIONS, kept) if there)
    return xarray.Variable(dims, data, attrs, {"dtype": field.dtype, "_FillValue": np.float32(np.nan)})


def text_of(value: bytes | None) -> str:
    """What the library has as bytes, or ""."""
    return (value or b"").decode()


def affine_of(volume: Volume) -> Array:
    """Index space to world, [4, 4]."""
    return np.array(volume.info().affine[:], np.float64).reshape(4, 4)


def is_along_axes(affine: Array) -> bool:
    """Whether x, y and z of the samples are those of the world, in either direction."""
    return bool(np.count_nonzero(affine[:3, :3]) == 3 and np.diag(affine)[:3].all())


def space_coordinate(volume: Volume, name: str, positions: Array) -> Any:
    """The coordinate of x, y or z: places in the world where the samples lie along its axes, else sample numbers."""
    axis, affine = _WORLD_AXES[name], affine_of(volume)
    attrs = {"axis": name.upper(), "long_name": name}
    if not is_along_axes(affine):
        return xarray.Variable((name,), positions, {**attrs, "long_name": "sample along " + name, "units": "1"})
    if unit := text_of(volume.info().spatial_unit):
        attrs["units"] = unit
    return xarray.Variable((name,), affine[axis, axis] * positions + affine[axis, 3], attrs)


def time_coordinate(volume: Volume, times: Array, dims: tuple[str, ...] = ("time",)) -> Any:
    """The coordinate of time in the file's unit; with the date of its 0 where the file knows that, as CF has it."""
    attributes, attrs = volume.attributes(), {"axis": "T", "standard_name": "time", "long_name": "time"}
    unit = text_of(volume.info().time_unit)
    if epoch := attributes.get("time_epoch", ""):
        attrs["units"] = "%s since %s" % (unit, epoch)
        calendar = attributes.get("time_calendar", "standard")
        attrs["calendar"] = _CALENDARS.get(calendar, calendar)
    elif unit:
        attrs["units"] = unit
    return xarray.Variable(dims, times, attrs)


def channel_attrs(volume: Volume, channel: int) -> dict[str, Any]:
    """CF attributes of a channel."""
    info = volume.channel_info(channel)
    attrs: dict[str, Any] = {"long_name": text_of(info.name), "actual_range": np.array(info.range[:])}
    if unit := text_of(info.unit):
        attrs["units"] = unit
    if info.error_bound:
        attrs["bcc4_error_bound"] = info.error_bound
    return attrs


def file_attrs(volume: Volume, level: int) -> dict[str, Any]:
    """Attributes of the dataset: those of the file, and where its samples stand."""
    attrs: dict[str, Any] = {"Conventions": "CF-1.8", **volume.attributes(), "bcc4_level": level}
    attrs["bcc4_affine"] = affine_of(volume).reshape(-1)
    return attrs


def make_dataset(file: SharedFile, level: int, drop: Iterable[str] = ()) -> Any:
    """The dataset of a file before the times are decoded."""
    volume, variables, attrs = file.volume, {}, file_attrs(file.volume, level)
    shape = FieldArray.whole(file, 0, level).shape
    space = chunk_samples(shape[1:], brick_samples(volume, level), _CHUNK_VALUES // max(chunk_frames(volume)))
    for channel in range(volume.info().channel_count):
        name = text_of(volume.channel_info(channel).name)
        if name in drop:
            continue
        field = FieldArray.whole(file, channel, level)
        variable = lazy_variable(field, channel_attrs(volume, channel))
        variable.encoding["bcc4"] = file, channel, level
        variable.encoding["preferred_chunks"] = {"time": chunk_frames(volume), "z": space[0], "y": space[1], "x": space[2]}
        variables[name] = variable
    axes = FieldArray.whole(file, 0, level).axes
    coords = {name: space_coordinate(volume, name, axes["tzyx".index(name)]) for name in "zyx"}
    coords["time"] = time_coordinate(volume, volume.times())
    return xarray.Dataset(variables, {name: at for name, at in coords.items() if name not in drop}, attrs)


def decoded(dataset: Any, decode_times: bool = True, use_cftime: bool | None = None) -> Any:
    """The dataset with dates for times, where these can be told."""
    if not decode_times or "since" not in dataset["time"].attrs.get("units", ""):
        return dataset
    try:
        times = xarray.decode_cf(dataset[["time"]], mask_and_scale=False, use_cftime=use_cftime)  # of no channel in days
        return dataset.assign_coords(time=times["time"])
    except (ValueError, OverflowError):  # such as months: the numbers say more than an error
        return dataset


class BccsplatBackend(backends.BackendEntrypoint):  # type: ignore[misc]
    """What xarray.open_dataset(..., engine="bccsplat") calls."""

    description = "Open .bcc4 files (bccsplat)"
    open_dataset_parameters = ("filename_or_obj", "drop_variables", "level", "kernel", "decode_times", "use_cftime",
                               "cache_bytes")

    def open_dataset(self, filename_or_obj: Any, *, drop_variables: Any = None, level: int = 0,
                     kernel: str | None = None, decode_times: bool = True, use_cftime: bool | None = None,
                     cache_bytes: int = 0) -> Any:
        """Dataset with a variable (time, z, y, x), float32, for each channel. level: a coarser one, of every 2**level-th
        sample. kernel: of reconstruction, None for the file's. decode_times: dates where the file knows them. cache_bytes:
        of memory for what was read, in each process; 0: what playing forward needs, which is much for a small worker."""
        drop = [drop_variables] if isinstance(drop_variables, str) else list(drop_variables or ())
        options = {"kernel": kernel, "cache_bytes": cache_bytes}
        file = SharedFile(filename_or_obj, **{key: value for key, value in options.items() if value})
        dataset = decoded(make_dataset(file, level, drop), decode_times, use_cftime)
        dataset.encoding["source"] = file.path
        return dataset

    def guess_can_open(self, filename_or_obj: Any) -> bool:
        """By the name."""
        try:
            return bool(os.fspath(filename_or_obj).endswith((".bcc4", ".bcc4.partial")))
        except TypeError:
            return False


import_module(__package__ + ".accessor")  # dataset.bcc4, which makes variables of this module
