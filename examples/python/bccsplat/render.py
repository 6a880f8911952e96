"""Renderer and Frame: pictures as numpy arrays, PNG and EXR."""
from __future__ import annotations

import ctypes
import os
from ctypes import byref
from typing import Any, Callable, Mapping, Sequence, Union

import numpy as np

from . import _abi, interrupt
from ._library import Progress, Watch, call, choose
from .arrays import Array, are_drawable, numbers_of
from .cancel import CancelToken, own_token, token_of
from .device import Child, Device, pointer_of
from .errors import refuse_existing
from .slices import Slice
from .streams import WriteAt, write_stream

Tile = Callable[[int, int, int, int], "bool | None"]
# Of copies of pixels; others are bytes.
_NUMBERS = {_abi.PIXELS_F32: np.float32, _abi.PIXELS_F16: np.float16}


def rows_of(points: Any, what: str, columns: str) -> Array:
    """Points of a transfer function as doubles [n, columns]; ValueError of another shape."""
    found, width = np.ascontiguousarray(numbers_of(points, what)), columns.count(",") + 1
    if found.ndim != 2 or found.shape[1] != width:
        raise ValueError("%s must be rows (%s), not of shape %r" % (what, columns, found.shape))
    return found


def background_of(background: Any) -> list[float] | None:
    """Linear red, green and blue of a background; None for none; ValueError of what is neither."""
    return None if background is None else numbers_of(background, "background, linear red, green and blue,", (3,)).tolist()


class TransferFunction:
    """Colour and opacity over the value, linear between points and constant beyond the ends.

    colors: rows (value, red, green, blue), linear. opacities: rows (value, fraction absorbed per unit_distance).
    unit_distance: world length, 0 for one mean voxel.
    """

    def __init__(self, colors: Any, opacities: Any, unit_distance: float = 0.0) -> None:
        self.colors = rows_of(colors, "colors", "value, red, green, blue")
        self.opacities = rows_of(opacities, "opacities", "value, opacity")
        self.unit_distance = unit_distance

    @classmethod
    def of(cls, look: _abi.Look) -> TransferFunction:
        """That of Volume.look."""
        return cls([tuple(p) for p in look.colors[:look.color_count]],
                   [tuple(p) for p in look.opacities[:look.opacity_count]])

    def struct(self) -> _abi.TransferFunction:
        """Looks into this object's arrays."""
        return _abi.TransferFunction(colors=self.colors, opacities=self.opacities, unit_distance=self.unit_distance)


