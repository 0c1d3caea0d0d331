"""The form of a LiDAR with a scan pattern: its swings one by one, and the file of a table with its hash."""

from pathlib import Path

from PySide6.QtCore import Qt
from PySide6.QtWidgets import QComboBox, QLabel
from pytestqt.qtbot import QtBot

from riglens.core.rig.model import Lidar, Rig, Sensor
from riglens.core.rig.yaml.file import load_rig
from riglens.core.sensors.scan import Scan, Swing
from riglens.widgets.panels.fields.edits import NumberEdit
from riglens.widgets.panels.inspector.panel import Inspector

FAST = Swing(rate_hz=-121.5, azimuth_deg=18.0, elevation_deg=17.5)
SLOW = Swing(rate_hz=77.7, azimuth_deg=16.0, elevation_deg=12.0, wave="ramp")
PATTERN = Scan(points_per_s=20_000.0, integration_s=0.1, swings=(FAST, SLOW))
LIVOX = Lidar(name="l", position=(1.0, 0.0, 1.5), rays=PATTERN)
SPINNING = Lidar(name="s", position=(1.0, 0.0, 1.5), elevations_deg=(-5.0, 5.0))


def shown(inspector: Inspector, name: str) -> list[NumberEdit]:
    edits = inspector.form.findChildren(NumberEdit, name)
    return [edit for edit in edits if edit.isVisibleTo(inspector.form) and edit.text()]


def test_swings_are_shown_edited_added_and_removed(qtbot: QtBot) -> None:
    inspector = Inspector()
    qtbot.addWidget(inspector)
    inspector.set_rig(Rig(sensors=(LIVOX, SPINNING)), ("l",))
    edited = list[dict[str, Sensor]]()
    inspector.sensors_edited.connect(edited.append)

    def rays() -> Scan:
        sensor = edited[-1]["l"]
        assert isinstance(sensor, Lidar) and isinstance(sensor.rays, Scan)
        return sensor.rays

    assert [edit.text() for edit in shown(inspector, "rate_hz")] == ["-121.5", "77.7"]
    rate = shown(inspector, "rate_hz")[1]
    rate.setText("50")
    rate.textEdited.emit("50")
    rate.setModified(True)
    qtbot.keyClick(rate, Qt.Key.Key_Return)
    assert rays().swings == (FAST, SLOW.replace(rate_hz=50.0))
    waves = [box for box in inspector.form.findChildren(QComboBox, "wave") if box.isVisibleTo(inspector.form)]
    assert [box.currentText() for box in waves] == ["sine", "ramp"]
    waves[1].activated.emit(waves[1].findData("sine"))
    assert rays().swings == (FAST, SLOW.replace(wave="sine"))
    count = inspector.form.findChild(QComboBox, "swings.count")
    assert count is not None and count.currentText() == "2"
    count.activated.emit(count.findData(1))
    assert rays().swings == (FAST,)
    count.activated.emit(count.findData(3))
    assert rays().swings == (FAST, SLOW, SLOW)
    inspector.set_rig(Rig(sensors=(LIVOX, SPINNING)), ("s",))
    assert not shown(inspector, "rate_hz") and not count.isVisibleTo(inspector.form)


def test_the_file_of_a_table_is_shown_with_its_hash(qtbot: QtBot, tmp_path: Path) -> None:
    (tmp_path / "pattern.csv").write_text("azimuth_deg,elevation_deg\n0,0\n1,2\n", encoding="utf-8")
    (tmp_path / "rig.yaml").write_text(
        "riglens: 1\nname: t\nsensors:\n"
        "  - {name: l, kind: lidar, position: [0, 0, 2], rays: {file: pattern.csv}}\n",
        encoding="utf-8",
    )
    rig = load_rig(tmp_path / "rig.yaml").rig
    inspector = Inspector()
    qtbot.addWidget(inspector)
    inspector.set_rig(rig, ("l",))
    note = inspector.form.findChild(QLabel, "rays.note")
    table = rig.sensors[0].table
    assert note is not None and table is not None and note.isVisibleTo(inspector.form)
    text = note.text().replace("\u200b", "")
    assert "pattern.csv: 2 rays" in text and table.ray_rows().sha256 in text
