"""open and save: a file as an array, and an array as a file."""
from __future__ import annotations

import datetime
from dataclasses import dataclass
from typing import Any, Mapping, Sequence

import numpy as np

from . import _abi
from ._library import Progress
from .arrays import Array, fills_of, loaded, masked, numbers_of, unmasked
from .cancel import CancelToken
from .device import Device
from .errors import Error, refuse_existing
from .keywords import given
from .plan import save_planned
from .shared import Path, default_device
from .volume import Volume
from .writer import TYPES, Channel, Writer

# Units of time that dates can be counted in, as numpy has them.
_STEPS = {name: step for step, names in {
    (1, "ns"): ("ns",), (1, "us"): ("us", "µs"), (1, "ms"): ("ms",), (1, "s"): ("s", "sec", "second", "seconds"),
    (1, "m"): ("min", "minute", "minutes"), (1, "h"): ("h", "hr", "hour", "hours"), (1, "D"): ("d", "day", "days")}.items()
    for name in names}


# Options that say how samples are coded, or that go on with a file that is coded already.
CODED = {"lattice", "scale", "time_scale", "lowpass", "store", "partial", "live", "fixed_predictions"}
# Options of a plan alone.
_PLANNED = {"density", "exact"}


def open(source: Any, *, device: Device | None = None, kernel: str | None = None, cache_bytes: int = 0,
         cancel: CancelToken | None = None, salvage: int = 0, shape: Sequence[float] | None = None) -> Volume:
    """Opens a .bcc4; nothing but its index is read. The volume is an array [t, z, y, x] of float32, and a number between
    two frames is a moment between them:

        volume = bccsplat.open("smoke.bcc4")
        volume[12]                  # frame 12, [z, y, x]
        volume[12.5, 10:20, :, 3]   # a moment between frames; only what lies around that is read
        volume.at(0.48)             # at a time in the file's unit

    source: a path, a URL or object of fsspec, an open binary file, the bytes of a file, or a stream, as of Volume. device:
    None, one that the whole process shares. kernel: of reconstruction; None, the file's. cache_bytes: of memory for what was
    read; 0, what playing forward needs. salvage, shape, cancel: as of Volume. Nothing has to be closed.
    """
    return Volume(device or default_device(), source, kernel=kernel, cache_bytes=cache_bytes, cancel=cancel, salvage=salvage,
                  shape=shape)


def bounds_of(abs_error: Any, names: Sequence[str]) -> Any:
    """A bound for all channels as it is; of a mapping one for each, 0 where it has none, or the one that all have."""
    if not isinstance(abs_error, Mapping):
        return abs_error
    if unknown := sorted(map(str, {*abs_error} - {*names})):
        raise ValueError("abs_error has %s, which is no channel: there are %s" % (unknown[0], ", ".join(names)))
    found = [float(abs_error.get(name, 0.0)) for name in names]
    return found[0] if len({*found}) == 1 else found


def frame_times(count: int, dt: float, start: float, times: Any) -> list[float]:
    """The time of every frame: `times`, or from `start` on every `dt`."""
    if times is None:
        return [start + n * dt for n in range(count)]
    given = [float(time) for time in numbers_of(times, "times").reshape(-1)]
    if len(given) != count:
        raise ValueError("times must be those of all %d frames, not %d" % (count, len(given)))
    return given


def undated(times: Any, unit: str | None) -> tuple[Any, str | None, dict[str, str]]:
    """Times that are dates or durations of numpy or Python as numbers of `unit` (None: seconds), that unit, and the
    attributes that say which date 0 is, of the first of them; others as they are."""
    given = np.asarray(times)
    if given.size and isinstance(given.flat[0], (datetime.datetime, datetime.timedelta)):
        given = given.astype("M8[us]" if isinstance(given.flat[0], datetime.datetime) else "m8[us]")
    kind = given.dtype.kind
    if kind not in "mM":
        return times, unit, {}
    if unit is not None and unit not in _STEPS:
        raise ValueError("times are dates or durations, and time_unit is %r: it is one of %s" % (unit, ", ".join(_STEPS)))
    given = given.astype(np.promote_types(given.dtype, kind + "8[us]"))  # months have no length
    first = np.ravel(given)[0].astype("M8[s]") if kind == "M" else np.timedelta64(0, "s")
    numbers = np.where(np.isnat(given), np.nan, (given - first) / np.timedelta64(*_STEPS[unit or "s"]))
    return numbers, unit or "s", {"time_epoch": str(first).replace("T", " ")} if kind == "M" else {}


def placed(spacing: Any, origin: Any) -> Array:
    """The affine [4, 4] of samples a distance apart along x, y, z (a number: the same along all), the first at `origin`."""
    affine = np.diag([*numbers_of(spacing, "spacing", (3,)), 1.0])
    affine[:3, 3] = numbers_of(origin, "origin", (3,))
    return affine


