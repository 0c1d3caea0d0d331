"""Broken input of every kind, as many as one likes: `make fuzz`, or `python -m tests.fuzz --count 1000000`.

Each target breaks something valid and hands it in: rigs of all formats, box data, POGs, meshes, caches, autosave,
clipboard, command line. What comes out must be a result or an InputError of one printable line, within LONGEST_S and
without a warning; anything else is a crash, whose input is kept in a folder. Each crash that is found becomes a test
of its own.
"""

from __future__ import annotations

import argparse
import contextlib
import io
import os
import random
import re
import signal
import sys
import tempfile
import time
import traceback
import warnings
from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from riglens.app.session import autosave
from riglens.assets import asset_path
from riglens.core.cache_folder import cache_folder
from riglens.core.errors import InputError
from riglens.core.formats.exchange import FORMATS, read_rig, writable
from riglens.core.kernels.runtime.compiled import KernelFolder
from riglens.core.rig import library
from riglens.core.rig.model import Rig
from riglens.core.rig.pose_text import parse_pose
from riglens.core.rig.presets import preset
from riglens.core.rig.yaml.file import dumps, loads, same_rig
from riglens.core.scene.grid import VoxelGrid
from riglens.core.scene.pog import build_pog
from riglens.core.scene.pog_store import load_pog, save_pog
from riglens.core.scene.readers import open_boxes
from riglens.core.scene.readers.occluders import open_occluders
from riglens.core.vehicle.mesh_parse import MAX_MEMORY_BYTES, parse_mesh
from tests.broken import mutated
from tests.core.formats.cases import SMALL, write_files
from tests.core.formats.test_xacro import CALIBRATION, CAR, KIT, MACROS
from tests.core.sound_boxes import SOURCES, csv_file
from tests.core.test_occluders import OCCLUDERS
from tests.core.test_occluders import POSES as POSES_OF_FRAMES

LONGEST_S, LONGEST_WAIT_S = 20, 600
"""Of the processor, far above the limits of every reader, and by the clock, where something waits for ever."""
LONGEST_LINE = 500
ROUNDS = 20
"""Of the targets, one of which slow ones take part in."""
Attempt = Callable[[random.Random], None]


@dataclass(frozen=True)
class Target:
    """Something that takes input: `attempt` hands broken input in; `files` are those that it breaks. A line that
    refuses them has one of the `names`. A slow one takes as long as twenty others."""

    name: str
    attempt: Attempt
    files: tuple[Path, ...] = ()
    names: tuple[str, ...] = ("",)
    is_slow: bool = False

    def is_told_by(self, line: str) -> bool:
        """Return whether a line names what is wrong."""
        return (
            bool(line)
            and line.isprintable()
            and len(line) <= LONGEST_LINE
            and any(name in line for name in self.names)
        )


@dataclass(frozen=True)
class Crash:
    """What came out in place of a result or a line, and the input as (name, content)."""

    target: str
    number: int
    what: str
    inputs: tuple[tuple[str, bytes], ...]


# ---------------------------------------------------------------- targets


def targets(folder: Path) -> list[Target]:
    """All targets; their files are made in a folder of the fuzzer's own."""
    made = [
        *_formats(folder / "rigs"),
        _xacro(folder / "xacro"),
        *_boxes(folder / "boxes"),
        *_meshes(folder / "meshes"),
    ]
    return [
        *made,
        _pog(folder / "pog"),
        _occluders(folder / "occluders"),
        *_caches(folder / "caches"),
        *_reviews(folder / "reviews"),
        *_texts(),
        _autosave(folder / "autosave"),
    ]


def _of_files(
    name: str,
    read: Callable[[random.Random], object],
    *files: Path,
    opened: Path | None = None,
    is_slow: bool = False,
) -> Target:
    """Breaks one of some files at a time, reads, and puts the file in order again.

    With `opened`, the file or folder that is opened, a line has to name it, a file or its folder.
    """
    names = (
        ("",)
        if opened is None
        else (opened.name, *(one for file in files for one in (file.name, file.parent.name)))
    )
    sound = {file: file.read_bytes() for file in files}

    def attempt(chance: random.Random) -> None:
        file = chance.choice(files)
        file.write_bytes(mutated(sound[file], chance))
        read(chance)
        file.write_bytes(sound[file])

    return Target(name, attempt, files, names, is_slow)


