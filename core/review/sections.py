"""The sections of a file of requirements: figures of a rig with limits, labels and waivers."""

from __future__ import annotations

from datetime import date, timedelta
from typing import Annotated, Literal, Self

from pydantic import AfterValidator, BeforeValidator, Field, model_validator

from riglens.core.blind.outline import BANDS_M
from riglens.core.blind.zones import By, unseen_by
from riglens.core.figures.coverage import SEEN
from riglens.core.figures.figure import Figure
from riglens.core.figures.hits import ON_TARGET
from riglens.core.figures.objects import ObjectFigure
from riglens.core.figures.predicted import PREDICTED
from riglens.core.figures.registry import figure_named, figures, tolerated_figures
from riglens.core.figures.text import in_sentence
from riglens.core.plain import Frozen
from riglens.core.review.mounts import MountLimits
from riglens.core.review.redundancy import What
from riglens.core.review.tolerance import MAX_DRAWS
from riglens.core.scene.sectors import SECTORS
from riglens.core.sensors.registry import one_of
from riglens.core.targets.traffic import WITHIN_M

Class = Literal["car", "bicycle", "pedestrian"]
Sector = Literal["front", "front-left", "left", "rear-left", "rear", "rear-right", "right", "front-right"]
Share = Annotated[float, Field(ge=0.0, le=1.0)]
Metres = Annotated[float, Field(allow_inf_nan=False, ge=0.0, le=1000.0)]
Area = Annotated[float, Field(allow_inf_nan=False, ge=0.0, le=1e6)]


def _not_blank(text: str) -> str:
    if not text.strip():
        raise ValueError("must not be blank")
    return text


Words = Annotated[str, Field(min_length=1, max_length=500), AfterValidator(_not_blank)]
Id = Annotated[str, Field(pattern=r"^[A-Za-z0-9][A-Za-z0-9._-]{0,99}$")]
MOST_RAISED = 1024
"""Draws up to which a chance is measured by default: the upper bound of none is 0.3 % then."""
MOST_CHANCE = 0.5
"""Largest chance of missing a limit that may be accepted: more than that and most cars would miss it; our choice."""
Relation = Literal["at least", "at most"]
_LIMITS = ("at_least", "at_most", "at_most_m2", "at_most_unseen")
assert set(Sector.__args__) == set(SECTORS)  # type: ignore[attr-defined]


def _day(value: object) -> object:
    if not isinstance(value, str):
        raise ValueError("must be a date such as 2027-03-31")
    try:
        return date.fromisoformat(value)
    except ValueError:
        raise ValueError("must be a date such as 2027-03-31") from None


LONGEST = timedelta(days=731)
"""Longest time ahead at which a waiver that counts may end: two years, our choice."""


class Waiver(Frozen):
    """Leave to miss a requirement up to and including a day, with the reason."""

    reason: Words
    until: Annotated[date, BeforeValidator(_day)]

    def holds_on(self, day: date) -> bool:
        """Return whether the waiver is valid on a day: neither over nor longer than any may be."""
        return day <= self.until and not self.is_too_long_on(day)

    def is_too_long_on(self, day: date) -> bool:
        """Return whether it ends too far ahead."""
        return self.until > day + LONGEST


class Requirement(Frozen):
    """Figure with a limit. `allow_missing`: a rig or scene without its subject meets it."""

    id: Id | None = None
    name: Words | None = None
    why: Words | None = None
    allow_missing: bool = False
    waived: Waiver | None = None

    @property
    def unit(self) -> str:
        """Unit of the figure."""
        return "share"

    @property
    def label(self) -> str | None:
        """The user's name of the requirement."""
        return self.name

    @property
    def relation(self) -> Relation:
        """Return the relation of the figure to the limit."""
        return "at least" if "at_least" in type(self).model_fields else "at most"

    @property
    def accepted(self) -> float:
        """The limit; 0 where the requirement has no field for it."""
        limits: list[float] = [getattr(self, name) for name in _LIMITS if name in type(self).model_fields]
        return limits[0] if limits else 0.0

    @property
    def is_met_by_all(self) -> bool:
        """Return whether no figure can miss the limit."""
        return self.unit == "share" and self.accepted == (0.0 if self.relation == "at least" else 1.0)

    @property
    def text(self) -> str:
        """The figure in words."""
        raise NotImplementedError

    @property
    def kinds(self) -> tuple[str, ...]:
        """The kinds of sensors without which the figure does not exist; none: any kind will do."""
        by = getattr(self, "by", "any")
        return () if by == "any" else (by,)

    def scope(self) -> dict[str, object]:
        """Return what identifies the figure: neither its limit nor its labels."""
        return self.model_dump(exclude_defaults=True, exclude=_NOT_SCOPE)


