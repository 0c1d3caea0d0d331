"""Define the result of a search for rigs, as data and as files."""

from __future__ import annotations

import csv
import io
import math
import os
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from riglens.core.errors import InputError
from riglens.core.figures.figure import Figure
from riglens.core.files import atomic_write
from riglens.core.optimise.bounds import Bound
from riglens.core.optimise.guard import KEPT, GuardResult, Verdict, verdict
from riglens.core.optimise.placing import Candidate
from riglens.core.optimise.problem import Problem
from riglens.core.optimise.skin import SkinGains
from riglens.core.rig.model import Rig
from riglens.core.rig.yaml.file import new_rig_file
from riglens.core.shown_text import spreadsheet_cell

TABLE = "proposals.csv"
CASTING = "casting"
_CASTING_SHARE = 0.7


@dataclass(frozen=True)
class Proposal:
    """A rig with candidates added or moved: its figure in the frames of choice, blind area if requested, the gain
    of each candidate over the rig without it, the guard's cases and what they say."""

    rig: Rig
    added: tuple[Candidate, ...]
    value: float
    blind_m2: float | None = None
    adds: tuple[float, ...] = ()
    guard: tuple[GuardResult, ...] = ()
    verdict: Verdict = "not checked"

    @property
    def cost(self) -> float:
        """Return the cost of the added sensors."""
        return math.fsum(one.cost for one in self.added)

    @property
    def weak(self) -> tuple[GuardResult, ...]:
        """Cases that keep less than half of the gain."""
        return tuple(one for one in self.guard if one.share < KEPT)

    def to_dict(self) -> dict[str, Any]:
        """Return the proposal as plain data, by the names of the JSON."""
        adds = self.adds or (None,) * len(self.added)
        sensors = [
            (sensor, more, one.cost / len(one.sensors))
            for one, more in zip(self.added, adds, strict=True)
            for sensor in one.sensors
        ]
        return {
            "name": self.rig.name,
            "value": self.value,
            "cost": self.cost,
            "sensors": [
                {
                    "name": s.name,
                    "model": s.model,
                    "position": list(s.position),
                    "rpy_deg": list(s.rpy_deg),
                    "cost": cost,
                    "adds": more,
                }
                for s, more, cost in sensors
            ],
            "guard": [{"case": k.case, "gain": k.gain, "se": k.se, "share": k.share} for k in self.guard],
            "verdict": self.verdict,
        }