class Frame(Child):
    """An image. channels: bits, such as Frame.RGBA | Frame.DEPTH; RGBA is always there."""

    RGBA, DEPTH = _abi.FRAME_RGBA, _abi.FRAME_DEPTH
    VALUE, TIME, DEEP = _abi.FRAME_VALUE, _abi.FRAME_TIME, _abi.FRAME_DEEP
    _kind = "frame"

    def __init__(self, device: Device, width: int, height: int, channels: int = RGBA) -> None:
        super().__init__(device)
        self._create("frame_create", device.pointer, width, height, channels)

    @classmethod
    def wrap(cls, device: Device, pixels: Array) -> Frame:
        """Draws into the caller's float32 array [height, width, 4]; rows may be apart, pixels may not."""
        if pixels.ndim != 3 or not are_drawable(pixels, (*pixels.shape[:2], 4)):
            raise ValueError("pixels must be writable float32 [height, width, 4] with contiguous rows")
        frame = cls.__new__(cls)
        Child.__init__(frame, device)
        frame._pixels = pixels  # borrowed by the library
        frame._create("frame_wrap", device.pointer, pixels.shape[1], pixels.shape[0], pixels.ctypes.data,
                      pixels.strides[0])
        return frame

    @classmethod
    def wrap_gl(cls, device: Device, texture: int, width: int, height: int, *, depth_texture: int = 0,
                replace: bool = False) -> Frame:
        """Draws into a texture of the OpenGL context that is current on this thread, before the depths of another one
        (0: none), with nothing read back. replace: not over what the texture holds. It has no pixels here."""
        frame = cls.__new__(cls)
        Child.__init__(frame, device)
        target = _abi.GlTarget(texture=texture, width=width, height=height, depth_texture=depth_texture, replace=int(replace))
        frame._create("frame_wrap_gl", device.pointer, byref(target))
        return frame

    @classmethod
    def wrap_planes(cls, device: Device, width: int, height: int, planes: Mapping[int, Array | None]) -> Frame:
        """Draws into the caller's float32 arrays, by channel: [height, width, 4] for RGBA, else [height, width]; rows may
        be apart and go from the bottom up (array[::-1]), pixels may not. None: the frame's own memory."""
        frame = cls.__new__(cls)
        Child.__init__(frame, device)
        array = (_abi.HostPlane * max(len(planes), 1))()
        for plane, (channel, pixels) in zip(array, planes.items()):
            plane.channel = channel
            if pixels is None:
                continue
            if not are_drawable(pixels, (height, width, 4) if channel == cls.RGBA else (height, width)):
                raise ValueError("planes must be writable float32 [height, width, 4] or [height, width] with contiguous rows")
            plane.pixels, plane.row_bytes = pixels, pixels.strides[0]
        frame._pixels = [*planes.values()]  # borrowed by the library
        frame._create("frame_wrap_planes", device.pointer, width, height, array, len(planes))
        return frame

    _pixels: Any = None

    @property
    def size(self) -> tuple[int, int]:
        """Width and height."""
        plane = _abi.Plane()
        call("frame_get_channel", self.pointer, self.RGBA, byref(plane))
        return plane.width, plane.height

    def channel(self, channel: int) -> Array:
        """The pixels themselves, [row, column, component] or [row, column]; the array keeps them alive."""
        plane = _abi.Plane()
        call("frame_get_channel", self.pointer, channel, byref(plane))
        assert plane.pixels is not None
        row = ctypes.c_int64(plane.row_bytes).value  # negative from the bottom up
        size = abs(row) * (plane.height - 1) + 4 * plane.components * plane.width
        first = -row * (plane.height - 1) if row < 0 else 0  # of row 0 in that memory
        memory: Any = (ctypes.c_char * size).from_address(plane.pixels - first)
        memory._owner = self.share()
        shape, strides = (plane.height, plane.width, plane.components), (row, 4 * plane.components, 4)
        array: Array = np.ndarray(shape, np.float32, memory, first, strides)
        return array if plane.components > 1 else array[:, :, 0]

    def rgba(self) -> Array:
        """[height, width, 4], float32, linear, premultiplied by opacity; the pixels themselves."""
        return self.channel(self.RGBA)

    def copy(self, format: int | str = "srgb8", channel: int = RGBA) -> Array:
        """A copy of a plane: "f32", "f16", or of RGBA "srgb8", bytes as PNG has them, or "srgb8_premultiplied"."""
        pixels = choose("PIXELS", format)
        out = np.empty(self.channel(channel).shape, _NUMBERS.get(pixels, np.uint8))
        call("frame_copy", self.pointer, channel, pixels, out.ctypes.data, 0)
        return out

    def copy_part(self, x: int, y: int, width: int, height: int, format: int | str = "srgb8",
                  channel: int = RGBA) -> Array:
        """The same of a rectangle; for a tile function, too."""
        pixels = choose("PIXELS", format)
        out = np.empty((height, width, 4) if channel == self.RGBA else (height, width), _NUMBERS.get(pixels, np.uint8))
        call("frame_copy_part", self.pointer, channel, pixels, x, y, width, height, out.ctypes.data, 0)
        return out

    def depth(self) -> Array:
        """[height, width], float32; the plane of Frame.DEPTH itself."""
        return self.channel(self.DEPTH)

    def deep(self) -> tuple[Array, Array]:
        """(first, samples) of the last render, copied. Pixel p = row * width + column has samples[first[p]:first[p + 1]],
        rows of (z, z_back, opacity, red, green, blue) in order of depth."""
        deep = _abi.Deep()
        call("frame_get_deep", self.pointer, byref(deep))
        pixels = deep.width * deep.height
        assert deep.first
        first = np.frombuffer(ctypes.string_at(deep.first, 8 * (pixels + 1)), np.uint64)
        floats = deep.sample_count * deep.components
        data = ctypes.string_at(deep.samples, 4 * floats) if floats else b""
        return first, np.frombuffer(data, np.float32).reshape(-1, deep.components)

    def _image_options(self, overwrite: bool, background: Sequence[float] | None,
                       **more: Any) -> _abi.ImageOptions:
        options = _abi.ImageOptions(overwrite=overwrite, use_background=background is not None, **more)
        if (color := background_of(background)) is not None:
            options.background[:] = [*color]
        return options

    def save_png(self, path: Union[str, "os.PathLike[str]"], *, overwrite: bool = False,
                 background: Sequence[float] | None = None) -> None:
        """8-bit sRGB; transparent, or over a linear RGB background."""
        refuse_existing(path, overwrite)
        call("frame_save_png", self.pointer, os.fsencode(path), byref(self._image_options(overwrite, background)))

    def save_exr(self, path: Union[str, "os.PathLike[str]"], *, overwrite: bool = False,
                 frames_per_second: tuple[int, int] | None = None, exposure_seconds: float = 0.0,
                 comments: str | None = None) -> None:
        """32-bit float. frames_per_second: numerator and denominator, for frames of a sequence."""
        refuse_existing(path, overwrite)
        call("frame_save_exr", self.pointer, os.fsencode(path),
             byref(self._exr_options(overwrite, frames_per_second, exposure_seconds, comments)))

    def save_deep_exr(self, path: Union[str, "os.PathLike[str]"], *, overwrite: bool = False,
                      frames_per_second: tuple[int, int] | None = None, exposure_seconds: float = 0.0,
                      comments: str | None = None) -> None:
        """Deep scanlines of a frame with the channel DEEP, as save_exr otherwise."""
        refuse_existing(path, overwrite)
        call("frame_save_deep_exr", self.pointer, os.fsencode(path),
             byref(self._exr_options(overwrite, frames_per_second, exposure_seconds, comments)))

    def to_bytes(self, format: int | str = "png", background: Sequence[float] | None = None,
                 progress: Progress | None = None, cancel: CancelToken | None = None) -> bytes:
        """The bytes of the file that save_png, save_exr or save_deep_exr writes. format: "png", "exr", "deep_exr"."""
        watch = Watch(progress)
        options = self._image_options(False, background, progress=watch.function, cancel_token=token_of(cancel))
        size = ctypes.c_uint64()
        room = 1 << 20
        while True:
            image = ctypes.create_string_buffer(room)
            call("frame_save_memory", self.pointer, choose("IMAGE", format), byref(options), image, room, byref(size),
                 watch=watch)
            if size.value <= room:
                return image.raw[:size.value]
            room = size.value

    def save_stream(self, write_at: WriteAt, format: int | str = "png",
                    background: Sequence[float] | None = None) -> None:
        """The same by write_at(offset, bytes)."""
        watch = Watch(None)
        stream = write_stream(write_at, watch)
        call("frame_save_stream", self.pointer, choose("IMAGE", format), byref(stream),
             byref(self._image_options(False, background)), watch=watch)

    def _exr_options(self, overwrite: bool, frames_per_second: tuple[int, int] | None, exposure_seconds: float,
                     comments: str | None) -> _abi.ImageOptions:
        options = self._image_options(overwrite, None, comments=comments)
        if frames_per_second is not None:
            options.frames_per_second[:] = [*frames_per_second]
        options.exposure_seconds = exposure_seconds
        return options


