"""Objects beside the car: rays counted one by one, shares by hand, profiles as files."""

import numpy as np
import pytest

from riglens.core.blind.outline import Outline
from riglens.core.errors import InputError
from riglens.core.review.profiles import (
    Place,
    Profile,
    Shape,
    Target,
    bundled_profiles,
    read_profiles,
    targets_of,
)
from riglens.core.review.verdicts import ObjectVerdict, ObjectVisibility, ray_counts, surface_share, verdicts
from riglens.core.rig.model import Lidar, LinearAngles, Rig, Sensor, Vehicle
from riglens.core.sensing.body_ends import barrier_of
from riglens.core.sensing.rays import sensor_rays
from riglens.core.vehicle.solid import solid_of
from tests.core.review.scenes import BOX, camera, dense_lidar, random_rig
from tests.core.vehicle.solids import brute_force


def counted(sensor: Sensor, directions: np.ndarray, target: Target, ends: np.ndarray) -> list[int]:
    """Rays that get there before they end, and rays that would if nothing ended them.

    A ray is inside of a cylinder by its nearest approach to the axis, half the chord there, and the two lids.
    """
    (x, y, z), (least, most) = sensor.position, sensor.range_m
    dx, dy, dz = directions.T
    flat = np.hypot(dx, dy)
    away = np.array([target.x_m - x, target.y_m - y])
    along, aside = (away[0] * dx + away[1] * dy) / flat, (away[0] * dy - away[1] * dx) / flat
    chord = np.sqrt(np.maximum(target.radius_m**2 - aside**2, 0.0))
    lids = np.sort([(0.0 - z) / dz, (target.height_m - z) / dz], axis=0)
    near = np.maximum(np.maximum(least, (along - chord) / flat), lids[0])
    far = np.minimum(np.minimum(most, (along + chord) / flat), lids[1])
    meets = (abs(aside) < target.radius_m) & (near < far)
    return [int((meets & (near < ends)).sum()), int(meets.sum())]


def test_rays_on_objects_are_those_of_a_search_through_all_rays_and_triangles() -> None:
    rng = np.random.default_rng(5)
    solid = solid_of(BOX)
    blocked = 0
    for sensor in random_rig(rng, 6).sensors:
        ranged = sensor.replace(range_m=(0.3, 6.0))
        barrier = barrier_of(ranged, solid)
        directions = sensor_rays(ranged).directions
        ends, _ = brute_force(np.array(ranged.position), directions, solid.triangles_m, barrier.start_m)
        for _ in range(8):
            x, y, r, h = rng.uniform([-6.0, -6.0, 0.05, 0.2], [6.0, 6.0, 0.6, 2.0]).tolist()
            target = Target("o", x, y, r, h)
            found = ray_counts(ranged, [target], ends)[0].tolist()
            assert found == counted(ranged, directions, target, ends)
            blocked += found[1] - found[0]
    assert blocked > 0


def test_a_sensor_in_an_object_meets_it_with_every_ray_and_one_out_of_range_with_none() -> None:
    lidar = dense_lidar(1.0, 10, 20)
    around = Target("a", 0.0, 0.0, 0.5, 2.0)
    assert ray_counts(lidar, [around], np.zeros(0))[0, 0] == lidar.ray_count
    beside = Target("c", 0.3, 0.2, 0.5, 1.4)
    assert ray_counts(lidar, [beside], np.zeros(0))[0, 0] == lidar.ray_count
    near = lidar.replace(range_m=(0.0, 2.0))
    assert ray_counts(near, [Target("b", 5.0, 0.0, 0.5, 2.0)], np.zeros(0))[0, 0] == 0


