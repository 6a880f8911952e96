"""The tasks that write a series of dask arrays by parts: one for each part, and one that joins them."""
from __future__ import annotations

import os
import uuid
from typing import TYPE_CHECKING, Any, Sequence

import numpy as np

from .errors import refuse_existing
from .files import add_frames, frame_of
from .shared import default_device
from .writer import join_parts

if TYPE_CHECKING:
    from .dataset_writer import LazySeries, SeriesPlan


class PartTask:
    """Frames first .. end - 1 of a series, to a file of their own. The arrays travel with the task as they are, lazy, and
    are computed here, a chunk of time after another: no more is held, and a part that is there already costs nothing."""

    def __init__(self, plan: SeriesPlan, series: Sequence[LazySeries], path: str, frames: tuple[int, int]) -> None:
        self.plan, self.path, self.frames = plan, path, frames
        self.made_before: list[Any] = []
        self.lead: int | None = None  # not known yet
        if any(in_cluster(one.data) for one in series):
            self.lead = lead_of([one.data for one in series], plan.part_frames(frames).start)
            needed = plan.part_frames(frames, self.lead)
            self.made_before = [one.data[needed.start:needed.stop] for one in series]
            self.series: list[LazySeries] = []
        else:
            self.series = [*series]

    def take_dependencies(self) -> list[Any]:
        """Arrays of which chunks lie in the memory of a cluster already: the scheduler brings them, all frames of the part
        at once. They leave the task, which travels without them."""
        taken, self.made_before = self.made_before, []
        return taken

    def run(self, brought: Sequence[Any]) -> str:
        """Writes the part and returns its path. It takes its name when it is whole, so that of two tasks of one part,
        such as after a worker was given up that still lives, either is right."""
        if os.path.exists(self.path):
            return self.path
        attempt = "%s.%s" % (self.path, uuid.uuid4().hex)
        # Of this run alone: what they hold goes with them, not with the task, which the scheduler keeps.
        series: list[Any] = [type(one)(one.data, "synchronous") for one in self.series]
        lead = lead_of(series, self.plan.part_frames(self.frames).start) if self.lead is None else self.lead
        with self.plan.writer(attempt, part=self.frames, part_times=self.plan.times, part_lead=lead) as writer:
            frames = range(*writer.part_frames())
            add_frames(writer, [Shifted(array, frames.start) for array in brought] or series, self.plan.times, frames)
        os.replace(attempt, self.path)
        return self.path


class Shifted:
    """Frames of an array that begins with frame `first`."""

    def __init__(self, array: Any, first: int) -> None:
        self.array, self.first = array, first

    def __getitem__(self, t: int) -> Any:
        return self.array[t - self.first]


def lead_of(series: Sequence[Any], begin: int) -> int:
    """How many frames before `begin` a part has to be given: back to one that is missing altogether in no channel."""
    lead = 0
    while lead < begin and any(not np.isfinite(frame_of(one, begin - lead)).any() for one in series):
        lead += 1
    return lead


def in_cluster(array: Any) -> bool:
    """Whether chunks of a dask array are results that a cluster holds, which only its scheduler can bring."""
    return any(type(value).__name__ == "Future" for value in dict(array.dask).values())


def join_task(parts: Sequence[str], path: str, overwrite: bool) -> str:
    """Joins the parts to the file, which takes its name when it is whole."""
    refuse_existing(path, overwrite)
    attempt = "%s.%s" % (parts[0], uuid.uuid4().hex)
    join_parts(default_device(), parts, attempt, compare_levels=True)
    os.replace(attempt, path)
    return path
