"""Volume: an open .bcc4, evaluated, read and cut."""
from __future__ import annotations

import ctypes
import os
from ctypes import byref, c_char_p, c_double, c_uint32, c_uint64
from typing import TYPE_CHECKING, Any, Iterator, Sequence

import numpy as np

from . import _abi
from ._library import Closed, Progress, Watch, call, choose, decode, encode
from .arrays import Array, bytes_of, corners_of, floats_of, points_of, whole
from .cancel import CancelToken, own_token, token_of
from .device import Child, Device
from .errors import Error
from .keywords import given
from .lazy_array import LazyArray
from .slices import Slice
from .sources import RemoteFile, opened
from .streams import Source, read_stream

if TYPE_CHECKING:
    from .field_array import FieldArray
    from .pictures import Picture, Plane
    from .render import TransferFunction
    from .viewing import Viewing


class Volume(Child, LazyArray):
    """An open .bcc4, which is an array [t, z, y, x] of float32 that is read where it is indexed; bccsplat.open makes one.

        volume[12.5]                             # [z, y, x] at frame number 12.5; volume.at(0.48): at a time
        volume[:, 6, 7, 8]                       # the series at a sample; volume.evaluate_world(points): anywhere
        volume.show(0.48).save("smoke.png")      # a picture, which a notebook shows
        volume.plane(0.48, z=5.5).imshow()       # a plane with its coordinates, by matplotlib
        volume.slice(plane=(1, 0, 0, -1, 0))     # the field on any hyperplane of space and time

    source: a path; a URL such as "https://..." or "s3://..." or an object of fsspec, of which only ranges are read; an open
    binary file; the bytes of a file (borrowed, not copied); or (size, read_at) or (size, read_at, merge_gap), of which
    read_at returns None for bytes that are not there yet: WouldBlock.

    Sent to another process, a volume is opened there by its path or URL. copy.copy is another handle of the same.
    salvage: what is damaged reads as missing instead of failing. shape: factors on x, y and z of the world.
    """

    _kind = "volume"

    def __init__(self, device: Device, source: Any, kernel: str | None = None, cache_bytes: int = 0,
                 cancel: CancelToken | None = None, *, salvage: int = 0, shape: Sequence[float] | None = None) -> None:
        """cancel: of opening it and of what takes long with it."""
        super().__init__(device)
        token = own_token(cancel)
        o = _abi.VolumeOptions(kernel=kernel, cache_bytes=cache_bytes, cancel_token=token_of(token), salvage=salvage)
        if shape is not None:
            o.shape[:] = [*shape]
        o.held = token  # an attribute of the Python object alone, as long as it looks into it
        self._given: tuple[Any, dict[str, Any]] = source, {"kernel": kernel, "cache_bytes": cache_bytes, "salvage": salvage,
                                                           "shape": shape}
        if (file := opened(source)) is not None:
            self._given = (file if isinstance(file, RemoteFile) else source), self._given[1]
            source = file.stream()
        elif isinstance(source, RemoteFile):
            source = source.stream()
        if isinstance(source, tuple):
            self._source: Any = read_stream(source)  # type: ignore[arg-type]
            self._create("volume_open_stream", device, byref(self._source), byref(o), token=token)
        elif isinstance(source, (str, os.PathLike)):
            self._create("volume_open_file", device, os.fsencode(source), byref(o), token=token)
        else:
            self._source = bytes_of(source)
            self._create("volume_open_memory", device, self._source.ctypes.data, self._source.size, byref(o), token=token)

    def __reduce__(self) -> tuple[Any, ...]:
        source, options = self._given
        if isinstance(source, (str, os.PathLike)):
            source = os.path.abspath(os.fspath(source))
        elif not isinstance(source, RemoteFile):
            raise TypeError("a volume of bytes, an open file or a stream cannot be sent to another process: send what it was "
                            "opened from, and call bccsplat.open there")
        return _opened_there, (source, options)

    @property
    def shape(self) -> tuple[int, int, int, int]:
        """Frames, and samples along z, y, x."""
        nx, ny, nz, nt = self.info().dims[:]
        return nt, nz, ny, nx

    @property
    def channels(self) -> list[str]:
        """Names of the channels."""
        return [self.channel_info(n).name for n in range(self.info().channel_count)]

    @property
    def affine(self) -> Array:
        """[4, 4], from (x, y, z, 1) of samples to the world; unevenly spaced axes are those of `axis`."""
        return np.array(self.info().affine[:], np.float64).reshape(4, 4)

    def field(self, channel: int | str = 0, level: int = 0) -> FieldArray:
        """A channel, by number or name, as an array [t, z, y, x] of float32 that is read where it is indexed. level: 0, or
        a coarser one of every 2**level-th sample along x, y and z."""
        from .field_array import FieldArray
        return FieldArray.whole(self, self.channel_number(channel), level)

    def __getitem__(self, key: Any) -> Array:
        """Values of channel 0, float32. As a numpy array [t, z, y, x] is indexed, with one list or mask at most; for t also
        numbers between frames, or a list of them. No more is read than what lies around the samples that are asked for."""
        from .field_array import FieldArray, as_numpy, check_moments, full_key
        full = full_key(key, 4)
        t, *space = full
        field = self.field()
        check_moments(t)
        if isinstance(t, (int, np.integer)) and not -len(self) <= t < len(self):
            raise IndexError("frame %d is out of bounds for %d frames" % (t, len(self)))
        if isinstance(t, (np.integer, slice)) or t.dtype == np.bool_:
            part: Array = field[full]
            return part
        moments = np.asarray(t, np.float64)
        if t.ndim and t.dtype.kind in "iu":
            moments = np.where(moments < 0, moments + len(self), moments)
        return as_numpy(FieldArray(self, [moments, *field.axes[1:]]).select((slice(None), *space)), full)

    def __array__(self, dtype: Any = None, copy: bool | None = None) -> Array:
        return np.asarray(self.field().read(), dtype)

    def at(self, time: float, channel: int | str = 0, level: int = 0) -> Array:
        """The field [z, y, x], float32, at a time in the file's unit, on a frame or between two."""
        field = self.field(channel, level)
        moment = [np.array([self.time_to_index(time)]), *field.axes[1:]]
        return np.asarray(type(field)(self, moment, field.channel, level).read()[0])

    def show(self, time: float | None = None, *, frame: float | None = None, width: int | None = None,
             height: int | None = None, layout: int | str | None = None, channel: int | str = 0,
             transfer_function: TransferFunction | None = None, look: int | str | None = None, rotate_x: float = 20,
             rotate_y: float = 30, background: Sequence[float] | None = (0, 0, 0), mode: int | str | None = None,
             quality: int | str | None = None, shading: int | str | None = None, backend: int | str | None = None,
             iso_value: float | None = None, opacity_stop: float = 0.0, sheet_step: float = 0.0,
             progress: Progress | None = None, cancel: CancelToken | None = None) -> Picture:
        """A picture of a moment, by its time in the file's unit or its frame number (neither: the one that shows most, as
        `look` says), which a notebook shows. layout: "volume"; "planes", three through the middle of what is seen, with the
        letters of their sides, the patient's right on the left as radiologists have it; "both" on one sheet; "flat", a map
        from above. None: by the kind of data, and the volume where it is told how it is to look. width and height: of all of
        it (None: 512 for the volume and for each plane). The rest is as of draw; further options of RenderOptions:
        draw(volume.slice(time=..), ...)."""
        from .pictures import draw, draw_layout
        number = self.channel_number(channel)
        kind = self.look(number)
        if time is None and frame is None:
            frame = kind.frame
        told = (transfer_function, look, mode, quality, shading, backend, iso_value) != (None,) * 7 or (
            (rotate_x, rotate_y, opacity_stop, sheet_step) != (20, 30, 0, 0))
        wanted = choose("LAYOUT", layout) or (_abi.LAYOUT_VOLUME if told else kind.layout)
        alone = (mode, quality, shading, backend, iso_value) != (None,) * 5 or (
            (rotate_x, rotate_y, opacity_stop, sheet_step) != (20, 30, 0, 0))
        if alone and wanted in (_abi.LAYOUT_PLANES, _abi.LAYOUT_FLAT):
            raise ValueError("planes have no use for options of a volume's picture: layout=\"volume\" has")
        cut = self.slice(time=time, frame=frame, channel=channel, space="even", cancel=cancel)

        def of_volume(width: int, height: int) -> Picture:
            return draw(cut, width, height, transfer_function=transfer_function, look=look, rotate_x=rotate_x,
                        rotate_y=rotate_y, background=background, mode=mode, quality=quality, shading=shading, backend=backend,
                        iso_value=iso_value, opacity_stop=opacity_stop, sheet_step=sheet_step, progress=progress, cancel=cancel)

        moment = self.time_to_index(time) if time is not None else frame
        assert moment is not None
        return draw_layout(cut, number, moment, wanted, layout is not None, width, height, transfer_function, look, of_volume,
                           background)

    def plane(self, time: float | None = None, *, frame: float | None = None, channel: int | str = 0, level: int = 0,
              x: float | None = None, y: float | None = None, z: float | None = None) -> Plane:
        """The samples of a plane with their coordinates, such as z=12.5 (in samples), at a time or a frame number (neither:
        the middle of the series). Its `imshow` draws it with matplotlib."""
        from .pictures import plane_of
        if time is not None and frame is not None:
            raise ValueError("give one of time and frame")
        if time is not None:
            frame = self.time_to_index(time)
        moment = (self.shape[0] - 1) / 2 if frame is None else frame
        place = {name: at for name, at in (("x", x), ("y", y), ("z", z)) if at is not None}
        return plane_of(self, moment, self.channel_number(channel), level, **place)

    def crops(self, size: Sequence[int], *, seed: int = 0, count: int | None = None, channel: int | str = 0,
              part: tuple[int, int] = (0, 1), memory: int = 1 << 28) -> Iterator[tuple[tuple[int, ...], Array]]:
        """Random crops [t, z, y, x] of that size, each with the place [t, z, y, x] of its first sample, for training. All
        places are as likely. They come slab of the file by slab, in an order that the seed tells; a slab, or as much of it as
        `memory` has bytes for, is decoded once for all its crops where these are many. count: None, as many as fill the
        series once. part: (number, of how many) of the workers that share them, such as (worker.id, worker.num_workers).

            for place, crop in volume.crops((4, 32, 32, 32), seed=epoch): ...
        """
        from .crops import crops_of
        return crops_of(self, size, seed, count, self.channel_number(channel), part, memory)

    def view(self, *, page: str | os.PathLike[str] | None = None, port: int = 0) -> Viewing:
        """The viewer for browsers with this volume, at an address of this machine, which a notebook shows by itself:

            volume.view().open()                 # in a browser

        page: the folder of the viewer, as examples/web/build.sh makes it; None, the one that is installed, as a wheel has it.
        port: of 127.0.0.1; 0, one that is free. It is there until it is closed or the process ends."""
        from .viewing import Viewing
        source = self._given[0]
        return Viewing(source if isinstance(source, RemoteFile) else opened(source) or source, page, port)

    def __repr__(self) -> str:
        if isinstance(self.pointer, Closed):
            return "<bccsplat.Volume, closed>"
        return "<bccsplat.Volume [t, z, y, x] = %r>" % (self.shape,)

    def _repr_png_(self) -> bytes:
        return self.show(width=256, height=256)._repr_png_()

    def _repr_html_(self) -> str:
        import base64
        import html

        from .pictures import described
        rows = "".join("<tr><th>%s</th><td>%s</td></tr>" % (html.escape(key), html.escape(text))
                       for key, text in described(self).items())
        image = base64.b64encode(self._repr_png_()).decode()
        return '<table>%s</table><img src="data:image/png;base64,%s"/>' % (rows, image)

    def reopen(self, source: Source | None = None) -> Volume:
        """The file as it is now, which may have more frames, with what this volume's caches hold. source: (size, read_at)
        of a stream that has grown; None: what it was opened from."""
        newer = object.__new__(type(self))
        Child.__init__(newer, self.device)
        if source is None:
            newer._source = getattr(self, "_source", None)
            newer._given = self._given
            newer._create("volume_reopen", self, None, token=self._pointer.token)
            newer._recipe = self._recipe  # in a forked process, without the caches
        else:
            newer._source = read_stream(source)
            newer._given = source, self._given[1]
            newer._create("volume_reopen", self, byref(newer._source), token=self._pointer.token)
            newer._recipe = ("volume_open_stream", self.device, byref(newer._source), self._recipe[-1])
        return newer

    def info(self) -> _abi.VolumeInfo:
        """What the index says of the file: sizes, times, lattice, units, bytes read so far."""
        info = _abi.VolumeInfo()
        call("volume_get_info", self.pointer, byref(info))
        return info

    def level_info(self, level: int) -> _abi.LevelInfo:
        """Of a coarser level, 1 .. info().level_count, or of level 0."""
        info = _abi.LevelInfo()
        call("volume_get_level_info", self.pointer, level, byref(info))
        return info

    def channel_info(self, channel: int = 0) -> _abi.ChannelInfo:
        """Name, unit, range, histogram, air and error bound of a channel."""
        info = _abi.ChannelInfo()
        call("volume_get_channel_info", self.pointer, channel, byref(info))
        return info

    def look(self, channel: int = 0, look: int | str | None = None, mode: int | str | None = None) -> _abi.Look:
        """A transfer function from the stored histogram, air and noise transparent; see TransferFunction.of."""
        made = _abi.Look()
        call("volume_get_look", self.pointer, channel, choose("LOOK", look), choose("MODE", mode), byref(made))
        return made

    def side(self) -> int:
        """The side of the world that people look at first (SIDE_...), which fit_camera takes."""
        side = ctypes.c_int32()
        call("volume_get_side", self.pointer, byref(side))
        return side.value

    def channel_number(self, channel: int | str) -> int:
        """The number of a channel given by number or name."""
        return self.find_channel(channel) if isinstance(channel, str) else channel

    def find_channel(self, name: str) -> int:
        """The number of the channel of that name; Error NOT_FOUND."""
        channel = c_uint32()
        call("volume_find_channel", self.pointer, encode(name), byref(channel))
        return channel.value

    def times(self) -> Array:
        """Time of every frame, in the file's unit."""
        times = np.empty(self.info().dims[3], np.float64)
        call("volume_get_times", self.pointer, times.ctypes.data, times.size, None)
        return times

    def frame_ranges(self, channel: int = 0) -> Array:
        """Smallest and largest value of the source [frame, 2]; empty where the file does not tell."""
        count = c_uint64()
        call("volume_get_frame_ranges", self.pointer, channel, None, 0, byref(count))
        ranges = np.empty((count.value, 2), np.float64)
        call("volume_get_frame_ranges", self.pointer, channel, ranges.ctypes.data, len(ranges), None)
        return ranges

    def time_to_index(self, time: float) -> float:
        """Frame number of a time in the file's unit; Error OUT_OF_DOMAIN outside the series."""
        index = c_double()
        call("volume_time_to_index", self.pointer, time, byref(index))
        return index.value

    def index_to_time(self, index: float) -> float:
        """Time in the file's unit of a frame number; Error OUT_OF_DOMAIN outside the series."""
        time = c_double()
        call("volume_index_to_time", self.pointer, index, byref(time))
        return time.value

    def attributes(self) -> dict[str, str]:
        """All free attributes of the file."""
        out: dict[str, str] = {}
        for i in range(self.info().attribute_count):
            key, value = c_char_p(), c_char_p()
            call("volume_get_attribute", self.pointer, i, byref(key), byref(value))
            out[decode(key.value)] = decode(value.value)
        return out

    def sources(self) -> list[tuple[str, int, int]]:
        """Name, bytes and CRC-32 (0: unknown) of what the data came from."""
        found: list[tuple[str, int, int]] = []
        name, size, crc = ctypes.c_char_p(), ctypes.c_uint64(), ctypes.c_uint32()
        while True:
            try:
                call("volume_get_source", self.pointer, len(found), byref(name), byref(size), byref(crc))
            except Error as error:
                if error.name != "BCCSPLAT_ERROR_NOT_FOUND":
                    raise
                return found
            found.append((decode(name.value), size.value, crc.value))

    def find_attribute(self, key: str) -> str:
        """One of them; Error NOT_FOUND."""
        value = c_char_p()
        call("volume_find_attribute", self.pointer, encode(key), byref(value))
        return decode(value.value)

    def read_frame(self, frame: int, begin: Sequence[int] | None = None, end: Sequence[int] | None = None,
                   channel: int | str = 0, out: Array | None = None) -> Array:
        """Values [z, y, x], float32, at the source's samples of a frame, from begin to before end (x, y, z; none: all); NaN
        in holes. What a slice has there but for rounding: where the file holds these samples themselves, only the box is
        read. `out`: a contiguous float32 array of that shape."""
        frame = whole(frame, "frame")
        first = [0, 0, 0] if begin is None else [whole(n, "begin") for n in begin]
        last = list(self.info().dims[:3]) if end is None else [whole(n, "end") for n in end]
        values = floats_of(out, tuple(max(b - a, 0) for a, b in zip(first[::-1], last[::-1])))
        if frame < 0 or min(first) < 0 or min(last) < 0:
            raise IndexError("frame %d, samples %s to before %s: frames and samples are counted from 0" % (frame, first, last))
        call("volume_read_frame", self.pointer, self.channel_number(channel), frame, (c_uint64 * 3)(*first),
             (c_uint64 * 3)(*last), values.ctypes.data)
        return values

    def evaluate(self, points: Any, channel: int | str = 0, out: Array | None = None) -> Array:
        """Values at points [..., 4] of index space (x, y, z, t). Outside the domain or in a hole: Error, and NaN in
        `out`."""
        at = points_of(points, 4)
        values = floats_of(out, at.shape[:-1])
        call("volume_evaluate_channel", self.pointer, self.channel_number(channel), values.size, at.ctypes.data,
             values.ctypes.data, None)
        return values

    def evaluate_with_gradients(self, points: Any, channel: int | str = 0) -> tuple[Array, Array]:
        """Values, and their slopes [..., 4] along x, y, z, t per index unit."""
        at = points_of(points, 4)
        values, slopes = np.empty(at.shape[:-1], np.float32), np.empty(at.shape, np.float32)
        call("volume_evaluate_channel", self.pointer, self.channel_number(channel), values.size, at.ctypes.data,
             values.ctypes.data, slopes.ctypes.data)
        return values, slopes

    def evaluate_world(self, points: Any, channel: int | str = 0) -> tuple[Array, Array]:
        """Values, and their slopes, at points [..., 4] of the world: x, y, z in the unit of space, and time. Slopes are
        per unit of space and time. Outside the domain and in holes both are NaN."""
        at = points_of(points, 4)
        values, slopes = np.empty(at.shape[:-1], np.float32), np.empty(at.shape, np.float32)
        call("volume_evaluate_world", self.pointer, self.channel_number(channel), values.size, at.ctypes.data,
             values.ctypes.data, slopes.ctypes.data, byref(c_uint64()))
        return values, slopes

    def axis(self, axis: int) -> tuple[Array, str, bool]:
        """Coordinates of the samples along an axis of space (none where it is evenly spaced), their unit, and whether they
        count down."""
        info = _abi.Axis()
        call("volume_get_axis", self.pointer, axis, byref(info))
        if not info.count:
            return np.empty(0), info.unit, bool(info.flags & _abi.AXIS_DOWN)
        values = np.ctypeslib.as_array(info.coordinates, (info.count,)).copy()
        return values, info.unit, bool(info.flags & _abi.AXIS_DOWN)

    def index_to_world(self, points: Any) -> Array:
        """Places [..., 3] of index space in the world; along unevenly spaced axes by their coordinates."""
        return self._mapped("volume_index_to_world", points)

    def world_to_index(self, points: Any) -> Array:
        """Places [..., 3] of the world in index space."""
        return self._mapped("volume_world_to_index", points)

    def _mapped(self, function: str, points: Any) -> Array:
        at = points_of(points, 3)
        out = np.empty(at.shape, np.float64)
        call(function, self.pointer, at.size // 3, at.ctypes.data, out.ctypes.data)
        return out

    def verify(self, progress: Progress | None = None) -> _abi.VerifyReport:
        """What a check of all bytes found. Where some cannot be read, Error with the report of the others in `report`."""
        report, watch = _abi.VerifyReport(), Watch(progress)
        try:
            call("volume_verify", self.pointer, watch.function, None, byref(report), watch=watch)
        except Error as error:
            error.report = report
            raise
        return report

    def prefetch(self, frame: float, progress: Progress | None = None, cancel: CancelToken | None = None) -> None:
        """Reads and makes what the slice at a frame number needs, ahead of it: for a thread that is idle."""
        watch = Watch(progress)
        options = _abi.SliceOptions(progress=watch.function, cancel_token=token_of(cancel))
        call("volume_prefetch", self.pointer, byref(_abi.Hyperplane(d=1, e=-frame)), byref(options), watch=watch)

    def ranges(self, *, frame: float | None = None, plane: Sequence[float] | None = None, missing: bool = False,
               box: Any = None, interval: tuple[float, float] = (0.0, 0.0), kernel: str | None = None,
               channel: int | str = 0, spacing: float = 0.0, time_length: float = 0.0, level: int = 0,
               thickness: float = 0.0, slab: int | str | None = None, method: int | str | None = None,
               lattice: int | str | None = None, space: str | None = None,
               bandwidth: Sequence[float] = (0, 0, 0, 0)) -> Array:
        """Bytes [n, 2] (offset, size) of the file that a slice reads: at a frame number or on a plane (a, b, c, d, e),
        options as of Slice. missing: without what the volume's caches hold."""
        if (frame is None) == (plane is None):
            raise ValueError("give one of frame and plane")
        a, b, c, d, e = (0, 0, 0, 1, -frame) if frame is not None else plane or ()
        o = _abi.SliceOptions(kernel=kernel, box=corners_of(box), channel=self.channel_number(channel), spacing=spacing,
                              time_length=time_length, level=level, thickness=thickness, slab=choose("SLAB", slab),
                              method=choose("METHOD", method), lattice=choose("LATTICE", lattice),
                              space=choose("SPACE", space))
        o.interval[:] = [*interval]
        o.bandwidth[:] = [*bandwidth]
        arguments = (self.pointer, byref(_abi.Hyperplane(a=a, b=b, c=c, d=d, e=e)), byref(o),
                     _abi.RANGES_MISSING if missing else 0)
        count = c_uint64()
        call("volume_get_ranges", *arguments, None, 0, byref(count))
        found = np.empty((count.value, 2), np.uint64)
        call("volume_get_ranges", *arguments, found.ctypes.data, len(found), byref(count))
        return found[:count.value]

    def slice(self, *, time: float | None = None, frame: float | None = None, plane: Sequence[float] | None = None,
              channel: int | str = 0, kernel: str | None = None, interval: tuple[float, float] = (0.0, 0.0),
              spacing: float = 0.0, time_length: float = 0.0, box: Any = None, space: str | None = None,
              lattice: int | str | None = None, level: int | None = None, thickness: float | None = None,
              slab: int | str | None = None, method: int | str | None = None, bandwidth: Sequence[float] | None = None,
              once: bool = False, motion: bool = False, progress: Progress | None = None,
              cancel: CancelToken | None = None) -> Slice:
        """At a time in the file's unit, at a frame number, or on a plane (a, b, c, d, e); options as of Slice, and of
        bccsplat_slice_options."""
        options: dict[str, Any] = {"channel": channel, "kernel": kernel, "interval": interval, "spacing": spacing,
                                   "time_length": time_length, "box": box, "space": space, "progress": progress,
                                   "cancel": cancel}
        options.update(given(lattice=lattice, level=level, thickness=thickness, slab=slab, method=method, bandwidth=bandwidth,
                             once=once or None, motion=motion or None))
        if sum(given is not None for given in (time, frame, plane)) != 1:
            raise ValueError("give one of time, frame and plane")
        if time is not None:
            return Slice.at_time(self, time, **options)
        if frame is not None:
            plane = (0, 0, 0, 1, -frame)
        if plane is None or len(plane) != 5:
            raise ValueError("plane must be the five numbers (a, b, c, d, e) of a x + b y + c z + d t + e = 0, not %r" %
                             (plane,))
        return Slice(self, *plane, **options)


def _opened_there(source: Any, options: dict[str, Any]) -> Volume:
    """A volume that was sent to this process."""
    from .shared import default_device
    return Volume(default_device(), source, **options)