def test_the_share_in_view_is_that_of_the_surface() -> None:
    whole, half = Target("a", 4.0, 0.0, 0.2, 1.0), Target("b", 0.0, 6.0, 0.2, 2.0)
    ahead = camera((0.0, 0.0, 0.5))
    assert surface_share(ahead, whole, None) == 1.0 and surface_share(ahead, half, None) == 0.0
    assert surface_share(ahead.replace(range_m=(5.0, 9.0)), whole, None) == 0.0
    for x, y in ((4.0, 6.0), (4.0, -6.0), (-4.0, 0.0)):
        assert surface_share(ahead, Target("beside", x, y, 0.2, 1.0), None) == 0.0
    wide = Target("wide", 4.0, 0.0, 1.0, 1.0)
    assert (
        surface_share(ahead.replace(range_m=(0.0, 3.95)), wide, None) == 1.0
    )  # all that faces it, nothing behind
    above = camera((0.0, 0.0, 3.0), 0.0, 90.0)
    assert surface_share(above, Target("lid", 0.1, 0.0, 1.0, 0.1), None) == 1.0
    back = Lidar(
        name="b", position=(0.0, 0.0, 0.5), elevations_deg=(-30.0, 30.0), azimuths_deg=(150.0, 180.0, 210.0)
    )
    behind_it = [Target("far", -4.0, y, 0.2, 1.0) for y in (0.0, 0.5, -0.5)]
    assert [surface_share(back, target, None) for target in behind_it] == [1.0, 1.0, 1.0]
    assert surface_share(back, whole, None) == 0.0
    level = Lidar(name="a", position=(0.0, 0.0, 1.0), elevations_deg=(-30.0, 0.0))
    assert (
        surface_share(level, half, None) == 0.5
    )  # the lower half, which reaches down to the ground within 30 deg
    both_ways = level.replace(azimuths_deg=(0.0, 180.0))  # two steps go all the way round
    assert surface_share(both_ways, Target("right", 0.0, -6.0, 0.2, 2.0), None) == 0.5
    quarter = level.replace(azimuths_deg=(-45.0, 0.0, 45.0))
    assert surface_share(quarter, half, None) == 0.0
    far = ahead.replace(range_m=(0.0, 2.0))
    assert surface_share(far, whole, None) == 0.0
    assert surface_share(ahead, Target("around", 0.0, 0.0, 0.5, 2.0), None) == 0.0  # none of it faces inwards
    behind = camera((0.0, 0.0, 1.0))  # inside the box of sheet metal
    barrier = barrier_of(behind, solid_of(BOX))
    assert surface_share(behind, whole, barrier) == 0.0 and surface_share(behind, whole, None) == 1.0


def test_objects_stand_where_their_profile_says_from_the_outermost_points() -> None:
    outline = Outline(-2.0, 3.0, -1.0, 1.5)
    by_name = {profile.name: profile for profile in bundled_profiles()}
    places = {t.name: (t.x_m, t.y_m) for t in targets_of(by_name["fmvss-111-far"], outline)}
    assert places["B"] == pytest.approx((-8.1, 0.0)) and places["E"] == pytest.approx((-5.05, -1.52))
    turn = targets_of(by_name["german-turn-assist"], outline)
    xs, ys = {round(t.x_m, 6) for t in turn}, {round(t.y_m, 6) for t in turn}
    assert (min(xs), max(xs), min(ys), max(ys)) == (-3.0, 3.0, -3.5, -1.9)
    assert max(np.diff(sorted(xs))) <= 0.8 and len(turn) == len(xs) * len(ys)
    rear = targets_of(by_name["un-r158-detection"], outline)
    assert {round(t.x_m, 6) for t in rear} == {-3.0, -2.6, -2.2} and max(t.y_m for t in rear) == 1.5
    front = targets_of(by_name["un-r159-pedestrians"], outline)
    assert {round(t.x_m, 6) for t in front} == {3.3, 4.15, 5.0, 5.85, 6.7} and min(
        t.y_m for t in front
    ) == -1.0
    beside = targets_of(by_name["un-r151-cyclists"], outline)
    assert max(t.y_m for t in beside) == -1.9 and min(t.y_m for t in beside) == -5.25
    sides = [targets_of(by_name[f"un-r166-{side}"], outline) for side in ("left", "right")]
    assert {round(t.y_m, 6) for t in sides[0]} == {1.7, 2.1, 2.5} and max(t.y_m for t in sides[1]) == -1.2
    assert {round(t.x_m, 6) for t in sides[0]} == {3.0, 2.4, 1.8, 1.2}
    for name in ("un-r159-pedestrians", "un-r151-cyclists", "fmvss-111-near", "un-r166-front"):
        assert "check before use" in by_name[name].source and "our choice" in by_name[name].source


