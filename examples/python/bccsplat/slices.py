"""Slice: a hyperplane of a volume, evaluated, sampled and seen."""
from __future__ import annotations

import ctypes
from ctypes import byref, c_uint64
from typing import TYPE_CHECKING, Any, Sequence

import numpy as np

from . import _abi
from ._library import Closed, Progress, Watch, call, choose
from .arrays import Array, corners_of, floats_of, points_of
from .cancel import CancelToken, own_token, token_of
from .device import Child
from .keywords import given

if TYPE_CHECKING:
    from .pictures import Picture
    from .render import Tile, TransferFunction
    from .volume import Volume


_BRICK_TYPES = {"uint8": "U8", "uint16": "U16", "float16": "F16", "float32": "F32"}


class Bricks:
    """Bricks of a slice, as Slice.bricks makes them.

        bricks.index     [cosets, k, j, i], uint32: 0 where a brick holds info.empty alone, else its place in values, + 1
        bricks.bounds    [cosets, k, j, i, 2]: no value of a brick is outside
        bricks.values    [n, w, v, u] of those that hold data, with borders
        bricks.info      place in slice space, scale and offset of codes, the kernel of sites
    """

    def __init__(self, cut: Slice, grid: int | str | None, dtype: Any, edge: int, border: int, spacing: float,
                 value_range: tuple[float, float]) -> None:
        kind = np.dtype(dtype)
        if kind.name not in _BRICK_TYPES:
            raise ValueError("bricks are of uint8, uint16, float16 or float32, not %s" % kind.name)
        options = _abi.BrickOptions(grid=choose("BRICK_GRID", grid), type=choose("TYPE", _BRICK_TYPES[kind.name]),
                                    edge=edge, border=border, spacing=spacing)
        options.range[:] = [*value_range]
        self.info = _abi.BrickInfo()
        call("slice_get_brick_info", cut.pointer, byref(options), byref(self.info))
        shape = (self.info.cosets, *self.info.bricks[::-1])
        self.index, self.bounds = np.empty(shape, np.uint32), np.empty((*shape, 2), np.float32)
        count = c_uint64()
        call("slice_find_bricks", cut.pointer, byref(options), self.index.ctypes.data, self.bounds.ctypes.data,
             byref(count))
        cells = np.flatnonzero(self.index).astype(np.uint32)
        self.values = np.empty((count.value, self.info.edge, self.info.edge, self.info.edge), kind)
        call("slice_get_bricks", cut.pointer, byref(options), cells.size, cells.ctypes.data, self.values.ctypes.data, None)


