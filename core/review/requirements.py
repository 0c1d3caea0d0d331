"""Define a file of requirements: settings of the figures, limits, and the id of each requirement."""

from __future__ import annotations

import difflib
import os
import re
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from typing import Annotated, Literal, Self

import numpy as np
from pydantic import Field, model_validator

from riglens.core.blind.zones import BlindSettings
from riglens.core.errors import InputError
from riglens.core.metric.entropy import EntropyField
from riglens.core.metric.scores import Body
from riglens.core.plain import Frozen
from riglens.core.review.profiles import Profile
from riglens.core.review.redundancy import failing_of, halves_of
from riglens.core.review.sections import (
    BlindArea,
    BlindObjects,
    Covered,
    FigureLimit,
    Loss,
    Mounts,
    OnTarget,
    PredictedDetection,
    Requirement,
    Seen,
    Tolerated,
    WorstCase,
)
from riglens.core.review.tolerance import PROFILES, SAMPLE_FRAMES, ToleranceProfile
from riglens.core.rig.model import Rig
from riglens.core.rig.yaml.checked import Problem, checked
from riglens.core.rig.yaml.nodes import read_text, shortened, shown_path
from riglens.core.scene.grid import DEFAULT_ROI_M, DEFAULT_VOXEL_M
from riglens.core.targets.traffic import Traffic


@dataclass(frozen=True)
class Item:
    """A requirement with its id and its place in the file: section, and its number there."""

    id: str
    place: tuple[str | int, ...]
    requirement: Requirement

    @property
    def section(self) -> str:
        """The section of the file."""
        return str(self.place[0])


Side = Annotated[float, Field(allow_inf_nan=False, gt=0.0, le=1000.0)]
MOST = 500
ACCEPTED = "a file of requirements, which starts with riglens_requirements: 1"
SECTIONS = (
    "figures",
    "seen",
    "predicted_detection",
    "on_target",
    "blind_areas",
    "blind_objects",
    "losses",
    "covered",
    "tolerance",
)


class Settings(Frozen):
    """Settings in which requirements hold: verdicts depend on them, so that nothing else may set them.

    voxel_m, roi_m: of the grid; boxes_sha256, frames: of the data, any where they are not given; body: of figures of
    traffic, as each rig says where it is not given; sample_frames: in which tolerances count objects.
    """

    voxel_m: Annotated[float, Field(gt=0.0, le=10.0)] = DEFAULT_VOXEL_M
    roi_m: tuple[Side, Side, Side] = DEFAULT_ROI_M
    boxes_sha256: Annotated[str, Field(pattern=r"^[0-9a-f]{64}$")] | None = None
    frames: Annotated[int, Field(ge=1)] | None = None
    body: Body | None = None
    min_points: Annotated[int, Field(ge=1, le=10_000)] = 5
    blind_voxel_m: Annotated[float, Field(ge=0.02, le=1.0)] = 0.1
    blind_width_m: Annotated[float, Field(ge=0.0, le=5.0)] = 0.3
    seed: Annotated[int, Field(ge=0, lt=1 << 63)] = 0
    sample_frames: Annotated[int, Field(ge=1)] = SAMPLE_FRAMES

    def require(self, field: EntropyField | None, traffic: Traffic | None) -> None:
        """Raise InputError unless a scene and its objects are those of the requirements."""
        if field is not None:
            pinned = (("voxel_m", self.voxel_m, field.grid.voxel_m), ("roi_m", self.roi_m, field.grid.roi_m))
            for name, wanted, found in pinned:
                if not np.allclose(wanted, found, rtol=1e-12, atol=0.0):
                    raise InputError(
                        f"must be {size_text(wanted)}, as required (got {size_text(found)})", name
                    )
        for source in (field, traffic):
            if source is None:
                continue
            data = source.data
            if self.boxes_sha256 not in (None, data.sha256):
                said = f"have SHA-256 {self.boxes_sha256}, as required (got {data.sha256 or 'none'})"
                raise InputError(f"must {said}", "boxes")
            if self.frames not in (None, data.frames):
                raise InputError(f"must be {self.frames}, as required (got {data.frames})", "frames")


