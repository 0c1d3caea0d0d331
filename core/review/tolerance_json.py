"""Tolerances as plain data: shares as fractions, mm and degrees."""

from __future__ import annotations

from typing import Any

from riglens.core.plain import to_plain
from riglens.core.review.measures import ON_TARGET, Measures
from riglens.core.review.tolerance import ToleranceResult, rig_of_draw
from riglens.core.rig.model import FORMAT_VERSION
from riglens.core.rig.yaml.file import identity_of
from riglens.core.scene.boxes import CLASSES

SPREAD = ("nominal", "median", "p05", "p95", "worst", "worst_draw")


def tolerance_document(found: ToleranceResult, body: str, measures: Measures | None = None) -> dict[str, Any]:
    """Return the tolerance of a rig under one profile; with what measured it, also the sample and its standard
    errors."""
    return {
        "riglens": FORMAT_VERSION,
        "body": body,
        "rig": identity_of(found.rig),
        "profile": to_plain(found.profile),
        "draws": found.draws,
        "seed": found.seed,
        "figures": {name: to_plain(spread, *SPREAD) for name, spread in found.spreads.items()},
        "noise_floor": {name: to_plain(spread, *SPREAD) for name, spread in found.floor.items()},
        "sensitivities": to_plain(found.sensitivities),
        **({} if measures is None else {"sample": _sample(found, measures)}),
    }


def _sample(found: ToleranceResult, measures: Measures) -> dict[str, Any]:
    """Return the number of frames in which objects were counted, and the standard error of each worst draw's change
    from the rig as designed, whose figures are those of all frames."""
    frames, of_frames = measures.frames
    worst_se = {}
    for cls in CLASSES:
        name = f"{ON_TARGET} {cls}"
        if name in found.spreads:
            drawn = rig_of_draw(found, found.spreads[name].worst_draw)
            worst_se[name] = measures.on_target(*drawn)[name].se
    return {"frames": frames, "of_frames": of_frames, "worst_se": worst_se}
