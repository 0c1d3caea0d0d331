"""Requirements on a rig as a file says them, and what becomes of each: one number, one limit, met or not."""

from __future__ import annotations

import os
from dataclasses import dataclass
from typing import Annotated, Literal, Self

from pydantic import Field, model_validator

from riglens.core.metric.scores import Body
from riglens.core.review.blind import BlindSettings, By
from riglens.core.review.checked_yaml import read_checked
from riglens.core.review.mounts import MountLimits
from riglens.core.review.outline import BANDS_M, SECTORS
from riglens.core.review.redundancy import What
from riglens.core.review.tolerance import PROFILES, ToleranceProfile
from riglens.core.rig.model import Frozen

Class = Literal["car", "bicycle", "pedestrian"]
Sector = Literal["front", "front-left", "left", "rear-left", "rear", "rear-right", "right", "front-right"]
Share = Annotated[float, Field(ge=0.0, le=1.0)]
Metres = Annotated[float, Field(allow_inf_nan=False, ge=0.0, le=1000.0)]
Area = Annotated[float, Field(allow_inf_nan=False, ge=0.0, le=1e6)]
MOST = 500
Relation = Literal["at least", "at most"]
assert set(Sector.__args__) == set(SECTORS)  # type: ignore[attr-defined]


class Seen(Frozen):
    """Share of H(Omega) of a class that is seen, at least."""

    cls: Annotated[Class, Field(alias="class")]
    by: By = "any"
    at_least: Share


class OnTarget(Frozen):
    """A share of road users of a class within distances, or all: on target, or with 5 points, at least."""

    cls: Annotated[Class, Field(alias="class")]
    ring_m: tuple[Metres, Metres] | None = None
    figure: Literal["on_target", "share_5", "visible", "both"] = "on_target"
    at_least: Share

    @model_validator(mode="after")
    def _rings_of_ten(self) -> Self:
        if self.ring_m is not None:
            low, high = self.ring_m
            if not low < high or low % 10 or high % 10:
                raise ValueError("ring_m: accepted is [from, to] in whole tens of metres, from < to")
        return self


class BlindArea(Frozen):
    """Ground in m² where an object of a height stands unseen, at most."""

    height_m: Annotated[float, Field(gt=0.0, lt=2.0)]
    by: By = "any"
    sensors: Literal[1, 2] = 1
    sector: Sector | None = None
    within_m: Metres | None = None
    at_most_m2: Area

    @model_validator(mode="after")
    def _known_band(self) -> Self:
        if self.within_m is not None and self.within_m not in BANDS_M[1:]:
            raise ValueError(f"within_m: accepted is one of {', '.join(f'{edge:g}' for edge in BANDS_M[1:])}")
        return self


class BlindObjects(Frozen):
    """Objects of a profile that are not seen, at most so many."""

    profile: str
    at_most_unseen: Annotated[int, Field(ge=0)] = 0


class Loss(Frozen):
    """What the worst failure of a kind costs of a class, at most; or one failure by its name."""

    of: Literal["voxels", "road_users"]
    cls: Annotated[Class, Field(alias="class")]
    failure: What = "sensor"
    name: str | None = None
    sector: Sector | None = None
    at_most: Share


class Covered(Frozen):
    """Share of a class that so many sensors, or two kinds, cover, at least."""

    of: Literal["voxels", "road_users"]
    cls: Annotated[Class, Field(alias="class")]
    sensors: Literal["1", "2", "3", "two kinds"] | Literal[1, 2, 3]
    sector: Sector | None = None
    at_least: Share


class Tolerated(Frozen):
    """How likely a figure may fall below a limit under errors of a profile, at most."""

    profile: str
    figure: Literal["seen", "on_target"] = "seen"
    cls: Annotated[Class, Field(alias="class")]
    limit: Share
    draws: Annotated[int, Field(ge=8, le=4096)] = 64
    at_most: Share = 0.05


class Requirements(Frozen):
    """A file of requirements. `body`, `min_points`, `width_m`, `voxel_m` of blind zones and `seed` say how figures are
    made; `tolerance_profiles` are errors of one's own."""

    riglens_requirements: Literal[1]
    body: Body | None = None
    min_points: Annotated[int, Field(ge=1, le=10_000)] = 5
    blind_voxel_m: Annotated[float, Field(ge=0.02, le=1.0)] = 0.1
    blind_width_m: Annotated[float, Field(ge=0.0, le=5.0)] = 0.3
    seed: Annotated[int, Field(ge=0, lt=1 << 63)] = 0
    sample_frames: Annotated[int, Field(ge=1)] = 100
    seen: Annotated[tuple[Seen, ...], Field(max_length=MOST)] = ()
    on_target: Annotated[tuple[OnTarget, ...], Field(max_length=MOST)] = ()
    blind_areas: Annotated[tuple[BlindArea, ...], Field(max_length=MOST)] = ()
    blind_objects: Annotated[tuple[BlindObjects, ...], Field(max_length=MOST)] = ()
    losses: Annotated[tuple[Loss, ...], Field(max_length=MOST)] = ()
    covered: Annotated[tuple[Covered, ...], Field(max_length=MOST)] = ()
    tolerance: Annotated[tuple[Tolerated, ...], Field(max_length=MOST)] = ()
    tolerance_profiles: Annotated[tuple[ToleranceProfile, ...], Field(max_length=MOST)] = ()
    mounts: MountLimits | None = None

    @model_validator(mode="after")
    def _profiles_known(self) -> Self:
        known = self.errors
        for one in self.tolerance:
            if one.profile not in known:
                raise ValueError(
                    f"tolerance profile '{one.profile}' is unknown, accepted is one of {', '.join(known)}"
                )
        return self

    @model_validator(mode="after")
    def _asks_something(self) -> Self:
        if not (self.needs_scene or self.blind_areas or self.blind_objects or self.mounts):
            raise ValueError("nothing is required")
        return self

    @property
    def errors(self) -> dict[str, ToleranceProfile]:
        """Profiles of errors by name: those that ship, and the file's own, which go before."""
        return {profile.name: profile for profile in (*PROFILES, *self.tolerance_profiles)}

    @property
    def needs_scene(self) -> bool:
        """Whether anything is asked that depends on traffic."""
        return bool(self.seen or self.on_target or self.losses or self.covered or self.tolerance)

    @property
    def needs_road_users(self) -> bool:
        """Whether anything is asked of road users."""
        counted = [*(one.of for one in self.losses), *(one.of for one in self.covered)]
        of_users = "road_users" in counted
        return bool(self.on_target) or of_users or any(one.figure == "on_target" for one in self.tolerance)

    @property
    def blind_settings(self) -> BlindSettings:
        """How blind zones are looked for."""
        return BlindSettings(self.blind_voxel_m, self.blind_width_m)


@dataclass(frozen=True)
class Verdict:
    """What became of one requirement: `text` says what was asked of what, `found` and `limit` in `unit`."""

    section: str
    text: str
    found: float
    relation: Relation
    limit: float
    unit: str

    @property
    def passes(self) -> bool:
        """Whether the requirement is met."""
        return self.found >= self.limit if self.relation == "at least" else self.found <= self.limit


def read_requirements(path: str | os.PathLike[str]) -> Requirements:
    """Read a file of requirements; InputError with file, line and field when it is wrong."""
    accepted = "a file of requirements, which starts with riglens_requirements: 1"
    return read_checked(path, Requirements, accepted)