def size_text(size_m: float | Sequence[float]) -> str:
    """Return a length, or those of a region, with their unit."""
    lengths = size_m if isinstance(size_m, Sequence) else (size_m,)
    return " × ".join(f"{length:g}" for length in lengths) + " m"


class Requirements(Frozen):
    """A file of requirements: `settings` say how figures are made; `tolerance_profiles` are errors of one's own."""

    riglens_requirements: Literal[1]
    settings: Settings = Settings()
    figures: Annotated[tuple[FigureLimit, ...], Field(max_length=MOST)] = ()
    seen: Annotated[tuple[Seen, ...], Field(max_length=MOST)] = ()
    predicted_detection: Annotated[tuple[PredictedDetection, ...], Field(max_length=MOST)] = ()
    on_target: Annotated[tuple[OnTarget, ...], Field(max_length=MOST)] = ()
    blind_areas: Annotated[tuple[BlindArea, ...], Field(max_length=MOST)] = ()
    blind_objects: Annotated[tuple[BlindObjects, ...], Field(max_length=MOST)] = ()
    losses: Annotated[tuple[Loss, ...], Field(max_length=MOST)] = ()
    covered: Annotated[tuple[Covered, ...], Field(max_length=MOST)] = ()
    tolerance: Annotated[tuple[Tolerated, ...], Field(max_length=MOST)] = ()
    tolerance_profiles: Annotated[tuple[ToleranceProfile, ...], Field(max_length=MOST)] = ()
    mounts: Mounts | None = None

    @model_validator(mode="after")
    def _asks_something(self) -> Self:
        if not (self.needs_scene or self.blind_areas or self.blind_objects or self.mounts):
            raise ValueError("nothing is required")
        return self

    @property
    def errors(self) -> dict[str, ToleranceProfile]:
        """Profiles of errors by name: those that ship, and the file's own."""
        return {profile.name: profile for profile in (*PROFILES, *self.tolerance_profiles)}

    @property
    def needs_scene(self) -> bool:
        """Return whether any requirement depends on traffic."""
        return (
            bool(self.figures or self.seen or self.losses or self.covered or self.tolerance)
            or self.needs_objects
        )

    @property
    def needs_objects(self) -> bool:
        """Return whether any requirement is on objects of the traffic."""
        counted = [*(one.of for one in self.losses), *(one.of for one in self.covered)]
        of_objects = "objects" in counted
        of_objects |= any(one.of.needs == "objects" for one in self.limits)
        return of_objects or any(one.of.needs == "objects" for one in self.tolerance)

    @property
    def limits(self) -> tuple[FigureLimit, ...]:
        """Limits of figures of classes, whichever section they stand in."""
        return (*self.figures, *self.on_target, *self.predicted_detection)

    @property
    def blind_settings(self) -> BlindSettings:
        """Return the settings of the blind-zone search."""
        return BlindSettings(self.settings.blind_voxel_m, self.settings.blind_width_m)

    def items(self) -> tuple[Item, ...]:
        """Return every requirement in the order of the sections. A missing id is derived from the requirement's
        subject, whatever its limit and its place; equal ones are numbered."""
        placed = list(self._placed())
        taken = {one.id for _, one in placed if one.id is not None}
        found = []
        for place, one in placed:
            known = one.id or _free(_derived_id(str(place[0]), one.scope()), taken)
            taken.add(known)
            found.append(Item(known, place, one))
        return tuple(found)

    def _placed(self) -> Iterator[tuple[tuple[str | int, ...], Requirement]]:
        for section in SECTIONS:
            for number, one in enumerate(getattr(self, section)):
                yield (section, number), one
        if self.mounts is not None:
            yield ("mounts",), self.mounts

    def problems(
        self, rigs: Iterable[Rig] = (), profiles: Sequence[Profile] | None = None
    ) -> Iterator[Problem]:
        """Yield the problems with names in the file: duplicate ids, unknown tolerance profiles and, where they are
        given, unknown profiles of objects and unknown failures of rigs."""
        ids: set[str] = set()
        shipped = {profile.name for profile in PROFILES}
        for number, own in enumerate(self.tolerance_profiles):
            if own.name in shipped:
                message = f"'{own.name}' is the name of a profile that ships: choose another one"
                yield ("tolerance_profiles", number, "name"), message
        for place, one in self._placed():
            if one.id is not None and one.id in ids:
                yield (*place, "id"), f"'{one.id}' is the id of another requirement"
            ids |= {one.id} if one.id is not None else set()
            if isinstance(one, Tolerated):
                yield from _unknown((*place, "profile"), "tolerance profile", one.profile, self.errors)
            if isinstance(one, WorstCase) and one.under is not None:
                yield from _unknown((*place, "under"), "tolerance profile", one.under, self.errors)
            if isinstance(one, BlindObjects) and profiles is not None:
                names = [profile.name for profile in profiles]
                yield from _unknown((*place, "profile"), "profile", one.profile, names)
        for rig in rigs:
            yield from self._not_in(rig)

    def _not_in(self, rig: Rig) -> Iterator[Problem]:
        """Yield the failures whose names a rig lacks, even with all of its sensors enabled."""
        whole = [sensor.replace(enabled=True) for sensor in rig.sensors]
        for number, one in enumerate(self.losses):
            if one.name is None or one.allow_missing:
                continue
            names = [name for what, name, _ in failing_of(whole) if what == one.failure]
            if one.failure == "half":
                names = [name for name, _ in halves_of(rig.model_copy(update={"sensors": tuple(whole)}))]
            if one.name not in names:
                hint = "; fails_with of sensors names groups" if one.failure == "group" else ""
                known = shortened(", ".join(names) or "none", 300) + hint
                rig_text = shortened(rig.name)
                message = f"rig '{rig_text}' has no {one.failure} '{shortened(one.name)}' ({known})"
                yield ("losses", number, "name"), message


