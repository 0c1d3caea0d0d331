"""Commands print and write the numbers that they did: a few sums over them are kept beside this file.

`python -m tests.test_kept_numbers` keeps them anew after a wanted change; `python -m tests.digest` shows the texts.
"""

from __future__ import annotations

import contextlib
import json
import math
import os
import re
import sys
import tempfile
from pathlib import Path
from unittest.mock import patch

import pytest

from tests.digest import run_group, set_environment
from tests.digest_items import BOX, Item, items, write_inputs

REPOSITORY = Path(__file__).resolve().parents[1]
KEPT = Path(__file__).with_name("kept_numbers.json")
CHOSEN = (
    "skew evaluate-hits", "van evaluate-residual", "skew targets-plain", "odd targets-behind", "mesh audit-table",
    "van range", "truck blind-map", "odd blind", "skew redundancy", "skew tolerance", "odd tolerance-table",
    "skew check", "scene pog-two", "scene data-two", "library own", "study targets-rigs", "optimise front",
    "extras blind-profile", "extras brackets", "extras check-own",
)  # fmt: skip
ITEMS = {
    **{item.name: item for item in items(None) if item.name in CHOSEN},
    "report": Item(
        "report", "report", (f"report ../in/small.yaml {BOX} --voxel 0.5 --draws 2 --out r.html",)
    ),
    "sweep": Item(
        "sweep", "sweep", (f"sweep ../in/small.yaml --vary L.z=1.8:2:3 {BOX} --voxel 0.5 --out s.parquet",)
    ),
    "simulate": Item(
        "simulate", "simulate", (f"simulate ../in/small.yaml {BOX} --out s --workers 1 --every 40",)
    ),
}
NUMBER = re.compile(r"[-−]?\d+(?:\.\d+)?(?:e[-+]?\d+)?")
DRAWING = re.compile(
    r"<svg xmlns.*?</svg>|<style.*?</style>|<script(?! type).*?</script>|[A-Za-z0-9+/=]{100,}|[0-9a-f]{12,}",
    re.DOTALL,
)
"""Parts of a page that are not compared: the output of drawing and layout libraries, and pictures and meshes in base64,
whose bytes differ between graphics drivers. No key of JSON is as long."""
SUMS = 16


def numbers_in(text: str) -> list[float]:
    """Return the count of numbers in a text, and sums over their sizes, each of those SUMS places apart."""
    found = [float(one.replace("−", "-")) for one in NUMBER.findall(DRAWING.sub("", text))]
    found = [value for value in found if math.isfinite(value)]
    sizes = [math.asinh(1e3 * value) * (1.0 + n * 0.618 % 1.0) for n, value in enumerate(found)]
    return [float(len(found)), *(math.fsum(sizes[n::SUMS]) for n in range(SUMS))]


def numbers_of(item: Item, root: Path) -> list[float]:
    """Run the commands of an item, the numbers in what they print and write.

    Environment, search path and folder are the same for every item and put back after it: `--library` adds to them.
    """
    folders = {f"RIGLENS_{name}_DIR": str(root / name.lower()) for name in ("CACHE", "CONFIG", "STATE")}
    with (
        patch.dict(os.environ, folders | {"COLUMNS": "120", "TERM": "dumb"}),
        patch.object(sys, "path", [*sys.path]),
        contextlib.chdir(root),
    ):
        for name in ("RIGLENS_LIBRARY", "FORCE_COLOR"):
            os.environ.pop(name, None)
        ((_, code, text, _),) = run_group([item], root, REPOSITORY)
    return [float(code), *numbers_in(text)]


@pytest.fixture(scope="module")
def root(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with the inputs."""
    folder = tmp_path_factory.mktemp("kept")
    (folder / "in").mkdir()
    write_inputs(folder / "in")
    return folder


@pytest.mark.parametrize("name", ITEMS)
def test_a_command_prints_and_writes_the_numbers_that_it_did(
    name: str, root: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    kept = json.loads(KEPT.read_text(encoding="utf-8"))[name]
    with capfd.disabled():  # they are captured in files
        found = numbers_of(ITEMS[name], root)
    assert found == pytest.approx(kept, rel=1e-9)


if __name__ == "__main__":
    with tempfile.TemporaryDirectory() as made:
        place = Path(made).resolve()
        (place / "in").mkdir()
        write_inputs(place / "in")
        set_environment(place, REPOSITORY)
        lines = (f"  {json.dumps(name)}: {json.dumps(numbers_of(ITEMS[name], place))}" for name in ITEMS)
        KEPT.write_text("{\n" + ",\n".join(lines) + "\n}\n", encoding="utf-8")
