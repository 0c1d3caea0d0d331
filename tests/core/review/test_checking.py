"""Verdicts on requirements: nothing is met by absence or by luck, and each says what decides it."""

import math
from dataclasses import replace
from datetime import date
from pathlib import Path
from xml.etree import ElementTree as ET

import numpy as np
import pytest

from riglens.core.blind.zones import BlindEngine
from riglens.core.engine.engine import Engine
from riglens.core.errors import InputError
from riglens.core.figures.evaluated import EvaluationSettings, Evaluator
from riglens.core.metric.entropy import EntropyField
from riglens.core.metric.scores import MetricSettings
from riglens.core.review.check_junit import RigCheck, junit_xml
from riglens.core.review.checking import Check, Subject
from riglens.core.review.documents import check_document, settings_document
from riglens.core.review.findings import Finding, Verdict, amounts
from riglens.core.review.measures import Measures
from riglens.core.review.profiles import bundled_profiles
from riglens.core.review.requirements import SECTIONS, Requirements, requirements_in
from riglens.core.review.tolerance import (
    Draws,
    chance_bounds,
    disturbed,
    errors_count,
    profile_called,
    standing,
    unit_draws,
)
from riglens.core.review.verdicts import ObjectVisibility
from riglens.core.rig.edits import damaged
from riglens.core.rig.model import Rig
from riglens.core.scene.boxes import CLASSES
from riglens.core.scene.grid import VoxelGrid
from riglens.core.sensors.base import HALVES
from riglens.core.sensors.radar import Radar, RadarScan
from riglens.core.shown_text import visible
from riglens.core.targets.engine import TargetEngine
from tests.core.builders import random_field, synthetic_pog
from tests.core.review.scenes import BOX, box_mesh, camera, dense_lidar, random_rig
from tests.core.review.test_redundancy import grouped, some_traffic, without
from tests.core.targets.cases import by_sector, parts

GRID = "blind_voxel_m: 0.5, voxel_m: 0.5, roi_m: [20, 16, 4]"
HEAD = f"riglens_requirements: 1\nsettings: {{{GRID}}}\n"
SMALL = VoxelGrid(0.5, (20.0, 16.0, 4.0))
DAY = date(2026, 6, 1)
ABSENT = (
    "seen: [{class: car, at_least: 0}, {class: car, by: camera, at_least: 0}]",
    "on_target: [{class: car, at_least: 0}, {class: car, figure: seen_by_cameras, at_least: 0}]",
    "predicted_detection: [{class: car, at_least: 0}]",
    "blind_areas: [{height_m: 0.3, at_most_m2: 1000000}]",
    "blind_objects: [{profile: adults-around, at_most_unseen: 1000}]",
    "losses: [{of: voxels, class: car, at_most: 1}, {of: objects, class: car, failure: pair, at_most: 1}]",
    "covered: [{of: voxels, class: car, sensors: 1, at_least: 0}]",
    "tolerance: [{profile: assembly, class: car, limit: 0, draws: 8}]",
    "mounts: {gap_m: 0.1}",
)


IGNORED = EvaluationSettings(MetricSettings(body="ignored"))


def required(text: str) -> Requirements:
    head = "riglens_requirements: 1\n" if text.startswith("settings") else HEAD
    return requirements_in(head + text, "required.yaml")


def subject(rig: Rig, seed: int = 4) -> Subject:
    rng = np.random.default_rng(seed)
    field, traffic = random_field(SMALL, rng), some_traffic(rng)
    return Subject(rig, Evaluator(field, traffic, IGNORED), bundled_profiles())


def verdicts(rig: Rig, text: str) -> tuple[Verdict, ...]:
    return Check(subject(rig), required(text)).verdicts()


def some_rig(sensors: int = 4) -> Rig:
    return random_rig(np.random.default_rng(3), sensors)


def test_the_file_that_the_documentation_shows_is_one() -> None:
    page = (Path(__file__).resolve().parents[3] / "docs" / "check.md").read_text(encoding="utf-8")
    text = next(part for part in page.split("```yaml\n") if part.startswith("riglens_requirements"))
    found = requirements_in(text.split("```")[0], "check.md", profiles=bundled_profiles())
    assert all(getattr(found, section) for section in (*SECTIONS, "mounts", "tolerance_profiles"))