def _unknown(place: tuple[str | int, ...], what: str, name: str, known: Iterable[str]) -> Iterator[Problem]:
    names = list(known)
    if name not in names:
        close = difflib.get_close_matches(name, names, n=1)
        hint = f"did you mean '{close[0]}'?" if close else f"must be one of {', '.join(names)}"
        yield place, f"{what} '{shortened(name)}' is unknown ({shortened(hint, 300)})"


def _derived_id(section: str, scope: dict[str, object]) -> str:
    words = [section]
    for value in scope.values():
        parts = value if isinstance(value, tuple) else (value,)
        words += [f"{part:g}" if isinstance(part, float) else str(part) for part in parts]
    return re.sub(r"[^\w.]+", "-", " ".join(words).lower()).strip("-")


def _free(name: str, taken: set[str]) -> str:
    """Return the name, or the first of its numbered ones that is free."""
    number, free = 2, name
    while free in taken:
        free, number = f"{name}-{number}", number + 1
    return free


def read_requirements(
    path: str | os.PathLike[str], rigs: Iterable[Rig] = (), profiles: Sequence[Profile] | None = None
) -> Requirements:
    """Read a file of requirements, and compare its names with rigs and profiles of objects, where they are given.

    InputError with file, line and field when something is wrong."""
    return requirements_in(read_text(path, ACCEPTED), shown_path(path), rigs, profiles)


def requirements_in(
    text: str, where: str, rigs: Iterable[Rig] = (), profiles: Sequence[Profile] | None = None
) -> Requirements:
    """Read requirements from a text, as `read_requirements` does; `where` names it in messages."""
    return checked(text, Requirements, ACCEPTED, where, lambda found: found.problems(rigs, profiles))
