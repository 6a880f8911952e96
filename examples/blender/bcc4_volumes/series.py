"""Moments of a .bcc4 as OpenVDB files: by the package bccsplat, or by the tool bcc4 where this Python cannot load that."""
import json
import os
import shutil
import subprocess
import sys
from dataclasses import dataclass

import numpy as np

from . import vdb


class Failure(Exception):
    """What a user is told."""


@dataclass
class Channel:
    name: str
    high: float   # that almost no stored value is above
    air: float
    labels: bool


@dataclass
class Series:
    """What a file is. Frames are counted from 0; `last` is the last moment, in frames."""

    path: str
    dims: tuple       # samples along x, y, z
    affine: np.ndarray
    frames: int
    last: float
    periodic: bool
    times: tuple      # of the first and the last frame
    channels: list

    def shown(self, frame, outside):
        """The frame number that is shown where `frame` is asked for; None: nothing."""
        if self.last <= 0:
            return 0.0
        if self.periodic or outside == "REPEAT":
            return frame % self.last
        if outside == "HIDE" and not 0 <= frame <= self.last:
            return None
        return min(max(frame, 0.0), self.last)

    def evenly(self, time):
        """The frame number of a time in the file's unit, of frames that are evenly spaced."""
        first, last = self.times
        return (time - first) / (last - first) * (self.frames - 1) if last > first else 0.0

    def time_evenly(self, frame):
        """The other way round."""
        first, last = self.times
        return first + (last - first) * frame / max(self.frames - 1, 1)

    def chosen(self, names):
        """The channels of these names, separated by commas; "": all."""
        asked = [name.strip() for name in names.split(",") if name.strip()]
        known = {channel.name: channel for channel in self.channels}
        for name in asked:
            if name not in known:
                raise Failure("%s has no channel %s: there are %s" % (self.path, name, ", ".join(known)))
        return [known[name] for name in asked] or self.channels


class PackageSeries(Series):
    """Through the package: all channels, and coarser levels."""

    way = "package"

    def __init__(self, bccsplat, path):
        try:
            self._volume = bccsplat.open(path)
        except bccsplat.Error as error:
            raise Failure(str(error)) from None
        self._package = bccsplat
        info = self._volume.info()
        self._of = [self._volume.channel_info(n) for n in range(info.channel_count)]
        nx, ny, nz, frames = info.dims[:]
        super().__init__(path, (nx, ny, nz), self._volume.affine, frames, frames if info.time_periodic else frames - 1,
                         bool(info.time_periodic), (info.time_first, info.time_last),
                         [Channel(of.name, of.percentile_998, of.air, bool(of.labels)) for of in self._of])

    def frame_at(self, time):
        """The frame number of a time in the file's unit, which may lie outside the series."""
        first, last = self.times
        return self._volume.time_to_index(time) if first <= time <= last else self.evenly(time)

    def time_at(self, frame):
        """The time of a frame number."""
        return self._volume.index_to_time(frame) if 0 <= frame <= self.last else self.time_evenly(frame)

    def write(self, target, frame, names, level, threshold):
        """A moment as an OpenVDB file, a grid for each channel. threshold: what is no further from air is left out; below 0:
        what the file takes for air."""
        try:
            grids = [self._grid(channel, frame, level, threshold) for channel in self.chosen(names)]
        except self._package.Error as error:
            raise Failure(str(error)) from None
        vdb.write(target, grids)

    def _grid(self, channel, frame, level, threshold):
        of = self._of[self.channels.index(channel)]
        step = 1 << level
        if level > self._volume.info().level_count:
            raise Failure("%s has no level %d: the coarsest is %d" % (self.path, level, self._volume.info().level_count))
        cut = self._package.Slice.at(self._volume, round(frame) if channel.labels else frame, channel=channel.name, level=level,
                                     space="even")
        values = cut.sample_grid((0, 0, 0), (step,) * 3, [(n - 1) // step + 1 for n in self.dims])
        # The field goes a little beyond the values that it is made of.
        np.clip(values, min(of.range[0], of.air), max(of.range[1], of.air), out=values)
        if threshold < 0:
            abi = self._package.abi
            half = of.value_scale / 2 if of.value_type in (abi.TYPE_U8, abi.TYPE_U16) else 0
            threshold = 0 if of.error_bound > 0 else max(of.air_threshold, half)
        return vdb.Grid(channel.name, values, self.affine @ np.diag([step, step, step, 1.0]), of.air, threshold)


class ToolSeries(Series):
    """Through the tool, which writes a channel to a file, and no coarser levels."""

    way = "tool"

    def __init__(self, tool, path):
        self._tool = tool
        about = json.loads(self._said("info", path, "--json"))
        *dims, frames = about["dims"]
        times = about["times"]
        self._even = times["uniform"]
        super().__init__(path, tuple(dims), np.array(about["affine"], np.float64).reshape(4, 4), frames,
                         frames if times["periodic"] else frames - 1, times["periodic"], (times["first"], times["last"]),
                         [Channel(of["name"], of["percentiles"]["99.8"], of["air"], of["labels"]) for of in about["channels"]])

    def frame_at(self, time):
        """As of a PackageSeries, of frames that are evenly spaced."""
        self._need_even()
        return self.evenly(time)

    def time_at(self, frame):
        """The same."""
        self._need_even()
        return self.time_evenly(frame)

    def _need_even(self):
        if not self._even:
            raise Failure("the tool does not tell the times of frames that are unevenly spaced: install the package bccsplat")

    def write(self, target, frame, names, level, threshold):
        """As of a PackageSeries, of one channel."""
        chosen = self.chosen(names)
        if len(chosen) > 1:
            raise Failure("the tool writes one channel into a file: name one of %s, or install the package bccsplat"
                          % ", ".join(channel.name for channel in chosen))
        if level or threshold >= 0:
            raise Failure("the tool has no level and no threshold of air for exports: install the package bccsplat")
        partial = "%s.%d.partial.vdb" % (target, os.getpid())
        self._said("export", self.path, "--channel", chosen[0].name, "--time", repr(float(frame)), "--index", "-o", partial,
                   "--overwrite", "--quiet")
        os.replace(partial, target)

    def _said(self, *arguments):
        try:
            done = subprocess.run([self._tool, *arguments], stdin=subprocess.DEVNULL, capture_output=True, text=True)
        except OSError as error:
            raise Failure("%s does not run: %s" % (self._tool, error)) from None
        if done.returncode:
            raise Failure(done.stderr.strip() or "%s ended with %d" % (self._tool, done.returncode))
        return done.stdout


def open_series(path, package="", tool=""):
    """package: a folder that holds the package, tool: the path of the tool; "": where Python and the shell look for them."""
    if not os.path.isfile(path):
        raise Failure("there is no file %s" % path)
    if package and package not in sys.path:
        sys.path.insert(0, package)
    try:
        import bccsplat
    except ImportError as error:
        found = tool or os.environ.get("BCCSPLAT_TOOL") or shutil.which("bcc4")
        if not found:
            raise Failure("neither the Python package bccsplat (%s) nor the tool bcc4 is found: the preferences of the add-on "
                          "say where they are" % error) from None
        return ToolSeries(found, path)
    return PackageSeries(bccsplat, path)
