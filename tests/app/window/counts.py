"""Counts of a little random traffic, for features that show what a rig gets onto road users."""

from __future__ import annotations

import numpy as np

from riglens.app.background.counting import CountAnswer, CountRequest
from riglens.core.targets.engine import TargetEngine
from tests.app.window.desk import FullDesk
from tests.core.targets.cases import random_traffic

TRAFFIC = random_traffic(np.random.default_rng(5), 6)
ENGINE = TargetEngine(TRAFFIC, threads=1)


def answer(request: CountRequest, frames: int | None = None) -> CountAnswer:
    """The answer to a request, from so many frames."""
    with_losses = request.with_losses and frames is None
    counted = ENGINE.evaluate(request.rig, request.settings, frames, with_losses=with_losses)
    baseline = ENGINE.evaluate(request.baseline_rig, request.settings, frames)
    return CountAnswer.of(request, counted, baseline)


def count(desk: FullDesk, frames: int | None = None) -> None:
    """Answer what was asked last."""
    request = desk.counter.requests[-1]
    desk.features.targets._take(request, answer(request, frames))
