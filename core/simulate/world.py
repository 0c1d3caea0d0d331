"""Build the content of one frame, the same for every rig: objects, given occluders, clutter, ground.

Draws depend on the seed and the number of the frame alone.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from riglens.core.kernels.objects.box_frames import FrameBoxes
from riglens.core.kernels.objects.sweeps import Reflectivity, Surface
from riglens.core.simulate.clutter import KINDS, Clutter, Footprints, scattered
from riglens.core.simulate.motion import SWEEP_S, Before, Motion, before
from riglens.core.simulate.settings import USUAL_SIMULATION, SimulationSettings
from riglens.core.targets.shapes import SHAPES, kind_numbers, kinds_of
from riglens.core.targets.traffic import NO_CLASS, Traffic

Doubles = NDArray[np.float64]
WAVES_M = ((6.0, 12.0), (12.0, 25.0), (25.0, 50.0))
"""Shortest and longest of each wave of the ground; our choice, as the heights."""
WAVE_HEIGHT_M = (0.01, 0.04)
BRIGHT, ROAD_BRIGHT = (10.0, 130.0), 25.0
"""Intensity at a right angle, drawn for each thing from the same range: it does not reveal the class."""
NEAR_M, FEWEST = 60.0, 3
"""The ground is the median of the bottoms of objects within this distance, if there are this many."""


@dataclass(frozen=True)
class TrueBoxes:
    """Objects of a frame, n of them, in the order of the data: cls (n,) uint8 index into CLASSES; centre_m, size_m
    (n, 3) metres, vehicle frame; rotation (n, 3, 3) box to vehicle frame; row (n,) place in the data."""

    cls: NDArray[np.uint8]
    centre_m: Doubles
    size_m: Doubles
    rotation: Doubles
    row: NDArray[np.int64]

    @property
    def yaw_rad(self) -> Doubles:
        """Return the heading of the objects, (n,), positive to the left."""
        return np.arctan2(self.rotation[:, 1, 0], self.rotation[:, 0, 0])

    @property
    def distance_m(self) -> Doubles:
        """Distance (n,) from the vehicle frame's origin to each centre along the ground."""
        return np.hypot(self.centre_m[:, 0], self.centre_m[:, 1])


class World(NamedTuple):
    """Frame for the kernels: `boxes`, objects first; their reflection; the ground; `kind` (n,) of each box beyond the
    objects: index into KINDS, -1 for given occluders."""

    boxes: FrameBoxes
    reflectivity: Reflectivity
    surface: Surface
    kind: NDArray[np.int64]


