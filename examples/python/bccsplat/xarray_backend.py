"""The engine "bccsplat" of xarray: .bcc4 files as datasets (time, z, y, x) that are read where they are indexed. Dimensions
have the names of the source where the file keeps them, as to_file writes it.

    ds = xarray.open_dataset("smoke.bcc4", engine="bccsplat", chunks={})   # dask chunks along the file's slabs
    ds = xarray.open_dataset("smoke.bcc4", engine="bccsplat", level=1)     # a coarser level

Of dask arrays each chunk is read where it is computed, by any thread or process. dataset.bcc4 is in bccsplat.accessor.
"""
from __future__ import annotations

import os
from importlib import import_module
from typing import Any, Iterable, Mapping, Sequence

import numpy as np

from . import auxiliary, records
from .arrays import Array
from .dimensions import ROLES, role_by_attributes, role_by_name
from .field_array import FieldArray, brick_samples, chunk_frames, chunk_samples, dropped
from .places import Places
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

# Of a file that keeps no names of its source.
DIMENSIONS = ("time", "z", "y", "x")


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


def lazy_variable(field: FieldArray, names: dict[str, str], attrs: dict[str, Any],
                  kept: Sequence[bool] = (True,) * 4) -> Any:
    """A variable of xarray of which nothing is read yet."""
    data = indexing.LazilyIndexedArray(LazyField(field, kept))
    dims = tuple(name for name, there in zip(names.values(), kept) if there)
    return xarray.Variable(dims, data, attrs, {"dtype": field.dtype, "_FillValue": np.float32(np.nan)})


def names_of(volume: Volume) -> dict[str, str]:
    """The dimensions by t, z, y and x: the names that the file keeps of its source, else those of DIMENSIONS."""
    attributes = volume.attributes()
    names = {role: str(records.read(attributes, "axis." + role).get("name") or usual)
             for role, usual in zip(ROLES, DIMENSIONS)}
    taken = {volume.channel_info(channel).name for channel in range(volume.info().channel_count)}
    return names if len({*names.values()} - taken) == len(ROLES) else dict(zip(ROLES, DIMENSIONS))


def coordinate(names: dict[str, str], role: str, record: dict[str, Any], attrs: dict[str, Any], values: Array) -> Any:
    """The coordinate of a dimension, with the attributes that the file keeps of it, or without any with usual ones, and
    what says that it is time, z, y or x."""
    kept = {key: value for key, value in records.arrays_of(record).items() if key not in ("name", "dtype")}
    made = xarray.Variable((names[role],), values, {**(kept if record else {"long_name": names[role]}), **attrs})
    if not record or (role_by_attributes(made) or role_by_name(names[role])) != role:
        made.attrs["axis"] = role.upper()
    return made


def space_coordinate(places: Places, names: dict[str, str], role: str, positions: Array) -> Any:
    """The coordinate of z, y or x: places, or along axes that lie oblique in the world sample numbers."""
    axis = "xyz".index(role)
    record, attrs = places.records[axis], {}
    if places.are_numbers(axis):
        record, attrs = {}, {"long_name": "sample along " + names[role], "units": "1"}
    elif unit := places.unit(axis):
        attrs["units"] = unit
    if places.is_down(axis):
        attrs["positive"] = "down"
    return coordinate(names, role, record, attrs, places.at(axis, positions))


def time_coordinate(volume: Volume, times: Array) -> Any:
    """The coordinate of time in the file's unit; with the date of its 0 where the file knows that, as CF has it."""
    attributes, attrs = volume.attributes(), {}
    unit, record = volume.info().time_unit, records.read(attributes, "axis.t")
    if epoch := attributes.get("time_epoch", ""):
        attrs["units"] = "%s since %s" % (unit, epoch)
        calendar = attributes.get("time_calendar", "standard")
        attrs["calendar"] = _CALENDARS.get(calendar, calendar)
    elif unit:
        attrs["units"] = unit
    if not record:
        attrs["standard_name"] = "time"
    return coordinate(names_of(volume), "t", record, attrs, times)


