"""The car as rays meet it: triangles with their materials in a tree of boxes. Vehicle frame, metres."""

from __future__ import annotations

import hashlib
import threading
from collections.abc import Collection, Sequence
from dataclasses import dataclass, field
from functools import lru_cache
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray

from riglens.core.errors import InputError
from riglens.core.geometry import Pose
from riglens.core.rig.model import Vehicle
from riglens.core.sensors.registry import kind_of
from riglens.core.vehicle.body import body_parts
from riglens.core.vehicle.parts import parts_of_profile

if TYPE_CHECKING:
    from riglens.core.kernels.body.solid import Tree

MATERIALS = ("paint", "panel", "glass", "trim", "gap", "lamp", "tail", "plate", "tyre", "rim", "dark")
"""Materials of triangles; the number of a material is its index."""
GLASS = MATERIALS.index("glass")
_FINDING = threading.Lock()


def solid_of(vehicle: Vehicle, stance: Pose = Pose()) -> Solid:
    """Return the solid of a car's body; InputError where its mesh file has not been read.

    `stance` is the pose of the car in the frame of its triangles, where that is not its own.
    """
    if vehicle.lacks_mesh:
        raise InputError(f"vehicle.body: the mesh '{vehicle.body}' has not been read")
    with _FINDING:
        making = _making(vehicle)
    # threads that open a car ask for the same solid at once; that of another car is not waited for
    with making:
        solid = _solid(vehicle)
    return solid if stance == Pose() else _standing(solid, stance)


@dataclass(frozen=True)
class Housing:
    """Housing of a sensor: a box with its middle at the sensor, or the upright cylinder in it, within a ball of
    `radius_m`."""

    name: str
    pose: Pose
    half_m: tuple[float, float, float]
    is_round: bool
    radius_m: float


@dataclass(frozen=True)
class Solid:
    """Triangles triangles_m (t, 3, 3) with materials (t,), numbers in MATERIALS, and parts (t,), numbers in PARTS, in a
    tree of boxes.

    Two solids with the same `fingerprint` are equal: they stop the same rays at the same places. With `housings`,
    `owners` (t,) is the place in them of each triangle, and their number for the triangles of the body, `body`.
    """

    triangles_m: NDArray[np.float64] = field(compare=False, repr=False)
    materials: NDArray[np.uint8] = field(compare=False, repr=False)
    parts: NDArray[np.uint8] = field(compare=False, repr=False)
    tree: Tree = field(compare=False, repr=False)
    fingerprint: str
    housings: tuple[Housing, ...] = ()
    owners: NDArray[np.int64] = field(
        default_factory=lambda: np.zeros(0, np.int64), compare=False, repr=False
    )
    body: str = ""
    """Fingerprint of the same without housings, where it has any."""

    @classmethod
    def of(
        cls,
        triangles_m: NDArray[np.floating],
        materials: NDArray[np.integer] | None = None,
        parts: NDArray[np.integer] | None = None,
    ) -> Solid:
        """Return the solid of triangles (t, 3, 3), of paint by default; triangles without an area are left out.

        No triangles at all is fine: nothing stops any ray.
        """
        corners = np.array(triangles_m, np.float64).reshape(-1, 3, 3)
        kinds = np.zeros(len(corners), np.uint8) if materials is None else np.asarray(materials, np.uint8)
        named = np.zeros(len(corners), np.uint8) if parts is None else np.asarray(parts, np.uint8)
        area = np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1)
        some = area > 0.0
        corners, kinds, named = np.ascontiguousarray(corners[some]), kinds[some], named[some]
        digest = hashlib.sha256(corners.tobytes() + kinds.tobytes())
        return cls(corners, kinds, named, _tree(corners), digest.hexdigest())

    @property
    def names_parts(self) -> bool:
        """Return whether the body says which triangles are glass, doors and other parts."""
        return bool(self.parts.any())

    @property
    def count(self) -> int:
        """Number of triangles."""
        return len(self.triangles_m)

    def barrier(self, kind: str, start_m: float, among: Collection[Housing] = ()) -> Barrier:
        """Return the part that stops the rays of a kind of sensor beyond `start_m` from their origin: the body, and
        some of the housings."""
        is_clear = kind_of(kind).occlusion.sees_through_glass
        stops = np.asarray(self.materials != GLASS) if is_clear else np.ones(self.count, np.bool_)
        if self.housings:
            stops &= np.array([*(one in among for one in self.housings), True])[self.owners]
        return Barrier(self.tree, stops, start_m)


