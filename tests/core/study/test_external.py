"""Published experiments with fewer beams: what is reduced, what is reported, and what the page says of the figures."""

from __future__ import annotations

import csv
from pathlib import Path

import numpy as np
import pytest

from riglens.core.engine.engine import Engine
from riglens.core.rig.model import Lidar
from riglens.core.study.external import (
    EXPERIMENTS,
    FIGURES,
    GROUPS,
    TOLERANCE,
    WITHIN_M,
    Experiment,
    ExperimentRatios,
    Recording,
    mean_error,
    outcomes,
)
from riglens.evaluation.options import SceneOptions, Triple
from riglens.evaluation.traffic import load_traffic
from riglens.studies.external import FRAMES, document
from tests.core.builders import field_of, grid_of
from tests.core.targets.cases import traffic

TOWN = "bundled town"
DOCS = Path(__file__).resolve().parents[3] / "docs"
SHARED = Path(__file__).resolve().parents[4] / "shared" / "data"
RECORDINGS: tuple[tuple[Recording, str, Triple | None], ...] = (
    ("nuscenes", "boxes/nuscenes_mini_val_ego.csv.gz", (-1.35, 0.0, 0.0)),
    ("kitti", "kitti/tracking", None),
)


def named(name: str) -> Experiment:
    (found,) = (one for one in EXPERIMENTS if one.name == name)
    return found


def lidars(name: str) -> tuple[Lidar, ...]:
    return named(name).rig().enabled_lidars()


def test_the_beams_are_those_that_the_sources_keep() -> None:
    """FUTR3D's loader takes angles of 0.65 to 1.98 degrees for beam 7, and so on downwards."""
    (four,) = lidars("32 to 4 beams")
    assert four.elevations().tolist() == [-6.67, -4.0, -1.33, 1.33]
    (one,) = lidars("32 to 1 beam")
    assert one.elevations().tolist() == [-1.33] and one.azimuths().size == 1085


def test_every_second_beam_and_azimuth_keep_their_offsets() -> None:
    (whole,) = named("64 to 32 beams").whole().enabled_lidars()
    (half,), (quarter,) = lidars("64 to 32 beams"), lidars("64 to 16, half the azimuths")
    assert half.elevations().tolist() == whole.elevations()[1::2].tolist()
    assert half.azimuth_offsets_deg == (whole.azimuth_offsets_deg or ())[1::2]
    assert quarter.beam_count == 16 and quarter.azimuths().size == whole.azimuths().size // 2
    assert named("64 to 32, half the azimuths").rig().enabled_lidars()[0].ray_count == pytest.approx(
        lidars("64 to 16 beams")[0].ray_count, rel=1e-3
    )


def test_points_at_random_are_a_share_of_all_beams_and_others_in_each_sweep() -> None:
    name = "a fifth of the points at random"
    kept, added_up = lidars(name), lidars(f"{name}, ten sweeps")
    (whole,) = named(name).whole().enabled_lidars()
    assert np.concatenate([lidar.elevations() for lidar in kept]).tolist() == whole.elevations().tolist()
    assert sum(lidar.ray_count for lidar in kept) == pytest.approx(0.2 * whole.ray_count, rel=0.05)
    assert len(added_up) == 10 * len(kept) == len({lidar.azimuths_deg for lidar in added_up})
    assert all(np.isin(lidar.azimuths(), whole.azimuths()).all() for lidar in kept)
    assert len(named(f"{name}, ten sweeps").whole().enabled_lidars()) == 10


def test_what_is_reported_is_a_loss_with_its_source() -> None:
    assert len({one.name for one in EXPERIMENTS}) == len(EXPERIMENTS)
    assert all(0.0 < one.published < 1.0 and "arXiv" in one.source for one in EXPERIMENTS)
    assert named("32 to 4 beams").published == pytest.approx(0.70, abs=0.005)
    for name in (
        "64 to 32 beams",
        "64 to 16, half the azimuths",
    ):  # training on what is met is worth something
        assert named(f"{name}, not retrained").published < named(name).published


def test_errors_are_told_with_their_sign_and_compared_without() -> None:
    experiment = named("32 to 1 beam")
    ratios = dict.fromkeys(FIGURES, experiment.published + 2 * TOLERANCE)
    high = ExperimentRatios(experiment, "boxes", ratios | {"seen": experiment.published - TOLERANCE / 2})
    assert high.error("on_target") == pytest.approx(2 * TOLERANCE) and not high.passes("on_target")
    assert high.error("seen") < 0.0 and high.passes("seen")
    assert mean_error([high], "seen") == pytest.approx(TOLERANCE / 2)


SIZE_M = (4.0, 1.8, 1.5)


