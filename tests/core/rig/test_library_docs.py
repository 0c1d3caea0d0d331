"""The page on the sensor library tells the truth: its example is a library, its numbers and fields are right."""

import re
from pathlib import Path

from riglens.core.rig.library import Entry, read_entries
from riglens.core.rig.model import Camera, Lidar

ROOT = Path(__file__).resolve().parents[3]
PAGE = (ROOT / "docs" / "sensor-library.md").read_text(encoding="utf-8")
NOT_OF_MODELS = {
    "name",
    "kind",
    "model",
    "position",
    "rpy_deg",
    "enabled",
    "mirror_of",
    "fails_with",
    "blocked",
}


def test_the_example_is_a_library(tmp_path: Path) -> None:
    (example,) = re.findall(r"```yaml\n(.*?)```", PAGE, re.DOTALL)
    (tmp_path / "own.yaml").write_text(example, encoding="utf-8")
    assert [entry.kind for entry in read_entries(tmp_path / "own.yaml", "own.yaml")] == ["lidar", "camera"]


def test_every_field_is_explained() -> None:
    fields = (set(Entry.model_fields) | set(Lidar.model_fields) | set(Camera.model_fields)) - {
        "name",
        "fields",
    }
    assert [field for field in fields - NOT_OF_MODELS if f"`{field}`" not in PAGE] == []
