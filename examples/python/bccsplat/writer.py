"""Writer: numpy frames or lattice samples in, .bcc4 out."""
from __future__ import annotations

import ctypes
import os
from ctypes import byref
from dataclasses import dataclass
from typing import Any, Callable, Iterable, Sequence, Union

import numpy as np

from . import _abi, interrupt
from ._library import Progress, Watch, call, choose, encode
from .arrays import Array, affine_of, numbers_of, unmasked
from .cancel import CancelToken, own_token, token_of
from .device import Child, Device
from .errors import refuse_existing
from .streams import Flush, Source, WriteAt, read_stream, write_stream

# points [n, 4] -> n values
Field = Callable[[Array], Array]

TYPES = {"u1": _abi.TYPE_U8, "u2": _abi.TYPE_U16, "u4": _abi.TYPE_U32, "i1": _abi.TYPE_I8, "i2": _abi.TYPE_I16,
          "i4": _abi.TYPE_I32, "f2": _abi.TYPE_F16, "f4": _abi.TYPE_F32, "f8": _abi.TYPE_F64}


@dataclass
class Channel:
    """One quantity of the file. air: the value of sites that are not stored (None: a Plan finds
    it); range: spread over U8 or U16 codes; labels: whether values are labels, which nothing lies between (None: readers
    tell by the values); they need lattice="cc", which a Plan chooses."""

    name: str = "value"
    unit: str | None = None
    source_type: int | str | None = None
    value_type: int | str | None = None
    air: float | None = 0.0
    air_threshold: float = 0.0
    range: tuple[float, float] | None = None
    labels: bool | None = None

    def options(self) -> _abi.ChannelOptions:
        """The C struct of it."""
        out = _abi.ChannelOptions(set_mask=0 if self.air is None else _abi.CHANNEL_SET_AIR,
                                  name=self.name, unit=self.unit,
                                  source_type=choose("TYPE", self.source_type),
                                  value_type=choose("TYPE", self.value_type), air=self.air or 0.0,
                                  air_threshold=self.air_threshold)
        if self.labels is not None:
            out.set_mask |= _abi.CHANNEL_LABELS if self.labels else _abi.CHANNEL_QUANTITIES
        if self.range is not None:
            out.set_mask |= _abi.CHANNEL_SET_RANGE
            out.range[:] = [*self.range]
        return out


def for_channels(name: str, values: Any, count: int) -> Any:
    """A number for all channels, or one for each, as one for each; ValueError of others."""
    found = [values] * count if isinstance(values, (int, float)) else values
    if not hasattr(found, "__len__") or len(found) != count:
        raise ValueError("%s is a number, or those of all %d channels, not %r" % (name, count, values))
    return found


def writer_options(dims: Sequence[int], channels: Sequence[Channel], watch: Watch, cancel: CancelToken | None, *,
                   lattice: int | str | None = None, store: int | str | None = None,
                   nonfinite: int | str | None = None, overwrite: bool = False, affine: Any = None,
                   spatial_unit: str | None = None, time_unit: str | None = None,
                   scale: float | Sequence[float] = 0.0, time_scale: float = 0.0, kernel: str | None = None,
                   ends: int | str | None = None, axes: Sequence[tuple[Any, str | None, bool]] | None = None,
                   abs_error: float | Sequence[float] = 0.0, wavelet_errors: float | Sequence[float] | None = None,
                   psnr: float = 0.0, measure: int | str | None = None, lowpass: int = 0,
                   faces: int | str | None = None, levels: int = 0, partial: int | str | None = None, live: int = 0,
                   periodic_axes: int = 0, fixed_predictions: int = 0) -> _abi.WriterOptions:
    """The C struct of a Writer's arguments, which keeps what it points to."""
    o = _abi.WriterOptions(lattice=choose("LATTICE", lattice),
                           store=choose("STORE", store), nonfinite=choose("NONFINITE", nonfinite),
                           overwrite=overwrite, spatial_unit=spatial_unit,
                           time_unit=time_unit, time_scale=time_scale,
                           recommended_kernel=kernel, ends=choose("ENDS", ends),
                           progress=watch.function, cancel_token=token_of(cancel), psnr=psnr,
                           measure=choose("MEASURE", measure), lowpass=lowpass,
                           faces=choose("FACES", faces), levels=levels, partial=choose("PARTIAL", partial), live=live,
                           periodic_axes=periodic_axes, fixed_predictions=fixed_predictions)
    if len(dims) not in (3, 4):
        raise ValueError("dims are the samples along x, y, z and the number of frames, not %r" % (tuple(dims),))
    o.dims[:] = [*dims, *[0] * (4 - len(dims))]
    if isinstance(scale, (int, float)):
        o.scale = scale
    else:  # x, y, z or x, y, z, t
        o.scales[:] = [*scale, *[0] * (4 - len(scale))]
    o.channels = [channel.options() for channel in channels]
    if isinstance(abs_error, (int, float)):
        o.abs_error = abs_error
    else:
        o.abs_errors = for_channels("abs_error", abs_error, len(channels))
    if wavelet_errors is not None:
        o.wavelet_errors = for_channels("wavelet_errors", wavelet_errors, len(channels))
    if affine is not None:
        o.affine[:] = affine_of(affine).reshape(16).tolist()
    if axes is not None:
        o.axes = [_abi.Axis(coordinates=at, unit=unit, flags=_abi.AXIS_DOWN if down else 0) for at, unit, down in axes]
    return o


