"""The same edit to several sensors: nothing else changes, names stay unique, mirror pairs stay sound."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from riglens.core.errors import InputError
from riglens.core.rig.edits import duplicated, free_name, list_text, pasted, with_enabled, without
from riglens.core.rig.model import MAX_SENSORS, Rig
from riglens.core.rig.presets import preset

RIG = preset("W+T")
NAMES = tuple(sensor.name for sensor in RIG.sensors)
SOME = st.sets(st.sampled_from(NAMES))


@given(SOME, st.booleans())
def test_only_the_chosen_sensors_are_switched(names: set[str], on: bool) -> None:
    changed = with_enabled(RIG, names, on)
    for before, after in zip(RIG.sensors, changed.sensors, strict=True):
        assert after == (before.replace(enabled=on) if before.name in names else before)


@given(SOME)
def test_the_sensors_that_stay_are_the_very_same(names: set[str]) -> None:
    assert without(RIG, names).sensors == tuple(s for s in RIG.sensors if s.name not in names)


@given(SOME)
def test_copies_stand_behind_the_others_under_names_of_their_own(names: set[str]) -> None:
    grown, copies = duplicated(RIG, names, 0.2)
    assert grown.sensors[: len(RIG.sensors)] == RIG.sensors
    assert [sensor.name for sensor in grown.sensors[len(RIG.sensors) :]] == list(copies)
    assert Rig.model_validate(grown.model_dump(by_alias=True)) == grown
    for name, copy in zip((n for n in NAMES if n in names), copies, strict=True):
        x, y, z = RIG.sensor(name).position
        assert grown.sensor(copy).position == (x, y + 0.2, z)


def test_more_copies_than_a_rig_can_hold_are_refused() -> None:
    rig = RIG
    with pytest.raises(InputError, match=f"at most {MAX_SENSORS}"):
        while len(rig.sensors) <= MAX_SENSORS:
            rig, _ = duplicated(rig, {sensor.name for sensor in rig.sensors}, 0.1)


@pytest.mark.parametrize(
    ("taken", "name"),
    [((), "cam"), (("cam",), "cam_2"), (("cam", "cam_2"), "cam_3"), (("cam_2", "cam"), "cam_3")],
)
def test_a_name_that_is_taken_gets_the_next_number(taken: tuple[str, ...], name: str) -> None:
    assert free_name(taken, "cam") == name


def test_one_sensor_is_named_and_several_are_counted() -> None:
    assert list_text(("roof",)) == "roof"
    assert list_text(("roof", "front")) == "2 sensors"


def test_a_rig_holds_as_many_sensors_as_its_limit_and_no_more() -> None:
    one = preset("W+T").enabled_lidars()[0]
    rig = Rig(sensors=tuple(one.replace(name=f"s{n}") for n in range(MAX_SENSORS - 1)))
    full, _ = pasted(rig, [one], 0.1)
    assert len(full.sensors) == MAX_SENSORS
    with pytest.raises(InputError, match=f"at most {MAX_SENSORS}"):
        pasted(full, [one], 0.1)
