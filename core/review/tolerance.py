"""Tolerance: the spread of a rig's figures under small errors of mounts and pitch of the car.

Errors of a profile are drawn evenly within its limits, by a scrambled Sobol sequence, so that two rigs with the same
sensors meet the same errors. Next to the spread is that of unavoidable errors, the noise floor: it shows the lattice
of rays and voxels, not the mounts.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Annotated, Generic, TypeVar

import numpy as np
from numpy.typing import NDArray
from pydantic import Field

from riglens.core.errors import InputError
from riglens.core.figures.figure import Estimate, Figure
from riglens.core.figures.registry import figure_named
from riglens.core.geometry import Pose, rpy_deg_from_rotation
from riglens.core.option_help import OptionHelp
from riglens.core.plain import Frozen
from riglens.core.rig.model import Rig, Sensor
from riglens.core.scene.boxes import Progress

T = TypeVar("T")
Doubles = NDArray[np.float64]
Figures = Mapping[str, Estimate]
Measure = Callable[[Rig, Pose], Figures]
"""Figures by name, `KEY CLASS`, of a rig with a pose of its car in the frame of the traffic."""
AXES = ("x", "y", "z", "roll", "pitch", "yaw")
MAX_DRAWS = 4096
SAMPLE_FRAMES = 100
"""Frames in which objects are counted for a tolerance."""
CONFIDENCE = 0.95
Millimetres = Annotated[float, Field(allow_inf_nan=False, ge=0.0, le=1000.0)]
Tilt = Annotated[float, Field(allow_inf_nan=False, ge=0.0, le=30.0)]


class ToleranceProfile(Frozen):
    """Limits of errors, each plus or minus: of every sensor on its own, of every bracket with all that it carries, of
    the car on its wheels. A bracket is the first name in `fails_with` of its sensors; it turns about their middle."""

    name: Annotated[str, Field(min_length=1, max_length=60)]
    source: Annotated[str, Field(min_length=1, max_length=500)]
    position_mm: Millimetres = 0.0
    angle_deg: Tilt = 0.0
    bracket_position_mm: Millimetres = 0.0
    bracket_angle_deg: Tilt = 0.0
    car_roll_deg: Tilt = 0.0
    car_pitch_deg: Tilt = 0.0
    car_heave_mm: Millimetres = 0.0


OUR_CHOICE = "our choice"
PROFILES = (
    ToleranceProfile(name="assembly", source=OUR_CHOICE, position_mm=3.0, angle_deg=0.1),
    ToleranceProfile(name="service", source=OUR_CHOICE, position_mm=5.0, angle_deg=0.3),
    ToleranceProfile(
        name="brackets",
        source=OUR_CHOICE,
        position_mm=1.0,
        angle_deg=0.05,
        bracket_position_mm=3.0,
        bracket_angle_deg=0.1,
    ),
    ToleranceProfile(name="ride", source=OUR_CHOICE, car_pitch_deg=0.5, car_roll_deg=0.5, car_heave_mm=20.0),
    ToleranceProfile(name="load", source=OUR_CHOICE, car_pitch_deg=1.5, car_heave_mm=60.0),
)
"""Bundled profiles; a file of requirements may hold others."""
NOISE_FLOOR = ToleranceProfile(name="noise floor", source=OUR_CHOICE, position_mm=1.0, angle_deg=0.01)


def profile_called(name: str) -> ToleranceProfile:
    """Return the bundled profile of that name; raise InputError when there is none."""
    for profile in PROFILES:
        if profile.name == name:
            return profile
    known = ", ".join(profile.name for profile in PROFILES)
    raise InputError(f"must be one of {known} (got '{name}')", "errors")


@dataclass(frozen=True)
class ToleranceOptions:
    """Options of a tolerance: which errors are drawn, how often, and what is measured."""

    errors: Annotated[
        str, OptionHelp("NAME", "Errors to draw: assembly, service, brackets, ride or load.")
    ] = "assembly"
    draws: Annotated[
        int,
        OptionHelp(
            "N", "Number of draws, which take most of the time; the sequence is balanced in powers of two."
        ),
    ] = 64
    seed: Annotated[
        int,
        OptionHelp(
            "N", "Seed of the draws; the same seed gives the same errors to rigs with the same sensors."
        ),
    ] = 0
    sample: Annotated[
        int,
        OptionHelp("N", "Number of frames in which objects are counted for the tolerance; 0 for none."),
    ] = SAMPLE_FRAMES
    sensitivities: Annotated[
        bool,
        OptionHelp("", "Also report the effect of each error on its own.", negative="no-sensitivities"),
    ] = True

    def __post_init__(self) -> None:
        require_draws(self.draws, self.seed, 1)
        profile_called(self.errors)


@dataclass(frozen=True)
class Spread:
    """Spread of one figure: as designed, median, 5 and 95 percent of the draws, the worst, its draw, and the standard
    error of its change from the rig as designed where that is of a sample."""

    nominal: float
    median: float
    p05: float
    p95: float
    worst: float
    worst_draw: int
    values: tuple[float, ...] = field(repr=False)
    worst_se: float = 0.0

    @classmethod
    def of(cls, nominal: float, values: Sequence[float], less_is_better: bool = False) -> Spread:
        """Return the spread of some draws, of which there is at least one."""
        low, middle, high = np.quantile(values, [0.05, 0.5, 0.95]).tolist()
        worst = int(np.argmax(values) if less_is_better else np.argmin(values))
        return cls(nominal, middle, low, high, float(values[worst]), worst, tuple(values))


@dataclass(frozen=True)
class Sensitivity:
    """Change by an error of one sensor at the profile's limit, by central differences: half the difference between plus
    and minus, by figure; se: its standard error, at most, where it is of a sample."""

    sensor: str
    axis: str
    limit: float
    effect: Mapping[str, float]
    se: Mapping[str, float]


@dataclass(frozen=True)
class ToleranceResult:
    """Result of a profile for a rig: the spread of each figure, that of the noise floor, and sensitivities; frames: in
    which objects were counted for each draw, and of how many."""

    rig: Rig
    profile: ToleranceProfile
    draws: int
    seed: int
    spreads: Mapping[str, Spread]
    floor: Mapping[str, Spread]
    sensitivities: tuple[Sensitivity, ...]
    frames: tuple[int, int] = (0, 0)

    @property
    def sample_text(self) -> str:
        """Say where figures of objects were counted; empty without them."""
        used, of = self.frames
        if used == of:
            return f"Objects in all {of:,} frames." if of else ""
        return (
            f"Objects: as designed in all {of:,} frames, changed as {used:,} of them show, object by object; ± are two "
            "standard errors of that change in the worst draw."
        )

    @property
    def of_objects(self) -> list[str]:
        """Return the names of the figures of objects."""
        return [
            name for name in self.spreads if (one := _figure_of(name)) is not None and one.needs == "objects"
        ]


def errors_count(rig: Rig) -> int:
    """Return the number of errors drawn for a rig: six for each sensor and bracket, three for the car."""
    return 6 * (len(rig.sensors) + len(brackets_of(rig))) + 3


def brackets_of(rig: Rig) -> dict[str, tuple[str, ...]]:
    """Return names of brackets and the sensors that each carries."""
    brackets: dict[str, list[str]] = {}
    for sensor in rig.sensors:
        if sensor.fails_with:
            brackets.setdefault(sensor.fails_with[0], []).append(sensor.name)
    return {name: tuple(members) for name, members in brackets.items()}


def unit_draws(count: int, errors: int, seed: int) -> Doubles:
    """Return draws (count, errors) in [-1, 1): a scrambled Sobol sequence."""
    from scipy.stats import qmc  # slow to load

    if not 1 <= count <= MAX_DRAWS:
        raise InputError(f"must be an integer from 1 to {MAX_DRAWS} (got {count})", "draws")
    sampler = qmc.Sobol(errors, scramble=True, rng=np.random.default_rng(seed))
    whole = sampler.random_base2(max(0, math.ceil(math.log2(count))))  # balanced in powers of two only
    return np.asarray(2.0 * whole[:count] - 1.0)


def disturbed(rig: Rig, profile: ToleranceProfile, errors: Doubles) -> tuple[Rig, Pose]:
    """Return a rig with errors (n,) in units of the profile's limits, and the stance of its car."""
    own = _limits(profile.position_mm, profile.angle_deg)
    shared = _limits(profile.bracket_position_mm, profile.bracket_angle_deg)
    count, brackets = len(rig.sensors), brackets_of(rig)
    each = errors[: 6 * count].reshape(-1, 6) * own
    joint = errors[6 * count : -3].reshape(-1, 6) * shared
    sensors = {s.name: _moved(s, error, s.position) for s, error in zip(rig.sensors, each, strict=True)}
    for members, error in zip(brackets.values(), joint, strict=True):
        middle = np.mean([rig.sensor(name).position for name in members], axis=0)
        for name in members:
            sensors[name] = _moved(sensors[name], error, middle)
    limits = (profile.car_roll_deg, profile.car_pitch_deg, profile.car_heave_mm / 1e3)
    roll, pitch, heave = (float(e) * limit for e, limit in zip(errors[-3:], limits, strict=True))
    stance = Pose((0.0, 0.0, heave), (roll, pitch, 0.0))
    return rig.model_copy(update={"sensors": tuple(sensors.values())}), stance


