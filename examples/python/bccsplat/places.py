"""Places: where the samples of a volume stand along x, y and z. All coordinates that Python shows or takes come from here."""
from __future__ import annotations

from typing import Any

import numpy as np

from . import records
from .arrays import Array
from .volume import Volume


def is_along_axes(affine: Array) -> bool:
    """Whether x, y and z of the samples are those of the world, in either direction."""
    return bool(np.count_nonzero(affine[:3, :3]) == 3 and np.diag(affine)[:3].all())


# Share of the distance of samples by which evenly spaced ones may be elsewhere.
_EVEN = 1e-3


def even_step(at: Array) -> float | None:
    """The distance of evenly spaced coordinates [n], n > 1, which may fall; None: they are not evenly spaced."""
    step = float(at[-1] - at[0]) / (len(at) - 1)
    off = np.abs(at - (at[0] + step * np.arange(len(at)))).max()
    return step if step and off <= _EVEN * abs(step) else None


class Places:
    """Coordinates of a volume's samples: along an unevenly spaced axis those of Volume.axis, monotone cubic between samples;
    along an even one the place in the world, or, of axes that lie oblique in it, the sample's number. Where an axis counts
    down, as depths do, so do its coordinates."""

    def __init__(self, volume: Volume) -> None:
        info = volume.info()
        self._volume, self.affine = volume, np.array(info.affine[:], np.float64).reshape(4, 4)
        self._axes = [volume.axis(axis) for axis in range(3)]
        self._along, self._unit = is_along_axes(self.affine), info.spatial_unit
        attributes = volume.attributes()
        self.records = [records.read(attributes, "axis." + name) for name in "xyz"]

    def is_even(self, axis: int) -> bool:
        """Whether the axis, 0, 1 or 2 of x, y and z, is evenly spaced."""
        return not self._axes[axis][0].size

    def are_numbers(self, axis: int) -> bool:
        """Whether the coordinates are numbers of samples, and not places."""
        return self.is_even(axis) and not self._along

    def is_down(self, axis: int) -> bool:
        """Whether the coordinates count against the axis of the world."""
        told = self._axes[axis][2] or self.records[axis].get("positive") == "down"
        return told and not self.are_numbers(axis)

    def unit(self, axis: int) -> str:
        """Of the coordinates; "" where it is not known, or these are numbers of samples."""
        if self.are_numbers(axis):
            return ""
        return str(self.records[axis].get("units", "")) or self._axes[axis][1] or self._unit

    def at(self, axis: int, samples: Any) -> Array:
        """Coordinates [n] of positions [n] in samples, which may lie between these."""
        at = np.asarray(samples, np.float64)
        if self.are_numbers(axis):
            return at
        if not self.is_even(axis):
            known, points = self._axes[axis][0], np.zeros((at.size, 3))
            points[:, axis] = at.reshape(-1)
            world = self._volume.index_to_world(points) - self.affine[:3, 3]
            even = np.linalg.solve(self.affine[:3, :3], world.T)[axis].reshape(at.shape)
            whole = np.rint(at).astype(np.int64).clip(0, known.size - 1)
            return np.where(at == whole, known[whole], known[0] + even / (known.size - 1) * (known[-1] - known[0]))
        sign = -1.0 if self.is_down(axis) else 1.0
        return np.asarray(sign * (self.affine[axis, axis] * at + self.affine[axis, 3]) + 0.0)  # not -0

    def samples(self, axis: int, coordinates: Any) -> Array:
        """Positions in samples of coordinates: the way back. What is a sample but for rounding is it."""
        at = np.asarray(coordinates, np.float64)
        if self.are_numbers(axis):
            return at
        if self.is_even(axis):
            sign = -1.0 if self.is_down(axis) else 1.0
            found = (sign * at - self.affine[axis, 3]) / self.affine[axis, axis]
        else:
            known = self._axes[axis][0]
            even = (at - known[0]) / (known[-1] - known[0]) * (known.size - 1)
            with np.errstate(invalid="ignore"):  # places that are NaN or infinite stay no samples
                world = self.affine[:3, axis] * even.reshape(-1, 1) + self.affine[:3, 3]
            found = self._volume.world_to_index(world)[:, axis].reshape(at.shape)
        whole = np.rint(found)
        return np.where(np.abs(found - whole) < 1e-9 * (1 + np.abs(whole)), whole, found)
