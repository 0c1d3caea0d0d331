"""The package of docs/extending.md, installed as it is on the page, works from command line, Python and the window."""

from __future__ import annotations

import json
import re
import shutil
from pathlib import Path

import pytest

from tests.environment import Environment

REPOSITORY = Path(__file__).resolve().parents[1]
PAGE = (REPOSITORY / "docs" / "extending.md").read_text(encoding="utf-8")
FILES = dict(re.findall(r"^`([\w.]+)`:\n\n```\w+\n(.*?)^```", PAGE, re.MULTILINE | re.DOTALL))
MOUNT = {
    "name": "night",
    "at_m": [1.5, 0.0, 0.2],
    "rpy_deg": [0, 5, 0],
    "width": 64,
    "height": 32,
    "hfov_deg": 60,
}
BOXES = """ACME
0 AUTO 8 0 0.8 4.5 1.9 1.6
0 mensch 6 1 0.9 0.6 0.6 1.8
1 rad 7 -1 0.9 1.8 0.6 1.7
1 tram 9 2 1.5 12 2.5 3
"""
USE = """
import riglens as rl

rig = rl.open_rig("front.acme")
scene = rl.load_scene("drive.boxlog", voxel_m=0.5, roi_m=(20, 20, 4))
print(rl.score(rig, scene)["car"].by_kind["thermal"].seen)
"""
WINDOW = """
import json
from pathlib import Path
from PySide6.QtCore import QTimer
from PySide6.QtWidgets import QApplication
from riglens.evaluation.options import SceneOptions, ScoreOptions
from riglens.app.window.dialogs import rig_files
from riglens.app.window.main_window import MainWindow
from riglens.app.window.start import open_window
from riglens.core.formats.opening import open_rig
from riglens.widgets.panels.fields.edits import NumberEdit

def look(result):
    try:
        panels = window.bench.panels
        window.session.document.choose_all()
        edit = panels.inspector.form.findChild(NumberEdit, "hfov_deg")
        seen = result.evaluation.scores.classes["car"].kinds["thermal"].seen
        groups = [panels.tree.topLevelItem(row).text(0) for row in range(panels.tree.topLevelItemCount())]
        print(json.dumps([groups[-1], edit.text(), seen > 0.0, "*.acme" in rig_files()]))
    finally:
        window.close()

def begin():
    global window
    window = next(one for one in QApplication.topLevelWidgets() if isinstance(one, MainWindow))
    window.bench.answers.answered.connect(look)

QApplication([])
QTimer.singleShot(0, begin)
scene = SceneOptions(boxes=Path("drive.boxlog"), voxel_m=0.5, roi_m=(20.0, 20.0, 4.0))
open_window(open_rig("front.acme"), scene, ScoreOptions())
"""


@pytest.fixture(scope="module")
def environment(tmp_path_factory: pytest.TempPathFactory) -> Environment:
    """An environment with this checkout and the package of the page."""
    folder = tmp_path_factory.mktemp("extending")
    (folder / "acme").mkdir()
    for name, text in FILES.items():
        (folder / "acme" / name).write_text(text, encoding="utf-8")
    environment = Environment(folder / "environment")
    (environment.site / "checkout.pth").write_text(f"{REPOSITORY}\n", encoding="utf-8")
    environment.install(folder / "acme")
    return environment


@pytest.fixture
def data(tmp_path: Path) -> Path:
    """A folder with a mount list and a box log."""
    (tmp_path / "front.acme").write_text(json.dumps({"acme_mounts": [MOUNT]}), encoding="utf-8")
    (tmp_path / "drive.boxlog").write_text(BOXES, encoding="utf-8")
    return tmp_path


def riglens(environment: Environment, cwd: Path, *words: str) -> str:
    return environment.run("python", "-m", "riglens", *words, cwd=cwd)


def test_the_command_line_uses_it(environment: Environment, data: Path) -> None:
    riglens(environment, data, "convert", "front.acme", "front.yaml")
    assert "kind: thermal" in (data / "front.yaml").read_text(encoding="utf-8")
    grid = ("--voxel", "0.5", "--roi", "20", "20", "4")
    for rig in ("front.acme", "front.yaml"):
        found = json.loads(
            riglens(environment, data, "evaluate", rig, "--boxes", "drive.boxlog", *grid, "--json", "-")
        )
        assert found["data"]["boxes"] == {"car": 1, "bicycle": 1, "pedestrian": 1}
        assert 0.0 < found["rigs"][0]["classes"]["car"]["thermal"]["seen"] <= 1.0
        figure = found["rigs"][0]["classes"]["car"]["figures"]["acme_share"]
        assert figure["value"] is None and "LiDAR" in figure["reason"]
    view = (*grid, "--boxes", "drive.boxlog", "--size", "160x120")
    for heat in ("seen_by_thermal", "off"):
        riglens(environment, data, "render", "front.acme", *view, "--heatmap", heat, "--out", f"{heat}.png")
    assert (data / "seen_by_thermal.png").read_bytes() != (data / "off.png").read_bytes()


def test_python_uses_it(environment: Environment, data: Path) -> None:
    assert 0.0 < float(environment.run("python", "-c", USE, cwd=data)) <= 1.0


def test_the_window_uses_it(environment: Environment, data: Path, xvfb: str) -> None:
    found = json.loads(environment.run("python", "-c", WINDOW, cwd=data))
    assert found == ["Thermal cameras  1", "60", True, True]


def test_a_broken_package_costs_one_line(environment: Environment, data: Path) -> None:
    distribution = environment.site / "broken_plugin-2.0.dist-info"
    distribution.mkdir()
    (distribution / "METADATA").write_text(
        "Metadata-Version: 2.1\nName: broken-plugin\nVersion: 2.0\n", encoding="utf-8"
    )
    (distribution / "entry_points.txt").write_text(
        "[riglens.sensors]\nsonar = no_such_module:SONAR\n", encoding="utf-8"
    )
    try:
        _, told = environment.output("python", "-m", "riglens", "convert", "front.acme", "out.yaml", cwd=data)
    finally:
        shutil.rmtree(distribution)
    (line,) = (line for line in told.splitlines() if "broken-plugin 2.0" in line)
    assert "no_such_module" in line and "Traceback" not in told
    assert (data / "out.yaml").is_file()
