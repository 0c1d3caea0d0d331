"""The page on rig files tells the truth: its examples load, its messages appear, nothing is left out."""

import re
from pathlib import Path

import pytest

from riglens.core.errors import InputError
from riglens.core.rig.presets import PRESETS
from riglens.core.rig.yaml.check import ACCEPTED
from riglens.core.rig.yaml.file import loads

PAGE = (Path(__file__).resolve().parents[3] / "docs" / "formats-rig.md").read_text(encoding="utf-8")
EXAMPLE, MODELS = re.findall(r"```yaml\n(.*?)```", PAGE, re.DOTALL)


def test_the_examples_are_valid_rigs() -> None:
    assert [sensor.kind for sensor in loads(EXAMPLE).rig.sensors] == ["lidar", "camera"]
    assert [lidar.ray_count for lidar in loads(MODELS).rig.lidars()] == [32 * 1800, 16 * 1800]


def test_every_field_model_and_group_is_explained() -> None:
    fields = {key.rpartition(".")[2].removesuffix("[]") for key in ACCEPTED}
    words = set(fields)
    words |= {
        name for name in PRESETS if name.startswith(("W+", "N+C")) or name in ("Wide", "Narrow", "Center")
    }
    missing = [
        word for word in words - {"from", "to", ""} if f"`{word}`" not in PAGE and f".{word}`" not in PAGE
    ]
    assert not missing


@pytest.mark.parametrize(
    ("old", "new", "line_start"),
    [
        ("[-0.4, 0.2, 2.2]", "[0, .nan, 2.2]", "sensors[0].position: found [0, .nan, 2.2]"),
        ("count: 16", "count: 0", "sensors[0].elevations_deg.count: found 0"),
        ("CAM_FRONT", "lidar_left", "sensors[1].name: found 'lidar_left', already used in line 6"),
        ("position: [0.5", "positon: [0.5", "sensors[1].positon: unknown field; did you mean 'position'?"),
        ("riglens: 1 ", "riglens: 2 ", "riglens: found format version 2, newer than this program reads"),
    ],
)
def test_the_messages_shown_are_those_of_the_program(old: str, new: str, line_start: str) -> None:
    with pytest.raises(InputError) as caught:
        loads(EXAMPLE.replace(old, new, 1), "rig.yaml")
    message = str(caught.value).partition("accepted are")[0]
    assert line_start in message and message in PAGE
