"""A new heatmap is one declaration: two made-up ones go through the whole product.

`ONCE` is of voxels, with a set of its own; `TALLEST`, the mean of a figure that leads nothing, is of objects. Nothing
else in the program names them.
"""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from PySide6.QtWidgets import QComboBox
from pytestqt.qtbot import QtBot

import riglens as rl
from riglens.app.session.session import HeatChoice
from riglens.core.engine.engine import Engine, Evaluation
from riglens.core.engine.inspect import covered_at_least
from riglens.core.errors import InputError
from riglens.core.figures.heatmaps import OFF, HeatMap, Marks, ObjectHeatMap, VoxelHeatMap
from riglens.core.figures.hits import TALL
from riglens.core.figures.registry import heat_map_named, heat_maps, maps, registered, voxel_sets
from riglens.core.figures.voxel_sets import VoxelSet
from riglens.core.metric.scores import MetricSettings
from riglens.core.scene.columns import Words, unpack
from riglens.evaluation.options import SceneOptions
from riglens.evaluation.requests import EvaluationRequest, LoadedScene, Result
from riglens.evaluation.scoring import Scoring, load_scene
from tests.app.window.counts import count
from tests.app.window.desk import full_desk
from tests.app.window_bench import choose_item
from tests.core.builders import camera, rig_of, spinning
from tests.waiting import TIMEOUT_S
from tools import write_figures

REPOSITORY = Path(__file__).resolve().parents[1]
RIG = rig_of(
    spinning((0.0, 0.0, 1.8), beams=16, count=360).replace(name="top"),
    camera((0.5, 0.0, 1.5)).replace(name="front"),
)
HELP = """
from riglens.core.figures.registry import registered
from tests.test_heatmaps import ONCE

with registered(ONCE):
    from riglens.app.commands import main
    main(["render", "--help"])
"""


def exactly_one(engine: Engine, found: Evaluation) -> Words:
    once, twice, _ = covered_at_least(engine, found.rig, found.settings.method)
    return np.asarray(once & ~twice)


ONCE = VoxelHeatMap(
    key="made_up",
    title="Seen by exactly 1",
    question="The part of the entropy in voxels that exactly one sensor sees.",
    better="less",
    voxels=VoxelSet(key="made_up", seen_by="exactly 1", of=exactly_one),
)
TALLEST = ObjectHeatMap.of(TALL)


@pytest.fixture(autouse=True)
def known() -> Iterator[None]:
    with registered(ONCE), registered(TALLEST):
        yield


@pytest.fixture(scope="module")
def scene() -> LoadedScene:
    return load_scene(SceneOptions(voxel_m=1.0, roi_m=(40.0, 30.0, 4.0)), lambda _: None)


def evaluated(scene: LoadedScene, heat: str, map_by: str | None = None) -> Result:
    request = EvaluationRequest(1, RIG, RIG, MetricSettings(), heat, map_by=map_by)
    return Scoring(scene, 1).exact(request, lambda: False)


def test_every_heatmap_says_what_it_is() -> None:
    every = heat_maps()
    assert {ONCE, TALLEST} <= set(every)
    for names in ([one.key for one in every], [one.key for one in maps()], [one.on_map for one in maps()]):
        assert len(set(names)) == len(names)
    shortcuts = [one.shortcut for one in every if one.shortcut]
    assert len(set(shortcuts)) == len(shortcuts)
    assert all(one.title and one.question.endswith(".") for one in every)


def test_the_registry_knows_it_for_a_while() -> None:
    assert heat_map_named("made_up") is ONCE and ONCE.voxels in voxel_sets()
    with pytest.raises(ValueError, match="already"), registered(ONCE):
        pass
    with pytest.raises(ValueError, match=OFF):
        VoxelHeatMap(key=OFF, title="Nothing", question="Nothing.")


