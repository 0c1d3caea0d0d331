"""Draw where a rig's sensors sit and what they resolve: the car with numbers, footprints, bearings, blind ground."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from riglens.core.blind.zones import HEIGHTS_M, BlindMap
from riglens.core.footprint.ground import EN_62676_4, Footprint, has_footprint
from riglens.core.rig.model import Rig, Sensor
from riglens.core.sensors.registry import kind_of
from riglens.reporting.svg import (
    DEGREES,
    GAIN,
    INK,
    LINE,
    LOSS,
    LOSS_TEXT,
    PANEL,
    SOFT,
    Drawing,
    Point,
    apart,
)

Figures = dict[str, Any]
UNITS_PER_M = 62.0
"""Of the outlines of a car."""
TINTS = (1.0, 0.72, 0.46, 0.24)
"""Opacity of bands, from the finest."""
NARROW_DEG = 6.0
"""Overlaps below are marked: our choice."""
_AROUND_M = 2.3
_LEAST_NUMBERED = 0.1
"""Reach of a footprint that has room for a number, as a share of that of the plan."""
_MOST_BEYOND_M = 120.0
_LEAST_RING_MM = 14.0
"""Radius of a ring that has room for its distance beside the numbers of sensors."""


@dataclass(frozen=True)
class CarShape:
    """Outlines of a car as paths of an SVG, UNITS_PER_M, around the origin of the vehicle frame: from above with ahead
    up, from the left with ahead to the left."""

    above: str
    beside: str


@dataclass(frozen=True)
class CarPicture:
    """Picture of a rig's car as a PNG, its size in pixels, and where in it each sensor is, in pixels."""

    png: bytes
    size: tuple[int, int]
    sensors: tuple[Point, ...]


def above(middle: Point, mm_per_m: float, x_m: float, y_m: float) -> Point:
    """Return the place on a plan, ahead up, of a place of the vehicle frame."""
    return middle[0] - y_m * mm_per_m, middle[1] - x_m * mm_per_m


def draw_car(drawing: Drawing, path: str, at: Point, mm_per_m: float, fill: str = PANEL) -> None:
    """Draw an outline of the car at a scale."""
    drawing.outline(path, at, mm_per_m / UNITS_PER_M, fill)


def numbered_picture(key: str, picture: CarPicture, called: str) -> Drawing:
    """Return the picture of a car with the numbers of its sensors."""
    wide, high = 104.0, 104.0 * picture.size[1] / picture.size[0]
    drawing = Drawing(
        f"{key}-car", wide, high, f"{called}: the car with its sensors, numbered as in the table of sensors"
    )
    drawing.image(picture.png, 0.0, 0.0, wide, high)
    scale = wide / picture.size[0]
    dots = [(x * scale, y * scale) for x, y in picture.sensors]
    places = apart(dots, (wide, high), 2.0, 9.0)
    for dot, place in zip(dots, places, strict=True):
        drawing.line([dot, place], "#ffffff", 0.7)
        drawing.line([dot, place], "#1b2430", 0.22)
    for number, place in enumerate(places, 1):
        drawing.badge(place, number)
    return drawing


# ---------------------------------------------------------------- what resolves what
def footprint_plan(
    key: str, rig: Rig, found: Sequence[Footprint], figures: Figures, shape: CarShape
) -> Drawing:
    """Return the footprints to scale with bands, rings of distance, and how far LiDARs hold a pedestrian."""
    wide, high = 112.0, 116.0
    held = _held(rig, figures)
    reach = max([*(_reach_m(one) for one in found if _has_pixels(one)), *(far for _, far in held), 20.0])
    reach = min(reach, _MOST_BEYOND_M)
    middle, scale = (wide / 2, 54.0), 53.0 / reach
    drawing = Drawing(
        f"{key}-plan", wide, high, "Plan of what the sensors resolve on the ground, ahead up, to scale"
    )
    for one in found:
        _draw_bands(drawing, one, middle, scale)
    _draw_rings(drawing, middle, scale, reach, held)
    draw_car(drawing, shape.above, middle, scale, "#ffffff")
    drawing.clip(wide, 108.5)
    far = [one for one in found if one.reach_m is not None and one.reach_m[1] > _LEAST_NUMBERED * reach]
    starts = [_middle_of(one, middle, scale, reach) for one in far]
    for one, place in zip(far, apart(starts, (wide, 108.0), 2.0, 0.0), strict=True):
        drawing.badge(place, rig.sensors.index(one.sensor) + 1)
    if any(_has_pixels(one) for one in found):
        for number, (limit, tint) in enumerate(zip(EN_62676_4, TINTS, strict=True)):
            drawing.rect(17.0 * number, 110.0, 17.0, 2.2, GAIN, 0.8 * tint)
            drawing.text(17.0 * number, 115.2, f"≥ {limit:g}")
        drawing.text(70.0, 112.0, "pixels per metre", colour=SOFT)
        drawing.text(70.0, 115.2, "(steps of EN 62676-4)", colour=SOFT)
    return drawing