def _formats(folder: Path) -> Iterator[Target]:
    cases = {**SMALL, "riglens": {"rig.yaml": dumps(preset("W+T"))}}
    for case, files in cases.items():
        place = write_files(folder / case, files)
        path = place / next(iter(files)) if len(files) == 1 else place
        paths = [place / name for name in files]

        def read(chance: random.Random, path: Path = path, name: str = case.removesuffix("-raw")) -> None:
            rig = read_rig(path, chance.choice((name, None))).rig
            assert same_rig(loads(dumps(rig)).rig, rig)
            if chance.random() < 0.1:
                _write(rig)

        yield _of_files(f"rig {case}", read, *paths, opened=path)


def _write(rig: Rig) -> None:
    """Write a rig in every format; one without sensors may be refused."""
    for name in writable():
        try:
            FORMATS[name].write(rig)
        except InputError as error:
            assert "no enabled sensor to write" in str(error)


XACRO = {"car.xacro": CAR, "macros.xacro": MACROS, "kit.xacro": KIT, "kit.yaml": CALIBRATION}
WORDS_OF_XACRO = """p at x height calibration pi math. xacro. $(eval) ' a 1 -2.5 1e12 9999999 'x' float('nan')
lambda: **p [ ] ( ) { } , : . = dict( len( load_yaml('kit.yaml') sqrt( min( ['base_link'] ['velodyne_top'] .rpy [0]
[1:] + - * / // % ** == < != >= \\ __class__"""
TOKENS = (
    *WORDS_OF_XACRO.split(),
    " in ",
    " not in ",
    " if ",
    " else ",
    " and ",
    " or ",
    " not ",
    "$(arg prefix)",
)


def _xacro(folder: Path) -> Target:
    """Break a file, or put an expression of random words in the place of one."""
    place = write_files(folder, XACRO)
    files = tuple(place / name for name in XACRO)

    def attempt(chance: random.Random) -> None:
        file = chance.choice(files)
        content = file.read_bytes()
        if chance.random() < 0.5:
            content = mutated(content, chance)
        for _ in range(chance.randint(0, 2)):
            words = "".join(chance.choices(TOKENS, k=chance.randint(1, 12)))
            expressions = re.findall(rb"\$\{[^}]*\}", content) or [b"lidar"]
            content = content.replace(chance.choice(expressions), f"${{{words}}}".encode(), 1)
        file.write_bytes(content)
        read_rig(chance.choice(files[::2]))

    return Target("rig xacro", attempt, files, is_slow=True)


def _boxes(folder: Path) -> Iterator[Target]:
    for source in SOURCES:
        place = folder / source.__name__
        place.mkdir(parents=True)
        sound = source(place)

        yield _of_files(
            f"boxes {source.__name__}",
            lambda _, path=sound.path: _read_boxes(path),  # type: ignore[misc]
            *sound.files,
            opened=sound.path,
        )


def _read_boxes(path: Path) -> None:
    """Read box data, which have to be boxes if they are not refused."""
    source = open_boxes(path)
    for batch in source.batches():
        assert np.isfinite(batch.centre_m).all() and np.isfinite(batch.rotation).all()
        assert (batch.size_m > 0).all() and (np.diff(batch.frame) >= 0).all()
    assert source.report().frames > 0 and len(source.content_hash) == 64


def _occluders(folder: Path) -> Target:
    folder.mkdir(parents=True)
    table, poses = folder / "occluders.csv", folder / "poses.csv"
    table.write_text(OCCLUDERS, encoding="utf-8")
    poses.write_text(POSES_OF_FRAMES, encoding="utf-8")
    return _of_files("occluders", lambda _: open_occluders(table, poses).around(("a", 0), 1e9), table, poses)


