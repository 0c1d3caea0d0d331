"""Every name of a source belongs to one class, or is counted as not mapped."""

import itertools

import pytest

from riglens.core.errors import InputError
from riglens.core.scene.boxes import CLASSES
from riglens.core.scene.readers.classes import (
    ANY_TABLE,
    ARGOVERSE,
    CARLA,
    KITTI,
    NUSCENES,
    SUMO,
    UNMAPPED,
    ClassTable,
    parse_class_map,
)

TABLES = {"KITTI": KITTI, "nuScenes": NUSCENES, "Argoverse": ARGOVERSE, "SUMO": SUMO, "CARLA": CARLA}


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


def test_overrides_are_read_from_texts() -> None:
    assert parse_class_map(["Tram=car", " a=b = ignore"]) == {"Tram": "car", "a=b": "ignore"}


@pytest.mark.parametrize("pair", ["Tram", "=car", "Tram=lorry", "Tram=", ""])
def test_an_override_of_another_form_is_refused(pair: str) -> None:
    with pytest.raises(
        InputError, match="accepted is NAME=CLASS with one of car, bicycle, pedestrian, ignore"
    ):
        parse_class_map([pair])