def _draw_bands(drawing: Drawing, found: Footprint, middle: Point, scale: float) -> None:
    """Draw a footprint: bands of pixels in tints of blue, reach of other sensors in grey."""
    fill, edge, tints = (
        (GAIN, "#ffffff", TINTS) if _has_pixels(found) else (SOFT, SOFT, (0.1,) * len(found.bands))
    )
    for band, tint in zip(found.bands, tints, strict=True):
        for patch in band.patches:
            drawing.area(
                [above(middle, scale, x, y) for x, y in patch.tolist()], fill, 0.8 * tint, edge, 0.15
            )


def _draw_rings(
    drawing: Drawing, middle: Point, scale: float, reach: float, held: Sequence[tuple[float, float]]
) -> None:
    """Draw rings of distance, and how far a pedestrian is held in each direction."""
    step = next(step for step in (5, 10, 20, 25) if reach / step <= 6.0)
    rings = range(step, math.ceil(reach) + 1, step)
    for ring in rings:
        drawing.circle(middle, ring * scale, stroke=INK, width=0.12, dash="0.6 0.8")
    if held:
        line = [above(middle, scale, far * math.cos(turn), far * math.sin(turn)) for turn, far in held]
        drawing.area(line, "none", 1.0, INK, 0.55)
    for ring in rings:
        if ring * scale >= _LEAST_RING_MM:
            x, y = middle[0] - ring * scale * math.sin(1.4), middle[1] - ring * scale * math.cos(1.4)
            drawing.text(x, y + 0.9, f"{ring} m", "middle", SOFT, halo=True)


def _has_pixels(found: Footprint) -> bool:
    """Return whether bands are of pixels per metre, not of classes that are reached."""
    return any(math.isfinite(band.limit) for band in found.bands)


def _held(rig: Rig, figures: Figures) -> list[tuple[float, float]]:
    """Return bearings in radians with the least distance to which sensors without a footprint hold a pedestrian."""
    there = {sensor.kind for sensor in rig.sensors if sensor.enabled and not has_footprint(sensor)}
    farthest: dict[float, float] = {}
    for row in figures["range"]["rigs"][0]["rows"]:
        for kind in there & row.keys() if row["class"] == "pedestrian" else ():
            least = row[kind]["first_below_m"]["min"]
            far = figures["range"]["to_m"] if least is None else least
            turn = math.radians(row["bearing_deg"])
            farthest[turn] = max(far, farthest.get(turn, 0.0))
    return list(farthest.items())


def _reach_m(found: Footprint) -> float:
    return max(
        (float(np.hypot(*patch.T).max()) for band in found.bands for patch in band.patches), default=0.0
    )


def _middle_of(found: Footprint, middle: Point, scale: float, reach: float) -> Point:
    """Return the middle of a footprint on the plan, within the reach of it."""
    patch = max(
        (patch for band in found.bands for patch in band.patches),
        key=lambda one: float(np.ptp(one, axis=0).sum()),
    )
    x, y = patch.mean(axis=0)
    far = max(float(np.hypot(x, y)), 1e-6)
    share = min(1.0, 0.62 * reach / far)
    return above(middle, scale, float(x) * share, float(y) * share)


