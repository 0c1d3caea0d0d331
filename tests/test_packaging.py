"""Wheel, source archive and checkout work where users put them: without symbolic links, on paths with spaces, beside
packages of the same names."""

from __future__ import annotations

import json
import shutil
import subprocess
import sys
import tarfile
import zipfile
from pathlib import Path

import pytest

import riglens as rl
from tests.environment import Environment
from tests.waiting import TIMEOUT_S

REPOSITORY = Path(__file__).resolve().parents[1]
ROOMS = ("app", "assets", "core", "widgets")
FOLDERS = (*ROOMS, "riglens", "docs")
FILES = ("CHANGELOG.md", "LICENSE", "README.md", "pyproject.toml")
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
    print(json.dumps(found))


if __name__ == "__main__":
    main()
"""
WHERE = """
import importlib.util
import riglens as rl
import riglens.core.errors

assert "W+T" in rl.presets()
assert importlib.util.find_spec("riglens.riglens") is None
print(riglens.core.errors.__file__, riglens.assets.asset_path("library.yaml").is_file())
"""


def build(kind: str, source: Path, target: Path) -> Path:
    """The archive of a kind ("sdist" or "wheel") that is built from a source folder."""
    command = [sys.executable, "-m", "hatchling", "build", "-t", kind, "-d", str(target)]
    subprocess.run(command, cwd=source, check=True, capture_output=True, timeout=TIMEOUT_S)
    (built,) = target.iterdir()
    return built


def files_in(*folders: str) -> set[str]:
    """What belongs into an archive from folders of the repository, relative to it."""
    found = [path for folder in folders for path in (REPOSITORY / folder).rglob("*") if path.is_file()]
    names = {path.relative_to(REPOSITORY).as_posix() for path in found if "__pycache__" not in path.parts}
    return {name for name in names if not name.startswith(tuple(f"riglens/{room}" for room in ROOMS))}


@pytest.fixture(scope="module")
def checkout(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A checkout as `git clone -c core.symlinks=false` makes it: each link is a text file that holds its target."""
    folder = tmp_path_factory.mktemp("check out")
    for name in FOLDERS:
        links = ROOMS if name == "riglens" else ()
        shutil.copytree(
            REPOSITORY / name, folder / name, ignore=shutil.ignore_patterns("__pycache__", *links)
        )
    for name in FILES:
        shutil.copy(REPOSITORY / name, folder)
    for room in ROOMS:
        (folder / "riglens" / room).write_text(f"../{room}", encoding="utf-8")
    return folder


