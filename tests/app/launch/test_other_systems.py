"""Window and commands without what only Linux and its like have: modules, signals, non-blocking files, links, /proc.

A stand-in for Windows and macOS: it shows that nothing of this is needed, not that RigLens runs there.
"""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

from tests.app.conftest import REPOSITORY, SMALL_GRID, SMALL_RIG
from tests.waiting import TIMEOUT_S

POOR = """
import os, signal, sys
# which have other code there
import asyncio, concurrent.futures.process, filelock, multiprocessing.popen_spawn_posix, platformdirs.unix, psutil

for name in ("fcntl", "grp", "pwd", "resource", "termios"):
    sys.modules[name] = None
for module, names in (
    (os, "fork geteuid getuid mkfifo sched_getaffinity set_blocking statvfs"),
    (signal, "SIGHUP pthread_kill pthread_sigmask setitimer"),
):
    for name in names.split():
        delattr(module, name)


def no_link(*_: object, **__: object) -> None:
    raise OSError(1314, "A required privilege is not held by the client")


def check(event: str, arguments: tuple[object, ...]) -> None:
    if event == "open" and str(arguments[0]).startswith("/proc"):
        where = str(sys._getframe(1).f_globals.get("__name__"))
        if not where.startswith("psutil"):
            raise FileNotFoundError(2, f"{where} reads", arguments[0])


os.symlink = os.link = no_link
sys.addaudithook(check)
"""
WINDOW = """
import signal, sys
from PySide6.QtCore import QTimer
from PySide6.QtWidgets import QApplication
from riglens.app.window.start import open_window
from riglens.core.formats.opening import open_rig
from riglens.evaluation.options import SceneOptions, ScoreOptions

app = QApplication(["riglens"])
QTimer.singleShot(0, lambda: signal.raise_signal(signal.SIGTERM))
sys.exit(open_window(open_rig(sys.argv[1]), SceneOptions(), ScoreOptions()))
"""
COMMANDS = """
import signal, sys
from riglens.app.commands import main

if __name__ == "__main__":
    assert sys.modules["fcntl"] is None
    for words in sys.argv[1:]:
        assert main(words.split()) == 0, words
"""
BODY = "vehicle: {body: body.obj, length: 4, width: 2, height: 1.5}\n"
MESH = "v 2 1 0.2\nv -2 1 0.2\nv 2 -1 0.2\nv 0 0 1.5\nf 1 2 4\nf 2 3 4\nf 3 1 4\nf 1 3 2\n"
XACRO = """<robot name="r" xmlns:xacro="http://www.ros.org/wiki/xacro"><link name="base_link"/><link name="roof_lidar"/>
<joint name="j" type="fixed"><parent link="base_link"/><child link="roof_lidar"/><origin xyz="0 0 ${1 + 1}"/></joint>
</robot>"""


@pytest.fixture
def poor(tmp_path: Path) -> dict[str, str]:
    """The environment of a Python that lacks these things, and so do the processes that it starts."""
    (tmp_path / "poor").mkdir()
    (tmp_path / "poor" / "sitecustomize.py").write_text(POOR, encoding="utf-8")
    return {**os.environ, "PYTHONPATH": os.pathsep.join((str(tmp_path / "poor"), str(REPOSITORY)))}


def output_of(script: str, *words: str, environment: dict[str, str], folder: Path, code: int = 0) -> str:
    """Return what a script prints, which must end with this code."""
    (folder / "script.py").write_text(script, encoding="utf-8")
    done = subprocess.run(
        [sys.executable, "script.py", *words],
        cwd=folder, env=environment, capture_output=True, encoding="utf-8", timeout=TIMEOUT_S,
    )  # fmt: skip
    assert done.returncode == code, done.stderr
    assert "Traceback" not in done.stderr, done.stderr
    return done.stdout


def test_commands_need_nothing_that_only_linux_has(poor: dict[str, str], tmp_path: Path, boxes: Path) -> None:
    (tmp_path / "body.obj").write_text(MESH, encoding="utf-8")
    (tmp_path / "rig.yaml").write_text(SMALL_RIG.replace("sensors:", BODY + "sensors:"), encoding="utf-8")
    (tmp_path / "robot.xacro").write_text(XACRO, encoding="utf-8")
    grid = " ".join(SMALL_GRID)
    out = output_of(
        COMMANDS,
        f"data build boxes.csv boxes.csv --out boxes.npz --workers 2 {grid}",
        f"evaluate rig.yaml --boxes boxes.csv --json - {grid}",
        f"sweep rig.yaml --vary roof.z=1.8:2:2 --out sweep.parquet --boxes boxes.csv --workers 2 {grid}",
        f"report rig.yaml --boxes boxes.csv --out report.html {grid}",
        "convert robot.xacro robot.yaml",
        f"convert rig.yaml {os.devnull} --to urdf",
        environment=poor, folder=tmp_path,
    )  # fmt: skip
    assert '"name": "small"' in out
    for name in ("boxes.npz", "sweep.parquet", "report.html", "robot.yaml"):
        assert (tmp_path / name).stat().st_size > 0


def test_the_window_opens_and_heeds_signals_there(poor: dict[str, str], tmp_path: Path, xvfb: str) -> None:
    (tmp_path / "rig.yaml").write_text(SMALL_RIG, encoding="utf-8")
    output_of(WINDOW, "rig.yaml", environment=poor, folder=tmp_path, code=130)


def test_the_window_opens_offscreen_on_this_system(tmp_path: Path) -> None:
    (tmp_path / "rig.yaml").write_text(SMALL_RIG, encoding="utf-8")
    here = {**os.environ, "PYTHONPATH": str(REPOSITORY), "QT_QPA_PLATFORM": "offscreen"}
    output_of(WINDOW, "rig.yaml", environment=here, folder=tmp_path, code=130)
