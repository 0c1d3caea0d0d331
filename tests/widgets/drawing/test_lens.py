"""Pictures through a lens: a place is where the camera's own projection has it."""

from __future__ import annotations

import numpy as np
import pytest

from riglens.core.rig.model import BrownConrady, Camera, KannalaBrandt
from riglens.core.sensors.camera import pixel_directions, project_px
from riglens.widgets.drawing.lens import bend_of, bends_of

POSE = {"position": (0.4, -0.2, 1.5), "rpy_deg": (7.0, 4.0, 30.0)}
SIZE = (80, 60)
CAMERAS = [
    Camera(name="plain", image=(320, 240), hfov_deg=65.0, **POSE),
    Camera(name="shifted", image=(320, 240), fx=260.0, fy=250.0, cx=140.0, cy=150.0, **POSE),
    Camera(
        name="bent", image=(320, 240), fx=260.0, fy=260.0, cx=160.0, cy=120.0, **POSE,
        distortion=BrownConrady(k1=-0.2, k2=0.05, p1=0.002),
    ),
    Camera(
        name="fisheye", image=(320, 240), fx=200.0, fy=200.0, cx=160.0, cy=120.0, **POSE,
        distortion=KannalaBrandt(),
    ),
]  # fmt: skip


@pytest.mark.parametrize("camera", CAMERAS, ids=lambda one: one.name)
def test_a_pixel_shows_the_place_that_the_camera_projects_there(camera: Camera) -> None:
    bend = bend_of(camera, SIZE, 2)
    assert bend is not None and bend.size[0] % 2 == bend.size[1] % 2 == 0
    away = np.random.default_rng(3).uniform((5.0, -8.0, -5.0), (30.0, 8.0, 5.0), (400, 3))
    pixels = project_px(camera, away) * np.array(SIZE) / np.array(camera.image) - 0.5
    inside = ((pixels > 0.0) & (pixels < np.array(SIZE) - 1.0)).all(axis=1)
    assert inside.sum() > 50
    world = away[inside] @ camera.pose.rotation().T + np.array(camera.position)
    flat = bend.view.project(world, bend.size)[:, :2]
    near = np.round(pixels[inside]).astype(int)
    step = max(np.nanmax(np.abs(np.diff(bend.places, axis=axis))) for axis in (0, 1))
    assert (np.abs(bend.places[near[:, 1], near[:, 0]] - flat) <= 1.1 * step).all()
    assert (flat >= 0.0).all() and (flat <= np.array(bend.size)).all()


def test_a_bent_picture_takes_the_colours_of_its_places_and_black_beyond_the_lens() -> None:
    bend = bend_of(CAMERAS[0], SIZE)
    assert bend is not None
    width, height = bend.size
    ramp = np.stack(np.meshgrid(np.arange(width), np.arange(height)), axis=-1).astype(np.uint8)
    flat = np.concatenate([ramp, np.full((height, width, 2), 255, np.uint8)], axis=-1)
    places = bend.places.copy()
    places[0, 0] = np.nan
    image = bend._replace(places=places).of(flat)
    assert image.shape == (*SIZE[::-1], 4)
    assert image[0, 0].tolist() == [0, 0, 0, 255]
    assert np.abs(image[30, 40, :2] - (places[30, 40] - 0.5)).max() <= 1.0


def test_a_bent_pixel_is_mixed_of_the_four_around_its_place_and_the_edge_goes_on() -> None:
    """Each pixel against the mix written out; of a picture that is neither square nor grey."""
    rng, (height, width) = np.random.default_rng(5), (7, 9)
    flat = rng.integers(0, 256, (height, width, 3), np.uint8)
    made = bend_of(CAMERAS[0], SIZE)
    assert made is not None
    places = rng.uniform((-1.0, -1.0), (width + 1.0, height + 1.0), (12, 11, 2))
    places[0, :3] = [[0.5, 0.5], [width - 0.5, height - 0.5], [3.5, 2.5]]  # the middle of pixels: those alone
    image = made._replace(places=places).of(flat)
    for row, column in np.ndindex(12, 11):
        x, y = np.clip(places[row, column] - 0.5, 0.0, [width - 1.0, height - 1.0])
        mixed = np.zeros(3)
        for v, u in np.ndindex(height, width):
            mixed += max(0.0, 1.0 - abs(x - u)) * max(0.0, 1.0 - abs(y - v)) * flat[v, u].astype(np.float64)
        assert np.abs(image[row, column] - mixed).max() <= 0.5 + 1e-9
    assert image[0, :3].tolist() == [flat[0, 0].tolist(), flat[-1, -1].tolist(), flat[2, 3].tolist()]


def test_a_lens_too_wide_has_no_flat_picture() -> None:
    assert bend_of(CAMERAS[0].replace(hfov_deg=150.0), SIZE) is None


def test_a_lens_too_wide_for_a_flat_picture_has_several_that_share_its_pixels() -> None:
    camera = Camera(
        name="wide", image=(320, 240), fx=90.0, fy=90.0, cx=160.0, cy=120.0, distortion=KannalaBrandt(), **POSE,
    )  # fmt: skip
    assert bend_of(camera, SIZE) is None and len(bends_of(CAMERAS[0], SIZE)) == 1
    bends = bends_of(camera, SIZE, 2)
    u, v = np.meshgrid(*((np.arange(most) + 0.5) * 4.0 for most in SIZE))
    rays = pixel_directions(camera, np.stack([u, v], axis=-1).reshape(-1, 2)).reshape(*SIZE[::-1], 3)
    imaged = [np.isfinite(bend.places[..., 0]) for bend in bends]
    assert len(bends) > 1 and (sum(imaged) == np.isfinite(rays[..., 0])).all()
    for bend, here in zip(bends, imaged, strict=True):
        world = 20.0 * rays[here] @ camera.pose.rotation().T + bend.view.position_m()
        flat = bend.view.project(world, bend.size)[:, :2]
        np.testing.assert_allclose(bend.places[here], flat, atol=1e-6)
        assert (flat >= -1.0).all() and (flat <= np.array(bend.size) + 1.0).all()