@pytest.mark.parametrize(
    ("value", "bounds", "is_shown", "status"),
    [
        (0.5, None, True, "met"),
        (0.6, None, True, "not met"),
        (0.5, None, False, "not shown"),
        (0.4, (0.3, 0.5), True, "met"),
        (0.4, (0.3, 0.6), True, "not shown"),
        (0.6, (0.5, 0.7), True, "not shown"),
        (0.7, (0.6, 0.8), True, "not met"),
    ],
)
def test_a_limit_is_met_or_not_where_both_bounds_say_so(
    value: float, bounds: tuple[float, float] | None, is_shown: bool, status: str
) -> None:
    text = "seen: [{class: car, at_least: 0.5}]\nblind_areas: [{height_m: 0.3, at_most_m2: 0.5}]"
    least, most = sorted(required(text).items(), key=lambda item: item.section, reverse=True)
    assert Verdict(most, Finding(value, bounds=bounds, is_shown=is_shown)).status == status
    turned = None if bounds is None else (1.0 - bounds[1], 1.0 - bounds[0])
    assert Verdict(least, Finding(1.0 - value, bounds=turned, is_shown=is_shown)).status == status


# ---------------------------------------------------------------- absence


@pytest.mark.parametrize("text", ABSENT)
def test_without_enabled_sensors_no_requirement_is_met_however_easy(text: str) -> None:
    off = tuple(sensor.replace(enabled=False) for sensor in some_rig().sensors)
    for verdict in verdicts(Rig(sensors=off), text):
        assert verdict.status == "not applicable" and not verdict.passes
        assert verdict.finding.value is None and "no enabled sensor" in verdict.lines()[0]


@pytest.mark.parametrize(
    ("text", "reason"),
    [
        ("seen: [{class: car, by: camera, at_least: 0}]", "no enabled camera"),
        ("on_target: [{class: car, figure: both, at_least: 0}]", "of one kind"),
        ("blind_areas: [{height_m: 0.3, by: camera, at_most_m2: 1000000}]", "no enabled camera"),
        ("blind_objects: [{profile: un-r158-detection, failing: group, at_most_unseen: 99}]", "no group"),
        ("blind_areas: [{height_m: 0.3, failing: pair, at_most_m2: 1000000}]", "no pair"),
        ("losses: [{of: voxels, class: car, failure: pair, at_most: 1}]", "no pair"),
        ("losses: [{of: objects, class: car, failure: group, at_most: 1}]", "no group"),
    ],
)
def test_what_a_rig_of_one_lidar_has_not_is_not_applicable_unless_it_may_be_missing(
    text: str, reason: str
) -> None:
    rig = Rig(sensors=(dense_lidar(1.9, 20, 60),))
    (verdict,) = verdicts(rig, text)
    assert (verdict.status, verdict.passes) == ("not applicable", False)
    assert reason in " ".join(verdict.lines()) and not check_document(rig, "ignored", [verdict])["passes"]
    (allowed,) = verdicts(rig, text.replace("}]", ", allow_missing: true}]"))
    assert (allowed.status, allowed.passes) == ("not applicable", True)


@pytest.mark.parametrize("text", ABSENT)
def test_no_permission_makes_a_rig_without_enabled_sensors_pass(text: str) -> None:
    off = tuple(sensor.replace(enabled=False) for sensor in some_rig().sensors)
    assert not any(
        one.passes for one in verdicts(Rig(sensors=off), text.replace("}", ", allow_missing: true}"))
    )


def test_a_housing_in_the_road_is_below_the_ground() -> None:
    rig = some_rig(6)
    first = rig.sensors[0]
    low = first.model_copy(update={"position": (3.0, 0.0, 1e-4)})
    rig = rig.model_copy(update={"sensors": (low, *rig.sensors[1:])})
    (mounts,) = verdicts(rig, "mounts: {keep_out: []}")
    assert mounts.status == "not met" and "housing is" in mounts.lines()[0]
    (area,) = verdicts(rig, "blind_areas: [{height_m: 0.3, at_most_m2: 1000000, allow_missing: true}]")
    assert not area.passes and "below the ground" in area.lines()[0]


@pytest.mark.parametrize("text", ABSENT)
@pytest.mark.parametrize("allowed", [False, True])
def test_no_figure_of_a_rig_with_a_sensor_below_the_ground_meets_a_requirement(
    text: str, allowed: bool
) -> None:
    rig = some_rig(6)
    first = rig.sensors[0]
    low = first.model_copy(update={"position": (*first.position[:2], -0.2)})
    asked = text.replace("}", ", allow_missing: true}") if allowed else text
    found = verdicts(rig.model_copy(update={"sensors": (low, *rig.sensors[1:])}), asked)
    status = "not met" if text.startswith("mounts") else "not applicable"
    assert [(one.status, one.passes) for one in found] == [(status, False)] * len(found) != []
    assert all(
        first.name in " ".join(one.lines()) and "below the ground" in " ".join(one.lines()) for one in found
    )
    off = low.model_copy(update={"enabled": False})
    again = verdicts(rig.model_copy(update={"sensors": (off, *rig.sensors[1:])}), asked)
    assert not any("below the ground" in line for one in again for line in one.lines())


