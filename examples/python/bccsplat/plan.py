"""Plan: what suits a series, chosen by looking at its frames, and the file that is written by it."""
from __future__ import annotations

import ctypes
import json
import os
import warnings
from ctypes import byref
from typing import Any, Callable, Dict, Mapping, Sequence, Union

import numpy as np

from . import _abi, interrupt
from ._library import Progress, Watch, call, decode
from .arrays import Array, numbers_of, unmasked
from .cancel import CancelToken, own_token
from .device import Child, Device
from .errors import Error
from .writer import TYPES, Channel, Writer, writer_options

# The share of a channel's range that no sample is off by of a plan without options.
_PROMISED = .02
# frame, channel -> an array [z, y, x]
Source = Callable[[int, int], Array]


class Plan(Child):
    """The options of a writer that suit a series: lattice, distances, steps, store and levels. With psnr or abs_error
    those of the smallest file that keeps the error; lattice, scale, store and others that are given are kept.

    dims: samples along x, y, z and the number of frames. source(frame, channel) returns an array [z, y, x]; it is asked
    for some frames, or for all, and for some more than once. types: of those arrays, by channel, as numpy has them.
    times: of the frames, rising; None: 0, 1, 2 ... density: sites per sample to choose distances for. exact: values as
    precise as the source's. levels: None, by the size of the frames. The others are those of Writer.
    """

    _kind = "plan"

    def __init__(self, device: Device, dims: Sequence[int], source: Source, *, channels: Sequence[Channel] = (Channel(),),
                 types: Sequence[Any] = (np.float32,), times: Sequence[float] | None = None, density: float = 0.0,
                 exact: bool = False, levels: int | None = None, progress: Progress | None = None,
                 cancel: CancelToken | None = None, lattice: int | str | None = None,
                 store: int | str | None = None, nonfinite: int | str | None = None, overwrite: bool = False,
                 affine: Any = None, spatial_unit: str | None = None, time_unit: str | None = None,
                 scale: float | Sequence[float] = 0.0, time_scale: float = 0.0, kernel: str | None = None,
                 ends: int | str | None = None, axes: Sequence[tuple[Any, str | None, bool]] | None = None,
                 abs_error: float | Sequence[float] = 0.0, wavelet_errors: float | Sequence[float] | None = None,
                 psnr: float = 0.0, measure: int | str | None = None, lowpass: int = 0, faces: int | str | None = None,
                 partial: int | str | None = None, live: int = 0, periodic_axes: int = 0,
                 fixed_predictions: int = 0) -> None:
        super().__init__(device)
        self._watch = Watch(progress)
        token = own_token(cancel)
        self._wish = writer_options(dims, channels, self._watch, token, levels=levels or 0, lattice=lattice,
                                    store=store, nonfinite=nonfinite, overwrite=overwrite, affine=affine,
                                    spatial_unit=spatial_unit, time_unit=time_unit, scale=scale, time_scale=time_scale,
                                    kernel=kernel, ends=ends, axes=axes, abs_error=abs_error, wavelet_errors=wavelet_errors,
                                    psnr=psnr, measure=measure, lowpass=lowpass, faces=faces, partial=partial, live=live,
                                    periodic_axes=periodic_axes, fixed_predictions=fixed_predictions)
        kinds = [np.dtype(kind) for kind in types]
        if len(kinds) != len(channels):
            raise ValueError("types are those of all %d channels, not %d" % (len(channels), len(kinds)))
        values = (_abi.PlanChannel * len(kinds))(*[_abi.PlanChannel(type=choose_type(kind)) for kind in kinds])
        shape = tuple(dims[2::-1])

        def give(_user: int | None, frame: int, channel: int, address: int) -> int:
            try:
                kind = kinds[channel]
                size = kind.itemsize * shape[0] * shape[1] * shape[2]
                room = np.frombuffer(memoryview((ctypes.c_char * size).from_address(address)), kind).reshape(shape)
                with interrupt.host_code:
                    values = unmasked(source(frame, channel))
                if kind.kind in "iu" and values.dtype.kind == "f":
                    raise ValueError("frame %d has %s values, masked ones perhaps, and types says %s: give a type of floats "
                                     "in types, and that of the source in the channel's source_type" %
                                     (frame, values.dtype, kind))
                room[...] = values
                return 0
            except BaseException as error:  # ctypes would print and forget it
                self._watch.error = error
                return 1

        o = _abi.PlanOptions(wish=self._wish, channels=values, density=density, exact=exact,
                             frame=_abi.bccsplat_source_fn(give))
        if levels is not None:
            o.set_mask |= _abi.PLAN_SET_LEVELS
        when = None if times is None else np.ascontiguousarray(numbers_of(times, "times"))
        if when is not None:
            if when.size != dims[3]:
                raise ValueError("times are those of all %d frames, not %d" % (dims[3], when.size))
            o.times = when
        self._create("plan_create", device.pointer, byref(o), watch=self._watch, token=token)

    @property
    def text(self) -> str:
        """What was chosen and why."""
        text = ctypes.c_char_p()
        call("plan_get_text", self.pointer, byref(text))
        return decode(text.value)

    @property
    def found(self) -> Dict[str, Any]:
        """What was found and tried, as `bcc4 import --dry-run --json` shows it."""
        told = ctypes.c_char_p()
        call("plan_get_json", self.pointer, byref(told))
        found: Dict[str, Any] = json.loads(decode(told.value))
        return found

    def writer_options(self) -> _abi.WriterOptions:
        """The C struct of all that was chosen; it belongs to the plan, until refine."""
        options = _abi.WriterOptions()
        call("plan_get_writer_options", self.pointer, byref(options))
        return options

    def writer(self, target: Union[str, "os.PathLike[str]"]) -> Writer:
        """A writer with these options, which is given all frames."""
        return Writer.of_plan(self.device, target, self, self._watch)

    def refine(self) -> None:
        """Makes the plan finer, after a writer missed the psnr. Raises NOT_FOUND where nothing is left to try."""
        call("plan_refine", self.pointer)


