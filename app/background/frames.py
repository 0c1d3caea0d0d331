"""Compute one frame of the traffic for the 3D view, in a separate thread with serial kernels.

Objects have the points that the panel Targets counts on them, by the same settings; where rays end is a picture of
the azimuths as listed against plain boxes.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING
from weakref import ref

import numpy as np

from riglens.app.background.worker import Context
from riglens.core.rig.model import Rig
from riglens.core.targets.settings import TargetSettings
from riglens.core.vehicle.housings import car_of
from riglens.core.vehicle.solid import Solid
from riglens.core.view.frames import FrameBoxes

if TYPE_CHECKING:  # made by the thread, which loads the compiler
    from riglens.core.targets.counts import ObjectCounts
    from riglens.core.targets.engine import TargetEngine
    from riglens.core.targets.traffic import Traffic
    from riglens.core.view.frame_scene import FrameScene, Missed

FrameAnswer = tuple["FrameScene", "Missed | None"]
"""A frame with the rig's hits, and why the requested box is missed, if any."""
COARSE_RAYS, ALL_RAYS = 60_000, 400_000
"""Rays that are cast while the mouse moves, and at rest."""


@dataclass(frozen=True)
class FrameRequest:
    """Request for a frame: its index in the traffic. The settings say whether the car's body blocks; `explain`: the box
    whose low point count is to be explained."""

    rig: Rig
    traffic: Traffic
    place: int
    settings: TargetSettings
    explain: int | None = None
    is_preview: bool = False


def boxes_of(traffic: Traffic, place: int) -> FrameBoxes:
    """Return the boxes of a frame, by its index in the traffic."""
    part = slice(int(traffic.starts[place]), int(traffic.starts[place + 1]))
    return FrameBoxes(
        traffic.cls[part],
        np.ascontiguousarray(traffic.centre_m[part]),
        np.ascontiguousarray(traffic.size_m[part]),
        np.ascontiguousarray(traffic.rotation[part]),
    )


def _as_counted(found: Missed, counts: ObjectCounts, number: int, enough: int) -> Missed:
    """Return the reason why an object is missed, with its point count."""
    place = np.flatnonzero(counts.box == number)
    if not len(place) or found.verdict in ("no LiDARs", "out of range"):
        return found
    points, alone = int(counts.all_points[place[0]]), int(counts.points_alone[place[0]])
    if points >= enough:
        return replace(found, verdict="few points", points=points, alone=alone)
    return replace(
        found, verdict="hidden" if alone >= enough else "between beams", points=points, alone=alone
    )


class FrameCasting:
    """Caster of single frames; the counts of the last one are kept for the next edit. Called by one thread."""

    def __init__(self) -> None:
        self._counted: tuple[ref[Traffic], int, TargetEngine] | None = None

    def __call__(self, request: FrameRequest, context: Context[FrameAnswer]) -> FrameAnswer:
        """Return the frame, and why the box of `explain` is missed."""
        from riglens.core.view.frame_scene import frame_scene, why_missed  # loads the compiler

        boxes, settings = boxes_of(request.traffic, request.place), request.settings
        body = car_of(request.rig) if settings.body == "blocks" else Solid.of(np.zeros((0, 3, 3)))
        context.stop_if_closing()
        most = COARSE_RAYS if request.is_preview else ALL_RAYS
        frame = int(request.traffic.frame[request.place])
        scene = frame_scene(request.rig, frame, boxes, body, most)
        counts = self._counts(request)
        points = scene.points.copy()
        points[counts.box] = counts.all_points
        missed = None
        if request.explain is not None and not request.is_preview:
            found = why_missed(request.rig, boxes, request.explain, body, settings.min_points)
            missed = _as_counted(found, counts, request.explain, settings.min_points)
        return replace(scene, points=points), missed

    def _counts(self, request: FrameRequest) -> ObjectCounts:
        """Return the points on all objects of the frame, as the panel Targets counts them."""
        from riglens.core.targets.engine import TargetEngine

        traffic, place = request.traffic, request.place
        if self._counted is None or self._counted[0]() is not traffic or self._counted[1] != place:
            self._counted = ref(traffic), place, TargetEngine(traffic.frame_alone(place), threads=1)
        lidars = request.rig.with_lidars_alone()
        return self._counted[2].evaluate(lidars, request.settings).objects
