"""Frame: drawing one step of a drag, heatmap and fans on, against drawing the same actors unchanged."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace

import pytest
import pyvista as pv
from vtkmodules.vtkRenderingCore import vtkRenderer

from riglens.core.figures.heatmaps import SEEN_ENTROPY, Heatmaps, Marks
from riglens.core.rig.model import Rig
from riglens.core.view.display import DisplayGrid
from riglens.core.view.heatmap_data import HeatmapData
from riglens.widgets.drawing.stage import props_of, render_window
from riglens.widgets.viewport.drawn_scene import DrawnScene
from riglens.widgets.viewport.scene_state import SceneState
from tests.bench.race import Goal, Race
from tests.bench.scenes import Scene as BenchScene
from tests.bench.scenes import Scenes, moved, names_of, wide_trapezoid

SIZE_PX = [1280, 800]
GOAL = 1.3


@dataclass(frozen=True)
class _Step:
    rig: Rig
    heatmap: HeatmapData | None


@pytest.mark.parametrize("kind", ["lidar", "camera"])
def test_drag_step(race: Race, scenes: Scenes, xvfb: str, kind: str) -> None:
    bench = scenes.at(0.10)
    rig = wide_trapezoid()
    name = names_of(rig, kind)[0]
    plotter = pv.Plotter(off_screen=True, window_size=SIZE_PX, lighting="none")
    try:
        window = render_window(plotter)
        window.SetMultiSamples(0)
        scene = DrawnScene(plotter)
        steps = _steps(bench, rig, name)
        first = next(steps)
        scene.show(SceneState(rig=first.rig, selected=name, grid=bench.field.grid, heatmap=first.heatmap))
        scene.set_view("iso")
        scene.set_quick(True)

        def draw() -> None:
            window.Render()
            window.WaitForCompletion()

        def drag(step: _Step) -> None:
            """What the viewport does when the mouse moves and the scores of that place arrive."""
            scene.preview({name: step.rig.sensor(name).pose})
            scene.show(replace(scene.state, rig=step.rig, heatmap=step.heatmap))
            scene.prepare()
            draw()

        drag(next(steps))
        before = _actors(plotter)
        goal = Goal("frame", f"{name} of W+T dragged, 1280 x 800, seen entropy, {bench.edge}", GOAL, "lower")
        race.run(goal, steps, drag, lambda _: draw())
        assert _actors(plotter) == before, "a drag must not rebuild actors"
    finally:
        plotter.close()


def _actors(plotter: pv.Plotter) -> list[str]:
    """The VTK objects that are drawn, by address."""
    # VTK's stubs do not know that a collection can be iterated over
    renderers: Iterable[vtkRenderer] = render_window(plotter).GetRenderers()  # type: ignore[assignment]
    return sorted(prop.GetAddressAsString("") for renderer in renderers for prop in props_of(renderer))


def _steps(bench: BenchScene, rig: Rig, name: str) -> Iterator[_Step]:
    """The sensor a little elsewhere, with the heatmap that belongs to it, without end."""
    heatmaps, engine = Heatmaps(DisplayGrid.build(bench.pog, bench.field)), bench.engine()
    number = 0
    while True:
        number += 1
        rig = rig.with_sensor(name, moved(wide_trapezoid().sensor(name), number))
        evaluation = engine.evaluate(rig)
        yield _Step(rig, heatmaps.drawn(SEEN_ENTROPY, "car", Marks(evaluation.seen_by_any())))