class Worlds:
    """Frames of traffic, by their number in the data, for a seed and settings; with motion, earlier sweeps too. For one
    thread: the last frame is cached for the LiDARs and cameras of a rig."""

    def __init__(
        self,
        traffic: Traffic,
        settings: SimulationSettings = USUAL_SIMULATION,
        motion: Motion | None = None,
    ) -> None:
        self.traffic, self.settings, self.motion = traffic, settings, motion
        self._place = {number: place for place, number in enumerate(traffic.frame.tolist())}
        self._last: tuple[int, World] | None = None

    @property
    def frames(self) -> int:
        """Number of frames."""
        return self.traffic.frames

    def truth(self, frame: int) -> TrueBoxes:
        """Return the objects of a frame."""
        _, users = self._places(frame)
        t = self.traffic
        return TrueBoxes(t.cls[users], t.centre_m[users], t.size_m[users], t.rotation[users], t.row[users])

    def world(self, frame: int) -> World:
        """Return the whole frame, read only."""
        if self._last is None or self._last[0] != frame:
            self._last = frame, self._made(frame)
        return self._last[1]

    def before(self, frame: int, sweeps: int) -> Before:
        """Return where the car was some sweeps before a frame; needs motion."""
        assert self.motion is not None
        place, (given, _) = self._place[frame], self._places(frame)
        return before(self.motion, place, given, sweeps * SWEEP_S)

    def _made(self, frame: int) -> World:
        given, users = self._places(frame)
        rng = np.random.default_rng([self.settings.seed, frame])
        surface = _surface(rng, self.settings, self._height(users))
        clutter = scattered(rng, self.settings.clutter, self._footprints(users))
        stands = _standing(clutter, surface)
        t, number = self.traffic, given.stop - given.start + len(clutter.kind)
        shape = kind_numbers(self.settings.shape, t.cls[given], t.size_m[given])
        boxes = FrameBoxes(
            np.array([0, number]),
            np.concatenate([t.centre_m[given], stands]),
            np.concatenate([t.size_m[given], clutter.size_m]) / 2.0,
            np.concatenate([t.rotation[given], clutter.rotation()]),
            np.ones(number, np.bool_),
            np.concatenate([t.cls[given], np.full(len(clutter.kind), NO_CLASS, np.uint8)]),
            np.concatenate([shape, (len(SHAPES) + clutter.kind).astype(np.uint8)]),
            *_KINDS,
        )
        bright = rng.uniform(*BRIGHT, number)
        kind = np.concatenate([np.full(given.stop - users.stop, -1), clutter.kind])
        return World(
            boxes, Reflectivity(users.stop - users.start, _SOFT_M, bright, ROAD_BRIGHT), surface, kind
        )

    def _places(self, frame: int) -> tuple[slice, slice]:
        """Return the slice of a frame's boxes, and that of the objects, which come first among them."""
        if frame not in self._place:
            raise IndexError(f"no frame {frame} among {self.frames}")
        place = self._place[frame]
        first, end = int(self.traffic.starts[place]), int(self.traffic.starts[place + 1])
        users = first + int(np.count_nonzero(self.traffic.cls[first:end] != NO_CLASS))
        return slice(first, end), slice(first, users)

    def _height(self, users: slice) -> float:
        """Return the average height of the ground, metres."""
        t = self.traffic
        near = t.distance_m[users] <= NEAR_M
        if np.count_nonzero(near) < FEWEST:
            return 0.0
        return float(np.median(t.centre_m[users][near, 2] - t.size_m[users][near, 2] / 2.0))

    def _footprints(self, users: slice) -> Footprints:
        t = self.traffic
        ahead = t.rotation[users][:, :2, 0]
        length = np.maximum(np.hypot(ahead[:, 0], ahead[:, 1]), 1e-9)[:, None]
        return Footprints(t.centre_m[users][:, :2], t.size_m[users][:, :2] / 2.0, ahead / length)


def earlier(world: World, then: Before) -> World:
    """Return a frame as it was before, in the vehicle frame of that moment."""
    centres, turn = world.boxes.centres.copy(), then.rotation
    centres[: len(then.moved_m), :2] -= then.moved_m
    boxes = world.boxes._replace(
        centres=(centres - then.place_m) @ turn, rotations=turn.T @ world.boxes.rotations
    )
    waves = world.surface.waves.copy()
    waves[:, 3] += waves[:, 1:3] @ then.place_m[:2]
    waves[:, 1:3] = waves[:, 1:3] @ turn[:2, :2]
    return world._replace(boxes=boxes, surface=world.surface._replace(waves=waves))


def _surface(rng: np.random.Generator, settings: SimulationSettings, height_m: float) -> Surface:
    """Return the ground of a frame; the draws are the same for every kind of ground."""
    count = len(WAVES_M)
    lengths_m = rng.uniform(*np.array(WAVES_M).T)
    amplitude_m, bearing, phase = rng.uniform(*WAVE_HEIGHT_M, count), rng.random(count), rng.random(count)
    turn = 2.0 * np.pi * bearing
    along = 2.0 * np.pi / lengths_m
    waves = np.stack([amplitude_m, along * np.cos(turn), along * np.sin(turn), 2.0 * np.pi * phase], axis=1)
    return Surface(settings.ground != "none", height_m, waves if settings.ground == "uneven" else waves[:0])


def _standing(clutter: Clutter, surface: Surface) -> Doubles:
    """Return the centres (n, 3) of things on the ground."""
    x, y = clutter.foot_m.T
    waves = surface.waves[:, :, None]
    bump = (waves[:, 0] * np.sin(waves[:, 1] * x + waves[:, 2] * y + waves[:, 3])).sum(axis=0)
    return np.column_stack([x, y, surface.height + bump + clutter.size_m[:, 2] / 2.0])


_KINDS = kinds_of([*SHAPES, *((kind.parts,) for kind in KINDS)])
_SOFT_M = np.array([*(0.0 for _ in SHAPES), *(kind.soft_m for kind in KINDS)])
"""Depth to which rays enter boxes of each kind."""
