"""The streets of the bundled town: where they run, how wide they are, and as input of SUMO's netconvert.

Map frame: x east, y north, metres. Everything follows from SEED.
"""

from __future__ import annotations

import math
import random
import xml.etree.ElementTree as ET
from dataclasses import dataclass
from pathlib import Path

SEED = 20260

COLUMNS, ROWS = 7, 5
BLOCK_M = 140.0
NODE_SHIFT_M = 18.0
BEND_M = 14.0
APPROACH_M = 160.0


@dataclass(frozen=True)
class Street:
    """One direction of a street; lanes (who may use it, width_m) from the kerb to the middle."""

    name: str
    speed_mps: float
    priority: int
    lanes: tuple[tuple[str, float], ...]


MOTOR = "passenger delivery truck bus motorcycle"
MIXED = MOTOR + " bicycle"
PARKING = "custom1"
SIDEWALK = ("pedestrian", 3.0)
BIKE_LANE = ("bicycle", 1.8)

BOULEVARD = Street("boulevard", 13.89, 4, (SIDEWALK, BIKE_LANE, (MOTOR, 3.2), (MOTOR, 3.2), (MOTOR, 3.2)))
AVENUE = Street("avenue", 13.89, 3, (SIDEWALK, BIKE_LANE, (MOTOR, 3.3), (MOTOR, 3.3)))
COLLECTOR = Street("collector", 11.11, 2, (SIDEWALK, BIKE_LANE, (PARKING, 2.4), (MOTOR, 3.3)))
SIDE_STREET = Street("side street", 8.33, 1, (("pedestrian", 2.5), (PARKING, 2.4), (MIXED, 3.2)))
APPROACH = Street("approach", 13.89, 2, ((MIXED, 3.4),))

ROW_STREETS = (SIDE_STREET, AVENUE, COLLECTOR, BOULEVARD, SIDE_STREET)
COLUMN_STREETS = (SIDE_STREET, AVENUE, SIDE_STREET, BOULEVARD, COLLECTOR, AVENUE, SIDE_STREET)

NodeKey = tuple[int, int]
Point = tuple[float, float]


@dataclass(frozen=True)
class Segment:
    """One block of a street between two nodes; both directions share the bend of the centre line."""

    start: NodeKey
    end: NodeKey
    street: Street
    bend_m: float

    @property
    def half_width_m(self) -> float:
        """From the middle of the road to the outer edge of one side."""
        return sum(width_m for _, width_m in self.street.lanes)


def rng_for(*key: object) -> random.Random:
    """Return a separate random stream for a purpose or an object, so that adding one does not disturb the others."""
    return random.Random(":".join(map(str, (SEED, *key))))


def node_positions() -> dict[NodeKey, Point]:
    """Map positions in metres: a shifted grid, plus the outer ends of the approaches."""
    rng = rng_for("nodes")
    grid = [(i, j) for i in range(COLUMNS) for j in range(ROWS)]
    shift_m = {key: [rng.uniform(-NODE_SHIFT_M, NODE_SHIFT_M) for _ in range(2)] for key in grid}
    nodes = {(i, j): (i * BLOCK_M + shift_m[i, j][0], j * BLOCK_M + shift_m[i, j][1]) for i, j in grid}
    for i, j, di, dj in approach_ends():
        x, y = nodes[i, j]
        nodes[i + di, j + dj] = (x + di * APPROACH_M, y + dj * APPROACH_M)
    return nodes


def approach_ends() -> list[tuple[int, int, int, int]]:
    """(column, row, step x, step y) of the border nodes where a main street leaves the town."""
    rows = [j for j, street in enumerate(ROW_STREETS) if street is not SIDE_STREET]
    columns = [i for i, street in enumerate(COLUMN_STREETS) if street is not SIDE_STREET]
    west_east = [(i, j, di, 0) for j in rows for i, di in ((0, -1), (COLUMNS - 1, 1))]
    south_north = [(i, j, 0, dj) for i in columns for j, dj in ((0, -1), (ROWS - 1, 1))]
    return west_east + south_north


