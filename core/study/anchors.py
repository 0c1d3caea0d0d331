"""Published experiments with fewer beams, narrower fields, cameras added and lost: the facts, each with its source.

An anchor states the ratio of average precision after a change of the sensors to that before. Rigs stand for the
sensors; where sensors were lost at random, several rigs with their chances do.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cache
from itertools import combinations
from math import comb
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from riglens.core.rig.model import Lidar, LinearAngles, Rig
from riglens.core.rig.presets import PAPER_CAMERA_GROUPS, PAPER_LIDAR_GROUPS, preset
from riglens.core.scene.boxes import CLASSES
from riglens.core.study.table2 import icra

Doubles = NDArray[np.float64]
Recording = Literal["nuscenes", "kitti"]
Mix = tuple[tuple[float, Rig], ...]
"""Rigs with the chance of each."""

BEAMS, FUSED, LOST, ALONE, NARROW, FAILS = GROUPS = (
    "LiDAR beams left out",
    "LiDARs with cameras",
    "cameras lost beside a LiDAR",
    "cameras lost, cameras alone",
    "narrow cameras against wide ones",
    "known not to hold",
)
WITHIN_M: dict[Recording, float] = {"nuscenes": 50.0, "kitti": 60.0}
"""Distance from the car up to which objects count, for every figure: about the ranges of the benchmarks."""
_RIGS: dict[Recording, str] = {"nuscenes": "nuScenes car", "kitti": "KITTI car"}
_CLASSES: dict[Recording, tuple[str, ...]] = {"nuscenes": CLASSES, "kitti": ("car",)}
TEN = 10


@dataclass(frozen=True)
class Anchor:
    """Change of sensors on a recording, and average precision (or the ratio alone, with `full` 1) before and after as
    the source reports it; `figure`: the one whose ratio is judged; `only`: a class where it is of one alone; `fails`:
    why it is known not to hold, where it is."""

    name: str
    group: str
    recording: Recording
    before: Mix
    after: Mix
    full: float
    reduced: float
    detector: str
    source: str
    figure: str = "predicted"
    only: str = ""
    fails: str = ""

    @property
    def published(self) -> float:
        """The ratio of average precision that the source reports."""
        return self.reduced / self.full

    @property
    def classes(self) -> tuple[str, ...]:
        """Classes that average precision is of."""
        return (self.only,) if self.only else _CLASSES[self.recording]

    @property
    def region(self) -> str:
        """The objects that count, in words."""
        who = "all" if self.classes == CLASSES else ", ".join(f"{name}s" for name in self.classes)
        return f"{who} within {WITHIN_M[self.recording]:g} m"


# ---------------------------------------------------------------- rigs


def whole_lidar(recording: Recording) -> Lidar:
    """Return the LiDAR of a recording's car."""
    (lidar,) = preset(_RIGS[recording]).enabled_lidars()
    return lidar


def with_sensors(recording: Recording, lidars: Sequence[Lidar], cameras: Sequence[str] = ()) -> Rig:
    """Return the recording's rig with these LiDARs and its cameras of these names."""
    rig = preset(_RIGS[recording])
    kept = [one for one in rig.enabled_cameras() if one.name in cameras]
    return rig.replace(sensors=(*lidars, *kept))