class Writer(Child):
    """Writes a file: frames by add_frame or lattice layers by add_layer, in order. Nothing is chosen by the data: what is not said
    is as include/bccsplat.h has it, a lattice of half the samples without a bound. bccsplat.save and Plan choose, and keep one.

    dims: samples along x, y, z and the number of frames (0: as many as come). A with block that ends without an
    exception finishes the file; one that ends with an exception leaves no file.
    target: a path, or write_at(offset, bytes); with it flush() is called where all so far is to be durable.
    scale: lattice distance in samples, one for x, y and z, or each of them, and time's.
    partial: PARTIAL_KEEP lets unfinished work stay, PARTIAL_RESUME goes on with it, PARTIAL_APPEND with a finished
    file (all of them of abi); where these do not fit the other arguments it is refused here, WRONG_STATE.
    live: after every so many slabs the file under way, target + ".partial", can be opened as it stands.
    axes: for x, y and z the coordinates of the samples, rising or falling (None: evenly spaced, as the affine says),
    their unit, and whether they count down, as depths do.
    part: (first, end) makes one file of several for join_parts: the frames of part_frames() are added. part_times are
    those of the whole series.
    """

    _kind = "writer"
    _plan: Any  # whose options it has, or None

    def __init__(self, device: Device, target: Union[str, "os.PathLike[str]", WriteAt], dims: Sequence[int], *,
                 channels: Sequence[Channel] = (Channel(),), lattice: int | str | None = None,
                 store: int | str | None = None, nonfinite: int | str | None = None,
                 overwrite: bool = False, affine: Any = None, spatial_unit: str | None = None,
                 time_unit: str | None = None, scale: float | Sequence[float] = 0.0, time_scale: float = 0.0,
                 kernel: str | None = None, ends: int | str | None = None, part: tuple[int, int] | None = None,
                 part_times: Sequence[float] = (), part_lead: int = 0,
                 axes: Sequence[tuple[Any, str | None, bool]] | None = None, progress: Progress | None = None,
                 cancel: CancelToken | None = None, flush: Flush | None = None,
                 abs_error: float | Sequence[float] = 0.0, wavelet_errors: float | Sequence[float] | None = None,
                 psnr: float = 0.0, measure: int | str | None = None, lowpass: int = 0,
                 faces: int | str | None = None, levels: int = 0, partial: int | str | None = None, live: int = 0,
                 periodic_axes: int = 0, fixed_predictions: int = 0) -> None:
        super().__init__(device)
        self._watch, self._finished, self._plan = Watch(progress), False, None
        token = own_token(cancel)
        o = writer_options(dims, channels, self._watch, token, lattice=lattice, store=store,
                           nonfinite=nonfinite, overwrite=overwrite, affine=affine, spatial_unit=spatial_unit,
                           time_unit=time_unit, scale=scale, time_scale=time_scale, kernel=kernel, ends=ends, axes=axes,
                           abs_error=abs_error, wavelet_errors=wavelet_errors, psnr=psnr, measure=measure, lowpass=lowpass,
                           faces=faces, levels=levels, partial=partial, live=live, periodic_axes=periodic_axes,
                           fixed_predictions=fixed_predictions)
        self._shape = tuple(dims[2::-1])
        if part is not None:
            times = np.ascontiguousarray(numbers_of(part_times, "part_times"))
            if times.size != o.dims[3]:
                raise ValueError("part_times are those of all %d frames of the series" % o.dims[3])
            o.part = _abi.SeriesPart(first=part[0], end=part[1], lead=part_lead, times=times)
        if callable(target):
            self._stream = write_stream(target, self._watch, flush)
            self._create("writer_create_stream", device.pointer, byref(self._stream), byref(o), token=token)
        else:
            refuse_existing(target, overwrite or o.partial != _abi.PARTIAL_DEFAULT)
            self._create("writer_create", device.pointer, os.fsencode(target), byref(o), token=token)

    @classmethod
    def of_plan(cls, device: Device, target: Union[str, "os.PathLike[str]"], plan: Any, watch: Watch) -> Writer:
        """A writer with the options of a Plan, which it keeps."""
        writer = cls.__new__(cls)
        Child.__init__(writer, device)
        writer._watch, writer._finished, writer._plan = watch, False, plan
        options = plan.writer_options()
        refuse_existing(target, bool(options.overwrite) or options.partial != _abi.PARTIAL_DEFAULT)
        writer._shape = tuple(options.dims[2::-1])
        writer._create("writer_create", device.pointer, os.fsencode(target), byref(options), token=plan.pointer.token)
        return writer

    def _call(self, name: str, *arguments: Any) -> None:
        call(name, self.pointer, *arguments, watch=self._watch)

    def add_frame(self, frame: Array | Iterable[tuple[Sequence[int], Array]], time: float, channel: int = 0) -> None:
        """The next frame: an array indexed [z, y, x] of any strides, or boxes ((x, y, z) of the first sample, array);
        what no box covers is air. No copy is made, but of arrays with a mask, which is missing data (nonfinite)."""
        whole = isinstance(frame, np.ndarray)
        if isinstance(frame, np.ndarray) and frame.shape != self._shape:
            raise ValueError("a frame is an array [z, y, x] of shape %r, not %r: a part of one is a box ((x, y, z), array)" %
                             (self._shape, frame.shape))
        parts: list[Any] = [((0, 0, 0), frame)] if whole else [*frame]
        boxes, kept = (_abi.Box * max(len(parts), 1))(), []
        for box, part in zip(boxes, parts):
            if len(part) != 2 or not isinstance(part[1], np.ndarray):
                raise ValueError("a frame is a numpy array [z, y, x], or boxes ((x, y, z), array): numpy.asarray makes an "
                                 "array of lists")
            begin, data = part[0], unmasked(part[1])
            if data.ndim != 3 or data.dtype.str[1:] not in TYPES:
                raise ValueError("a box is an array [z, y, x] of numbers of 1 to 8 bytes, not %r" % (data.dtype,))
            if not data.dtype.isnative or data.strides == (0, 0, 0):  # all strides 0 would mean packed
                data = np.ascontiguousarray(data, data.dtype.newbyteorder("="))
            kept.append(data)
            box.struct_size, box.type, box.data = ctypes.sizeof(_abi.Box), TYPES[data.dtype.str[1:]], data
            box.begin[:], box.dims[:] = [*begin], [*data.shape[::-1]]
            box.stride_bytes[:] = [*data.strides[::-1]]
        self._call("writer_add_frame", channel, time, boxes, len(parts))

    def part_frames(self) -> tuple[int, int]:
        """The frames to add: begin, end."""
        begin, end = ctypes.c_uint64(), ctypes.c_uint64()
        call("writer_get_part_frames", self.pointer, byref(begin), byref(end))
        return begin.value, end.value

    def part_box(self) -> tuple[tuple[int, ...], tuple[int, ...]]:
        """The samples of each frame to add, along x, y, z: begin, end; of a block of space its own and what is around."""
        begin, end = (ctypes.c_uint64 * 3)(), (ctypes.c_uint64 * 3)()
        call("writer_get_part_box", self.pointer, begin, end)
        return tuple(begin), tuple(end)

    def layer_geometry(self, layer: int = 0) -> _abi.LayerGeometry:
        """Where the sites of a layer stand: site (i, j, k) at origin + step * (i, j, k) and frame number `frame`."""
        geometry = _abi.LayerGeometry()
        call("writer_get_layer_geometry", self.pointer, layer, byref(geometry))
        return geometry

    def layer_coordinates(self, layer: int) -> tuple[Array, Array, Array, float]:
        """x, y, z of the sites as arrays that broadcast to [z, y, x], and the frame number."""
        g = self.layer_geometry(layer)
        x, y, z = (g.origin[a] + g.step[a] * np.arange(g.dims[a]) for a in range(3))
        return x[None, None, :], y[None, :, None], z[:, None, None], g.frame

    def add_layer(self, samples: Array, layer: int, channel: int = 0) -> None:
        """The next layer of lattice samples, indexed [z, y, x]."""
        flat = np.ascontiguousarray(unmasked(samples), np.float32)
        self._call("writer_add_layer", channel, layer, flat.ctypes.data, flat.size)

    def add_field(self, field: Field, channel: int = 0) -> None:
        """All layers of a channel, from a function of points [n, 4] (x, y, z, t) of index space that returns their n
        values. What it raises comes out of here."""

        def ask(_user: int | None, n: int, xyzt: int, values: int) -> int:
            try:
                points = np.ctypeslib.as_array((ctypes.c_double * (4 * n)).from_address(xyzt)).reshape(n, 4)
                with interrupt.host_code:
                    found = unmasked(field(points))
                np.ctypeslib.as_array((ctypes.c_float * n).from_address(values))[:] = found
                return 0
            except BaseException as error:
                self._watch.error = error
                return 1

        self._call("writer_add_field", channel, _abi.bccsplat_field_fn(ask), None)

    def set_times(self, first: float, step: float) -> None:
        """Times of a file of layers or a field, in the file's unit: frame i at first + i * step."""
        self._call("writer_set_times", first, step)

    def set_attribute(self, key: str, value: str) -> None:
        """A free attribute of the file; a key given twice keeps the last value."""
        self._call("writer_set_attribute", encode(key), encode(value))

    def add_source(self, name: str, size: int, crc32: int = 0) -> None:
        """Where the data came from: name, size in bytes and CRC-32 (0: unknown)."""
        self._call("writer_add_source", encode(name), size, crc32)

    def finish(self) -> _abi.WriterReport:
        """Writes what is pending and gives the file its name; what was written, in bytes, sites and frames."""
        return self._finish("writer_finish")

    def finish_short(self) -> _abi.WriterReport:
        """The same with the frames that were given, fewer than the writer was made for."""
        return self._finish("writer_finish_short")

    def _finish(self, name: str) -> _abi.WriterReport:
        report = _abi.WriterReport()
        self._call(name, byref(report))
        self._finished = True
        return report

    def error(self, channel: int = 0, measured: int = -1) -> _abi.ErrorReport:
        """What was measured against the source, after finish: -1 for the series, else the frame of that number."""
        report = _abi.ErrorReport()
        call("writer_get_error", self.pointer, channel, measured, byref(report))
        return report

    def __exit__(self, *exception: object) -> None:
        try:
            if exception[0] is None and not self._finished:
                self.finish()
        finally:
            self.close()


