"""A whole study of seconds, with PyTorch: resumed after any stop it ends with the same figures."""

from __future__ import annotations

import multiprocessing
import os
import shutil
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from dataclasses import replace
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest

from riglens.core.detect.net import machine
from riglens.core.detect.pillars import FEATURES
from riglens.core.errors import InputError
from riglens.core.pieces.backend import Backend, workers_at
from riglens.core.pieces.cluster import cluster_workers
from riglens.core.pieces.work import OwnProcess
from riglens.core.rig.model import Camera
from riglens.core.simulate.motion import Motion
from riglens.core.simulate.painting import SCORES
from riglens.core.study.detection.making import make
from riglens.core.study.detection.pieces import Job, Pieces, Study, jobs, samples_of
from riglens.core.study.detection.protocol import entrants
from riglens.core.study.detection.result import assemble, finished_seeds
from riglens.core.study.detection.run import StudyProgress, run
from tests.core.pieces.test_cluster import Cluster
from tests.core.study.detection.small import PROTOCOL, rig, traffic

pytest.importorskip("torch", reason="make test-detect")
REPOSITORY = Path(__file__).resolve().parents[4]
KILLED = """
import sys
from pathlib import Path
from tests.core.study.detection.test_run import small_study, with_processes

if __name__ == "__main__":
    with_processes(small_study(), Path(sys.argv[1]), 2, lambda told: print(told.done, flush=True))
"""


def small_study() -> Study:
    return Study(entrants([rig("a"), rig("b", beams=3)]), PROTOCOL, traffic(), machine("cpu"))


def with_processes(
    study: Study, folder: Path, count: int, tell: Callable[[StudyProgress], None] = lambda told: None
) -> Pieces:
    with workers_at(Backend(count), len(jobs(study))) as workers:
        return run(study, folder, workers, tell)


@pytest.fixture(scope="module")
def whole(tmp_path_factory: pytest.TempPathFactory) -> tuple[Pieces, list[StudyProgress]]:
    told: list[StudyProgress] = []
    return with_processes(small_study(), tmp_path_factory.mktemp("whole"), 2, told.append), told


def figures(pieces: Pieces) -> list[bytes]:
    seeds = pieces.study.protocol.seeds
    return [array.tobytes() for one in assemble(pieces, seeds) for array in (one.by_seed, one.replicas)]


def test_it_makes_every_piece_and_tells_of_it(whole: tuple[Pieces, list[StudyProgress]]) -> None:
    pieces, told = whole
    every = jobs(pieces.study)
    assert len(every) == 6 + 2 * 2 + 4  # sweeps with four references, passes of nets, what they find
    finished = [one.finished.title for one in told if one.finished is not None]
    assert sorted(finished) == sorted(one.title for one in every)
    assert told[0].share == 0.0 and told[-1].share == pytest.approx(1.0) and told[-1].done == len(every)
    assert all(one.share <= other.share + 1e-9 for one, other in pairwise(told))
    assert finished_seeds(pieces) == 2
    held = samples_of(pieces.of(Job(None, pieces.study.compared[0])), "test")
    assert held.frame.tolist() == pieces.study.split.test.tolist() and held.points.sum() > 0


def test_nothing_is_made_twice(whole: tuple[Pieces, list[StudyProgress]]) -> None:
    pieces, _ = whole
    before = {path: path.stat().st_mtime_ns for path in pieces.folder.iterdir()}
    told: list[StudyProgress] = []
    with_processes(small_study(), pieces.folder, 2, told.append)
    assert len(told) == 1 and told[0].share == pytest.approx(1.0)
    assert {path: path.stat().st_mtime_ns for path in pieces.folder.iterdir()} == before


@pytest.mark.parametrize("after", [1, 7])
def test_killed_at_some_moment_and_resumed_it_ends_with_the_same_figures(
    whole: tuple[Pieces, list[StudyProgress]], after: int, tmp_path: Path
) -> None:
    script = tmp_path / "killed.py"
    script.write_text(KILLED, encoding="utf-8")
    environment = os.environ | {"PYTHONPATH": str(REPOSITORY), "RIGLENS_TEST_MARK": str(tmp_path)}
    command = [sys.executable, str(script), str(tmp_path / "pieces")]
    with subprocess.Popen(
        command, env=environment, stdout=subprocess.PIPE, encoding="utf-8", cwd=REPOSITORY
    ) as process:
        assert process.stdout is not None
        for line in process.stdout:
            if int(line) >= after:
                break
        assert marked(str(tmp_path))
        process.send_signal(signal.SIGKILL)
    end = time.monotonic() + 60
    while marked(str(tmp_path)) and time.monotonic() < end:  # its processes end when they see it
        time.sleep(0.1)
    assert not marked(str(tmp_path))
    pieces = with_processes(small_study(), tmp_path / "pieces", 1)
    assert figures(pieces) == figures(whole[0])


def test_workers_that_share_no_folder_make_the_same_pieces(
    whole: tuple[Pieces, list[StudyProgress]], tmp_path: Path
) -> None:
    pieces, _ = whole
    study = pieces.study
    net = study.nets[0]
    last = pieces.of(Job(net, None, study.protocol.epochs))
    for job, state in ((Job(net, None, 1), None), (Job(net, study.compared[0]), last)):
        there = make(study, job, tmp_path / "nothing", state)
        assert there == make(study, job, pieces.folder, state)


