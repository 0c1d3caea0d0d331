"""The rigs and protocols of the third study, docs/study-detection-3.md: drawn by a stated seed before it ran.

LiDARs and cameras are seen by two detectors that know nothing of each other; `fusing` joins what they find, so that
every set of LiDARs meets every set of cameras without another net.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Literal

import numpy as np

from riglens.core.rig.model import Camera, Rig
from riglens.core.rig.presets import preset
from riglens.core.simulate.settings import SimulationSettings
from riglens.core.study.detection.protocol import Protocol
from riglens.core.study.detection.second import MOUNTS, Place, rig_of, second_rigs

SEED = 20261128
"""Of the draw of rigs."""
FUSED = 8
"""LiDAR rigs that meet the sets of cameras, drawn from those of the second study."""
_ROOF_4, _CORNERS_4 = MOUNTS[4]
_ROOF_1, _ROOF_2 = MOUNTS[1][0], MOUNTS[2][0]
_DENSE: tuple[tuple[tuple[str, ...], tuple[Place, ...]], ...] = (
    (("hesai-ot128",), _ROOF_1),
    (("hesai-xt32",) * 4, _ROOF_4),
    (("ouster-os1-128-rev7",) * 2, _ROOF_2),
    (("hesai-qt128",) * 4, _CORNERS_4),
    (("hesai-ot128",) * 2, _ROOF_2),
    (("ouster-os0-128",) * 4, _CORNERS_4),
    (("robosense-ruby-plus", *("hesai-jt128",) * 4), (*_ROOF_1, *_CORNERS_4)),
    (("velodyne-vls-128",) * 4, _ROOF_4),
)
"""Rigs of more rays than any before, from 230,400 to 960,512: our choice."""

Part = Literal["lidars", "cameras"]
PROTOCOL = Protocol(
    seeds=1,
    epochs=4,
    train_frames=150,
    test_frames=140,
    simulation=SimulationSettings(clutter=120, body="blocks"),
)
PARTS: dict[Part, Protocol] = {
    "lidars": PROTOCOL,
    "cameras": replace(PROTOCOL, detector="pictures", epochs=8, train_frames=100),
}
"""Parts of the study, in the order in which they run."""
_FRONT = ("CAM_FRONT", "CAM_FRONT_LEFT", "CAM_FRONT_RIGHT")
CAMERA_SETS: dict[str, tuple[str, tuple[str, ...] | None]] = {
    "3 front": ("Wide", _FRONT),
    "6 surround": ("Wide", None),
    "6 narrow": ("Narrow", None),
    "1 front": ("Wide", _FRONT[:1]),
    "front and rear": ("Wide", ("CAM_FRONT", "CAM_BACK")),
    "3 rear": ("Wide", ("CAM_BACK", "CAM_BACK_LEFT", "CAM_BACK_RIGHT")),
    "3 narrow front": ("Narrow", _FRONT),
    "no rear": ("Wide", (*_FRONT, "CAM_BACK_LEFT", "CAM_BACK_RIGHT")),
}
"""Cameras of the paper's groups; the first three meet LiDARs, all are judged alone."""
MEETING = tuple(CAMERA_SETS)[:3]


def rigs_of_part(part: Part) -> tuple[Rig, ...]:
    """Return the rigs of a part: of LiDARs alone, or of cameras alone."""
    if part == "lidars":
        return (*fused_lidars(), *dense_rigs())
    return tuple(Rig(name=name, self_occlusion=False, sensors=cameras_of(name)) for name in CAMERA_SETS)


def fused_lidars() -> tuple[Rig, ...]:
    """Return the LiDAR rigs that meet cameras, in the order of the second study."""
    rigs = second_rigs()
    drawn = np.random.default_rng(SEED).choice(len(rigs), FUSED, replace=False)
    return tuple(rigs[place] for place in sorted(drawn.tolist()))


def dense_rigs() -> tuple[Rig, ...]:
    """Return the rigs of many rays."""
    return tuple(
        rig_of(f"dense {number}", list(zip(models, places, strict=True)))
        for number, (models, places) in enumerate(_DENSE, 1)
    )


def cameras_of(name: str) -> tuple[Camera, ...]:
    """Return a set of cameras by its name."""
    group, names = CAMERA_SETS[name]
    cameras = preset(group).enabled_cameras()
    return tuple(one for one in cameras if names is None or one.name in names)


def with_cameras(lidars: Rig, name: str) -> Rig:
    """Return a LiDAR rig with a set of cameras."""
    both = (*lidars.sensors, *cameras_of(name))
    return lidars.model_copy(update={"name": f"{lidars.name}, {name}", "sensors": both})