@pytest.mark.parametrize("text", ABSENT)
def test_no_figure_of_a_rig_with_two_sensors_in_one_place_meets_a_requirement(text: str) -> None:
    rig = some_rig(6)
    twin = rig.sensors[0].model_copy(update={"name": "twin"})
    found = verdicts(rig.replace(sensors=(*rig.sensors, twin)), text.replace("}", ", allow_missing: true}"))
    status = "not met" if text.startswith("mounts") else "not applicable"
    assert [(one.status, one.passes) for one in found] == [(status, False)] * len(found) != []
    assert all("in one place" in " ".join(one.lines()) for one in found)


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("figures: [{figure: missed, class: car, at_least: 0.1}]", "less of missed is better"),
        ("on_target: [{class: car, at_most: 0.9}]", "more of on target is better"),
        (
            "tolerance_profiles: [{name: assembly, source: x, angle_deg: 0.001}]\n"
            "tolerance: [{profile: assembly, class: car, limit: 0.4}]",
            "'assembly' is the name of a profile that ships",
        ),
        ("tolerance: [{profile: assembly, class: car, limit: 0.4, at_most: 1.0}]", "at_most"),
        (
            "blind_areas: [{height_m: 0.3, under: load, draws: 1, chance_at_most: 1.0, at_most_m2: 9}]",
            "chance_at_most",
        ),
        ("seen: [{class: car, at_least: 0.9, at_least: 0.0}]", "at_least"),
        ("seen: [{class: car, at_least: -0.1}]", "at_least"),
        ("mounts: {keep_out: [{name: glass, part: glass, allows: [drone]}]}", "kinds of sensors"),
    ],
)
def test_a_file_that_would_let_worse_rigs_pass_is_refused(text: str, said: str) -> None:
    with pytest.raises(InputError, match=said) as caught:
        required(text)
    assert "\n" not in str(caught.value) and "required.yaml" in str(caught.value)


def test_a_limit_that_no_rig_can_miss_and_zones_that_are_none_are_said() -> None:
    easy, hard = verdicts(some_rig(), "seen: [{class: car, at_least: 0}, {class: car, at_least: 0.001}]")
    assert easy.passes and easy.lines() == ("no rig can miss this limit",) and hard.lines() == ()
    (mounts,) = verdicts(some_rig(), "mounts: {keep_out: []}")
    assert "keeps no place free" in mounts.lines()[-1]


def test_any_two_kinds_detect_an_object_together() -> None:
    far = RadarScan(azimuth_deg=(-60.0, 60.0), elevation_deg=(-30.0, 30.0), range_m=50.0)
    radar = Radar(name="radar", position=(0.0, 0.0, 1.0), scans=(far,))
    asked = subject(Rig(sensors=(dense_lidar(1.9, 64, 360), radar)))
    (verdict,) = Check(asked, required("on_target: [{class: car, figure: both, at_least: 0}]")).verdicts()
    assert asked.evaluate.traffic is not None
    targets = TargetEngine(asked.evaluate.traffic, 1).evaluate(asked.rig)
    assert verdict.finding.value == parts(targets)["car"].total.both.value > 0.0


@pytest.mark.parametrize("text", [*ABSENT[:3], *ABSENT[5:8]])
def test_a_class_that_the_scene_has_not_is_not_applicable(text: str) -> None:
    rng = np.random.default_rng(4)
    traffic = some_traffic(rng)
    counts = rng.integers(1, 50, (*SMALL.shape, 3))
    counts[..., CLASSES.index("car")] = 0
    field = EntropyField.from_pog(synthetic_pog(SMALL, counts, 50))
    no_cars = replace(traffic, cls=np.full_like(traffic.cls, CLASSES.index("bicycle")))
    asked = Subject(some_rig(), Evaluator(field, no_cars, IGNORED), bundled_profiles())
    for verdict in Check(asked, required(text)).verdicts():
        assert (verdict.status, verdict.passes) == ("not applicable", False)


@pytest.mark.parametrize("figure", ["predicted", "found"])
def test_predicted_detection_is_that_of_the_targets_and_nothing_outside_its_domain(figure: str) -> None:
    asked = subject(Rig(sensors=(dense_lidar(1.9, 64, 720),)))
    each = f"class: car, figure: {figure}"
    text = f"predicted_detection: [{{{each}, at_least: 0}}, {{{each}, ring_m: [0, 20], at_least: 1}}]"
    whole, near = Check(asked, required(text)).verdicts()
    assert asked.evaluate.traffic is not None
    scores = TargetEngine(asked.evaluate.traffic, threads=1).evaluate(asked.rig)
    calibration = scores.calibration if figure == "predicted" else scores.settings.recall
    table = parts(scores)["car"]
    rings = [ring[figure] for ring in table.rings[:2]]
    assert whole.finding.value == pytest.approx(table.total[figure].value)
    wanted = sum(ring.objects * ring.value for ring in rings) / sum(ring.objects for ring in rings)
    assert near.finding.value == pytest.approx(wanted)
    assert calibration is not None
    error = calibration.errors[1 + CLASSES.index("car")]
    assert whole.lines()[0].startswith(f"±{200 * error:.1f} %, two standard errors") and error > 0.0
    assert (whole.passes, near.passes) == (True, False), "a curve stays below 1"
    (outside,) = verdicts(
        Rig(sensors=(dense_lidar(1.9, 2, 90),)), f"predicted_detection: [{{{each}, at_least: 0}}]"
    )
    assert outside.status == "not applicable" and "rays" in outside.lines()[0]


