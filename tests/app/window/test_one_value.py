"""Each figure of a rig has one value, whichever command, page, script or window it comes from."""

from __future__ import annotations

import json
from collections import defaultdict
from pathlib import Path
from typing import Any

import pytest
from pytestqt.qtbot import QtBot

import riglens as rl
from riglens.app.background.counting import make_counter
from riglens.app.commands import main
from riglens.core.rig.model import Rig
from riglens.core.scene.boxes import CLASSES
from riglens.reporting.reading import attached_figures
from tests.app.window_bench import open_bench
from tests.waiting import TIMEOUT_MS

ROI = (20.0, 20.0, 4.0)
GRID = ("--voxel", "0.5", "--roi", "20", "20", "4")
REQUIRED = """riglens_requirements: 1
settings: {voxel_m: 0.5, roi_m: [20, 20, 4]}
blind_areas: [{height_m: 0.3, at_most_m2: 0}]
blind_objects: [{profile: PROFILE, at_most_unseen: 0}]
seen: [{class: car, at_least: 0}, {class: pedestrian, at_least: 0}]
on_target: [{class: car, at_least: 0}]
"""
KINDS = ("any", "camera", "lidar")


class Values:
    """Figures by name, each with its values and where these come from."""

    def __init__(self) -> None:
        self._found: defaultdict[str, dict[Any, list[str]]] = defaultdict(lambda: defaultdict(list))

    def add(self, where: str, **figures: Any) -> None:
        for name, value in figures.items():
            self._found[name][value].append(where)

    def add_scores(self, where: str, rig: dict) -> None:
        for name in CLASSES:
            found = rig["classes"][name]
            self.add(where, **{f"s_ms {name}": found["s_ms"]})
            self.add(where, **{f"seen {name} {kind}": found[kind]["seen"] for kind in KINDS})

    def add_targets(self, where: str, rig: dict) -> None:
        for name in CLASSES:
            self.add(where, **{f"on_target {name}": rig["classes"][name]["lidar"]["on_target"]})

    def add_blind(self, where: str, found: dict) -> None:
        for profile in found["profiles"]:
            self.add(where, **{f"objects {profile['name']}": profile["seen"]})

    def add_redundancy(self, where: str, found: dict) -> None:
        for name in CLASSES:
            self.add(where, **{f"seen {name} any": found["voxels"]["classes"][name]["covered"]["1"]})

    def add_verdicts(self, where: str, found: dict) -> None:
        for verdict in found["verdicts"]:
            words = verdict["text"].split()
            if verdict["section"] == "seen":
                self.add(where, **{f"seen {words[2]} any": verdict["found"]})
            elif verdict["section"] == "on_target":
                self.add(where, **{"on_target car": verdict["found"]})
            else:
                self.add(where, **{verdict["text"]: verdict["found"]})

    @property
    def conflicts(self) -> dict[str, dict[Any, list[str]]]:
        return {name: dict(values) for name, values in self._found.items() if len(values) > 1}

    def sources(self, name: str) -> set[str]:
        return {where for values in self._found[name].values() for where in values}


def said(folder: Path, *words: object) -> dict:
    """The JSON of a command."""
    out = folder / "out.json"
    assert main([str(word) for word in (*words, "--json", out)]) in (0, 1)
    return json.loads(out.read_text(encoding="utf-8"))


@pytest.fixture
def rigs(tmp_path: Path) -> dict[str, str]:
    """Three rigs by name, as they are given to commands: a preset, one edited and saved, and a car that is solid."""
    edited, path = rl.open_rig("W+T"), tmp_path / "edited.yaml"
    low = edited.sensors[-1].replace(position=(0.2, -0.5, 0.9))
    rl.save_rig(edited.replace(name="edited", sensors=(*edited.sensors[:-1], low)), path)
    return {"W+T": "W+T", "edited": str(path), "nuScenes car": "nuScenes car"}