def as_series(array: Any) -> Any:
    """What has frames [z, y, x] at [t], of anything with a shape: arrays of three dimensions are one frame."""
    if not hasattr(array, "shape"):
        array = loaded(array)
    if type(array).__module__.startswith("nibabel."):
        raise ValueError("images of nibabel are [x, y, z, t]: give numpy.asarray(image.dataobj).T, and affine=image.affine")
    if 0 in array.shape:
        raise ValueError("there is nothing to save: an array of shape %r has no values" % (tuple(array.shape),))
    if len(array.shape) == 3:
        return masked(array, fills_of(array))[None]
    if len(array.shape) != 4:
        raise ValueError("an array is [t, z, y, x] or [z, y, x], not of shape %r" % (tuple(array.shape),))
    return array


def refuse_both(one: str, given: Any, **others: Any) -> None:
    """ValueError where something is said twice, one of which would be ignored."""
    if given is not None and (twice := [name for name, value in others.items() if value is not None]):
        raise ValueError("%s and %s say the same: give one of them" % (one, twice[0]))


def save(path: Path, array: Any, *, dt: float | None = None, start: float | None = None, times: Any = None,
         spacing: Any = None, origin: Any = None, affine: Any = None, name: str = "value",
         unit: str | Mapping[str, str | None] | None = None, spatial_unit: str | None = None,
         time_unit: str | None = None, attributes: Mapping[str, str] = {},
         air: float | None = None, air_threshold: float = 0.0, nonfinite: str | None = None, labels: bool | None = None,
         abs_error: float | Mapping[str, float] = 0.0, psnr: float | None = None, overwrite: bool = False,
         device: Device | None = None, progress: Progress | None = None, cancel: CancelToken | None = None,
         lattice: int | str | None = None, scale: float | Sequence[float] | None = None, time_scale: float | None = None,
         store: int | str | None = None, kernel: str | None = None,
         ends: int | str | None = None, faces: int | str | None = None, axes: Any = None, levels: int | None = None,
         density: float | None = None, exact: bool | None = None, lowpass: int | None = None,
         measure: int | str | None = None, live: int | None = None, partial: int | None = None,
         periodic_axes: int | None = None, fixed_predictions: int | None = None) -> _abi.WriterReport:
    """Writes an array to a .bcc4 file, frame by frame, and returns the report of the writer.

    Without options it is the file that `bcc4 import` makes: a Plan, which reads some frames once more, or all of them, finds what
    takes the fewest bytes and keeps 50 dB outside air and every sample within 2 % of the range of its channel, or all of them
    exactly where that takes less. What was chosen and is promised is told by the volume's info() and channel_info(): store,
    lattice, error_bound (0 of samples kept exactly, and where no bound can be kept, as of frames of which memory holds no slab).
    abs_error and psnr ask for other bounds.
    Options that say how samples are coded (lattice, scale, time_scale, store, lowpass, partial, live, fixed_predictions)
    are taken at their word, without a bound unless one is given: what a lattice of half the samples cannot hold (noise, detail
    of one sample) is lost then, where lattice="cc" keeps every sample. With density, exact, air_threshold or some kernels a
    plan chooses samples, without a bound, too; a warning says where these are off by more than 2 % of the range.

    array: [t, z, y, x], or [z, y, x] of one frame, of numbers of 1 to 8 bytes; anything with a shape whose [t] is a frame
    does, such as a memory map or a variable of a file, of which one frame is held at a time. A mapping of names to such
    arrays of one shape makes a channel of each. Arrays are passed to the library as they are, with any strides. What a
    mask of numpy.ma hides, as netCDF4 has it, and what the attributes _FillValue and missing_value name is missing data.
    dt, start: time between frames (None: 1) and of the first (None: 0), or times [t] of all of them, rising, in time_unit; or dates or
    durations of numpy or Python, which are stored in time_unit (None: seconds), with the date of the first.
    spacing, origin: distance of samples (None: 1) and place of the first (None: 0) along x, y, z, in spatial_unit, or an
    affine [4, 4] from (x, y, z, 1) of samples to the world.
    name, unit: of the channel and its values; of several units by their names. air: the value of empty space, within
    air_threshold of which nothing is stored; None: 0, or what a plan finds. nonfinite: "error", "hole" (NaN and infinities are missing data) or "clamp";
    None: "hole" where an array has a mask or fill values, else "error".
    labels: whether the values of all channels are labels, which nothing lies between and which are stored exactly. None: the
    values tell. abs_error: > 0: no finite sample is off by more; of several channels by their names, for which there is no
    plan: a lattice of half the samples, with corrections that keep them. psnr: in dB, also with options that say how samples are
    coded. overwrite: an existing file is replaced; without it FileExistsError is raised before anything is read. lattice,
    scale and the rest: as of Writer; density and exact: as of Plan.
    """
    options = given(cancel=cancel, lattice=lattice, scale=scale, time_scale=time_scale, store=store, kernel=kernel,
                    ends=ends, faces=faces, axes=axes, levels=levels, density=density, exact=exact,
                    lowpass=lowpass, measure=measure, live=live, partial=partial, periodic_axes=periodic_axes,
                    fixed_predictions=fixed_predictions)
    refuse_existing(path, overwrite or partial is not None)
    refuse_both("times", times, dt=dt, start=start)
    refuse_both("affine", affine, spacing=spacing, origin=origin)
    channels = {key: as_series(value) for key, value in array.items()} if isinstance(array, Mapping) else \
        {name: as_series(array)}
    if not channels:
        raise ValueError("there is nothing to save: the mapping has no channel")
    if len({tuple(series.shape) for series in channels.values()}) != 1:
        raise ValueError("channels have different shapes: %s" %
                         ", ".join("%s %r" % (key, tuple(series.shape)) for key, series in channels.items()))
    nt, nz, ny, nx = next(iter(channels.values())).shape
    times, time_unit, dates = undated(times, time_unit)
    when, attributes = frame_times(nt, 1.0 if dt is None else dt, start or 0.0, times), {**attributes, **dates}
    place = placed(1.0 if spacing is None else spacing, 0.0 if origin is None else origin) if affine is None else affine
    units = unit if isinstance(unit, Mapping) else dict.fromkeys(channels, unit)
    if unknown := set(units) - set(channels):
        raise ValueError("unit has %s, which is no channel: there are %s" % (sorted(unknown)[0], ", ".join(channels)))
    series, bounds = [*channels.values()], bounds_of(abs_error, [*channels])
    kinds = [kind_of(values) for values in series]
    if nonfinite is None:
        nonfinite = "hole" if any(kind.masked for kind in kinds) else "error"
    if psnr is not None and not isinstance(psnr, (int, float)):
        raise TypeError("psnr must be a number of decibels, not %r" % (psnr,))
    if psnr is not None or _PLANNED & {*options} or (isinstance(bounds, (int, float)) and not CODED & {*options}):
        try:
            return save_planned(
                device or default_device(), path, lambda t, channel: frame_of(series[channel], t), (nx, ny, nz, nt), when,
                attributes, psnr=psnr or 0.0, affine=place, spatial_unit=spatial_unit, time_unit=time_unit,
                nonfinite=nonfinite, abs_error=bounds, overwrite=overwrite, types=[kind.given for kind in kinds],
                channels=[Channel(key, units.get(key), kind.source, air=air, air_threshold=air_threshold,
                                  labels=labels) for key, kind in zip(channels, kinds)],
                progress=progress, **options)
        except Error as error:
            if psnr is not None or error.status != _abi.ERROR_BOUND_NOT_MET or _PLANNED & {*options} or not bounds:
                raise  # else by the lattice of the defaults, whose corrections keep any bound that floats can
    writer = Writer(device or default_device(), path, (nx, ny, nz, nt), affine=place, spatial_unit=spatial_unit,
                    time_unit=time_unit, nonfinite=nonfinite, abs_error=bounds, overwrite=overwrite,
                    channels=[Channel(key, units.get(key), kind.source, air=air or 0.0, air_threshold=air_threshold,
                                      labels=labels)
                              for key, kind in zip(channels, kinds)],
                    progress=progress, **options)
    with writer:
        for key, value in attributes.items():
            writer.set_attribute(key, value)
        add_frames(writer, series, when, range(nt))
        return writer.finish()


