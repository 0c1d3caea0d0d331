"""Spots and candidates: where they are, what keeps them out, and what conflicts."""

import numpy as np
import pytest

from riglens.core.errors import InputError
from riglens.core.geometry import Pose
from riglens.core.optimise.additions import Additions, Move
from riglens.core.optimise.candidates import choices_of, conflicts, rules_for
from riglens.core.optimise.spots import skin_spots
from riglens.core.review.mounts import KeepOut, MountLimits, Overhang, violations
from riglens.core.rig.edits import mirrored_pose
from riglens.core.rig.library import default_library
from riglens.core.rig.model import PARAMETRIC_BODIES, Rig, Vehicle
from riglens.core.vehicle.solid import solid_of
from riglens.core.vehicle.standing import skin_of

MODEL = "generic-16"


def test_spots_lie_on_the_outer_skin_and_keep_their_distance() -> None:
    solid = solid_of(Vehicle())
    spots = skin_spots(Vehicle(), 0.4)
    points = np.array([spot.point_m for spot in spots])
    away = np.linalg.norm(points[:, None] - points[None], axis=2) + 9.0 * np.eye(len(points))
    assert away.min() >= 0.4
    assert (points[:, 1] >= 0.0).all()
    for spot in spots:
        x, y, z = spot.point_m.tolist()
        assert skin_of(solid).materials_at(np.array([x, y, z]), 1e-5) & {"paint", "panel", "trim"}
        assert np.linalg.norm(spot.normal) == pytest.approx(1.0)
    again = skin_spots(Vehicle(), 0.4)
    assert [spot.point_m.tolist() for spot in again] == points.tolist()


def test_no_place_on_the_skin_is_left_without_a_spot() -> None:
    """A Poisson disk: fewer spots by a larger distance, and no two sets of a distance differ much."""
    few, some, many = (len(skin_spots(Vehicle(), spacing)) for spacing in (0.8, 0.4, 0.2))
    assert few < some / 2 < some < many / 2


@pytest.mark.parametrize("seed", range(4))
def test_candidates_break_no_rule(seed: int) -> None:
    rng = np.random.default_rng(seed)
    car = Vehicle(body=PARAMETRIC_BODIES[seed], length=4.7, width=1.9, height=float(rng.uniform(1.4, 2.4)))
    own = default_library().entry(MODEL).sensor("own", Pose((0.0, 0.0, car.height + 0.2)))
    rig = Rig(vehicle=car, sensors=(own,))
    rules = MountLimits(
        height_m=(float(rng.uniform(0.3, 0.8)), float(rng.uniform(1.5, 3.0))),
        spacing_m=float(rng.uniform(0.2, 0.6)),
        gap_m=float(rng.uniform(0.08, 0.15)),
        beyond_m=Overhang(left=0.1, right=0.1, front=float(rng.uniform(0.0, 0.2)), rear=0.05),
        width_m=car.width + 0.2,
    )
    additions = Additions((MODEL,), 2, mirrored=bool(seed % 2), rules=rules, spots_m=0.45)
    found = choices_of(rig, additions, seed=seed).candidates
    apart = conflicts(found, rig, rules_for(rig, rules))
    names = [sensor.name for one in found for sensor in one.sensors]
    assert len(set(names)) == len(names)
    for number in rng.permutation(len(found))[:6].tolist():
        free = np.flatnonzero(~apart[number])
        added = [found[number], *([found[int(rng.choice(free))]] if len(free) else [])]
        whole = rig.replace(sensors=(own, *(s for one in added for s in one.sensors)))
        mine = [f for f in violations(whole, rules_for(rig, rules)) if f.sensor != "own"]
        assert mine == []


def test_a_pair_is_mirrored_and_named_as_one() -> None:
    found = choices_of(Rig(), Additions((MODEL,), spots_m=0.6)).candidates
    for one in found:
        left, right = one.sensors
        assert right.pose == mirrored_pose(left.pose)
        assert right.mirror_of == left.name
        assert one.cost == 2.0


def test_a_sensor_without_a_partner_may_stand_on_either_side() -> None:
    sides = {
        np.sign(one.places_m[0, 1])
        for one in choices_of(Rig(), Additions((MODEL,), mirrored=False)).candidates
    }
    assert {1.0, -1.0} <= sides


