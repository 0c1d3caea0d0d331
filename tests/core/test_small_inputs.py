"""Every line, key and number of box data, requirements, profiles, libraries and rig files means what it did."""

from __future__ import annotations

import tempfile
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

from riglens.assets import asset_path
from riglens.core.blind.outline import Outline
from riglens.core.review.profiles import read_profiles, targets_of
from riglens.core.review.requirements import read_requirements
from riglens.core.rig.library import read_entries
from riglens.core.rig.presets import preset
from riglens.core.rig.yaml.file import dumps, loads
from riglens.core.scene.readers import open_boxes
from riglens.core.scene.readers.occluders import open_occluders
from tests.core import sound_boxes
from tests.core.formats.cases import write_files
from tests.core.small_changes import Files, compare, keep, outcomes
from tests.core.test_occluders import OCCLUDERS, POSES
from tests.fuzz import LIBRARY, REQUIRED

KEPT = Path(__file__).with_name("small_inputs.json")
BOXES = (
    sound_boxes.csv_file, sound_boxes.kitti_tracking, sound_boxes.kitti_object, sound_boxes.nuscenes_tables,
    sound_boxes.once, sound_boxes.zod, sound_boxes.dair_v2x, sound_boxes.opv2v,
)  # fmt: skip


def boxes_of(path: Path) -> Iterator[object]:
    source = open_boxes(path)
    yield [(one.frame, one.cls, one.centre_m, one.size_m, one.rotation) for one in source.batches()]
    report = source.report()
    yield report.frames, report.boxes, report.unmapped, report.sequences, len(report.notes)


def occluders_of(path: Path) -> Iterator[object]:
    yield open_occluders(path / "occluders.csv", path / "poses.csv").around(("a", 0), 1e9)


def profiles_of(path: Path) -> Iterator[object]:
    for profile in read_profiles(path):
        yield profile, targets_of(profile, Outline(-2.3, 2.3, -0.9, 0.9))


CASES: dict[str, tuple[Files, str, Callable[[Path], Iterator[object]]]] = {
    "occluders": ({"occluders.csv": OCCLUDERS, "poses.csv": POSES}, ".", occluders_of),
    "profiles": (
        {"blind.yaml": asset_path("review", "blind.yaml").read_text(encoding="utf-8")}, "blind.yaml", profiles_of
    ),
    "requirements": ({"own.yaml": REQUIRED}, "own.yaml", lambda path: iter([read_requirements(path)])),
    "library": ({"own.yaml": LIBRARY}, "own.yaml", lambda path: iter([read_entries(path, path.name)])),
    "rig": (
        {"rig.yaml": dumps(preset("W+T"))}, "rig.yaml",
        lambda path: iter([loads(path.read_text(encoding="utf-8")).rig]),
    ),
}  # fmt: skip


def sound(make: Callable[[Path], sound_boxes.Sound]) -> tuple[Files, str, Callable[[Path], Iterator[object]]]:
    """Return the files of a source of boxes, the place to open, and what opens it."""
    with tempfile.TemporaryDirectory() as made:
        folder = Path(made)
        found = make(folder)
        files = {
            path.relative_to(folder).as_posix(): path.read_text(encoding="utf-8") for path in found.files
        }
        return files, found.path.relative_to(folder).as_posix(), boxes_of


CASES |= {make.__name__: sound(make) for make in BOXES}


def found_in(case: str, folder: Path) -> list[list[float] | None]:
    files, opened, read = CASES[case]
    return outcomes(files, lambda changed: read(write_files(folder, dict(changed)) / opened))


@pytest.mark.parametrize("case", CASES)
def test_every_line_key_and_number_means_what_it_did(case: str, tmp_path: Path) -> None:
    compare(KEPT, case, found_in(case, tmp_path))


if __name__ == "__main__":
    with tempfile.TemporaryDirectory() as made:
        keep(KEPT, {case: found_in(case, Path(made) / case) for case in CASES})