def _pog(folder: Path) -> Target:
    folder.mkdir(parents=True)
    path = folder / "a.npz"
    save_pog(build_pog(open_boxes(csv_file(folder).path), VoxelGrid(1.0, (20.0, 20.0, 4.0))), path)
    return _of_files("POG", lambda _: load_pog(path), path, opened=path)


def _meshes(folder: Path) -> Iterator[Target]:
    import trimesh  # the reader of meshes brings it

    folder.mkdir(parents=True)
    for ending in ("glb", "obj", "ply", "stl"):
        path = folder / f"a.{ending}"
        trimesh.creation.box((4.0, 2.0, 1.5)).export(path)
        yield _of_files(
            f"mesh {ending}",
            lambda _, path=path: parse_mesh(path),  # type: ignore[misc]
            path,
            is_slow=ending == "glb",
        )


LIBRARY = """made-up-16:
  kind: lidar
  title: Made up 16
  maker: Nobody
  source: words of a test, which are made up
  elevations_deg: {from: -15, to: 15, count: 16}
  range_m: [0.5, 100]
"""


def _caches(folder: Path) -> Iterator[Target]:
    own = folder / "library.yaml"
    folder.mkdir(parents=True)
    own.write_text(LIBRARY, encoding="utf-8")
    kept = cache_folder() / library.NAME
    bundled = asset_path("library.yaml")
    library.stored_entries(bundled)
    yield _of_files("cache of the library", lambda _: library.stored_entries(bundled), kept, is_slow=True)
    yield _of_files("library of the user", lambda _: library.read_entries(own, own.name), own)
    kernels = KernelFolder()
    kernels.write("fuzz.nbc", b"machine code" * 20)
    if kernels.path is not None:
        yield _of_files("cache of a kernel", lambda _: kernels.read("fuzz.nbc"), kernels.path / "fuzz.nbc")


REQUIRED = """riglens_requirements: 1
settings: {body: blocks, voxel_m: 0.5, roi_m: [60, 40, 4], frames: 3, seed: 1}
seen: [{class: car, by: any, at_least: 0.5, id: R1, waived: {reason: later, until: 2027-05-31}}]
on_target: [{class: pedestrian, ring_m: [0, 20], figure: share_5, at_least: 0.9}]
blind_areas: [{height_m: 0.8, sector: rear, within_m: 5, under: own, at_most_m2: 1.0}]
losses: [{of: voxels, class: car, failure: group, name: bracket, at_most: 0.3}]
covered: [{of: objects, class: car, sensors: two kinds, at_least: 0.3}]
tolerance: [{profile: own, class: car, limit: 0.49, draws: 64}]
tolerance_profiles: [{name: own, source: a test, position_mm: 2, angle_deg: 0.05}]
mounts: {height_m: [0.3, 2.2], beyond_m: {top: 0.4}, keep_out: [{name: hood, boxes: [{x: [0.75, 1.0]}]}]}
"""
PAGE = (
    '<html><script type="application/json" id="figures">{"riglens_report":1,"inputs":{"rigs":["riglens: 1"],'
    '"voxel_m":0.1,"roi_m":[60.0,40.0,4.0],"method":"exact","reading":"covered","lambda":0.1,"body":"blocks","draws":2,"seed":0,'
    '"boxes":null,"requirements":null}}</script></html>'
)


def _reviews(folder: Path) -> Iterator[Target]:
    from riglens.core.blind.outline import Outline
    from riglens.core.review.profiles import read_profiles, targets_of
    from riglens.core.review.requirements import read_requirements
    from riglens.reporting.reading import attached_figures, inputs_of

    folder.mkdir(parents=True)
    profiles, required, page = (folder / name for name in ("blind.yaml", "required.yaml", "report.html"))
    profiles.write_bytes(asset_path("review", "blind.yaml").read_bytes())
    required.write_text(REQUIRED, encoding="utf-8")
    page.write_text(PAGE, encoding="utf-8")

    def place_all(_: object) -> None:
        for profile in read_profiles(profiles):
            targets_of(profile, Outline(-2.3, 2.3, -0.9, 0.9))

    def look_into(_: object) -> None:
        inputs_of(attached_figures(page.read_bytes(), page.name), page.name)

    yield _of_files("blind zone profiles", place_all, profiles)
    yield _of_files("requirements", lambda _: read_requirements(required), required)
    yield _of_files("report", look_into, page)