@dataclass(frozen=True)
class OptimiseResult:
    """Proposals, the best first, then those of the front; no allowed set is better than `bound` in the frames of
    choice; `bound` is None if nothing bounds the figure.

    All values are those of the objective's figure, in its unit. before, reference_value: of the rig itself and of the
    one that gains refer to, in the same frames. unmet: the requirements that the best proposal does not meet, None
    without requirements.
    """

    problem: Problem
    candidates: int
    before: float
    before_blind_m2: float | None
    reference: Rig
    reference_value: float
    bound: Bound | None
    proposals: tuple[Proposal, ...]
    front: tuple[int, ...] = ()
    unmet: tuple[str, ...] | None = None

    @property
    def best(self) -> Proposal:
        """The proposal with the best value."""
        return self.proposals[0]

    @property
    def figure(self) -> Figure:
        """The figure that was to improve."""
        return self.problem.goal.figure

    @property
    def gain(self) -> float:
        """Return by how much the best proposal is better than the reference, in the frames of choice."""
        return self.problem.goal.sign * (self.best.value - self.reference_value)

    @property
    def bound_value(self) -> float | None:
        """The bound as a value."""
        if self.bound is None or self.bound.kind == "proven":
            return None if self.bound is None else self.best.value
        better: Callable[[float, float], float] = min if self.problem.goal.sign < 0.0 else max
        return better(self.best.value, self.bound.value)

    @property
    def gap(self) -> float | None:
        """Return the largest share by which the best proposal could be beaten: negative where less is better."""
        if self.bound_value is None:
            return None
        return self.bound_value / self.best.value - 1.0 if self.best.value > 0.0 else 0.0

    def checked(self, guard: tuple[GuardResult, ...]) -> OptimiseResult:
        """Return the result with cases of the guard of its best proposal."""
        best = replace(self.best, guard=guard, verdict=verdict(guard, self.figure.resolved))
        return replace(self, proposals=(best, *self.proposals[1:]))

    def sentence(self) -> str:
        """Return the bound as one sentence."""
        additions, count = self.problem.additions, self.problem.count
        what = "pair" if additions.mirrored else "sensor"
        some = f"set of {count} {what}s" if count > 1 else what
        if additions.counts:
            some, count = "choice within these counts", 1
        if self.problem.moves:
            names = [move.sensor for move in self.problem.moves]
            moved = " and ".join(filter(None, [", ".join(names[:-1]), names[-1]]))
            some = f"{some} with another mount of {moved}" if count else f"other mount of {moved}"
        where = f"on these {self.candidates} mounts"
        frames = f" in these {self.problem.frames} frames" if self.problem.goal.of_objects else ""
        if self.bound is None or self.gap is None:
            return f"the best {some} that was found {where}; no bound on others{frames}"
        if self.bound.kind == "proven":
            return f"no {some} {where} is better{frames} (proven)"
        gap = math.ceil(abs(self.gap) * 1000.0) / 10.0
        return f"no {some} {where} is better by more than {gap:.1f} %{frames}"

    def to_dict(self) -> dict[str, Any]:
        """Return the result as plain data, by the names of the JSON."""
        kind = "none" if self.bound is None else self.bound.kind
        return {
            "riglens": 1,
            "objective": self.problem.objective,
            "before": self.before,
            "reference": {"name": self.reference.name, "value": self.reference_value},
            "candidates": self.candidates,
            "frames": self.problem.frames,
            "held_out": self.problem.held_out,
            "seed": self.problem.seed,
            "bound": {"value": self.bound_value, "kind": kind, "gap": self.gap},
            "proposals": [one.to_dict() for one in self.proposals],
            "front": [
                {"value": self.proposals[n].value, "blind_m2": self.proposals[n].blind_m2, "proposal": n}
                for n in self.front
            ],
            "unmet": None if self.unmet is None else list(self.unmet),
        }

    def save(self, folder: str | os.PathLike[str]) -> tuple[Path, ...]:
        """Write the proposals as rig files, and their figures as CSV; return the files."""
        path = Path(folder)
        check_folder(path)
        try:
            path.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            raise InputError(f"{path} cannot be made ({error.strerror})", "out") from error
        files = [path / f"proposal-{number}.yaml" for number in range(1, len(self.proposals) + 1)]
        text = io.StringIO()
        table = csv.writer(text, lineterminator="\n")
        table.writerow(["file", "name", "value", "blind_m2", "cost", "verdict"])
        for file, one in zip(files, self.proposals, strict=True):
            new_rig_file(one.rig).save(file)
            blind = "" if one.blind_m2 is None else one.blind_m2
            table.writerow(
                [file.name, spreadsheet_cell(one.rig.name), one.value, blind, one.cost, one.verdict]
            )
        with atomic_write(path / TABLE, "w") as stream:
            stream.write(text.getvalue())
        return (*files, path / TABLE)


@dataclass(frozen=True)
class Progress:
    """Progress of a search: the current step, the share of it that is done, and the best rig so far.

    value, bound: the figure of the best rig and of any other, once candidates have been cast; skin: their gains for any
    rig; result: what is known, once all but the guard is done.
    """

    stage: str
    share: float
    best: Rig | None = None
    value: float | None = None
    bound: float | None = None
    skin: SkinGains | None = None
    result: OptimiseResult | None = None

    @property
    def of_all(self) -> float:
        """Share of the whole search that is done; most of it is casting."""
        return _CASTING_SHARE * (self.share if self.stage == CASTING else 1.0)


def check_folder(folder: str | os.PathLike[str]) -> None:
    """Raise InputError where proposals cannot be written into a folder."""
    path = Path(folder)
    if path.exists() and not path.is_dir():
        raise InputError(f"{path} must be a folder", "out")
