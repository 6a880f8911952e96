"""dataset.bcc4: what xarray does not know of a field that is continuous in space and time, and writing datasets.

Any dataset has it once `bccsplat.accessor` is imported, which opening one with the engine "bccsplat" does.
"""
from __future__ import annotations

from importlib import import_module
from typing import Any, Mapping, Sequence

import numpy as np

from . import _abi, held, records
from ._library import Progress
from . import xarray_backend as engine
from .arrays import Array
from .cancel import CancelToken
from .dataset_writer import DatasetWriter
from .errors import Error
from .field_array import FieldArray, evaluate_or_nan
from .keywords import given
from .places import Places
from .shared import Path, SharedFile
from .volume import Volume

xarray: Any = import_module("xarray")
times_of_cf: Any = import_module("xarray.coding.times")
_WORDS_OF_CF = {"d": "days", "h": "hours", "min": "minutes", "s": "seconds", "ms": "milliseconds", "us": "microseconds"}

# By how much values may differ that are the same: a share of the spread of their row, and of the largest of the channel.
_SAME, _ROUNDING = 1e-4, 1e-6
# Samples of a row that tell whether values are the file's: few enough to be evaluated as points, which read what lies around.
_ROW = 32
# Values that are compared at a time of what is in memory: 64 MiB of the file's.
_BLOCK = 1 << 24
# Samples by which a coordinate is another place, whatever its type rounds to.
_MOVED = .01


def dates_of_texts(values: Array) -> Array:
    """Texts such as "2020-01-01T09:00" as dates; other arrays as they are."""
    texts = values.dtype.kind == "U" or (values.dtype.kind == "O" and values.size and isinstance(values.flat[0], str))
    return values.astype("datetime64[ns]") if texts else values


def numbers_of_times(values: Any, volume: Volume) -> Array:
    """Times in the file's unit, float64, of numbers or, where the file knows the date of its 0, of dates."""
    array = dates_of_texts(np.asarray(values))
    if array.dtype.kind == "m" and records.read(volume.attributes(), "axis.t").get("dtype"):
        return np.asarray(array / np.timedelta64(1, "s"), np.float64)
    if array.dtype.kind == "m":
        raise ValueError("times are numbers in the unit of the file, or dates, not durations such as %r" % (array.flat[0],))
    if array.dtype.kind not in "MO":
        return array.astype(np.float64)
    attrs = engine.time_coordinate(volume, np.zeros(1)).attrs
    if "since" not in attrs.get("units", ""):
        raise ValueError("the file does not know the date of its time 0: give times as numbers%s" %
                         (" of " + attrs["units"] if "units" in attrs else ""))
    unit, _, epoch = attrs["units"].partition(" since ")
    units = "%s since %s" % (_WORDS_OF_CF.get(unit, unit), epoch)
    coded, _, _ = times_of_cf.encode_cf_datetime(array, units, attrs["calendar"])
    return np.asarray(coded, np.float64)


def frames_of_times(values: Any, volume: Volume) -> Array:
    """Frame numbers, float64, of times as of numbers_of_times; Error outside the series."""
    numbers = numbers_of_times(values, volume)
    found = [volume.time_to_index(float(number)) for number in numbers.reshape(-1)]
    return np.array(found, np.float64).reshape(numbers.shape)


def differing(held: Array, right: Array, largest: float) -> Array:
    """Where values are not the right ones but for rounding, also to whole numbers or short floats; NaN are the same."""
    found, known = held.astype(np.float64), right[np.isfinite(right)]
    spread = float(np.ptp(known)) if known.size else 0.0
    kind = np.finfo(held.dtype) if held.dtype.kind == "f" else None
    rounding = kind.eps * (np.abs(right) + kind.tiny) if kind else 1.0
    near = np.abs(found - right) <= _SAME * spread + _ROUNDING * largest + rounding
    differ: Array = ~(near | (np.isnan(found) & np.isnan(right)))
    return differ


