"""Files that take long to make: stored POGs, simulated data sets, reports; and surveys of box data."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Literal, Unpack

from numpy.typing import ArrayLike

from riglens.arguments import BoxReading, StrPath, Warnings, reads_boxes, scene_options
from riglens.core.files import require_ending, require_writable
from riglens.core.metric.scores import DEFAULT_LAMBDA, Body, Method, Reading
from riglens.core.rig.model import Rig
from riglens.core.scene.boxes import Progress
from riglens.core.targets.settings import Phase
from riglens.core.targets.shapes import Shape
from riglens.evaluation.options import ReportOptions, SceneOptions, ScoreOptions
from riglens.results import Listing
from riglens.scenes import Scene, load_scene, with_blocking_meshes


@reads_boxes
def survey(
    *boxes: StrPath,
    progress: Progress | None = None,
    **read_as: Unpack[BoxReading],
) -> Listing:
    """Survey box data: classes, directions, distances, sizes, the ground, and what is not mapped.

    Arguments as for `load_scene`; several data sets count as one.
    """
    from riglens.evaluation.described import described

    options = scene_options(None, **read_as)
    document = described(options, [Path(one) for one in boxes], progress).document()
    rows = [
        {"class": name, "boxes": found["boxes"], **{k: sum(v) for k, v in found["sectors"].items()}}
        for name, found in document["classes"].items()
    ]
    return Listing(
        f"Survey of {document['data']['source']}: {document['data']['frames']:,} frames", document, rows
    )


@reads_boxes
def build_pog(
    *boxes: StrPath,
    out: StrPath,
    voxel_m: float | None = None,
    roi_m: ArrayLike | None = None,
    workers: int | None = None,
    dask: str | None = None,
    **read_as: Unpack[BoxReading],
) -> Scene:
    """Build the POG of box data sets together, store it for `load_scene(pog=out)`, and return the scene.

    Arguments as for `load_scene`; `workers` processes build parts at the same time, or the Dask cluster at `dask`.
    After an interruption the same call resumes.
    """
    from riglens.core.pieces.backend import Backend
    from riglens.jobs.building import build

    options = scene_options(None, voxel_m=voxel_m, roi_m=roi_m, **read_as)
    build([Path(one) for one in boxes], Path(out), options, Backend(workers, dask), Warnings())
    return load_scene(pog=out)


@reads_boxes
def simulate(
    rigs: Rig | Sequence[Rig],
    out: StrPath,
    boxes: StrPath | None = None,
    *,
    surroundings: Literal["ignored", "block"] | None = None,
    occluders: tuple[StrPath, StrPath] | None = None,
    every: int | None = None,
    sequences: int | None = None,
    clutter: int = 60,
    road: Literal["uneven", "flat", "none"] = "uneven",
    noise_m: float = 0.02,
    dropout: float = 0.05,
    shape: Shape = "class",
    range_law: bool = True,
    phase: Phase = "random",
    seed: int = 0,
    pictures: bool = True,
    points: bool = False,
    workers: int | None = None,
    dask: str | None = None,
    carla: str | None = None,
    body: Body | None = None,
    mesh_folder: StrPath = ".",
    **read_as: Unpack[BoxReading],
) -> tuple[Path, ...]:
    """Simulate what rigs measure in traffic, as data sets in nuScenes' format; return their folders.

    Boxes as for `load_traffic`, settings as for `riglens simulate`; `points` also writes the points of each frame with
    the object that each is on. After an interruption the same call resumes. With `carla`, "HOST:PORT",
    `frames` frames of one rig are collected from that simulator instead.
    """
    from riglens.core.pieces.backend import Backend
    from riglens.core.simulate.settings import SimulationSettings
    from riglens.core.simulate.units import Extras
    from riglens.jobs.simulating import DataSetJob, collect_in_carla, make_data_sets

    options = scene_options(boxes, occluders=occluders, **read_as)
    settings = SimulationSettings(seed, shape, range_law, phase, noise_m, dropout, clutter, road)
    score = ScoreOptions(body=body)
    several = with_blocking_meshes(rigs, score, mesh_folder)
    extras, backend = Extras(pictures, points), Backend(workers, dask)
    job = DataSetJob(Path(out), options, settings, extras, backend, every, sequences)
    if carla is not None:
        return (collect_in_carla(several, carla, job, Warnings()).folder,)
    job = replace(job, scene=options.surrounded(surroundings, in_town=True))
    return tuple(made.folder for made in make_data_sets(several, score, job, Warnings()))


@reads_boxes
def report(
    rigs: Rig | Sequence[Rig],
    out: StrPath,
    boxes: StrPath | None = None,
    *,
    voxel_m: float | None = None,
    roi_m: ArrayLike | None = None,
    pog: StrPath | None = None,
    requirements: StrPath | None = None,
    draws: int = ReportOptions.draws,
    seed: int = 0,
    project: str | None = None,
    revision: str | None = None,
    author: str | None = None,
    reviewer: str | None = None,
    method: Method = "exact",
    reading: Reading = "covered",
    camera_weight: float = DEFAULT_LAMBDA,
    body: Body | None = None,
    threads: int | None = None,
    mesh_folder: StrPath = ".",
    **read_as: Unpack[BoxReading],
) -> Path:
    """Write a page (.html) or PDF about rigs with every figure attached, and return its path.

    Boxes as for `load_scene`, `method` to `body` as for `score`; `requirements` are checked on the page, `draws` are
    those of the tolerance, 0 for none; project, revision, author and reviewer go into the header.
    """
    from riglens.reporting.making import write_report

    path, score = Path(out), ScoreOptions(method, reading, camera_weight, threads, body)
    options = scene_options(boxes, voxel_m=voxel_m, roi_m=roi_m, pog=pog, **read_as)
    require_ending("out", path, ".html", ".pdf")
    holds = ReportOptions(_path(requirements), draws, seed, project, revision, author, reviewer)
    require_writable(path, options.files)
    several = with_blocking_meshes(rigs, score.solid(), mesh_folder)
    write_report(several, path, options, score, holds, Warnings())
    return path


def verify_report(
    path: StrPath, boxes: StrPath | None = None, *, meshes: StrPath | None = None, threads: int | None = None
) -> bool:
    """Make an earlier report again from what is attached; return whether figures, words and pictures are the same.

    `boxes`: the data that it was made of, where that was not the bundled town; `meshes`: the folder of its car bodies.
    """
    from riglens.reporting.making import verified

    options, score = SceneOptions(boxes=_path(boxes)), ScoreOptions(threads=threads)
    return verified(Path(path), options, score, _path(meshes), Warnings()).place is None


def _path(path: StrPath | None) -> Path | None:
    return None if path is None else Path(path)
