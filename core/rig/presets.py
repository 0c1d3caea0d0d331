"""Built-in rigs by name: those of the paper ("W+T", "Narrow+Pyramid-roll", "Center"), and cars of public data sets."""

from __future__ import annotations

import difflib
import math
from dataclasses import dataclass
from functools import lru_cache

from riglens.assets import asset_path
from riglens.core.errors import InputError
from riglens.core.geometry import Vec3
from riglens.core.rig.model import Camera, Lidar, LinearAngles, Rig, Sensor
from riglens.core.rig.yaml.nodes import shortened

_OUTER_ROLL_DEG = math.degrees(0.28)
_FRONT_PITCH_DEG = math.degrees(-0.09)

_PYRAMID: tuple[Vec3, ...] = ((-0.2, -0.6, 2.2), (0.4, 0.0, 2.4), (-0.2, 0.0, 2.6), (-0.2, 0.6, 2.2))
_LINE: tuple[Vec3, ...] = ((0.0, -0.6, 2.2), (0.0, -0.4, 2.2), (0.0, 0.4, 2.2), (0.0, 0.6, 2.2))
_UPRIGHT: tuple[Vec3, ...] = ((0.0, 0.0, 0.0),) * 4
_OUTER_TWO_ROLLED: tuple[Vec3, ...] = (
    (-_OUTER_ROLL_DEG, 0.0, 0.0),
    (0.0, 0.0, 0.0),
    (0.0, 0.0, 0.0),
    (_OUTER_ROLL_DEG, 0.0, 0.0),
)


@dataclass(frozen=True)
class Group:
    """Sensors that the paper names together: their name, its letters in names of rigs, and who describes them."""

    name: str
    letters: str
    sensors: tuple[Sensor, ...]
    origin: str = "paper"


def _lidars(positions_m: tuple[Vec3, ...], rpy_deg: tuple[Vec3, ...] = _UPRIGHT) -> tuple[Lidar, ...]:
    """Return LIDAR_1 to LIDAR_4 in the order of the paper, 16 beams over [-25, 25] degrees, 360 azimuths."""
    return tuple(
        Lidar(
            name=f"LIDAR_{number}",
            model="generic-16",
            position=position_m,
            rpy_deg=turn,
            elevations_deg=LinearAngles(from_=-25.0, to=25.0, count=16),
            azimuths_deg=LinearAngles(from_=-180.0, to=180.0, count=360),
        )
        for number, (position_m, turn) in enumerate(zip(positions_m, rpy_deg, strict=True), 1)
    )


def _cameras(hfov_deg: float, back_hfov_deg: float) -> tuple[Camera, ...]:
    """Return CAM_FRONT and so on around the car, 1600 x 900 pixels, 352 x 128 rays each."""
    return tuple(
        Camera(
            name=name,
            position=(x_m, y_m, 1.8),
            rpy_deg=(0.0, 0.0, yaw_deg),
            image=(1600, 900),
            hfov_deg=back_hfov_deg if name == "CAM_BACK" else hfov_deg,
            cast=(352, 128),
        )
        for name, x_m, y_m, yaw_deg in _CAMERA_PLACES
    )


_CAMERA_PLACES = (
    ("CAM_FRONT", 0.5, 0.0, 0.0),
    ("CAM_FRONT_LEFT", 0.0, 0.5, 55.0),
    ("CAM_BACK_LEFT", -0.5, 0.5, 110.0),
    ("CAM_BACK", -1.5, 0.0, 180.0),
    ("CAM_BACK_RIGHT", -0.5, -0.5, -110.0),
    ("CAM_FRONT_RIGHT", 0.0, -0.5, -55.0),
)

CAMERA_GROUPS = (Group("Wide", "W", _cameras(70.0, 110.0)), Group("Narrow", "N", _cameras(55.0, 55.0)))

_CENTER: tuple[Vec3, ...] = ((0.0, 0.0, 2.4), (0.0, 0.0, 2.6), (0.0, 0.0, 2.8), (0.0, 0.0, 3.0))
_TRAPEZOID: tuple[Vec3, ...] = ((-0.4, 0.2, 2.2), (-0.4, -0.2, 2.2), (0.2, 0.5, 2.2), (0.2, -0.5, 2.2))
_SQUARE: tuple[Vec3, ...] = ((-0.5, 0.5, 2.2), (-0.5, -0.5, 2.2), (0.5, 0.5, 2.2), (0.5, -0.5, 2.2))
_SECOND_PITCHED: tuple[Vec3, ...] = (
    (0.0, 0.0, 0.0),
    (0.0, _FRONT_PITCH_DEG, 0.0),
    (0.0, 0.0, 0.0),
    (0.0, 0.0, 0.0),
)
LIDAR_GROUPS = (
    Group("Center", "C", _lidars(_CENTER)),
    Group("Pyramid", "P", _lidars(_PYRAMID)),
    Group("Line", "L", _lidars(_LINE)),
    Group("Trapezoid", "T", _lidars(_TRAPEZOID)),
    Group("Square", "S", _lidars(_SQUARE), "published code"),
    Group("Line-roll", "LR", _lidars(_LINE, _OUTER_TWO_ROLLED), "published code"),
    Group("Pyramid-roll", "PR", _lidars(_PYRAMID, _OUTER_TWO_ROLLED), "published code"),
    Group("Pyramid-pitch", "PP", _lidars(_PYRAMID, _SECOND_PITCHED), "published code"),
)

