"""Make the bundled scenario: boxes around ego cars that drive through a simulated town.

The town (curved multi-lane streets, traffic lights, bike lanes, sidewalks, crossings, parked cars) and its
traffic are written as SUMO input, simulated with libsumo, recorded every two seconds, and seen from several
cars in turn. Everything follows from SEED: a second run gives the same bytes. Needed only to make the asset:

    python3 -m venv sumo-env && sumo-env/bin/pip install eclipse-sumo==1.28.0 libsumo==1.28.0
    sumo-env/bin/python make_scenario.py      # writes boxes.csv.gz and scenario.json beside itself

Frames: SUMO gives the middle of the front bumper in a map frame (x east, y north) and a nautical angle in
degrees (0 = north, clockwise). Written boxes are in the ego vehicle frame: x forward, y left, z up, origin on
the ground under the centre of the ego car's body.
"""

from __future__ import annotations

import argparse
import gzip
import hashlib
import json
import math
import random
import subprocess
import tempfile
import xml.etree.ElementTree as ET
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import libsumo
import sumo

SEED = 20260
SUMO_VERSION = "1.28.0"

STEP_S = 0.5
FRAME_S = 2
WARM_UP_S = 200
RECORD_S = 700
EGO_COUNT = 50
FRAMES_PER_EGO = 50
EGO_MIN_MEAN_SPEED_MPS = 4.0
EGO_MAX_STANDING_SHARE = 0.45

# Wider than the region of interest (60 m x 40 m) by more than half the diagonal of the longest vehicle
# (a bus of 12.4 m): no box that reaches into the region is lost.
KEEP_X_M = 37.0
KEEP_Y_M = 27.0

COLUMNS, ROWS = 7, 5
BLOCK_M = 140.0
NODE_SHIFT_M = 18.0
BEND_M = 14.0
APPROACH_M = 160.0
PARKING_PITCH_M = 6.6
PARKING_OCCUPANCY = 0.65
PARKING_CLEARANCE_M = 12.0


@dataclass(frozen=True)
class Kind:
    """A source class: SUMO class, mean size and its relative spread, traffic, place in the lane."""

    name: str
    v_class: str
    length_m: float
    width_m: float
    height_m: float
    spread: float
    departures_per_s: float
    lateral_spread_m: float


KINDS = (
    Kind("car", "passenger", 4.60, 1.85, 1.52, 0.050, 0.85, 0.20),
    Kind("van", "delivery", 5.60, 2.02, 2.45, 0.050, 0.12, 0.12),
    Kind("truck", "truck", 8.60, 2.48, 3.30, 0.060, 0.05, 0.08),
    Kind("bus", "bus", 12.00, 2.55, 3.10, 0.015, 0.04, 0.05),
    Kind("bicycle", "bicycle", 1.80, 0.60, 1.70, 0.045, 0.55, 0.20),
    Kind("motorcycle", "motorcycle", 2.15, 0.80, 1.50, 0.050, 0.09, 0.50),
    Kind("pedestrian", "pedestrian", 0.50, 0.60, 1.72, 0.050, 1.80, 0.0),
)
PARKED_KINDS = ("car", "car", "car", "car", "van")


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


@dataclass(frozen=True)
class Size:
    """Size of one road user in metres."""

    length_m: float
    width_m: float
    height_m: float


@dataclass(frozen=True)
class Actor:
    """A road user of the simulation: source class and size."""

    kind: str
    size: Size


EGO_BODY = Size(4.60, 1.85, 1.52)


@dataclass(frozen=True)
class Pose:
    """State in the map frame (x east, y north): front middle, heading anticlockwise from east, speed."""

    front_x_m: float
    front_y_m: float
    heading_rad: float
    speed_mps: float


@dataclass(frozen=True)
class Box:
    """One row of the table; centre and size in metres, yaw in radians, ego vehicle frame."""

    kind: str
    x_m: float
    y_m: float
    size: Size
    yaw_rad: float

    def row(self, seq: int, frame: int) -> str:
        size = self.size
        metres = (self.x_m, self.y_m, size.height_m / 2, size.length_m, size.width_m, size.height_m)
        texts = [_fixed(value, 3) for value in metres]
        return ",".join([str(seq), str(frame), self.kind, *texts, _fixed(self.yaw_rad, 4)])


