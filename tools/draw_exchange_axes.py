"""Draws docs/images/exchange-axes.svg: origin and axes of every rig format on a car seen from its right side.

Run it from the root of the project after changing a panel: python -m tools.draw_exchange_axes
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from tools.drawing import BLUE, FAINT, GREEN, GREY, RED, Drawing, Point

TARGET = Path("docs/images/exchange-axes.svg")
WIDTH, HEIGHT, COLUMNS, GAP = 306, 236, 3, 10
GROUND, REAR, FRONT, CENTRE, AXLE, ROOF = 150, 76, 206, 146, 136, 84
ARROW = 46
BODY = (
    "M 36 132 Q 34 112 54 108 L 84 104 Q 98 86 122 84 L 158 84 Q 182 86 200 104 L 232 110 Q 250 114 250 132 "
    "L 226 132 A 20 20 0 0 0 186 132 L 96 132 A 20 20 0 0 0 56 132 Z"
)
"""A car that drives to the right."""
LENS, WHITE, METAL = "M 0 0 l -34 -11 l 0 22 z", "#ffffff", "#eef1f4"


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
    Panel(
        "Basalt",
        (CENTRE + 24, ROOF - 4),
        ISO,
        ("IMU, anywhere: x forward unless tipped · m", "quaternion x y z w · cameras optical"),
    ),
    Panel(
        "Audi A2D2", (REAR, AXLE), ISO, ("middle of the rear axle · m", "x and y axes of each sensor · body")
    ),
    Panel(
        "SDFormat",
        (CENTRE, GROUND),
        ISO,
        ("model: taken under the body centre · m", "roll pitch yaw rad, or ° · body"),
    ),
    Panel(
        "ONCE",
        (CENTRE, ROOF - 6),
        {"x": "away", "y": "back", "z": "up"},
        ("LiDAR on the roof: x left, y back · m", "4 × 4 matrices from the camera · optical"),
    ),
    Panel(
        "DDAD, ZOD",
        (REAR, GROUND),
        ISO,
        ("ground under the rear axle, ZOD: taken · m", "quaternion, 4 × 4 matrices · optical"),
    ),
    Panel(
        "DAIR-V2X, LIO-SAM, vlcal",
        (CENTRE, ROOF - 6),
        ISO,
        ("LiDAR on the roof · m", "matrices or quaternion · cameras optical"),
    ),
    Panel(
        "OPV2V",
        (CENTRE, GROUND),
        {"x": "forward", "y": "near", "z": "up"},
        ("left-handed: y right, pitch up, yaw right", "poses in the map of CARLA · ° · body"),
    ),
    Panel(
        "LGSVL",
        (CENTRE, GROUND),
        {"x": "near", "y": "up", "z": "forward"},
        ("left-handed: pitch down, yaw right · m", "vehicle: taken under body centre · ° · body"),
    ),
    Panel(
        "ORB-SLAM3, R3LIVE",
        (CENTRE + 24, ROOF - 4),
        ISO,
        ("IMU, or camera 1, anywhere · m", "4 × 4 matrices from the camera · optical"),
    ),
    Panel("ASAM OSI", (REAR, AXLE), ISO, ("middle of the rear axle itself · m", "roll pitch yaw rad · body")),
)


def frame(d: Drawing, at: Point, axes: dict[str, str]) -> None:
    """Axes in a point: arrows in the plane of the picture; a dot towards the reader, a cross away."""
    steps = {"forward": (ARROW, 0), "back": (-ARROW, 0), "up": (0, -ARROW), "down": (0, 28)}
    x, y = at
    for (name, where), colour in zip(axes.items(), (RED, GREEN, BLUE), strict=True):
        if where in steps:
            dx, dy = steps[where]
            d.arrow(at, (x + dx, y + dy), colour)
            place = (x + dx + (4 if dx > 0 else -4), y - 8) if dx else (x + 10, y + dy + (4 if dy < 0 else 6))
        else:
            cx, cy = x - 18, y - 21
            d.dot(cx, cy, 7, WHITE, colour)
            if where == "near":
                d.dot(cx, cy, 2.6, colour)
            else:
                d.shape("M -4.5 -4.5 l 9 9 m 0 -9 l -9 9", cx, cy, stroke=colour)
            place = cx - 15, cy + 4
        d.dot(place[0], place[1] - 4, 6, WHITE)  # keeps it legible on lines
        d.text(*place, f"*{name}", 13, colour, "middle")
    d.dot(x, y, 4.5)


def panel(d: Drawing, left: float, top: float, found: Panel) -> None:
    """Draw a format: a car on the ground, and the frame on it."""
    d.shape(BODY, left, top, METAL)
    for x in (REAR, FRONT):
        d.dot(left + x, top + AXLE, 14, WHITE, GREY)
    d.line([(left + 16, top + GROUND), (left + 290, top + GROUND)], GREY, 1.5)
    frame(d, (left + found.origin[0], top + found.origin[1]), found.axes)
    d.text(left + 14, top + 24, f"*{found.title}", 15)
    for row, words in enumerate(found.lines):
        d.text(left + 14, top + 198 + 20 * row, words)


def legend(d: Drawing, left: float, top: float) -> None:
    """Draw the two orientations of a camera, and a key of the crosses and dots."""
    d.text(left + 14, top + 24, "*Sensors", 15)
    for x, words, axes in (
        (78, "body axes", {"x": "forward", "y": "away", "z": "up"}),
        (206, "optical axes", {"x": "near", "y": "down", "z": "forward"}),
    ):
        d.shape(LENS, left + x, top + 100, METAL)
        frame(d, (left + x, top + 100), axes)
        d.text(left + x - 36, top + 178, words)
    d.text(left + 14, top + 200, "⊗ away from you: to the left of the car", 12, GREY)
    d.text(left + 14, top + 219, "⊙ at you: to its right · cars drive to the right", 12, GREY)


def drawing() -> str:
    """The whole picture."""
    rows = -(-(len(PANELS) + 1) // COLUMNS)
    size = GAP + COLUMNS * (WIDTH + GAP), GAP + rows * (HEIGHT + GAP)
    d = Drawing(*size, "Origin and axes of every rig format")
    for index in range(len(PANELS) + 1):
        x, y = GAP + index % COLUMNS * (WIDTH + GAP), GAP + index // COLUMNS * (HEIGHT + GAP)
        d.box(x, y, WIDTH, HEIGHT, WHITE, FAINT, 6)
        if index < len(PANELS):
            panel(d, x, y, PANELS[index])
        else:
            legend(d, x, y)
    return d.svg()


if __name__ == "__main__":
    TARGET.write_text(drawing(), encoding="utf-8")
