"""Whatever a file turns into, a reader reads a rig or refuses in one line: no traceback, no hang."""

import random
import zlib
from pathlib import Path

import pytest

from riglens.core.errors import InputError
from riglens.core.formats.exchange import FORMATS, WRITABLE, read_rig
from riglens.core.rig.presets import preset
from riglens.core.rig.yaml.file import dumps, loads, same_rig
from tests.core.formats.cases import SMALL, write_files
from tests.core.formats.mutations import mutated

QUICK, LONG = 60, 10_000
CASES = {**SMALL, "riglens": {"rig.yaml": dumps(preset("W+T"))}}


def check(path: Path, name: str | None, wants_all: bool) -> bool:
    """Read the file; whether there was a rig in it, which then survives every way out."""
    try:
        rig = read_rig(path, name).rig
    except InputError as error:
        message = str(error)
        assert message and message.isprintable() and len(message) < 2000, repr(message)
        return False
    assert same_rig(loads(dumps(rig)).rig, rig)
    for target in WRITABLE if wants_all else ():
        write = FORMATS[target].write
        assert write is not None
        try:
            write(rig)
        except InputError as error:
            assert "no enabled sensor to write" in str(error)
    return True


def fuzz(case: str, folder: Path, count: int) -> None:
    """Break one file of a case at a time, `count` times, and read the case: by its format's name, or told by itself."""
    chance = random.Random(zlib.crc32(case.encode()))
    write_files(folder, CASES[case])
    files = {name: text.encode() for name, text in CASES[case].items()}
    path = folder / next(iter(files)) if len(files) == 1 else folder
    rigs = 0
    for number in range(count):
        name = chance.choice(list(files))
        (folder / name).write_bytes(mutated(files[name], chance))
        told = case.removesuffix("-raw") if number % 2 else None
        rigs += check(path, told, wants_all=number % 10 == 0)
        (folder / name).write_bytes(files[name])
    assert 0 < rigs < count


@pytest.mark.parametrize("case", CASES)
def test_broken_files_are_read_or_refused_in_one_line(case: str, tmp_path: Path) -> None:
    fuzz(case, tmp_path, QUICK)


@pytest.mark.slow
@pytest.mark.parametrize("case", CASES)
def test_ten_thousand_broken_files_of_every_format(case: str, tmp_path: Path) -> None:
    fuzz(case, tmp_path, LONG)
