"""The page on rig files tells the truth: its examples load, nothing is left out."""

import re
from pathlib import Path

from riglens.core.rig.model import (
    BrownConrady,
    Camera,
    KannalaBrandt,
    Lidar,
    MeshPlacement,
    Rig,
    Vehicle,
)
from riglens.core.rig.presets import PRESETS
from riglens.core.rig.yaml.file import loads
from riglens.core.sensors.scan import RayTable, Scan, Swing

PAGE = (Path(__file__).resolve().parents[3] / "docs" / "formats-rig.md").read_text(encoding="utf-8")
EXAMPLE, MODELS = re.findall(r"```yaml\n(.*?)```", PAGE, re.DOTALL)


def test_the_examples_are_valid_rigs() -> None:
    assert [sensor.kind for sensor in loads(EXAMPLE).rig.sensors] == ["lidar", "camera"]
    assert [lidar.ray_count for lidar in loads(MODELS).rig.enabled_lidars()] == [32 * 1800, 16 * 1800]


def test_every_field_model_and_group_is_explained() -> None:
    parts = (Rig, Vehicle, MeshPlacement, Lidar, Camera, BrownConrady, KannalaBrandt)
    parts += (Scan, Swing, RayTable)
    words = {name for part in parts for name in part.model_fields}
    words |= {
        name for name in PRESETS if name.startswith(("W+", "N+C")) or name in ("Wide", "Narrow", "Center")
    }
    missing = [word for word in words if f"`{word}`" not in PAGE and f".{word}`" not in PAGE]
    assert not missing
