"""`riglens study accuracy --sensor`: sensors of the library measured; table and findings, chart, CSV and JSON."""

from __future__ import annotations

import json
import os
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

from riglens.core.files import write_file
from riglens.core.monitor import Monitor
from riglens.core.shown_tables import Block, ShownTable, Styled, table
from riglens.core.shown_text import visible
from riglens.core.study.sensor_methods import (
    QUICK_REPETITIONS,
    REPETITIONS,
    MethodName,
    SensorPoint,
    SensorResult,
    SensorStudy,
    sensors_at,
    study_sensors,
)
from riglens.evaluation.loading import load_rig, load_scene
from riglens.evaluation.options import SceneOptions, ScoreOptions
from riglens.studies.accuracy_text import edge_text, percent
from riglens.studies.files import csv_text, require_folder
from riglens.studies.pictures import PICTURES, write_pictures
from riglens.studies.sensor_methods_chart import chart

NAME = "accuracy-sensors"
FILES = (*(f"{NAME}.{file_format}" for file_format in PICTURES), f"{NAME}.csv", f"{NAME}.json")
TITLES: dict[MethodName, str] = {
    "fast": "RigLens",
    "walk": "exact walk, ray by ray",
    "plain": "plain DDA",
    "plain-single": "plain DDA, single precision",
    "bresenham": "Bresenham",
    "sampled": "points on rays, every",
    "thinned": "RigLens with fewer rays,",
    "rectangles": "bounding rectangles",
    "centres": "voxel centres in view",
}


def study(
    rig_name: str,
    models: Sequence[str],
    scene: SceneOptions,
    score: ScoreOptions,
    folder: Path,
    quick: bool,
    monitor: Monitor,
) -> list[Block]:
    """Measure time and error of all ways for sensors of the library, write the results into a folder and return
    them."""
    rig = load_rig(rig_name, monitor)
    sensors_at(rig, models)
    require_folder(folder, FILES)
    _, field = load_scene(scene, monitor)
    repetitions = QUICK_REPETITIONS if quick else REPETITIONS
    with monitor.stage("Measuring") as progress:
        found = study_sensors(field, rig, models, score.threads or 1, repetitions, progress)
    source = field.data.short_source
    _write(found, source, folder)
    files = f"{', '.join(FILES)} in {folder}"
    return [sensor_table(found), *verdicts(found), "", caption(found, source), files]


def _write(found: SensorStudy, source: str, folder: Path) -> None:
    write_file(folder / f"{NAME}.csv", csv_text([*_rows(found)]))
    write_file(folder / f"{NAME}.json", json.dumps(as_json(found), indent=1) + "\n")
    write_pictures(chart(found, caption(found, source)), folder, NAME)


def point_text(point: SensorPoint) -> str:
    """Name a way with its setting."""
    unit = {"sampled": " voxel", "thinned": " of them"}.get(point.method, "")
    return f"{TITLES[point.method]} {point.setting}{unit}" if point.setting else TITLES[point.method]


def sensor_table(found: SensorStudy) -> ShownTable:
    """Return a table with a block per sensor and pose and a line per method."""
    titles = ("rays", "median\nms", "times\nRigLens", "missed\nvoxels", "extra\nvoxels")
    made = table("sensor, pose, way", *titles)
    for result in found.results:
        made.add_row(Styled(f"{visible(result.model)}, {result.pose}, sees {result.voxels:,} voxels", "bold"))
        fast_ms = result.point("fast").median_ms
        for point in result.points:
            made.add_row(
                f"  {point_text(point)}", f"{point.rays:,}", f"{point.median_ms:.3g}",
                f"{point.median_ms / fast_ms:.3g}", percent(point.missed), percent(point.extra),
            )  # fmt: skip
        made.add_section()
    return made


def verdicts(found: SensorStudy) -> Iterator[str]:
    """Return one sentence per sensor and pose."""
    return map(_verdict, found.results)


def _verdict(result: SensorResult) -> str:
    fast, walk, plain = result.point("fast"), result.point("walk"), result.point("plain")
    exact = (
        "the voxels of the exact walk" if result.is_exact else f"WRONG in {percent(fast.error)} of the voxels"
    )
    return (
        f"{visible(result.model)}, {result.pose}: RigLens {fast.median_ms:.3g} ms, {exact}; walking every ray takes "
        f"{walk.median_ms / fast.median_ms:.2g} times as long, plain DDA {plain.median_ms / fast.median_ms:.2g} times "
        f"with {percent(plain.error)} of the voxels wrong; {_quicker(result)}."
    )


def _quicker(result: SensorResult) -> str:
    """Name the methods that are faster than RigLens, and their price."""
    fast = result.point("fast")
    quicker = [p for p in result.points if p.median_ms < fast.median_ms and p.method != "fast"]
    if not quicker:
        return "nothing is faster"
    best = min(quicker, key=lambda p: (p.error, p.median_ms))
    if best.error == 0.0:
        return f"{point_text(best)} is faster and equally correct here"
    return f"of the faster ones, {point_text(best)} has the fewest errors: {percent(best.error)}"


def caption(found: SensorStudy, source: str) -> str:
    """Describe the measurement in one line: methods, data and number of threads."""
    count = found.repetitions
    runs = f"median of {count} alternating runs" if count > 1 else "one run"
    threads = f"{found.threads} thread{'s' if found.threads > 1 else ''} of {os.cpu_count() or 1} processors"
    return (
        f"{source}, {found.frames:,} frames · {edge_text(found.voxel_m)} · places of rig {visible(found.rig.name)} · "
        f"one sensor moved, three classes scored · {threads} (dense grids: 1) · {runs}"
    )


def as_json(found: SensorStudy) -> dict[str, Any]:
    """Return all measurements in full precision; shares are fractions of `voxels`."""
    return {
        "riglens": 1,
        "voxel_m": found.voxel_m,
        "data": {"source": found.source, "frames": found.frames, "sha256": found.sha256},
        "rig": found.rig.name,
        "threads": found.threads,
        "repetitions": found.repetitions,
        "sensors": [_result_json(result) for result in found.results],
    }


def _result_json(result: SensorResult) -> dict[str, Any]:
    sensor = result.sensor
    return {
        "model": result.model,
        "kind": sensor.kind,
        "pose": result.pose,
        "position_m": list(sensor.position),
        "rpy_deg": list(sensor.rpy_deg),
        "rays": sensor.ray_count,
        "voxels": result.voxels,
        "methods": [
            {
                "method": p.method,
                "setting": p.setting or None,
                "rays": p.rays,
                "median_ms": p.median_ms,
                "times_ms": list(p.times_ms),
                "missed": p.missed,
                "extra": p.extra,
            }
            for p in result.points
        ],
    }


def _rows(found: SensorStudy) -> Iterator[dict[str, object]]:
    for result in found.results:
        for p in result.points:
            roll_deg, pitch_deg, yaw_deg = result.sensor.rpy_deg
            yield {
                "model": result.model, "pose": result.pose,
                "roll_deg": roll_deg, "pitch_deg": pitch_deg, "yaw_deg": yaw_deg, "voxel_m": found.voxel_m,
                "method": p.method, "setting": p.setting, "rays": p.rays, "threads": found.threads,
                "median_ms": p.median_ms, "least_ms": min(p.times_ms), "most_ms": max(p.times_ms),
                "runs": len(p.times_ms), "voxels": result.voxels, "missed": p.missed, "extra": p.extra,
            }  # fmt: skip
