"""Draws docs/images/simulate.png: what two LiDARs and a camera measure in one frame of the bundled town.

Run it from the root of the project: python -m tools.draw_simulate
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import BoundaryNorm, ListedColormap
from matplotlib.figure import Figure

from riglens.core.rig.model import Camera, Lidar, LinearAngles, Rig
from riglens.core.scene.readers import bundled_occluders, bundled_source
from riglens.core.simulate.pictures import LABELS, Cameras, class_labels
from riglens.core.simulate.settings import SimulationSettings
from riglens.core.simulate.sweeps import STATIC, Simulator
from riglens.core.simulate.world import TrueBoxes, Worlds
from riglens.core.targets.traffic import read_traffic

TARGET = Path("docs/images/simulate.png")
FRAME, REACH_M = 2089, 26.0
COLOURS = ("black", "#3b82f6", "#f59e0b", "#ec4899", "#94a3b8", "#475569", "#bfdbfe", "#0f172a")
CLASS_COLOURS = dict(zip(range(3), COLOURS[1:4], strict=True))


def lidar(name: str, y_m: float) -> Lidar:
    """A LiDAR of 32 beams at an edge of the roof."""
    return Lidar(
        name=name,
        position=(0.2, y_m, 1.75),
        elevations_deg=LinearAngles(from_=-25.0, to=8.0, count=32),
        azimuths_deg=LinearAngles(from_=-180.0, to=180.0, count=1080),
        range_m=(0.5, 120.0),
    )


RIG = Rig(
    name="shown",
    sensors=(
        lidar("left", 0.6),
        lidar("right", -0.6),
        Camera(
            name="back",
            position=(-0.4, 0.0, 1.6),
            rpy_deg=(0.0, 0.0, 180.0),
            hfov_deg=80.0,
            image=(1200, 675),
        ),
    ),
)


def from_above(axes: Axes, simulator: Simulator) -> None:
    """Draw the points of the sweep by surface, and the boxes of the objects."""
    sweep, truth = simulator.sweep(FRAME), simulator.worlds.truth(FRAME)
    on = np.where(sweep.object >= 0, np.append(truth.cls, 0)[np.maximum(sweep.object, -1)] + 1, 5)
    on = np.where(sweep.object == STATIC, 4, on)
    colours = np.array(COLOURS)[on]
    axes.scatter(sweep.points_m[:, 0], sweep.points_m[:, 1], s=0.8, c=colours, linewidths=0)
    outline(axes, truth)
    axes.set(xlim=(-REACH_M, REACH_M), ylim=(-REACH_M * 0.56, REACH_M * 0.56), aspect="equal")
    axes.set_xlabel("x ahead, m", fontsize=7)
    axes.set_ylabel("y to the left, m", fontsize=7)
    axes.tick_params(labelsize=6)


def outline(axes: Axes, truth: TrueBoxes) -> None:
    """Footprints of the boxes."""
    corners = np.array([[1, 1], [1, -1], [-1, -1], [-1, 1], [1, 1]])
    for cls, centre, size, turn in zip(truth.cls, truth.centre_m, truth.size_m, truth.rotation, strict=True):
        places = (corners * size[:2] / 2) @ turn[:2, :2].T + centre[:2]
        axes.plot(*places.T, color=CLASS_COLOURS[int(cls)], linewidth=1.0)


def main() -> None:
    """Draw it."""
    traffic = read_traffic(bundled_source(), occluders=bundled_occluders())
    worlds = Worlds(traffic, SimulationSettings(body="blocks"))
    picture = Cameras(RIG, worlds).picture(0, FRAME)
    figure = Figure(figsize=(11, 6.0), layout="constrained")
    ((one, two), (three, four)) = figure.subplots(2, 2)
    one.imshow(picture.rgb)
    one.set_title("picture", fontsize=9)
    norm = BoundaryNorm(np.arange(len(LABELS) + 1) - 0.5, len(LABELS))
    labels = class_labels(picture.what, worlds.truth(FRAME).cls)
    shown = two.imshow(labels, cmap=ListedColormap(COLOURS), norm=norm, interpolation="nearest")
    bar = figure.colorbar(shown, ax=two, ticks=range(len(LABELS)), shrink=0.85)
    bar.ax.set_yticklabels(LABELS, fontsize=7)
    two.set_title("class of each pixel", fontsize=9)
    depth = np.where(np.isfinite(picture.depth_m), picture.depth_m, np.nan)
    bar = figure.colorbar(three.imshow(depth, cmap="viridis_r", vmax=60.0), ax=three, shrink=0.85)
    bar.ax.tick_params(labelsize=7)
    three.set_title("depth, m", fontsize=9)
    for axes in (one, two, three):
        axes.set_axis_off()
    from_above(four, Simulator(RIG, worlds))
    four.set_title("sweep of both LiDARs from above, by what the points are on", fontsize=9)
    figure.savefig(TARGET, dpi=110)


if __name__ == "__main__":
    main()
