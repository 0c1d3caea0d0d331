"""What the layers draw: rays of the metric inside the ROI, heatmap cells and their colours, sensor shapes."""

from collections.abc import Iterator

import numpy as np
import pytest
import pyvista as pv

from riglens.core.rig.model import Camera, Lidar, LinearAngles, Vehicle
from riglens.core.scene.grid import VoxelGrid
from riglens.core.sensing.rays import clip_to_roi, sensor_rays
from riglens.core.vehicle.solid import solid_of
from riglens.widgets.heatmap.levels import DRAG_CELLS, coarse_level, full_level
from riglens.widgets.sensors.ray_look import (
    LEAST_DENSITY,
    MOST_DENSITY,
    OTHER_LINES,
    SELECTED_LINES,
    RayLook,
    Strokes,
)
from riglens.widgets.sensors.rays import RaysLayer, fan_of, fan_rows
from riglens.widgets.theme import DARK, LIGHT, mix, rgb
from tests.core.vehicle.solids import body_ends
from tests.widgets.conftest import contrast

GRID = VoxelGrid()
LIDAR = Lidar(
    name="roof",
    position=(0.2, -0.5, 2.2),
    rpy_deg=(1.0, 2.0, 33.0),
    elevations_deg=LinearAngles(**{"from": -25.0, "to": 25.0, "count": 16}),
)
CAMERA = Camera(
    name="front", position=(0.5, 0.0, 1.8), rpy_deg=(0.0, 5.0, 55.0), hfov_deg=70.0, cast=(352, 128)
)
ONE_BEAM = LIDAR.replace(elevations_deg=(0.0,), azimuths_deg=(0.0,))
MANY_BEAMS = LIDAR.replace(
    elevations_deg=LinearAngles(**{"from": -25.0, "to": 15.0, "count": 128}),
    azimuths_deg=LinearAngles(**{"from": -180.0, "to": 180.0, "count": 1800}),
)
TINY_CAMERA = CAMERA.replace(cast=(1, 1))


@pytest.mark.parametrize("sensor", [LIDAR, CAMERA, ONE_BEAM, MANY_BEAMS, TINY_CAMERA])
@pytest.mark.parametrize("most", [OTHER_LINES, SELECTED_LINES])
def test_a_fan_is_made_of_rays_of_the_metric_and_stays_small(sensor, most):
    rows = fan_rows(sensor, most)
    assert len(np.unique(rows)) == len(rows) and rows.min() >= 0 and rows.max() < sensor.ray_count
    assert 1 <= len(rows) <= 1.3 * most
    assert lines_of(sensor, Strokes(most, 0.3)) <= 2.8 * most


@pytest.mark.parametrize("sensor", [LIDAR, CAMERA])
def test_every_drawn_ray_ends_where_the_metric_says_it_leaves_the_roi(sensor):
    rows = fan_rows(sensor, 200)
    rays = sensor_rays(sensor, rows)
    t0, t1 = clip_to_roi(GRID, rays)
    ends = np.array(rays.origin_m) + t1[:, None] * rays.directions
    drawn = np.asarray(fan_of(sensor, GRID, Strokes(200, 0.3), "#ff0000").rays.points)[1 : 2 * len(rows) : 2]
    assert (t1 > t0).all()
    assert np.allclose(drawn, ends, atol=1e-4)


@pytest.mark.parametrize("sensor", [LIDAR, CAMERA])
def test_drawn_rays_end_at_a_solid_body(sensor):
    inside, solid = sensor.replace(position=(0.0, 0.0, 0.7)), solid_of(Vehicle())
    strokes = Strokes(200, 0.3)
    rays, stopped = (fan_of(inside, GRID, strokes, "#ff0000", solid=body).rays for body in (None, solid))
    away_m = [
        np.linalg.norm(np.asarray(fan.points)[1::2] - inside.position, axis=1) for fan in (rays, stopped)
    ]
    ends_m = body_ends(inside, solid)[fan_rows(inside, 200)]
    assert np.allclose(away_m[1], np.minimum(away_m[0], ends_m), atol=1e-4)
    assert (ends_m < 3.0).mean() > (0.9 if sensor is LIDAR else 0.2), "most rays meet the car from inside"


