"""The cached surfaces of the car: the same as built, and built again when the file is no good."""

import re
from pathlib import Path

import numpy as np
import pytest

from riglens.core.rig.model import Vehicle
from riglens.core.vehicle import body
from riglens.core.vehicle import store as body_store
from riglens.core.vehicle.body import arch_walls, body_parts
from riglens.core.vehicle.store import stored_surfaces
from riglens.core.vehicle.surface import NO_SURFACE, Surface, superellipsoid


@pytest.fixture
def folder(tmp_path, monkeypatch):
    monkeypatch.setenv("RIGLENS_CACHE_DIR", str(tmp_path / "cache"))
    return tmp_path / "cache"


class Workshop:
    """Builds two surfaces and an empty one, and counts how often."""

    def __init__(self) -> None:
        self.built = 0

    def __call__(self) -> list[tuple[str, Surface]]:
        self.built += 1
        paint, glass = superellipsoid((2.0, 1.0, 0.5), 0.6), superellipsoid((1.0, 0.8, 0.4), 0.9, samples=8)
        return [("paint", paint), ("trim", NO_SURFACE), ("glass", glass)]


def assert_same(found, expected):
    assert np.array_equal(found.points, expected.points)
    assert np.array_equal(found.triangles, expected.triangles)
    assert np.array_equal(found.normals, expected.normals)


def assert_as_built(painted):
    built = [(material, mesh) for material, mesh in Workshop()() if len(mesh.triangles)]
    assert [material for material, _ in painted] == [material for material, _ in built]
    for (_, found), (_, expected) in zip(painted, built, strict=True):
        assert_same(found, expected)


def test_the_second_start_builds_nothing_and_gets_the_same_surfaces(folder):
    build = Workshop()
    assert_as_built(stored_surfaces("sedan", build))
    assert_as_built(stored_surfaces("sedan", build))
    assert build.built == 1


def test_surfaces_of_other_code_are_built_again(folder, monkeypatch):
    build = Workshop()
    stored_surfaces("sedan", build)
    monkeypatch.setattr(body_store, "_MADE_BY", ("body.py", "profile.py"))
    assert_as_built(stored_surfaces("sedan", build))
    monkeypatch.setattr(body_store, "BODIES", Path(__file__))
    assert_as_built(stored_surfaces("sedan", build))
    assert build.built == 3


def test_surfaces_of_something_else_are_built_again(folder):
    build = Workshop()
    for of in ("a short car", "a long car", "a long car"):
        assert_as_built(stored_surfaces("finished", build, of=of))
    assert build.built == 2


@pytest.mark.parametrize("name", ["sedan", "suv", "van", "truck"])
def test_a_car_from_the_cache_is_the_one_that_was_built(folder, name):
    vehicle = Vehicle(body=name, length=4.9)
    built, found = (_fresh(vehicle) for _ in range(2))
    assert [material for material, _ in found] == [material for material, _ in built]
    for (_, one), (_, other) in zip(found, built, strict=True):
        assert_same(one, other)


def _fresh(vehicle):
    """As in a process that has drawn no car yet."""
    body._kept.cache_clear()
    (walls,) = arch_walls(vehicle)
    return [*body_parts(vehicle), ("walls", walls)]


def test_a_change_of_the_surfaces_does_not_reach_the_cache(folder):
    build = Workshop()
    for _ in range(2):
        painted = stored_surfaces("sedan", build)
        assert_as_built(painted)
        painted[0][1].points[:] *= 2.0


FOLDER = Path(body.__file__).resolve().parent
KEEPS_ONLY = {"store.py"}
"""This keeps surfaces, but does not decide their shape."""


def sources_of(path: str) -> set[str]:
    """The modules of the room that a module needs, itself among them."""
    found, wanted = set(), {path}
    while wanted:
        path = wanted.pop()
        found.add(path)
        names = re.findall(
            r"^from riglens\.core\.vehicle\.(\S+) import", (FOLDER / path).read_text(encoding="utf-8"), re.M
        )
        wanted |= {f"{name}.py" for name in names} - found - KEEPS_ONLY
    return found


def test_the_cache_follows_every_source_that_shapes_the_car():
    assert set(body_store._MADE_BY) == sources_of("body.py")