def choose_type(kind: Any) -> int:
    """The constant of a numpy type."""
    if kind.str[1:] not in TYPES:
        raise ValueError("values are numbers of 1 to 8 bytes, not %r" % (kind,))
    return TYPES[kind.str[1:]]


def save_planned(device: Device, path: Union[str, "os.PathLike[str]"], frames: Source, dims: Sequence[int],
                 times: Sequence[float], attributes: Mapping[str, str], **options: Any) -> _abi.WriterReport:
    """Writes a series by a plan of it; where a PSNR is missed once more, by a finer one."""
    with Plan(device, dims, frames, times=times, **options) as plan:
        while True:
            try:
                return write_once(plan, path, frames, times, attributes)
            except Error as error:
                if error.status != _abi.ERROR_BOUND_NOT_MET:
                    raise
                missed = error
            try:
                plan.refine()
            except Error as error:
                if error.status != _abi.ERROR_NOT_FOUND:
                    raise
                raise missed from None  # nothing is left to try


def write_once(plan: Plan, path: Union[str, "os.PathLike[str]"], frames: Source, times: Sequence[float],
               attributes: Mapping[str, str]) -> _abi.WriterReport:
    """Writes all frames by a plan as it is."""
    with plan.writer(path) as writer:
        for key, value in attributes.items():
            writer.set_attribute(key, value)
        for t, time in enumerate(times):
            for channel in range(plan.writer_options().channel_count):
                writer.add_frame(frames(t, channel), time, channel)
        report = writer.finish()
        tell_losses(plan, writer, path)
        return report


def tell_losses(plan: Plan, writer: Writer, path: Union[str, "os.PathLike[str]"]) -> None:
    """Warns where a plan keeps no bound and what was measured is off by more than what it promises otherwise."""
    options = plan.writer_options()
    if options.abs_error or options.abs_errors or options.psnr:
        return
    for channel in range(options.channel_count):
        error = writer.error(channel)
        if error.max_abs <= _PROMISED * error.peak:
            continue
        short = error.max_abs <= 2 * float(np.spacing(np.float32(min(abs(error.expected), 1e38))))
        advice = "values are read as 32-bit floats: subtract an offset" if short else \
            'no bound was asked for: give abs_error= or psnr=, or lattice="cc", which keeps all samples'
        warnings.warn("%s: %s is off by up to %g, where its values spread by %g; %s" %
                      (os.fspath(path), options.channels[channel].name, error.max_abs, error.peak, advice), stacklevel=5)