def test_a_lidar_fan_shows_lowest_and_highest_beam_all_round():
    rows = fan_rows(LIDAR, 600)
    assert {0, 15} <= set(rows // 360)
    assert np.diff(np.unique(rows % 360)).max() <= 12


def test_a_camera_fan_reaches_all_four_corners_of_the_image():
    columns, lines = CAMERA.resolution
    assert {0, columns - 1, (lines - 1) * columns, lines * columns - 1} <= set(fan_rows(CAMERA, 150).tolist())


def test_a_sensor_outside_the_roi_that_looks_away_draws_nothing():
    away = CAMERA.replace(position=(100.0, 0.0, 1.8), rpy_deg=(0.0, 0.0, 0.0))
    assert lines_of(away, Strokes(150, 0.3)) == 0


def test_a_coarse_heatmap_has_few_cells_and_loses_no_peak():
    x, y, z = np.meshgrid(np.arange(150) * 0.4, np.arange(100) * 0.4, np.arange(10) * 0.4, indexing="ij")
    centres = np.stack([x, y, z], axis=-1).reshape(-1, 3).astype(np.float32)
    values = np.random.default_rng(1).random(len(centres)).astype(np.float32)
    level = coarse_level(full_level(centres, 0.4))
    coarse = level.largest(values)
    assert len(level.centres_m) == len(coarse) <= DRAG_CELLS
    assert coarse.max() == values.max()
    peak = centres[values.argmax()]
    assert (np.abs(level.centres_m[coarse.argmax()] - peak) <= level.cell_m / 2 + 1e-4).all()


def test_a_block_of_cells_shows_its_largest_value():
    centres = np.array([[0.2, 0.2, 0.2], [0.6, 0.2, 0.2], [5.0, 0.2, 0.2]], dtype=np.float32)
    level = coarse_level(full_level(centres, 0.4), most=2)
    assert level.largest(np.array([0.3, 0.9, 0.5], dtype=np.float32)).tolist() == pytest.approx([0.9, 0.5])


def test_a_small_heatmap_is_shown_in_full_while_dragging():
    full = full_level(np.zeros((10, 3), dtype=np.float32), 0.4)
    assert coarse_level(full) is full


@pytest.mark.parametrize("palette", [DARK, LIGHT])
def test_text_stands_out_from_the_background(palette):
    text, background = (sum(rgb(colour)) for colour in (palette.text, palette.background))
    assert abs(text - background) > 1.2


def test_colours_mix_evenly():
    assert mix("#000000", "#ffffff", 0.5) == "#808080"
    assert mix("#102030", "#ffffff", 0.0) == "#102030"


def lines_of(sensor, strokes: Strokes) -> int:
    """How many lines a fan has."""
    return sum(mesh.n_cells for mesh in fan_of(sensor, GRID, strokes, "#ff0000"))


@pytest.fixture
def layer() -> Iterator[RaysLayer]:
    plotter = pv.Plotter(off_screen=True, window_size=[64, 64], lighting="none")
    yield RaysLayer(plotter.renderer)
    plotter.close()


def drawn(layer: RaysLayer, look: RayLook, quick: bool = False) -> tuple[list[int], list[int]]:
    """Number of lines and largest opacity of the selected sensor's fan, and of ten others."""
    others = [CAMERA, MANY_BEAMS] * 5
    layer.show([LIDAR], True, GRID, DARK, look.of_selected(quick))
    layer.show(others, False, GRID, DARK, look.of_others(len(others), quick))
    drawn = [(fan.rays, fan.edges) for fan in reversed(layer._fans)]
    meshes = [[pv.wrap(actor.mapper.GetInput()) for actor in fan] for fan in drawn]
    lines = [sum(mesh.n_lines for mesh in fan) for fan in meshes]
    return lines, [max(int(mesh["rgba"][:, 3].max()) for mesh in fan) for fan in meshes]


@pytest.mark.parametrize("density", [1.0, 8.0])
def test_a_moving_picture_has_far_fewer_but_bolder_rays(layer, density):
    (lines, opacity), (few, bold) = (drawn(layer, RayLook(density=density), quick) for quick in (False, True))
    assert all(0 < less < 0.5 * many for less, many in zip(few, lines, strict=True))
    assert all(more > some for more, some in zip(bold, opacity, strict=True))
    assert few == drawn(layer, RayLook(), quick=True)[0]


def test_density_is_the_number_of_rays_and_opacity_how_strong_they_are(layer):
    lines, opacity = drawn(layer, RayLook())
    more, same = drawn(layer, RayLook(density=4.0))
    assert all(3.0 < many / some < 6.0 for many, some in zip(more, lines, strict=True)) and same == opacity
    same, stronger = drawn(layer, RayLook(opacity=0.3))
    assert same == lines
    assert all(
        bold / some == pytest.approx(1.5, abs=0.1) for bold, some in zip(stronger, opacity, strict=True)
    )


@pytest.mark.parametrize("sensor", [LIDAR, CAMERA, MANY_BEAMS])
def test_the_densest_fan_too_is_made_of_rays_of_the_metric(sensor):
    strokes = RayLook(density=MOST_DENSITY).of_selected()
    rows = fan_rows(sensor, strokes.lines)
    assert len(np.unique(rows)) == len(rows) and rows.max() < sensor.ray_count
    assert lines_of(sensor, strokes) <= 2.8 * strokes.lines


def test_a_thin_fan_keeps_its_lowest_and_highest_beam_and_the_corners_of_the_image():
    strokes = RayLook(density=LEAST_DENSITY).of_others(60)
    assert {0, 15} <= set(fan_rows(LIDAR, strokes.lines) // 360)
    columns, lines = CAMERA.resolution
    assert {0, lines * columns - 1} <= set(fan_rows(CAMERA, strokes.lines).tolist())


@pytest.mark.parametrize("palette", [DARK, LIGHT])
def test_rings_of_a_lidar_that_is_not_selected_stand_out_from_the_ground(layer, palette):
    layer.show([LIDAR], False, GRID, palette, RayLook().of_others(7))
    ring = np.asarray(pv.wrap(layer._fans[False].edges.mapper.GetInput())["rgba"])[0] / 255.0
    shown = ring[3] * ring[:3] + (1.0 - ring[3]) * np.array(rgb(palette.ground))
    assert contrast(shown, rgb(palette.ground)) > 1.8
