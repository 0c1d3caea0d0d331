"""Reviews of a rig: blind zones, detection range, redundancy, tolerance, mounts, requirements, and all in one go."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import cache
from pathlib import Path

from riglens.arguments import StrPath, Warnings
from riglens.core.blind.zones import BlindSettings
from riglens.core.engine.audit import audit as audit_rig
from riglens.core.errors import InputError
from riglens.core.figures.evaluated import Evaluator
from riglens.core.footprint.document import footprints_document, footprints_of, solid_rig
from riglens.core.footprint.ground import EN_62676_4, Footprint
from riglens.core.footprint.ground import footprint as footprint_of
from riglens.core.metric.scores import Body, Method
from riglens.core.review.documents import mounts_review_document
from riglens.core.review.mounts import USUAL_LIMITS, mounts_of, violations
from riglens.core.review.profiles import profiles_in
from riglens.core.review.tolerance import SAMPLE_FRAMES, ToleranceOptions
from riglens.core.rig.edits import damaged as damaged_rig
from riglens.core.rig.model import Rig, Sensor
from riglens.core.scene.boxes import Progress
from riglens.core.targets.detection_range import RangePlan, around
from riglens.core.targets.settings import TargetSettings
from riglens.core.targets.traffic import Traffic
from riglens.evaluation.options import ScoreOptions
from riglens.results import (
    AuditResult,
    BlindResult,
    CheckResult,
    FootprintResult,
    MountsResult,
    RangeResult,
    RedundancyResult,
    Result,
    ReviewResult,
    ToleranceResult,
)
from riglens.scenes import Scene, load_scene, with_blocking_mesh, with_blocking_meshes
from riglens.traffic import load_traffic


def blind(
    rig: Rig,
    *,
    width_m: float = 0.3,
    within_m: float = 20.0,
    voxel_m: float = 0.1,
    profiles: Sequence[StrPath] = (),
    threads: int | None = None,
    mesh_folder: StrPath = ".",
) -> BlindResult:
    """Find the ground beside the car where an object is unseen, and judge test objects. The car is solid.

    Parameters
    ----------
    width_m
        Width of the object; 0 for single columns of voxels.
    within_m
        Maximum distance from the car's outline.
    voxel_m
        Edge of a voxel.
    profiles
        Files of profiles of your own, instead of those that ship with the program.
    """
    from riglens.jobs.reviewing import blind_zones

    ScoreOptions(threads=threads)
    settings, judged = (
        BlindSettings(voxel_m, width_m, within_m=within_m),
        profiles_in(list(map(Path, profiles))),
    )
    rig = with_blocking_mesh(rig, "blocks", mesh_folder)
    return BlindResult(*blind_zones(rig, settings, judged, threads, Warnings()))


def detection_range(
    rig: Rig,
    *,
    min_points: int = 5,
    min_height_px: float = 25.0,
    directions: int = 8,
    to_m: float = 150.0,
    reaction_s: float = 1.0,
    deceleration_mps2: float = 5.0,
    threads: int | None = None,
    mesh_folder: StrPath = ".",
) -> RangeResult:
    """Find up to which distance a rig detects one object in the open, by class and direction. The car is solid.

    Parameters
    ----------
    min_points, min_height_px
        LiDAR points, and height in native pixels of a camera, that detect an object.
    directions
        Number of directions around the car, the first one ahead.
    to_m
        Maximum distance.
    reaction_s, deceleration_mps2
        How the car brakes (our choice).
    """
    from riglens.jobs.reviewing import detection_range as range_of

    ScoreOptions(threads=threads)
    plan = RangePlan(
        min_points,
        min_height_px,
        around(directions),
        to_m,
        reaction_s=reaction_s,
        deceleration_mps2=deceleration_mps2,
    )
    return RangeResult(range_of(with_blocking_mesh(rig, "blocks", mesh_folder), plan, threads))


def redundancy(
    rig: Rig,
    scene: Scene,
    traffic: Traffic | None = None,
    *,
    min_points: int = 5,
    halves: bool = False,
    method: Method = "exact",
    body: Body | None = None,
    threads: int | None = None,
    mesh_folder: StrPath = ".",
) -> RedundancyResult:
    """Find what one, two and three sensors cover, and what is lost when sensors, pairs or groups fail.

    With `traffic`, objects are counted too: LiDARs detect them by `min_points` points of all, a camera by 25 px of
    height. With `halves` the losses by each sensor with half of its view blocked are listed as well.
    """
    from riglens.jobs.reviewing import evaluator_of

    options = ScoreOptions(method, threads=threads, body=body)
    rig = with_blocking_mesh(rig, options.body_of(rig), mesh_folder)
    return _redundancy(evaluator_of(scene.field, traffic, options), rig, min_points, halves)


def _redundancy(evaluate: Evaluator, rig: Rig, min_points: int, halves: bool) -> RedundancyResult:
    from riglens.jobs.reviewing import redundancy_of

    found = redundancy_of(evaluate, rig, TargetSettings(min_points=min_points), True, halves, Warnings())
    return RedundancyResult(found.document(), rig, found.voxels, found.targets)


def tolerance(
    rig: Rig,
    scene: Scene,
    traffic: Traffic | None = None,
    *,
    errors: str = "assembly",
    draws: int = 64,
    seed: int = 0,
    sample: int = SAMPLE_FRAMES,
    sensitivities: bool = True,
    method: Method = "exact",
    body: Body | None = None,
    threads: int | None = None,
    mesh_folder: StrPath = ".",
    progress: Progress | None = None,
) -> ToleranceResult:
    """Find how much a rig's figures spread under small errors of its mounts, or of the stance of the car.

    Parameters
    ----------
    traffic
        With it, objects are counted too, in `sample` frames.
    errors
        Which errors: "assembly", "service", "brackets", "ride" or "load".
    draws, seed
        Number of draws, balanced in powers of two, and their seed.
    sensitivities
        Also find what each error does on its own.
    """
    from riglens.jobs.reviewing import evaluator_of

    options = ScoreOptions(method, threads=threads, body=body)
    drawing = ToleranceOptions(errors, draws, seed, sample, sensitivities)
    rig = with_blocking_mesh(rig, options.body_of(rig), mesh_folder)
    return _drawn(evaluator_of(scene.field, traffic, options), rig, drawing, progress)


def _drawn(
    evaluate: Evaluator, rig: Rig, drawing: ToleranceOptions, progress: Progress | None = None
) -> ToleranceResult:
    from riglens.jobs.reviewing import drawn

    found, document = drawn(evaluate, rig, drawing, progress)
    return ToleranceResult(document, found)


def mounts(rig: Rig, *, mesh_folder: StrPath = ".") -> MountsResult:
    """Find how high, how near to the skin and how near to each other sensors are mounted, and what is wrong."""
    rig = with_blocking_mesh(rig, "blocks", mesh_folder)
    return MountsResult(mounts_review_document(rig), rig, mounts_of(rig), violations(rig, USUAL_LIMITS))


def footprint(
    sensor: Sensor,
    *,
    px_per_m: Sequence[float] = EN_62676_4,
    rig: Rig | None = None,
    mesh_folder: StrPath = ".",
) -> Footprint:
    """Find what a camera resolves, or a radar or ultrasonic sensor reaches, on flat ground.

    Parameters
    ----------
    px_per_m
        Least pixels per metre of each band of a camera, falling; those of EN 62676-4.
    rig
        The rig whose body and housings hide ground from the sensor; without it nothing does.
    """
    solid = None if rig is None else solid_rig(with_blocking_mesh(rig, "blocks", mesh_folder))
    return footprint_of(sensor, px_per_m, solid)


def footprints(
    rig: Rig, *, px_per_m: Sequence[float] = EN_62676_4, mesh_folder: StrPath = "."
) -> FootprintResult:
    """Find the footprints of a rig's enabled sensors, the pixels on objects and the overlaps of cameras."""
    rig = with_blocking_mesh(rig, "blocks", mesh_folder)
    found = footprints_of(rig, px_per_m)
    return FootprintResult(footprints_document(rig, found), rig, found)


