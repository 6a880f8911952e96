"""Writing datasets of xarray: at once, or of dask arrays as parts of the series, on whatever scheduler is active."""
from __future__ import annotations

import bisect
import os
import shutil
from dataclasses import dataclass
from importlib import import_module
from itertools import accumulate
from typing import Any, Mapping, Sequence, Union

import numpy as np

from .arrays import Array, numbers_of
from .files import add_frames, save
from .part_task import PartTask, join_task
from .shared import Path, default_device
from .streams import WriteAt
from .writer import Channel, Writer

times_of_cf: Any = import_module("xarray.coding.times")
masks_of_cf: Any = import_module("xarray.coding.variables")

# A part is worth its task, and the frames beside it that it reads along, from so many bytes and frames on.
_PART_BYTES = 1 << 28
_PART_FRAMES = 48
# Share of a distance of samples by which distances may differ.
_EVEN = 1e-3


@dataclass
class SeriesPlan:
    """What a file of a series says of itself, for every process that writes some of it."""

    dims: tuple[int, int, int, int]
    times: list[float]
    channels: list[Channel]
    affine: Array
    spatial_unit: str | None
    time_unit: str | None
    attributes: dict[str, str]
    options: dict[str, Any]

    def writer(self, path: Union[Path, WriteAt], **options: Any) -> Writer:
        """A writer of the file, or with part=(first, end) of a part of it."""
        made = Writer(default_device(), path, self.dims, channels=self.channels, affine=self.affine,
                      spatial_unit=self.spatial_unit, time_unit=self.time_unit, **self.options, **options)
        for key, value in self.attributes.items():
            made.set_attribute(key, value)
        return made

    def part_frames(self, part: tuple[int, int]) -> range:
        """The frames that a part is made of, some more than its own."""
        return range(*self.writer(lambda offset, data: None, part=part, part_times=self.times).part_frames())


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
        first = next(iter(dataset.data_vars.values()))
        self.dataset, self.names = dataset, tuple(dims or first.dims)
        if len(self.names) not in (3, 4):
            raise ValueError("a variable has the dimensions %s: time, z, y and x, or z, y and x are wanted; select others, "
                             "and give dims=" % ", ".join(map(str, first.dims)))
        for name, variable in dataset.data_vars.items():
            if set(variable.dims) != set(self.names):
                raise ValueError("%s has the dimensions %s, not %s: leave it out, or broadcast it" %
                                 (name, ", ".join(map(str, variable.dims)), ", ".join(map(str, self.names))))
        self.options: dict[str, Any] = {"nonfinite": "hole", **options}
        self.series = [self._series(variable.variable) for variable in dataset.data_vars.values()]
        self.plan = self._plan()

    def write(self, path: Path, *, psnr: float | None, parts: int | None, resume: bool, overwrite: bool) -> None:
        """Writes the file. Of dask arrays by parts, unless psnr asks for a plan of the whole."""
        if not overwrite and os.path.exists(path):
            raise FileExistsError("%s is there already: give another name, or overwrite=True" % os.fspath(path))
        if psnr is not None:
            self._write_bounded(path, psnr, overwrite)
            return
        count = self._part_count() if parts is None else self._checked_parts(parts)
        if count > 1:
            self._write_parts(os.path.abspath(os.fspath(path)), count, resume)
            return
        with self.plan.writer(path, overwrite=overwrite) as writer:
            add_frames(writer, self.series, self.plan.times, range(self.plan.dims[3]))

    def _checked_parts(self, parts: int) -> int:
        """The number of parts that was asked for, if the series has that many."""
        if not isinstance(parts, int) or not 1 <= parts <= self.plan.dims[3]:
            raise ValueError("parts must be 1 to %d, the number of frames, not %r" % (self.plan.dims[3], parts))
        return parts

    def _series(self, variable: Any) -> LazySeries:
        there = masks_of_cf.CFMaskCoder().decode(variable.transpose(*self.names))
        if len(self.names) == 3:
            there = there.set_dims(("time", *self.names))
        return LazySeries(there.data if hasattr(there.data, "dask") else VariableFrames(there))

    def _plan(self) -> SeriesPlan:
        nt, nz, ny, nx = self.series[0].shape
        attributes = {str(key): str(value) for key, value in self.dataset.attrs.items()
                      if not str(key).startswith(("bcc4_", "labels.")) and key not in ("Conventions", "time_epoch", "time_calendar")}
        times, time_unit, dates = self._times(nt)
        channels = [Channel(str(name), variable.attrs.get("units")) for name, variable in self.dataset.data_vars.items()]
        return SeriesPlan((nx, ny, nz, nt), times, channels, self._affine(), self._spatial_unit(), time_unit,
                          {**attributes, **dates}, self.options)

    def _times(self, count: int) -> tuple[list[float], str | None, dict[str, str]]:
        """Times of frames, their unit, and what says which date 0 is."""
        name = self.names[0] if len(self.names) == 4 else "time"  # of one moment a scalar
        if name not in self.dataset.coords or self.dataset[name].size != count:
            return [float(n) for n in range(count)], None, {}
        coordinate = self.dataset[name]
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

    def _affine(self) -> Array:
        """From samples to the world: by the coordinates, and where these count samples by the affine of their file."""
        local, names = np.eye(4), self.names[-3:]
        for axis, name in enumerate(reversed(names)):
            if name in self.dataset.coords:
                local[axis, axis], local[axis, 3] = even_spacing(str(name), self.dataset[name].values)
        outer = self.dataset.attrs.get("bcc4_affine")
        if outer is None:
            return local
        turned = np.asarray(outer, np.float64).reshape(4, 4)
        if np.count_nonzero(turned[:3, :3]) != 3 or not np.diag(turned)[:3].all():
            return np.asarray(turned @ local)
        for axis, name in enumerate(reversed(names)):
            if self.dataset.sizes[name] == 1:
                local[axis, axis] = turned[axis, axis]
        return local

    def _spatial_unit(self) -> str | None:
        units = {self.dataset[name].attrs.get("units") for name in self.names[-3:] if name in self.dataset.coords}
        return str(units.pop()) if len(units) == 1 and None not in units else None

    def _part_count(self) -> int:
        if not all(series._ends for series in self.series):
            return 1
        frames = self.plan.dims[3]
        size = sum(series.data.nbytes for series in self.series)
        return max(1, min(frames // _PART_FRAMES, int(np.ceil(size / _PART_BYTES))))

    def _write_bounded(self, path: Path, psnr: float, overwrite: bool) -> None:
        plan, options = self.plan, dict(self.options)
        channels = {channel.name: series for channel, series in zip(plan.channels, self.series)}
        save(path, channels, times=plan.times, affine=plan.affine, unit=plan.channels[0].unit, psnr=psnr,
             attributes=plan.attributes,
             spatial_unit=plan.spatial_unit, time_unit=plan.time_unit, nonfinite=options.pop("nonfinite"),
             overwrite=overwrite, **options)

    def _write_parts(self, path: str, count: int, resume: bool) -> None:
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
        dask.compute(dask.delayed(join_task)(names, path, dask_key_name="bcc4-join-" + token))
        shutil.rmtree(folder)


def even_spacing(name: str, values: Any) -> tuple[float, float]:
    """The distance and the first of evenly spaced coordinates, which may fall; ValueError of others."""
    at = numbers_of(values, "the coordinate " + name)
    if len(at) == 1:
        return 1.0, float(at[0])
    step = float(at[-1] - at[0]) / (len(at) - 1)
    if not step or np.abs(np.diff(at) - step).max() > _EVEN * abs(step):
        raise ValueError("the coordinate %s is not evenly spaced, from %g to %g: interpolate the dataset onto one that is "
                         "first, such as dataset.interp(%s=numpy.linspace(%r, %r, %d))" %
                         (name, at[0], at[-1], name, float(at[0]), float(at[-1]), len(at)))
    return step, float(at[0])