def town_segments() -> list[Segment]:
    """All blocks of all streets; main streets bend less than side streets."""
    rng = rng_for("bends")
    pairs = [((i, j), (i + 1, j), ROW_STREETS[j]) for j in range(ROWS) for i in range(COLUMNS - 1)]
    pairs += [((i, j), (i, j + 1), COLUMN_STREETS[i]) for i in range(COLUMNS) for j in range(ROWS - 1)]
    pairs += [((i, j), (i + di, j + dj), APPROACH) for i, j, di, dj in approach_ends()]
    return [Segment(start, end, street, rng.choice((0.0, -BEND_M, BEND_M))) for start, end, street in pairs]


def centre_line(start: Point, end: Point, bend_m: float) -> list[Point]:
    """Return the points (metres) of a smooth arc whose middle is `bend_m` off the straight line."""
    dx, dy = end[0] - start[0], end[1] - start[1]
    length = math.hypot(dx, dy)
    count = 12 if bend_m else 1
    offsets = [(k / count, bend_m * math.sin(math.pi * k / count) ** 2) for k in range(count + 1)]
    return [(start[0] + s * dx - o * dy / length, start[1] + s * dy + o * dx / length) for s, o in offsets]


def node_name(key: NodeKey) -> str:
    """The id of a node in SUMO's files."""
    return "n" + "_".join(str(k).replace("-", "m") for k in key)


def street_table(map_name: str) -> str:
    """Return the text of the table of all streets: their middles, and their lanes from the kerb to the middle."""
    uses = {"pedestrian": "sidewalk", "bicycle": "bike", PARKING: "parking"}
    nodes, rows = node_positions(), ["map,street,lanes,x,y"]
    for number, one in enumerate(town_segments()):
        lanes = "/".join(f"{uses.get(allow, 'motor')} {width_m:g}" for allow, width_m in one.street.lanes)
        line = centre_line(nodes[one.start], nodes[one.end], one.bend_m)
        rows += [f"{map_name},{number},{lanes},{x:.2f},{y:.2f}" for x, y in line]
    return "\n".join(rows) + "\n"


def write_xml(root: ET.Element, path: Path) -> None:
    """Write a file of SUMO."""
    ET.indent(root)
    ET.ElementTree(root).write(path, encoding="utf-8")


def write_nodes(path: Path, nodes: dict[NodeKey, Point], segments: list[Segment]) -> None:
    """Traffic lights where two main streets meet, right of way elsewhere."""
    root = ET.Element("nodes")
    for key, (x, y) in nodes.items():
        main = sum(key in (s.start, s.end) for s in segments if s.street.priority >= 2)
        kind = "traffic_light" if main >= 3 else "priority"
        ET.SubElement(root, "node", id=node_name(key), x=f"{x:.2f}", y=f"{y:.2f}", type=kind)
    write_xml(root, path)


def _add_edge(root: ET.Element, start: NodeKey, end: NodeKey, street: Street, line: list[Point]) -> None:
    ends = {"from": node_name(start), "to": node_name(end)}
    rank = {"type": street.name, "priority": str(street.priority), "speed": str(street.speed_mps)}
    shape = " ".join(f"{x:.2f},{y:.2f}" for x, y in line)
    form = {"id": "{from}to{to}".format(**ends), "numLanes": str(len(street.lanes)), "shape": shape}
    edge = ET.SubElement(root, "edge", form | ends | rank)
    for index, (allow, width_m) in enumerate(street.lanes):
        ET.SubElement(edge, "lane", index=str(index), allow=allow, width=str(width_m))


def write_edges(path: Path, nodes: dict[NodeKey, Point], segments: list[Segment]) -> None:
    """Both directions of every segment."""
    root = ET.Element("edges")
    for s in segments:
        line = centre_line(nodes[s.start], nodes[s.end], s.bend_m)
        _add_edge(root, s.start, s.end, s.street, line)
        _add_edge(root, s.end, s.start, s.street, line[::-1])
    write_xml(root, path)
