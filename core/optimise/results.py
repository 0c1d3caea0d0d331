"""The result of a search for rigs, as data and as files."""

from __future__ import annotations

import csv
import io
import math
import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from riglens.core.errors import InputError
from riglens.core.files import atomic_write
from riglens.core.optimise.bounds import Bound
from riglens.core.optimise.guard import GuardResult, Verdict, verdict, weak_cases
from riglens.core.optimise.mounts import Candidate
from riglens.core.optimise.objectives import Problem
from riglens.core.optimise.tables import UNIT
from riglens.core.rig.model import Rig
from riglens.core.rig.yaml.file import new_rig_file
from riglens.core.shown_text import spreadsheet_cell

TABLE = "proposals.csv"


@dataclass(frozen=True)
class Proposal:
    """A rig with candidates added or moved: value in the frames of choice, blind area if requested, the guard's
    cases."""

    rig: Rig
    added: tuple[Candidate, ...]
    value: float
    blind_m2: float | None = None
    guard: tuple[GuardResult, ...] = ()

    @property
    def cost(self) -> float:
        """Return the cost of the added sensors."""
        return math.fsum(one.cost for one in self.added)

    @property
    def verdict(self) -> Verdict:
        """Return whether the gain over the reference is one."""
        return verdict(self.guard)

    @property
    def weak(self) -> tuple[GuardResult, ...]:
        """Cases that keep less than half of the gain."""
        return weak_cases(self.guard)

    def to_dict(self) -> dict[str, Any]:
        """Return the proposal as plain data, by the names of the JSON."""
        sensors = [sensor for one in self.added for sensor in one.sensors]
        return {
            "name": self.rig.name,
            "value": self.value,
            "cost": self.cost,
            "sensors": [
                {"name": s.name, "model": s.model, "position": list(s.position), "rpy_deg": list(s.rpy_deg)}
                for s in sensors
            ],
            "guard": [{"case": k.case, "gain": k.gain, "se": k.se, "share": k.share} for k in self.guard],
            "verdict": self.verdict,
        }


@dataclass(frozen=True)
class CostStep:
    """The best rig found with a number of additions, and its value in the frames of choice."""

    count: int
    value: float
    rig: Rig


@dataclass(frozen=True)
class Cheapest:
    """Least cost at which a set reaches a value; whether it is proven that no cheaper one does."""

    value: float
    cost: float
    is_proven: bool


