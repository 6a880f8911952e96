"""python_speed.py FOLDER [--size N] [--frames N] [--points N] [--waves A B]: what a field between its samples costs in Python.

Beside each other, of waves whose values are known everywhere: netCDF4 (frames deflated) with linear interpolation and with
scipy's map_coordinates of order 3, and of .bcc4 files the fastest that errs no more; where none does, the most accurate. The files
are those that bccsplat.save makes without options and by several bounds in decibels, and samples on lattices of several distances
for two kernels. Times are CPU seconds of one thread, the best of three, from the closed file
on: all reading is in them, files are in the system's cache. Prints the tables of tests/bench/notes/python.md. Needs numpy, scipy and netCDF4.
"""
import argparse
import itertools
import os
import sys
import time

import netCDF4
import numpy as np
from scipy import ndimage

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..", "examples", "python"))
import bccsplat  # noqa: E402

SEED = 4
WAVES = 24
SCALES = [1.0, 1.25, 1.6, 2.0, 2.5, 3.0]
KERNELS = ["default", "fine"]
# Frames to either side of a moment that a spline in time is made of, so that its ends do not show.
MARGIN = 8
# Distance of what is compared from faces and ends, where a spline of mirrored samples says more of the mirror.
INSIDE = 6
# Of files that a plan chooses; None: without options, 50 dB and 2 % at the worst sample.
BOUNDS = [None, 60, 70, 80]
REPEATS = 3


class Truth:
    """A sum of plane waves in x, y, z, t, all as strong."""

    def __init__(self, shortest, longest):
        random = np.random.default_rng(SEED)
        directions = random.normal(size=(WAVES, 4))
        directions /= np.linalg.norm(directions, axis=1)[:, None]
        lengths = shortest * (longest / shortest) ** random.random(WAVES)
        self.k, self.phase = 2 * np.pi * directions / lengths[:, None], random.random(WAVES) * 2 * np.pi
        self.weight = np.full(WAVES, 1 / WAVES)

    def at(self, points):
        """At points [n, 4], x, y, z, t."""
        return sum(w * np.sin(points @ k + p) for w, k, p in zip(self.weight, self.k, self.phase))

    def frame(self, t, n):
        """[z, y, x] at a moment."""
        total = np.zeros((n, n, n))
        at = np.arange(n)
        for w, k, p in zip(self.weight, self.k, self.phase):
            x, y, z = (np.exp(1j * k[a] * at) for a in range(3))
            total += w * (z[:, None, None] * y[None, :, None] * (x * np.exp(1j * (k[3] * t + p)))).imag
        return total


def timed(function):
    start = time.process_time()
    found = function()
    return found, time.process_time() - start


class Grid:
    """netCDF4 and scipy, by splines of an order."""

    def __init__(self, name, order, frames):
        self.name, self.order, self.frames = name, order, frames

    def read(self, begin, end):
        with netCDF4.Dataset(self.name) as file:
            return np.asarray(file["f"][begin:end])

    def points(self, points):
        data = self.read(0, self.frames)
        filtered = ndimage.spline_filter(data, self.order, np.float32) if self.order > 1 else data
        return ndimage.map_coordinates(filtered, points[:, ::-1].T, np.float32, self.order, mode="mirror", prefilter=False)

    def moment(self, t):
        begin = max(0, int(t) - (MARGIN if self.order > 1 else 0))
        data = self.read(begin, min(self.frames, int(t) + 2 + (MARGIN if self.order > 1 else 0)))
        if self.order == 1:
            return (1 - t % 1) * data[0] + t % 1 * data[1]
        along = ndimage.spline_filter1d(data, 3, 0, np.float32)  # at a moment only time is between samples
        first, u = int(t) - 1 - begin, t % 1
        weights = [(1 - u) ** 3 / 6, 2 / 3 - u * u + u**3 / 2, 1 / 6 + (u + u * u - u**3) / 2, u**3 / 6]
        return np.tensordot(np.array(weights, np.float32), along[first:first + 4], 1)


class File:
    """A .bcc4 file."""

    def __init__(self, name):
        self.name = name

    def open(self):
        return bccsplat.open(self.name, device=bccsplat.Device(threads=1))

    def points(self, points):
        return self.open().evaluate(points)

    def moment(self, t):
        return self.open()[t]