_NOT_SCOPE = {
    *Requirement.model_fields,
    *_LIMITS,
    "limit",
    "draws",
    "max_draws",
    "chance_at_most",
    "title",
    "least_detected",
}


class Seen(Requirement):
    """Share of H(Omega) of a class that is seen, at least."""

    cls: Annotated[Class, Field(alias="class")]
    by: By = "any"
    at_least: Share

    @property
    def text(self) -> str:
        return f"seen of {self.cls} by {self.by}"


COVERED_THINGS = {"voxels": "voxels", "objects": "objects"}
"""Words for what losses and coverage are counted of."""


def _known_figure(key: str) -> str:
    return one_of([one.key for one in figures() if one.per_class], key)


def _known_tolerated(key: str) -> str:
    return one_of([one.key for one in tolerated_figures()], key)


class FigureLimit(Requirement):
    """Limit of any figure of a class: of objects, also of those within distances or in a sector; or of voxels."""

    figure: Annotated[str, AfterValidator(_known_figure)]
    cls: Annotated[Class, Field(alias="class")]
    ring_m: tuple[Metres, Metres] | None = None
    sector: Sector | None = None
    at_least: Annotated[float, Field(allow_inf_nan=False)] | None = None
    at_most: Annotated[float, Field(allow_inf_nan=False)] | None = None

    @model_validator(mode="after")
    def _complete(self) -> Self:
        if (self.at_least is None) == (self.at_most is None):
            raise ValueError("must hold either at_least or at_most")
        wrong = {"more": self.at_most, "less": self.at_least, "neither": None}[self.of.better]
        if wrong is not None:
            raise ValueError(
                f"{self.of.better} of {in_sentence(self.of.title)} is better: "
                f"{'at_least' if self.of.better == 'more' else 'at_most'} limits it"
            )
        if self.of.unit == "share" and not 0.0 <= self.accepted <= 1.0:
            raise ValueError(
                f"{self.relation.replace(' ', '_')} must be a share, 0 to 1 (got {self.accepted:g})"
            )
        if (self.ring_m or self.sector) and not isinstance(self.of, ObjectFigure):
            raise ValueError(f"{self.figure} has no ring_m and no sector")
        if self.ring_m is not None:
            if self.sector is not None:
                raise ValueError("either ring_m or sector, not both")
            low, high = self.ring_m
            if not low < high <= WITHIN_M or low % 10 or high % 10:
                raise ValueError(
                    f"ring_m must be [from, to] in whole tens of metres, from < to, at most {WITHIN_M:g}"
                )
        return self

    @property
    def of(self) -> Figure:
        """The figure that is limited."""
        found = figure_named(self.figure)
        assert found is not None
        return found

    @property
    def relation(self) -> Relation:
        return "at most" if self.at_least is None else "at least"

    @property
    def accepted(self) -> float:
        limit = self.at_most if self.at_least is None else self.at_least
        assert limit is not None
        return limit

    @property
    def unit(self) -> str:
        return self.of.unit

    @property
    def text(self) -> str:
        return f"{in_sentence(self.of.title)} of {self.cls}{self._where}"

    @property
    def _where(self) -> str:
        ring = "" if self.ring_m is None else f", {self.ring_m[0]:g} to {self.ring_m[1]:g} m"
        return f"{ring}{_sector_text(self.sector)}"


class OnTarget(FigureLimit):
    """Limit of a figure of objects, of hit coverage where none is named."""

    figure: Annotated[str, AfterValidator(_known_figure)] = ON_TARGET.key


class PredictedDetection(FigureLimit):
    """Limit of a figure of a calibration, of predicted detection where none is named."""

    figure: Annotated[str, AfterValidator(_known_figure)] = PREDICTED.key


WORST: dict[What, str] = {
    "sensor": "worst sensor",
    "pair": "worst pair",
    "group": "worst group",
    "half": "worst half of a sensor",
}
STATE: dict[What, str] = {"sensor": "failed", "pair": "failed", "group": "failed", "half": "blocked"}


class WorstCase(Requirement):
    """A figure of the rig as designed; with `failing` in the worst single failure of that kind, with `under` in the
    worst of the draws of a tolerance profile, with both in the worst failure in the worst draw.

    Few draws within a limit show little: there must be enough of them to say with 95 % confidence that at most
    `chance_at_most` of all draws exceed it.
    """

    failing: What | None = None
    under: str | None = None
    draws: Annotated[int, Field(ge=1, le=MAX_DRAWS)] = 64
    chance_at_most: Annotated[float, Field(gt=0.0, le=MOST_CHANCE)] = 0.05

    @property
    def case_text(self) -> str:
        """Return the case that counts; nothing for the rig as designed."""
        failing = "" if self.failing is None else f", {WORST[self.failing]} {STATE[self.failing]}"
        return failing + ("" if self.under is None else f", worst of {self.draws:,} draws under {self.under}")


