"""Writing datasets of xarray: at once, or of dask arrays as parts of the series, on whatever scheduler is active."""
from __future__ import annotations

import bisect
import os
import shutil
import warnings
from dataclasses import dataclass
from importlib import import_module
from itertools import accumulate
from typing import Any, Mapping, Sequence, Union

import numpy as np

from . import auxiliary, records
from .arrays import Array, numbers_of
from .dimensions import ROLES, role_by_attributes, role_by_name, roles_of
from .errors import refuse_existing
from .files import CODED, bounds_of, save
from .places import even_step, is_along_axes
from .part_task import PartTask, join_task
from .shared import Path, default_device
from .streams import WriteAt
from .writer import Channel, Writer

times_of_cf: Any = import_module("xarray.coding.times")
masks_of_cf: Any = import_module("xarray.coding.variables")

# A part is worth its task, and the frames beside it that it reads along, from so many bytes and frames on.
_PART_BYTES = 1 << 28
_PART_FRAMES = 48
# Attributes of a dataset that its file says otherwise.
_OF_A_FILE = ("Conventions", "time_epoch", "time_calendar")


@dataclass
class SeriesPlan:
    """What a file of a series says of itself, for every process that writes some of it."""

    dims: tuple[int, int, int, int]
    times: list[float]
    channels: list[Channel]
    affine: Array
    axes: list[tuple[Array | None, str | None, bool]] | None
    spatial_unit: str | None
    time_unit: str | None
    attributes: dict[str, str]
    options: dict[str, Any]

    def writer(self, path: Union[Path, WriteAt], **options: Any) -> Writer:
        """A writer of the file, or with part=(first, end) of a part of it."""
        made = Writer(default_device(), path, self.dims, channels=self.channels, affine=self.affine, axes=self.axes,
                      spatial_unit=self.spatial_unit, time_unit=self.time_unit, **self.options, **options)
        for key, value in self.attributes.items():
            made.set_attribute(key, value)
        return made

    def part_frames(self, part: tuple[int, int], lead: int = 0) -> range:
        """The frames that a part is made of, some more than its own, and `lead` before these."""
        return range(*self.writer(lambda offset, data: None, part=part, part_times=self.times, part_lead=lead).part_frames())


class LazySeries:
    """Frames [z, y, x] of a variable at [t], of which one frame or, of a dask array, one chunk of time is in memory."""

    def __init__(self, data: Any, scheduler: str | None = None) -> None:
        self.data, self.scheduler = data, scheduler
        self.shape = tuple(data.shape)
        chunks = getattr(data, "chunks", None)
        self._ends = [*accumulate(chunks[0])] if chunks else None
        self._held: tuple[int, Array] | None = None

    def __getitem__(self, t: int) -> Array:
        if self._ends is None:
            frame: Array = self.data[t]
            return frame
        block = bisect.bisect_right(self._ends, t)
        if self._held is None or self._held[0] != block:
            self._held = None  # before the next one is made
            begin = self._ends[block - 1] if block else 0
            self._held = block, self.data[begin:self._ends[block]].compute(scheduler=self.scheduler)
        frame = self._held[1][t - (self._ends[block - 1] if block else 0)]
        return frame

    def __getstate__(self) -> dict[str, Any]:
        return {**self.__dict__, "_held": None}


class VariableFrames:
    """The data of a variable that is no dask array: indexing reads one frame."""

    def __init__(self, variable: Any) -> None:
        self.variable, self.shape = variable, variable.shape

    def __getitem__(self, t: int) -> Array:
        return np.asarray(self.variable[t].values)