def test_a_ring_without_road_users_is_not_applicable() -> None:
    (verdict,) = verdicts(some_rig(), "on_target: [{class: car, ring_m: [40, 50], at_least: 0}]")
    assert (verdict.status, verdict.passes) == ("not applicable", False)


def test_a_sector_has_the_figure_of_its_objects_and_one_without_them_is_not_applicable() -> None:
    asked = subject(some_rig())
    assert asked.evaluate.traffic is not None
    sectors = by_sector(TargetEngine(asked.evaluate.traffic, threads=1).evaluate(asked.rig))["car"]
    text = ", ".join(f"{{class: car, sector: {sector}, at_least: 0}}" for sector in sectors)
    found = Check(asked, required(f"on_target: [{text}]")).verdicts()
    assert 0 < sum(row.objects > 0 for row in sectors.values()) < len(sectors)
    for verdict, row in zip(found, sectors.values(), strict=True):
        if row.objects:
            assert verdict.finding.value == pytest.approx(row.on_target.value)
        else:
            assert (verdict.status, verdict.passes) == ("not applicable", False)


@pytest.mark.parametrize(
    ("where", "told"),
    [
        ("sector: ahead", "'front-left'"),
        ("ring_m: [0, 10], sector: front", "either ring_m or sector"),
        ("ring_m: [20, 20]", "from < to"),
        ("ring_m: [15, 20]", "whole tens"),
    ],
)
def test_where_a_figure_of_objects_cannot_be_is_told(where: str, told: str) -> None:
    with pytest.raises(InputError, match=told):
        required(f"on_target: [{{class: car, {where}, at_least: 0}}]")


def test_pairs_of_a_rig_that_is_too_large_for_them_are_not_met_by_default() -> None:
    one = camera((0.0, 0.0, 2.0)).replace(image=(16, 12), cast=(16, 12))
    sensors = tuple(
        one.replace(name=f"c{n}", position=(0.02 * n, 0.0, 2.0), rpy_deg=(0.0, 0.0, 8.0 * n))
        for n in range(41)
    )
    (verdict,) = verdicts(
        Rig(sensors=sensors), "losses: [{of: voxels, class: car, failure: pair, at_most: 1}]"
    )
    assert not verdict.passes and "up to 40 enabled sensors" in verdict.lines()[0]


def test_zones_of_a_material_that_a_mesh_file_lacks_are_not_kept_out_by_default() -> None:
    lidar = dense_lidar(1.55, 4, 8)
    rig = Rig(sensors=(lidar,), vehicle=BOX.with_body_mesh(box_mesh(4.0, 1.8)))
    zone = "mounts: {gap_m: 0.1, keep_out: [{name: panes, material: glass}]}"
    for text, status in ((zone, "not applicable"), ("mounts: {gap_m: 0.1}", "met")):
        (verdict,) = verdicts(rig, text)
        assert (verdict.status, verdict.passes) == (status, status == "met")
        assert "the mesh file names no such parts: " in verdict.lines()[0]
    far = rig.replace(sensors=(lidar.replace(position=(0.0, 0.0, 3.0)),))
    (verdict,) = verdicts(far, zone)
    assert verdict.status == "not met" and len(verdict.lines()) == 2


def test_a_rig_that_detects_nothing_has_nothing_to_lose() -> None:
    up = camera((0.0, 0.0, 6.0)).replace(rpy_deg=(0.0, -90.0, 0.0))
    text = "losses: [{of: voxels, class: car, at_most: 1}, {of: objects, class: car, at_most: 1}]"
    for verdict in verdicts(Rig(sensors=(up,)), text):
        assert (verdict.status, verdict.passes) == ("not applicable", False)
        assert "detects nothing of car" in verdict.lines()[0]