class RenderOptions:
    """How pictures are drawn. surfaces: (value, opacity) or (value, opacity, linear RGB) of each isosurface, instead of
    iso_value. tile(x, y, width, height) hears of each rectangle of the frame that is final; True cancels. The others are as of
    bccsplat_render_options."""

    def __init__(self, *, mode: int | str | None = None, quality: int | str | None = None,
                 shading: int | str | None = None, preintegrate: int | str | None = None,
                 smooth_edges: int | str | None = None, backend: int | str | None = None,
                 iso_value: float | None = None,
                 gradient_noise: float | None = None, surfaces: Sequence[Sequence[Any]] = (),
                 progress: Progress | None = None, tile: Tile | None = None, cancel: CancelToken | None = None,
                 sheet_step: float = 0.0, opacity_stop: float = 0.0, depth_opacity: float = 0.0, deep_tolerance: float = 0.0,
                 tile_size: int = 0, reference: int = 0, disable_skips: int = 0) -> None:
        self.token = own_token(cancel)
        o = _abi.RenderOptions(mode=choose("MODE", mode), quality=choose("QUALITY", quality),
                               shading=choose("SHADING", shading),
                               preintegrate=choose("PREINTEGRATE", preintegrate),
                               smooth_edges=choose("SMOOTH_EDGES", smooth_edges),
                               backend=choose("BACKEND", backend), cancel_token=token_of(self.token),
                               sheet_step=sheet_step, opacity_stop=opacity_stop, depth_opacity=depth_opacity,
                               deep_tolerance=deep_tolerance, tile_size=tile_size, reference=reference,
                               disable_skips=disable_skips)
        if iso_value is not None:
            o.set_mask |= _abi.RENDER_SET_ISO
            o.iso_value = iso_value
        array = (_abi.IsoSurface * max(len(surfaces), 1))()
        for surface, (value, opacity, *color) in zip(array, surfaces):
            surface.value, surface.opacity = value, opacity
            if color:
                surface.color[:], surface.use_color = [*color[0]], 1
        o.surfaces, o.surface_count = array, len(surfaces)
        if gradient_noise is not None:
            o.set_mask |= _abi.RENDER_SET_GRADIENT_NOISE
            o.gradient_noise = gradient_noise
        self.watch = Watch(progress)
        o.progress = self.watch.function
        o.tile = self._tile_function(tile)
        self.struct, self._kept = o, array

    def _tile_function(self, tile: Tile | None) -> Any:
        def report(_user: int | None, x: int, y: int, width: int, height: int) -> int:
            try:
                with interrupt.host_code:
                    return 1 if tile is not None and tile(x, y, width, height) else 0
            except BaseException as error:  # comes out of the call, as that of a progress function
                self.watch.error = error
                return 1

        return _abi.bccsplat_tile_fn(report) if tile else _abi.bccsplat_tile_fn(0)


