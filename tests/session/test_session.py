"""A whole session at the real window, crash and recovery included; pictures and frame times stay in out/session."""

import json
import os
import shutil
import signal
import subprocess
import sys
from pathlib import Path

import pytest

REPOSITORY = Path(__file__).resolve().parents[2]
OUT = REPOSITORY / "out" / "session"


def run(part: str, folder: Path) -> subprocess.CompletedProcess[str]:
    """One part of the session in a process of its own, with settings of its own."""
    environment = {
        **os.environ,
        "PYTHONPATH": str(REPOSITORY),
        "RIGLENS_CONFIG_DIR": str(folder / "config"),
        "RIGLENS_STATE_DIR": str(folder / "state"),
    }
    command = [sys.executable, "-m", "tests.session.drive", part, str(folder)]
    return subprocess.run(
        command, env=environment, cwd=REPOSITORY, capture_output=True, encoding="utf-8", timeout=1800
    )


@pytest.mark.slow
def test_a_session_with_a_crash_loses_no_edit(xvfb: str) -> None:
    shutil.rmtree(OUT, ignore_errors=True)
    OUT.mkdir(parents=True)
    work = run("work", OUT)
    assert work.returncode == -signal.SIGKILL, work.stderr
    times = {
        name: note
        for name, note in json.loads((OUT / "work.json").read_text(encoding="utf-8")).items()
        if "median_ms" in note
    }
    assert len(times) == 4
    (OUT / "frame-times.json").write_text(json.dumps(times, indent=1), encoding="utf-8")
    recover = run("recover", OUT)
    assert recover.returncode == 0, recover.stderr
    assert "Traceback" not in work.stderr + recover.stderr
    assert len(list(OUT.glob("*.png"))) >= 9
