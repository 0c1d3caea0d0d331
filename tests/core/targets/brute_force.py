"""Every ray against every box in plain numpy: what the targets engine has to find, written without its short cuts."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from riglens.core.rig.model import Lidar, Rig, Sensor
from riglens.core.scene.boxes import CLASSES
from riglens.core.sensing.rays import local_directions
from riglens.core.sensors.kind import Echo
from riglens.core.sensors.registry import kind_of
from riglens.core.targets.contribution import phases_rad
from riglens.core.targets.detection_range import SIZES_M
from riglens.core.targets.draws import mixed, sensor_key, units
from riglens.core.targets.range_law import anchors_of, range_for
from riglens.core.targets.settings import EXACT, TargetSettings
from riglens.core.targets.shapes import GLASS_PASSES, GLASS_RETURNS, REFLECTIVITY, WIDTH
from riglens.core.targets.traffic import Traffic
from riglens.core.vehicle.solid import Solid
from tests.core.targets.parts import Parts, parts_of
from tests.core.vehicle.solids import body_ends

Doubles = NDArray[np.float64]
CELL_M, INSIDE_M = 0.2, 0.001


@dataclass(frozen=True)
class OnBoxes:
    """Of n boxes: rays (n, sensors) that enter each first, alone (n, sensors) that would without the others, rows (n,
    sensors) from the first to the last with such a ray, and the distinct cells (n,) of all LiDARs."""

    rays: NDArray[np.int64]
    alone: NDArray[np.int64]
    rows: NDArray[np.int64]
    cells: NDArray[np.int64]


def count(
    traffic: Traffic,
    rig: Rig,
    settings: TargetSettings = EXACT,
    frames: int | None = None,
    solid: Solid | None = None,
) -> OnBoxes:
    """What the enabled sensors of a rig get onto the boxes of the first frames, past a solid if there
    is one; those with returns cast their finest rays."""
    sensors = [_cast_of(sensor) for sensor in rig.sensors if sensor.enabled]
    number = len(traffic.cls)
    rays, alone, rows = (np.zeros((number, len(sensors)), np.int64) for _ in range(3))
    limits = [_limits(sensor) for sensor in sensors]
    cells: list[set[tuple[int, int, int]]] = [set() for _ in range(number)]
    for frame in range(traffic.frames if frames is None else frames):
        first, end = int(traffic.starts[frame]), int(traffic.starts[frame + 1])
        for column, sensor in enumerate(sensors):
            phase = phases_rad(sensor, settings, traffic.frame[frame : frame + 1])[0]
            directions = _directions(sensor, float(phase))
            parts = parts_of(settings.shape, traffic.cls[first:end], traffic.size_m[first:end])
            entry, start, along = _entries(traffic, slice(first, end), parts, sensor, directions)
            in_box = np.zeros((len(entry), end - first), bool)
            for one, box in enumerate(parts.box.tolist()):
                in_box[:, box] |= np.isfinite(entry[:, one])
            alone[first:end, column] = in_box.sum(axis=0)
            words = return_words(sensor, settings.seed, int(traffic.frame[frame]))
            draws = units(mixed(words, np.array([0])))
            is_lossy = isinstance(sensor, Lidar) and settings.range_law
            if is_lossy:
                entry[np.ix_(draws < GLASS_PASSES, parts.is_glass)] = np.inf
            free = _ends(sensor, solid) > entry.min(axis=1, initial=np.inf)
            hit = np.flatnonzero(np.isfinite(entry).any(axis=1) & free)
            part = entry[hit].argmin(axis=1) if end > first else np.zeros(0, np.int64)
            if isinstance(sensor, Lidar):
                returns = ~parts.is_glass[part]
                if is_lossy:
                    returns |= draws[hit] >= 1.0 - GLASS_RETURNS
                    box, t = parts.box[part], entry[hit, part]
                    inner = start[box] - parts.offset_m[part], along[hit, box], parts.half_m[part]
                    returns &= _lawful(
                        sensor, traffic.cls[first + box], t, _cosines(*inner), units(words[hit])
                    )
                hit, part = hit[returns], part[returns]
            owner = parts.box[part]
            if limits[column].size and hit.size:
                near = entry[hit, part] <= limits[column][traffic.cls[first + owner], hit]
                hit, part, owner = hit[near], part[near], owner[near]
            for ray, box, one in zip(hit, owner, part, strict=True):
                rays[first + box, column] += 1
                if isinstance(sensor, Lidar):
                    inside = start[box] + (entry[ray, one] + INSIDE_M) * along[ray, box]
                    i, j, k = np.floor(inside / CELL_M).astype(int).tolist()
                    cells[first + box].add((i, j, k))
            columns = sensor.resolution[0]
            for box in np.unique(owner):
                row = hit[owner == box] // columns
                rows[first + box, column] = row.max() - row.min() + 1
            _leave_one_of_a_cell(traffic, slice(first, end), sensor, limits[column], rays[first:end, column])
    return OnBoxes(rays, alone, rows, np.array([len(found) for found in cells], np.int64))


def _cast_of(sensor: Sensor) -> Sensor:
    return sensor.finest() if kind_of(sensor).hits.measure == "returns" else sensor


def _limits(sensor: Sensor) -> Doubles:
    """How far each ray gets returns from each class, (3, rays); (0,): as far as its range."""
    echoes = [Echo(cls, min(SIZES_M[cls][:2])) for cls in CLASSES]
    rows = [kind_of(sensor).limits_m(sensor, echo) for echo in echoes]
    limited = [np.repeat(row, sensor.resolution[0]) for row in rows if row is not None]
    return np.array(limited) if limited else np.zeros(0)


def _leave_one_of_a_cell(
    traffic: Traffic, boxes: slice, sensor: Sensor, limits: Doubles, rays: NDArray[np.int64]
) -> None:
    """Of the boxes of a frame in one resolution cell keep the rays of that which returns from farthest, or of the one
    with most rays."""
    cells = kind_of(sensor).cells
    if cells is None:
        return
    best: dict[tuple[int, ...], int] = {}
    for box in np.flatnonzero(rays).tolist():
        local = (traffic.centre_m[boxes][box] - np.array(sensor.position)) @ sensor.pose.rotation()
        cell, reach = tuple(cells(sensor, local[None])[0].tolist()), limits.max(axis=1)[traffic.cls[boxes]]
        other = best.setdefault(cell, box)
        if other == box:
            continue
        loser = box if (reach[box], rays[box]) <= (reach[other], rays[other]) else other
        rays[loser], best[cell] = 0, box + other - loser


def return_words(sensor: Sensor, seed: int, frame: int) -> NDArray[np.uint64]:
    """The random words of all rays in a frame that decide which of them return, (rays,)."""
    key = mixed(sensor_key(seed, f"returns of {sensor.name}"), np.array([frame]))[0]
    return mixed(int(key), np.arange(sensor.ray_count))


def _cosines(start: Doubles, along: Doubles, half: Doubles) -> Doubles:
    """Cosine (n,) at the face by which rays enter boxes, in the axes of these; 1 from inside."""
    with np.errstate(all="ignore"):
        at = np.where(np.abs(start) > half, (np.abs(start) - half) / np.abs(along), -np.inf)
    cosine = np.abs(along)[np.arange(len(at)), at.argmax(axis=1)]
    return np.where(np.isfinite(at).any(axis=1), cosine, 1.0)


def _lawful(
    sensor: Sensor, cls: NDArray[np.uint8], t: Doubles, cosine: Doubles, chance: Doubles
) -> NDArray[np.bool_]:
    """Return a mask of the rays that return under the range law."""
    anchors = anchors_of(sensor)
    if not anchors:
        return np.ones(len(t), np.bool_)
    limit = np.array([range_for(rho, anchors) for rho in REFLECTIVITY])[cls] * np.sqrt(cosine)
    with np.errstate(over="ignore"):
        return np.asarray(chance < 1.0 / (1.0 + np.exp((t / limit - 1.0) / WIDTH)))


def _ends(sensor: Sensor, solid: Solid | None) -> Doubles:
    """Where a solid stops each ray of the whole lattice, (rays,); inf: nowhere."""
    ends = np.full(sensor.ray_count, np.inf)
    if solid is not None:
        exists = ~np.isnan(local_directions(sensor, np.arange(sensor.ray_count))[:, 0])
        ends[exists] = body_ends(sensor, solid)
    return ends


def _directions(sensor: Sensor, phase: float) -> Doubles:
    """Directions of all rays in the vehicle frame, NaN where the lens has none, (rays, 3)."""
    local = local_directions(sensor, np.arange(sensor.ray_count))
    rotation = sensor.pose.rotation()
    if phase != 0.0:
        cos, sin = np.cos(phase), np.sin(phase)
        x, y, z = rotation.T
        rotation = np.stack([x * cos + y * sin, y * cos - x * sin, z], axis=1)
    return np.stack(
        [(row[0] * local[:, 0] + row[1] * local[:, 1]) + row[2] * local[:, 2] for row in rotation], axis=1
    )


def entries(traffic: Traffic, boxes: slice, sensor: Sensor, directions: Doubles) -> Doubles:
    """Where each ray enters each whole box, (rays, boxes), inf: nowhere."""
    parts = parts_of("box", traffic.cls[boxes], traffic.size_m[boxes])
    return _entries(traffic, boxes, parts, sensor, directions)[0]


def _entries(
    traffic: Traffic, boxes: slice, parts: Parts, sensor: Sensor, directions: Doubles
) -> tuple[Doubles, Doubles, Doubles]:
    """Where each ray enters each part, (rays, parts), inf: nowhere; the sensor in the axes of the boxes (m, 3), and the
    rays (rays, m, 3)."""
    turn, half = traffic.rotation[boxes], traffic.size_m[boxes] / 2.0
    back = -(traffic.centre_m[boxes] - np.array(sensor.position))
    start = np.stack([_into(turn, back, axis) for axis in range(3)], axis=1)
    along = np.stack([_into(turn[None], directions[:, None], axis) for axis in range(3)], axis=2)
    from_part, part_along = start[parts.box] - parts.offset_m, along[:, parts.box]
    part_half = parts.half_m
    with np.errstate(all="ignore"):
        a, b = (-part_half - from_part) / part_along, (part_half - from_part) / part_along
    between = np.abs(from_part) < part_half
    flat = part_along == 0.0
    first = np.where(flat, np.where(between, -np.inf, np.inf), np.minimum(a, b))
    last = np.where(flat, np.where(between, np.inf, -np.inf), np.maximum(a, b))
    enters = np.maximum(first.max(axis=2), sensor.range_m[0])
    leaves = np.minimum(last.min(axis=2), sensor.range_m[1])
    own: NDArray[np.bool_] = np.all(np.abs(start) <= half, axis=1)
    return np.where((enters < leaves) & ~own[parts.box], enters, np.inf), start, along


def _into(turn: Doubles, v: Doubles, axis: int) -> Doubles:
    """One component of R^T v, summed from left to right."""
    return (turn[..., 0, axis] * v[..., 0] + turn[..., 1, axis] * v[..., 1]) + turn[..., 2, axis] * v[..., 2]
