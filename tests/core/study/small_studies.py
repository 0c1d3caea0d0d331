"""Small studies of made-up scenes, measured once per process: the tests of measuring and of telling share them."""

import tempfile
from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest

from riglens.core.metric.entropy import EntropyField
from riglens.core.rig.library import LIBRARY_VARIABLE
from riglens.core.scene.boxes import CLASSES
from riglens.core.scene.grid import VoxelGrid
from riglens.core.scene.pog import build_pog
from riglens.core.study.accuracy import AccuracyPlan, AccuracyStudy, study_accuracy
from riglens.core.study.sensor_methods import SensorStudy, study_sensors
from riglens.core.study.stability_cases import ray_cases
from riglens.core.study.stability_methods import MethodRow, judged
from riglens.core.study.stability_metric import (
    LETTERS,
    MetricStudy,
    Ranking,
    RayLattice,
    StabilityPlan,
    study_metric,
)
from tests.core.builders import boxes_of, camera, grid_of, random_field, rig_of, spinning

QUICK = AccuracyPlan(repetitions=1, threads=1, lattices=("1/2",))
BENT = """bent:
  kind: camera
  title: A camera with a bent lens and few pixels
  source: our choice
  image: [192, 108]
  fx: 93.0
  fy: 94.0
  cx: 96.0
  cy: 54.0
  distortion: {model: brown_conrady, k1: -0.165, k2: 0.0099}
"""
SHAPES = {0.5: (24, 20, 10), 1.0: (12, 10, 5)}
PLAN = StabilityPlan(
    voxel_m=0.5,
    edge_factors=(2.0, 3.0),
    lattices=(RayLattice((16, 9)), RayLattice((32, 18), 90)),
    resamples=3,
)
SCENE = VoxelGrid(0.5, (20.0, 20.0, 4.0))
BOXES = boxes_of(
    (0, 0, (6.0, 0.0, 0.8), (4.5, 1.9, 1.6), 0.3),
    (0, 1, (3.0, -4.0, 0.9), (1.8, 0.6, 1.7), 0.0),
    (1, 0, (-6.0, 3.0, 0.8), (4.5, 1.9, 1.6), 0.0),
    (1, 0, (-6.0, 2.5, 0.8), (4.5, 1.9, 1.6), 0.1),
    (3, 2, (2.0, 5.0, 0.9), (0.9, 0.9, 1.8), 0.0),
    (3, 0, (6.5, 0.5, 0.8), (4.5, 1.9, 1.6), 0.2),
    frames=6,
)


@cache
def small_accuracy_study() -> AccuracyStudy:
    """A camera and a LiDAR on two grids of one made-up scene."""
    rng = np.random.default_rng(11)
    fields = {edge: random_field(grid_of(*shape, edge), rng) for edge, shape in SHAPES.items()}
    rig = rig_of(camera((0.31, 0.17, 2.23), cast=(16, 8)), spinning((-0.27, 0.41, 2.63)))
    return study_accuracy(fields, 1.0, rig, QUICK)


@cache
def small_sensor_study() -> SensorStudy:
    """A LiDAR of the library and a camera of one's own on a coarse grid of a made-up scene, one run of each way."""
    field = random_field(grid_of(24, 20, 4, 1.0), np.random.default_rng(7))
    rig = rig_of(camera((0.31, 0.17, 1.73), (0.0, 0.0, 12.0)), spinning((-0.27, 0.41, 1.93), (0.0, 0.0, 8.0)))
    with tempfile.TemporaryDirectory() as folder, pytest.MonkeyPatch.context() as patch:
        (own := Path(folder, "own.yaml")).write_text(BENT, encoding="utf-8")
        patch.setenv(LIBRARY_VARIABLE, str(own))
        return study_sensors(field, rig, ("velodyne-vlp-16", "bent"), repetitions=1)


@cache
def judged_cases() -> dict[str, MethodRow]:
    """Every case about rays, judged, by its name."""
    return {case.name: judged(case, 1) for case in ray_cases(quick=True)}


@cache
def small_metric_study() -> MetricStudy:
    """The orders of the paper's rigs on a few boxes, on two grids."""
    field = EntropyField.from_pog(build_pog(BOXES, SCENE))
    grids = {1.0: EntropyField.from_pog(build_pog(BOXES, VoxelGrid(1.0, SCENE.roi_m)))}
    return study_metric(field, lambda edge, _: grids.get(edge), BOXES, replace(PLAN, threads=1))


def ranking(**s_mig: float) -> Ranking:
    """A ranking with the same S-MIG for every class."""
    return Ranking({letter: dict.fromkeys(CLASSES, s_mig.get(letter, 0.0)) for letter in LETTERS})


HAND = {"C": -40.0, "P": -30.0, "L": -20.0, "T": -10.0, "W": -4.0, "N": -8.0}
