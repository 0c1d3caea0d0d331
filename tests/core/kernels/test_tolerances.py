"""The tolerances stand in the order that the proofs need, and docs/engine.md names what exists."""

from __future__ import annotations

import importlib
import math
import re
from pathlib import Path

from riglens.core.engine import fans, frustums, meshes, sheets
from riglens.core.kernels.beams import beam_cones, cones, cores
from riglens.core.kernels.cameras import frustum, lens_mesh
from riglens.core.kernels.fans import fan, profile, ties
from riglens.core.kernels.rays import predicates, walk
from riglens.core.sensing import image_bins

REPOSITORY = Path(__file__).resolve().parents[3]
ROOMS = ("kernels", "engine", "sensing", "sensors")
NAME = re.compile(r"`([a-z_]+)\.(\w+)`")
U = predicates.UNIT_ROUNDOFF


def modules() -> dict[str, Path]:
    """Return the files of these rooms by the names of their modules."""
    files = (path for room in ROOMS for path in sorted((REPOSITORY / "core" / room).rglob("*.py")))
    return {
        ".".join(("riglens", *path.relative_to(REPOSITORY).with_suffix("").parts)): path for path in files
    }


def test_the_functions_that_the_page_names_exist() -> None:
    text = (REPOSITORY / "docs" / "engine.md").read_text(encoding="utf-8")
    by_stem = {path.stem: name for name, path in modules().items()}
    named = NAME.findall(text)
    assert len(named) > 15
    for module, name in named:
        assert hasattr(importlib.import_module(by_stem[module]), name), f"{module}.{name}"


def test_a_crossing_is_known_to_half_of_the_tolerance() -> None:
    assert 8.0 * U * fan.FARTHEST_ORIGIN / fan.STRAIGHTEST <= profile.TOLERANCE / 2.0


def test_a_plane_along_an_axis_stays_clear_of_the_faces_beside_it() -> None:
    assert fan.STRAIGHT * 3.0 * fan.FARTHEST_ORIGIN < profile.TOLERANCE
    assert fan.STRAIGHT < fan.STRAIGHTEST


def test_one_walk_for_several_ties_finds_all_their_rays() -> None:
    assert fan.STEEPEST * (ties.TOGETHER + U * 3.0 * fan.FARTHEST_ORIGIN) < ties.AROUND
    assert ties.TOGETHER < profile.TOLERANCE < ties.AROUND


def test_the_exact_predicates_hold_for_every_ray_of_a_fan() -> None:
    assert fans.TAMEST**3 * U > predicates.SMALLEST
    assert fans.WILDEST**2 < predicates.LARGEST
    assert walk.FARTHEST * fan.STEEPEST < predicates.LARGEST


def test_moments_called_different_are_different() -> None:
    assert predicates.MOMENT_BOUND > 6.0 * U


def test_a_voxel_lies_between_its_two_balls() -> None:
    assert frustum.BALL + frustum.SLACK < 0.5
    assert math.sqrt(3.0) / 2.0 < frustum.SPHERE < 1.0
    assert frustums.SHORTEST_DEPTH > 1.0 + frustum.SPHERE


def test_balls_columns_and_tiles_have_room_for_rounding() -> None:
    assert frustum.BALL + cones.SLACK < 0.5
    assert math.sqrt(3.0) / 2.0 < cones.SPHERE
    assert math.sqrt(0.5) < cones.HALF_COLUMN
    assert beam_cones.TILE * math.sqrt(0.5) < beam_cones.HALF_TILE
    assert beam_cones.BLOCK * math.sqrt(0.5) < beam_cones.HALF_BLOCK
    assert cores.NEARLY_ONE > cones.SPHERE + cones.SLACK


def test_what_a_ray_meets_away_from_the_camera_is_ahead_of_it() -> None:
    assert lens_mesh.TOUCHING / math.hypot(1.0, image_bins.WIDEST_TANGENT) > lens_mesh.AHEAD
    half_columns_in_sectors = 1.02 * cones.HALF_COLUMN / lens_mesh.NEAREST * 0.25 * lens_mesh.SECTORS
    assert 2.0 * half_columns_in_sectors + 2.0 < 2.0**lens_mesh.WIDEST
    assert math.asin(cones.HALF_COLUMN / lens_mesh.NEAREST) < 1.02 * cones.HALF_COLUMN / lens_mesh.NEAREST
    assert frustum.SPHERE + math.sqrt(0.5) < meshes.ROOM


def test_a_cone_has_one_height_and_its_times_are_known() -> None:
    assert sheets.STEEPEST_DEG < 90.0
    assert 3.0 * U * cones.LONGEST < cones.CLEAR / 2.0
    assert cones.ROUND > 0.5 and beam_cones.ROUND_TIP > cones.ROUND
