"""Load rigs, scenes and traffic on the terminal: with progress bars, and notes on the data."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from riglens.app.terminal.console import TERMINAL
from riglens.core.metric.entropy import EntropyField
from riglens.core.metric.scores import Body
from riglens.core.rig.model import Rig
from riglens.core.scene.pog import Pog
from riglens.core.targets.traffic import Traffic
from riglens.evaluation import loading
from riglens.evaluation.options import SceneOptions, ScoreOptions


def load_rig(name: str) -> Rig:
    """Open a preset, a rig file or a file of another program."""
    return loading.load_rig(name, TERMINAL)


def load_rigs(
    names: Sequence[str],
    score: ScoreOptions,
    libraries: Sequence[Path] = (),
    housings: Body | None = None,
) -> list[Rig]:
    """Open rigs with the meshes of bodies that stop rays."""
    return loading.load_rigs(names, score, TERMINAL, libraries, housings)


def load_scene(
    options: SceneOptions, rigs: Sequence[Rig] = (), score: ScoreOptions | None = None
) -> tuple[Pog, EntropyField]:
    """Load the scene that rigs are scored on."""
    return loading.load_scene(options, TERMINAL, rigs, score)


def load_traffic(options: SceneOptions, within_m: float) -> Traffic:
    """Load the objects that points and pixels are counted on."""
    return loading.load_traffic(options, within_m, TERMINAL)
