"""The set of pictures for a report: every file that the captions name, clear around what is drawn."""

import xml.etree.ElementTree as ElementTree
from dataclasses import replace

import matplotlib.image
import numpy as np
import pytest

from riglens.core.errors import InputError
from riglens.core.footprint.ground import footprint
from riglens.core.rig.model import Camera, KannalaBrandt, Rig
from riglens.rendering.picture_set import CAPTIONS, VIEWS, require_folder, write_set
from riglens.rendering.render import rig_state

CAMERA = Camera(name="front left/1", position=(0.3, 0.0, 1.5), image=(320, 180), hfov_deg=60.0)
WIDE = Camera(
    name="wide", position=(2.2, 0.0, 0.8), image=(128, 96), fx=32, fy=32, cx=64, cy=48, distortion=KannalaBrandt(),
)  # fmt: skip
RIG = Rig(name="two", sensors=(CAMERA, WIDE))


@pytest.fixture(scope="module")
def written(tmp_path_factory, xvfb):
    folder = tmp_path_factory.mktemp("set") / "new"
    return folder, write_set(rig_state(RIG, "light"), folder, (160, 100))


def test_the_set_has_all_pictures_twice_and_their_captions(written):
    folder, files = written
    names = [*VIEWS, "footprints", "blind-zones", "camera-front-left-1", "camera-wide"]
    assert {file.name for file in files} == {f"{n}{s}" for n in names for s in (".png", ".svg")} | {CAPTIONS}
    captions = (folder / CAPTIONS).read_text(encoding="utf-8").splitlines()
    assert captions[0] == "two" and [line.split(":")[0] for line in captions[1:]] == names


def test_pictures_are_clear_around_the_car_and_vector_files_are_well_formed(written):
    folder, files = written
    corner = matplotlib.image.imread(folder / "corner.png")
    assert corner.shape == (100, 160, 4) and corner[0, 0, 3] == 0.0 and corner[..., 3].max() == 1.0
    for file in files:
        if file.suffix == ".svg":
            root = ElementTree.fromstring(file.read_bytes())
            assert root.find("{http://www.w3.org/2000/svg}desc") is not None


def test_what_a_camera_sees_has_its_proportions_and_the_ground(written):
    folder, _ = written
    seen = matplotlib.image.imread(folder / "camera-front-left-1.png")
    width, height = CAMERA.image
    assert seen.shape[:2] == (round(160 * height / width), 160) and seen[..., 3:].min(initial=1.0) == 1.0
    assert np.ptp(seen[..., :3]) > 0.1


def test_a_lens_of_half_the_sphere_has_a_picture_too(written):
    folder, _ = written
    seen = matplotlib.image.imread(folder / "camera-wide.png")
    assert seen.shape[:2] == (120, 160) and np.ptp(seen[..., :3]) > 0.1
    assert seen[60, 10, :3].max() > 0.0 and seen[60, 150, :3].max() > 0.0  # at 72 degrees to both sides


def test_the_car_and_its_shadow_fill_their_pictures(written):
    folder, _ = written
    for name in VIEWS:
        drawn = matplotlib.image.imread(folder / f"{name}.png")[..., 3] > 0.0
        wide, high = (
            np.ptp(np.flatnonzero(drawn.any(axis=axis))) / side for axis, side in ((0, 160), (1, 100))
        )
        assert 0.7 < max(wide, high) < 1.0, name


def test_ground_where_the_lowest_object_is_seen_is_clear(written):
    folder, _ = written
    alpha = matplotlib.image.imread(folder / "blind-zones.png")[..., 3]
    ahead, behind = alpha[40, 120], alpha[40, 40]
    assert ahead == 0.0 and behind > 0.3


def test_the_drawing_of_footprints_has_a_polygon_per_patch(written):
    folder, _ = written
    root = ElementTree.fromstring((folder / "footprints.svg").read_bytes())
    patches = [patch for one in RIG.sensors for band in footprint(one).bands for patch in band.patches]
    assert len(root.findall("{http://www.w3.org/2000/svg}polygon")) >= len(patches) - 2


def test_colours_of_clear_parts_are_those_over_any_background(xvfb):
    from riglens.widgets.viewport.still import render_still

    state = replace(rig_state(RIG, "light"), show_legend=False, show_ground=False)
    opaque, clear = (render_still(state, (160, 100), transparent=made, view="top") for made in (False, True))
    share = clear[..., 3:] / 255.0
    solid = (share == 1.0)[..., 0]
    assert solid.any() and np.abs(clear[solid][:, :3].astype(int) - opaque[solid].astype(int)).mean() < 3.0


def test_a_file_in_place_of_the_folder_is_refused(tmp_path):
    file = tmp_path / "file"
    file.write_text("x", encoding="utf-8")
    with pytest.raises(InputError, match="folder"):
        require_folder(file)