def on_kitti(*cars_m: tuple[float, float]) -> list[ExperimentRatios]:
    """The experiments on KITTI with one frame of cars at these places."""
    boxes = traffic([(0, 0, (x, y, 0.75), SIZE_M, 0.0) for x, y in cars_m])
    return outcomes("kitti", boxes, Engine(field_of(grid_of(2, 2, 2)), 1), frames=1)


def test_predicted_ap_counts_the_objects_that_the_published_one_counts() -> None:
    """A rectangle of 60 m x 40 m, in which its curves were fitted, would leave the second car out."""
    near, both = on_kitti((12.0, 0.0)), on_kitti((12.0, 0.0), (45.0, 25.0))
    beyond = on_kitti((12.0, 0.0), (45.0, 25.0), (59.0, 30.0))
    for figure in ("predicted", "on_target"):
        first, second, third = ([one.ratios[figure] for one in found] for found in (near, both, beyond))
        assert first != second == third, figure


def test_json_says_which_published_ratios_are_predicted() -> None:
    found = on_kitti((20.0, 0.0), (45.0, 25.0))
    groups = document(found)["groups"]
    assert [group["name"] for group in groups] == list(GROUPS)
    tests = {test["name"]: test for group in groups for test in group["tests"]}
    assert len(tests) == len(found)
    for one in found:
        told = tests[one.experiment.name]
        assert (told["published"], told["predicted"]) == (one.experiment.published, one.ratios["predicted"])
        assert told["passes"] == (abs(told["predicted"] - told["published"]) <= TOLERANCE)


@pytest.mark.skipif(not SHARED.is_dir(), reason="needs the real data beside the project")
def test_predicted_ap_passes_five_of_six_on_the_recordings() -> None:
    """Of nuScenes within 50 m and of KITTI within 60 m."""
    found: list[ExperimentRatios] = []
    engine = Engine(field_of(grid_of(2, 2, 2)))
    for recording, boxes, origin_m in RECORDINGS:
        options = SceneOptions(boxes=SHARED / boxes, origin_m=origin_m)
        data = load_traffic(options, WITHIN_M[recording])
        found += outcomes(recording, data, engine, min(FRAMES, data.frames))
    retrained = document(found)["groups"][0]["tests"]
    assert (sum(test["passes"] for test in retrained), len(retrained)) == (5, 6)


SENTENCES = {
    "64 to 16 beams, not retrained": "{published} of car AP, on target {on_target}, ≥ 5 points {share_5};",
    "64 to 16, half the azimuths, not retrained": "the azimuths {published}, {on_target} and {share_5}.",
    "a fifth of the points at random": "keeps {published} of NDS, on target {on_target}, ≥ 5 points {share_5}.",
    "a fifth of the points at random, ten sweeps": "gaps (on target {on_target})",
    "32 to 4 beams, ten sweeps": "32 to 4 beams {on_target},",
    "32 to 1 beam, ten sweeps": "32 to 1 beam {on_target})",
}
"""Sentences of the page with the figures of experiments that have no table there."""


def test_the_page_says_what_the_table_does() -> None:
    with (DOCS / "data" / "external.csv").open(encoding="utf-8", newline="") as stream:
        rows = list(csv.DictReader(stream))
    page = " ".join((DOCS / "study-external.md").read_text(encoding="utf-8").split())
    assert {row["experiment"] for row in rows} == {one.name for one in EXPERIMENTS}
    sentences = dict(SENTENCES)
    for row in rows:
        assert row["objects"] == named(row["experiment"]).region
        assert float(row["published"]) == pytest.approx(named(row["experiment"]).published, abs=1e-4)
        if row["boxes"] == TOWN:
            continue
        said = {name: f"{float(row[name]):.2f}" for name in ("published", *FIGURES)}
        if row["group"] == GROUPS[0]:
            cells = (row["experiment"], row["objects"], *said.values())
            assert f"| {' | '.join(cells)} |" in page, row["experiment"]
        elif row["experiment"] in sentences:
            assert sentences.pop(row["experiment"]).format(**said) in page, row["experiment"]
    assert not sentences
    recorded = {row["boxes"] for row in rows} - {TOWN}
    for boxes, label in (
        (recorded, "**mean error**"),
        ({TOWN}, "mean error with the boxes of the bundled town"),
    ):
        of = [row for row in rows if row["boxes"] in boxes and row["group"] == GROUPS[0]]
        errors = (
            np.mean([abs(float(row[name]) - float(row["published"])) for row in of]) for name in FIGURES
        )
        assert f"| {label} | | | {' | '.join(f'{error:.3f}' for error in errors)} |" in page