Frame = dict[str, Pose]
ScenarioFrames = list[list[list[Box]]]


def _fixed(value: float, digits: int) -> str:
    """Fixed-point text without a negative zero."""
    return f"{round(value, digits) + 0.0:.{digits}f}"


def _rng(*key: object) -> random.Random:
    """Random stream of its own for a purpose or an object, so that adding one does not disturb the others."""
    return random.Random(":".join(map(str, (SEED, *key))))


# --- the town -------------------------------------------------------------------------------------


def node_positions() -> dict[NodeKey, Point]:
    """Map positions in metres: a shifted grid, plus the outer ends of the approaches."""
    rng = _rng("nodes")
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
    rng = _rng("bends")
    pairs = [((i, j), (i + 1, j), ROW_STREETS[j]) for j in range(ROWS) for i in range(COLUMNS - 1)]
    pairs += [((i, j), (i, j + 1), COLUMN_STREETS[i]) for i in range(COLUMNS) for j in range(ROWS - 1)]
    pairs += [((i, j), (i + di, j + dj), APPROACH) for i, j, di, dj in approach_ends()]
    return [Segment(start, end, street, rng.choice((0.0, -BEND_M, BEND_M))) for start, end, street in pairs]


def centre_line(start: Point, end: Point, bend_m: float) -> list[Point]:
    """Points (metres) of a smooth arc whose middle lies `bend_m` beside the straight line."""
    dx, dy = end[0] - start[0], end[1] - start[1]
    length = math.hypot(dx, dy)
    count = 12 if bend_m else 1
    offsets = [(k / count, bend_m * math.sin(math.pi * k / count) ** 2) for k in range(count + 1)]
    return [(start[0] + s * dx - o * dy / length, start[1] + s * dy + o * dx / length) for s, o in offsets]


def _node_name(key: NodeKey) -> str:
    return "n" + "_".join(str(k).replace("-", "m") for k in key)


def _write_xml(root: ET.Element, path: Path) -> None:
    ET.indent(root)
    ET.ElementTree(root).write(path, encoding="utf-8")


def write_nodes(path: Path, nodes: dict[NodeKey, Point], segments: list[Segment]) -> None:
    """Traffic lights where two main streets meet, right of way elsewhere."""
    root = ET.Element("nodes")
    for key, (x, y) in nodes.items():
        main = sum(key in (s.start, s.end) for s in segments if s.street.priority >= 2)
        kind = "traffic_light" if main >= 3 else "priority"
        ET.SubElement(root, "node", id=_node_name(key), x=f"{x:.2f}", y=f"{y:.2f}", type=kind)
    _write_xml(root, path)


def _add_edge(root: ET.Element, start: NodeKey, end: NodeKey, street: Street, line: list[Point]) -> None:
    ends = {"from": _node_name(start), "to": _node_name(end)}
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
    _write_xml(root, path)


def build_network(folder: Path) -> Path:
    """Let netconvert join the streets to a network with crossings and traffic lights; returns the file."""
    nodes, segments = node_positions(), town_segments()
    node_file, edge_file, net_file = folder / "town.nod.xml", folder / "town.edg.xml", folder / "town.net.xml"
    write_nodes(node_file, nodes, segments)
    write_edges(edge_file, nodes, segments)
    netconvert = Path(sumo.SUMO_HOME) / "bin" / "netconvert"
    files = ["-n", str(node_file), "-e", str(edge_file), "-o", str(net_file)]
    crossings = ["--crossings.guess", "--walkingareas", "--default.crossing-width", "4"]
    lights = ["--tls.default-type", "actuated", "--tls.layout", "incoming", "--default.junctions.radius", "6"]
    subprocess.run([str(netconvert), *files, *crossings, *lights, "--no-turnarounds"], check=True)
    return net_file


