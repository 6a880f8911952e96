"""An OpenVDB file of dense boxes of float32, by numpy alone. What the numbers mean: a tree of three kinds of nodes below a
root (32^3 nodes of 16^3 leaves of 8^3 voxels), first the shape of all of it, then the voxels of its leaves."""
import os
import struct
import uuid
from dataclasses import dataclass

import numpy as np

_MAGIC, _VERSION, _LIBRARY = 0x56444220, 224, (10, 0)
_BY_MASK = 2            # values that are not stored are the background
_NONE, _ALL = 0, 6      # which values of a node are stored: those of its mask, of which there are none, or each
_LEAF = np.dtype([("mask", "u1", 64), ("stored", "i1"), ("values", "<f4", 512)])


@dataclass
class Grid:
    """A box of voxels [z, y, x], the first of them at (0, 0, 0), and where they are: affine [4, 4] from (x, y, z, 1). What is
    no further than `threshold` from the background, and what is NaN, is left out."""

    name: str
    values: np.ndarray
    affine: np.ndarray
    background: float = 0.0
    threshold: float = 0.0


def _text(text):
    data = text.encode()
    return struct.pack("<I", len(data)) + data


def _metadata(entries):
    """Pairs of a name and a text."""
    return struct.pack("<I", len(entries)) + b"".join(_text(name) + _text("string") + _text(text) for name, text in entries)


def _leaves(grid):
    """The leaves that hold something, and their places [n, 3] in leaves, in the order of the file."""
    values = np.ascontiguousarray(grid.values.transpose(2, 1, 0), np.float32)
    full = np.full([-(-n // 8) * 8 for n in values.shape], grid.background, np.float32)
    full[tuple(slice(n) for n in values.shape)] = values
    boxes = full.reshape([n for size in full.shape for n in (size // 8, 8)]).transpose(0, 2, 4, 1, 3, 5)
    voxels = boxes.reshape(*boxes.shape[:3], 512)
    away = np.abs(voxels - np.float32(grid.background))
    active = away > grid.threshold  # false of NaN
    places = np.argwhere(active.any(axis=-1))
    # By their nodes: those of the root one after the other, in each those of the next kind, and in these the leaves.
    places = places[np.lexsort([*(places & 15).T[::-1], *(places >> 4 & 31).T[::-1], *(places >> 9).T[::-1]])]
    chosen = tuple(places.T)
    leaves = np.zeros(len(places), _LEAF)
    leaves["mask"] = np.packbits(active[chosen], axis=-1, bitorder="little")
    leaves["stored"] = _ALL
    leaves["values"] = np.where(active[chosen], voxels[chosen], np.float32(grid.background))
    return leaves, places


def _node(children, log):
    """A node of 8^log children that has these, by places in it, and no values of its own."""
    mask = np.zeros(8 ** log, bool)
    mask[(children[:, 0] << 2 * log) + (children[:, 1] << log) + children[:, 2]] = True
    return np.packbits(mask, bitorder="little").tobytes() + bytes(8 ** log // 8) + struct.pack("<b", _NONE)


def _groups(places, shift):
    """Ranges of places, which are in order, that lie in one node each."""
    nodes = places >> shift
    starts = np.flatnonzero(np.r_[True, (nodes[1:] != nodes[:-1]).any(axis=1)]) if len(places) else []
    return zip(starts, [*starts[1:], len(places)])


def _topology(grid, leaves, places):
    roots = [*_groups(places, 9)]
    out = [struct.pack("<ifII", 1, grid.background, 0, len(roots))]
    for begin, end in roots:
        inside = places[begin:end]
        nodes = [*_groups(inside, 4)]
        out.append(struct.pack("<3i", *(inside[0] >> 9 << 12)))
        out.append(_node(np.array([inside[first] >> 4 & 31 for first, _ in nodes]), 5))
        for first, last in nodes:
            out.append(_node(inside[first:last] & 15, 4))
            out.append(leaves["mask"][begin + first:begin + last].tobytes())
    return b"".join(out)


def _body(grid, topology):
    """All of a grid before its leaves. An affine of OpenVDB is of rows."""
    about = _metadata([("class", "fog volume"), ("name", grid.name)])
    place = np.asarray(grid.affine, "<f8").T.tobytes()
    return struct.pack("<I", _BY_MASK) + about + _text("AffineMap") + place + topology


def write(path, grids, texts=()):
    """Writes grids into a file, which is there once it is whole. texts: pairs of a name and a text, about all of it."""
    out = [struct.pack("<qIII?", _MAGIC, _VERSION, *_LIBRARY, True), str(uuid.uuid4()).encode(), _metadata([*texts]),
           struct.pack("<i", len(grids))]
    position = sum(map(len, out))
    for grid in grids:
        leaves, places = _leaves(grid)
        body, voxels = _body(grid, _topology(grid, leaves, places)), leaves.tobytes()
        name = _text(grid.name) + _text("Tree_float_5_4_3") + _text("")
        start = position + len(name) + 24
        out += [name, struct.pack("<3q", start, start + len(body), start + len(body) + len(voxels)), body, voxels]
        position = start + len(body) + len(voxels)
    partial = "%s.%d.partial" % (path, os.getpid())
    try:
        with open(partial, "wb") as file:
            file.writelines(out)
        os.replace(partial, path)
    except BaseException:
        if os.path.exists(partial):
            os.remove(partial)
        raise