@pytest.mark.parametrize(
    "text",
    [
        "tolerance: [{profile: joint, class: car, limit: 0, draws: 8, at_most: 0.5}]",
        "blind_areas: [{height_m: 0.3, under: joint, draws: 5, chance_at_most: 0.5, at_most_m2: 1000000}]",
        "blind_objects: [{profile: adults-around, under: joint, draws: 5, chance_at_most: 0.5, at_most_unseen: 1000}]",
    ],
)
def test_errors_that_a_rig_cannot_have_prove_nothing(text: str) -> None:
    rig = some_rig(4)
    own = "tolerance_profiles: [{name: joint, source: a test, bracket_position_mm: 5}]\n"
    (without_brackets,) = verdicts(rig, own + text)
    assert (without_brackets.status, without_brackets.passes) == ("not applicable", False)
    assert "'joint' move nothing" in without_brackets.lines()[0]
    assert verdicts(grouped(rig), own + text)[0].passes
    off = tuple(one.replace(enabled=one.fails_with is None) for one in grouped(rig).sensors)
    assert not verdicts(Rig(sensors=off), own + text)[0].passes


def test_a_rig_of_one_beam_loses_all_that_it_detects() -> None:
    beam = dense_lidar(1.2, 2, 90).replace(name="beam")
    of_all, of_detected = verdicts(
        Rig(sensors=(beam,)),
        "losses: [{of: voxels, class: car, share_of: all, least_detected: 0, at_most: 0.2},"
        " {of: voxels, class: car, least_detected: 0, at_most: 0.2}]",
    )
    assert of_all.finding.value is not None and of_all.finding.value < 0.2
    assert of_detected.finding.value == 1.0 and of_detected.status == "not met"
    assert "100.00 % of what the rig detects" in of_all.lines()


def test_a_rig_that_detects_little_meets_no_limit_of_losses() -> None:
    up = camera((0.0, 0.0, 3.5)).replace(rpy_deg=(0.0, -20.0, 0.0), hfov_deg=1.0)
    asked = subject(Rig(sensors=(up,)))
    seen = Check(asked, required("covered: [{of: voxels, class: car, sensors: 1, at_least: 0}]")).verdicts()
    assert 0.0 < (seen[0].finding.value or 0.0) < 0.05
    for share_of in ("all", "detected"):
        text = f"losses: [{{of: voxels, class: car, share_of: {share_of}, at_most: 1}}]"
        (verdict,) = Check(asked, required(text)).verdicts()
        assert (verdict.status, verdict.passes) == ("not applicable", False)
        assert "too little to lose" in verdict.lines()[0]


# ---------------------------------------------------------------- settings


def test_a_scene_that_is_not_that_of_the_requirements_is_refused() -> None:
    asked = subject(some_rig())
    field = asked.evaluate.field
    assert field is not None
    sha256, frames = "ab" * 32, field.data.frames
    field = replace(field, data=replace(field.data, sha256=sha256))
    asked = replace(asked, evaluate=Evaluator(field, None, IGNORED))
    seen = "\nseen: [{class: car, at_least: 0}]"
    right = f"{GRID}, boxes_sha256: {sha256}, frames: {frames}"
    assert Check(asked, required(f"settings: {{{right}}}{seen}")).verdicts()[0].passes
    for said, wrong, field in (
        ("voxel_m: 0.5", "voxel_m: 0.1", "voxel_m must be 0.1 m"),
        ("roi_m: [20, 16, 4]", "roi_m: [20, 20, 4]", "roi_m must be 20 × 20 × 4 m"),
        (sha256, "cd" * 32, "boxes must have SHA-256"),
        (f"frames: {frames}", f"frames: {frames + 1}", f"frames must be {frames + 1}"),
    ):
        with pytest.raises(InputError, match=field):
            Check(asked, required(f"settings: {{{right.replace(said, wrong)}}}{seen}"))
    with pytest.raises(InputError, match=r"voxel_m must be 0\.1 m"):
        Check(asked, requirements_in(f"riglens_requirements: 1{seen}", "defaults.yaml"))


# ---------------------------------------------------------------- chances


def test_bounds_of_a_chance_are_those_of_clopper_and_pearson() -> None:
    assert chance_bounds(0, 8) == (0.0, pytest.approx(1.0 - 0.05 ** (1 / 8)))
    assert chance_bounds(8, 8) == (pytest.approx(0.05 ** (1 / 8)), 1.0)
    low, high = chance_bounds(3, 64)

    def at_most(p: float, most: int) -> float:
        return sum(math.comb(64, k) * p**k * (1 - p) ** (64 - k) for k in range(most + 1))

    assert at_most(high, 3) == pytest.approx(0.05) and 1.0 - at_most(low, 2) == pytest.approx(0.05)