def join_parts(device: Device, parts: Sequence[Union[str, "os.PathLike[str]"]], path: Union[str, "os.PathLike[str]"], *,
               overwrite: bool = False, compare_levels: bool = False, progress: Progress | None = None,
               cancel: CancelToken | None = None) -> _abi.WriterReport:
    """One file of the parts of a series, in any order. compare_levels: coarser levels that no part has measured, as those
    of blocks, are compared with level 0, so that pictures know which of them will do."""
    refuse_existing(path, overwrite)
    watch, report, token = Watch(progress), _abi.WriterReport(), own_token(cancel)
    names = (ctypes.c_char_p * len(parts))(*[os.fsencode(part) for part in parts])
    options = _abi.JoinOptions(overwrite=overwrite, progress=watch.function, cancel_token=token_of(token),
                               compare_levels=compare_levels)
    call("join_parts", device.pointer, len(parts), names, os.fsencode(path), byref(options), byref(report), watch=watch,
         token=token)
    return report


def join_streams(device: Device, parts: Sequence[Source], write_at: WriteAt, *, compare_levels: bool = False,
                 progress: Progress | None = None, cancel: CancelToken | None = None) -> _abi.WriterReport:
    """The same of parts (size, read_at), by write_at(offset, bytes)."""
    watch, report, token = Watch(progress), _abi.WriterReport(), own_token(cancel)
    streams = (_abi.ReadStream * len(parts))(*[read_stream(part) for part in parts])
    stream = write_stream(write_at, watch)
    options = _abi.JoinOptions(progress=watch.function, cancel_token=token_of(token), compare_levels=compare_levels)
    call("join_streams", device.pointer, len(parts), streams, byref(stream), byref(options), byref(report), watch=watch,
         token=token)
    return report