# ---------------------------------------------------------------- where the sensors sit
def seats(key: str, rig: Rig, shape: CarShape) -> Drawing:
    """Return the car from above and from the left with its sensors, numbered; kinds differ by their form."""
    length, width = rig.vehicle.length, rig.vehicle.width
    spots = np.array([one.position for one in rig.sensors]).reshape(-1, 3)
    low = np.minimum(spots.min(axis=0, initial=0.0), [-length / 2, -width / 2, 0.0])
    high = np.maximum(spots.max(axis=0, initial=0.0), [length / 2, width / 2, rig.vehicle.height])
    scale = min(
        61.0 / (high[0] - low[0] + 0.4), 66.0 / (high[0] - low[0] + 0.8), 40.0 / (high[1] - low[1] + 0.6)
    )
    tall, wide = (high[0] - low[0]) * scale + 8.0, 61.0
    drawing = Drawing(
        f"{key}-seats",
        wide,
        round(tall + (high[2] + 0.5) * scale + 7.0, 1),
        "Where the sensors sit, from above and from the left",
    )
    middle = (wide / 2 + float(high[1] + low[1]) / 2 * scale, 4.0 + float(high[0]) * scale)
    draw_car(drawing, shape.above, middle, scale)
    dots = [above(middle, scale, x, y) for x, y, _ in spots.tolist()]
    for sensor, dot in zip(rig.sensors, dots, strict=True):
        _mark(drawing, sensor, dot)
    places = apart(dots, (wide, tall), 2.0, 6.0)
    for number, (dot, place) in enumerate(zip(dots, places, strict=True), 1):
        drawing.line([dot, place], INK, 0.18)
        drawing.badge(place, number)
    ground = tall + (float(high[2]) + 0.35) * scale
    left = wide / 2 + float(high[0] + low[0]) / 2 * scale
    drawing.line([(0.0, ground), (wide, ground)], INK, 0.25)
    draw_car(drawing, shape.beside, (left, ground), scale)
    for sensor in rig.sensors:
        x, _, z = sensor.position
        fill = "#ffffff" if has_footprint(sensor) else GAIN
        drawing.circle((left - x * scale, ground - z * scale), 0.9, fill, GAIN, 0.45)
    if len(rig.sensors):
        top = int(np.argmax(spots[:, 2]))
        x, _, z = spots[top].tolist()
        drawing.text(left - x * scale + 2.0, ground - z * scale - 0.6, f"{top + 1}: {z:.2f} m", halo=True)
    drawing.line([(1.0, ground + 3.0), (1.0 + scale, ground + 3.0)], INK, 0.35)
    drawing.text(2.5 + scale, ground + 3.8, "1 m")
    drawing.text(wide, ground + 3.8, "ahead is up, and left", "end", SOFT)
    return drawing


def _mark(drawing: Drawing, sensor: Sensor, at: Point) -> None:
    """Mark a sensor from above by its field of view, a disc if it sees all around; white if it makes no picture."""
    kind = kind_of(sensor)
    view = kind.view_deg(sensor)[0]
    if not math.isfinite(view) or view >= 359.0:
        drawing.circle(at, 1.3, GAIN, "#ffffff", 0.3)
        return
    makes_pictures = has_footprint(sensor) and kind.in_field is None
    ahead, length = sensor.pose.rotation()[:, 0], 4.2 if makes_pictures else 2.8
    yaw, half = math.atan2(ahead[1], ahead[0]), math.radians(view / 2)
    turns = [yaw - half + half * step / 4 for step in range(9)]
    arc = [(at[0] - length * math.sin(turn), at[1] - length * math.cos(turn)) for turn in turns]
    if makes_pictures:
        drawing.area([at, *arc], GAIN, 0.75, "#ffffff")
    else:
        drawing.area([at, *arc], "#ffffff", 1.0, GAIN, 0.3)


def bearing_strip(key: str, rig: Rig, document: Figures) -> Drawing | None:
    """Return the bearings that each camera's picture shows at the horizon, and what neighbours share; None without a
    camera that shows any."""
    ends = {one["name"]: one["bearings_deg"] for one in document["sensors"] if one.get("bearings_deg")}
    cameras = [(number, one) for number, one in enumerate(rig.sensors, 1) if one.name in ends]
    if not cameras:
        return None
    wide, left, right, row = 178.0, 42.0, 176.0, 4.1
    bottom = 5.0 + row * len(cameras)
    drawing = Drawing(f"{key}-bearings", wide, bottom + 4.5, "Bearings that the cameras' pictures show")

    def across(bearing_deg: float) -> float:
        return left + (180.0 - bearing_deg) / 360.0 * (right - left)

    for turn, name in ((180, "behind"), (90, "left"), (0, "ahead"), (-90, "right"), (-180, "behind")):
        drawing.line([(across(turn), 1.0), (across(turn), bottom)], LINE)
        drawing.text(across(turn), bottom + 3.4, name, "end" if turn == -180 else "middle", SOFT)
    for shared in document["overlaps"]:
        if shared["right"] not in ends or shared["left"] not in ends:
            continue
        wide_deg = shared["overlap_deg"]
        start = ends[shared["left"]][0]
        is_bad = wide_deg < NARROW_DEG
        for from_deg, to_deg in _unwrapped(min(start, start + wide_deg), max(start, start + wide_deg)):
            drawing.rect(
                across(to_deg),
                1.0,
                across(from_deg) - across(to_deg),
                bottom - 1.0,
                LOSS if is_bad else SOFT,
                0.3 if is_bad else 0.18,
            )
        middle = math.remainder(start + wide_deg / 2, 360.0)
        words = f"{wide_deg:.0f}°".replace("-", "−")
        drawing.text(across(middle), 3.2, words, "middle", LOSS_TEXT if is_bad else INK, True, halo=True)
    drawing.text(0.0, 3.2, "shared", colour=SOFT)
    for place, (number, camera) in enumerate(cameras):
        y = 5.2 + row * place
        drawing.text(0.0, y + 2.2, f"{number} {_short(camera.name)}")
        for from_deg, to_deg in _unwrapped(*ends[camera.name]):
            drawing.rect(across(to_deg), y, across(from_deg) - across(to_deg), 2.5, GAIN, 0.7)
    return drawing