@pytest.fixture(scope="module")
def sdist(checkout: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The source archive, built from the checkout without links."""
    return build("sdist", checkout, tmp_path_factory.mktemp("sdist"))


@pytest.fixture(scope="module")
def unpacked(sdist: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The folder of the unpacked source archive, behind a path with spaces."""
    folder = tmp_path_factory.mktemp("un packed")
    with tarfile.open(sdist) as files:
        files.extractall(folder, filter="data")
    (unpacked,) = folder.iterdir()
    return unpacked


@pytest.fixture(scope="module")
def wheel(unpacked: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The wheel, built from the source archive."""
    return build("wheel", unpacked, tmp_path_factory.mktemp("wheel"))


@pytest.fixture(scope="module")
def installed(wheel: Path, tmp_path_factory: pytest.TempPathFactory) -> Environment:
    """An environment with the wheel, behind a path with spaces."""
    environment = Environment(tmp_path_factory.mktemp("some one's") / "the environment")
    environment.install(wheel)
    return environment


@pytest.fixture(scope="module")
def project(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A project with its own core, app, widgets and assets."""
    project = tmp_path_factory.mktemp("the project")
    for room in ROOMS:
        (project / room).mkdir()
        (project / room / "__init__.py").write_text(
            f"OWNER = 'the {room} of somebody else'\n", encoding="utf-8"
        )
    (project / "core" / "work.py").write_text(WORK, encoding="utf-8")
    (project / "use.py").write_text(USE, encoding="utf-8")
    return project


def test_the_source_archive_holds_every_file_once(sdist: Path) -> None:
    with tarfile.open(sdist) as files:
        names = [file.name.partition("/")[2] for file in files.getmembers() if file.isfile()]
    assert sorted({*names} - {"PKG-INFO", ".gitignore"}) == sorted({*files_in(*FOLDERS), *FILES})


def test_the_wheel_holds_riglens_and_nothing_else(wheel: Path) -> None:
    names = set(zipfile.ZipFile(wheel).namelist())
    assert {name.partition("/")[0] for name in names} == {"riglens", f"riglens-{rl.__version__}.dist-info"}
    within = {name.partition("/")[2] for name in names if name.startswith("riglens/")}
    own = {name.removeprefix("riglens/") for name in files_in("riglens")}
    assert {name for name in within if not name.startswith("docs/")} == files_in(*ROOMS) | own
    assert "docs/first-five-minutes.md" in within


def test_a_checkout_with_links_makes_the_same_wheel(wheel: Path, tmp_path: Path) -> None:
    linked = zipfile.ZipFile(build("wheel", REPOSITORY, tmp_path))
    assert {file.filename: file.CRC for file in linked.infolist()} == {
        file.filename: file.CRC for file in zipfile.ZipFile(wheel).infolist()
    }


@pytest.mark.parametrize("source", ["checkout", "unpacked"])
def test_sources_without_links_run_in_place(
    source: str, request: pytest.FixtureRequest, tmp_path: Path
) -> None:
    folder = request.getfixturevalue(source)
    environment = Environment(tmp_path / "environment")
    for package in ("riglens", "app"):
        assert "W+T" in environment.run("python", "-m", package, "list", "rigs", cwd=folder)
    environment.install("--editable", folder)
    assert "W+T" in environment.run("riglens", "list", "rigs")
    assert environment.run("python", "-c", WHERE).strip() == f"{folder / 'core' / 'errors.py'} True"


def test_the_wheel_runs_in_an_empty_environment(installed: Environment) -> None:
    assert "W+T" in installed.run("riglens", "list", "rigs")
    package = installed.site / "riglens"
    assert installed.run("python", "-c", WHERE).strip() == f"{package / 'core' / 'errors.py'} True"


@pytest.mark.slow
def test_it_works_beside_packages_of_the_same_names(installed: Environment, project: Path, xvfb: str) -> None:
    found = json.loads(installed.run("python", "use.py", cwd=project))
    assert found["own"] == [f"the {room} of somebody else" for room in ROOMS]
    package = installed.site / "riglens"
    assert [Path(found[room]) for room in ROOMS] == [package / room for room in ROOMS]
    scene = rl.load_scene(voxel_m=0.5, roi_m=(20, 20, 4))
    expected = [str(package / "__init__.py"), rl.score(rl.open_rig("W+T"), scene)["car"].seen]
    assert [found["here"], found["process"], found["dask"]] == [expected] * 3
    assert (project / "picture.png").read_bytes().startswith(b"\x89PNG")


@pytest.mark.slow
def test_commands_with_processes_work_there(installed: Environment, project: Path) -> None:
    for number in range(2):
        (project / f"{number}.csv").write_text(
            f"seq,frame,cls,x,y,z,length,width,height,yaw\ns,{number},car,6,{number},0.8,4.5,1.9,1.6,0.3\n",
            encoding="utf-8",
        )
    grid = ("--voxel", "0.5", "--roi", "20", "20", "4")
    words = ("data", "build", "0.csv", "1.csv", "--out", "cars.npz", *grid, "--workers", "2")
    assert "2 frames" in installed.run("python", "-m", "riglens", *words, cwd=project)
    words = ("evaluate", "W+T", "--pog", "cars.npz", "--json", "-")
    assert '"name": "W+T"' in installed.run("python", "-m", "riglens", *words, cwd=project)
