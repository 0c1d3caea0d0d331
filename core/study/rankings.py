"""Orders of the paper's rigs by S-MS, and how much two orders agree."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from itertools import combinations

from riglens.core.engine.engine import Engine
from riglens.core.metric.entropy import EntropyField
from riglens.core.metric.scores import DEFAULT_LAMBDA, MetricSettings, Reading
from riglens.core.rig.model import Camera, EvenAngles, Lidar, Rig
from riglens.core.rig.presets import CAMERA_GROUPS, LIDAR_GROUPS, PAPER_RIGS, preset
from riglens.core.scene.boxes import CLASSES

LIDARS = {group.letters: group.name for group in LIDAR_GROUPS if group.origin == "paper"}
CAMERAS = {group.letters: group.name for group in CAMERA_GROUPS}
LETTERS = {**LIDARS, **CAMERAS}


@dataclass(frozen=True)
class RayLattice:
    """Rays of every camera (columns, rows) and azimuths of every LiDAR."""

    cast: tuple[int, int] = (352, 128)
    azimuths: int = 360

    def applied(self, rig: Rig) -> Rig:
        """The rig with these rays."""
        changed: Rig = rig.replace(sensors=tuple(self._with_rays(sensor) for sensor in rig.sensors))
        return changed

    def _with_rays(self, sensor: Lidar | Camera) -> Lidar | Camera:
        turn = EvenAngles(from_=-180.0, to=180.0, count=self.azimuths)
        changes = {"cast": self.cast} if isinstance(sensor, Camera) else {"azimuths_deg": turn}
        changed: Lidar | Camera = sensor.replace(**changes)
        return changed


@dataclass(frozen=True)
class Ranking:
    """S-MIG in nat of the paper's groups by letter and class; from these S-MS of the eight rigs."""

    s_mig: Mapping[str, Mapping[str, float]]
    camera_weight: float = DEFAULT_LAMBDA

    @cached_property
    def s_ms(self) -> dict[str, dict[str, float]]:
        """S-MS by rig and class."""
        return {name: self._rig(name) for name in PAPER_RIGS}

    def _rig(self, name: str) -> dict[str, float]:
        cameras, lidars = (self.s_mig[letter] for letter in name.split("+"))
        return {cls: self.camera_weight * cameras[cls] + lidars[cls] for cls in CLASSES}

    def with_weight(self, camera_weight: float) -> Ranking:
        """The same groups with another lambda."""
        return Ranking(self.s_mig, camera_weight)

    def figures(self, of: str, cls: str) -> dict[str, float]:
        """S-MIG of the groups "lidars" or "cameras", or S-MS of the "rigs", of one class."""
        if of == "rigs":
            return {rig: self.s_ms[rig][cls] for rig in PAPER_RIGS}
        return {letter: self.s_mig[letter][cls] for letter in (LIDARS if of == "lidars" else CAMERAS)}

    def order(self, of: str, cls: str) -> tuple[str, ...]:
        """Names by figure, the lowest first; empty when all are equal."""
        figures = self.figures(of, cls)
        return tuple(sorted(figures, key=figures.__getitem__)) if len(set(figures.values())) > 1 else ()


def rank(
    field: EntropyField,
    lattice: RayLattice = RayLattice(),
    reading: Reading = "covered",
    camera_weight: float = DEFAULT_LAMBDA,
    threads: int | None = None,
) -> Ranking:
    """Score the paper's six groups of sensors on a scene."""
    engine, settings = Engine(field, threads), MetricSettings(reading=reading)
    s_mig: dict[str, dict[str, float]] = {}
    for letter, name in LETTERS.items():
        found = engine.evaluate(lattice.applied(preset(name)), settings)
        assert found is not None  # nothing abandons it
        kind = "lidar" if letter in LIDARS else "camera"
        s_mig[letter] = {cls: getattr(found.scores.classes[cls], kind).s_mig for cls in CLASSES}
    return Ranking(s_mig, camera_weight)


@dataclass(frozen=True)
class Agreement:
    """Rank correlations of the eight rigs' S-MS with those of a reference; None where one has no order."""

    tau: float | None
    rho: float | None


def agreement(one: Ranking, other: Ranking, cls: str) -> Agreement:
    """Kendall's tau-b and Spearman's rho over the eight rigs."""
    mine, theirs = (list(ranking.figures("rigs", cls).values()) for ranking in (one, other))
    if len(set(mine)) == 1 or len(set(theirs)) == 1:
        return Agreement(None, None)
    from scipy import stats  # here, and not above: slow to load, and few commands need it

    tau, rho = stats.kendalltau(mine, theirs).statistic, stats.spearmanr(mine, theirs).statistic
    return Agreement(float(tau), float(rho))


def swapped(one: Ranking, other: Ranking, of: str, cls: str) -> list[tuple[str, str]]:
    """Pairs (lower first in `other`) whose order is another in `one`."""
    mine, theirs = one.figures(of, cls), other.figures(of, cls)
    ordered = other.order(of, cls)
    return [(a, b) for a, b in combinations(ordered, 2) if theirs[a] < theirs[b] and mine[a] >= mine[b]]
