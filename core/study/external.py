"""Published experiments with fewer beams or points against figures of the same rigs: an external test of the figures.

Each experiment states the ratio of average precision with a reduced LiDAR to that with the whole one, on the same
recording. A figure passes where its own ratio, on boxes of that recording, differs by TOLERANCE at most: this was fixed
before the first run. All figures count the same objects, those of `Experiment.region`. Experiments whose detector was
trained on the reduced data are the test; the others, where a detector meets data that it was not trained on or where
many sweeps are added up, bound what it says.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from riglens.core.engine.engine import Engine
from riglens.core.figures.hits import ON_TARGET, SHARE_1, SHARE_5
from riglens.core.figures.objects import parts_by_class
from riglens.core.figures.predicted import PREDICTED
from riglens.core.metric.scores import PAPER_SETTINGS
from riglens.core.rig.model import Lidar, LinearAngles, Rig
from riglens.core.rig.presets import preset
from riglens.core.scene.boxes import CLASSES
from riglens.core.targets.engine import TargetEngine
from riglens.core.targets.settings import TargetSettings
from riglens.core.targets.traffic import Traffic

Doubles = NDArray[np.float64]
Recording = Literal["nuscenes", "kitti"]

TOLERANCE = 0.05
GROUPS = ("trained on the reduced data", "trained on the whole data", "ten sweeps of a standing scene")
"""Groups of experiments: the test, its bounds, and what changes where a detector adds up sweeps."""
FIGURES = {
    "predicted": "predicted AP",
    "on_target": "on target",
    "share_5": "≥ 5 points",
    "share_1": "≥ 1 point",
    "seen": "seen",
    "rays": "rays",
}
"""Figures compared, by name; the last is a baseline."""
WITHIN_M: dict[Recording, float] = {"nuscenes": 50.0, "kitti": 60.0}
"""Distance from the car up to which objects count, for every figure: about the ranges of the benchmarks."""
_RIGS: dict[Recording, str] = {"nuscenes": "nuScenes car", "kitti": "KITTI car"}
_CLASSES: dict[Recording, tuple[str, ...]] = {"nuscenes": CLASSES, "kitti": ("car",)}


@dataclass(frozen=True)
class Experiment:
    """A LiDAR that keeps the beams of these numbers, counted from the top beginning with 0, every `azimuth_step`-th
    azimuth, and a share `kept` of its rays at random; `full` and `reduced`: what the source reports of both.

    is_retrained: whether the detector was trained on the reduced data. sweeps: how many of a standing scene the figures
    add up, each with a spin phase and, at random, rays of its own.
    """

    name: str
    recording: Recording
    beams: tuple[int, ...]
    full: float
    reduced: float
    detector: str
    source: str
    azimuth_step: int = 1
    kept: float = 1.0
    is_retrained: bool = True
    sweeps: int = 1

    @property
    def group(self) -> str:
        """Return its group, one of GROUPS."""
        return GROUPS[2] if self.sweeps > 1 else GROUPS[0] if self.is_retrained else GROUPS[1]

    @property
    def region(self) -> str:
        """The objects that count, in words."""
        classes = _CLASSES[self.recording]
        who = "all" if classes == CLASSES else ", ".join(f"{name}s" for name in classes)
        return f"{who} within {WITHIN_M[self.recording]:g} m"

    @property
    def published(self) -> float:
        """The ratio of average precision that the source reports."""
        return self.reduced / self.full

    def rig(self) -> Rig:
        """Return the recording's rig with the reduced LiDAR alone."""
        return self._rig(self.beams, self.azimuth_step, self.kept)

    def whole(self) -> Rig:
        """Return the recording's rig with its LiDAR alone."""
        return self._rig(None, 1, 1.0)

    def _rig(self, beams: tuple[int, ...] | None, azimuth_step: int, kept: float) -> Rig:
        rig = preset(_RIGS[self.recording])
        (lidar,) = rig.enabled_lidars()
        turn, count = lidar.azimuths_deg, lidar.beam_count
        assert isinstance(turn, LinearAngles)
        places = range(count) if beams is None else [count - 1 - beam for beam in reversed(beams)]
        coarser = LinearAngles(from_=turn.from_, to=turn.to, count=turn.count // azimuth_step)
        sweep = [_with_beams(lidar, places).replace(azimuths_deg=coarser)]
        sensors: list[Lidar] = []
        rng = np.random.default_rng(0)
        for number in range(self.sweeps):
            if kept < 1.0:
                sweep = list(_thinned(lidar, places, coarser.open_end_deg(), kept, rng))
            sensors += [one.replace(name=f"{one.name} {number}") for one in sweep]
        return rig.replace(name=self.name, sensors=tuple(sensors))


def _thinned(
    lidar: Lidar, places: Sequence[int], azimuths_deg: Doubles, kept: float, rng: np.random.Generator
) -> Iterator[Lidar]:
    """Yield LiDARs of two beams each, which keep a share of the azimuths, drawn for each of them."""
    for first in range(0, len(places), 2):
        chosen = azimuths_deg[rng.random(len(azimuths_deg)) < kept]
        beams = _with_beams(lidar, places[first : first + 2])
        yield beams.replace(azimuths_deg=tuple(chosen.tolist()), name=f"{lidar.name} {first}")


def _with_beams(lidar: Lidar, places: Sequence[int]) -> Lidar:
    offsets = lidar.azimuth_offsets_deg
    return lidar.replace(
        elevations_deg=tuple(lidar.elevations()[list(places)].tolist()),
        azimuth_offsets_deg=None if offsets is None else tuple(offsets[place] for place in places),
    )


_FUTR3D = (
    "FUTR3D, LiDAR alone, ten sweeps: mAP",
    "arXiv 2203.10642; table of github.com/Tsinghua-MARS-Lab/futr3d",
)
_DISTILLED = (
    "PointPillars: car AP in 3D, moderate",
    "arXiv 2203.14956, table of github.com/weiyithu/LiDAR-Distillation; 64 beams: model zoo of OpenPCDet",
)
_CORRUPTED = (
    "TransFusion, LiDAR and cameras, ten sweeps: NDS",
    "arXiv 2402.11677, table of github.com/ika-rwth-aachen/MultiCorrupt: mean over three severities",
)
_KITTI_FULL = 77.28
_BEAMS: tuple[tuple[str, int, int, float, bool], ...] = (
    ("64 to 32 beams", 2, 1, 70.15, True),
    ("64 to 32, half the azimuths", 2, 2, 66.96, True),
    ("64 to 16 beams", 4, 1, 59.87, True),
    ("64 to 16, half the azimuths", 4, 2, 55.24, True),
    ("64 to 32 beams, not retrained", 2, 1, 65.91, False),
    ("64 to 32, half the azimuths, not retrained", 2, 2, 57.77, False),
    ("64 to 16 beams, not retrained", 4, 1, 47.48, False),
    ("64 to 16, half the azimuths, not retrained", 4, 2, 38.75, False),
)
"""On KITTI: name, steps of beams and azimuths, average precision, and whether the detector was trained on it."""
_SINGLE = (
    Experiment("32 to 4 beams", "nuscenes", (7, 9, 11, 13), 63.3, 44.3, *_FUTR3D),
    Experiment("32 to 1 beam", "nuscenes", (9,), 63.3, 16.9, *_FUTR3D),
    *(
        Experiment(
            name, "kitti", tuple(range(0, 64, step)), _KITTI_FULL, ap, *_DISTILLED, turn, 1.0, is_retrained
        )
        for name, step, turn, ap, is_retrained in _BEAMS
    ),
    Experiment(
        "a fifth of the points at random",
        "nuscenes",
        tuple(range(32)),
        1.0,
        0.969,
        *_CORRUPTED,
        kept=0.2,
        is_retrained=False,
    ),
    Experiment(
        "32 to 8 beams, not retrained",
        "nuscenes",
        tuple(range(1, 32, 4)),
        1.0,
        0.633,
        *_CORRUPTED,
        is_retrained=False,
    ),
)
TEN = 10
EXPERIMENTS = (
    *_SINGLE,
    *(
        replace(one, name=f"{one.name}, ten sweeps", sweeps=TEN)
        for one in _SINGLE
        if one.recording == "nuscenes"
    ),
)
"""Those on nuScenes again with the ten sweeps that their detectors add up."""


@dataclass(frozen=True)
class ExperimentRatios:
    """The published ratio of an experiment, and the ratios of the figures (by name)."""

    experiment: Experiment
    boxes: str
    ratios: Mapping[str, float]

    def error(self, figure: str) -> float:
        """Return by how much the ratio of a figure is above the published one."""
        return self.ratios[figure] - self.experiment.published

    def passes(self, figure: str) -> bool:
        """Return whether a figure's ratio is the published one within the tolerance."""
        return abs(self.error(figure)) <= TOLERANCE


def outcomes(
    recording: Recording,
    traffic: Traffic,
    engine: Engine,
    frames: int,
    tell: Callable[[float], None] = lambda share: None,
) -> list[ExperimentRatios]:
    """Compute the figures of the experiments on a recording, on the objects of `frames` frames of some boxes."""
    targets = TargetEngine(traffic.within(WITHIN_M[recording]))
    mine = [one for one in EXPERIMENTS if one.recording == recording]
    found = []
    whole: dict[int, dict[str, float]] = {}
    for number, one in enumerate(mine, 1):
        if one.sweeps not in whole:
            whole[one.sweeps] = _figures(one.whole(), recording, targets, engine, frames)
        reduced = _figures(one.rig(), recording, targets, engine, frames)
        ratios = {name: reduced[name] / whole[one.sweeps][name] for name in FIGURES}
        found.append(ExperimentRatios(one, traffic.data.source, ratios))
        tell(number / len(mine))
    return found


def _figures(
    rig: Rig, recording: Recording, targets: TargetEngine, engine: Engine, frames: int
) -> dict[str, float]:
    """Return means over the classes of the benchmark; the car's own body as the rig defines it."""
    classes = _CLASSES[recording]
    settings = TargetSettings(body=None)
    counted = targets.evaluate(rig, settings, frames)
    of_objects = (PREDICTED, ON_TARGET, SHARE_5, SHARE_1)
    rows = [parts_by_class(counted, of_objects)[cls].total for cls in classes]
    predicted = [row["predicted"].value for row in rows if row["predicted"].exists]
    scored = engine.evaluate(rig, replace(PAPER_SETTINGS, body=rig.body)).scores.classes
    return {
        "predicted": float(np.mean(predicted)) if predicted else math.nan,
        **{one.key: float(np.mean([row[one.key].value for row in rows])) for one in of_objects[1:]},
        "seen": float(np.mean([scored[cls].any_seen for cls in classes])),
        "rays": float(sum(lidar.ray_count for lidar in rig.enabled_lidars())),
    }


def mean_error(found: Sequence[ExperimentRatios], figure: str) -> float:
    """Return the mean of the absolute errors of a figure."""
    return float(np.mean([abs(one.error(figure)) for one in found]))
