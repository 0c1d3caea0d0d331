"""Draws docs/images/house.svg: floors and rooms of RigLens, and the way of one drag through them.

Run it from the root of the project after changing a room: python -m tools.draw_house
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import accumulate
from pathlib import Path
from xml.sax.saxutils import escape

TARGET = Path("docs/images/house.svg")
WIDTH, MARGIN, LABEL_WIDTH, GAP = 1120, 16, 150, 10
ROOM_HEIGHT, FLOOR_PAD = 54, 12
WHITE, INK, GREY, FAINT, PAPER, RED = "#ffffff", "#1f2933", "#5f6b76", "#c3cbd3", "#fbfcfd", "#c62828"


@dataclass(frozen=True)
class Room:
    """A folder, in a few words; `stop` is its number on the way of a drag."""

    name: str
    words: str
    stop: int | None = None


@dataclass(frozen=True)
class Floor:
    """Layer: its rooms are arranged in storeys, and an upper storey may import a lower one."""

    name: str
    words: tuple[str, str]
    colour: str
    storeys: tuple[tuple[Room, ...], ...]


HOUSE = (
    Floor(
        "app",
        ("starts and wires", ""),
        "#e3f2fd",
        (
            (Room("commands", "the command line"),),
            (Room("window", "workbench and features", 5),),
            (Room("session", "current requests", 2),),
            (Room("background", "latest request wins", 3), Room("terminal", "tables, progress, notes")),
            (Room("launch", "folders, Ctrl-C"),),
        ),
    ),
    Floor(
        "riglens",
        ("every job as a", "function: riglens as rl"),
        "#ede7f6",
        (
            (Room("jobs", "what a command or a function does"),),
            (Room("reporting", "pages and PDFs about rigs"),),
            (Room("studies", "prose and charts"), Room("rendering", "pictures for files")),
            (Room("evaluation", "scenes, scores, heatmaps"),),
        ),
    ),
    Floor(
        "widgets",
        ("what a person", "sees and touches"),
        "#e8f5e9",
        (
            (Room("viewport", "the 3D view", 1), Room("maps", "pictures of a plane")),
            (Room("panels", "numbers, fields and lists", 6),),
            (
                Room("car", "body as drawn"),
                Room("heatmap", "cells, legend"),
                Room("sensors", "bodies, rays"),
                Room("traffic", "a frame's road users"),
                Room("gizmo", "handles, drags"),
            ),
            (Room("drawing", "camera, stage, letters: what all of them draw with"),),
        ),
    ),
    Floor(
        "core",
        ("the model and", "the mathematics"),
        "#fff8e1",
        (
            (
                Room("optimise", "proposed rigs, with a bound and a guard"),
                Room("sweep", "many rigs that differ in some fields"),
            ),
            (
                Room("study", "measuring methods, rigs and grids"),
                Room("review", "redundancy, tolerance, mounts, requirements"),
            ),
            (Room("simulate", "sweeps, with clutter, ground and noise"),),
            (Room("figures", "each figure, heatmap and map, defined once"),),
            (Room("footprint", "what sensors resolve and reach on the ground"),),
            (
                Room("blind", "near-field zones"),
                Room("targets", "points on road users"),
                Room("view", "one sensor, one frame"),
                Room("formats", "rigs of other programs"),
                Room("detect", "a small detector, AP"),
            ),
            (Room("engine", "edits, exact to the last bit", 4),),
            (Room("metric", "entropy, S-MIG, S-MS, seen"), Room("sensing", "rays and lenses")),
            (Room("scene", "grid, boxes, POG"), Room("vehicle", "meshes of bodies")),
            (Room("rig", "rigs, YAML, history, library"),),
            (Room("sensors", "each kind in one file: fields, rays, hits"),),
            (Room("kernels", "compiled loops"), Room("pieces", "resumable work, Dask")),
        ),
    ),
    Floor(
        "assets",
        ("data that ships", ""),
        "#eceff1",
        ((Room("", "sensor library, scenario, the paper's tables"),),),
    ),
)


class Drawing:
    """Shapes on a light card of their own, which is legible on a light page and on a dark one."""

    def __init__(self, width: int, height: int, title: str) -> None:
        card = f'<rect x="1" y="1" width="{width - 2}" height="{height - 2}" rx="8" fill="{PAPER}" stroke="{FAINT}"/>'
        self._parts = [
            f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width} {height}" width="{width}" '
            f'height="{height}" font-family="DejaVu Sans, Verdana, sans-serif">',
            f"<title>{escape(title)}</title>",
            card,
        ]

    def text(self, x: float, y: float, words: str, size: int, colour: str = INK, at: str = "start") -> None:
        """Write a line; bold where it starts with an asterisk."""
        weight = ' font-weight="bold"' if words.startswith("*") else ""
        style = f'font-size="{size}" fill="{colour}" text-anchor="{at}"{weight}'
        self._parts.append(f'<text x="{x:.1f}" y="{y:.1f}" {style}>{escape(words.lstrip("*"))}</text>')

    def box(
        self, x: float, y: float, width: float, height: float, fill: str, stroke: str, radius: int
    ) -> None:
        """Draw a rectangle with round corners."""
        self._parts.append(
            f'<rect x="{x:.1f}" y="{y:.1f}" width="{width:.1f}" height="{height:.1f}" rx="{radius}" fill="{fill}" '
            f'stroke="{stroke}"/>'
        )

    def dot(self, x: float, y: float, radius: int) -> None:
        """Draw a red disc."""
        self._parts.append(f'<circle cx="{x:.1f}" cy="{y:.1f}" r="{radius}" fill="{RED}" stroke="none"/>')

    def svg(self) -> str:
        """Return the file's text."""
        return "\n".join([*self._parts, "</svg>"]) + "\n"