def moves(profile: ToleranceProfile, rig: Rig) -> bool:
    """Return whether errors of a profile move the car or any enabled sensor of a rig."""
    moved, stance = disturbed(rig, profile, np.ones(errors_count(rig)))
    pairs = zip(rig.sensors, moved.sensors, strict=True)
    return stance != Pose() or any(one.enabled and one != other for one, other in pairs)


def _limits(position_mm: float, angle_deg: float) -> Doubles:
    return np.array([position_mm / 1e3] * 3 + [angle_deg] * 3)


def _moved(sensor: Sensor, error: Doubles, about_m: Sequence[float] | Doubles) -> Sensor:
    """Return a sensor shifted by metres and turned by degrees about axes of the vehicle through a place."""
    if not error.any():
        return sensor
    turn = Pose((0.0, 0.0, 0.0), (float(error[3]), float(error[4]), float(error[5]))).rotation()
    middle = np.asarray(about_m, np.float64)
    x, y, z = (middle + turn @ (np.array(sensor.position) - middle) + error[:3]).tolist()
    return sensor.with_pose(Pose((x, y, z), rpy_deg_from_rotation(turn @ sensor.pose.rotation())))


def standing(rig: Rig, stance: Pose) -> Rig:
    """Return the rig in the frame of the traffic for a `stance` of its car."""
    if stance == Pose():
        return rig
    sensors = tuple(sensor.with_pose(stance.compose(sensor.pose)) for sensor in rig.sensors)
    return rig.model_copy(update={"sensors": sensors})