# --- the traffic ----------------------------------------------------------------------------------


@dataclass(frozen=True)
class Edges:
    """Edge ids by what they are good for, and the parking lanes as (edge, lane index, length_m)."""

    inner: tuple[str, ...]
    inbound: tuple[str, ...]
    outbound: tuple[str, ...]
    parking: tuple[tuple[str, int, float], ...]


def read_edges(net_file: Path) -> Edges:
    """Sort the network's edges for demand."""
    edges = [e for e in ET.parse(net_file).getroot().iter("edge") if e.get("function") is None]
    ends = {_node_name((i + di, j + dj)) for i, j, di, dj in approach_ends()}
    inner = tuple(e.attrib["id"] for e in edges if e.get("type") != APPROACH.name)
    inbound = tuple(e.attrib["id"] for e in edges if e.get("from") in ends)
    outbound = tuple(e.attrib["id"] for e in edges if e.get("to") in ends)
    parking = tuple(
        (e.attrib["id"], int(lane.attrib["index"]), float(lane.attrib["length"]))
        for e in edges
        for lane in e.iter("lane")
        if lane.get("allow") == PARKING
    )
    return Edges(inner, inbound, outbound, parking)


def actor_size(kind: Kind, actor_id: str) -> Size:
    """Size of one road user; depends on SEED and its id only and stays within two standard deviations."""
    rng = _rng("size", actor_id)
    factors = [1 + kind.spread * max(-2.0, min(2.0, rng.gauss(0, 1))) for _ in range(3)]
    dimensions = (kind.length_m, kind.width_m, kind.height_m)
    return Size(*(round(d * f, 3) for d, f in zip(dimensions, factors, strict=True)))


def _type_element(kind: Kind, actor_id: str, size: Size, parked: bool) -> ET.Element:
    """SUMO type of one road user: its own size and its own habit of keeping left or right in the lane."""
    offset_m = max(-2.0, min(2.0, _rng("lateral", actor_id).gauss(0, 1))) * kind.lateral_spread_m
    element = ET.Element("vType", id=f"type_{actor_id}", vClass=PARKING if parked else kind.v_class)
    element.attrib |= {"length": f"{size.length_m}", "width": f"{size.width_m}", "height": f"{size.height_m}"}
    if kind.name != "pedestrian":
        element.attrib |= {"latAlignment": f"{offset_m:.2f}", "minGapLat": "0.3", "jmTimegapMinor": "0.7"}
    if parked:
        element.attrib["minGap"] = "0.2"
    return element


def _trip_ends(edges: Edges, rng: random.Random) -> tuple[str, str]:
    """Origin and destination of a vehicle: through traffic, into the town, out of it, or within it."""
    start = rng.choice(edges.inbound if rng.random() < 0.5 else edges.inner)
    end = rng.choice(edges.outbound if rng.random() < 0.5 else edges.inner)
    return (start, end) if start != end else _trip_ends(edges, rng)


def _trip_element(kind: Kind, actor_id: str, depart_s: float, edges: Edges) -> ET.Element:
    """A walk or a drive; SUMO finds the way."""
    rng = _rng("trip", actor_id)
    depart = f"{depart_s:.1f}"
    if kind.name == "pedestrian":
        start, end = rng.sample(edges.inner, 2)
        person = ET.Element("person", id=actor_id, type=f"type_{actor_id}", depart=depart, departPos="random")
        ET.SubElement(person, "walk", {"from": start, "to": end})
        return person
    start, end = _trip_ends(edges, rng)
    ways = {"id": actor_id, "type": f"type_{actor_id}", "from": start, "to": end}
    return ET.Element("trip", ways, depart=depart, departLane="best", departSpeed="max")


def moving_traffic() -> Iterator[tuple[float, str, Kind]]:
    """(departure time, id, kind) of everybody who moves, in no particular order."""
    for kind in KINDS:
        rng = _rng("departures", kind.name)
        for number in range(round(kind.departures_per_s * (WARM_UP_S + RECORD_S))):
            yield rng.uniform(0, WARM_UP_S + RECORD_S), f"{kind.name}{number:04d}", kind