def check(
    rigs: Rig | Sequence[Rig],
    requirements: StrPath,
    scene: Scene | None = None,
    traffic: Traffic | None = None,
    *,
    profiles: Sequence[StrPath] = (),
    body: Body | None = None,
    threads: int | None = None,
    mesh_folder: StrPath = ".",
) -> CheckResult:
    """Check rigs against a file of requirements, in the bundled town unless scene and traffic are given.

    Raises InputError for names that neither a rig nor the program has.
    """
    from riglens.jobs.checking import CheckData, CheckInputs, checked

    several = with_blocking_meshes(rigs, ScoreOptions().solid(), mesh_folder)
    asked = CheckInputs.of(Path(requirements), tuple(Path(one) for one in profiles), several)
    score = ScoreOptions(threads=threads, body=body).as_required(asked.required.settings.body, asked.file)
    if scene is None and asked.required.needs_scene:
        grid = asked.required.settings
        scene = load_scene(voxel_m=grid.voxel_m, roi_m=grid.roi_m)
    if traffic is None and asked.required.needs_objects:
        traffic = load_traffic()
    needed = CheckData(None if scene is None else scene.field, traffic)
    found = checked(several, score, needed, asked, Warnings())
    return CheckResult(found.document(), {one.title: one.verdicts for one in found.checks})