def test_a_clean_handful_of_draws_proves_little_and_more_are_made_until_it_is_decided() -> None:
    text = "tolerance: [{profile: assembly, class: car, limit: 0, draws: 8, max_draws: %d, at_most: 0.05}]"
    (few,) = verdicts(some_rig(2), text % 32)
    assert (few.status, few.passes) == ("not shown", False) and few.finding.value == 0.0
    assert "(0 of 32 draws)" in few.text and "after 32 draws, the most" in few.lines()[0]
    (more,) = verdicts(some_rig(2), text % 256)
    assert more.status == "met" and "(0 of 64 draws)" in more.text
    assert more.finding.bounds == chance_bounds(0, 64)
    (wrong,) = verdicts(some_rig(2), text.replace("limit: 0", "limit: 1") % 256)
    assert wrong.status == "not met" and "(8 of 8 draws)" in wrong.text


def test_a_chance_is_that_of_the_figure_of_all_frames_whatever_the_sample() -> None:
    text = "on_target: [{class: car, at_least: 0}]"
    rig, none = some_rig(2), "tolerance_profiles: [{name: none, source: a test, position_mm: 1e-9}]\n"
    designed = verdicts(rig, text)[0].finding.value
    chance = f"settings: {{{GRID}, sample_frames: 3}}\n{none}"
    chance += "tolerance: [{profile: none, figure: on_target, class: car, limit: %.17g}]"
    assert verdicts(rig, chance % designed)[0].finding.value == 0.0
    assert verdicts(rig, chance % (designed + 1e-12))[0].finding.value == 1.0


def test_more_draws_begin_with_those_of_fewer_and_are_those_of_the_tolerance() -> None:
    rig, profile = some_rig(2), profile_called("assembly")
    for few in (1, 5, 8):
        assert np.array_equal(unit_draws(40, 15, 7)[:few], unit_draws(few, 15, 7))
    field = random_field(SMALL, np.random.default_rng(0))
    draws = Draws(rig, profile, 7, Measures(Evaluator(field)))
    assert len(draws.first(3)) == 3 and len(draws.first(6)) == 6
    errors = unit_draws(6, errors_count(rig), 7)
    for found, error in zip(draws.first(6), errors, strict=True):
        moved = standing(*disturbed(rig, profile, error))
        seen = Engine(field).evaluate(moved, with_seen=False).scores.classes["car"].any_seen
        assert found["seen car"].value == seen


# ---------------------------------------------------------------- failures and draws


def test_blind_zones_and_objects_with_a_failure_are_those_of_the_worst_rig_without_it() -> None:
    rig = grouped(some_rig(4))
    text = (
        "blind_areas: [{height_m: 0.8, failing: WHAT, at_most_m2: 1},"
        " {height_m: 0.3, failing: WHAT, by: lidar, sector: rear, within_m: 5, at_most_m2: 1}]\n"
        "blind_objects: [{profile: adults-around, failing: WHAT}]"
    )
    names = [sensor.name for sensor in rig.sensors]
    failures = {
        "sensor": [(name,) for name in names],
        "pair": [(one, other) for n, one in enumerate(names) for other in names[n + 1 :]],
        "group": [(names[0], names[3]), (names[0], names[1], names[3])],
        "half": [],
    }
    profile = next(profile for profile in bundled_profiles() if profile.name == "adults-around")
    for what, failing in failures.items():
        rigs = [without(rig, members) for members in failing]
        rigs += [damaged(rig, [f"{name}={half}"]) for name in names for half in HALVES if what == "half"]
        settings = required(text.replace("WHAT", what)).blind_settings
        maps = [BlindEngine(rig.vehicle, settings).evaluate(one) for one in rigs]
        found = [one.finding.value for one in verdicts(rig, text.replace("WHAT", what))]
        assert found == [
            pytest.approx(max(one.area_m2(0.8).sum() for one in maps)),
            pytest.approx(max(one.area_m2(0.3, "lidar")[4, :3].sum() for one in maps)),
            max(len(ObjectVisibility(one, "blocks").verdict(profile).failed) for one in rigs),
        ]


def test_the_worst_half_costs_no_more_than_the_worst_sensor() -> None:
    rig = some_rig()
    text = (
        "losses: [{of: OF, class: car, failure: half, at_most: 0},"
        " {of: OF, class: car, failure: sensor, at_most: 1}, "
        "{of: OF, class: car, failure: half, name: s1=left, at_most: 1}]"
    )
    for of in ("voxels", "objects"):
        half, whole, named = (one.finding for one in verdicts(rig, text.replace("OF", of)))
        assert half.value is not None and whole.value is not None and named.value is not None
        assert named.value <= half.value <= whole.value
        assert "s1=left is blocked" in named.text
    with pytest.raises(InputError, match="has no half 's9=left'"):
        verdicts(rig, text.replace("s1", "s9").replace("OF", "voxels"))


