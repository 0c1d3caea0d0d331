"""Simulate one sweep of a LiDAR in one frame: points on objects, on occluders, on the ground.

Serial, for processes that run side by side. Which ray ends where is settled by the kernels that count points on road
users (`nearest`, `targets`), and which of these come back by the same draws: noise and losses only come on top.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from riglens.core.kernels.objects.box_frames import (
    Beams,
    Canvas,
    FrameBoxes,
    box_of,
    is_inside,
    is_lost,
    local_direction,
    new_faces,
    ray_at,
    set_turn,
    start_of,
    turned,
)
from riglens.core.kernels.objects.counts import spun, wipe
from riglens.core.kernels.objects.images import is_stopped
from riglens.core.kernels.objects.nearest import meet_frame
from riglens.core.kernels.objects.returns import cosine_of, is_returned, overhang_of
from riglens.core.kernels.rays.lattice import Direction, rotated, rotated_back
from riglens.core.kernels.rays.phases import mixed, unit
from riglens.core.kernels.runtime.jit import kernel, lean, lean_inlined

GROUND, STATIC = -1, -2
"""Codes of points that are on no object."""
CORRECTIONS = 2
ROUGH = 0.25
"""Least cosine that counts on the ground: asphalt is rough, and returns more at a flat angle than a smooth face."""
_HALF_WORD = 1.0 / (1 << 32)
_SQRT3 = 1.7320508075688772


class Reflectivity(NamedTuple):
    """Reflection model of a frame: `users`, the number of objects, which come first among its boxes; soft (k,): depth
    to which rays enter boxes of each kind, metres; bright (n,): intensity of each box at a right angle, and `road` that
    of the ground."""

    users: int
    soft: np.ndarray
    bright: np.ndarray
    road: float


class Surface(NamedTuple):
    """The ground: whether there is one, its height in metres, and waves (k, 4): amplitude in metres, x and y in radians
    per metre, phase in radians."""

    exists: bool
    height: float
    waves: np.ndarray


class DrawKeys(NamedTuple):
    """Keys of the draws of a sensor in a frame: returns, noise, losses; standard deviation of the noise in metres,
    share lost; law (6,) or (0,): range in metres at which half of the rays return from car, bicycle, pedestrian,
    occluders, the ground, and the relative width."""

    returns: np.uint64
    noise: np.uint64
    losses: np.uint64
    noise_m: float
    dropout: float
    law: np.ndarray


class Returns(NamedTuple):
    """Output of a sweep, (rays,) each: place (rays, 3) in the vehicle frame, intensity, number of the ray, code of the
    surface; and reached (users,): rays that meet each object first, whether or not they return."""

    points: np.ndarray
    intensity: np.ndarray
    ray: np.ndarray
    what: np.ndarray
    reached: np.ndarray


@lean_inlined
def height_at(surface: Surface, x: float, y: float) -> float:
    """Return the height of the ground above the plane on average, metres."""
    bump = 0.0
    for k in range(surface.waves.shape[0]):
        wave = surface.waves[k]
        bump += wave[0] * np.sin(wave[1] * x + wave[2] * y + wave[3])
    return bump


@lean_inlined
def ground_at(surface: Surface, origin: np.ndarray, d: Direction) -> float:
    """Return the distance at which a ray meets the ground, metres, inf: never. First the plane; then, CORRECTIONS
    times, the plane at the height that the ground has there."""
    above = origin[2] - surface.height
    if not surface.exists or d[2] >= 0.0 or above <= 0.0:
        return np.inf
    t = above / -d[2]
    for _ in range(CORRECTIONS):
        t = (above - height_at(surface, origin[0] + t * d[0], origin[1] + t * d[1])) / -d[2]
    return t if t > 0.0 else np.inf


@lean_inlined
def _ground_seen(surface: Surface, beams: Beams, d: Direction) -> float:
    """Return 1 / distance at which a ray meets the ground within its range, 0 where it does not."""
    t = ground_at(surface, beams.origin, d)
    return 1.0 / t if beams.reach[0] <= t <= beams.reach[1] and t < np.inf else 0.0


@lean_inlined
def bell(key: np.uint64) -> float:
    """Return a number from nearly a normal distribution of deviation 1: the sum of four even ones, so never beyond
    3.5."""
    low = np.uint64(0xFFFF)
    total = (
        (key & low) + ((key >> np.uint64(16)) & low) + ((key >> np.uint64(32)) & low) + (key >> np.uint64(48))
    )
    return (np.float64(total) / 65536.0 - 2.0 + 2.0 / 65536.0) * _SQRT3


@lean
def set_frames(
    traffic: FrameBoxes, beams: Beams, rotation: np.ndarray, turns: np.ndarray, starts: np.ndarray
) -> None:
    """Write the axes of every box: turns (n, 3, 3) from those of the sensor, and starts (n, 3), the sensor in them."""
    for box in range(traffic.centres.shape[0]):
        set_turn(traffic, rotation, box, turns[box])
        starts[box, 0], starts[box, 1], starts[box, 2] = start_of(traffic, beams, box)


@lean_inlined
def _note(
    ray: int, d: Direction, origin: np.ndarray, t: float, deep: float, shade: float, what: int,
    draws: DrawKeys, to: Returns, count: int,
) -> int:  # fmt: skip
    """Record a return, unless it is lost; return the number so far."""
    word = mixed(draws.losses, np.uint64(ray))
    if np.float64(word >> np.uint64(32)) * _HALF_WORD < draws.dropout:
        return count
    if deep > 0.0:
        t += deep * (np.float64(word & np.uint64(0xFFFFFFFF)) * _HALF_WORD)
    if draws.noise_m > 0.0:
        t += draws.noise_m * bell(mixed(draws.noise, np.uint64(ray)))
    for axis in range(3):
        to.points[count, axis] = origin[axis] + t * d[axis]
    to.intensity[count], to.ray[count], to.what[count] = shade, ray, what
    return count + 1


@lean
def _note_returns(
    traffic: FrameBoxes, reflectivity: Reflectivity, surface: Surface, beams: Beams, rotation: np.ndarray,
    draws: DrawKeys,
    canvas: Canvas, turns: np.ndarray, starts: np.ndarray, to: Returns,
) -> int:  # fmt: skip
    """Record the returns of all rays, row by row from below; return the number of points."""
    count, law = 0, draws.law
    for place in range(beams.row_of.size):
        for column in range(beams.columns):
            slot = place * beams.columns + column
            part, local = canvas.owner[slot], local_direction(beams, place, column)
            d = rotated(rotation, local)
            inverse = canvas.inverse[slot]
            if part < 0:
                inverse = _ground_seen(surface, beams, d)
            if inverse == 0.0 or (beams.ends.size > 0 and is_stopped(beams, place, column, inverse)):
                continue
            t = 1.0 / inverse
            deep, cosine, bright, half_m, what = 0.0, -d[2], reflectivity.road, 0.0, GROUND
            if part >= 0:
                box = box_of(part)
                along, s = turned(turns[box], local), starts[box]
                cosine = cosine_of(overhang_of(traffic, part, (s[0], s[1], s[2])), along)
                deep, bright, what = reflectivity.soft[traffic.kind[box]], reflectivity.bright[box], STATIC
                if box < reflectivity.users:
                    what = box
                    to.reached[box] += 1
                half_m = law[traffic.cls[box]] if law.size > 0 else 0.0
            elif law.size > 0:
                cosine, half_m = max(cosine, ROUGH), law[4]
            if part >= 0 and is_lost(traffic, beams, draws.returns, part, place, column):
                continue
            ray = ray_at(beams, place, column)
            if law.size > 0:
                chance = unit(mixed(draws.returns, np.uint64(ray)))
                if not is_returned(t, half_m, law[5], cosine, chance):
                    continue
            count = _note(ray, d, beams.origin, t, deep, bright * cosine, what, draws, to, count)
    return count


@kernel
def cast_sweep(
    traffic: FrameBoxes, reflectivity: Reflectivity, surface: Surface, beams: Beams, phase: float, draws: DrawKeys,
    canvas: Canvas,
    alone: np.ndarray, to: Returns,
) -> int:  # fmt: skip
    """Simulate one sweep of a LiDAR in the only frame of `traffic`, its azimuths shifted by a phase in radians.

    Returns the number of points, which stand first in `to`. Adds to alone (boxes,) the rays that would meet each box
    if it stood there alone. The canvas is left empty, as it was found.
    """
    boxes = traffic.centres.shape[0]
    rotation = spun(beams.rotation, phase)
    faces, key = new_faces(), draws.returns
    meet_frame(traffic, beams, 0, rotation, key, faces, np.empty((8, 3)), np.empty(3), canvas, alone)
    turns, starts = np.empty((boxes, 3, 3)), np.empty((boxes, 3))
    set_frames(traffic, beams, rotation, turns, starts)
    count = _note_returns(traffic, reflectivity, surface, beams, rotation, draws, canvas, turns, starts, to)
    canvas.last[:] = -1
    wipe(beams.columns, canvas)
    return count


@kernel
def count_inside(
    points: np.ndarray, centres: np.ndarray, halves: np.ndarray, rotations: np.ndarray, counts: np.ndarray
) -> None:
    """Count the points (p, 3) in each box (n,), faces included; boxes as in `FrameBoxes`."""
    for box in range(counts.size):
        centre, turn = centres[box], rotations[box]
        half = halves[box, 0], halves[box, 1], halves[box, 2]
        radius2 = half[0] * half[0] + half[1] * half[1] + half[2] * half[2]
        for k in range(points.shape[0]):
            x, y, z = points[k, 0] - centre[0], points[k, 1] - centre[1], points[k, 2] - centre[2]
            if x * x + y * y + z * z > 1.000001 * radius2:
                continue
            counts[box] += is_inside(rotated_back(turn, (x, y, z)), half)