PARTS = ("blind", "range", "redundancy", "tolerance", "audit", "mounts", "footprint")


def review(
    rig: Rig,
    scene: Scene | None = None,
    traffic: Traffic | None = None,
    *,
    only: Sequence[str] = PARTS,
    min_points: int = 5,
    profiles: Sequence[StrPath] = (),
    errors: str = "assembly",
    draws: int = 64,
    seed: int = 0,
    sample: int = SAMPLE_FRAMES,
    damaged: Sequence[str] = (),
    halves: bool = False,
    method: Method = "exact",
    body: Body | None = None,
    threads: int | None = None,
    mesh_folder: StrPath = ".",
) -> ReviewResult:
    """Review a rig: blind zones, detection range, redundancy, tolerance, where rays go, mounts, footprints.

    The bundled town is the scene, and its objects the traffic, unless a scene is given.

    The other arguments are those of the functions of the parts.

    Parameters
    ----------
    only
        Some of the parts: "blind", "range", "redundancy", "tolerance", "audit", "mounts", "footprint".
    min_points
        LiDAR points that detect an object.
    damaged
        Sensors that have failed, "LIDAR_1", or are blocked by half, "LIDAR_1=left" (right, upper, lower).
    """
    if unknown := [name for name in only if name not in PARTS]:
        raise InputError(f"must be some of {', '.join(PARTS)} (got '{unknown[0]}')", "only")
    from riglens.jobs.reviewing import evaluator_of

    if scene is None and {"redundancy", "tolerance", "audit"} & set(only):
        scene = load_scene()
        traffic = traffic or load_traffic()
    options, rig = ScoreOptions(method, threads=threads, body=body), damaged_rig(rig, damaged)
    drawing = ToleranceOptions(errors, draws, seed, sample)

    @cache
    def evaluate() -> Evaluator:
        assert scene is not None
        return evaluator_of(scene.field, traffic, options)

    def read(body: Body) -> Rig:
        return with_blocking_mesh(rig, body, mesh_folder)

    makers: dict[str, Callable[[], Result]] = {
        "blind": lambda: blind(rig, profiles=profiles, threads=threads, mesh_folder=mesh_folder),
        "range": lambda: detection_range(
            rig, min_points=min_points, threads=threads, mesh_folder=mesh_folder
        ),
        "redundancy": lambda: _redundancy(evaluate(), read(options.body_of(rig)), min_points, halves),
        "tolerance": lambda: _drawn(evaluate(), read(options.body_of(rig)), drawing),
        "audit": lambda: AuditResult(audit_rig(evaluate().voxels, read("blocks"))),
        "mounts": lambda: mounts(rig, mesh_folder=mesh_folder),
        "footprint": lambda: footprints(rig, mesh_folder=mesh_folder),
    }  # fmt: skip
    return ReviewResult(rig, {name: makers[name]() for name in PARTS if name in only})
