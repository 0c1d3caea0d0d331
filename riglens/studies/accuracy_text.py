"""Describe the accuracy study in words and as CSV: names of points, inputs, and findings."""

from __future__ import annotations

import os
from collections.abc import Iterator

from riglens.core.rig.model import Rig
from riglens.core.scene.boxes import CLASSES
from riglens.core.scene.grid import DEFAULT_VOXEL_M
from riglens.core.shown_text import visible
from riglens.core.study.accuracy import AccuracyStudy, MethodName, Point, Wrong
from riglens.studies.files import csv_text

TITLES: dict[MethodName, str] = {
    "exact": "exact engine",
    "edit-camera": "exact engine, one camera moved",
    "edit-lidar": "exact engine, one LiDAR moved",
    "plain": "plain DDA",
    "plain-single": "plain DDA, single precision",
    "bresenham": "Bresenham",
    "rectangles": "bounding rectangles",
    "centres": "voxel centres in view",
}


def edge_text(voxel_m: float) -> str:
    """Return a voxel edge as δ in metres, with two decimals where they are enough."""
    text = f"{voxel_m:.2f}"
    return f"δ {text if float(text) == voxel_m else f'{voxel_m:g}'} m"


def point_text(point: Point, study: AccuracyStudy) -> str:
    """Name a point by its method and by what differs from the study's own setting."""
    if point.lattice == "all pixels":
        return "exact, all camera pixels"
    if point.lattice != "own":
        return f"exact, {point.lattice} of the rays"
    if point.voxel_m != study.voxel_m:
        return f"exact, {edge_text(point.voxel_m)}"
    return own_text(study) if point.is_own else TITLES[point.method]


def own_text(study: AccuracyStudy) -> str:
    """Name the setting, as the default where it is the default."""
    setting = _setting(study)
    return f"default: {setting}" if study.voxel_m == DEFAULT_VOXEL_M else setting


def _setting(study: AccuracyStudy) -> str:
    return f"exact, {edge_text(study.voxel_m)}, {lattice_text(study.rig)}"


def lattice_text(rig: Rig) -> str:
    """Return the ray lattice of the cameras, of the LiDARs where there are none."""
    casts = {camera.resolution for camera in rig.enabled_cameras()}
    sizes = casts or {(len(lidar.elevations()), len(lidar.azimuths())) for lidar in rig.enabled_lidars()}
    return " × ".join(map(str, next(iter(sizes)))) if len(sizes) == 1 else "lattices of several sizes"


def sensors_text(rig: Rig) -> str:
    """Describe a rig's sensors: their number and lattices."""
    parts = []
    for name, sizes in (
        ("camera", [camera.resolution for camera in rig.enabled_cameras()]),
        ("LiDAR", [(len(lidar.elevations()), len(lidar.azimuths())) for lidar in rig.enabled_lidars()]),
    ):
        if sizes:
            shown = " × ".join(map(str, sizes[0])) if len(set(sizes)) == 1 else "various"
            parts.append(f"{len(sizes)} {name}{'s' if len(sizes) > 1 else ''} {shown}")
    return ", ".join(parts)


def caption(study: AccuracyStudy, source: str) -> str:
    """Describe the measurement in one line: methods, data and number of threads."""
    count, processors = study.plan.repetitions, os.cpu_count() or 1
    runs = f"median of {count} alternating runs" if count > 1 else "one run"
    return (
        f"{source}, {study.frames:,} frames · rig {visible(study.rig.name)}: {sensors_text(study.rig)} · "
        f"{study.own.threads} threads on {processors} processors (plain DDA: 1) · {runs}"
    )


def verdicts(study: AccuracyStudy) -> Iterator[str]:
    """Return the findings, one sentence each."""
    yield _voxel_verdict(study)
    yield _score_verdict(study)
    if study.finest_m != study.voxel_m:
        yield _grid_verdict(study)


