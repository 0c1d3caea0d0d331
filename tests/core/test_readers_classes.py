"""Every name of a source belongs to one class, or is counted as not mapped."""

import itertools

import pytest

from riglens.core.errors import InputError
from riglens.core.scene.boxes import CLASSES
from riglens.core.scene.readers.classes import (
    ANY_TABLE,
    ARGOVERSE,
    CARLA,
    CARLA_BLUEPRINTS,
    KITTI,
    NUPLAN,
    NUSCENES,
    PANDASET,
    SUMO,
    UNMAPPED,
    WAYMO,
    ClassTable,
    fits,
    parse_class_map,
)

TABLES = {"KITTI": KITTI, "nuScenes": NUSCENES, "Argoverse": ARGOVERSE, "SUMO": SUMO, "CARLA": CARLA}
TABLES |= {"Waymo": WAYMO, "nuPlan": NUPLAN, "PandaSet": PANDASET, "blueprints": CARLA_BLUEPRINTS}


def test_the_tables_never_contradict_each_other() -> None:
    for one, other in itertools.combinations(TABLES.values(), 2):
        assert all(one[name] == other[name] for name in one.keys() & other.keys())


@pytest.mark.parametrize(
    ("cls", "names"),
    [
        ("car", "Car Van Truck vehicle.bus.bendy bus trailer construction_vehicle SCHOOL_BUS"),
        ("bicycle", "Cyclist bicycle motorcycle vehicle.motorcycle BICYCLIST MOTORCYCLIST"),
        ("pedestrian", "Pedestrian Person Person_sitting human.pedestrian.child OFFICIAL_SIGNALER"),
    ],
)
def test_names_belong_to_their_class_whatever_their_case(cls: str, names: str) -> None:
    assert set(ClassTable(ANY_TABLE).codes(names.split())) == {CLASSES.index(cls)}


def test_racks_cones_animals_trams_and_unknown_names_belong_to_none() -> None:
    names = ["static_object.bicycle_rack", "traffic_cone", "animal", "DOG", "Tram", "Misc", "DontCare", "ego"]
    assert set(ClassTable(ANY_TABLE).codes(names)) == {UNMAPPED}


@pytest.mark.parametrize(
    ("cls", "names"),
    [
        (
            "car",
            "TYPE_VEHICLE,vehicle,Pickup Truck,Medium-sized Truck,Semi-truck,Towed Object,Emergency Vehicle",
        ),
        ("car", "Other Vehicle - Uncommon,vehicle.tesla.model3,vehicle.carlamotors.firetruck"),
        (
            "bicycle",
            "TYPE_CYCLIST,Motorized Scooter,vehicle.bh.crossbike,vehicle.vespa.zx125,vehicle.yamaha.yzf",
        ),
        ("pedestrian", "TYPE_PEDESTRIAN,Pedestrian with Object,walker.pedestrian.0042"),
    ],
)
def test_names_of_waymo_nuplan_pandaset_and_carla_are_known(cls: str, names: str) -> None:
    assert set(ClassTable(ANY_TABLE).codes(names.split(","))) == {CLASSES.index(cls)}


def test_what_is_like_a_known_name_but_is_none_stays_unmapped() -> None:
    names = ["vehicle.ego", "vehicle.tram.x", "TYPE_SIGN", "Tram / Subway", "Train", "czone_sign", "walker"]
    assert set(ClassTable(ANY_TABLE).codes(names)) == {UNMAPPED}


def test_overrides_may_hold_wildcards() -> None:
    table = ClassTable(ANY_TABLE, {"vehicle.*": "ignore", "vehicle.bus.*": "car", "vehicle.car": "bicycle"})
    names = ["vehicle.truck", "vehicle.bus.rigid", "vehicle.car", "Car", "vehicle.tesla.model3"]
    assert table.codes(names) == [UNMAPPED, 0, 1, 0, UNMAPPED]
    assert table.never_met() == []
    assert ClassTable({}, {"t?p": "car"}).codes(["tip", "trip", "t[p", "t*p"]) == [0, UNMAPPED, 0, 0]
    assert ClassTable({}, {"a[bc]*": "car"}).codes(["ab", "a[bc]d"]) == [UNMAPPED, 0]
    assert ClassTable({}, {"x*": "car"}).never_met() == ["class map: no box is called 'x*'"]


def test_of_several_wildcards_the_last_one_counts_and_the_order_is_part_of_what_is_in_effect() -> None:
    one = ClassTable({}, {"a*": "car", "*b": "bicycle"})
    other = ClassTable({}, {"*b": "bicycle", "a*": "car"})
    assert (one.codes(["ab"]), other.codes(["ab"])) == ([1], [0])
    assert list(one.effective().items()) != list(other.effective().items())
    assert "vehicle.truck" not in ClassTable(ANY_TABLE, {"vehicle.*": "ignore"}).effective()
    assert fits("abc", "a*") and not fits("abc", "a?")


def test_overrides_are_read_from_texts() -> None:
    assert parse_class_map(["Tram=car", " a=b = ignore"]) == {"Tram": "car", "a=b": "ignore"}


@pytest.mark.parametrize("pair", ["Tram", "=car", "Tram=lorry", "Tram=", ""])
def test_an_override_of_another_form_is_refused(pair: str) -> None:
    with pytest.raises(InputError, match="must be NAME=CLASS with one of car, bicycle, pedestrian, ignore"):
        parse_class_map([pair])