class View:
    """A camera, or a host's world_to_view and projection (4x4, for columns), with the host's opaque scene around.

    depth_range: "zero_one", "minus_one_one" or "reversed". depth: float32 [height, width], of a kind "device" (the default
    of matrices), "planar" (of cameras) or "ray". background: float32 [height, width, 4], linear and premultiplied.
    part: (x, y, width, height of the whole picture) of which the frame is a part, its first pixel at (x, y).
    """

    def __init__(self, camera: _abi.Camera | None = None, *, world_to_view: Any = None, projection: Any = None,
                 depth_range: int | str | None = None, y_down: bool = False, depth: Array | None = None,
                 depth_kind: int | str | None = None, background: Array | None = None,
                 part: tuple[int, int, int, int] | None = None) -> None:
        v = _abi.View(depth_range=choose("DEPTH_RANGE", depth_range), depth_kind=choose("DEPTH", depth_kind),
                      y_down=int(y_down))
        if (world_to_view is None) != (projection is None):
            raise ValueError("give both world_to_view and projection, or a camera")
        if projection is not None:
            v.use_matrices = 1
            v.world_to_view[:] = np.asarray(world_to_view, np.float64).reshape(16).tolist()
            v.projection[:] = np.asarray(projection, np.float64).reshape(16).tolist()
        if camera is not None:
            v.camera = camera
        if part is not None:
            v.region_begin[:], v.picture_size[:] = [*part[:2]], [*part[2:]]
        planes = [None if p is None else np.ascontiguousarray(p, np.float32) for p in (depth, background)]
        for plane, shape in zip(planes, (2, 3)):
            if plane is not None and plane.ndim != shape:
                raise ValueError("depth is [height, width], background [height, width, 4]")
        v.depth, v.background = planes
        self.struct, self.planes = v, planes

    def check(self, width: int, height: int) -> None:
        """That the planes are as large as a frame."""
        for plane, shape in zip(self.planes, ((height, width), (height, width, 4))):
            if plane is not None and plane.shape != shape:
                raise ValueError("a plane of shape %s for a frame of %s" % (plane.shape, shape))

    def project(self, points: Any, width: int, height: int) -> Array:
        """[n, 3] points of the world to pixel coordinates and distance along the view direction."""
        return self._points("view_project", points, width, height)

    def unproject(self, pixels: Any, width: int, height: int) -> Array:
        """The way back."""
        return self._points("view_unproject", pixels, width, height)

    def _points(self, function: str, points: Any, width: int, height: int) -> Array:
        given = np.ascontiguousarray(points, np.float64).reshape(-1, 3)
        out = np.empty_like(given)
        call(function, byref(self.struct), width, height, len(given), given.ctypes.data, out.ctypes.data)
        return out