def test_a_verdict_on_objects_without_sensors_is_that_of_the_rig_without_them() -> None:
    rig = some_rig(5)
    gone = (rig.sensors[0].name, rig.sensors[3].name)
    for profile in bundled_profiles():
        shortened = ObjectVisibility(rig, "blocks").verdict(profile).without(gone)
        assert shortened == ObjectVisibility(without(rig, gone), "blocks").verdict(profile)


def test_blind_zones_and_objects_at_the_worst_draw_are_those_of_a_rig_and_car_with_its_errors() -> None:
    rig = some_rig(3)
    text = (
        "blind_areas: [{height_m: 0.8, under: load, draws: 4, at_most_m2: 1}]\n"
        "blind_objects: [{profile: adults-around, under: load, draws: 4}]"
    )
    asked, profile = required(text), profile_called("load")
    objects = next(profile for profile in bundled_profiles() if profile.name == "adults-around")
    areas, unseen = [], []
    for errors in unit_draws(4, errors_count(rig), 0):
        moved, stance = disturbed(rig, profile, errors)
        engine = BlindEngine(rig.vehicle, asked.blind_settings)
        areas.append(engine.evaluate(standing(moved, stance), stance=stance).area_m2(0.8).sum())
        visibility = ObjectVisibility(standing(moved, stance), "blocks", stance=stance)
        unseen.append(len(visibility.verdict(objects).failed))
    area, objects_found = Check(subject(rig), asked).verdicts()
    assert area.finding.value == pytest.approx(max(areas)) and len(set(areas)) > 1
    assert objects_found.finding.value == max(unseen)
    assert "worst of 4 draws under load" in area.text


@pytest.mark.parametrize(
    "limit", ["blind_areas: [{height_m: 0.8, at_most_m2: 1000000, CASE}]",
              "blind_objects: [{profile: adults-around, at_most_unseen: 1000, CASE}]"],
)  # fmt: skip
def test_few_draws_within_a_limit_do_not_show_that_it_holds(limit: str) -> None:
    for draws, status in ((1, "not shown"), (58, "not shown"), (59, "met")):
        (verdict,) = verdicts(some_rig(2), limit.replace("CASE", f"under: load, draws: {draws}"))
        assert verdict.status == status and verdict.passes == (status == "met")
    (verdict,) = verdicts(some_rig(2), limit.replace("CASE", "under: load, draws: 1"))
    assert "up to 95.0 % may exceed it" in verdict.lines()[0]
    beyond = limit.replace("1000000", "0").replace("1000,", "0,").replace("CASE", "under: load, draws: 1")
    assert verdicts(Rig(sensors=(camera((0.0, 0.0, 3.0)),)), beyond)[0].status == "not met"


def test_the_worst_failure_at_the_worst_draw_is_that_of_every_draw_without_every_sensor() -> None:
    rig = grouped(some_rig(4))
    text = (
        "blind_areas: [{height_m: 0.8, failing: WHAT, under: load, draws: 2, at_most_m2: 1}]\n"
        "blind_objects: [{profile: adults-around, failing: WHAT, under: load, draws: 2}]"
    )
    names = [sensor.name for sensor in rig.sensors]
    profile = next(profile for profile in bundled_profiles() if profile.name == "adults-around")
    for what in ("sensor", "half"):
        asked = required(text.replace("WHAT", what))
        areas, unseen = [], []
        for errors in unit_draws(2, errors_count(rig), 0):
            moved, stance = disturbed(rig, profile_called("load"), errors)
            stood = standing(moved, stance)
            rigs = [without(stood, (name,)) for name in names]
            if what == "half":
                rigs = [damaged(stood, [f"{name}={half}"]) for name in names for half in HALVES]
            for one in rigs:
                found = BlindEngine(rig.vehicle, asked.blind_settings).evaluate(one, stance=stance)
                areas.append(found.area_m2(0.8).sum())
                unseen.append(len(ObjectVisibility(one, "blocks", stance=stance).verdict(profile).failed))
        area, objects = Check(subject(rig), asked).verdicts()
        assert area.finding.value == pytest.approx(max(areas)) and len(set(areas)) > 1
        assert objects.finding.value == max(unseen)
        place, members = int(np.argmax(areas)) // len(rigs), int(np.argmax(areas)) % len(rigs)
        failed = names[members] if what == "sensor" else f"{names[members // 4]}={list(HALVES)[members % 4]}"
        state = "failed" if what == "sensor" else "blocked"
        assert area.lines() == (f"draw {place}", f"{failed} {state}")


# ---------------------------------------------------------------- ids, ties, waivers