class Slice(Child):
    """The 3D field on the hyperplane a x + b y + c z + d t + e = 0 of index space; volume.slice makes one.

        cut = volume.slice(time=0.48)
        cut.sample_grid()                        # [z, y, x], as the source has it, or on a grid of yours
        cut.evaluate([[3.5, 4, 5.25]])           # values at points; with slopes: evaluate_with_gradients
        cut.show()                               # a picture
    """

    _kind = "slice"
    _made: tuple[str, tuple[Any, ...], dict[str, Any]]  # the method, its arguments and options, but for the volume

    def __reduce__(self) -> tuple[Any, ...]:
        """It is cut anew of the volume, which is opened where it is sent to."""
        return _cut_there, (self.volume, *self._made)

    def show(self, width: int = 512, height: int = 512, *, transfer_function: TransferFunction | None = None,
             look: int | str | None = None, rotate_x: float = 20, rotate_y: float = 30,
             background: Sequence[float] | None = (0, 0, 0), mode: int | str | None = None,
             quality: int | str | None = None, shading: int | str | None = None, preintegrate: int | str | None = None,
             smooth_edges: int | str | None = None, backend: int | str | None = None, iso_value: float | None = None,
             gradient_noise: float | None = None, surfaces: Sequence[Sequence[Any]] = (), progress: Progress | None = None,
             tile: Tile | None = None, cancel: CancelToken | None = None, sheet_step: float = 0.0,
             opacity_stop: float = 0.0, depth_opacity: float = 0.0, tile_size: int = 0, reference: int = 0,
             disable_skips: int = 0) -> Picture:
        """A picture of it, which a notebook shows, as of draw."""
        from .pictures import draw
        return draw(self, width, height, transfer_function=transfer_function, look=look, rotate_x=rotate_x,
                    rotate_y=rotate_y, background=background, mode=mode, quality=quality, shading=shading,
                    preintegrate=preintegrate, smooth_edges=smooth_edges, backend=backend, iso_value=iso_value,
                    gradient_noise=gradient_noise, surfaces=surfaces, progress=progress, tile=tile, cancel=cancel,
                    sheet_step=sheet_step, opacity_stop=opacity_stop, depth_opacity=depth_opacity, tile_size=tile_size,
                    reference=reference, disable_skips=disable_skips)

    def _repr_png_(self) -> bytes:
        return self.show(256, 256)._repr_png_()

    def __repr__(self) -> str:
        if isinstance(self.pointer, Closed):
            return "<bccsplat.Slice, closed>"
        return "<bccsplat.Slice [w, v, u] = %r>" % (tuple(self.info().dims[::-1]),)

    def __init__(self, volume: Volume, a: float, b: float, c: float, d: float, e: float, *, channel: int | str = 0,
                 kernel: str | None = None, interval: tuple[float, float] = (0.0, 0.0), spacing: float = 0.0,
                 time_length: float = 0.0, box: Any = None, space: str | None = None, progress: Progress | None = None,
                 cancel: CancelToken | None = None, lattice: int | str | None = None, level: int | None = None,
                 thickness: float | None = None, slab: int | str | None = None, method: int | str | None = None,
                 bandwidth: Sequence[float] | None = None, once: bool = False, motion: bool = False) -> None:
        """channel: number or name. box: ((x0, y0, z0), (x1, y1, z1)) in index units, of a time slice; None: all of it.
        space: "index" or "even", which pictures of volumes with unevenly spaced axes are made of. once: no other
        moment of this part of the series follows soon. motion: a time slice between two frames follows what moves.
        cancel: of making it and of what takes long with it."""
        super().__init__(volume.device)
        self.volume = volume
        number = volume.channel_number(channel)
        token = own_token(cancel)
        options = given(lattice=lattice, level=level, thickness=thickness, slab=slab, method=method,
                        bandwidth=None if bandwidth is None else tuple(bandwidth), once=once or None,
                        motion=_abi.MOTION_ON if motion else None)
        self._made = "Slice", (a, b, c, d, e), {"channel": number, "kernel": kernel, "interval": interval, "spacing": spacing,
                                                "time_length": time_length, "box": box, "space": space, **options, "motion": motion}
        o = self._options(number, kernel, interval, spacing, time_length, box, space, token, options)
        self._cut(byref(_abi.Hyperplane(a=a, b=b, c=c, d=d, e=e)), o, progress)

    @staticmethod
    def _options(channel: int, kernel: str | None, interval: tuple[float, float], spacing: float, time_length: float,
                 box: Any, space: str | None, cancel: CancelToken | None,
                 options: dict[str, Any]) -> _abi.SliceOptions:
        o = _abi.SliceOptions(channel=channel, kernel=kernel, spacing=spacing, time_length=time_length,
                              box=corners_of(box), cancel_token=token_of(cancel),
                              space=choose("SPACE", space), **options)
        o.interval[:] = [*interval]
        o.held = cancel  # an attribute of the Python object alone, as long as it looks into it
        return o

    def _cut(self, plane: Any, options: _abi.SliceOptions, progress: Progress | None) -> None:
        watch = Watch(progress)
        options.progress = watch.function
        self._create("slice_create", self.volume, plane, byref(options), watch=watch, token=options.held)

    @classmethod
    def at(cls, volume: Volume, frame: float, *, channel: int | str = 0, kernel: str | None = None,
           interval: tuple[float, float] = (0.0, 0.0), spacing: float = 0.0, time_length: float = 0.0, box: Any = None,
           space: str | None = None, progress: Progress | None = None, cancel: CancelToken | None = None,
           lattice: int | str | None = None, level: int | None = None, thickness: float | None = None,
           slab: int | str | None = None, method: int | str | None = None,
           bandwidth: Sequence[float] | None = None, once: bool = False, motion: bool = False) -> Slice:
        """The time slice at a frame number, which may be fractional."""
        return cls(volume, 0, 0, 0, 1, -frame, channel=channel, kernel=kernel, interval=interval, spacing=spacing,
                   time_length=time_length, box=box, space=space, progress=progress, cancel=cancel, lattice=lattice,
                   level=level, thickness=thickness, slab=slab, method=method, bandwidth=bandwidth, once=once,
                   motion=motion)

    @classmethod
    def at_time(cls, volume: Volume, time: float, *, channel: int | str = 0, kernel: str | None = None,
                interval: tuple[float, float] = (0.0, 0.0), spacing: float = 0.0, time_length: float = 0.0,
                box: Any = None, space: str | None = None, progress: Progress | None = None,
                cancel: CancelToken | None = None, lattice: int | str | None = None, level: int | None = None,
                thickness: float | None = None, slab: int | str | None = None, method: int | str | None = None,
                bandwidth: Sequence[float] | None = None, once: bool = False, motion: bool = False) -> Slice:
        """The time slice at a time in the file's unit."""
        cut = cls.__new__(cls)
        Child.__init__(cut, volume.device)
        cut.volume = volume
        number = volume.channel_number(channel)
        token = own_token(cancel)
        options = given(lattice=lattice, level=level, thickness=thickness, slab=slab, method=method,
                        bandwidth=None if bandwidth is None else tuple(bandwidth), once=once or None,
                        motion=_abi.MOTION_ON if motion else None)
        cut._made = "at_time", (time,), {"channel": number, "kernel": kernel, "interval": interval, "spacing": spacing,
                                         "time_length": time_length, "box": box, "space": space, **options, "motion": motion}
        o = cls._options(number, kernel, interval, spacing, time_length, box, space, token, options)
        watch = Watch(progress)
        o.progress = watch.function
        cut._create("volume_slice_at", volume, time, byref(o), watch=watch, token=token)
        return cut

    @classmethod
    def along(cls, volume: Volume, point: Any, basis: Any, *, channel: int | str = 0, kernel: str | None = None,
              progress: Progress | None = None, cancel: CancelToken | None = None,
              interval: tuple[float, float] = (0.0, 0.0), spacing: float = 0.0, lattice: int | str | None = None,
              level: int | None = None, thickness: float | None = None, slab: int | str | None = None,
              method: int | str | None = None, bandwidth: Sequence[float] | None = None, once: bool = False) -> Slice:
        """With an origin (x, y, z, t) and three directions [3, 4] of slice space in index space."""
        cut = cls.__new__(cls)
        Child.__init__(cut, volume.device)
        cut.volume = volume
        at = np.ascontiguousarray(point, np.float64).reshape(4)
        axes = np.ascontiguousarray(basis, np.float64).reshape(3, 4)
        number = volume.channel_number(channel)
        token = own_token(cancel)
        options = given(lattice=lattice, level=level, thickness=thickness, slab=slab, method=method,
                        bandwidth=None if bandwidth is None else tuple(bandwidth), once=once or None)
        cut._made = "along", (at, axes), {"channel": number, "kernel": kernel, "interval": interval, "spacing": spacing,
                                          **options}
        o = _abi.SliceOptions(channel=number, kernel=kernel, spacing=spacing, point=at, basis=axes,
                              cancel_token=token_of(token), **options)
        o.interval[:] = [*interval]
        o.held = token
        cut._cut(None, o, progress)
        return cut

    def info(self) -> _abi.SliceInfo:
        """Lattice, place in index space and the world, extent, bounds of the values, bytes read, milliseconds."""
        info = _abi.SliceInfo()
        call("slice_get_info", self.pointer, byref(info))
        return info

    def look(self, look: int | str | None = None, mode: int | str | None = None) -> _abi.Look:
        """A transfer function for the slice: of a time slice the volume's, of others by the values that they hold."""
        made = _abi.Look()
        call("slice_get_look", self.pointer, choose("LOOK", look), choose("MODE", mode), byref(made))
        return made

    def evaluate(self, points: Any, out: Array | None = None) -> Array:
        """Values at points [..., 3] of slice space; failures as of Volume.evaluate."""
        at = points_of(points, 3)
        values = floats_of(out, at.shape[:-1])
        call("slice_evaluate", self.pointer, values.size, at.ctypes.data, values.ctypes.data, None)
        return values

    def evaluate_with_gradients(self, points: Any) -> tuple[Array, Array]:
        """Values [...], float32, at points [..., 3], and their slopes [..., 3] along u, v, w per unit of slice space."""
        at = points_of(points, 3)
        values, slopes = np.empty(at.shape[:-1], np.float32), np.empty(at.shape, np.float32)
        call("slice_evaluate", self.pointer, values.size, at.ctypes.data, values.ctypes.data, slopes.ctypes.data)
        return values, slopes

    def pick(self, origin: Sequence[float], direction: Sequence[float], what: int | str = "value", threshold: float = 0.0, *,
             begin: float = 0.0, end: float = 0.0, transfer_function: Any = None) -> _abi.Hit | None:
        """What a ray of the world meets; None: nothing. what: "value", where the field first passes the threshold;
        "maximum"; "opacity", where that along the ray reaches the threshold. begin, end: distances from the origin;
        both 0: to the end of the domain. The ray of a pixel goes through two points of View.unproject."""
        ray, hit = _abi.Ray(pick=choose("PICK", what), threshold=threshold, begin=begin, end=end), _abi.Hit()
        ray.origin[:], ray.direction[:] = [*origin], [*direction]
        function = None if transfer_function is None else transfer_function.struct()
        if function is not None:
            ray.transfer_function = ctypes.pointer(function)
        call("slice_pick", self.pointer, byref(ray), byref(hit))
        return hit if hit.found else None

    def sample_grid(self, origin: Sequence[float] | None = None, step: Sequence[float] = (1, 1, 1),
                    dims: Sequence[int] | None = None, out: Array | None = None) -> Array:
        """A dense box indexed [w, v, u] ([z, y, x] of a time slice), by default at the source's own resolution.
        dims: samples along u, v, w. NaN outside the domain and in holes."""
        if (origin is None) != (dims is None) or (dims is None and tuple(step) != (1, 1, 1)):
            raise ValueError("origin and dims belong together, and a step to them")
        grid = None
        if origin is not None and dims is not None:
            grid = _abi.Grid()
            grid.origin[:], grid.step[:], grid.dims[:] = [*origin], [*step], [*dims]
        nu, nv, nw = dims or self.info().dims[:]
        values = floats_of(out, (nw, nv, nu))
        call("slice_sample_grid", self.pointer, None if grid is None else byref(grid), values.ctypes.data)
        return values

    def points(self) -> tuple[Array, Array]:
        """The lattice points: positions [n, 3] in slice space and coefficients [n] relative to air."""
        count = c_uint64()
        call("slice_get_points", self.pointer, 0, None, None, byref(count))
        uvw, coefficients = np.empty((count.value, 3), np.float32), np.empty(count.value, np.float32)
        call("slice_get_points", self.pointer, count.value, uvw.ctypes.data, coefficients.ctypes.data, None)
        return uvw, coefficients

    def bricks(self, grid: int | str | None = None, dtype: Any = np.float32, edge: int = 32, border: int = 1,
               spacing: float = 0.0, value_range: tuple[float, float] = (0.0, 0.0)) -> Bricks:
        """The slice as bricks for textures: of edge samples with a border on each side, those that hold data.
        grid: "samples", of the field on a Cartesian grid at most spacing apart (0: 1), or "sites", what the field is
        made of. dtype: uint8, uint16, float16 or float32; value_range: what the codes of integers span; both 0: all."""
        return Bricks(self, grid, dtype, edge, border, spacing, value_range)

    def fit_camera(self, width: int, height: int, rotate_x: float = 20, rotate_y: float = 30,
                   projection: int | str | None = None) -> _abi.Camera:
        """A view of the whole slice, turned by angles in degrees."""
        camera = _abi.Camera()
        call("slice_fit_camera", self.pointer, choose("PROJECTION", projection), rotate_x, rotate_y, width, height,
             byref(camera))
        return camera

    def seen_bounds(self, transfer_function: Any = None) -> tuple[float, ...]:
        """The box of the world, x0 y0 z0 x1 y1 z1, around what a TransferFunction shows of the slice; None: the
        default look."""
        bounds = (ctypes.c_double * 6)()
        struct = None if transfer_function is None else transfer_function.struct()
        call("slice_get_seen_bounds", self.pointer, None if struct is None else byref(struct), bounds)
        return tuple(bounds)

    def view_needs(self, view: Any, width: int, height: int, clips: Any = None, *, mode: int | str | None = None,
                   quality: int | str | None = None) -> _abi.PictureNeeds:
        """What a picture by a View (None: the default one) needs: see picture_needs. clips: an array of Clip structs."""
        needs = _abi.PictureNeeds()
        options = _abi.RenderOptions(mode=choose("MODE", mode), quality=choose("QUALITY", quality))
        call("slice_get_view_needs", self.pointer, None if view is None else byref(view.struct), clips,
             0 if clips is None else len(clips), width, height, byref(options), byref(needs))
        return needs

    def picture_needs(self, camera: _abi.Camera, width: int, height: int, *, mode: int | str | None = None,
                      quality: int | str | None = None) -> _abi.PictureNeeds:
        """The level and the box that a picture of this time slice needs, told by a slice of any level."""
        needs = _abi.PictureNeeds()
        options = _abi.RenderOptions(mode=choose("MODE", mode), quality=choose("QUALITY", quality))
        call("slice_get_picture_needs", self.pointer, byref(camera), width, height, byref(options), byref(needs))
        return needs


def _cut_there(volume: Volume, method: str, arguments: tuple[Any, ...], options: dict[str, Any]) -> Slice:
    """A slice that was sent to this process."""
    made: Slice = (Slice if method == "Slice" else getattr(Slice, method))(volume, *arguments, **options)
    return made