def _autosave(folder: Path) -> Target:
    folder.mkdir(parents=True)
    rig = preset("W+T")
    autosave.AutosaveFile(folder).write(autosave.Unsaved(rig, rig, None))
    (path,) = folder.glob(f"*{autosave.SUFFIX}")
    return _of_files("autosave", lambda _: autosave.orphans(folder), path, is_slow=True)


POSES = (
    "1 2 3 0 0 90",
    "x: 1, y: 2, z: 3, roll: 0, pitch: 0, yaw: 90",
    "[1, 0, 0, 1, 0, 1, 0, 2, 0, 0, 1, 3, 0, 0, 0, 1]",
)
WORDS = (
    *(
        "evaluate",
        "build",
        "data",
        "review",
        "render",
        "list",
        "rigs",
        "convert",
        "sensors",
        "study",
        "table1",
        "W+T",
        "nosuch.csv",
    ),
    *(
        "--boxes",
        "--voxel",
        "--roi",
        "--frames",
        "--lambda",
        "--threads",
        "--origin",
        "--classes",
        "--ground",
        "auto",
    ),
    *(
        "--pog",
        "--out",
        "--json",
        "--to",
        "--from",
        "--help",
        "--reading",
        "hits",
        "0.5",
        "1e309",
        "nan",
        "-1",
        "--",
    ),
    *(
        "car=bus",
        "\x1b[2J",
        "=1",
        "a" * 300,
        "../x",
        "9" * 50,
        "",
        "-",
        "--frames=0",
        "/dev/fd/99",
        "~nobody/x",
    ),
)


def _texts() -> Iterator[Target]:
    from riglens.app.window.features.edits import sensors_in

    copied = dumps(preset("W+T")).encode()

    def paste(chance: random.Random) -> None:
        sensors_in(mutated(copied, chance).decode("utf-8", "replace"))

    def paste_pose(chance: random.Random) -> None:
        parse_pose(mutated(chance.choice(POSES).encode(), chance).decode("utf-8", "replace"))

    yield Target("clipboard: sensors", paste)
    yield Target("clipboard: a pose", paste_pose)
    yield Target("command line", _command, is_slow=True)


def _command(chance: random.Random) -> None:
    """Random words; nothing that they say can be found, so that no work begins."""
    from riglens.app.commands import main

    words = [chance.choice(WORDS) for _ in range(chance.randint(2, 7))]
    said = io.StringIO()
    with contextlib.redirect_stderr(said), contextlib.redirect_stdout(io.StringIO()):
        code = main([*words, "--nosuch"])
    lines = said.getvalue().splitlines()
    if code == 2 and len(lines) == 1:
        raise InputError(lines[0])
    if code != 0 or "Traceback" in said.getvalue():
        raise AssertionError(f"{words} gave code {code} and {said.getvalue()[:300]!r}")


# ---------------------------------------------------------------- running


def outcome(target: Target, chance: random.Random) -> str:
    """Hand one broken input in; "read", "refused", or what is wrong."""
    try:
        with warnings.catch_warnings(action="error"), _time_limit():
            target.attempt(chance)
    except InputError as error:
        line = str(error)
        return "refused" if target.is_told_by(line) else f"said {line[:300]!r}"
    except BaseException as error:
        if isinstance(error, KeyboardInterrupt):
            raise
        return "".join(traceback.format_exception(error)[-4:])
    return "read"