def lights_struct(lights: Sequence[tuple[Sequence[float], Sequence[float]]], ambient: float, diffuse: float,
                  specular: float, shininess: float, shadow: bool = False, occlusion: bool = False) -> _abi.Lights:
    array = (_abi.Light * max(len(lights), 1))()
    for light, (direction, color) in zip(array, lights):
        light.direction[:], light.color[:] = [*direction], [*color]
    return _abi.Lights(count=len(lights), lights=array, ambient=ambient, diffuse=diffuse, specular=specular,
                       shininess=shininess, shadow=int(shadow), occlusion=int(occlusion))


def box_clips(box_to_world: Any) -> list[tuple[float, float, float, float]]:
    """The half-spaces (a, b, c, d) of a box: what a 4x4 affine takes the cube [0, 1]^3 to."""
    matrix = np.ascontiguousarray(box_to_world, np.float64).reshape(16)
    faces = (_abi.Clip * 6)()
    call("make_box_clips", matrix.ctypes.data, faces)
    return [(f.normal[0], f.normal[1], f.normal[2], f.offset) for f in faces]


def clip_array(clips: Sequence[Any]) -> Any:
    """Half-spaces a x + b y + c z + d >= 0 as (a, b, c, d), or as Clip structs."""
    array = (_abi.Clip * max(len(clips), 1))()
    for n, clip in enumerate(clips):
        if isinstance(clip, _abi.Clip):
            array[n] = clip
        else:
            array[n].normal[:], array[n].offset = [*clip[:3]], clip[3]
    return array


def trail_struct(interval: Sequence[float], *, content: int | str | None = None, combine: int | str | None = None,
                 samples: int = 0, intervals: int = 0, transfer_function: TransferFunction | None = None,
                 colors: Any = None, transfer_functions: Sequence[TransferFunction] = (),
                 weights: Sequence[float] = (), unlit: bool = False) -> _abi.Trail:
    """A trail over an interval of frames relative to a slice.

    transfer_functions: one for each sub-interval, the earliest first, which there are then as many of; so are weights,
    the curve of a shutter. unlit: whatever the slice is.
    """
    for given, what in ((transfer_functions, "transfer functions"), (weights, "weights")):
        if len(given):
            if intervals not in (0, len(given)):
                raise ValueError(f"{len(given)} {what} for {intervals} sub-intervals")
            intervals = len(given)
    trail = _abi.Trail(content=choose("TRAIL", content), samples=samples, intervals=intervals, unlit=int(unlit))
    trail.combine = choose("TRAIL", combine)
    trail.interval[:] = [*interval]
    if transfer_function is not None:
        trail.transfer_function = transfer_function.struct()
    if transfer_functions:
        trail.transfer_functions = [f.struct() for f in transfer_functions]
    if colors is not None:
        trail.colors = np.asarray(colors, np.float64).reshape(max(intervals, 1), 3)
    if len(weights):
        trail.weights = weights
    return trail