def parked_vehicles(edges: Edges) -> Iterator[tuple[str, Kind, str, int, float]]:
    """(id, kind, edge, lane index, front position along the lane) of the vehicles parked at the kerb."""
    kinds = {kind.name: kind for kind in KINDS}
    rng = _rng("parking")
    for edge, lane, length_m in edges.parking:
        places = int((length_m - 2 * PARKING_CLEARANCE_M) / PARKING_PITCH_M)
        for place in range(places):
            front_m = PARKING_CLEARANCE_M + (place + 1) * PARKING_PITCH_M - rng.uniform(0.2, 0.6)
            kind = kinds[rng.choice(PARKED_KINDS)]
            if rng.random() < PARKING_OCCUPANCY:
                yield f"parked_{edge}_{place:02d}", kind, edge, lane, front_m


def _parked_element(actor_id: str, edge: str, lane: int, front_m: float) -> ET.Element:
    position = f"{front_m:.2f}"
    where = {"departLane": str(lane), "departPos": position, "departSpeed": "0"}
    element = ET.Element("vehicle", {"id": actor_id, "type": f"type_{actor_id}", "depart": "0"} | where)
    ET.SubElement(element, "route", edges=edge)
    span = {"startPos": f"{front_m - 1:.2f}", "endPos": position}
    ET.SubElement(element, "stop", {"lane": f"{edge}_{lane}", "duration": "100000"} | span)
    return element


def write_traffic(path: Path, edges: Edges) -> dict[str, Actor]:
    """Write types and trips in order of departure; returns all road users by id."""
    root = ET.Element("routes")
    actors: dict[str, Actor] = {}
    for actor_id, kind, edge, lane, front_m in parked_vehicles(edges):
        actors[actor_id] = Actor(kind.name, actor_size(kind, actor_id))
        root.append(_type_element(kind, actor_id, actors[actor_id].size, parked=True))
        root.append(_parked_element(actor_id, edge, lane, front_m))
    for depart_s, actor_id, kind in sorted(moving_traffic(), key=lambda trip: trip[:2]):
        actors[actor_id] = Actor(kind.name, actor_size(kind, actor_id))
        root.append(_type_element(kind, actor_id, actors[actor_id].size, parked=False))
        root.append(_trip_element(kind, actor_id, depart_s, edges))
    _write_xml(root, path)
    return actors


# --- the simulation -------------------------------------------------------------------------------


def _snapshot() -> Frame:
    """Poses of all vehicles and persons at this moment, by id."""
    frame: Frame = {}
    for domain in (libsumo.vehicle, libsumo.person):
        for actor_id in sorted(domain.getIDList()):
            x, y = domain.getPosition(actor_id)
            heading_rad = math.radians(90.0 - domain.getAngle(actor_id))
            frame[actor_id] = Pose(x, y, heading_rad, domain.getSpeed(actor_id))
    return frame


def simulate(net_file: Path, traffic_file: Path) -> list[Frame]:
    """Run SUMO; one snapshot per FRAME_S after the warm-up."""
    options = {
        "net-file": net_file,
        "route-files": traffic_file,
        "seed": SEED,
        "step-length": STEP_S,
        "lateral-resolution": 0.4,
        "time-to-teleport": 150,
        "time-to-impatience": 30,
        "device.rerouting.probability": 0.6,
        "device.rerouting.period": 60,
        "pedestrian.striping.stripe-width": 0.67,
        "pedestrian.striping.jamtime": 60,
    }
    texts = [text for name, value in options.items() for text in (f"--{name}", str(value))]
    libsumo.start(["sumo", *texts, "--no-step-log", "--no-warnings"])
    frames: list[Frame] = []
    libsumo.simulationStep(WARM_UP_S)
    for second in range(0, RECORD_S, FRAME_S):
        libsumo.simulationStep(WARM_UP_S + second)
        frames.append(_snapshot())
    libsumo.close()
    return frames


