"""The view at rest draws coarse footprints until exact ones have been found elsewhere, also through a camera."""

from __future__ import annotations

import pytest
import pyvista as pv
from pytestqt.qtbot import QtBot

from riglens.core.footprint.ground import FOOTPRINTS, footprint
from riglens.core.rig.model import Camera, KannalaBrandt, Rig
from riglens.widgets.viewport.drawn_scene import DrawnScene
from tests.widgets.viewport.views import KINDS, AnyView, settle, shown

CAMERA = Camera(name="front", position=(0.4, 0.0, 1.53), image=(160, 90), hfov_deg=65.0)
BENT = Camera(
    name="bent", position=(0.0, 1.0, 1.03), rpy_deg=(0.0, 40.0, 90.0), image=(1280, 960), fx=320, fy=320, cx=640,
    cy=480, distortion=KannalaBrandt(k1=-0.02),
)  # fmt: skip
RIG = Rig(sensors=(CAMERA, BENT))


def drawn_m2(scene: DrawnScene) -> float:
    """Area of the footprints of all sensors but the selected one."""
    mesh = pv.wrap(scene._rig._footprints._fills[False].mapper.GetInput())
    return float(mesh.triangulate().compute_cell_sizes()["Area"].sum())


@KINDS
def test_footprints_become_exact_in_the_view_and_through_a_camera(kind: type[AnyView], qtbot: QtBot) -> None:
    FOOTPRINTS._kept._answers.clear()
    view = shown(kind, qtbot, rig=RIG, selected="front")
    limits = view.state.ray_look.px_per_m
    inset = view._inset._scene
    assert inset is not None
    coarse, exact = (footprint(BENT, limits, step_deg=step).area_m2 for step in (4.0, 2.0))
    assert abs(exact / coarse - 1.0) > 1e-3
    heard = list[str]()
    view.drawn.connect(lambda: heard.append("drawn"))
    view.footprints_lacking.connect(lambda: heard.append("lacking"))
    for area_m2, lacks in ((coarse, True), (exact, False)):
        assert [drawn_m2(scene) for scene in (view._scene, inset)] == pytest.approx([area_m2] * 2, rel=1e-4)
        view.request_render()
        settle(view)
        assert heard and ("lacking" in heard) is lacks
        for camera in RIG.sensors:
            FOOTPRINTS.found(camera, limits, None)
        heard.clear()
        view.update_footprints()
        settle(view)
    assert not heard, "nothing is drawn again once all are exact"