def test_an_object_beside_the_car_stands_outwards_of_its_side() -> None:
    outline = Outline(-2.0, 3.0, -1.0, 1.5)
    places = {"ahead": (3.5, 0.0), "behind": (-2.5, 0.0), "left": (0.0, 2.0), "right": (0.0, -1.5)}
    for side, at in places.items():
        other = {"y": 0.0} if side in ("ahead", "behind") else {"x": 0.0}
        assert Place(**{side: 0.5}, **other).at_m(outline) == at


@pytest.mark.parametrize(("side", "ys"), [("left", {2.0, 2.5, 3.0}), ("right", {-1.5, -2.0, -2.5})])
def test_a_field_beside_the_car_lies_outwards_of_its_side(side: str, ys: set[float]) -> None:
    area = {"ahead": (-1.0, 0.0), side: (0.5, 1.5)}
    shape = Shape(height=1.0, diameter=0.3)
    profile = Profile(name="a", title="t", source="s", object=shape, field=area)  # type: ignore[arg-type]
    targets = targets_of(profile, Outline(-2.0, 3.0, -1.0, 1.5))
    assert {t.x_m for t in targets} == {2.0, 2.5, 3.0} and {t.y_m for t in targets} == ys


def test_an_object_is_seen_from_just_enough_rays_and_share_on() -> None:
    level = dense_lidar(1.0, 301, 720).replace(elevations_deg=LinearAngles(from_=-30.0, to=0.0, count=301))
    rig, half = Rig(vehicle=BOX, sensors=(level,)), {"x": 0.0, "left": 5.0}

    def judged(rays: int, share: float) -> ObjectVerdict:
        shape = Shape(height=2.0, diameter=0.4)
        profile = Profile(name="a", title="t", source="s", object=shape, at=(half,), rays=rays, share=share)  # type: ignore[arg-type]
        (one,) = verdicts(rig, [profile], "ignored")[0].objects
        return one

    found = judged(1, 0.0)
    assert found.share == 0.5 and found.rays > 50 and found.target.radius_m == 0.2
    assert judged(found.rays, 0.5).is_seen
    assert not judged(found.rays + 1, 0.5).is_seen and not judged(found.rays, 0.51).is_seen


def test_the_body_hides_objects_only_where_it_blocks() -> None:
    rig = Rig(vehicle=BOX, sensors=(camera((0.0, 0.0, 1.0)),))
    shape, at = Shape(height=1.0, diameter=0.3), ({"ahead": 2.0, "y": 0.0},)
    profile = Profile(name="a", title="t", source="s", object=shape, at=at)  # type: ignore[arg-type]
    seen = [verdicts(rig, [profile], body)[0].passes for body in ("ignored", "blocks")]  # type: ignore[arg-type]
    assert seen == [True, False]


def test_an_object_is_met_by_all_pixels_of_a_camera_whatever_it_casts() -> None:
    shape, at = Shape(height=1.0, diameter=0.3), ({"ahead": 2.0, "y": 0.0},)
    profile = Profile(name="a", title="t", source="s", object=shape, at=at)  # type: ignore[arg-type]
    eye = camera((0.0, 0.0, 1.0))
    rays = [
        verdicts(Rig(vehicle=BOX, sensors=(one,)), [profile], "ignored")[0].objects[0].rays
        for one in (eye, eye.replace(cast=(8, 6)))
    ]
    assert rays[0] == rays[1] > 48


