"""The examples of docs/scripting.md run as they are on the page, each in a folder of its own."""

from __future__ import annotations

import re
from pathlib import Path

import matplotlib.image
import pytest

import riglens as rl

REPOSITORY = Path(__file__).resolve().parents[1]
PAGE = (REPOSITORY / "docs" / "scripting.md").read_text(encoding="utf-8")
EXAMPLES = dict(re.findall(r"^## ([^\n]+)\n\n```python\n(.*?)^```", PAGE, re.MULTILINE | re.DOTALL))


@pytest.fixture
def output(
    tmp_path: Path,
    request: pytest.FixtureRequest,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> tuple[Path, str]:
    """The folder in which an example ran, and what it printed."""
    monkeypatch.chdir(tmp_path)
    exec(compile(EXAMPLES[request.param], request.param, "exec"), {"__name__": "__main__"})
    return tmp_path, capsys.readouterr().out


def example(title: str) -> pytest.MarkDecorator:
    """Have the test see what the example under that heading left."""
    return pytest.mark.parametrize("output", [title], indirect=True)


def test_the_page_has_these_examples_all_run_here() -> None:
    assert list(EXAMPLES) == [
        "Compare two rigs in five lines",
        "Sweep the height of one sensor",
        "Convert a rig",
        "Points on objects",
        "Arrays",
        "Where the rays go",
        "A picture",
    ]
    assert len(EXAMPLES["Compare two rigs in five lines"].splitlines()) == 5


@example("Compare two rigs in five lines")
def test_a_comparison_in_five_lines(output: tuple[Path, str]) -> None:
    rig, predicted, sentence = output[1].splitlines()
    assert "W+T" in rig and "Predicted AP" in rig
    assert 0.0 < float(predicted) < 1.0
    assert "nuScenes car" in sentence


@example("Sweep the height of one sensor")
def test_a_sweep(output: tuple[Path, str]) -> None:
    assert matplotlib.image.imread(output[0] / "height.png")[..., :3].std() > 0.01


@example("Convert a rig")
def test_a_conversion(output: tuple[Path, str]) -> None:
    folder, out = output
    assert "ROS URDF: ignored: vehicle: the format cannot express it" in out
    assert "origin of the LiDAR in the camera's frame: [" in out
    assert (folder / "rig.urdf").read_text(encoding="utf-8").startswith("<?xml")
    assert len(rl.open_rig(folder / "rig.yaml").sensors) == len(rl.open_rig("W+T").sensors)


@example("Points on objects")
def test_points_on_objects(output: tuple[Path, str]) -> None:
    lines = output[1].splitlines()
    assert [line.split(":")[0] for line in lines[::2]] == ["Trapezoid", "Center"]
    assert all("objects without a point" in line for line in lines[1::2])


@example("Arrays")
def test_arrays(output: tuple[Path, str]) -> None:
    unseen, *sensors, triangles = output[1].splitlines()
    assert float(unseen.split()[0]) > 0.0 and 0.0 < float(unseen.split()[-1]) <= 1.0
    assert len(sensors) == len(rl.open_rig("W+T").enabled_lidars()) and all(
        line.endswith("voxels") for line in sensors
    )
    assert triangles.endswith(", 3, 3) triangles of the car")


@example("Where the rays go")
def test_an_audit(output: tuple[Path, str]) -> None:
    *sensors, ignored, blocks = output[1].splitlines()
    assert len(sensors) == len(rl.open_rig("W+T").sensors)
    assert all("% into the car, " in line and line.endswith("% bring something new") for line in sensors)
    assert float(ignored.removeprefix("ignored ")) >= float(blocks.removeprefix("blocks ")) > 0.5


@example("A picture")
def test_pictures(output: tuple[Path, str]) -> None:
    dark, light = (matplotlib.image.imread(output[0] / name) for name in ("narrow.png", "lost.png"))
    assert dark.shape[:2] == light.shape[:2] == (400, 640)
    assert light[..., :3].mean() > dark[..., :3].mean()


def test_every_name_is_on_the_page() -> None:
    assert [name for name in rl.__all__ if f"`{name}" not in PAGE] == []