def test_a_damaged_piece_is_made_again(whole: tuple[Pieces, list[StudyProgress]], tmp_path: Path) -> None:
    pieces, _ = whole
    shutil.copytree(pieces.folder, tmp_path / "pieces")
    for kind in ("sweeps", "net-0", "found-1"):
        path = sorted((tmp_path / "pieces").glob(f"{kind}-*"))[0]
        path.write_bytes(path.read_bytes()[:-1] + b"?")
    told: list[StudyProgress] = []
    again = with_processes(small_study(), tmp_path / "pieces", 1, told.append)
    assert (
        sum(one.finished is not None for one in told) == 1 + 2 + 1
    )  # a net is trained from its first pass on
    assert figures(again) == figures(pieces)


def test_a_worker_with_another_pytorch_is_refused_in_one_line(tmp_path: Path) -> None:
    other = replace(small_study(), machine=replace(machine("cpu"), torch="1.0"))
    with pytest.raises(InputError, match=r"must be Machine.*'1\.0'.*got Machine") as told:
        run(other, tmp_path, OwnProcess(), lambda told: None)
    assert "\n" not in str(told.value) and not list(tmp_path.iterdir())


@pytest.mark.slow
def test_a_dask_cluster_ends_with_the_same_figures(
    whole: tuple[Pieces, list[StudyProgress]], tmp_path: Path
) -> None:
    pytest.importorskip("distributed")
    with Cluster(tmp_path) as cluster, cluster_workers(cluster.address) as workers:
        pieces = run(small_study(), tmp_path / "pieces", workers, lambda told: None)
    assert figures(pieces) == figures(whole[0])


def test_cancelled_it_keeps_what_is_done_and_leaves_no_process(tmp_path: Path) -> None:
    def enough(told: StudyProgress) -> None:
        if told.done >= 2:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        with_processes(small_study(), tmp_path, 2, enough)
    assert len([path for path in tmp_path.iterdir() if path.name.startswith("sweeps")]) >= 2
    assert not multiprocessing.active_children()
    assert not [path for path in tmp_path.iterdir() if path.name.startswith("found")]


def test_a_net_for_each_rig(tmp_path: Path) -> None:
    own = replace(small_study(), protocol=replace(PROTOCOL, mode="per-rig", seeds=1))
    pieces = with_processes(own, tmp_path, 2)
    every, hit = assemble(pieces, 1)
    assert every.value.shape == hit.value.shape == (2, 4)
    assert np.isfinite(every.value).all() and (hit.value >= every.value - 1e-9).all()


def test_cameras_tell_the_net_of_points(tmp_path: Path) -> None:
    eye = Camera(name="CAM", position=(0.0, 0.0, 2.0), hfov_deg=110.0, image=(320, 180), cast=(80, 45))
    seeing = rig("a").model_copy(update={"sensors": (*rig("a").sensors, eye)})
    rigs = entrants([seeing, rig("b")], "lidars and cameras")
    protocol = replace(PROTOCOL, mode="shared", seeds=1, epochs=1, cameras="good")
    asked = Study(rigs, protocol, traffic(), machine("cpu"))
    pieces = with_processes(asked, tmp_path, 2)
    one, other = (samples_of(pieces.of(Job(None, entrant)), "test") for entrant in rigs)
    assert one.features.shape[1] == other.features.shape[1] == FEATURES + SCORES
    assert (one.cell == other.cell).all() and (
        one.features[:, :FEATURES] == other.features[:, :FEATURES]
    ).all()
    assert one.features[:, FEATURES + 1 :].any() and not other.features[:, FEATURES:].any()
    assert np.isfinite(assemble(pieces, 1)[0].value).all()


def test_range_images_of_several_sweeps(tmp_path: Path) -> None:
    still = traffic()
    motion = Motion(np.zeros((still.frames, 2)), np.zeros(still.frames), np.ones((len(still.cls), 2)))
    protocol = replace(PROTOCOL, seeds=1, epochs=1, sweeps=2, detector="range")
    asked = Study(entrants([rig("a")]), protocol, still, machine("cpu"), motion)
    other = replace(motion, boxes_m_s=2.0 * motion.boxes_m_s)
    assert asked.sweeps_key(asked.compared[0]) != replace(asked, motion=other).sweeps_key(asked.compared[0])
    found = assemble(with_processes(asked, tmp_path, 1), 1)[0]
    assert np.isfinite(found.value).all()


def test_seeds_count_once_every_rig_is_judged(
    whole: tuple[Pieces, list[StudyProgress]], tmp_path: Path
) -> None:
    pieces, _ = whole
    half = tmp_path / "half"
    half.mkdir()
    for path in pieces.folder.iterdir():
        if not path.name.startswith(("found-1", "net-1")):
            (half / path.name).write_bytes(path.read_bytes())
    assert finished_seeds(Pieces(pieces.study, half)) == 1
    assert assemble(Pieces(pieces.study, half), 1)[0].by_seed == pytest.approx(
        assemble(pieces, 2)[0].by_seed[:, :1]
    )


def marked(mark: str) -> list[str]:
    """Processes whose environment holds the mark."""
    found = []
    for folder in Path("/proc").glob("[0-9]*"):
        try:
            if f"RIGLENS_TEST_MARK={mark}".encode() in (folder / "environ").read_bytes():
                found.append(folder.name)
        except OSError:
            continue
    return found
