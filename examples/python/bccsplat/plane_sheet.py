"""Three planes through a moment, or a map's one, as a picture, with the letters of their sides; beside them a volume's."""
from __future__ import annotations

from typing import Callable, Sequence

import numpy as np

from . import _abi
from .arrays import Array
from .pictures import plane_of
from .volume import Volume

LEAST_PANE = 96  # pixels a side, which letters have room in
_MARGIN = .02  # of a pane, around a plane

# Letters of 5 x 7 points, a number of five bits for each row.
_LETTERS = {"L": (16, 16, 16, 16, 16, 16, 31), "R": (30, 17, 17, 30, 20, 18, 17), "A": (14, 17, 17, 31, 17, 17, 17),
            "P": (30, 17, 17, 30, 16, 16, 16), "S": (15, 16, 16, 14, 1, 1, 30), "I": (14, 4, 4, 4, 4, 4, 14),
            "x": (0, 0, 17, 10, 4, 10, 17), "y": (0, 0, 17, 17, 15, 1, 14), "z": (0, 0, 31, 2, 4, 8, 31)}
# What the lower and the higher ends of the world's axes are called.
_NAMES = {_abi.SIDE_ANTERIOR_RAS: ("LR", "PA", "IS"), _abi.SIDE_ANTERIOR_LPS: ("RL", "AP", "IS")}

# An axis of the samples in a picture: its number, whether it runs against the picture, and the letters of its ends.
Side = tuple[int, bool, str, str]


def plane_sides(volume: Volume) -> list[tuple[Side, Side]]:
    """To the right and up, of the coronal, the sagittal and the axial plane, or x z, y z and x y of a world without sides. As
    radiologists have them: the patient's left is on the right, front and head are up, in the sagittal plane the front is on
    the left. Axes aslant to the world have the letters of the sides that they are nearest to."""
    from itertools import permutations
    linear = np.array(volume.info().affine[:], np.float64).reshape(4, 4)[:3, :3]
    share = np.abs(linear) / np.linalg.norm(linear, axis=0)
    axes = max(permutations(range(3)), key=lambda order: float(share[range(3), order].sum()))
    names = _NAMES.get(volume.side(), (" x", " y", " z"))

    def along(world: int, wanted: str) -> Side:
        back = wanted in names[world][:1]
        ends = names[world]
        low, high = (ends[1], ends[0]) if back else (ends[0], ends[1])
        return axes[world], bool(linear[world, axes[world]] < 0) != back, low.strip(), high.strip()

    return [(along(0, "L"), along(2, "S")), (along(1, "P"), along(2, "S")), (along(0, "L"), along(1, "A"))]