class Renderer(Child):
    """Draws a slice into frames. What is not set stays at the defaults of the header."""

    _kind = "renderer"

    def __init__(self, device: Device) -> None:
        super().__init__(device)
        self._watch, self._slice = Watch(None), None
        self._made: RenderOptions | None = None
        self._create("renderer_create", device.pointer)
        self.set_options()

    def set_slice(self, cut: Slice | None) -> None:
        """What is drawn; None: nothing."""
        call("renderer_set_slice", self.pointer, pointer_of(cut))
        self._slice = cut.share() if cut else None  # and with it what the volume borrows from Python

    _slice: Slice | None

    def set_trail(self, interval: tuple[float, float] | None, *, content: int | str | None = None,
                  combine: int | str | None = None, samples: int = 0, intervals: int = 0,
                  transfer_function: TransferFunction | None = None, colors: Any = None,
                  transfer_functions: Sequence[TransferFunction] = (), weights: Sequence[float] = (),
                  unlit: bool = False) -> None:
        """3.5D motion blur over an interval of frames relative to the slice, as of trail_struct; None: no trail."""
        if interval is None:
            call("renderer_set_trail", self.pointer, None)
            return
        trail = trail_struct(interval, content=content, combine=combine, samples=samples, intervals=intervals,
                             transfer_function=transfer_function, colors=colors, transfer_functions=transfer_functions,
                             weights=weights, unlit=unlit)
        call("renderer_set_trail", self.pointer, byref(trail))

    def set_camera(self, camera: _abi.Camera | None) -> None:
        """Such as from Slice.fit_camera or look_at; None: the default view."""
        call("renderer_set_camera", self.pointer, None if camera is None else byref(camera))

    def set_view(self, view: View | None) -> None:
        """A camera or matrices, depths and a background; None: the default view."""
        call("renderer_set_view", self.pointer, None if view is None else byref(view.struct))
        self._view = view  # whose planes are borrowed

    _view: View | None = None

    def set_clips(self, clips: Sequence[Any]) -> None:
        """Half-spaces of the world that are kept, (a, b, c, d) with a x + b y + c z + d >= 0 each."""
        call("renderer_set_clips", self.pointer, clip_array(clips), len(clips))

    def set_transfer_function(self, function: TransferFunction | None) -> None:
        """Colours and opacities; None: by the histogram of the file."""
        if function is not None and not isinstance(function, TransferFunction):
            raise TypeError("a TransferFunction is wanted, not %r" % (function,))
        struct = None if function is None else function.struct()
        call("renderer_set_transfer_function", self.pointer, None if struct is None else byref(struct))

    def set_lights(self, lights: Sequence[tuple[Sequence[float], Sequence[float]]] = (), *, ambient: float = 0.0,
                   diffuse: float = 0.0, specular: float = 0.0, shininess: float = 0.0, shadow: bool = False,
                   occlusion: bool = False) -> None:
        """lights: (direction towards the light, linear RGB), at most 8. shadow, occlusion: the volume stands in the way of
        them, and of ambient light."""
        call("renderer_set_lights", self.pointer,
             byref(lights_struct(lights, ambient, diffuse, specular, shininess, shadow, occlusion)))

    def set_options(self, *, mode: int | str | None = None, quality: int | str | None = None,
                    shading: int | str | None = None, preintegrate: int | str | None = None,
                    smooth_edges: int | str | None = None, backend: int | str | None = None,
                    iso_value: float | None = None, gradient_noise: float | None = None,
                    surfaces: Sequence[Sequence[Any]] = (), progress: Progress | None = None, tile: Tile | None = None,
                    cancel: CancelToken | None = None, sheet_step: float = 0.0, opacity_stop: float = 0.0,
                    depth_opacity: float = 0.0, deep_tolerance: float = 0.0, tile_size: int = 0, reference: int = 0,
                    disable_skips: int = 0) -> None:
        """As RenderOptions."""
        made = RenderOptions(mode=mode, quality=quality, shading=shading, preintegrate=preintegrate,
                             smooth_edges=smooth_edges, backend=backend, iso_value=iso_value,
                             gradient_noise=gradient_noise, surfaces=surfaces, progress=progress, tile=tile, cancel=cancel,
                             sheet_step=sheet_step, opacity_stop=opacity_stop, depth_opacity=depth_opacity,
                             deep_tolerance=deep_tolerance, tile_size=tile_size, reference=reference,
                             disable_skips=disable_skips)
        call("renderer_set_options", self.pointer, byref(made.struct))
        self._watch = made.watch  # the one before is of no use to the library any more
        self._made, self._pointer.token = made, made.token  # with the function of tiles

    def render(self, frame: Frame) -> None:
        """Draws into the frame; Error WRONG_STATE without a slice."""
        if self._view is not None:
            self._view.check(*frame.size)
        call("renderer_render", self.pointer, frame.pointer, watch=self._watch)

    def cancel(self) -> None:
        """Ends the render under way in another thread; it raises Cancelled there."""
        call("renderer_cancel", self.pointer)

    def stats(self) -> _abi.RenderStats:
        """Of the last render: milliseconds, points, what was skipped."""
        stats = _abi.RenderStats()
        call("renderer_get_stats", self.pointer, byref(stats))
        return stats