def kept_beams(
    lidar: Lidar, beams: Sequence[int] | None, azimuth_step: int = 1, kept: float = 1.0, sweeps: int = 1
) -> tuple[Lidar, ...]:
    """Return a LiDAR that keeps the beams of these numbers, counted from the top beginning with 0 (None: all), every
    `azimuth_step`-th azimuth, and a share `kept` of its rays at random, in some sweeps of a standing scene, each with a
    spin phase and, at random, rays of its own."""
    turn, count = lidar.azimuths_deg, lidar.beam_count
    assert isinstance(turn, LinearAngles)
    places = range(count) if beams is None else [count - 1 - beam for beam in reversed(beams)]
    coarser = LinearAngles(from_=turn.from_, to=turn.to, count=turn.count // azimuth_step)
    sweep = [_with_beams(lidar, places).replace(azimuths_deg=coarser)]
    sensors: list[Lidar] = []
    rng = np.random.default_rng(0)
    for number in range(sweeps):
        if kept < 1.0:
            sweep = list(_thinned(lidar, places, coarser.open_end_deg(), kept, rng))
        sensors += [one.replace(name=f"{one.name} {number}") for one in sweep]
    return tuple(sensors)


def _thinned(
    lidar: Lidar, places: Sequence[int], azimuths_deg: Doubles, kept: float, rng: np.random.Generator
) -> Iterator[Lidar]:
    """Yield LiDARs of two beams each, which keep a share of the azimuths, drawn for each of them."""
    for first in range(0, len(places), 2):
        chosen = azimuths_deg[rng.random(len(azimuths_deg)) < kept]
        beams = _with_beams(lidar, places[first : first + 2])
        yield beams.replace(azimuths_deg=tuple(chosen.tolist()), name=f"{lidar.name} {first}")


def _with_beams(lidar: Lidar, places: Sequence[int]) -> Lidar:
    offsets = lidar.azimuth_offsets_deg
    return lidar.replace(
        elevations_deg=tuple(lidar.elevations()[list(places)].tolist()),
        azimuth_offsets_deg=None if offsets is None else tuple(offsets[place] for place in places),
    )


def cut_to(lidar: Lidar, field_deg: float) -> Lidar:
    """Return a LiDAR of which the azimuths in a field around straight ahead are left."""
    turn = lidar.azimuths_deg
    assert isinstance(turn, LinearAngles)
    azimuths = turn.open_end_deg()
    ahead = (azimuths + lidar.rpy_deg[2] + 180.0) % 360.0 - 180.0
    return lidar.replace(azimuths_deg=tuple(azimuths[np.abs(ahead) <= field_deg / 2.0].tolist()))


def lost(names: Sequence[str], draws: int) -> Iterator[tuple[float, tuple[str, ...]]]:
    """Yield the sets of names that are left with their chances, where a name is lost in each of some draws with
    replacement."""
    for size in range(1, min(draws, len(names)) + 1):
        # ways to draw each of `size` names at least once
        ways = sum((-1) ** k * comb(size, k) * (size - k) ** draws for k in range(size + 1))
        for gone in combinations(names, size):
            yield ways / len(names) ** draws, tuple(name for name in names if name not in gone)


# ---------------------------------------------------------------- anchors


def _one(rig: Rig) -> Mix:
    return ((1.0, rig),)


_FUTR3D = "arXiv 2203.10642; table of github.com/Tsinghua-MARS-Lab/futr3d"
_DISTILLED = (
    "PointPillars: car AP in 3D, moderate",
    "arXiv 2203.14956, table of github.com/weiyithu/LiDAR-Distillation; 64 beams: model zoo of OpenPCDet",
)
_CORRUPTED = (
    "TransFusion, LiDAR and cameras, ten sweeps: NDS",
    "arXiv 2402.11677, table of github.com/ika-rwth-aachen/MultiCorrupt: mean over three severities",
)
_ADLAB = "table of github.com/ADLab-AutoDrive/BEVFusion"
_ROBOBEV = "arXiv 2304.06719, tables of github.com/Daniel-xsy/RoboBEV"
_KITTI_FULL = 77.28
_FOUR: Sequence[int] = (7, 9, 11, 13)
_ONE: Sequence[int] = (9,)
_UNTRAINED = "not trained on the reduced data"
_SWEEPS = "ten sweeps of a standing scene, while real objects move"
_KITTI_BEAMS: tuple[tuple[str, int, int, float, float], ...] = (
    ("64 to 32 beams", 2, 1, 70.15, 65.91),
    ("64 to 32, half the azimuths", 2, 2, 66.96, 57.77),
    ("64 to 16 beams", 4, 1, 59.87, 47.48),
    ("64 to 16, half the azimuths", 4, 2, 55.24, 38.75),
)
"""Name, steps of beams and azimuths, average precision of detectors trained on it, and on the whole."""
_FUSIONS: tuple[tuple[str, float, float, str, str], ...] = (
    ("BEVFusion (MIT)", 64.68, 68.39, "github.com/mit-han-lab/bevfusion", ""),
    ("PointPillars, BEVFusion (ADLab)", 35.1, 53.5, _ADLAB, "a head that finds little with LiDARs alone"),
    ("CenterPoint, BEVFusion (ADLab)", 57.1, 64.2, _ADLAB, ""),
    ("TransFusion, BEVFusion (ADLab)", 64.9, 67.9, _ADLAB, ""),
    ("MetaBEV, TransFusion", 62.5, 68.0, "github.com/ChongjianGE/MetaBEV", ""),
    ("UniBEV", 58.2, 64.2, "arXiv 2309.14516; from memory, their mean checked", ""),
    ("FUTR3D, 32 beams", 63.3, 67.4, _FUTR3D, ""),
    ("BEVFusion (Kumar et al.)", 64.7, 68.5, "arXiv 2511.04347", ""),
)
"""mAP with a LiDAR alone and with cameras too."""
_CUT: tuple[tuple[str, float, float, float, float], ...] = (
    ("PointPillars", 53.5, 33.5, 36.8, 41.6),
    ("CenterPoint", 64.2, 40.9, 45.5, 54.0),
    ("TransFusion", 67.9, 41.5, 46.4, 50.3),
)
"""Head, mAP with cameras of the whole LiDAR, of 120 and 180 degrees of it, and with half of the objects without
points."""
_CRASH_FUSED = (0.6852, 0.6667, 0.6511, 0.6398)
_CRASH_ALONE = (1.0, 0.533, 0.252, 0.234)
"""With all cameras and after 2, 4 and 5 draws: mAP of BEVFusion, and the mean ratio of twelve detectors of pictures."""
_DRAWS = (2, 4, 5)
_PICTURES: tuple[tuple[str, float, float, str], ...] = (
    ("PETR, 1600 to 800 px", 40.4, 37.8, "github.com/megvii-research/PETR"),
    ("PETR, 1408 to 704 px", 31.7, 30.9, "github.com/exiawsh/StreamPETR"),
    ("BEVFormer, 1600 to 1280 px", 41.6, 37.0, "github.com/fundamentalvision/BEVFormer"),
)
_SMALLER = "picture size does not count once an object is visible"


@cache
def anchors(recording: Recording) -> tuple[Anchor, ...]:
    """Return the anchors of a recording, group by group."""
    found = [*_on_kitti()] if recording == "kitti" else [*_on_nuscenes()]
    return tuple(sorted(found, key=lambda one: GROUPS.index(one.group)))


def _on_kitti() -> Iterator[Anchor]:
    lidar = whole_lidar("kitti")
    before = _one(with_sensors("kitti", kept_beams(lidar, None)))
    for name, step, turn, trained, untrained in _KITTI_BEAMS:
        reduced = kept_beams(lidar, range(0, lidar.beam_count, step), turn)
        after = _one(with_sensors("kitti", reduced))
        one = Anchor(name, BEAMS, "kitti", before, after, _KITTI_FULL, trained, *_DISTILLED)
        yield one
        yield replace(one, name=f"{name}, not retrained", group=FAILS, reduced=untrained, fails=_UNTRAINED)


def _on_nuscenes() -> Iterator[Anchor]:
    yield from _beams()
    yield from _fusions()
    yield from _cameras_lost()
    yield from _narrow()


def _beams() -> Iterator[Anchor]:
    lidar = whole_lidar("nuscenes")
    alone = "FUTR3D, LiDAR alone, ten sweeps: mAP", _FUTR3D
    for sweeps in (1, TEN):
        before = _one(with_sensors("nuscenes", kept_beams(lidar, None, sweeps=sweeps)))
        words = ", ten sweeps" if sweeps > 1 else ""
        for name, few, ap in (("32 to 4 beams", _FOUR, 44.3), ("32 to 1 beam", _ONE, 16.9)):
            after = _one(with_sensors("nuscenes", kept_beams(lidar, few, sweeps=sweeps)))
            group, fails = (FAILS, _SWEEPS) if sweeps > 1 else (BEAMS, "")
            yield Anchor(f"{name}{words}", group, "nuscenes", before, after, 63.3, ap, *alone, fails=fails)
        corrupted: tuple[tuple[str, Sequence[int] | None, float, float], ...] = (
            ("a fifth of the points at random", None, 0.2, 0.969),
            ("32 to 8 beams, not retrained", tuple(range(1, 32, 4)), 1.0, 0.633),
        )
        for name, beams, kept, ratio in corrupted:
            after = _one(with_sensors("nuscenes", kept_beams(lidar, beams, kept=kept, sweeps=sweeps)))
            yield Anchor(
                f"{name}{words}", FAILS, "nuscenes", before, after, 1.0, ratio, *_CORRUPTED, fails=_UNTRAINED
            )


def _names() -> tuple[str, ...]:
    return tuple(one.name for one in preset(_RIGS["nuscenes"]).enabled_cameras())


def _fusions() -> Iterator[Anchor]:
    lidar, names = whole_lidar("nuscenes"), _names()
    alone, both = with_sensors("nuscenes", (lidar,)), with_sensors("nuscenes", (lidar,), names)
    before, after = _one(alone), _one(both)
    for detector, by_lidar, by_both, source, fails in _FUSIONS:
        name, said = f"cameras added: {detector}", f"{detector}: mAP"
        yield Anchor(name, FUSED, "nuscenes", before, after, by_lidar, by_both, said, source, fails=fails)
    four = _one(with_sensors("nuscenes", kept_beams(lidar, _FOUR), names))
    said = "FUTR3D with cameras: mAP"
    yield Anchor("32 to 4 beams with cameras", FUSED, "nuscenes", after, four, 67.4, 58.0, said, _FUTR3D)
    pictures = with_sensors("nuscenes", (), names)
    for head, full, of_120, of_180, half in _CUT:
        said = f"{head}, BEVFusion (ADLab): mAP"
        for field_deg, ap in ((120.0, of_120), (180.0, of_180)):
            cut = _one(with_sensors("nuscenes", (cut_to(lidar, field_deg),), names))
            name = f"LiDAR cut to {field_deg:g}°, with cameras: {head}"
            yield Anchor(name, FUSED, "nuscenes", after, cut, full, ap, said, _ADLAB)
        yield Anchor(
            f"half of the objects without points: {head}", FAILS, "nuscenes", _one(both),
            ((0.5, both), (0.5, pictures)), full, half, said, _ADLAB,
            fails="no rig: points of whole objects are taken away, and the detector is trained on it",
        )  # fmt: skip
    for name, full, ap, source in _PICTURES:
        yield Anchor(
            name, FAILS, "nuscenes", _one(pictures), _one(_with_fewer_pixels(pictures)), full, ap,
            "cameras alone: mAP", source, fails=_SMALLER,
        )  # fmt: skip


def _with_fewer_pixels(rig: Rig) -> Rig:
    """Return a rig whose cameras have half as many columns and rows."""
    halved = []
    for one in rig.enabled_cameras():
        width_px, height_px = one.image
        lens = {name: (getattr(one, name) or 0.0) / 2.0 for name in ("fx", "fy", "cx", "cy")}
        wide = {} if one.hfov_deg is not None else lens
        halved.append(one.replace(image=(width_px // 2, height_px // 2), cast=None, **wide))
    return rig.replace(sensors=tuple(halved))


def _cameras_lost() -> Iterator[Anchor]:
    lidar, names = whole_lidar("nuscenes"), _names()
    for group, lidars, published, detector in (
        (LOST, (lidar,), _CRASH_FUSED, "BEVFusion, not retrained: mAP"),
        (ALONE, (), _CRASH_ALONE, "mean of twelve detectors of pictures, not retrained: mAP"),
    ):
        before = _one(with_sensors("nuscenes", lidars, names))
        for draws, ap in zip(_DRAWS, published[1:], strict=True):
            after = tuple(
                (share, with_sensors("nuscenes", lidars, left)) for share, left in lost(names, draws)
            )
            name = f"{draws} draws of lost cameras" + ("" if lidars else ", cameras alone")
            yield Anchor(name, group, "nuscenes", before, after, published[0], ap, detector, _ROBOBEV)


def _narrow() -> Iterator[Anchor]:
    """Yield the paper's Table II, mean of four LiDAR groups and four detectors."""
    paper, groups = icra(), PAPER_LIDAR_GROUPS
    wide, narrow = (
        tuple((1.0 / len(groups), preset(f"{cameras[0]}+{lidars[0]}")) for lidars in groups)
        for cameras in PAPER_CAMERA_GROUPS
    )
    for cls in CLASSES:
        ap = paper.of(cls).mean(axis=0)
        yield Anchor(
            f"narrow for wide cameras, {cls}", NARROW, "nuscenes", wide, narrow,
            float(ap[: len(groups)].mean()), float(ap[len(groups) :].mean()), "mean of four detectors: AP",
            "arXiv 2310.05245, Table II", figure="seen_by_cameras", only=cls,
        )  # fmt: skip