@contextmanager
def _time_limit() -> Iterator[None]:
    """Raise TimeoutError in a block that takes too long, where the system has alarms."""

    def end(number: int, frame: object) -> None:
        raise TimeoutError(f"took more than {LONGEST_S} s of the processor or {LONGEST_WAIT_S} s")

    if not hasattr(signal, "SIGPROF"):
        yield
        return
    before = {number: signal.signal(number, end) for number in (signal.SIGALRM, signal.SIGPROF)}
    signal.alarm(LONGEST_WAIT_S)
    signal.setitimer(signal.ITIMER_PROF, LONGEST_S)
    try:
        yield
    finally:
        signal.alarm(0)
        signal.setitimer(signal.ITIMER_PROF, 0.0)
        for number, handler in before.items():
            signal.signal(number, handler)


def turns(every: Sequence[Target]) -> list[Target]:
    """Return ROUNDS rounds of the targets, slow ones in the first alone."""
    return [target for number in range(ROUNDS) for target in every if number == 0 or not target.is_slow]


def run(
    count: int, seed: int, seconds: float = float("inf"), only: str = ""
) -> tuple[Counter[str], list[Crash]]:
    """Hand inputs to the targets with `only` in their names, in turn; what came out by target, and the crashes."""
    found, crashes, ends_s = Counter[str](), list[Crash](), time.monotonic() + seconds
    with tempfile.TemporaryDirectory(prefix="riglens-fuzz-") as folder, _own_cache(Path(folder) / "cache"):
        every = turns([target for target in targets(Path(folder)) if only in target.name])
        sound = {file: file.read_bytes() for target in every for file in target.files}
        with contextlib.suppress(KeyboardInterrupt):  # told with what there is by then
            for number in range(count):
                if time.monotonic() > ends_s:
                    break
                target, chance = every[number % len(every)], random.Random(f"{seed} {number}")
                said = outcome(target, chance)
                if said not in ("read", "refused"):
                    inputs = tuple((file.name, file.read_bytes()) for file in target.files)
                    crashes.append(Crash(target.name, number, said, inputs))
                found[f"{target.name}: {said if said in ('read', 'refused') else 'CRASH'}"] += 1
                for file in target.files:
                    if not file.exists() or file.read_bytes() != sound[file]:
                        file.write_bytes(sound[file])
    return found, crashes


@contextmanager
def _own_cache(folder: Path) -> Iterator[None]:
    before = {name: os.environ.get(name) for name in ("RIGLENS_CACHE_DIR", "NUMBA_CACHE_DIR")}
    os.environ["RIGLENS_CACHE_DIR"] = str(folder)
    try:
        yield
    finally:
        for name, value in before.items():
            os.environ.pop(name, None) if value is None else os.environ.update({name: value})


def main() -> int:
    """Fuzz as the command line says; exit code 1 when something crashed."""
    words = argparse.ArgumentParser(prog="python -m tests.fuzz", description=__doc__)
    words.add_argument("--count", type=int, default=100_000)
    words.add_argument("--seed", type=int, default=1)
    words.add_argument("--seconds", type=float, default=float("inf"))
    words.add_argument("--only", default="", help="targets whose names hold this text")
    words.add_argument("--keep", type=Path, default=Path("out/fuzz"), help="where inputs that crash are kept")
    said = words.parse_args()
    if sys.platform != "win32":
        import resource

        resource.setrlimit(resource.RLIMIT_AS, (MAX_MEMORY_BYTES, MAX_MEMORY_BYTES))
    signal.signal(signal.SIGTERM, signal.default_int_handler)
    found, crashes = run(said.count, said.seed, said.seconds, said.only)
    for line, times in sorted(found.items()):
        print(f"{times:9,}  {line}")
    print(f"{found.total():9,}  inputs, {len(crashes)} crashes")
    for crash in crashes:
        place = said.keep / f"{said.seed}-{crash.number}"
        place.mkdir(parents=True, exist_ok=True)
        for name, content in crash.inputs:
            (place / name).write_bytes(content)
        print(f"\n{crash.target}, input {crash.number}, kept in {place}:\n{crash.what}", file=sys.stderr)
    return 1 if crashes else 0


if __name__ == "__main__":
    sys.exit(main())