@xarray.register_dataset_accessor("bcc4")
class Bcc4Accessor:
    """dataset.bcc4 of datasets that the engine "bccsplat" opened, and of parts of these: the field between the samples.
    to_file is there for every dataset."""

    def __init__(self, dataset: Any) -> None:
        self._dataset, self._checked = dataset, False

    @property
    def file(self) -> SharedFile:
        """The file behind the dataset."""
        return self._first_origin()[0]

    @property
    def volume(self) -> Volume:
        """The open volume, for pictures and everything else: ds.bcc4.volume.show(0.5)."""
        return self.file.volume

    @property
    def level(self) -> int:
        """The level of the file that the dataset was opened at."""
        return self._first_origin()[2]

    def at(self, t: Any) -> Any:
        """The dataset at a moment, on a frame or between two, or at a list of moments: in the file's unit of time, or
        dates where the file knows them. Nothing is read before it is indexed, but as of interp."""
        return self.interp(**{self._names["t"]: t})

    def interp(self, **places: Any) -> Any:
        """The field at other coordinates, through the lattice: time=, z=, y= and x=, or what the file calls these, as of
        the dataset's own coordinates.

        A number drops its axis; a list or array [n] replaces it, and nothing is read before the result is indexed.
        DataArrays that share a dimension are points (or a path), which are evaluated at once. What is not given stays as
        it is. Outside the samples of space, and in holes, NaN; times outside the series raise Error.

        The first call tells whether the dataset is still that of the file: ValueError where its dimensions, values or
        coordinates were changed. Of what is read from the file when it is indexed the arrays tell; what was loaded is compared
        with the file, all of it, which takes as long as loading it did; of what is of dask parts of two rows are, which miss
        what was changed elsewhere.
        """
        names = self._names.values()
        if unknown := set(places) - {*names}:
            raise ValueError("the volume has the coordinates %s, not %s" % (", ".join(names), ", ".join(sorted(unknown))))
        self._channels()
        if not self._checked:
            self._check_dimensions()
            if not self._holds_what_it_says():
                self._check_values()
            self._checked = True
        return self._interpolated(places)

    def to_file(self, path: Path, *, dims: Sequence[str] | None = None, psnr: float | None = None,
                parts: int | None = None, resume: bool = False, overwrite: bool = False,
                abs_error: float | Mapping[str, float] | None = None, nonfinite: str | None = None, air: float | None = None,
                air_threshold: float | None = None, labels: bool | None = None, progress: Progress | None = None,
                cancel: CancelToken | None = None, lattice: int | str | None = None,
                scale: float | Sequence[float] | None = None, time_scale: float | None = None,
                store: int | str | None = None, kernel: str | None = None,
                ends: int | str | None = None, faces: int | str | None = None, levels: int | None = None,
                density: float | None = None, exact: bool | None = None, lowpass: int | None = None,
                measure: int | str | None = None, live: int | None = None, partial: int | None = None,
                periodic_axes: int | None = None, fixed_predictions: int | None = None) -> None:
        """Writes every variable of the dataset as a channel of a .bcc4 file. What is kept, and what is promised without
        options, is as of bccsplat.save; but not of dask arrays that are written by parts: there is no plan of these, which would
        have to compute the arrays once more, and without abs_error a lattice of half the samples keeps what it can, without a bound.

        dims: names of the dimensions of time, z, y and x (or of z, y and x), the slowest first; None: by the attributes and
        names of the coordinates, as CF has them, and by their order where these do not tell. (time, lat, lon) is one plane.
        Coordinates become places and times, evenly spaced or not; names and attributes are kept. psnr: as of bccsplat.save.
        parts: of dask arrays, the number of tasks that write a part of the series each, on whatever scheduler is active; a
        task holds a chunk of time of its part, and one that dies costs its part only. None: as many as are large enough.
        resume: take over the parts that a run before this one finished, with the same arrays and options; they lie beside
        `path` until the file is whole. nonfinite: None, "hole": NaN is missing data. The others are as of bccsplat.save; a Writer
        of parts has no air, air_threshold, labels, density and exact.
        """
        options = given(abs_error=abs_error, nonfinite=nonfinite, air=air, air_threshold=air_threshold, labels=labels,
                        progress=progress, cancel=cancel, lattice=lattice, scale=scale, time_scale=time_scale, store=store,
                        kernel=kernel, ends=ends, faces=faces, levels=levels, density=density, exact=exact,
                        lowpass=lowpass, measure=measure, live=live, partial=partial, periodic_axes=periodic_axes,
                        fixed_predictions=fixed_predictions)
        DatasetWriter(self._dataset, dims, options).write(path, psnr=psnr, parts=parts, resume=resume,
                                                          overwrite=overwrite)

    def _check_dimensions(self) -> None:
        """ValueError where a variable lies along other dimensions than the coordinates, or those of the file in another
        order."""
        names, coords, sizes = [*self._names.values()], self._dataset.coords, self._dataset.sizes
        right = [dim for name in names
                 for dim in (coords[name].dims if name in coords else (name,) if name in sizes else ())]
        for name, variable in self._fields().items():
            known = [dim for dim in variable.dims if dim in names]
            if {*variable.dims} != {*right} or known != sorted(known, key=names.index):
                raise ValueError("%s lies along %s, not along the file's %s or some of these in this order: interpolate "
                                 "before you change dimensions" %
                                 (name, ", ".join(map(str, variable.dims)), ", ".join(names)))

    def _holds_what_it_says(self) -> bool:
        """Whether all variables are read from the file, at the places of their coordinates; nothing is read to tell it."""
        for name, channel, level in self._channels():
            found = held.field_of(self._dataset[name].variable)
            if found is None or (found[0].channel, found[0].level) != (channel, level) or found[0].source is not self.file:
                return False
            for at, coordinate in zip(found[1], self._names.values()):
                if coordinate not in self._dataset.coords:
                    if coordinate not in self._dataset.sizes or len(at) == self._dataset.sizes[coordinate]:
                        continue
                    return False
                try:
                    said = self._positions(coordinate, np.atleast_1d(self._dataset[coordinate].values))
                except Error:  # times outside the series
                    return False
                if said.shape == at.shape and (np.abs(said - at) > _MOVED).any():
                    raise self._refusal([name])
                if said.shape != at.shape or not (np.abs(said - at) <= 1e-6 * (1 + np.abs(at))).all():
                    return False
        return True

    def _check_values(self) -> None:
        """ValueError where values are not what the file has at their coordinates: all that are in memory, a block of frames after
        the other, and of others a part of a row through the middle, at two moments. A whole axis without coordinates has the
        file's; where samples of a part of one are cannot be told, and nothing is read."""
        time, sizes = self._names["t"], self._dataset.sizes
        own = engine.make_dataset(self.file, self.level).coords
        lost = {name: own[name] for name in self._names.values() if name not in self._dataset.coords}
        if any(at.size != sizes.get(name, 1) for name, at in lost.items()):
            return
        whole = self._dataset.assign_coords({name: at if name in sizes else at[0] for name, at in lost.items()})
        loaded = [name for name, variable in self._fields().items() if held.is_loaded(variable.variable)]
        others = [name for name in self._fields() if name not in loaded]
        parts = [whole[others].isel(self._rows())] if others else []
        frames = sizes.get(time, 1)
        step = max(1, _BLOCK * frames // max(1, *(self._dataset[name].size for name in loaded))) if loaded else frames
        for first in range(0, frames if loaded else 0, step):
            parts.append(whole[loaded].isel({time: slice(first, first + step)} if time in sizes else {}))
        for part in parts:
            if changed := Bcc4Accessor(part.compute())._changed():
                raise self._refusal(changed)

    def _rows(self) -> dict[Any, Array]:
        """Of each dimension the numbers that make a part of a row through the middle, at two moments."""
        time, sizes = self._names["t"], self._dataset.sizes
        space = [dim for dim in next(iter(self._fields().values())).dims if dim != time]
        rows = {dim: np.arange(sizes[dim])[sizes[dim] // 2:][:1] for dim in space[:-1]}
        if space:
            middle = sizes[space[-1]] // 2
            rows[space[-1]] = np.arange(sizes[space[-1]])[max(0, middle - _ROW // 2):][:_ROW]
        if time in sizes:
            rows[time] = np.arange(sizes[time])[sizes[time] // 4::max(1, sizes[time] // 2)]
        return rows

    def _refusal(self, changed: list[Any]) -> ValueError:
        return ValueError("the values of %s are no longer those of %s at the dataset's coordinates: interpolate before "
                          "you change values or coordinates" % (", ".join(map(str, changed)), self.file.path))

    def _changed(self) -> list[Any]:
        """The variables that hold other values than the file has at their coordinates."""
        try:
            right = self._interpolated({})
        except Error as error:
            if error.status != _abi.ERROR_OUT_OF_DOMAIN:  # a time
                raise
            return list(self._fields())
        changed, halves = [], self._halves()
        for name, channel, _ in self._channels():
            given, info = self._dataset[name], self.volume.channel_info(channel)
            found, largest = right[name].transpose(*given.dims).values, float(np.abs(info.range[:]).max())
            wrong = given.copy(data=differing(given.values, found, largest))
            if (wrong & ~halves if info.labels else wrong).any():
                changed.append(name)
        return changed

    def _halves(self) -> Any:
        """Where coordinates are half way between samples, and labels those of either by the rounding of places."""
        found = False
        for name in self._names.values():
            at = self._wanted(name, None)
            found = found | (abs(at.copy(data=self._positions(name, at.data)) % 1 - .5) < 1e-6)
        return found

    def _interpolated(self, places: dict[str, Any]) -> Any:
        """What interp gives, unchecked."""
        wanted = {name: self._wanted(name, places.get(name)) for name in self._names.values()}
        if all(at.dims in ((), (name,)) for name, at in wanted.items()):
            return self._grid(wanted)
        return self._points(wanted)

    def _wanted(self, name: str, place: Any) -> Any:
        """A coordinate as a DataArray without coordinates of its own."""
        if place is None:
            if name not in self._dataset.coords:
                raise ValueError("the dataset has no coordinate %s any more: give %s=" % (name, name))
            place = self._dataset[name]
        if isinstance(place, (xarray.DataArray, xarray.Variable)):
            return xarray.DataArray(place.data, dims=place.dims)
        values = dates_of_texts(np.asarray(place)) if name == self._names["t"] else np.asarray(place)
        return xarray.DataArray(values, dims=(name,) if values.ndim else ())

    def _positions(self, name: str, values: Any) -> Array:
        role = next(role for role, known in self._names.items() if known == name)
        if role == "t":
            return frames_of_times(values, self.volume)
        return Places(self.volume).samples("xyz".index(role), values)

    @property
    def _names(self) -> dict[str, str]:
        return engine.names_of(self.volume)

    def _first_origin(self) -> tuple[SharedFile, int, int]:
        for name in self._fields():
            return self._origin(name)
        raise ValueError("the dataset has no variable")

    def _fields(self) -> dict[Any, Any]:
        """The variables but for the small ones that a file keeps beside its channels."""
        return {name: variable for name, variable in self._dataset.data_vars.items() if "bcc4_beside" not in variable.encoding}

    def _origin(self, name: Any) -> tuple[SharedFile, int, int]:
        """File, channel and level of a variable. What is calculated has none, as xarray drops the encoding."""
        origin: tuple[SharedFile, int, int] | None = self._dataset[name].encoding.get("bcc4")
        if origin is None:
            raise ValueError('%s is not as xarray.open_dataset(..., engine="bccsplat") gave it: interpolate before you '
                             "calculate" % name)
        return origin

    def _channels(self) -> list[tuple[Any, int, int]]:
        names = list(self._fields())
        if len(paths := {self._origin(name)[0].path for name in names}) > 1:
            raise ValueError("the variables are of several files: %s; interpolate those of each for themselves" %
                             ", ".join(sorted(paths)))
        return [(name, *self._origin(name)[1:]) for name in names]

    def _coordinates(self, wanted: dict[str, Any]) -> dict[str, Any]:
        return {name: at.variable._replace(attrs=self._dataset[name].attrs if name in self._dataset.coords else {})
                for name, at in wanted.items()}

    def _finished(self, variables: dict[Any, Any], wanted: dict[str, Any]) -> Any:
        moved = {name for name, at in wanted.items() if name not in at.dims or at.size != self._dataset.sizes.get(name, -1)}
        for name, variable in self._dataset.variables.items():  # what lies along axes that stay
            if "bcc4_beside" in variable.encoding and not {*variable.dims} & moved:
                (variables if name in self._dataset.data_vars else wanted)[name] = self._dataset[name]
        made = xarray.Dataset(variables, self._coordinates(wanted), self._dataset.attrs)
        made.encoding.update(self._dataset.encoding)
        return made

    def _grid(self, wanted: dict[str, Any]) -> Any:
        axes = [np.atleast_1d(self._positions(name, at.data)) for name, at in wanted.items()]
        kept = [at.ndim == 1 for at in wanted.values()]
        variables = {}
        for name, channel, level in self._channels():
            field = FieldArray(self.file, axes, channel, level)
            variables[name] = engine.lazy_variable(field, self._names, self._dataset[name].attrs, kept)
            variables[name].encoding["bcc4"] = self.file, channel, level
        return self._finished(variables, wanted)

    def _points(self, wanted: dict[str, Any]) -> Any:
        if level := max(level for *_, level in self._channels()):
            raise ValueError("points are evaluated at level 0: open the dataset without level=%d" % level)
        positions = [at.copy(data=self._positions(name, at.data)) for name, at in wanted.items()]
        t, z, y, x = xarray.broadcast(*positions)
        points = np.stack([axis.data for axis in (x, y, z, t)], -1)
        variables = {}
        for name, channel, _ in self._channels():
            values = evaluate_or_nan(self.volume, points, np.empty(points.shape[:-1], np.float32), channel=channel)
            variables[name] = (t.dims, values, self._dataset[name].attrs)
        return self._finished(variables, wanted)
