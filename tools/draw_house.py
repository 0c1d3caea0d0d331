"""Draws docs/images/house.svg: floors and rooms of RigLens, and the way of one drag through them.

Run it from the root of the project after changing a room: python tools/draw_house.py
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from xml.sax.saxutils import escape

TARGET = Path("docs/images/house.svg")
WIDTH, MARGIN, LABEL_WIDTH, GAP = 1120, 16, 150, 10
ROOM_HEIGHT, FLOOR_PAD = 54, 12
INK, GREY, PAPER, WAY = "#1f2933", "#5f6b76", "#ffffff", "#c62828"


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
        "riglens",
        ("the Python interface", "import riglens as rl"),
        "#ede7f6",
        ((Room("api", "for scripts"),),),
    ),
    Floor(
        "app",
        ("starts and wires", ""),
        "#e3f2fd",
        (
            (Room("commands", "the command line"),),
            (Room("window", "workbench and features", 5),),
            (
                Room("session", "current requests", 2),
                Room("studies", "prose and charts"),
                Room("rendering", "pictures for files"),
            ),
            (Room("background", "latest request wins", 3), Room("terminal", "tables, progress, notes")),
            (Room("evaluation", "scenes, scores, heatmaps"), Room("launch", "displays, libraries, folders")),
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
                Room("review", "blind zones, redundancy, tolerance, mounts"),
            ),
            (Room("simulate", "sweeps, with clutter, ground and noise"),),
            (
                Room("engine", "edits, exact to the last bit", 4),
                Room("targets", "points on road users"),
                Room("view", "one sensor, one frame"),
                Room("formats", "rigs of other programs"),
                Room("detect", "a small detector, AP"),
            ),
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


def text(
    x: float, y: float, words: str, size: int, colour: str = INK, weight: str = "normal", at: str = "start"
) -> str:
    """A line of text."""
    style = f'font-size="{size}" fill="{colour}" font-weight="{weight}" text-anchor="{at}"'
    return f'<text x="{x:g}" y="{y:g}" {style}>{escape(words)}</text>'


def room(x: float, y: float, width: float, it: Room) -> list[str]:
    """Return a room with its name and purpose, and its number on the path of a drag."""
    middle = x + width / 2
    parts = [
        f'<rect x="{x:g}" y="{y:g}" width="{width:g}" height="{ROOM_HEIGHT}" rx="5" fill="{PAPER}" stroke="{GREY}"/>'
    ]
    if it.name:
        parts.append(text(middle, y + 23, it.name, 15, weight="bold", at="middle"))
    parts.append(text(middle, y + (42 if it.name else 32), it.words, 12, GREY, at="middle"))
    if it.stop is not None:
        parts.append(f'<circle cx="{x + 18:g}" cy="{y + 18:g}" r="11" fill="{WAY}"/>')
        parts.append(text(x + 18, y + 22.5, str(it.stop), 13, PAPER, "bold", "middle"))
    return parts


def floor(y: float, it: Floor) -> tuple[list[str], float]:
    """A floor with all of its storeys, and the y below it."""
    height = 2 * FLOOR_PAD + len(it.storeys) * (ROOM_HEIGHT + GAP) - GAP
    full = WIDTH - 2 * MARGIN
    parts = [f'<rect x="{MARGIN}" y="{y:g}" width="{full}" height="{height}" rx="8" fill="{it.colour}"/>']
    parts.append(text(MARGIN + 14, y + 32, it.name, 18, weight="bold"))
    parts += [text(MARGIN + 14, y + 52 + 15 * n, words, 12, GREY) for n, words in enumerate(it.words)]
    left, inside = MARGIN + LABEL_WIDTH, full - LABEL_WIDTH - FLOOR_PAD
    for number, rooms in enumerate(it.storeys):
        width = (inside - GAP * (len(rooms) - 1)) / len(rooms)
        top = y + FLOOR_PAD + number * (ROOM_HEIGHT + GAP)
        for place, one in enumerate(rooms):
            parts += room(left + place * (width + GAP), top, width, one)
    return parts, y + height + GAP


def drawing() -> str:
    """The whole picture as SVG."""
    parts: list[str] = []
    y = float(MARGIN)
    for it in HOUSE:
        more, y = floor(y, it)
        parts += more
    note = "Imports go down, from floor to floor and from storey to storey. Red: the way of one mouse move."
    parts.append(text(MARGIN + 2, y + 14, note, 13, GREY))
    height = y + 28
    head = (
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {WIDTH} {height:g}" width="{WIDTH}" '
        f'height="{height:g}" font-family="sans-serif">'
    )
    return "\n".join([head, f'<rect width="100%" height="100%" fill="{PAPER}"/>', *parts, "</svg>", ""])


if __name__ == "__main__":
    TARGET.write_text(drawing(), encoding="utf-8")
