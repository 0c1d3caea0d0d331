"""Return mounts as plain data: metres, and violations in words."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from riglens.core.plain import to_plain
from riglens.core.review.mounts import Mount, Violation
from riglens.core.rig.model import FORMAT_VERSION, Rig
from riglens.core.rig.yaml.file import identity_of


def mounts_document(rig: Rig, mounts: Sequence[Mount], found: Sequence[Violation]) -> dict[str, Any]:
    """Return the mounts of a rig's enabled sensors; null: no body or no neighbour to measure to."""
    return {
        "riglens": FORMAT_VERSION,
        "rig": identity_of(rig),
        "mounts": [_mount(mount) for mount in mounts],
        "violations": to_plain(list(found)),
    }


def _mount(mount: Mount) -> dict[str, Any]:
    stand = mount.stand
    return {
        "name": mount.name,
        "height_m": mount.height_m,
        "gap_m": None if stand.nearest_m is None else stand.gap_m,
        "neighbour": mount.neighbour,
        "neighbour_m": None if mount.neighbour is None else mount.neighbour_m,
        "beyond_m": to_plain(mount.beyond_m),
        "materials": sorted(mount.materials),
        "zones": list(mount.zones),
    }