def test_an_evaluation_brings_its_cells_and_its_map_from_above(scene: LoadedScene) -> None:
    found, whole = evaluated(scene, "made_up", "made_up"), evaluated(scene, "entropy").heatmap
    engine = Engine(scene.field, 1)
    marks = [engine.evaluate(rig_of(sensor)).seen_by_any() for sensor in RIG.sensors]
    once = unpack(scene.field.grid, np.asarray(marks[0] ^ marks[1]))
    assert found.heatmap is not None and whole is not None and found.top_view is not None
    assert found.heatmap.title == "Seen by exactly 1, car"
    grid = scene.field.grid
    places = np.floor((found.heatmap.centres_m - np.array(grid.origin_m)) / grid.voxel_m).astype(int)
    wanted = np.where(once[tuple(places.T)], whole.values, 0.0)
    np.testing.assert_allclose(found.heatmap.values, wanted, atol=1e-5)
    assert 0.0 < wanted.sum() < whole.values.sum()
    columns = np.zeros(grid.shape[:2])
    np.add.at(columns, (places[:, 0], places[:, 1]), found.heatmap.values)
    np.testing.assert_allclose(found.top_view.seen * found.top_view.entropy_nat, columns, atol=1e-4)


def test_a_click_means_what_is_drawn(scene: LoadedScene) -> None:
    result = evaluated(scene, "made_up")
    assert isinstance(result.marks, Marks)
    meant = ONCE.meant(result.marks, 1.0)
    assert meant is not None and np.array_equal(meant, result.marks.seen) and meant.any()


def test_the_command_line_offers_it() -> None:
    command = [sys.executable, "-c", HELP]
    done = subprocess.run(command, cwd=REPOSITORY, capture_output=True, encoding="utf-8", timeout=TIMEOUT_S)
    assert "made_up (seen by exactly 1)" in " ".join(done.stdout.replace("│", " ").split()), done.stderr


@pytest.mark.parametrize("heat", [ONCE, TALLEST], ids=lambda heat: heat.key)
def test_python_draws_it(heat: HeatMap, tmp_path: Path) -> None:
    scene, out = rl.load_scene(voxel_m=1.0, roi_m=(20, 20, 4)), tmp_path / "drawn.png"
    traffic = rl.load_traffic().part(range(20))
    drawn = []
    for key in (heat.key, OFF):
        rl.render(RIG, scene, out, heatmap=key, traffic=traffic, size_px=(160, 120), legend=False, rays=False)
        drawn.append(out.read_bytes())
    assert drawn[0] != drawn[1]
    with pytest.raises(InputError, match="made_up"):
        rl.render(RIG, scene, out, heatmap="twofold")


def test_a_heatmap_of_objects_needs_them(tmp_path: Path) -> None:
    scene = rl.load_scene(voxel_m=1.0, roi_m=(20, 20, 4))
    with pytest.raises(InputError, match="heatmap share_25px needs traffic"):
        rl.render(RIG, scene, tmp_path / "drawn.png", heatmap="share_25px")


def test_the_window_offers_it_and_keeps_the_choice(qtbot: QtBot) -> None:
    with full_desk(qtbot) as desk:
        desk.load()
        desk.answer()
        desk.act("heat_made_up")
        assert desk.session.heat == HeatChoice("made_up") and desk.recompute.requests[-1].heat == "made_up"
        assert desk.workbench.actions["heat_made_up"].isChecked()
        panel = desk.features.map.panel
        combo = panel.findChild(QComboBox)
        assert combo is not None
        choose_item(combo, ONCE.voxels.on_map)
        assert panel.seen_by == "made_up"
        desk.act("heat_share_25px")
        assert desk.recompute.requests[-1].heat == OFF
        count(desk)
        data = desk.viewport.state.heatmap
        assert data is not None and data.title == f"{TALL.title}, car" and data.unit == "%"
        choose_item(combo, TALLEST.on_map)
        assert panel.map.readout().startswith(f"{TALLEST.on_map}: mean")


def test_the_page_of_heatmaps_is_made_from_the_registry() -> None:
    page = (REPOSITORY / write_figures.HEATMAPS).read_text(encoding="utf-8")
    shown = write_figures.with_table(page)
    assert ONCE.question in shown and TALLEST.question in shown
    own = ("`made_up`", "`share_25px`")
    assert "\n".join(line for line in shown.split("\n") if not any(key in line for key in own)) == page
