"""Footprints in the 3D view: the core's bands, as meshes of the same area, strongest for the selected sensor."""

import numpy as np
import pytest
import pyvista as pv

from riglens.core.footprint.ground import EN_62676_4, FOOTPRINTS, footprint
from riglens.core.rig.model import Camera, KannalaBrandt, Vehicle
from riglens.core.sensors.ultrasonic import Ultrasonic
from riglens.core.vehicle.housings import with_housings
from riglens.core.vehicle.solid import solid_of
from riglens.widgets.sensors.footprints import FootprintsLayer, tints
from riglens.widgets.theme import DARK, palette

CAMERA = Camera(name="c", position=(0.0, 0.0, 1.5), image=(1600, 900), hfov_deg=70.0)
BENT = Camera(
    name="b", position=(0.0, 1.0, 1.0), rpy_deg=(0.0, 40.0, 90.0), image=(1280, 960), fx=320, fy=320, cx=640, cy=480,
    distortion=KannalaBrandt(k1=-0.02),
)  # fmt: skip
SOUND = Ultrasonic(name="u", position=(2.3, 0.0, 0.5))


@pytest.fixture
def layer(plotter: pv.Plotter) -> FootprintsLayer:
    return FootprintsLayer(plotter.renderer, plotter.renderer)


def drawn(layer: FootprintsLayer, is_selected: bool) -> pv.PolyData:
    return pv.wrap(layer._fills[is_selected].mapper.GetInput())


@pytest.mark.parametrize("sensor", [CAMERA, BENT, SOUND], ids=["pinhole", "bent", "sound"])
def test_a_mesh_has_the_area_of_the_bands(layer, sensor):
    layer.show([sensor], True, True, DARK, EN_62676_4, None, False)
    found = footprint(sensor)
    area = drawn(layer, True).triangulate().compute_cell_sizes()["Area"].sum()
    assert area == pytest.approx(found.area_m2, rel=1e-4)
    assert len(tints(sensor, DARK, len(found.bands))) == len(found.bands)


def test_the_selected_sensor_has_the_strongest_footprint(layer):
    for is_selected, is_any in ((True, True), (False, True), (False, False)):
        layer.show([CAMERA], is_selected, is_any, DARK, EN_62676_4, None, False)
    others = np.asarray(drawn(layer, False)["rgba"])[:, 3].max()
    assert np.asarray(drawn(layer, True)["rgba"])[:, 3].max() > others
    layer.show([CAMERA], False, True, DARK, EN_62676_4, None, False)
    assert np.asarray(drawn(layer, False)["rgba"])[:, 3].max() < others


def test_nothing_is_shown_of_no_sensor(layer):
    layer.show([CAMERA], False, False, DARK, EN_62676_4, None, False)
    layer.show([], False, False, DARK, EN_62676_4, None, False)
    assert not layer._fills[False].visibility and not layer._edges[False].visibility


def test_at_rest_the_body_hides_ground(layer):
    low, solid = CAMERA.replace(rpy_deg=(0.0, 20.0, 0.0)), solid_of(Vehicle())
    layer.show([low], True, True, DARK, EN_62676_4, solid, False)
    area = drawn(layer, True).triangulate().compute_cell_sizes()["Area"].sum()
    assert area == pytest.approx(footprint(low, solid=solid).area_m2, rel=1e-4)


def test_a_housing_hides_ground_where_it_is_in_view(layer):
    low, body = CAMERA.replace(rpy_deg=(0.0, 20.0, 0.0)), solid_of(Vehicle())
    areas = []
    for x in (-0.5, 0.3, -0.6):
        solid = with_housings(body, (CAMERA.replace(name="other", position=(x, 0.0, 1.4)),))
        layer.show([low], True, True, DARK, EN_62676_4, solid, False)
        areas.append(drawn(layer, True).triangulate().compute_cell_sizes()["Area"].sum())
        assert areas[-1] == pytest.approx(footprint(low, solid=solid).area_m2, rel=1e-4)
    assert areas[0] == areas[2] > 1.001 * areas[1]


def test_a_footprint_that_is_known_is_shown_while_something_moves(layer):
    low, solid = SOUND.replace(position=(2.1, 0.9, 0.5), rpy_deg=(0.0, 0.0, 150.0)), solid_of(Vehicle())
    areas = []
    for moved in (low, low, low.replace(position=(2.1, 0.95, 0.5))):
        layer.show([moved], True, True, DARK, EN_62676_4, solid, True)
        areas.append(drawn(layer, True).triangulate().compute_cell_sizes()["Area"].sum())
        if len(areas) == 1:
            FOOTPRINTS.found(low, EN_62676_4, solid)
    free, cut = footprint(low, step_deg=4.0).area_m2, footprint(low, solid=solid).area_m2
    assert areas == pytest.approx([free, cut, free], rel=1e-3) and cut < 0.95 * free


@pytest.fixture
def waiting(plotter: pv.Plotter) -> FootprintsLayer:
    return FootprintsLayer(plotter.renderer, plotter.renderer, waits=True)


def test_a_layer_that_waits_is_coarse_at_rest_until_the_footprint_is_known(waiting):
    low, solid = SOUND.replace(position=(2.1, 0.9, 0.52), rpy_deg=(0.0, 0.0, 150.0)), solid_of(Vehicle())
    areas = []
    for lacks in (True, False):
        waiting.show([low], True, True, DARK, EN_62676_4, solid, False)
        areas.append(drawn(waiting, True).triangulate().compute_cell_sizes()["Area"].sum())
        assert waiting.lacks_any is lacks
        FOOTPRINTS.found(low, EN_62676_4, solid)
    coarse, exact = footprint(low, step_deg=4.0).area_m2, footprint(low, solid=solid).area_m2
    assert areas == pytest.approx([coarse, exact], rel=1e-4)


def test_a_layer_finds_few_coarse_footprints_at_a_time(waiting, monkeypatch):
    monkeypatch.setattr("riglens.widgets.sensors.footprints._MOST_QUICK", 2)
    several = [CAMERA.replace(position=(0.0, 0.01 * number, 1.37)) for number in range(5)]
    bands = []
    for _ in range(4):
        waiting.show(several, False, False, DARK, EN_62676_4, None, False)
        bands.append(drawn(waiting, False).n_cells)
    assert [count // (bands[0] // 2) for count in bands] == [2, 4, 5, 5] and waiting.lacks_any


def test_meshes_are_made_again_where_their_footprints_or_their_look_differ(layer):
    def fills(sensor, is_any=True, look=DARK, quick=False):
        layer.show([sensor], False, is_any, look, EN_62676_4, None, quick)
        return layer._fills[False].mapper.GetInput() if not quick else layer._hazy.mapper.GetInput()

    first = fills(CAMERA)
    assert fills(CAMERA) is first and fills(CAMERA.replace(name="same"), quick=True) is first
    assert layer._hazy.visibility and not layer._fills[False].visibility
    assert fills(CAMERA) is first and layer._fills[False].visibility and not layer._hazy.visibility
    for other in (fills(CAMERA, is_any=False), fills(CAMERA, look=palette(False)), fills(SOUND)):
        assert other is not first
    again = fills(CAMERA)
    assert again is not first
    one, other = pv.wrap(first), pv.wrap(again)
    assert np.array_equal(one.points, other.points) and np.array_equal(one["rgba"], other["rgba"])
