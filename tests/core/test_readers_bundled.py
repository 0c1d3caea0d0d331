"""The scenario that comes with the program reads like any table."""

import hashlib
import json
from importlib import resources

import pytest

from riglens.core.scene.grid import VoxelGrid
from riglens.core.scene.pog import build_pog
from riglens.core.scene.readers import bundled_source

POGS = {
    VoxelGrid(): "8eea463696c231fba974f9b31dfdebac04e67a89bd1fc8697e91834c88b1ddea",
    VoxelGrid(0.25): "022f2a7ebe9041681fdc38c1df8d4e21ac58f61d7066463978d879aaf6acab75",
    VoxelGrid(0.2, (30.0, 36.0, 3.0)): "ea9e2644df5d6d48202a3aaf3aac300044c70f897315d01475d813c68e36857a",
}
"""Of the town when its boxes ended at the border of the default region."""


def test_the_bundled_scenario_holds_what_its_note_says() -> None:
    note = json.loads(
        resources.files("riglens.assets").joinpath("scenarios/town/scenario.json").read_text(encoding="utf-8")
    )
    source = bundled_source()
    total = sum(batch.frame.size for batch in source.batches())
    report = source.report()
    assert report.frames == note["frames"] >= 2000
    assert sum(report.boxes.values()) == total
    assert all(count > 0 for count in report.boxes.values())
    assert not report.unmapped


@pytest.mark.parametrize(("grid", "digest"), POGS.items(), ids=lambda value: str(value)[:40])
def test_boxes_beyond_the_region_leave_the_pog_as_it_was(grid: VoxelGrid, digest: str) -> None:
    pog = build_pog(bundled_source(), grid)
    content = pog.index.words.tobytes() + pog.counts.tobytes() + str(pog.data.frames).encode()
    assert hashlib.sha256(content).hexdigest() == digest