@dataclass(frozen=True)
class OptimiseResult:
    """Proposals, the best first, then those of the front; no allowed set exceeds `bound` in the frames of choice.

    before, reference_value: values of the rig itself and of the one that gains refer to, in the same frames. stairs: by
    number of additions, from none on. floors: the best proposal's value by class; unmet: the
    requirements that it does not meet, None without requirements.
    """

    problem: Problem
    candidates: int
    before: float
    before_blind_m2: float | None
    reference: Rig
    reference_value: float
    bound: Bound
    proposals: tuple[Proposal, ...]
    front: tuple[int, ...] = ()
    stairs: tuple[CostStep, ...] = ()
    floors: Mapping[str, float] = field(default_factory=dict)
    unmet: tuple[str, ...] | None = None
    cheapest: Cheapest | None = None

    @property
    def best(self) -> Proposal:
        """The proposal with the largest value."""
        return self.proposals[0]

    @property
    def bound_value(self) -> float:
        """The bound as a value."""
        return (
            self.best.value if self.bound.kind == "proven" else max(self.best.value, self.bound.value / UNIT)
        )

    @property
    def gap(self) -> float:
        """Return the largest share by which the best proposal could be beaten."""
        return self.bound_value / self.best.value - 1.0 if self.best.value > 0.0 else 0.0

    def sentence(self) -> str:
        """Return the bound as one sentence."""
        additions, count = self.problem.additions, self.problem.count
        what = "pair" if additions.mirrored else "sensor"
        some = f"set of {count} {what}s" if count > 1 else what
        if self.problem.moves:
            names = [move.sensor for move in self.problem.moves]
            moved = " and ".join(filter(None, [", ".join(names[:-1]), names[-1]]))
            some = f"{some} with another mount of {moved}" if count else f"other mount of {moved}"
        where = f"on these {self.candidates} mounts"
        if self.floors:
            where += " that keeps the floors"
        if self.cheapest is not None:
            said = (
                "none cheaper reaches" if self.cheapest.is_proven else "none cheaper was found that reaches"
            )
            where += f" at a cost of {self.cheapest.cost:g} ({said} {self.cheapest.value:g})"
        if self.bound.kind == "proven":
            return f"no {some} {where} is better in these {self.problem.frames} frames (proven)"
        gap = math.ceil(self.gap * 1000.0) / 10.0
        return f"no {some} {where} is better by more than {gap:.1f} % in these {self.problem.frames} frames"

    def floor_lines(self) -> list[str]:
        """Return whether the best proposal keeps each floor, as sentences."""
        floors = self.problem.floors.items()
        kept = {name: "keeps" if self.floors[name] >= floor - 1e-9 else "misses" for name, floor in floors}
        return [
            f"{name}: {self.floors[name]:.3f}, {kept[name]} the floor of {floor:g}." for name, floor in floors
        ]

    def to_dict(self) -> dict[str, Any]:
        """Return the result as plain data, by the names of the JSON."""
        return {
            "riglens": 1,
            "objective": self.problem.objective,
            "before": self.before,
            "reference": {"name": self.reference.name, "value": self.reference_value},
            "candidates": self.candidates,
            "frames": self.problem.frames,
            "held_out": self.problem.held_out,
            "seed": self.problem.seed,
            "bound": {"value": self.bound_value, "kind": self.bound.kind, "gap": self.gap},
            "proposals": [one.to_dict() for one in self.proposals],
            "front": [
                {"value": self.proposals[n].value, "blind_m2": self.proposals[n].blind_m2, "proposal": n}
                for n in self.front
            ],
            "floors": {
                name: {"floor": floor, "value": self.floors[name]}
                for name, floor in self.problem.floors.items()
            },
            "unmet": None if self.unmet is None else list(self.unmet),
            "cheapest": None if self.cheapest is None else vars(self.cheapest),
            "stairs": [{"count": one.count, "value": one.value} for one in self.stairs],
        }

    def save(self, folder: str | os.PathLike[str]) -> tuple[Path, ...]:
        """Write the proposals as rig files, and their figures as CSV; return the files."""
        return save_proposals(self.proposals, folder)


def save_proposals(proposals: Sequence[Proposal], folder: str | os.PathLike[str]) -> tuple[Path, ...]:
    """Write proposals as rig files, and their figures as CSV; return the files."""
    path = Path(folder)
    check_folder(path)
    try:
        path.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise InputError(f"{path} cannot be made ({error.strerror})", "out") from error
    files = [path / f"proposal-{number}.yaml" for number in range(1, len(proposals) + 1)]
    text = io.StringIO()
    table = csv.writer(text, lineterminator="\n")
    table.writerow(["file", "name", "on_target", "blind_m2", "cost", "verdict"])
    for file, one in zip(files, proposals, strict=True):
        new_rig_file(one.rig).save(file)
        blind = "" if one.blind_m2 is None else one.blind_m2
        table.writerow([file.name, spreadsheet_cell(one.rig.name), one.value, blind, one.cost, one.verdict])
    with atomic_write(path / TABLE, "w") as stream:
        stream.write(text.getvalue())
    return (*files, path / TABLE)


def check_folder(folder: str | os.PathLike[str]) -> None:
    """Raise InputError where proposals cannot be written into a folder."""
    path = Path(folder)
    if path.exists() and not path.is_dir():
        raise InputError(f"{path} must be a folder", "out")