def panes_of(layout: int, width: int, height: int) -> list[tuple[slice, slice]]:
    """Rows and columns of the parts of a picture: three planes, the volume as the fourth with LAYOUT_BOTH, or a map's plane."""
    columns, rows = {_abi.LAYOUT_BOTH: (2, 2), _abi.LAYOUT_PLANES: (3, 1)}.get(layout, (1, 1))
    gap = max(2, min(width, height) // 100)
    w, h = (width - gap * (columns - 1)) // columns, (height - gap * (rows - 1)) // rows
    return [(slice(r * (h + gap), r * (h + gap) + h), slice(c * (w + gap), c * (w + gap) + w)) for r in range(rows)
            for c in range(columns)]


def _weights(edges: tuple[float, float], places: Array, pixels: int, falls: bool, nearest: bool) -> tuple[Array, Array]:
    """What each of the pixels along an axis has of each sample [pixels, samples], and the samples that are nearest to them."""
    border = np.linspace(edges[0], edges[1], pixels + 1)
    if falls:
        border = border[::-1]
    numbers = np.arange(len(places), dtype=np.float64)
    at = np.interp((border[1:] + border[:-1]) / 2, places, numbers)
    reach = np.maximum(1.0, np.abs(np.diff(np.interp(border, places, numbers))))
    closest = np.rint(at).astype(np.int64)
    if nearest:
        return np.eye(len(places))[closest], closest
    weights = np.maximum(0.0, 1 - np.abs(numbers - at[:, None]) / reach[:, None])
    return weights / weights.sum(1, keepdims=True), closest


def _write(pixels: Array, letter: str, x: float, y: float, scale: int) -> None:
    """A white letter in a dark field, its middle at x and y."""
    bits = np.array([[row >> (4 - i) & 1 for i in range(5)] for row in _LETTERS[letter]], np.float32)
    field = np.pad(bits, 1).repeat(scale, 0).repeat(scale, 1)
    top, left = int(y - field.shape[0] / 2), int(x - field.shape[1] / 2)
    part = pixels[top:top + field.shape[0], left:left + field.shape[1]]
    part[..., :3] = np.maximum(.3 * part[..., :3], field[..., None])
    part[..., 3] = 1


def _colored(values: Array, colors: Array, labels: bool) -> Array:
    """Linear RGB of values. Greys of a display rise as the values do, from the first to the last that has a colour."""
    if labels or (colors[:, 1:] != colors[:, 1:2]).any():
        return np.stack([np.interp(values, colors[:, 0], colors[:, i]) for i in (1, 2, 3)], -1)
    low, high = colors[0, 0], colors[-1, 0]
    grey = np.clip((values - low) / (high - low), 0, 1) if high > low else np.ones_like(values)
    return np.where(grey <= .04045, grey / 12.92, ((grey + .055) / 1.055) ** 2.4)[..., None].repeat(3, -1)


def _ground(volume: Volume, axis: int) -> int:
    """The level of a map nearest to the ground: of heights and depths that nearest to 0, of pressures the highest."""
    from .places import Places
    last = volume.shape[3 - axis] - 1
    places = Places(volume)
    first, other = np.abs(places.at(axis, np.array([0.0, last])))
    pressure = any(word in places.unit(axis) for word in ("Pa", "bar"))
    return 0 if (first <= other) != pressure else last


def sheet(volume: Volume, frame: float, channel: int, layout: int, width: int, height: int, colors: Array,
          bounds: Callable[[], Sequence[float]], draw_volume: Callable[[int, int], Array]) -> Array:
    """The picture [height, width, 4], linear and premultiplied. colors: value and linear RGB. bounds: the box of the world
    around what is seen, through whose middle the planes go. draw_volume: of that width and height."""
    panes, sides = panes_of(layout, width, height), plane_sides(volume)
    out = np.zeros((height, width, 4), np.float32)
    if layout == _abi.LAYOUT_BOTH:
        rows, columns = panes.pop()
        out[rows, columns] = draw_volume(columns.stop - columns.start, rows.stop - rows.start)
    shape = volume.shape[:0:-1]
    if layout == _abi.LAYOUT_FLAT:
        sides, at = sides[2:], [0, 0, 0]
        across = 3 - sides[0][0][0] - sides[0][1][0]
        at[across] = _ground(volume, across)
    else:
        box = np.array(bounds()).reshape(2, 3)
        at = np.rint(volume.world_to_index(box.mean(0))).clip(0, np.array(shape) - 1).astype(int).tolist()
    affine = np.array(volume.info().affine[:], np.float64).reshape(4, 4)
    steps = np.linalg.norm(affine[:3, :3], axis=0)
    places, edges = [], []
    for axis in range(3):  # in even positions, as the affine has them
        numbers = np.zeros((shape[axis], 3))
        numbers[:, axis] = np.arange(shape[axis])
        even = (volume.index_to_world(numbers) - affine[:3, 3]) @ np.linalg.inv(affine[:3, :3]).T
        places.append(even[:, axis])
        half = 0 if volume.axis(axis)[0].size and shape[axis] > 1 else .5
        edges.append((float(even[0, axis]) - half, float(even[-1, axis]) + half))
    lengths = [(edges[axis][1] - edges[axis][0]) * steps[axis] for axis in range(3)]
    w, h = (part.stop - part.start for part in reversed(panes[0]))
    length = max(max(lengths[right[0]] / w, lengths[up[0]] / h) for right, up in sides) / (1 - 2 * _MARGIN)
    labels = bool(volume.channel_info(channel).labels)
    for (rows, columns), (right, up) in zip(panes, sides):
        across = 3 - right[0] - up[0]
        values = np.asarray(plane_of(volume, frame, channel, 0, **{"xyz"[across]: at[across]}).values, np.float64)
        if right[0] > up[0]:
            values = values.T  # [up, right]
        pw, ph = (max(1, int(lengths[side[0]] / length + .5)) for side in (right, up))
        across_columns, near = _weights(edges[right[0]], places[right[0]], pw, right[1], labels)
        across_rows, near_rows = _weights(edges[up[0]], places[up[0]], ph, not up[1], labels)  # from the top
        there = np.isfinite(values)
        share = across_rows @ there @ across_columns.T
        mean = across_rows @ np.where(there, values, 0) @ across_columns.T / np.maximum(share, 1e-9)
        shown = there[near_rows][:, near]
        left, top = columns.start + (w - pw) // 2, rows.start + (h - ph) // 2
        part = out[top:top + ph, left:left + pw]
        part[..., :3] = np.where(shown[..., None], _colored(mean, colors, labels), 0)
        part[..., 3] = shown
        scale = max(1, min(w, h) // 150)
        dx, dy = (6 * scale if n >= 24 * scale else -6 * scale for n in (pw, ph))  # a thin plane has them outside
        for letter, x, y in ((right[2], dx, ph / 2), (right[3], pw - dx, ph / 2), (up[3], pw / 2, dy),
                             (up[2], pw / 2, ph - dy)):
            if letter:
                _write(out, letter, left + x, top + y, scale)
    return out
