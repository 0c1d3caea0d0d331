"""On real boxes (nuScenes mini, validation scenes) the paper's orders appear, with the documented figures."""

from pathlib import Path

import pytest

from riglens.core.metric.entropy import EntropyField
from riglens.core.metric.scores import ClassScores
from riglens.core.rig.presets import preset
from riglens.core.scene.boxes import CLASSES
from riglens.core.scene.grid import VoxelGrid
from riglens.core.scene.pog import build_pog
from riglens.core.scene.readers import open_boxes
from tests.core.builders import evaluate

LIDARS_KNAT = {"Center": -187.9, "Pyramid": -183.0, "Line": -134.7, "Trapezoid": -134.2}
CAMERAS_KNAT = {"Wide": -670.7, "Narrow": -686.5}
H_TOTAL_KNAT = 855.8


@pytest.fixture(scope="module")
def groups(shared_data: Path) -> dict[str, dict[str, ClassScores]]:
    """Scores per class of every sensor group of the paper."""
    table = shared_data / "boxes" / "nuscenes_mini_val_ego.csv.gz"
    if not table.is_file():
        pytest.skip("the nuScenes boxes are not on this machine")
    field = EntropyField.from_pog(build_pog(open_boxes(table, (-1.35, 0.0, 0.0)), VoxelGrid()))
    assert field.data.frames == 81
    return {name: evaluate(field, preset(name)).scores.classes for name in (*LIDARS_KNAT, *CAMERAS_KNAT)}


def test_s_mig_for_cars_is_within_one_percent_of_the_documented_figures(
    groups: dict[str, dict[str, ClassScores]],
) -> None:
    for name, expected in LIDARS_KNAT.items():
        assert groups[name]["car"].lidar.s_mig / 1e3 == pytest.approx(expected, rel=0.01)
    for name, expected in CAMERAS_KNAT.items():
        assert groups[name]["car"].camera.s_mig / 1e3 == pytest.approx(expected, rel=0.01)
    assert groups["Center"]["car"].h_total / 1e3 == pytest.approx(H_TOTAL_KNAT, rel=0.01)


@pytest.mark.parametrize("cls", CLASSES)
def test_every_order_of_the_papers_table_appears(groups: dict[str, dict[str, ClassScores]], cls: str) -> None:
    lidars = [groups[name][cls].lidar.s_mig for name in ("Center", "Pyramid", "Line", "Trapezoid")]
    assert lidars == sorted(lidars) and len(set(lidars)) == 4
    assert groups["Narrow"][cls].camera.s_mig < groups["Wide"][cls].camera.s_mig
