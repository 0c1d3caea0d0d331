"""Cuboids of PandaSet: pickles are never read, and the lines on the page make a table that is right."""

import gzip
import math
import pickle
import re
import sys
from pathlib import Path
from types import ModuleType, SimpleNamespace
from typing import Any

import numpy as np
import pytest

from riglens.core.errors import InputError
from riglens.core.scene.readers.opening import open_boxes

ROOT = Path(__file__).resolve().parents[2]
PAGE = (ROOT / "docs" / "formats-boxes.md").read_text(encoding="utf-8")


class Bomb:
    """Leaves a mark when it is unpickled."""

    def __init__(self, mark: Path) -> None:
        self.mark = mark

    def __reduce__(self) -> tuple[Any, ...]:
        return Path.touch, (self.mark,)


@pytest.mark.parametrize(
    ("file", "given"),
    [
        ("00.pkl.gz", "00.pkl.gz"),
        ("00.pkl", "."),
        ("annotations/cuboids/00.pkl.gz", "."),
        ("annotations/cuboids/00.pkl.gz", "annotations"),
    ],
)
def test_pickles_are_refused_unread_with_the_way_out(tmp_path: Path, file: str, given: str) -> None:
    place, mark = tmp_path / file, tmp_path / "mark"
    place.parent.mkdir(parents=True, exist_ok=True)
    place.write_bytes(gzip.compress(pickle.dumps(Bomb(mark))))
    with pytest.raises(InputError, match=r"pickle files, .* never read here: .*formats-boxes\.md, PandaSet"):
        open_boxes(tmp_path / given)
    assert not mark.exists()


def devkit(boxes: list[dict[str, Any]], pose: dict[str, dict[str, float]]) -> ModuleType:
    """What the page needs of pandaset-devkit: one sequence of one frame."""
    frame = SimpleNamespace(to_dict=lambda _how: boxes)
    sequence = SimpleNamespace(
        load_lidar=lambda: None,
        load_cuboids=lambda: None,
        cuboids=[frame],
        lidar=SimpleNamespace(poses=[pose]),
    )
    module = ModuleType("pandaset")
    module.DataSet = lambda _folder: {"001": sequence}  # type: ignore[attr-defined]
    return module


def cuboid(label: str, x: float, y: float, yaw: float, sensor: int) -> dict[str, Any]:
    """One row of the cuboids; 4 m long, 2 m wide, 1.5 m high."""
    size = {"dimensions.x": 2.0, "dimensions.y": 4.0, "dimensions.z": 1.5}
    place = {"position.x": x, "position.y": y, "position.z": 5.0}
    return {"label": label, "yaw": yaw, "cuboids.sensor_id": sensor} | size | place


def test_the_lines_of_the_page_make_a_table_in_the_frame_of_the_car(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The car drives to the world's -x; another is 10 m ahead and drives along, a third 3 m to its left across."""
    # the Pandar64's y points backwards, to the world's +x, and its x to the left, to the world's -y
    half = math.sqrt(0.5)
    pose = {
        "position": {"x": 100.0, "y": 50.0, "z": 6.0},
        "heading": {"w": half, "x": 0.0, "y": 0.0, "z": -half},
    }
    boxes = [
        cuboid("Car", 90.0, 50.0, math.pi / 2, -1),  # yaw 0 looks along +y: 90 degrees look along -x
        cuboid("Bus", 100.0, 47.0, math.pi, 0),  # looks along -y, to the left
        cuboid("Car", 90.0, 50.0, math.pi / 2, 1),
    ]
    (code,) = re.findall(r"```python\n(.*?)```", PAGE.partition("## PandaSet")[2], re.DOTALL)
    monkeypatch.setitem(sys.modules, "pandaset", devkit(boxes, pose))
    monkeypatch.chdir(tmp_path)
    exec(compile(code, "formats-boxes.md", "exec"), {})  # our own page
    source = open_boxes(tmp_path / "pandaset_001.csv", origin_m=(0.0, 0.0, 2.0))
    (batch,) = list(source.batches(lambda share: None))
    assert np.abs(batch.centre_m - [(10.0, 0.0, 1.0), (0.0, 3.0, 1.0)]).max() < 1e-9
    assert batch.cls.tolist() == [0, 0]
    forward = batch.rotation[:, :, 0]
    assert np.abs(forward - [(1.0, 0.0, 0.0), (0.0, 1.0, 0.0)]).max() < 1e-9
