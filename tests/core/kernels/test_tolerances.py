"""The tolerances: each is told in docs/engine.md with its value, and they stand in the order that the proofs need."""

from __future__ import annotations

import ast
import importlib
import math
import re
from pathlib import Path

import pytest

from riglens.core.engine import fans, frustums, meshes, sheets
from riglens.core.kernels.beams import beam_cones, cones, cores
from riglens.core.kernels.cameras import frustum, lens_mesh
from riglens.core.kernels.fans import fan, profile, ties
from riglens.core.kernels.rays import predicates, walk
from riglens.core.sensing import image_bins

REPOSITORY = Path(__file__).resolve().parents[3]
ROOMS = ("kernels", "engine", "sensing", "sensors")
ROW = re.compile(r"^\| `(\w+)\.(\w+)` \| ([^|]+) \|", re.MULTILINE)
NAME = re.compile(r"`([a-z_]+)\.(\w+)`")
U = predicates.UNIT_ROUNDOFF
NOT_ABOUT_VOXELS = ("objects", "runtime", "sight", "phases", "mounting", "sectors", "ultrasonic")
"""Folders and modules that decide nothing about voxels: those of sensors describe what they are."""


NO_TOLERANCES = {
    ("predicates", "UNIT_ROUNDOFF"),
    ("predicates", "_SPLITTER"),
    ("approximate", "HALF_DIAGONAL"),
    ("approximate", "LEAST_RADIUS"),
    ("approximate", "TURN"),
    ("cones", "A_TURN"),
    ("screen", "A_TURN"),
}
"""Constants of nature, of doubles, and stand-ins for zero."""


def in_the_sources() -> dict[tuple[str, str], float]:
    """Every number with a point that a module of these rooms names, by module and name."""
    found = {}
    for module_name, path in modules().items():
        if {path.stem, path.parent.name} & set(NOT_ABOUT_VOXELS):
            continue
        module = importlib.import_module(module_name)
        for name in _assigned(ast.parse(path.read_text(encoding="utf-8"))):
            value = getattr(module, name)
            if name.isupper() and isinstance(value, float):
                found[path.stem, name] = value
    return found


def modules() -> dict[str, Path]:
    """Return the files of these rooms by the names of their modules."""
    files = (path for room in ROOMS for path in sorted((REPOSITORY / "core" / room).rglob("*.py")))
    return {
        ".".join(("riglens", *path.relative_to(REPOSITORY).with_suffix("").parts)): path for path in files
    }


def _assigned(tree: ast.Module) -> list[str]:
    targets = [target for node in tree.body if isinstance(node, ast.Assign) for target in node.targets]
    return [node.id for target in targets for node in ast.walk(target) if isinstance(node, ast.Name)]


def in_the_docs() -> dict[tuple[str, str], float]:
    """The tables of docs/engine.md: module and name, and the value told."""
    text = (REPOSITORY / "docs" / "engine.md").read_text(encoding="utf-8")
    return {(module, name): number_of(value) for module, name, value in ROW.findall(text) if name.isupper()}


def number_of(told: str) -> float:
    """`8 u`, `2^-400`, `1e-8`: as a double."""
    if told.endswith(" u"):
        return float(told[:-2]) * U
    if "^" in told:
        base, power = told.split("^")
        return float(base) ** int(power)
    return float(told)


def test_the_page_on_the_engine_tells_every_tolerance_with_its_value() -> None:
    sources = {key: value for key, value in in_the_sources().items() if key not in NO_TOLERANCES}
    assert in_the_docs() == sources


def test_the_functions_that_the_page_names_exist() -> None:
    text = (REPOSITORY / "docs" / "engine.md").read_text(encoding="utf-8")
    by_stem = {path.stem: name for name, path in modules().items()}
    named = NAME.findall(text)
    assert len(named) > 20
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


@pytest.mark.parametrize(
    ("told", "number"), [("8 u", 2.0**-50), ("2^-3", 0.125), ("1e-8", 1e-8), ("0.499", 0.499)]
)
def test_numbers_are_read_as_they_are_told(told: str, number: float) -> None:
    assert number_of(told) == number