def test_a_sensor_leans_outwards() -> None:
    found = choices_of(Rig(), Additions((MODEL,), spots_m=0.6, tilts_deg=(0.0, 15.0))).candidates
    for one in found:
        up = one.sensors[0].pose.rotation()[:, 2]
        assert np.degrees(np.arccos(min(1.0, float(up[2])))) == pytest.approx(one.tilt_deg, abs=0.01)
        if one.tilt_deg and abs(one.places_m[0, 0]) < 1.0:
            assert up[1] > 0.0


def test_a_lidar_of_a_sector_looks_away_from_the_car() -> None:
    found = choices_of(Rig(), Additions(("hesai-at128",), spots_m=0.6, tilts_deg=(0.0,))).candidates
    rear = [one.sensors[0] for one in found if one.places_m[0, 0] < -2.25]
    assert rear
    assert all(sensor.pose.rotation()[0, 0] < -0.5 for sensor in rear)


def test_painted_zones_and_named_ones_keep_candidates_out() -> None:
    free = choices_of(Rig(), Additions((MODEL,), spots_m=0.5)).candidates
    x, y, z = free[0].places_m[0].tolist()
    painted = choices_of(Rig(keep_out=((x, y, z, 0.5),)), Additions((MODEL,), spots_m=0.5)).candidates
    assert 0 < len(painted) < len(free)
    nowhere = MountLimits(
        keep_out=(KeepOut(name="paint", material="paint"), KeepOut(name="trim", material="trim"))
    )
    with pytest.raises(InputError, match="no mount"):
        choices_of(Rig(), Additions((MODEL,), spots_m=0.5, rules=nowhere))


def test_a_zone_on_either_side_keeps_a_pair_out() -> None:
    asked = Additions((MODEL,), spots_m=0.5)
    pair = next(one for one in choices_of(Rig(), asked).candidates if len(one.places_m) == 2)
    left, right = (
        {
            tuple(one.places_m[0])
            for one in choices_of(Rig(keep_out=((*place.tolist(), 0.5),)), asked).candidates
        }
        for place in pair.places_m
    )
    assert left == right and tuple(pair.places_m[0]) not in left


def test_a_box_holds_places_in_the_air_outside_of_the_car() -> None:
    box = ((-0.4, 0.4), (-0.4, 0.4), (1.2, 2.0))
    asked = Additions((MODEL,), mirrored=False, spots_m=0.4, tilts_deg=(0.0,), box_m=box)
    found = choices_of(Rig(), asked).candidates
    places = np.array([one.places_m[0] for one in found])
    assert (places >= [low for low, _ in box]).all() and (places <= [high for _, high in box]).all()
    assert {round(float(z), 3) for z in places[:, 2]} == {1.6, 2.0}
    assert len({tuple(place) for place in places.tolist()}) == len(found) == 3 * 3 * 2
    pairs = choices_of(Rig(), Additions((MODEL,), spots_m=0.4, tilts_deg=(0.0,), box_m=box)).candidates
    assert len(pairs) == 3 * 2
    assert all(one.places_m[0, 1] > 0.0 for one in pairs)
    moved = choices_of(
        roof_on(Rig()), Additions((), spots_m=0.4, box_m=box), moves=(Move("roof", 0.5),)
    ).candidates
    assert all(np.linalg.norm(one.places_m[0] - [0.0, 0.0, 1.7]) <= 0.5 for one in moved)
    inside = ((-0.5, 0.5), (-0.2, 0.2), (0.6, 1.0))
    with pytest.raises(InputError, match="no mount in the box"):
        choices_of(Rig(), Additions((MODEL,), box_m=inside))


def roof_on(rig: Rig) -> Rig:
    """A car with a LiDAR above its roof."""
    return rig.replace(sensors=(default_library().entry(MODEL).sensor("roof", Pose((0.0, 0.0, 1.7))),))


def test_what_cannot_be_asked_is_refused_in_one_line() -> None:
    for wrong, said in (
        ({"count": 0}, "count"),
        ({"budget": 0.0}, "budget"),
        ({"spots_m": 0.0}, "spots_m"),
        ({"box_m": ((1.0, 0.0), (0.0, 1.0), (0.0, 1.0))}, "box_m"),
    ):
        with pytest.raises(InputError, match=said) as caught:
            Additions(**{"models": (MODEL,), **wrong})
        assert "\n" not in str(caught.value)
    with pytest.raises(InputError, match="budget must be at least 6"):
        choices_of(Rig(), Additions((MODEL,), costs={MODEL: 3.0}, budget=5.0))
