"""`riglens pog` stores a POG that scores like its boxes; an interrupted build changes nothing."""

import json
import os
import signal
from pathlib import Path

import pytest

from tests.waiting import TIMEOUT_S, poll

SMALL = ("--voxel", "0.5", "--roi", "20", "20", "4")


def scores_of(outcome):
    rigs = json.loads(outcome.out)["rigs"]
    return [{key: value for key, value in rig.items() if key != "elapsed_ms"} for rig in rigs]


def test_a_stored_pog_scores_exactly_as_its_boxes(riglens, boxes, tmp_path):
    stored = riglens("pog", boxes, "--out", tmp_path / "small.npz", *SMALL)
    assert stored.code == 0
    assert "3 frames" in stored.out
    direct = riglens("evaluate", "W+T", "N+C", "--boxes", boxes, *SMALL, "--json", "-")
    through = riglens("evaluate", "W+T", "N+C", "--pog", tmp_path / "small.npz", "--json", "-")
    assert scores_of(direct) == scores_of(through)
    assert json.loads(direct.out)["grid"] == json.loads(through.out)["grid"]
    assert json.loads(direct.out)["data"] == json.loads(through.out)["data"]


@pytest.fixture
def stored(riglens, boxes, tmp_path):
    riglens("pog", boxes, "--out", tmp_path / "small.npz", *SMALL)
    return tmp_path / "small.npz"


@pytest.mark.parametrize(
    "option",
    ["--boxes a.csv", "--voxel 0.2", "--roi 60 40 4", "--origin 0 0 0", "--frames 5", "--classes a=car"],
)
def test_options_that_contradict_the_pog_are_refused(riglens, stored, option):
    name, *values = option.split()
    line = riglens("evaluate", "W+T", "--pog", stored, name, *values).refused()
    assert name in line
    assert "small.npz" in line


def test_options_that_repeat_the_pog_are_fine(riglens, stored):
    assert riglens("evaluate", "W+T", "--pog", stored, *SMALL).code == 0


def test_what_is_not_a_pog_is_refused(riglens, boxes, stored):
    assert "boxes.csv" in riglens("evaluate", "W+T", "--pog", boxes).refused()
    stored.write_bytes(stored.read_bytes()[:-200])
    assert "small.npz" in riglens("evaluate", "W+T", "--pog", stored).refused()


def test_ctrl_c_in_the_middle_of_a_build_changes_nothing(riglens_process, tmp_path):
    table = tmp_path / "long.csv"
    with table.open("w") as file:
        file.write("seq,frame,cls,x,y,z,length,width,height,yaw\n")
        for frame in range(1_000_000):
            file.write(f"s,{frame},bus,{frame % 17},2,1.8,12,2.5,3.5,0.5\n")
    out, cache = tmp_path / "out", tmp_path / "cache"
    out.mkdir()
    (out / "old.npz").write_text("kept")
    environment = {"RIGLENS_CACHE_DIR": str(cache)}
    process = riglens_process(
        "pog", table, "--out", out / "old.npz", "--voxel", "0.1", env=environment, start_new_session=True
    )
    poll(lambda: _has_opened(process.pid, table))
    os.kill(process.pid, signal.SIGINT)
    output, errors = process.communicate(timeout=TIMEOUT_S)
    assert process.returncode in (130, -signal.SIGINT)  # a shell says 130 to both
    assert output == ""
    assert errors == "riglens: interrupted; no file was changed\n"
    assert (out / "old.npz").read_text() == "kept"
    assert [path.name for path in out.iterdir()] == ["old.npz"]


def _has_opened(pid: int, path: Path) -> bool:
    """Whether the process has the file open: the build is under way."""
    folder = f"/proc/{pid}/fd"
    return path.resolve() in [Path(folder, name).resolve() for name in os.listdir(folder)]
