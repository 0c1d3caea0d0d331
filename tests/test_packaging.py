"""Wheel and source archive work where strangers put them: beside packages of the same names, on paths with spaces."""

from __future__ import annotations

import json
import os
import subprocess
import sys
import sysconfig
import tarfile
import zipfile
from pathlib import Path
from typing import NamedTuple

import pytest

import riglens as rl
from tests.waiting import TIMEOUT_S

pytestmark = pytest.mark.slow

REPOSITORY = Path(__file__).resolve().parents[1]
ROOMS = ("app", "assets", "core", "widgets")
WORK = """
def seen(name):
    import riglens as rl

    scene = rl.load_scene(voxel_m=0.5, roi_m=(20, 20, 4))
    return rl.__file__, rl.score(rl.open_rig(name), scene)["car"].seen
"""
USE = """
import importlib
import json
import multiprocessing
import sys
from concurrent.futures import ProcessPoolExecutor

import app, assets, core, widgets
import riglens as rl
from core.work import seen


def main():
    found = {"own": [room.OWNER for room in (app, assets, core, widgets)], "here": seen("W+T")}
    for room in ("app", "assets", "core", "widgets"):
        found[room] = importlib.import_module(f"riglens.{room}").__path__[0]
    with ProcessPoolExecutor(1, multiprocessing.get_context("spawn")) as pool:
        found["process"] = pool.submit(seen, "W+T").result()
    from distributed import Client, LocalCluster

    with LocalCluster(1, threads_per_worker=1, dashboard_address=None) as cluster, Client(cluster) as client:
        found["dask"] = client.submit(seen, "W+T").result()
    scene = rl.load_scene(voxel_m=0.5, roi_m=(20, 20, 4))
    rl.render(rl.open_rig("W+T"), scene, "picture.png", size_px=(320, 200))
    found["top"] = sorted({name.partition(".")[0] for name in sys.modules} & {"riglens", *ROOMS})
    print(json.dumps(found))


ROOMS = ("app", "assets", "core", "widgets")
if __name__ == "__main__":
    main()
"""


class Stranger(NamedTuple):
    """A project with packages of its own that are called like RigLens' folders, and where RigLens is installed."""

    project: Path
    site: Path

    def run(self, *words: str) -> str:
        """Standard output of Python in the project, where RigLens comes from the installed wheel alone."""
        paths = (self.project, self.site, sysconfig.get_path("purelib"))
        environment = {**os.environ, "PYTHONPATH": os.pathsep.join(map(str, paths))}
        # -S: the .pth file of the checkout's editable install is not read
        command = [sys.executable, "-S", *words]
        done = subprocess.run(
            command, cwd=self.project, env=environment, capture_output=True, text=True, timeout=600
        )
        assert done.returncode == 0, done.stderr
        return done.stdout


def build(kind: str, source: Path, target: Path) -> Path:
    """The archive of a kind ("sdist" or "wheel") that is built from a source folder."""
    command = [sys.executable, "-m", "hatchling", "build", "-t", kind, "-d", str(target)]
    subprocess.run(command, cwd=source, check=True, capture_output=True, timeout=TIMEOUT_S)
    (built,) = target.iterdir()
    return built


@pytest.fixture(scope="module")
def checkout(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The source archive, unpacked behind a path with spaces."""
    archive = build("sdist", REPOSITORY, tmp_path_factory.mktemp("sdist"))
    folder = tmp_path_factory.mktemp("check out")
    with tarfile.open(archive) as files:
        files.extractall(folder, filter="data")
    (checkout,) = folder.iterdir()
    return checkout


@pytest.fixture(scope="module")
def wheel(checkout: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The wheel, built from the source archive."""
    return build("wheel", checkout, tmp_path_factory.mktemp("wheel"))


@pytest.fixture(scope="module")
def stranger(wheel: Path, tmp_path_factory: pytest.TempPathFactory) -> Stranger:
    """A project with its own core, app, widgets and assets, and the wheel behind a path with spaces."""
    folder = tmp_path_factory.mktemp("some one's")
    project, site = folder / "the project", folder / "site packages"
    for room in ROOMS:
        (project / room).mkdir(parents=True)
        (project / room / "__init__.py").write_text(f"OWNER = 'the {room} of somebody else'\n")
    (project / "core" / "work.py").write_text(WORK)
    (project / "use.py").write_text(USE)
    words = ("install", "--no-deps", "--no-index", "--quiet", "--target", str(site), str(wheel))
    subprocess.run([sys.executable, "-m", "pip", *words], check=True, timeout=TIMEOUT_S)
    return Stranger(project, site)


def test_the_wheel_holds_riglens_and_nothing_else(wheel: Path, stranger: Stranger) -> None:
    names = zipfile.ZipFile(wheel).namelist()
    assert {name.partition("/")[0] for name in names} == {"riglens", f"riglens-{rl.__version__}.dist-info"}
    assert {"riglens/py.typed", "riglens/api.py", "riglens/core/kernels/runtime/jit.py"} <= set(names)
    templates = {path.name for path in (REPOSITORY / "riglens" / "reporting" / "templates").iterdir()}
    assert {f"riglens/reporting/templates/{name}" for name in templates} <= set(names) and len(templates) > 5
    own = {path.name for path in stranger.site.iterdir()}
    assert own == {"riglens", f"riglens-{rl.__version__}.dist-info", "bin"}
    assert [path.name for path in (stranger.site / "bin").iterdir()] == ["riglens"]


def test_it_works_beside_packages_of_the_same_names(stranger: Stranger, xvfb: str) -> None:
    found = json.loads(stranger.run("use.py"))
    assert found["own"] == [f"the {room} of somebody else" for room in ROOMS]
    package = stranger.site / "riglens"
    assert [Path(found[room]) for room in ROOMS] == [package / room for room in ROOMS]
    scene = rl.load_scene(voxel_m=0.5, roi_m=(20, 20, 4))
    expected = [str(package / "__init__.py"), rl.score(rl.open_rig("W+T"), scene)["car"].seen]
    assert [found["here"], found["process"], found["dask"]] == [expected] * 3
    assert (stranger.project / "picture.png").read_bytes().startswith(b"\x89PNG")


def test_the_command_line_works_there(stranger: Stranger) -> None:
    assert stranger.run("-m", "riglens", "--version").strip() == rl.__version__
    for number in range(2):
        (stranger.project / f"{number}.csv").write_text(
            f"seq,frame,cls,x,y,z,length,width,height,yaw\ns,{number},car,6,{number},0.8,4.5,1.9,1.6,0.3\n"
        )
    grid = ("--voxel", "0.5", "--roi", "20", "20", "4")
    words = ("-m", "riglens", "pog", "0.csv", "1.csv", "--out", "cars.npz", *grid, "--workers", "2")
    assert "2 frames" in stranger.run(*words)
    assert '"name": "W+T"' in stranger.run(
        "-m", "riglens", "evaluate", "W+T", "--pog", "cars.npz", "--json", "-"
    )


def test_the_source_archive_runs_where_it_is_unpacked(checkout: Path) -> None:
    environment = {**os.environ, "PYTHONPATH": sysconfig.get_path("purelib")}
    code = "import riglens.core.errors as found; print(found.__file__)"
    for words in (("-m", "riglens", "--help"), ("-m", "riglens", "presets"), ("-c", code)):
        command = [sys.executable, "-S", *words]
        done = subprocess.run(
            command, cwd=checkout, env=environment, capture_output=True, text=True, timeout=TIMEOUT_S
        )
        assert done.returncode == 0, done.stderr
    assert Path(done.stdout.strip()) == checkout / "riglens" / "core" / "errors.py"