@pytest.mark.slow
def test_every_command_page_script_and_the_window_give_one_value_for_each_figure(
    qtbot: QtBot, tmp_path: Path, rigs: dict[str, str]
) -> None:
    found = {name: Values() for name in rigs}
    for name, given in rigs.items():
        add_window(found[name], qtbot, tmp_path, rl.open_rig(given))
    boxes, required = tmp_path / "boxes.csv", tmp_path / "required.yaml"
    scene = ("--boxes", boxes, *GRID)
    together = said(tmp_path, "evaluate", "--targets", *rigs.values(), *scene)
    alone = {name: said(tmp_path, "evaluate", "--targets", given, *scene) for name, given in rigs.items()}
    for key, add in (("evaluate", Values.add_scores), ("targets", Values.add_targets)):
        both = together if key == "evaluate" else together[key]
        assert both["body"] is None
        assert [rig["body"] for rig in both["rigs"]] == ["ignored", "ignored", "blocks"]
        for number, name in enumerate(rigs):
            one = alone[name] if key == "evaluate" else alone[name][key]
            add(found[name], f"{key} of all", both["rigs"][number])
            add(found[name], key, one["rigs"][0])
    for name, given in rigs.items():
        values, rig = found[name], rl.open_rig(given)
        parts = ("--only", "blind,redundancy,tolerance", "--draws", 1, "--no-sensitivities")
        review = said(tmp_path, "review", given, *parts, *scene)
        blind, tolerance = review["blind"], review["tolerance"]["figures"]
        values.add_blind("blind", blind)
        values.add_redundancy("redundancy", review["redundancy"])
        for cls in CLASSES:
            values.add("tolerance", **{f"seen {cls} any": tolerance[f"seen {cls}"]["nominal"]})
            values.add("tolerance", **{f"on_target {cls}": tolerance[f"on_target {cls}"]["nominal"]})
        profile = blind["profiles"][0]
        required.write_text(REQUIRED.replace("PROFILE", json.dumps(profile["name"])), encoding="utf-8")
        values.add_verdicts("check", said(tmp_path, "check", given, "--requirements", required, *scene))
        values.add(
            "blind", **{f"objects of {profile['name']} unseen": len(profile["objects"]) - profile["seen"]}
        )
        scored = rl.score(rig, rl.load_scene(boxes, 0.5, roi_m=ROI))
        values.add_scores("rl.score", scored.to_dict()["rigs"][0])
        counted = rl.targets(rig, rl.load_traffic(boxes))
        values.add_targets("rl.targets", counted.to_dict()["rigs"][0])
    for shown in ([*rigs], ["W+T"]):
        page, where = tmp_path / "report.html", f"report of {len(shown)}"
        words = ["report", *(rigs[name] for name in shown), "--out", page, "--draws", 0]
        words += ["--requirements", required, *scene]
        assert main([str(word) for word in words]) == 0
        figures = attached_figures(page.read_bytes(), str(page))
        for number, name in enumerate(shown):
            found[name].add_scores(where, figures["evaluation"]["rigs"][number])
            found[name].add_targets(where, figures["targets"]["rigs"][number])
            found[name].add_blind(where, figures["rigs"][number]["blind"])
            found[name].add_redundancy(where, figures["rigs"][number]["redundancy"])
            found[name].add_verdicts(where, figures["rigs"][number]["check"])
    assert {name: values.conflicts for name, values in found.items()} == {name: {} for name in rigs}
    everywhere = {"window", "evaluate", "evaluate of all", "redundancy", "tolerance", "check", "rl.score"}
    assert found["W+T"].sources("seen car any") == everywhere | {"report of 1", "report of 3"}


def add_window(values: Values, qtbot: QtBot, folder: Path, rig: Rig) -> None:
    """Add the window's figures: Scores, Targets and Test objects."""
    with open_bench(qtbot, folder, rig=rig, counter=make_counter()) as bench:
        features = bench.features
        qtbot.waitUntil(
            lambda: features.targets.is_current and features.targets.answer.is_whole, timeout=TIMEOUT_MS
        )
        bench.act("test_objects")
        objects = features.objects
        assert objects._worker.wait_until_idle(TIMEOUT_MS / 1000)
        qtbot.waitUntil(lambda: bool(objects._profiles), timeout=TIMEOUT_MS)
        result = bench.workbench.answers.result
        classes, counts = result.evaluation.scores.classes, features.targets.answer.figures
        for name in CLASSES:
            one = classes[name]
            values.add("window", **{f"s_ms {name}": one.s_ms, f"seen {name} any": one.any_seen})
            values.add("window", **{f"seen {name} {kind}": getattr(one, kind).seen for kind in KINDS[1:]})
            values.add("window", **{f"on_target {name}": counts["on_target"][name].value})
        for found in objects._profiles:
            values.add("window", **{f"objects {found.profile.name}": len(found.objects) - len(found.failed)})
