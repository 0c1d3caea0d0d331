"""Damaged files give one line with the name of the file, short enough to be read: every reader, damaged many ways."""

import random
from pathlib import Path

import pytest

from riglens.core.errors import InputError
from riglens.core.vehicle.mesh_file import read_mesh
from tests import fuzz

TIMES = 12
LONGEST = 400
"""Letters of a line, with the path of a temporary folder in it."""


def complaints(target: fuzz.Target) -> list[str]:
    """What a reader says of its files, damaged in so many ways; of what it reads all the same it says nothing."""
    sound, said = [file.read_bytes() for file in target.files], []
    for number in range(TIMES):
        try:
            target.attempt(random.Random(f"message {number}"))
        except InputError as error:
            said.append(str(error))
        for file, content in zip(target.files, sound, strict=True):
            file.write_bytes(content)
    return said


def test_complaints_about_rigs_boxes_and_pogs_are_one_short_line_with_the_name_of_the_file(
    tmp_path: Path,
) -> None:
    targets = [
        *fuzz._formats(tmp_path / "rigs"), *fuzz._boxes(tmp_path / "boxes"), fuzz._pog(tmp_path / "pog"),
    ]  # fmt: skip
    silent = []
    for target in targets:
        names = {name for file in target.files for name in (file.name, file.parent.name)}
        said = complaints(target)
        for line in said:
            assert any(name in line for name in names), f"{target.name}: {line}"
            assert line.isprintable() and len(line) <= LONGEST, f"{target.name}: {line}"
        silent += [] if said else [target.name]
    assert len(targets) >= 24 and len(silent) < 4, "damaged, most of them are refused"


def test_complaints_about_meshes_are_one_short_line_with_the_name_of_the_file(tmp_path: Path) -> None:
    path = tmp_path / "car.ply"
    path.write_bytes(b"ply\nformat ascii 1.0\nelement vertex 9\n" + bytes(range(256)))
    with pytest.raises(InputError) as caught:
        read_mesh(path)
    line = str(caught.value)
    assert path.name in line and line.isprintable() and len(line) <= LONGEST
