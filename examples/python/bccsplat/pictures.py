"""Pictures and planes that a notebook and matplotlib show."""
from __future__ import annotations

import os
from typing import Any, Callable, Sequence, Union

import numpy as np

from . import _abi
from ._library import Progress
from .arrays import Array
from .cameras import fit_camera
from .cancel import CancelToken
from .field_array import FieldArray
from .places import Places, even_step
from .render import Frame, Renderer, Tile, TransferFunction, background_of
from .slices import Slice
from .volume import Volume

_PLANES = {"x": (2, ("y", "z")), "y": (1, ("x", "z")), "z": (0, ("x", "y"))}


class Picture:
    """A drawn picture; a notebook shows it by itself.

    pixels: [height, width, 4], uint8, sRGB with straight opacity, row 0 on top.
    """

    def __init__(self, frame: Frame, background: Sequence[float] | None = None) -> None:
        self.frame, self.background = frame, background_of(background)

    @property
    def pixels(self) -> Array:
        """[height, width, 4], uint8, sRGB; transparent where nothing is."""
        return self.frame.copy("srgb8")

    def __array__(self, dtype: Any = None, copy: bool | None = None) -> Array:
        return np.asarray(self.pixels, dtype)

    def _repr_png_(self) -> bytes:
        return self.frame.to_bytes("png", self.background)

    def save(self, path: Union[str, "os.PathLike[str]"], *, overwrite: bool = False) -> None:
        """Writes it as PNG, over the background it was made with. overwrite: an existing file is replaced."""
        if not os.fspath(path).lower().endswith(".png"):
            raise ValueError("pictures are written as PNG: %r must end in .png; other programs take `pixels`" %
                             os.fspath(path))
        self.frame.save_png(path, overwrite=overwrite, background=self.background)


def draw(cut: Slice, width: int = 512, height: int = 512, *, transfer_function: TransferFunction | None = None,
         look: int | str | None = None, rotate_x: float = 20, rotate_y: float = 30,
         background: Sequence[float] | None = (0, 0, 0), mode: int | str | None = None, quality: int | str | None = None,
         shading: int | str | None = None, preintegrate: int | str | None = None, smooth_edges: int | str | None = None,
         backend: int | str | None = None, iso_value: float | None = None, gradient_noise: float | None = None,
         surfaces: Sequence[Sequence[Any]] = (), progress: Progress | None = None, tile: Tile | None = None,
         cancel: CancelToken | None = None, sheet_step: float = 0.0, opacity_stop: float = 0.0, depth_opacity: float = 0.0,
         tile_size: int = 0, reference: int = 0, disable_skips: int = 0) -> Picture:
    """A picture of a slice, width x height pixels, filled by what is seen, from the front (of a patient the face) turned
    by angles in degrees.

    transfer_function: None, that of `look` ("ct-bone" ...), or of the file's histogram. background: linear RGB, or None
    for a transparent picture. The rest is as of RenderOptions, such as mode="maximum" or quality="draft".
    """
    if not (width >= 1 and height >= 1):
        raise ValueError("a picture has a width and a height of 1 and more pixels, not %r x %r" % (width, height))
    renderer = Renderer(cut.device)
    renderer.set_slice(cut)
    if transfer_function is None and look is not None:
        transfer_function = TransferFunction.of(cut.look(look, mode))
    renderer.set_transfer_function(transfer_function)
    renderer.set_camera(fit_camera(cut.seen_bounds(transfer_function), width, height, rotate_x=rotate_x, rotate_y=rotate_y,
                                   side=cut.volume.side()))
    renderer.set_options(mode=mode, quality=quality, shading=shading, preintegrate=preintegrate, smooth_edges=smooth_edges,
                         backend=backend, iso_value=iso_value, gradient_noise=gradient_noise, surfaces=surfaces,
                         progress=progress, tile=tile, cancel=cancel, sheet_step=sheet_step, opacity_stop=opacity_stop,
                         depth_opacity=depth_opacity, tile_size=tile_size, reference=reference, disable_skips=disable_skips)
    frame = Frame(cut.device, width, height)
    renderer.render(frame)
    return Picture(frame, background)


def draw_layout(cut: Slice, channel: int, frame: float, layout: int, chosen: bool, width: int | None, height: int | None,
                transfer_function: TransferFunction | None, look: int | str | None, of_volume: Callable[[int, int], Picture],
                background: Sequence[float] | None) -> Picture:
    """The picture of Volume.show. chosen: planes are wanted, and not only usual, which they are where there is room."""
    from . import plane_sheet
    columns, rows = {_abi.LAYOUT_BOTH: (2, 2), _abi.LAYOUT_PLANES: (3, 1)}.get(layout, (1, 1))
    w, h = 512 * columns if width is None else width, 512 * rows if height is None else height
    if layout in (0, _abi.LAYOUT_VOLUME):
        return of_volume(w, h)
    pane = plane_sheet.panes_of(layout, w, h)[0]
    if min(part.stop - part.start for part in pane) < plane_sheet.LEAST_PANE:
        if chosen:
            raise ValueError("a picture of %d x %d pixels has no room for planes and their letters; each has %d x %d or more" %
                             (w, h, plane_sheet.LEAST_PANE, plane_sheet.LEAST_PANE))
        return of_volume(w, h)
    function = transfer_function or TransferFunction.of(cut.volume.look(channel, look))
    pixels = plane_sheet.sheet(cut.volume, frame, channel, layout, w, h, np.array(function.colors, np.float64),
                               lambda: cut.seen_bounds(transfer_function),
                               lambda width, height: of_volume(width, height).frame.channel(Frame.RGBA))
    return Picture(Frame.wrap(cut.device, pixels), background)