# --- the ego cars and what stands around them -----------------------------------------------------


def _stay(car: str, frames: list[Frame]) -> tuple[int, list[Pose]]:
    """First frame index and poses of a car; a car enters and leaves the simulation once."""
    present = [k for k, frame in enumerate(frames) if car in frame]
    return present[0], [frames[k][car] for k in present]


def _drives_well(poses: list[Pose]) -> bool:
    """True for a drive that moves through town: red lights are fine, a jam is not."""
    speeds = [pose.speed_mps for pose in poses]
    standing = sum(speed < 0.3 for speed in speeds) / len(speeds)
    return sum(speeds) / len(speeds) >= EGO_MIN_MEAN_SPEED_MPS and standing <= EGO_MAX_STANDING_SHARE


def ego_candidates(frames: list[Frame], actors: dict[str, Actor]) -> list[tuple[int, str]]:
    """(first frame index, id) of a part of FRAMES_PER_EGO frames of each car that moves well in it."""
    seen = sorted({actor_id for frame in frames for actor_id in frame})
    cars = [i for i in seen if actors[i].kind == "car" and not i.startswith("parked")]
    candidates: list[tuple[int, str]] = []
    for car in cars:
        first, poses = _stay(car, frames)
        if len(poses) >= FRAMES_PER_EGO:
            skipped = _rng("start", car).randrange(len(poses) - FRAMES_PER_EGO + 1)
            if _drives_well(poses[skipped : skipped + FRAMES_PER_EGO]):
                candidates.append((first + skipped, car))
    return candidates


def _centre(pose: Pose, size: Size) -> tuple[float, float]:
    """Map position of the body's centre: half a length behind the front."""
    half_m, heading_rad = size.length_m / 2, pose.heading_rad
    return pose.front_x_m - half_m * math.cos(heading_rad), pose.front_y_m - half_m * math.sin(heading_rad)


def box_in_ego_frame(actor: Actor, pose: Pose, ego: Actor, ego_pose: Pose) -> Box:
    """Turn a map pose into a box in the ego vehicle frame."""
    x, y = _centre(pose, actor.size)
    ego_x, ego_y = _centre(ego_pose, ego.size)
    dx, dy = x - ego_x, y - ego_y
    cos, sin = math.cos(ego_pose.heading_rad), math.sin(ego_pose.heading_rad)
    yaw_rad = math.remainder(pose.heading_rad - ego_pose.heading_rad, math.tau)
    return Box(actor.kind, cos * dx + sin * dy, cos * dy - sin * dx, actor.size, yaw_rad)


def boxes_around(ego_id: str, frame: Frame, actors: dict[str, Actor]) -> list[Box]:
    """Boxes of one frame near the ego car, without the ego car itself, ordered by id."""
    ego, ego_pose = actors[ego_id], frame[ego_id]
    others = [i for i in sorted(frame) if i != ego_id]
    boxes = [box_in_ego_frame(actors[i], frame[i], ego, ego_pose) for i in others]
    return [b for b in boxes if abs(b.x_m) <= KEEP_X_M and abs(b.y_m) <= KEEP_Y_M]


def _reach_m(box: Box, axis_rad: float) -> tuple[float, float]:
    """Interval that the box's footprint covers along a horizontal axis through the origin."""
    centre_m = box.x_m * math.cos(axis_rad) + box.y_m * math.sin(axis_rad)
    along, across = abs(math.cos(box.yaw_rad - axis_rad)), abs(math.sin(box.yaw_rad - axis_rad))
    half_m = (box.size.length_m * along + box.size.width_m * across) / 2
    return centre_m - half_m, centre_m + half_m


def touches_ego(box: Box) -> bool:
    """True when the footprints of the box and of EGO_BODY overlap (separating axes)."""
    ego = Box("car", 0.0, 0.0, EGO_BODY, 0.0)
    axes_rad = (0.0, math.pi / 2, box.yaw_rad, box.yaw_rad + math.pi / 2)
    reaches = [(_reach_m(box, axis), _reach_m(ego, axis)) for axis in axes_rad]
    return all(a[0] < b[1] and b[0] < a[1] for a, b in reaches)