def channel_attrs(volume: Volume, channel: int) -> dict[str, Any]:
    """CF attributes of a channel: those that the file keeps of its source, and what it says of the values itself."""
    info = volume.channel_info(channel)
    attributes, key = volume.attributes(), "channel." + info.name
    attrs: dict[str, Any] = records.arrays_of(records.read(attributes, key)) if records.is_there(attributes, key) else \
        {"long_name": info.name}
    attrs["actual_range"] = np.array(info.range[:])
    if unit := info.unit:
        attrs["units"] = unit
    if info.error_bound:
        attrs["bcc4_error_bound"] = info.error_bound
    return attrs


def file_attrs(volume: Volume, level: int) -> dict[str, Any]:
    """Attributes of the dataset: those of the file, and where its samples stand."""
    attributes = volume.attributes()
    kept: dict[str, Any] = {key: value for key, value in attributes.items()
                            if not records.is_record(key) and key not in ("time_epoch", "time_calendar")}
    kept.update(records.arrays_of(records.read(attributes, records.DATASET)))
    info = volume.info()
    unit = {"bcc4_spatial_unit": info.spatial_unit} if info.spatial_unit else {}
    return {"Conventions": "CF-1.8", **kept, "bcc4_level": level, "bcc4_affine": np.array(info.affine[:]), **unit}


def make_dataset(file: SharedFile, level: int, drop: Iterable[str] = (), decode_times: bool = False) -> Any:
    """The dataset of a file before the times of its coordinate are decoded. decode_times: of small variables beside it."""
    volume, variables, attrs = file.volume, {}, file_attrs(file.volume, level)
    names, places = names_of(volume), Places(volume)
    shape = FieldArray.whole(file, 0, level).shape
    frames = chunk_frames(volume, level)
    space = chunk_samples(shape[1:], brick_samples(volume, level), _CHUNK_VALUES // max(frames))
    for channel in range(volume.info().channel_count):
        name = volume.channel_info(channel).name
        if name in drop:
            continue
        field = FieldArray.whole(file, channel, level)
        variable = lazy_variable(field, names, channel_attrs(volume, channel))
        variable.encoding["bcc4"] = file, channel, level
        variable.encoding["preferred_chunks"] = dict(zip(names.values(), (frames, *space)))
        variables[name] = variable
    axes = FieldArray.whole(file, 0, level).axes
    coords = {names[role]: space_coordinate(places, names, role, at) for role, at in zip("zyx", axes[1:])}
    coords[names["t"]] = time_coordinate(volume, volume.times())
    for name in auxiliary.names(attributes := volume.attributes()):
        made, is_coordinate = auxiliary.read(attributes, name, decode_times)
        if level and not {*made.dims} <= {names["t"]}:
            continue  # along samples of level 0
        (coords if is_coordinate else variables)[name] = made
    shown = [{name: at for name, at in group.items() if name not in drop} for group in (variables, coords)]
    return xarray.Dataset(*shown, attrs)


def decoded(dataset: Any, time: str, attributes: Mapping[str, str], use_cftime: bool | None = None) -> Any:
    """The dataset with dates for times, the name of whose dimension is given, where these can be told."""
    if records.read(attributes, "axis.t").get("dtype", "").startswith("timedelta64"):
        at = dataset[time]
        lengths = np.rint(at.values * 1e9).astype("m8[ns]")
        return dataset.assign_coords({time: (time, lengths, {key: value for key, value in at.attrs.items() if key != "units"})})
    if "since" not in dataset[time].attrs.get("units", ""):
        return dataset
    try:
        times = xarray.decode_cf(dataset[[time]], mask_and_scale=False, use_cftime=use_cftime)  # of no channel in days
        return dataset.assign_coords({time: times[time]})
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
        file = SharedFile(filename_or_obj, kernel=kernel, cache_bytes=cache_bytes)
        dataset, time = make_dataset(file, level, drop, decode_times), names_of(file.volume)["t"]
        if decode_times and time not in drop:
            dataset = decoded(dataset, time, file.volume.attributes(), use_cftime)
        dataset.encoding["source"] = file.path
        return dataset

    def guess_can_open(self, filename_or_obj: Any) -> bool:
        """By the name."""
        try:
            return bool(os.fspath(filename_or_obj).endswith((".bcc4", ".bcc4.partial")))
        except TypeError:
            return False


import_module(__package__ + ".accessor")  # dataset.bcc4, which makes variables of this module