class Plane:
    """A plane of samples with its coordinates.

    values: [rows, columns], float32; rows run along the second axis of `axes`. coordinates: of the samples along the
    columns and along the rows, float64, in `units`. extent: (left, right, bottom, top) of the borders of the samples.
    """

    def __init__(self, values: Array, axes: tuple[str, str], coordinates: tuple[Array, Array], units: tuple[str, str],
                 title: str) -> None:
        self.values, self.axes, self.coordinates, self.units, self.title = values, axes, coordinates, units, title

    @property
    def unit(self) -> str:
        """Of both axes; "" where they differ or are not known."""
        return self.units[0] if self.units[0] == self.units[1] else ""

    def __array__(self, dtype: Any = None, copy: bool | None = None) -> Array:
        return np.asarray(self.values, dtype)

    def __repr__(self) -> str:
        return "<bccsplat.Plane [%s, %s] = %r: %s>" % (*self.axes[::-1], self.values.shape, self.title)

    @property
    def extent(self) -> tuple[float, float, float, float]:
        """As matplotlib's imshow takes it with origin="lower"."""
        ends: list[float] = []
        for at in self.coordinates:
            first, last = (at[1] - at[0], at[-1] - at[-2]) if len(at) > 1 else (1.0, 1.0)
            ends += [float(at[0] - first / 2), float(at[-1] + last / 2)]
        return ends[0], ends[1], ends[2], ends[3]

    def imshow(self, ax: Any = None, **options: Any) -> Any:
        """Draws it with matplotlib, with coordinates on its axes, and returns what that makes. ax: None, the current axes.
        options: those of imshow, such as cmap; of unevenly spaced samples those of pcolormesh."""
        if ax is None:
            from importlib import import_module
            ax = import_module("matplotlib.pyplot").gca()
        if all(len(at) < 2 or even_step(at) for at in self.coordinates):
            image = ax.imshow(self.values, **{"origin": "lower", "extent": self.extent, **options})
        else:
            image = ax.pcolormesh(*self.coordinates, self.values, **{"shading": "nearest", **options})
        for name, axis, unit in zip("xy", self.axes, self.units):
            getattr(ax, "set_%slabel" % name)(axis + (" (%s)" % unit if unit else ""))
        ax.set_title(self.title)
        return image


def plane_of(volume: Volume, frame: float, channel: int = 0, level: int = 0, **place: float) -> Plane:
    """The plane x, y or z = a number of samples (which may lie between two) at a frame number; see Volume.plane."""
    if len(place) != 1 or not set(place) <= set(_PLANES):
        raise ValueError("a plane is at one of x, y and z, in samples, such as volume.plane(z=12.5); given: %s" %
                         (", ".join(sorted(place)) or "none"))
    (name, index), = place.items()
    dropped, axes = _PLANES[name]
    last = volume.shape[1 + dropped] - 1
    if not 0 <= index <= last:
        raise ValueError("the plane %s = %g lies outside the samples, 0 to %d" % (name, index, last))
    field = FieldArray.whole(volume, channel, level)
    positions = [np.array([frame]), *field.axes[1:]]
    positions[1 + dropped] = np.array([index], np.float64)
    values = FieldArray(volume, positions, channel, level).read()[0]
    places = Places(volume)

    def world(axis: str) -> Array:
        number = "xyz".index(axis)
        return places.at(number, positions[3 - number])

    unit, *units = ["samples" if places.are_numbers(number) else places.unit(number)
                    for number in map("xyz".index, (name, *axes))]
    info, described = volume.info(), volume.channel_info(channel)
    title = "%s, %s = %g%s, t = %g %s" % (described.name, name, world(name)[0],
                                          " " + unit if unit else "", volume.index_to_time(frame),
                                          info.time_unit)
    return Plane(values.squeeze(dropped), axes, (world(axes[0]), world(axes[1])), (units[0], units[1]), title.rstrip())


def described(volume: Volume) -> dict[str, str]:
    """What a file holds, in words, line for line."""
    info = volume.info()
    nx, ny, nz, nt = info.dims[:]
    lattices = {_abi.LATTICE_D4STAR: "D4*", _abi.LATTICE_BCC: "BCC", _abi.LATTICE_CC: "Cartesian"}
    lines = {"samples": "%d x %d x %d, %d frames" % (nx, ny, nz, nt),
             "time": "%g to %g %s" % (info.time_first, info.time_last, info.time_unit),
             "lattice": "%s%s, kernel %s" % (lattices[info.lattice], ", wavelets" if info.store == _abi.STORE_WAVELETS else "",
                                             info.kernel),
             "file": "%d bytes, %.3g a sample" % (info.bytes_file, info.bytes_file / (info.cc_samples *
                                                                                      info.channel_count))}
    for n in range(info.channel_count):
        channel = volume.channel_info(n)
        name, unit = channel.name, channel.unit
        lines["channel " + name] = "%g to %g %s" % (channel.range[0], channel.range[1], unit)
    return {key: text.strip() for key, text in lines.items()}