def test_every_profile_names_its_source_and_judges_by_its_own_numbers() -> None:
    profiles = bundled_profiles()
    assert len(profiles) >= 7 and all(len(profile.source) > 20 for profile in profiles)
    heavy = {one.name for one in profiles if not one.is_for(Vehicle(body="van"))}
    assert heavy == {"german-turn-assist", "un-r159-pedestrians", "un-r151-cyclists"}
    light = {one.name for one in profiles if not one.is_for(Vehicle(body="truck"))}
    assert {"un-r166-front", "fmvss-111-far"} <= light and "un-r158-camera" not in light | heavy
    assert {one.name for one in profiles if one.from_memory} == {"fmvss-111-near", "fmvss-111-far"}
    rig = Rig(vehicle=BOX, sensors=(dense_lidar(3.0), camera((-2.0, 0.0, 1.6), 180.0, 20.0)))
    visibility = ObjectVisibility(rig, "blocks")
    for verdict in verdicts(rig, profiles, "blocks"):
        assert verdict == visibility.verdict(verdict.profile)
        for one in verdict.objects:
            assert one.is_seen == (one.rays >= verdict.profile.rays and one.share >= verdict.profile.share)
            assert one.rays == sum(one.rays_by_sensor.values())
            kinds = {rig.sensor(name).kind for name in one.rays_by_sensor}
            assert verdict.profile.by == "any" or kinds == {verdict.profile.by}
        assert verdict.passes == all(one.is_seen for one in verdict.objects)
    nobody = verdicts(Rig(vehicle=BOX), profiles, "ignored")
    assert not any(verdict.passes for verdict in nobody)


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("profiles: []", "1: riglens_profiles is missing"),
        ("riglens_profiles: 2\nprofiles: []", "1: riglens_profiles must be 1 (got 2)"),
        (
            "riglens_profiles: 1\nprofiles:\n  - {name: a, title: b, source: c, object: {height: 0.8}}",
            "diameter",
        ),
        (
            "riglens_profiles: 1\nprofiles:\n  - {name: a, title: b, source: c, object: {height: 1, diameter: 1},\n"
            "     at: [{ahead: 1, behind: 2, y: 0}]}",
            "4: profiles[0].at[0]",
        ),
        ("riglens_profiles: 1\nprofiles: &a []", "anchors"),
        (
            "riglens_profiles: 1\nprofiles:\n"
            + 2
            * "  - {name: a, title: b, source: c, object: {height: 1, diameter: 1}, at: [{x: 1, y: 0}]}\n",
            "profile 'a' is given twice",
        ),
        ("- 1", "a mapping"),
    ],
)
def test_a_wrong_file_is_refused_with_line_and_field(tmp_path, text: str, said: str) -> None:
    path = tmp_path / "mine.yaml"
    path.write_text(text, encoding="utf-8")
    with pytest.raises(InputError) as caught:
        read_profiles(path)
    assert "mine.yaml" in str(caught.value) and said in str(caught.value) and "\n" not in str(caught.value)


def test_a_field_of_too_many_objects_is_refused() -> None:
    with pytest.raises(InputError, match="at most 2000"):
        targets_of(
            Profile(
                name="a",
                title="t",
                source="s",
                object=Shape(height=1.0, diameter=1.0),
                field={"ahead": (0.0, 100.0), "across": "width"},  # type: ignore[arg-type]
                spacing=0.02,
            ),
            Outline(-2.0, 2.0, -1.0, 1.0),
        )


def test_a_disabled_sensor_sees_no_object() -> None:
    rig, (profile, *_) = random_rig(np.random.default_rng(5), 4), bundled_profiles()
    off = rig.with_sensor("s1", rig.sensor("s1").replace(enabled=False))
    (whole,), (some,) = verdicts(rig, [profile], "ignored"), verdicts(off, [profile], "ignored")
    assert some == whole.without(["s1"]) != whole
    assert all("s1" not in one.rays_by_sensor for one in some.objects)