class Draws(Generic[T]):
    """Measurements of a rig under errors of a profile, draw by draw. More draws begin with those of fewer."""

    def __init__(
        self, rig: Rig, profile: ToleranceProfile, seed: int, measure: Callable[[Rig, Pose], T]
    ) -> None:
        self._rig, self._profile, self._seed, self._measure = rig, profile, seed, measure
        self._found: list[T] = []

    def first(self, count: int) -> Sequence[T]:
        """Return the measurements of the first draws."""
        if count > len(self._found):
            units = unit_draws(count, errors_count(self._rig), self._seed)
            for errors in units[len(self._found) :]:
                self._found.append(self._measure(*disturbed(self._rig, self._profile, errors)))
        return self._found[:count]


def chance_bounds(count: int, draws: int) -> tuple[float, float]:
    """Return the lower and the upper bound of a chance that occurred `count` times in `draws` draws, each with 95 %
    confidence (Clopper and Pearson, Biometrika 26, 1934, exact for independent draws)."""
    from scipy.stats import beta  # slow to load

    low = float(beta.ppf(1.0 - CONFIDENCE, count, draws - count + 1)) if count else 0.0
    high = float(beta.ppf(CONFIDENCE, count + 1, draws - count)) if count < draws else 1.0
    return low, high


class ToleranceRun:
    """Draws of a rig one after another, for a caller that measures them when there is time.

    Draws of the noise floor, a quarter as many, come in between, so that what is known half-way is known of both."""

    def __init__(
        self,
        rig: Rig,
        profile: ToleranceProfile,
        draws: int = 64,
        seed: int = 0,
        frames: tuple[int, int] = (0, 0),
    ) -> None:
        self.rig, self.profile, self.draws, self.seed, self._frames = rig, profile, draws, seed, frames
        units = unit_draws(draws, errors_count(rig), seed)
        few = max(1, draws // 4)
        self._steps = [(False, np.zeros(errors_count(rig)))]
        for place, errors in enumerate(units):
            self._steps.append((False, errors))
            if place % 4 == 0 and place // 4 < few:
                self._steps.append((True, units[place // 4]))
        self._found: list[Figures] = []

    @property
    def steps(self) -> int:
        """Return the number of measurements."""
        return len(self._steps)

    @property
    def done(self) -> int:
        """Return the number of measurements taken."""
        return len(self._found)

    def wanted(self) -> tuple[Rig, Pose]:
        """Return the rig to measure next, and the stance of its car; IndexError when all is done."""
        is_floor, errors = self._steps[self.done]
        return disturbed(self.rig, NOISE_FLOOR if is_floor else self.profile, errors)

    def take(self, figures: Figures) -> None:
        """Store the figures of the rig that `wanted` returned."""
        self._found.append(figures)

    def result(self, sensitivities: Sequence[Sensitivity] = ()) -> ToleranceResult | None:
        """Return the result so far; None before the first draw of both kinds."""
        drawn: tuple[list[Figures], list[Figures]] = ([], [])
        for figures, (is_floor, _) in zip(self._found[1:], self._steps[1:], strict=False):
            drawn[is_floor].append(figures)
        found, floor = drawn
        if not found or not floor:
            return None
        nominal, own = self._found[0], (self.rig, self.profile, self.draws, self.seed)
        spreads, of_floor = _spreads(nominal, found), _spreads(nominal, floor)
        return ToleranceResult(*own, spreads, of_floor, tuple(sensitivities), self._frames)


def tolerance(
    rig: Rig,
    profile: ToleranceProfile,
    measure: Measure,
    draws: int = 64,
    seed: int = 0,
    with_sensitivities: bool = True,
    progress: Progress | None = None,
    frames: tuple[int, int] = (0, 0),
) -> ToleranceResult:
    """Draw errors and measure the rig with each of them; the same seed gives the same draws. `frames`: as in
    the result."""
    run = ToleranceRun(rig, profile, draws, seed, frames)
    axes = [axis for axis in _axes(rig, profile) if with_sensitivities]
    steps = run.steps + 2 * len(axes)
    done = iter(range(1, steps + 1))

    def measured(moved: Rig, stance: Pose) -> Figures:
        figures = measure(moved, stance)
        if progress is not None:
            progress(next(done) / steps)
        return figures

    while run.done < run.steps:
        run.take(measured(*run.wanted()))
    found = run.result([_sensitivity(rig, profile, measured, *axis) for axis in axes])
    assert found is not None  # there is at least one draw of each kind
    return found


def _spreads(nominal: Figures, found: Sequence[Figures]) -> dict[str, Spread]:
    spreads = {
        name: Spread.of(one.value, [drawn[name].value for drawn in found], is_less_better(name))
        for name, one in nominal.items()
    }
    return {name: replace(one, worst_se=found[one.worst_draw][name].se) for name, one in spreads.items()}


def is_less_better(name: str) -> bool:
    """Return whether less of a measured figure, `KEY CLASS`, is better."""
    figure = _figure_of(name)
    return figure is not None and figure.better == "less"


def _figure_of(name: str) -> Figure | None:
    return figure_named(name.partition(" ")[0])


def _axes(rig: Rig, profile: ToleranceProfile) -> Iterator[tuple[str, str, int, float]]:
    """Yield the sensor, axis, place among all errors, and limit in mm or degrees, of each error that has a limit."""
    limits = [profile.position_mm] * 3 + [profile.angle_deg] * 3
    for number, sensor in enumerate(rig.sensors):
        for axis, (name, limit) in enumerate(zip(AXES, limits, strict=True)):
            if limit and sensor.enabled:
                yield sensor.name, name, 6 * number + axis, limit
    limits = [profile.car_roll_deg, profile.car_pitch_deg, profile.car_heave_mm]
    for axis, (name, limit) in enumerate(zip(("roll", "pitch", "z"), limits, strict=True)):
        if limit:
            yield "car", name, errors_count(rig) - 3 + axis, limit


def _sensitivity(
    rig: Rig,
    profile: ToleranceProfile,
    measured: Measure,
    sensor: str,
    axis: str,
    place: int,
    limit: float,
) -> Sensitivity:
    error = np.zeros(errors_count(rig))
    error[place] = 1.0
    more, less = (measured(*disturbed(rig, profile, sign * error)) for sign in (1.0, -1.0))
    effect = {name: (more[name].value - less[name].value) / 2.0 for name in more}
    return Sensitivity(
        sensor, axis, limit, effect, {name: (more[name].se + less[name].se) / 2.0 for name in more}
    )


def rig_of_draw(result: ToleranceResult, draw: int, magnified: float = 1.0) -> tuple[Rig, Pose]:
    """Return the rig of a draw, its errors magnified, and the stance of its car."""
    errors = unit_draws(result.draws, errors_count(result.rig), result.seed)[draw]
    return disturbed(result.rig, result.profile, magnified * errors)


def worst_rig(result: ToleranceResult, figure: str, magnified: float = 1.0) -> Rig:
    """Return the rig of the draw with the worst value of a figure, with its stance; InputError for an unknown figure.

    `magnified`: factor on its errors, to be visible next to the rig as designed."""
    if figure not in result.spreads:
        known = ", ".join(result.spreads)
        raise InputError(f"must be one of {known} (got '{figure}')", "figure")
    draw = result.spreads[figure].worst_draw
    worst = standing(*rig_of_draw(result, draw, magnified))
    return worst.model_copy(update={"name": f"{worst.name[:150]}, {result.profile.name}, draw {draw}"})


def require_draws(draws: int, seed: int, least: int) -> None:
    """Raise InputError for a number of draws or a seed out of its limits."""
    if not least <= draws <= MAX_DRAWS:
        raise InputError(f"must be an integer from {least} to {MAX_DRAWS} (got {draws})", "draws")
    if not 0 <= seed < 1 << 63:
        raise InputError(f"must be an integer from 0 to 2^63 - 1 (got {seed})", "seed")
