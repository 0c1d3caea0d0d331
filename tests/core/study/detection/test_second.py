"""The second study is the one that was registered: its rigs, protocols and figures."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from riglens.core.simulate.motion import Motion
from riglens.core.study.detection.making import sweeps_of
from riglens.core.study.detection.pieces import Study, samples_of
from riglens.core.study.detection.protocol import Protocol, entrants
from riglens.core.study.detection.second import (
    APART,
    BUDGETS,
    PROTOCOLS,
    budgets,
    rigs_of,
    second_rigs,
)
from tests.core.study.detection.small import NOWHERE, PROTOCOL, digest, rig, traffic

REGISTERED = Path(__file__).resolve().parents[4] / "docs" / "data" / "detection2-registered.md"


def test_rigs_and_protocols_are_those_that_were_registered() -> None:
    text = REGISTERED.read_text(encoding="utf-8")
    assert f"`{digest(PROTOCOLS, rigs_of)}`" in text
    assert all(f"- {one.name}\n" in text for one in second_rigs())


def test_rigs_of_a_budget_cost_alike_and_differ() -> None:
    rigs = entrants(second_rigs())
    found = budgets([one.name for one in rigs])
    assert sorted(place for places in found.values() for place in places) == list(range(len(rigs)))
    for budget, places in zip(BUDGETS, found.values(), strict=True):
        assert len(places) >= 5
        assert all(abs(rigs[place].rays / budget - 1.0) <= APART for place in places)
    assert len({one.key for one in rigs}) == len(rigs) >= 20


def test_painted_rigs_have_wide_narrow_and_no_cameras() -> None:
    rigs = entrants(rigs_of("painted"), "lidars and cameras")
    assert [len(one.rig.enabled_cameras()) for one in rigs] == [0, 6, 6] * 3
    assert len({one.key for one in rigs}) == 9 and len({one.lidars_key for one in rigs}) == 3


def test_parts_differ_in_what_their_names_say() -> None:
    first = PROTOCOLS["pillars"].as_dict()
    apart = {
        arm: {name for name in first | how.as_dict() if first.get(name) != how.as_dict().get(name)}
        for arm, how in PROTOCOLS.items()
    }
    assert apart == {
        "pillars": set(),
        "range": {"panorama", "train_frames"},
        "one-sweep": {"sweeps"},
        "painted": {"sweeps", "painting"},
    }
    assert first["simulation"]["body"] == "blocks"  # type: ignore[index]
    assert not {"sweeps", "panorama"} & set(Protocol().as_dict())  # pieces of other studies keep their names


@pytest.mark.parametrize("detector", ["pillars", "range"])
def test_a_sample_of_several_sweeps_holds_them_all_with_their_age(detector: str) -> None:
    still = traffic()
    zero = Motion(np.zeros((still.frames, 2)), np.zeros(still.frames), np.zeros((len(still.cls), 2)))
    rigs = entrants([rig("a")])
    counts, figures = [], []
    for sweeps in (1, 3):
        how = replace(PROTOCOL, mode="per-rig", sweeps=sweeps, detector=detector)
        study = Study(rigs, how, still, NOWHERE, zero if sweeps > 1 else None)
        held = samples_of(sweeps_of(study, study.compared[0]), "test")
        counts.append(held.points.sum())
        figures.append(held.features)
    assert 2.5 * counts[0] < counts[1] < 3.5 * counts[0]
    assert figures[1].shape[1] == figures[0].shape[1] + 1
    assert 0.0 <= figures[1][:, -1].min() < 0.5 < figures[1][:, -1].max() <= 1.0