class Barrier(NamedTuple):
    """Obstacle of a sensor's rays: a tree of triangles, a selection of them (t,), and the distance from which they
    count."""

    tree: Tree
    stops: NDArray[np.bool_]
    start_m: float


def joined(solid: Solid, housings: tuple[Housing, ...], parts: Sequence[NDArray[np.float64]]) -> Solid:
    """Return a body with housings, of triangles (t, 3, 3) each."""
    owners = np.repeat(np.arange(len(housings)), [len(part) for part in parts])
    more = np.ascontiguousarray(np.concatenate(parts))
    digest = hashlib.sha256(repr((solid.fingerprint, housings)).encode()).hexdigest()
    return Solid(
        np.concatenate([solid.triangles_m, more]),
        np.concatenate([solid.materials, np.zeros(len(more), np.uint8)]),
        np.concatenate([solid.parts, np.zeros(len(more), np.uint8)]),
        _both(solid.tree, _tree(more)),
        digest,
        housings,
        np.concatenate([np.full(solid.count, len(housings)), owners]),
        solid.fingerprint,
    )


def _both(one: Tree, other: Tree) -> Tree:
    """Return a tree of two: a root above their nodes, and the triangles of the one before those of the other."""
    before, after = 1 + len(one.skip), 1 + len(one.skip) + len(other.skip)
    every = np.concatenate([one.bounds, other.bounds])
    root = np.concatenate([every[:, :3].min(axis=0), every[:, 3:].max(axis=0)])
    leaf = np.concatenate([np.zeros((1, 2), np.int64), one.leaf, other.leaf + np.array([len(one.number), 0])])
    skip = np.concatenate([[after], one.skip + 1, other.skip + before])
    number = np.concatenate([one.number, other.number + len(one.number)])
    corners = np.concatenate([one.corners, other.corners])
    return type(one)(corners, number, np.concatenate([root[None], every]), leaf, skip)


def _tree(corners: NDArray[np.float64]) -> Tree:
    from riglens.core.vehicle.tree import tree_of  # the compiler, only when a ray is to be stopped

    return tree_of(corners)


@lru_cache(maxsize=2)
def _standing(solid: Solid, stance: Pose) -> Solid:
    """Return the same solid, moved and turned."""
    return Solid.of(stance.transform(solid.triangles_m), solid.materials, solid.parts)


@lru_cache(maxsize=4)
def _making(vehicle: Vehicle) -> threading.Lock:
    """Return the lock that is held while the solid of a body is made."""
    return threading.Lock()


# 13 MB each: of a car that is edited, the one before, which the view still shows, the saved one
@lru_cache(maxsize=3)
def _solid(vehicle: Vehicle) -> Solid:
    """Return the same object for the same body, so that structures built from it are reused."""
    if vehicle.body_mesh is not None:
        placed = vehicle.body_mesh.placed(vehicle.mesh)
        return Solid.of(placed.points[placed.triangles], parts=placed.parts)
    parts = body_parts(vehicle)
    triangles = [surface.points[surface.triangles] for _, surface in parts]
    kinds = [np.full(len(t), MATERIALS.index(name)) for t, (name, _) in zip(triangles, parts, strict=True)]
    corners, materials = np.concatenate(triangles), np.concatenate(kinds)
    named = parts_of_profile(vehicle, corners.astype(np.float64), MATERIALS, materials)
    return Solid.of(corners, materials, named)