def scenes(frames: list[Frame], actors: dict[str, Actor]) -> ScenarioFrames:
    """Boxes by sequence and frame: EGO_COUNT drives drawn by SEED in which nothing runs into the ego car.

    (Now and then SUMO lets road users pass through each other at a crossing.)
    """
    candidates = ego_candidates(frames, actors)
    _rng("egos").shuffle(candidates)
    drives: list[tuple[int, str, list[list[Box]]]] = []
    for first, ego in candidates:
        boxes = [boxes_around(ego, frame, actors) for frame in frames[first : first + FRAMES_PER_EGO]]
        if not any(touches_ego(box) for frame in boxes for box in frame):
            drives.append((first, ego, boxes))
        if len(drives) == EGO_COUNT:
            return [drive[2] for drive in sorted(drives, key=lambda drive: drive[:2])]
    raise SystemExit(f"only {len(drives)} of {EGO_COUNT} ego drives found")


# --- the files ------------------------------------------------------------------------------------


def table_bytes(scenario: ScenarioFrames) -> bytes:
    """The gzipped CSV table; no time stamp or name inside, so that equal tables are equal files."""
    lines = ["seq,frame,cls,x,y,z,length,width,height,yaw"]
    for seq, frames in enumerate(scenario):
        for number, boxes in enumerate(frames):
            lines += [box.row(seq, number) for box in boxes]
    return gzip.compress(("\n".join(lines) + "\n").encode(), compresslevel=9, mtime=0)


def sidecar(scenario: ScenarioFrames, table: bytes) -> dict[str, object]:
    """What the table itself cannot say: above all the number of frames, empty ones included."""
    counts = Counter(box.kind for frames in scenario for boxes in frames for box in boxes)
    return {
        "name": "town",
        "frames": sum(len(frames) for frames in scenario),
        "seed": SEED,
        "sumo_version": SUMO_VERSION,
        "sha256": hashlib.sha256(table).hexdigest(),
        "boxes": {kind.name: counts[kind.name] for kind in KINDS},
    }


def print_statistics(scenario: ScenarioFrames, table: bytes) -> None:
    """Frames, empty frames, boxes per frame and class, file size."""
    frames = [boxes for sequence in scenario for boxes in sequence]
    print(f"{len(scenario)} sequences, {len(frames)} frames, {sum(not f for f in frames)} without boxes")
    mean = sum(map(len, frames)) / len(frames)
    print(f"{mean:.1f} boxes a frame, at most {max(map(len, frames))}; {len(table)} bytes")
    for kind in KINDS:
        per_frame = [sum(box.kind == kind.name for box in boxes) for boxes in frames]
        print(f"  {kind.name:<11}{sum(per_frame):>7} boxes; in {sum(n > 0 for n in per_frame):>5} frames")


def main() -> None:
    """Simulate, look around, write the two files."""
    parser = argparse.ArgumentParser(description="Make the bundled town scenario with SUMO.")
    parser.add_argument("--out", type=Path, default=Path(__file__).parent, help="folder to write to")
    folder: Path = parser.parse_args().out
    if SUMO_VERSION not in libsumo.getVersion()[1]:
        raise SystemExit(f"needs SUMO {SUMO_VERSION}, found {libsumo.getVersion()[1]}")
    with tempfile.TemporaryDirectory() as scratch:
        net_file, traffic_file = build_network(Path(scratch)), Path(scratch) / "town.rou.xml"
        actors = write_traffic(traffic_file, read_edges(net_file))
        frames = simulate(net_file, traffic_file)
    scenario = scenes(frames, actors)
    table = table_bytes(scenario)
    (folder / "boxes.csv.gz").write_bytes(table)
    sidecar_text = json.dumps(sidecar(scenario, table), indent=2) + "\n"
    (folder / "scenario.json").write_text(sidecar_text, encoding="utf-8")
    print_statistics(scenario, table)


if __name__ == "__main__":
    main()
