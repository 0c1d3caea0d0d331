"""Draws docs/images/exchange-axes.svg: origin and axes of every rig format on a car seen from its right side.

Run it from the root of the project after changing a panel: python tools/draw_exchange_axes.py
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from xml.sax.saxutils import escape

TARGET = Path("docs/images/exchange-axes.svg")
WIDTH, HEIGHT, COLUMNS, GAP = 306, 236, 3, 10
GROUND, REAR, FRONT, CENTRE, AXLE, ROOF = 150, 76, 206, 146, 136, 84
RED, GREEN, BLUE, INK, GREY = "#c62828", "#2e7d32", "#1565c0", "#1f2933", "#5f6b76"
ARROW = 46


@dataclass(frozen=True)
class Panel:
    """One format: where its origin is on the car, where its axes point, and two lines of text."""

    title: str
    origin: tuple[int, int]
    axes: dict[str, str]
    lines: tuple[str, str]


ISO = {"x": "forward", "y": "away", "z": "up"}
PANELS = (
    Panel(
        "RigLens",
        (CENTRE, GROUND),
        ISO,
        ("ground under the body centre · m", "roll pitch yaw °, R = Rz·Ry·Rx"),
    ),
    Panel(
        "nuScenes",
        (REAR, GROUND),
        ISO,
        ("ground under the rear axle · m", "quaternion w x y z · cameras optical"),
    ),
    Panel(
        "Autoware",
        (REAR, GROUND),
        ISO,
        ("base_link: ground under rear axle · m", "roll pitch yaw rad · camera_link: body"),
    ),
    Panel(
        "ROS URDF",
        (REAR, GROUND),
        ISO,
        ("base_link: taken / written here · m", "rpy rad · …_optical: optical"),
    ),
    Panel(
        "CARLA, ROS bridge",
        (CENTRE, GROUND),
        ISO,
        ("actor: ground under body centre · m", "roll pitch yaw ° in ROS axes · body"),
    ),
    Panel(
        "CARLA, published TOML",
        (CENTRE, GROUND),
        {"x": "forward", "y": "near", "z": "up"},
        ("left-handed: y right, pitch up, yaw right", "°, flat lists of LiDARs rad · m · body"),
    ),
    Panel(
        "DriveWorks",
        (REAR, GROUND),
        ISO,
        ("ground under the rear axle · m", "roll pitch yaw ° + corrections · body"),
    ),
    Panel(
        "PandaSet",
        (CENTRE, ROOF - 6),
        {"x": "away", "y": "back", "z": "up"},
        ("Pandar64 on the roof: x left, y back · m", "quaternion w x y z, to sensor · optical"),
    ),
    Panel(
        "Kalibr",
        (CENTRE + 24, ROOF - 4),
        ISO,
        ("IMU (or camera 0), anywhere · m", "4 × 4 matrices to the camera · optical"),
    ),
    Panel(
        "KITTI",
        (CENTRE + 8, ROOF - 6),
        ISO,
        ("Velodyne on the roof · m", "3 × 4 and 3 × 3 matrices · optical"),
    ),
    Panel(
        "Argoverse 2",
        (REAR, AXLE),
        ISO,
        ("middle of the rear axle itself · m", "quaternion w x y z · cameras optical"),
    ),
    Panel(
        "OpenCV, ROS, VINS",
        (CENTRE + 24, ROOF - 4),
        ISO,
        ("IMU (or the camera), anywhere · m", "4 × 4 matrices from the camera · optical"),
    ),
    Panel(
        "EuRoC, maplab, FAST-LIVO2",
        (CENTRE + 24, ROOF - 4),
        ISO,
        ("IMU, anywhere: x forward unless tipped · m", "4 × 4 matrices from the camera · optical"),
    ),
    Panel(
        "Apollo",
        (REAR, GROUND),
        {"x": "near", "y": "forward", "z": "up"},
        ("novatel: taken under the rear axle · m", "quaternion x y z w · cameras optical"),
    ),
    Panel(
        "KITTI-360",
        (REAR, AXLE),
        {"x": "forward", "y": "near", "z": "down"},
        ("GPS/IMU over the rear axle · m", "3 × 4 matrices · cameras optical"),
    ),
    Panel(
        "Boreas",
        (CENTRE, ROOF - 4),
        {"x": "near", "y": "forward", "z": "up"},
        ("Applanix, taken as on the roof · m", "4 × 4 matrices T_a_b · cameras optical"),
    ),
    Panel(
        "AirSim",
        (CENTRE, GROUND),
        {"x": "forward", "y": "near", "z": "down"},
        ("pawn: taken under the body centre · m", "roll pitch yaw °, up and right · body"),
    ),
    Panel(
        "MMDetection3D",
        (REAR, GROUND),
        ISO,
        ("ground under the rear axle, or LiDAR · m", "4 × 4 matrices · cameras optical"),
    ),
    Panel(
        "CARLA leaderboard agent",
        (CENTRE, GROUND),
        {"x": "forward", "y": "near", "z": "up"},
        ("left-handed: y right, pitch up, yaw right", "° · m · body"),
    ),
    Panel("ASAM OSI", (REAR, AXLE), ISO, ("middle of the rear axle itself · m", "roll pitch yaw rad · body")),
)


def text(
    x: float,
    y: float,
    words: str,
    size: int = 12,
    colour: str = INK,
    weight: str = "normal",
    at: str = "start",
) -> str:
    """A line of text."""
    style = f'font-size="{size}" fill="{colour}" font-weight="{weight}" text-anchor="{at}"'
    return f'<text x="{x:g}" y="{y:g}" {style}>{escape(words)}</text>'


def label(x: float, y: float, name: str, colour: str) -> str:
    """The name of an axis, with a white edge that keeps it legible on lines."""
    edge = f'<text x="{x:g}" y="{y:g}" font-size="13" font-weight="bold" text-anchor="middle" stroke="#fff"'
    return f'{edge} stroke-width="4">{name}</text>{text(x, y, name, 13, colour, "bold", "middle")}'


def car() -> str:
    """A car that drives to the right, and the ground."""
    body = (
        "M 36 132 Q 34 112 54 108 L 84 104 Q 98 86 122 84 L 158 84 Q 182 86 200 104 L 232 110 Q 250 114 250 132 "
        "L 226 132 A 20 20 0 0 0 186 132 L 96 132 A 20 20 0 0 0 56 132 Z"
    )
    wheels = "".join(
        f'<circle cx="{x}" cy="{AXLE}" r="14" fill="#fff" stroke="{GREY}" stroke-width="2"/>'
        for x in (REAR, FRONT)
    )
    ground = f'<line x1="16" y1="{GROUND}" x2="290" y2="{GROUND}" stroke="{GREY}" stroke-width="1.5"/>'
    return f'<path d="{body}" fill="#eef1f4" stroke="{GREY}" stroke-width="1.5"/>{wheels}{ground}'


def arrow(x: float, y: float, dx: float, dy: float, colour: str, name: str) -> str:
    """An axis in the plane of the picture with its name at the tip."""
    ends = f'x1="{x}" y1="{y}" x2="{x + dx}" y2="{y + dy}"'
    line = f'<line {ends} stroke="{colour}" stroke-width="2.5" marker-end="url(#{colour[1:]})"/>'
    place = (x + dx + (4 if dx > 0 else -4), y - 8) if dx else (x + 10, y + dy + (4 if dy < 0 else 6))
    return line + label(*place, name, colour)


def across(x: float, y: float, is_near: bool, colour: str, name: str) -> str:
    """Return an axis towards the reader (a dot) or away (a cross), next to the origin."""
    cx, cy = x - 18, y - 21
    ring = f'<circle cx="{cx}" cy="{cy}" r="7" fill="#fff" stroke="{colour}" stroke-width="2"/>'
    cross = f'<path d="M {cx - 4.5} {cy - 4.5} l 9 9 m 0 -9 l -9 9" stroke="{colour}" stroke-width="2"/>'
    inner = f'<circle cx="{cx}" cy="{cy}" r="2.6" fill="{colour}"/>' if is_near else cross
    return ring + inner + label(cx - 15, cy + 4, name, colour)


def frame(x: float, y: float, axes: dict[str, str]) -> str:
    """Axes in a point."""
    steps = {"forward": (ARROW, 0), "back": (-ARROW, 0), "up": (0, -ARROW), "down": (0, 28)}
    drawn = []
    for (name, where), colour in zip(axes.items(), (RED, GREEN, BLUE), strict=True):
        if where in steps:
            drawn.append(arrow(x, y, *steps[where], colour, name))
        else:
            drawn.append(across(x, y, where == "near", colour, name))
    return (
        "".join(drawn) + f'<circle cx="{x}" cy="{y}" r="4.5" fill="{INK}" stroke="#fff" stroke-width="1.5"/>'
    )


def box(index: int, content: str) -> str:
    """A panel in its place of the grid."""
    x, y = GAP + index % COLUMNS * (WIDTH + GAP), GAP + index // COLUMNS * (HEIGHT + GAP)
    border = f'<rect width="{WIDTH}" height="{HEIGHT}" rx="6" fill="#fff" stroke="#cfd6dc"/>'
    return f'<g transform="translate({x} {y})">{border}{content}</g>'


def panel(found: Panel) -> str:
    """A format."""
    words = (
        text(14, 24, found.title, 15, INK, "bold")
        + text(14, 198, found.lines[0])
        + text(14, 218, found.lines[1])
    )
    return car() + frame(*found.origin, found.axes) + words


def legend() -> str:
    """Return the two orientations of a camera, and a key of the crosses and dots."""
    lens = '<path d="M {0} {1} l -34 -11 l 0 22 z" fill="#eef1f4" stroke="#5f6b76"/>'
    body = lens.format(78, 100) + frame(78, 100, {"x": "forward", "y": "away", "z": "up"})
    optical = lens.format(206, 100) + frame(206, 100, {"x": "near", "y": "down", "z": "forward"})
    words = (
        text(14, 24, "Sensors", 15, INK, "bold") + text(40, 178, "body axes") + text(172, 178, "optical axes")
    )
    how = text(14, 200, "⊗ away from you: to the left of the car", 12, GREY)
    return (
        body
        + optical
        + words
        + how
        + text(14, 219, "⊙ at you: to its right · cars drive to the right", 12, GREY)
    )


def marker(colour: str) -> str:
    """The tip of an arrow."""
    shape = f'<path d="M 0 0 L 8 4 L 0 8 z" fill="{colour}"/>'
    size = 'markerWidth="8" markerHeight="8" refX="5" refY="4" markerUnits="userSpaceOnUse"'
    return f'<marker id="{colour[1:]}" {size} orient="auto">{shape}</marker>'


def drawing() -> str:
    """The whole picture."""
    boxes = [panel(found) for found in PANELS] + [legend()]
    rows = -(-len(boxes) // COLUMNS)
    width, height = GAP + COLUMNS * (WIDTH + GAP), GAP + rows * (HEIGHT + GAP)
    head = f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width} {height}" width="{width}" height="{height}"'
    defs = "".join(marker(colour) for colour in (RED, GREEN, BLUE))
    content = "\n".join(box(index, one) for index, one in enumerate(boxes))
    ground = f'<rect width="{width}" height="{height}" fill="#f5f7f9"/>'
    return f'{head} font-family="DejaVu Sans, Verdana, sans-serif"><defs>{defs}</defs>\n{ground}\n{content}\n</svg>\n'


if __name__ == "__main__":
    TARGET.write_text(drawing(), encoding="utf-8")
