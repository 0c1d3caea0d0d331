"""Compare shows what rigs get onto road users, counted in the same frames and in the same way."""

from __future__ import annotations

import csv
import io
from dataclasses import replace

from riglens.app.background.counting import OtherCount
from riglens.core.figures.figure import Estimate
from riglens.core.figures.hits import SHARE_5
from riglens.core.figures.registry import leading_figures, object_figures
from riglens.core.figures.text import change_text, decimals_of, estimate_text, in_sentence
from riglens.core.figures.values import values_of_objects
from tests.app.window.counts import ENGINE, count
from tests.app.window.desk import FullDesk


def asked(desk: FullDesk) -> list[OtherCount]:
    return [request for request in desk.counter.others if request.group == "compare"]


def answered(desk: FullDesk, request: OtherCount) -> Estimate:
    figures = values_of_objects(ENGINE.evaluate(request.rig, request.settings))
    desk.features.compare._rigs._take_count(request, figures)
    return figures[SHARE_5.key]["car"]


def shown(desk: FullDesk, name: str) -> str:
    return desk.features.compare.panel.table.text_of(name, "car ≥ 5 pts")


def test_rigs_are_counted_once_the_rig_being_edited_is_and_show_it_first(desk: FullDesk) -> None:
    compare = desk.features.compare
    compare.add_presets(("W+C",))
    assert asked(desk) == []
    count(desk)
    (request,) = asked(desk)
    assert request.rig.name == "W+C"
    assert shown(desk, "W+C") == "…"
    value = answered(desk, request)
    assert shown(desk, "W+C") == estimate_text(SHARE_5, value)
    own = desk.features.targets.answer.figures[SHARE_5.key]["car"]
    assert shown(desk, desk.document.rig.name) == estimate_text(SHARE_5, own)
    leading = [figure.key for figure in leading_figures()]
    assert [column.figure.key for column in compare.panel.model.columns] == 3 * leading


def test_differences_count_from_the_baseline(desk: FullDesk) -> None:
    compare = desk.features.compare
    compare.add_presets(("W+C",))
    count(desk)
    value = answered(desk, asked(desk)[0])
    compare.panel.model.set_shown("baseline")
    before = desk.features.targets.answer.baseline_figures[SHARE_5.key]["car"]
    change = value.minus(before)
    assert shown(desk, "W+C") == change_text(SHARE_5, change.value, decimals_of(SHARE_5, change.se))


def test_another_way_of_counting_makes_all_void(desk: FullDesk) -> None:
    compare = desk.features.compare
    compare.add_presets(("W+C",))
    count(desk)
    old = asked(desk)[0]
    answered(desk, old)
    desk.session.set_targets(replace(desk.session.targets, min_points=9))
    count(desk)
    assert shown(desk, "W+C") == "…"
    answered(desk, old)
    assert shown(desk, "W+C") == "…"
    assert asked(desk)[-1].settings.min_points == 9


def test_counts_last_as_long_as_their_traffic(desk: FullDesk) -> None:
    rigs = desk.features.compare._rigs
    count(desk)
    name = desk.document.rig.name
    counted = shown(desk, name)
    rigs.drop_scores(desk.session.scene)
    assert "%" in counted and shown(desk, name) == counted
    rigs.drop_scores(None)
    assert "%" not in shown(desk, name)


def test_a_rig_that_cannot_be_counted_shows_a_dash(desk: FullDesk) -> None:
    desk.features.compare.add_presets(("W+C",))
    count(desk)
    desk.features.compare._rigs._take_count(asked(desk)[0], None)
    assert shown(desk, "W+C") == "—"


def test_every_figure_is_in_the_table_for_spreadsheets(desk: FullDesk) -> None:
    desk.features.compare.add_presets(("W+C",))
    count(desk)
    value = answered(desk, asked(desk)[0])
    table = list(csv.DictReader(io.StringIO(desk.features.compare.panel.as_text(","))))
    assert float(table[1]["car at least 5 points (fraction)"]) == value.value
    assert table[1]["car S-MS (nat)"] == ""
    for name in ("car", "pedestrian"):
        for figure in object_figures(("lidar", "camera")):
            known = desk.features.targets.answer.figures[figure.key][name]
            unit = {"share": "fraction"}.get(figure.unit, figure.unit)
            text = table[0][f"{name} {in_sentence(figure.title)} ({unit})"]
            assert text == (repr(known.value) if known.exists else "")