def _named(study: AccuracyStudy) -> str:
    what = "default" if study.voxel_m == DEFAULT_VOXEL_M else "requested setting"
    return f"The {what} ({_setting(study)})"


def _voxel_verdict(study: AccuracyStudy) -> str:
    own = study.own
    if own.on_voxel_front:
        faster = [p for p in study.points if p.on_voxel_front and p.median_ms < own.median_ms]
        if not faster:
            return f"{_named(study)} lies on the Pareto front of wrong voxels, as its fastest point."
        least = min(faster, key=lambda p: p.voxel_error or 0.0)
        return (
            f"{_named(study)} lies on the Pareto front of wrong voxels; the best that is faster, "
            f"{point_text(least, study)}, has {percent(least.voxel_error or 0.0)} of the voxels wrong."
        )
    better = _better(study, own, [p.voxel_error for p in study.points], own.voxel_error or 0.0)
    return (
        f"{_named(study)} does not lie on the Pareto front of wrong voxels: {better} is faster and no worse."
    )


def _score_verdict(study: AccuracyStudy) -> str:
    own = study.own
    if own.on_score_front:
        return f"For S-MS against {edge_text(study.finest_m)} it lies on the Pareto front."
    better = _better(study, own, [p.score_error for p in study.points], own.score_error)
    return f"For S-MS against {edge_text(study.finest_m)} it does not: {better} is faster and no worse."


def _better(study: AccuracyStudy, own: Point, errors: list[float | None], mine: float) -> str:
    """Return the fastest point that is at least as good as one that is not on the front."""
    rivals = [
        p
        for p, error in zip(study.points, errors, strict=True)
        if p.from_scratch
        and p is not own
        and error is not None
        and error <= mine
        and p.median_ms <= own.median_ms
    ]
    return point_text(min(rivals, key=lambda p: p.median_ms), study)


def _grid_verdict(study: AccuracyStudy) -> str:
    """Describe how S-MS depends on the voxel edge, for the class with the largest effect."""
    errors = {
        cls: error.grid_error for cls, error in study.own.errors.items() if error.grid_error is not None
    }
    if not errors:
        return "The rig sees no entropy, so S-MS does not depend on the voxel edge."
    worst = max(errors, key=lambda cls: errors[cls])
    mine, finest = (point.errors[worst].share or 0.0 for point in (study.own, study.finest))
    return (
        f"S-MS depends on δ: as a share of H(Ω) it is {percent(mine)} at {edge_text(study.voxel_m)} and "
        f"{percent(finest)} at {edge_text(study.finest_m)} ({worst}). Compare scores on one grid only."
    )


def percent(share: float) -> str:
    """Return a fraction as percent with two or three significant digits."""
    value = 100.0 * share
    return (
        f"{value:.0f} %"
        if value >= 100.0
        else f"{value:.3g} %"
        if value >= 0.01 or value == 0.0
        else f"{value:.1e} %"
    )


def accuracy_csv(study: AccuracyStudy) -> str:
    """Return all points as CSV in full precision; empty where a figure does not exist."""
    return csv_text([_csv_row(point) for point in study.points])


def _csv_row(point: Point) -> dict[str, object]:
    wrong = point.wrong or (None,) * len(Wrong._fields)
    row: dict[str, object] = {
        "method": point.method,
        "voxel_m": point.voxel_m,
        "lattice": point.lattice,
        "rays": point.rays,
        "threads": point.threads,
        "median_ms": point.median_ms,
        "least_ms": min(point.times_ms),
        "most_ms": max(point.times_ms),
        "runs": len(point.times_ms),
        **dict(zip(Wrong._fields, wrong, strict=True)),
    }
    for cls in CLASSES:
        errors = point.errors[cls]._asdict()
        row |= {f"s_ms_{cls}": point.s_ms[cls]} | {f"{name}_{cls}": value for name, value in errors.items()}
    row |= {"score_error": point.score_error, "from_scratch": point.from_scratch}
    return row | {"on_voxel_front": point.on_voxel_front, "on_score_front": point.on_score_front}