class DatasetWriter:
    """A dataset on its way to a file. dims: names of the dimensions of time, z, y, x, or of z, y, x."""

    def __init__(self, dataset: Any, dims: Sequence[str] | None, options: Mapping[str, Any]) -> None:
        if not dataset.data_vars:
            raise ValueError("the dataset has no variable to write")
        first = max(dataset.data_vars.values(), key=lambda variable: int(variable.ndim))
        if len(dims or first.dims) not in (3, 4):
            raise ValueError("a variable has the dimensions %s: time, z, y and x, or z, y and x are wanted; select others, "
                             "and give dims=" % ", ".join(map(str, first.dims)))
        self.fields = {name: variable for name, variable in dataset.data_vars.items()
                       if {*variable.dims} == {*(dims or first.dims)}}
        self._beside = {name: variable for name, variable in dataset.variables.items()
                        if name not in self.fields and name not in dataset.dims and not self._is_place(dataset, name)}
        if large := [name for name, variable in self._beside.items() if not auxiliary.is_small(variable)]:
            raise ValueError("%s: only small variables of one dimension are kept beside those along %s: leave them out, such as by "
                             "dataset.drop_vars(%r), or broadcast them" %
                             (", ".join("%s has the dimensions %s" % (name, ", ".join(map(str, dataset[name].dims)))
                                        for name in large), ", ".join(map(str, dims or first.dims)), large))
        self.dataset = dataset
        self.names = dict(zip(ROLES[-len(dims):], dims)) if dims else roles_of(dataset, first.dims)
        self.options: dict[str, Any] = {"nonfinite": "hole", **options}
        if isinstance(bounds := self.options.get("abs_error"), Mapping):
            self.options["abs_error"] = bounds_of(bounds, [str(name) for name in self.fields])
        self.series = [self._series(variable.variable) for variable in self.fields.values()]
        self.plan = self._plan()

    @staticmethod
    def _is_place(dataset: Any, name: Any) -> bool:
        """Whether it is the moment, level or row of a dimension that is not there any more."""
        at = dataset[name]
        return name in dataset.coords and at.ndim == 0 and (role_by_attributes(at) or role_by_name(name)) is not None

    def write(self, path: Path, *, psnr: float | None, parts: int | None, resume: bool, overwrite: bool) -> None:
        """Writes the file: as a whole, or of dask arrays by parts, unless psnr asks for a plan of the whole."""
        refuse_existing(path, overwrite)
        count = self._part_count() if parts is None else self._checked_parts(parts)
        if psnr is None and count > 1:
            if not self.options.get("abs_error") and not CODED & {*self.options}:
                warnings.warn("%s is written by parts, which have no bound of the error: give abs_error=, or lattice= where that "
                              "is meant" % os.fspath(path), stacklevel=3)
            self._write_parts(os.path.abspath(os.fspath(path)), count, resume, overwrite)
        else:
            self._write_whole(path, psnr, overwrite)

    def _checked_parts(self, parts: int) -> int:
        """The number of parts that was asked for, if the series has that many."""
        if not isinstance(parts, int) or not 1 <= parts <= self.plan.dims[3]:
            raise ValueError("parts must be 1 to %d, the number of frames, not %r" % (self.plan.dims[3], parts))
        return parts

    def _series(self, variable: Any) -> LazySeries:
        names = [self.names.get(role, (role,)) for role in ROLES]  # of one that is not there what is no name
        there = variable.transpose(*(name for name in names if name in variable.dims))
        for coder in masks_of_cf.UnsignedIntegerCoder, masks_of_cf.CFMaskCoder, masks_of_cf.CFScaleOffsetCoder:
            there = coder().decode(there)
        there = there.set_dims(tuple(names))
        return LazySeries(there.data if hasattr(there.data, "dask") else VariableFrames(there))

    def _coordinate(self, role: str) -> Any:
        """The coordinate of time, z, y or x, also of a dimension that is not there any more; None: there is none."""
        name = self.names.get(role)
        if name is None:  # of one moment, level or row
            scalars = [key for key, at in self.dataset.coords.items() if at.ndim == 0]
            name = next((key for key in scalars if (role_by_attributes(self.dataset[key]) or role_by_name(key)) == role), None)
        return self.dataset[name] if name in self.dataset.coords else None

    def _plan(self) -> SeriesPlan:
        nt, nz, ny, nx = self.series[0].shape
        attributes = {key: value for key, value in self._own_attributes().items() if isinstance(value, str)}
        times, time_unit, dates = self._times(nt)
        units, (affine, axes) = {*self._units()}, self._places((nx, ny, nz))
        if self._is_oblique():
            units = {self.dataset.attrs.get("bcc4_spatial_unit")}
        channels = [Channel(str(name), variable.attrs.get("units")) for name, variable in self.fields.items()]
        return SeriesPlan((nx, ny, nz, nt), times, channels, affine, axes, units.pop() if len(units) == 1 else None, time_unit,
                          {**attributes, **dates, **self._records()}, self.options)

    def _records(self) -> dict[str, str]:
        """What is kept of the dimensions and variables: names, and attributes but for what the file says itself."""
        made = {}
        for role in ROLES:
            at = self._coordinate(role)
            name, attrs = (self.names.get(role), {}) if at is None else (at.name, records.kept(at.attrs, role == "t"))
            if role != "t" and self._is_oblique():  # numbers of samples, which no file has to say
                attrs = {}
            if at is not None and role == "t" and at.dtype.kind == "m":
                attrs["dtype"] = "timedelta64[ns]"  # as xarray says it of files of netCDF
            if name is not None and (role == "t" or not self._is_oblique()):
                made["axis." + role] = records.written({**attrs, "name": str(name)})
        for name, variable in self.fields.items():
            made["channel.%s" % name] = records.written(records.kept(variable.attrs))
        for name in self._beside:
            made[auxiliary.PREFIX + str(name)] = auxiliary.record_of(self.dataset[name], name in self.dataset.coords)
        if others := {key: value for key, value in self._own_attributes().items() if not isinstance(value, str)}:
            made[records.DATASET] = records.written(records.kept(others))
        return made

    def _own_attributes(self) -> dict[str, Any]:
        """Those of the dataset that a file does not say otherwise."""
        return {str(key): value for key, value in self.dataset.attrs.items()
                if not str(key).startswith(("bcc4_", "labels.")) and key not in _OF_A_FILE}

    def _times(self, count: int) -> tuple[list[float], str | None, dict[str, str]]:
        """Times of frames, their unit, and what says which date 0 is."""
        coordinate = self._coordinate("t")
        if coordinate is None:
            return [float(n) for n in range(count)], None, {}
        values, units = np.atleast_1d(coordinate.values), coordinate.attrs.get("units")
        if values.dtype.kind == "m":
            return (values / np.timedelta64(1, "s")).tolist(), "s", {}
        calendar = coordinate.attrs.get("calendar", "standard")
        if values.dtype.kind in "MO":
            units = coordinate.encoding.get("units") or "seconds since %s" % str(values[0])[:19].replace("T", " ")
            values, units, calendar = times_of_cf.encode_cf_datetime(values, units, coordinate.encoding.get("calendar"))
        unit, since, epoch = str(units or "").partition(" since ")
        dates = {"time_epoch": epoch, "time_calendar": str(calendar)} if since else {}
        return [float(time) for time in values], unit or None, dates

    def _places(self, sizes: tuple[int, ...]) -> tuple[Array, list[tuple[Array | None, str | None, bool]] | None]:
        """From samples to the world, and the axes where one of them is uneven: by the coordinates, and where these count
        samples by the affine of their file."""
        outer, local, oblique = self._affine_of_file(), np.eye(4), self._is_oblique()
        axes: list[tuple[Array | None, str | None, bool]] = []
        for axis, (role, unit) in enumerate(zip("xyz", self._units())):
            coordinate, known = self._coordinate(role), None
            down = coordinate is not None and coordinate.attrs.get("positive") == "down"
            sign = -1.0 if down else 1.0
            if coordinate is not None:
                at = np.atleast_1d(numbers_of(coordinate.values, "the coordinate %s" % coordinate.name))
                step = spacing_of(str(coordinate.name), at)
                known = at if len(at) > 1 and even_step(at) is None else None
                local[axis, axis], local[axis, 3] = sign * step, sign * at[0] + 0.0  # not -0
            if sizes[axis] == 1 and not oblique:
                local[axis, axis] = outer[axis, axis]
            axes.append((known, unit, down))
        uneven = any(known is not None for known, _, _ in axes)
        if uneven and oblique:
            raise ValueError("the samples lie oblique in the world and are unevenly spaced as well, which no file can say: "
                             "select evenly spaced ones, or drop the attribute bcc4_affine")
        return outer @ local if oblique else local, axes if uneven else None

    def _affine_of_file(self) -> Array:
        return np.reshape(self.dataset.attrs.get("bcc4_affine", np.eye(4)), (4, 4)).astype(np.float64)

    def _is_oblique(self) -> bool:
        """Whether the samples of its file lie oblique in the world, so that coordinates count them."""
        return not is_along_axes(self._affine_of_file())

    def _units(self) -> list[str | None]:
        """Units of x, y and z; of degrees to the north and to the east one."""
        found = [None if at is None else at.attrs.get("units") for at in map(self._coordinate, "xyz")]
        return [None if unit is None else "degrees" if str(unit).lower().startswith("degree") else str(unit) for unit in found]

    def _part_count(self) -> int:
        if not all(series._ends for series in self.series):
            return 1
        frames = self.plan.dims[3]
        size = sum(series.data.nbytes for series in self.series)
        return max(1, min(frames // _PART_FRAMES, int(np.ceil(size / _PART_BYTES))))

    def _write_whole(self, path: Path, psnr: float | None, overwrite: bool) -> None:
        plan, options = self.plan, dict(self.options)
        channels = {channel.name: series for channel, series in zip(plan.channels, self.series)}
        save(path, channels, times=plan.times, affine=plan.affine, axes=plan.axes, psnr=psnr,
             unit={channel.name: channel.unit for channel in plan.channels}, attributes=plan.attributes,
             spatial_unit=plan.spatial_unit, time_unit=plan.time_unit, nonfinite=options.pop("nonfinite"),
             overwrite=overwrite, **options)

    def _write_parts(self, path: str, count: int, resume: bool, overwrite: bool) -> None:
        dask = import_module("dask")
        if not os.path.isdir(os.path.dirname(path)):
            raise FileNotFoundError("%s: there is no folder of that name to write into" % os.path.dirname(path))
        frames = self.plan.dims[3]
        bounds = [round(frames * n / count) for n in range(count + 1)]
        token = dask.base.tokenize(path, [getattr(series.data, "name", None) for series in self.series],
                                   [vars(channel) for channel in self.plan.channels],
                                   {**vars(self.plan), "channels": None}, bounds)
        folder = "%s.parts-%s" % (path, token[:12])
        if not resume:
            shutil.rmtree(folder, ignore_errors=True)
        os.makedirs(folder, exist_ok=True)
        tasks = [PartTask(self.plan, self.series, os.path.join(folder, "part%05d.bcc4" % n), (first, end))
                 for n, (first, end) in enumerate(zip(bounds, bounds[1:]))]
        names = [dask.delayed(task.run)(task.take_dependencies(), dask_key_name="bcc4-part%05d-%s" % (n, token))
                 for n, task in enumerate(tasks)]
        dask.compute(dask.delayed(join_task)(names, path, overwrite, dask_key_name="bcc4-join-" + token))
        shutil.rmtree(folder)


def spacing_of(name: str, at: Array) -> float:
    """The mean distance of coordinates [n], which may fall; ValueError of those that do not rise or fall throughout."""
    if len(at) == 1:
        return 1.0
    rises = np.diff(at) > 0
    if not (np.isfinite(at).all() and (rises.all() or (np.diff(at) < 0).all())):
        raise ValueError("the coordinate %s neither rises nor falls throughout, from %g to %g: sort the dataset by it, such "
                         "as dataset.sortby(%r), or drop it" % (name, at[0], at[-1], name))
    return float(at[-1] - at[0]) / (len(at) - 1)