PAPER_LIDAR_GROUPS = tuple(group.name for group in LIDAR_GROUPS if group.origin == "paper")
PAPER_CAMERA_GROUPS = tuple(group.name for group in CAMERA_GROUPS)


@dataclass(frozen=True)
class Preset:
    """A built-in rig: its name, one line about it, and the groups of sensors it has or the file it is in."""

    name: str
    description: str
    cameras: Group | None = None
    lidars: Group | None = None
    file: str = ""

    @property
    def title(self) -> str:
        """Return the name in words, with the short name where that is another: "Wide + Trapezoid (W+T)"."""
        words = " + ".join(group.name for group in (self.cameras, self.lidars) if group)
        return f"{words} ({self.name})" if words not in ("", self.name) else self.name

    def rig(self) -> Rig:
        """Return the rig: that of the file, or one on the default vehicle, cameras first, then LiDARs.

        The paper's rigs are scored as in the paper, with rays that pass through the car.
        """
        if self.file:
            return _rig_in(self.file)
        groups = (group for group in (self.cameras, self.lidars) if group)
        sensors = tuple(sensor for group in groups for sensor in group.sensors)
        return Rig(name=self.name, self_occlusion=False, sensors=sensors)


def _all_presets() -> tuple[Preset, ...]:
    paper = [group for group in LIDAR_GROUPS if group.origin == "paper"]
    code_only = [group for group in LIDAR_GROUPS if group.origin != "paper"]
    rigs = [
        _pair(cameras, lidars) for lot in (paper, code_only) for cameras in CAMERA_GROUPS for lidars in lot
    ]
    lidar_only = [Preset(g.name, f"4 LiDARs {g.name} alone ({g.origin})", lidars=g) for g in LIDAR_GROUPS]
    camera_only = [Preset(g.name, f"6 cameras {g.name} alone ({g.origin})", cameras=g) for g in CAMERA_GROUPS]
    return (*CARS, *rigs, *lidar_only, *camera_only)


CARS = (
    Preset("nuScenes car", "6 cameras + 1 LiDAR, a Renault Zoe of nuScenes", file="nuscenes.yaml"),
    Preset("KITTI car", "4 cameras + 1 LiDAR, the VW Passat of KITTI", file="kitti.yaml"),
    Preset("PandaSet car", "6 cameras + 2 LiDARs, a Chrysler Pacifica of PandaSet", file="pandaset.yaml"),
    Preset("Argoverse 2 car", "9 cameras + 2 LiDARs, a Ford Fusion of Argoverse 2", file="argoverse2.yaml"),
    Preset(
        "Waymo car", "5 cameras + 5 LiDARs, a Chrysler Pacifica of the Waymo Open Dataset", file="waymo.yaml"
    ),
    Preset(
        "nuScenes car with radars",
        "6 cameras + 1 LiDAR + 5 radars, the car of nuScenes with all its sensors",
        file="nuscenes-radars.yaml",
    ),
    Preset(
        "production car",
        "6 cameras + 5 radars + 12 ultrasonic sensors + 1 LiDAR, as in production cars",
        file="production.yaml",
    ),
)
"""Cars as their public calibrations describe them; the files name their sources."""


@lru_cache(maxsize=len(CARS))
def _rig_in(file: str) -> Rig:
    # imported late: the paper's rigs need no YAML, and reading it brings the sensor library
    from riglens.core.rig.yaml.file import loads

    return loads(asset_path("rigs", file).read_text(encoding="utf-8"), file).rig


def _pair(cameras: Group, lidars: Group) -> Preset:
    text = f"6 cameras {cameras.name} + 4 LiDARs {lidars.name} ({lidars.origin})"
    return Preset(f"{cameras.letters}+{lidars.letters}", text, cameras, lidars)


PRESETS = {preset.name: preset for preset in _all_presets()}
"""Every preset by its name, in the order in which they are listed: cars, then the rigs of the paper."""

PAPER_RIGS = tuple(
    name for name, p in PRESETS.items() if p.cameras and p.lidars and p.lidars.origin == "paper"
)


def preset(name: str) -> Rig:
    """Return the built-in rig of that name, in any case, in letters ("W+T") or words ("wide+trapezoid").

    Raise InputError that names the nearest presets when there is none.
    """
    found = find_preset(name)
    if found is None:
        close = close_presets(name)
        hint = f"did you mean {' or '.join(close)}?; " if close else ""
        raise InputError(f"unknown preset '{shortened(name)}' ({hint}known: {', '.join(PRESETS)})")
    return found.rig()


def find_preset(name: str) -> Preset | None:
    """Return the preset of that name or spelling, None when there is none."""
    known = _spellings().get(_plain(name))
    return PRESETS[known] if known else None


def close_presets(name: str) -> list[str]:
    """Return the presets whose names are nearest to a misspelt one."""
    spellings = difflib.get_close_matches(_plain(name), _spellings(), n=3, cutoff=0.5)
    return list(dict.fromkeys(_spellings()[spelling] for spelling in spellings))


def _plain(name: str) -> str:
    return name.strip().casefold().replace("_", "-").replace(" ", "").replace("centre", "center")


def _spellings() -> dict[str, str]:
    """Return every accepted spelling and its preset."""
    spellings: dict[str, str] = {}
    for name, found in PRESETS.items():
        spellings[_plain(name)] = name
        if found.cameras and found.lidars:
            spellings[_plain(f"{found.cameras.name}+{found.lidars.name}")] = name
    return spellings
