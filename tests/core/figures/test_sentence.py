"""The sentence that says whether a rig is better: which changes decide it, and what it names."""

import pytest

from riglens.core.figures.figure import ALL, CLASSES_AND_ALL, Estimate
from riglens.core.figures.sentence import sentence


def changes(**by_key: dict[str, float]) -> dict[str, dict[str, Estimate]]:
    """Changes of figures by class; classes that are left out do not change."""
    return {
        key: {who: Estimate(found.get(who, 0.0), se=0.001) for who in CLASSES_AND_ALL}
        for key, found in by_key.items()
    }


@pytest.mark.parametrize(
    ("by_key", "verdict", "named", "not_named"),
    [
        ({"predicted": {ALL: 0.05, "car": 0.05}}, "Better", ("predicted AP +5.0",), ("car",)),
        ({"predicted": {"car": -0.05}}, "Worse", ("car −5.0",), ("pedestrian",)),
        ({"missed": {ALL: -0.03}}, "Better", ("missed −3.0",), ("predicted",)),
        ({"missed": {ALL: 0.03}}, "Worse", ("missed +3.0",), ()),
        (
            {"predicted": {ALL: 0.02, "car": 0.04, "pedestrian": -0.03}},
            "Mixed",
            ("predicted AP car +4.0", "pedestrian −3.0"),
            ("bicycle",),
        ),
        (
            {"predicted": {ALL: 0.04, "car": 0.04}, "seen_by_cameras": {ALL: -0.2}},
            "Mixed",
            ("predicted AP +4.0", "but seen by cameras −20.0"),
            (),
        ),
        (
            {"predicted": {ALL: 0.04}, "share_5": {ALL: 0.02, "bicycle": -0.04, "pedestrian": -0.06}},
            "Mixed",
            ("predicted AP +4.0", "pedestrian −6.0"),
            ("bicycle",),
        ),
        ({"predicted": {"bicycle": 0.04, "pedestrian": 0.06}}, "Better", ("pedestrian +6.0",), ("bicycle",)),
        ({"predicted": {ALL: 0.004}}, "No difference", (), ("predicted",)),
        ({"predicted": {}}, "The same", (), ()),
        ({"s_ms": {ALL: 1e6}}, "Nothing to compare", (), ()),
    ],
)
def test_only_resolved_changes_of_leading_figures_with_a_direction_decide(
    by_key: dict[str, dict[str, float]], verdict: str, named: tuple[str, ...], not_named: tuple[str, ...]
) -> None:
    said = sentence(changes(**by_key), "the baseline")
    assert said.startswith(verdict) and "the baseline" in said
    assert all(one in said for one in named) and not any(one in said for one in not_named)


def test_a_change_within_its_error_decides_nothing_and_a_lack_is_a_reason() -> None:
    unsure = {"predicted": {who: Estimate(0.05, se=0.03) for who in CLASSES_AND_ALL}}
    assert sentence(unsure, "A").startswith("No difference")
    none = {"predicted": {who: Estimate.none("there is no sensor") for who in CLASSES_AND_ALL}}
    assert "there is no sensor" in sentence(none, "A")