def test_ids_follow_what_is_required_and_neither_limits_nor_order() -> None:
    text = "seen: [{class: car, at_least: 0.5}, {class: car, by: lidar, at_least: 0.4}]\nlosses: [%s]\n"
    loss = "{of: voxels, class: car, name: left bracket, failure: group, at_most: 0.1}"
    ids = {item.place: item.id for item in required(text % loss).items()}
    assert ids == {
        ("seen", 0): "seen-car",
        ("seen", 1): "seen-car-lidar",
        ("losses", 0): "losses-voxels-car-group-left-bracket",
    }
    other = text.replace("0.5}, ", "0.9, why: so}, {id: mine, name: A, class: car, at_least: 0}, ") % loss
    assert {item.id for item in required(other).items()} == {*ids.values(), "mine"}
    twice = required("seen: [{class: car, at_least: 0.5}, {class: car, at_least: 0.6}]").items()
    assert [item.id for item in twice] == ["seen-car", "seen-car-2"]
    with pytest.raises(InputError, match=r"required.yaml:5: seen\[1\].id: 'a' is the id of another"):
        required("seen:\n  - {id: a, class: car, at_least: 0.5}\n  - {id: a, class: bicycle, at_least: 0.5}")


def test_a_tie_shows_the_digits_that_decide() -> None:
    assert amounts(0.86479, 0.8648, "share") == ("86.479 %", "86.480 %")
    assert amounts(0.8648, 0.8648, "share") == ("86.48 %", "86.48 %")
    assert amounts(1.0 + 2**-52, 1.0, "m²")[0].startswith("1.0000000000000002")
    assert (
        amounts(0.5, 0.8648, "share") == ("50.00 %", "86.48 %") and amounts(3, 0, "objects")[0] == "3 objects"
    )


def test_a_waiver_holds_up_to_its_day_with_its_reason() -> None:
    rig = some_rig(2)
    (verdict,) = verdicts(
        rig,
        "seen: [{class: car, at_least: 1, why: R1, waived: {reason: new bracket in May, until: 2026-06-01}}]",
    )
    assert verdict.status == "not met" and not verdict.passes and not verdict.holds_on(None)
    assert verdict.holds_on(DAY) and verdict.is_waived_on(DAY) and not verdict.holds_on(date(2026, 6, 2))
    assert not verdict.holds_on(date(2024, 5, 1)), "more than two years"
    assert "two years ahead" in verdict.lines(date(2024, 5, 1))[-1]
    assert "waived until 2026-06-01: new bracket in May" in verdict.lines(DAY)
    assert "why: R1" in verdict.lines(DAY) and "expired" in verdict.lines(date(2026, 6, 2))[-1]
    assert check_document(rig, "ignored", [verdict], day=DAY)["passes"]
    assert not check_document(rig, "ignored", [verdict])["passes"]
    with pytest.raises(InputError, match="must not be blank"):
        required("seen: [{class: car, at_least: 1, waived: {reason: '  ', until: 2026-06-01}}]")
    for until in ("soon", "20", "2026-13-01"):
        with pytest.raises(InputError, match="must be a date such as"):
            required(f"seen: [{{class: car, at_least: 1, waived: {{reason: a, until: {until}}}}}]")


def test_junit_is_well_formed_for_hostile_names_and_counts_what_holds() -> None:
    hostile = "]]></failure>\x1b[31m\ufffe&<\"'"
    rig = some_rig(2).model_copy(update={"name": hostile})
    found = verdicts(
        rig,
        'seen:\n  - {class: car, at_least: 0}\n  - {class: bicycle, at_least: 1, name: "a ]]> <b>"}\n'
        "  - {class: pedestrian, at_least: 1, waived: {reason: '<why>', until: 2026-06-01}}\n"
        "losses: [{of: voxels, class: car, failure: group, at_most: 1, allow_missing: true}]",
    )
    lines = {verdict.item.id: number for number, verdict in enumerate(found, 1)}
    settings = settings_document(required("mounts: {}").settings, None, None)
    settings |= {"requirements": {"file": f"{hostile}\x00\ud800"}}
    text = junit_xml([RigCheck(rig, "ignored", found, hostile, settings)], hostile, lines, DAY)
    suite = ET.fromstring(text)[0]
    assert (suite.get("tests"), suite.get("failures"), suite.get("skipped")) == ("4", "1", "2")
    assert "\\x1b[31m" in (suite.get("name") or "") and "\\ufffe" in (suite.get("name") or "")
    cases = suite.findall("testcase")
    assert [[child.tag for child in case] for case in cases] == [[], ["failure"], ["skipped"], ["skipped"]]
    assert cases[1].get("name") == "seen-bicycle: a ]]> <b>" and suite.get("file") == visible(hostile)
    assert (cases[1][0].text or "").splitlines()[0] == f"{visible(hostile)}:2"
    assert all(set(case.attrib) == {"name", "classname", "time"} for case in cases), (
        "all that Jenkins accepts"
    )