class BlindArea(WorstCase):
    """Ground in m² where an object of a height is unseen, at most."""

    height_m: Annotated[float, Field(gt=0.0, lt=2.0)]
    by: By = "any"
    sensors: Literal[1, 2] = 1
    sector: Sector | None = None
    within_m: Metres | None = None
    at_most_m2: Area

    @property
    def unit(self) -> str:
        return "m²"

    @model_validator(mode="after")
    def _known_band(self) -> Self:
        if self.within_m is not None and self.within_m not in BANDS_M[1:]:
            raise ValueError(f"within_m must be one of {', '.join(f'{edge:g}' for edge in BANDS_M[1:])}")
        return self

    @property
    def text(self) -> str:
        near = "" if self.within_m is None else f" within {self.within_m:g} m"
        unseen = f"{unseen_by(self.by, self.sensors)}{near}{_sector_text(self.sector)}"
        return f"ground where {self.height_m:g} m is {unseen}{self.case_text}"


class BlindObjects(WorstCase):
    """Most objects of a profile that may be unseen."""

    profile: str
    at_most_unseen: Annotated[int, Field(ge=0)] = 0

    @property
    def unit(self) -> str:
        return "objects"

    @property
    def text(self) -> str:
        return f"objects of {self.profile} unseen{self.case_text}"


class Loss(Requirement):
    """Limit of the loss of a class by the worst failure of a kind; or by one failure by its `name`, with a `title`.

    A rig that detects less than `least_detected` of the class has little to lose: there is no figure then.
    """

    of: Literal["voxels", "objects"]
    cls: Annotated[Class, Field(alias="class")]
    failure: What = "sensor"
    name: str | None = None
    title: Words | None = None
    sector: Sector | None = None
    share_of: Literal["all", "detected"] = "detected"
    least_detected: Share = 0.05
    at_most: Share

    @property
    def label(self) -> str | None:
        return self.title

    @property
    def text(self) -> str:
        return self.text_of(f"the {WORST[self.failure]}" if self.name is None else self.name)

    def text_of(self, failing: str) -> str:
        """Return the figure in words, for what fails."""
        happens = "is blocked" if self.failure == "half" else "fails"
        what = f"{'detected ' if self.share_of == 'detected' else ''}{COVERED_THINGS[self.of]} of {self.cls}"
        return f"{what} lost when {failing} {happens}{_sector_text(self.sector)}"

    def scope(self) -> dict[str, object]:
        name = {} if self.name is None else {"name": self.name}
        return super().scope() | name


class Covered(Requirement):
    """Least share of a class that a number of sensors, or two kinds, cover."""

    of: Literal["voxels", "objects"]
    cls: Annotated[Class, Field(alias="class")]
    sensors: Literal["1", "2", "3", "two kinds"] | Literal[1, 2, 3]
    sector: Sector | None = None
    at_least: Share

    @property
    def text(self) -> str:
        return f"{COVERED_THINGS[self.of]} of {self.cls} covered by {self.sensors}{_sector_text(self.sector)}"


class Tolerated(Requirement):
    """Limit of the chance that a figure is worse than a value under errors of a profile.

    There are at least `draws` draws, and more, up to `max_draws`, until the bounds of the chance decide."""

    profile: str
    figure: Annotated[str, AfterValidator(_known_tolerated)] = SEEN.key
    cls: Annotated[Class, Field(alias="class")]
    limit: Share
    draws: Annotated[int, Field(ge=8, le=MAX_DRAWS)] = 64
    max_draws: Annotated[int, Field(ge=8, le=MAX_DRAWS)] = MOST_RAISED
    at_most: Annotated[float, Field(ge=0.0, le=MOST_CHANCE)] = 0.05

    @property
    def of(self) -> Figure:
        """The figure whose chance is limited."""
        found = figure_named(self.figure)
        assert found is not None
        return found

    @property
    def text(self) -> str:
        title, way = self.of.title, "above" if self.of.better == "less" else "below"
        return f"chance of {in_sentence(title)} of {self.cls} {way} {self.limit:g} under {self.profile}"


class Mounts(MountLimits, Requirement):
    """Limits of all mounts: one requirement."""

    @property
    def unit(self) -> str:
        return "violations"

    @property
    def text(self) -> str:
        return "all mounts"

    def scope(self) -> dict[str, object]:
        return {}


def _sector_text(sector: str | None) -> str:
    """Return the sector of a figure; nothing for all around the car."""
    return "" if sector is None else f", {sector}"