def room(d: Drawing, x: float, y: float, width: float, it: Room) -> None:
    """Draw a room with its name and purpose, and its number on the path of a drag."""
    middle = x + width / 2
    d.box(x, y, width, ROOM_HEIGHT, WHITE, GREY, 5)
    if it.name:
        d.text(middle, y + 23, f"*{it.name}", 15, at="middle")
    d.text(middle, y + (42 if it.name else 32), it.words, 12, GREY, "middle")
    if it.stop is not None:
        d.dot(x + 18, y + 18, 11)
        d.text(x + 18, y + 22.5, f"*{it.stop}", 13, WHITE, "middle")


def height_of(it: Floor) -> int:
    """Return the height of a floor with all of its storeys."""
    return 2 * FLOOR_PAD + len(it.storeys) * (ROOM_HEIGHT + GAP) - GAP


def floor(d: Drawing, y: float, it: Floor) -> None:
    """Draw a floor with all of its storeys."""
    full = WIDTH - 2 * MARGIN
    d.box(MARGIN, y, full, height_of(it), it.colour, "none", 8)
    d.text(MARGIN + 14, y + 32, f"*{it.name}", 18)
    for number, words in enumerate(it.words):
        d.text(MARGIN + 14, y + 52 + 15 * number, words, 12, GREY)
    left, inside = MARGIN + LABEL_WIDTH, full - LABEL_WIDTH - FLOOR_PAD
    for number, rooms in enumerate(it.storeys):
        width = (inside - GAP * (len(rooms) - 1)) / len(rooms)
        top = y + FLOOR_PAD + number * (ROOM_HEIGHT + GAP)
        for place, one in enumerate(rooms):
            room(d, left + place * (width + GAP), top, width, one)


def drawing() -> str:
    """The whole picture as SVG."""
    tops = list(accumulate((height_of(it) + GAP for it in HOUSE), initial=MARGIN))
    d = Drawing(WIDTH, tops[-1] + 28, "Floors and rooms of RigLens")
    for y, it in zip(tops, HOUSE, strict=False):
        floor(d, y, it)
    note = "Imports go down, from floor to floor and from storey to storey. Red: the way of one mouse move."
    d.text(MARGIN + 2, tops[-1] + 14, note, 13, GREY)
    return d.svg()


if __name__ == "__main__":
    TARGET.write_text(drawing(), encoding="utf-8")
