"""The window and the commands say the same: Scores, Targets, Compare and Study against JSON, number by number."""

from __future__ import annotations

import json
from pathlib import Path

from pytestqt.qtbot import QtBot

from riglens.app.background.counting import make_counter
from riglens.app.commands import main
from riglens.app.window.features.compared import CURRENT
from riglens.core.rig.yaml.file import dumps
from riglens.core.scene.boxes import CLASSES
from tests.app.window_bench import CAMERA, RIG, open_bench
from tests.waiting import TIMEOUT_MS

GRID = ("--voxel", "0.5", "--roi", "20", "20", "4")


def said(folder: Path, *words: object) -> dict:
    """The JSON of a command."""
    out = folder / "out.json"
    assert main([str(word) for word in (*words, "--json", out)]) == 0
    return json.loads(out.read_text(encoding="utf-8"))


def test_scores_compare_targets_and_test_objects_are_those_of_the_commands(
    qtbot: QtBot, tmp_path: Path
) -> None:
    one, two = tmp_path / "one.yaml", tmp_path / "two.yaml"
    other = RIG.replace(name="other", sensors=(CAMERA,))
    for path, rig in ((one, RIG), (two, other)):
        path.write_text(dumps(rig), encoding="utf-8")
    with open_bench(qtbot, tmp_path, counter=make_counter()) as bench:
        compare = bench.features.compare
        compare.add_file(two)
        qtbot.waitUntil(
            lambda: (
                all(row.scores and row.counted for row in compare.rows) and bench.features.targets.is_current
            ),
            timeout=TIMEOUT_MS,
        )
        rows = {row.key == CURRENT: row for row in compare.rows}
        bench.act("test_objects")
        objects = bench.features.objects
        assert objects._worker.wait_until_idle(TIMEOUT_MS / 1000)
        qtbot.waitUntil(lambda: objects.page.tree.topLevelItemCount() > 1, timeout=TIMEOUT_MS)
        tree = objects.page.tree
        seen = [tree.topLevelItem(place).text(1) for place in range(tree.topLevelItemCount())]
        boxes = tmp_path / "boxes.csv"
    scene = ("--boxes", boxes, *GRID)
    found = said(tmp_path, "evaluate", "--targets", one, two, *scene)
    scores, counts = found["rigs"], found["targets"]["rigs"]
    for row, score, count in zip((rows[True], rows[False]), scores, counts, strict=True):
        for name in CLASSES:
            assert row.scores.classes[name].any_seen == score["classes"][name]["any"]["seen"]
            assert row.scores.classes[name].s_ms == score["classes"][name]["s_ms"]
            assert row.counted["on_target"][name].value == count["classes"][name]["lidar"]["on_target"]
    profiles = said(tmp_path, "review", one, "--only", "blind")["blind"]["profiles"]
    assert seen == [f"{profile['seen']} of {len(profile['objects'])}" for profile in profiles]
