"""Every model of the library, upright and tilted, on one thread: the way it is cast, and how it compares with plain DDA
that sums competently. No model is to be slower.
"""

from __future__ import annotations

import pytest

from tests.bench.race import Goal, Race
from tests.bench.scenes import Scenes, competent_edit, models, moves, way_taken, with_model

MODELS = [entry.name for kind in ("lidar", "camera") for entry in models().entries(kind)]
GOAL = 1.0
ROUNDS = 5


@pytest.mark.parametrize("pose", ["upright", "tilted"])
@pytest.mark.parametrize("model", MODELS)
def test_model(race: Race, scenes: Scenes, model: str, pose: str) -> None:
    scene = scenes.at(0.10)
    rig, name = with_model(model, pose)
    engine = scene.engine(1)
    engine.evaluate(rig)
    way = way_taken(scene, rig.sensor(name))
    race.run(
        Goal("library", f"{model}, {pose}, by {way}, {scene.edge}", GOAL),
        moves(scene, rig, [name]),
        lambda m: engine.evaluate(m.rig, with_seen=False),
        lambda m: competent_edit(scene, m),
        rounds=ROUNDS,
    )