def add_frames(writer: Writer, channels: Sequence[Any], times: Sequence[float], frames: range) -> None:
    """Gives a writer some frames of all its channels, in order."""
    for t in frames:
        for channel, series in enumerate(channels):
            writer.add_frame(frame_of(series, t), times[t], channel)


@dataclass
class FrameKind:
    """Of frames of a series. source: the constant of the type of their values (None: the library will say why it takes
    none of it); given: the type that they come in; masked: whether they have masks or fill values."""

    source: int | None
    given: Any
    masked: bool


def kind_of(series: Any) -> FrameKind:
    """The kind of a series' frames, by the first of them."""
    first = masked(series[0], fills_of(series))
    own = writable(np.empty(0, first.dtype)).dtype.newbyteorder("=")
    missing = isinstance(first, np.ma.MaskedArray)
    return FrameKind(TYPES.get(own.str[1:]), np.promote_types(own, np.float16) if missing else own, missing)


def frame_of(series: Any, t: int) -> Array:
    """Frame t of a series as writable has it; what is missing is NaN."""
    return writable(masked(series[t], fills_of(series)))


def writable(frame: Any) -> Array:
    """A frame as an array of a type that the library takes: booleans as bytes, 64-bit integers as doubles."""
    array = unmasked(frame)
    if array.dtype == np.bool_:
        return array.view(np.uint8)
    return array.astype(np.float64) if array.dtype.kind in "iu" and array.dtype.itemsize == 8 else array
