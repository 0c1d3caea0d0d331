"""Rigs of other programs in the window: opened, exported, and a report to read each time."""

from fnmatch import fnmatch
from pathlib import Path

import pytest
from PySide6.QtGui import QAction

from riglens.app.window.dialogs import rig_files
from riglens.core.formats.argoverse import POSES
from riglens.core.formats.exchange import read_rig, writable
from tests.app.window.desk import FullDesk
from tests.app.window_bench import RIG
from tests.core.formats.cases import SMALL, write_files
from tests.waiting import TIMEOUT_MS


def export(bench: FullDesk, name: str) -> None:
    """Choose an entry of File > Export as."""
    bench.features.exchange.menu.aboutToShow.emit()
    action = bench.workbench.window.findChild(QAction, f"export_{name}")
    assert action is not None
    action.trigger()


@pytest.mark.parametrize(
    ("files", "named", "names"),
    [
        (SMALL["nuscenes"], "calibrated_sensor.json", ["CAM_FRONT", "LIDAR_TOP", "RADAR_FRONT"]),
        (SMALL["autoware"], "sensor_kit_calibration.yaml", ["camera0", "velodyne_top"]),
        (SMALL["urdf"], "rig.urdf", ["velodyne", "camera"]),
    ],
)
def test_a_rig_of_another_program_is_opened_with_a_report(
    bench: FullDesk, tmp_path: Path, files: dict[str, str], named: str, names: list[str]
) -> None:
    bench.dialogs.path = write_files(tmp_path / "foreign", files) / named
    bench.act("open")
    bench.qtbot.waitUntil(lambda: bool(bench.dialogs.shown), timeout=TIMEOUT_MS)
    assert [sensor.name for sensor in bench.document.rig.sensors] == names
    assert bench.document.path is None and not bench.workbench.window.isWindowModified()
    (html,) = bench.dialogs.shown
    assert "<b>Converted</b>" in html and "<b>Approximated</b>" in html
    assert "converted:" in bench.dialogs.details[0] and " more" not in html


def test_the_dialog_offers_every_kind_of_file_that_is_read() -> None:
    offered = rig_files().partition("(")[2].partition(")")[0].split()
    names = [name for files in SMALL.values() for name in files]
    for name in (*names, "car.xacro", POSES, "calibrated_sensor.json.gz"):
        assert any(fnmatch(name, pattern) for pattern in offered), name


def test_saving_a_foreign_rig_asks_for_a_file_and_leaves_the_source_alone(
    bench: FullDesk, tmp_path: Path
) -> None:
    source = write_files(tmp_path, SMALL["driveworks"]) / "rig.json"
    before = source.read_bytes()
    bench.dialogs.path = source
    bench.act("open")
    bench.qtbot.waitUntil(lambda: bool(bench.dialogs.shown), timeout=TIMEOUT_MS)
    bench.dialogs.path = tmp_path / "mine.yaml"
    bench.act("save")
    assert (tmp_path / "mine.yaml").is_file() and source.read_bytes() == before


def test_a_broken_foreign_file_is_reported_and_the_rig_stays(bench: FullDesk, tmp_path: Path) -> None:
    bad = tmp_path / "rig.json"
    bad.write_text('{"rig": {"sensors": [1]}}', encoding="utf-8")
    bench.dialogs.path = bad
    bench.act("open")
    bench.qtbot.waitUntil(lambda: "rig.json" in bench.workbench.errors.message, timeout=TIMEOUT_MS)
    assert bench.document.rig == RIG and not bench.dialogs.shown


def test_every_exporter_writes_what_is_shown(bench: FullDesk, tmp_path: Path) -> None:
    for name in [name for name in writable() if name != "riglens"]:
        bench.dialogs.shown.clear()
        bench.dialogs.path = tmp_path / f"out-{name}"
        export(bench, name)
        assert bench.dialogs.path.exists() and len(bench.dialogs.shown) == 1
        assert "<b>Written</b>" in bench.dialogs.shown[0]
        if name != "osi":
            assert len(read_rig(bench.dialogs.path, name).rig.sensors) == len(RIG.sensors)


def test_a_folder_with_other_files_is_not_overwritten_by_an_export(bench: FullDesk, tmp_path: Path) -> None:
    bench.dialogs.path = write_files(tmp_path / "home", {"thesis.tex": "mine"})
    export(bench, "autoware")
    assert "holds thesis.tex" in bench.workbench.errors.message
    assert not bench.dialogs.shown


def test_names_from_a_file_are_shown_as_they_are_and_not_as_markup(bench: FullDesk, tmp_path: Path) -> None:
    text = SMALL["autoware"]["sensor_kit_calibration.yaml"].replace("gnss_link", '"<img src=x>gnss"')
    files = {**SMALL["autoware"], "sensor_kit_calibration.yaml": text}
    bench.dialogs.path = write_files(tmp_path / "kit", files) / "sensors_calibration.yaml"
    bench.act("open")
    bench.qtbot.waitUntil(lambda: bool(bench.dialogs.shown), timeout=TIMEOUT_MS)
    assert "&lt;img src=x&gt;gnss" in bench.dialogs.shown[0] and "<img" not in bench.dialogs.shown[0]


def test_a_dropped_rig_of_another_program_is_opened(bench: FullDesk, tmp_path: Path) -> None:
    bench.features.drop.take([write_files(tmp_path, SMALL["driveworks"]) / "rig.json"])
    bench.qtbot.waitUntil(lambda: bool(bench.dialogs.shown), timeout=TIMEOUT_MS)
    assert [sensor.name for sensor in bench.document.rig.sensors] == ["camera:front", "lidar:top"]


def test_a_rig_of_another_program_can_be_compared_with(bench: FullDesk, tmp_path: Path) -> None:
    bench.features.compare.add_file(write_files(tmp_path, SMALL["driveworks"]) / "rig.json")
    assert len(bench.dialogs.shown) == 1 and bench.document.rig == RIG