def measure(method, tasks, peak):
    """For each task seconds, the best of three, and dB against the truth, away from the faces."""
    found = {}
    for name, (kind, argument, expected) in tasks.items():
        runs = [timed(lambda: getattr(method, kind)(argument)) for _ in range(REPEATS)]
        error = runs[0][0].reshape(expected.shape) - expected
        if kind == "moment":
            error = error[INSIDE:-INSIDE, INSIDE:-INSIDE, INSIDE:-INSIDE]
        found[name] = min(seconds for _, seconds in runs), 20 * np.log10(peak / np.sqrt(np.mean(np.square(error))))
    return found


def tasks_of(truth, size, frames, count):
    random = np.random.default_rng(SEED + 1)
    points = INSIDE + random.random((count, 4)) * (np.array([size, size, size, frames]) - 1 - 2 * INSIDE)
    probes, moments = INSIDE + random.random((1000, 3)) * (size - 1 - 2 * INSIDE), np.arange(INSIDE, frames - INSIDE, .5)
    series = np.concatenate([np.broadcast_to(probes[:, None], (1000, len(moments), 3)),
                             np.broadcast_to(moments[None, :, None], (1000, len(moments), 1))], -1).reshape(-1, 4)
    moment = frames / 2 + .5
    return {"%.0e random (x, y, z, t)" % count: ("points", points, truth.at(points)),
            "a frame between two": ("moment", moment, truth.frame(moment, size)),
            "1000 points, two moments a frame": ("points", series, truth.at(series))}


def files_of():
    """What each file is, in words, and the options of save that make it."""
    for bound in BOUNDS:
        yield ("no options", {}) if bound is None else ("%d dB" % bound, {"psnr": bound})
    for scale, kernel in itertools.product(SCALES, KERNELS):
        yield "d4star, %g, %s" % (scale, kernel), {"lattice": "d4star", "scale": scale, "time_scale": scale, "kernel": kernel}


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("folder")
    parser.add_argument("--size", type=int, default=96)
    parser.add_argument("--frames", type=int, default=48)
    parser.add_argument("--points", type=int, default=1_000_000)
    parser.add_argument("--waves", type=float, nargs=2, default=[4, 20], help="shortest and longest, in samples")
    given = parser.parse_args()
    truth, size, frames = Truth(*given.waves), given.size, given.frames
    os.makedirs(given.folder, exist_ok=True)
    data = np.stack([truth.frame(t, size).astype(np.float32) for t in range(frames)])
    grid = os.path.join(given.folder, "waves.nc")
    with netCDF4.Dataset(grid, "w") as file:
        for name, count in zip("tzyx", data.shape):
            file.createDimension(name, count)
        file.createVariable("f", "f4", tuple("tzyx"), zlib=True, chunksizes=(1, size, size, size))[:] = data
    tasks = tasks_of(truth, size, frames, given.points)
    peak = float(data.max() - data.min())
    grids = {name: measure(Grid(grid, order, frames), tasks, peak) for name, order in (("linear", 1), ("cubic spline", 3))}
    files = []
    for told, options in files_of():
        name = os.path.join(given.folder, "waves-%s.bcc4" % told.replace(", ", "-").replace(" ", "-"))
        bccsplat.save(name, data, overwrite=True, **options)
        files.append((measure(File(name), tasks, peak), "%.1f (%s)" % (os.path.getsize(name) / 1e6, told)))
    print("%d^3 x %d samples of f32, %d waves of %g to %g samples; %.1f MB deflated as netCDF4\n" %
          (size, frames, WAVES, *given.waves, os.path.getsize(grid) / 1e6))
    print("| task | beside | theirs: CPU s (dB) | bccsplat: CPU s (dB) | its file: MB (what it is) | times as fast |")
    print("|---|---|---|---|---|---|")
    for task in tasks:
        for name, measured in grids.items():
            seconds, error = measured[task]
            enough = [file for file in files if file[0][task][1] >= error]
            found, told = (min(enough, key=lambda file: file[0][task][0]) if enough else
                           max(files, key=lambda file: file[0][task][1]))
            own, own_error = found[task]
            print("| %s | %s | %.3f (%.1f) | %.3f (%.1f) | %s | %.1f%s |" %
                  (task, name, seconds, error, own, own_error, told, seconds / own,
                   "" if enough else ", with a larger error"))


if __name__ == "__main__":
    main()