def _short(name: str, most: int = 24) -> str:
    return name if len(name) <= most else f"{name[: most - 1]}…"


def _unwrapped(from_deg: float, to_deg: float) -> Iterator[tuple[float, float]]:
    """Yield the parts of a range of bearings within -180 to 180 degrees."""
    for turn in (-360.0, 0.0, 360.0):
        low, high = max(from_deg + turn, -180.0), min(to_deg + turn, 180.0)
        if low < high:
            yield low, high


# ---------------------------------------------------------------- beside the car
def blind_plan(key: str, found: BlindMap, document: Figures, shape: CarShape) -> Drawing:
    """Return the ground beside the car by the height from which an object is seen there, with the test objects."""
    outline = found.ground.outline
    half_x = max(outline.front_m, -outline.rear_m) + _AROUND_M
    half_y = max(outline.left_m, -outline.right_m) + _AROUND_M
    wide = 80.0
    scale = min(wide / 2 / half_y, 78.0 / 2 / half_x)
    middle = (wide / 2, half_x * scale)
    high = 2.0 * half_x * scale
    drawing = Drawing(
        f"{key}-blind",
        86.0,
        round(high + 8.0, 1),
        "Ground beside the car by the height from which an object is seen, with test objects",
    )
    steps = _steps_around(found, half_x, half_y)
    side = found.grid.voxel_m * scale
    corner = (middle[0] - steps.shape[1] / 2 * side, middle[1] - steps.shape[0] / 2 * side)
    for step, colour in enumerate(DEGREES, 1):
        drawing.cells(steps >= step, corner, side, colour)
    for beyond in (1.0, 2.0):
        x, y = above(middle, scale, outline.front_m + beyond, outline.left_m + beyond)
        drawing.rect(
            x, y, (outline.width_m + 2 * beyond) * scale, (outline.length_m + 2 * beyond) * scale, "none",
            stroke=INK, radius=beyond * scale, dash="0.7 0.8",
        )  # fmt: skip
        corner = above(middle, scale, outline.front_m + 0.72 * beyond, outline.right_m - 0.72 * beyond)
        drawing.text(corner[0] + 0.6, corner[1] - 0.4, f"{beyond:g} m", colour=SOFT, halo=True)
    draw_car(drawing, shape.above, middle, scale)
    for one in (
        one for profile in document["profiles"] if profile["for_this_vehicle"] for one in profile["objects"]
    ):
        at = above(middle, scale, one["x_m"], one["y_m"])
        drawing.circle(at, 0.62, GAIN if one["seen"] else "#ffffff", GAIN if one["seen"] else "#1b2430", 0.4)
    drawing.clip(wide, high)
    for place, (colour, height) in enumerate(zip(DEGREES, HEIGHTS_M, strict=True)):
        drawing.rect(13.0 * place, high + 1.6, 13.0, 2.2, colour)
        drawing.text(13.0 * place, high + 6.8, f"> {height:.2f} m")
    drawing.text(67.0, high + 3.6, "seen only", colour=SOFT)
    drawing.text(67.0, high + 6.8, "where taller", colour=SOFT)
    return drawing


def _steps_around(found: BlindMap, half_x_m: float, half_y_m: float) -> NDArray[np.int64]:
    """Return the step of height of each cell around the car, (rows, columns) with ahead up; 0 within the car."""
    steps = found.steps("any", 1).astype(np.int64)
    steps[~found.ground.counts] = 0
    edge = found.grid.voxel_m
    rows, columns = (
        min(size, 2 * round(half / edge))
        for size, half in zip(steps.shape, (half_x_m, half_y_m), strict=True)
    )
    top, left = ((size - part) // 2 for size, part in zip(steps.shape, (rows, columns), strict=True))
    return steps[top : top + rows, left : left + columns][::-1, ::-1]
