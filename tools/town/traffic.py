"""Traffic of the bundled town: objects and their trips, simulated with libsumo, recorded every two seconds.

SUMO gives the middle of the front bumper in a map frame (x east, y north) and a nautical angle in degrees (0 = north,
clockwise).
"""

from __future__ import annotations

import math
import random
import subprocess
import xml.etree.ElementTree as ET
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import libsumo
import sumo

from tools.town.streets import (
    APPROACH,
    PARKING,
    SEED,
    Point,
    approach_ends,
    node_name,
    node_positions,
    rng_for,
    town_segments,
    write_edges,
    write_nodes,
    write_xml,
)

STEP_S = 0.5
FRAME_S = 2
WARM_UP_S = 200
RECORD_S = 700

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
class Size:
    """Size of one object in metres."""

    length_m: float
    width_m: float
    height_m: float


@dataclass(frozen=True)
class Actor:
    """Object of the simulation: source class and size."""

    kind: str
    size: Size


@dataclass(frozen=True)
class Pose:
    """State in the map frame (x east, y north): front middle, heading anticlockwise from east, speed."""

    front_x_m: float
    front_y_m: float
    heading_rad: float
    speed_mps: float


Frame = dict[str, Pose]


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


def map_origin(net_file: Path) -> Point:
    """Return the origin of the streets' map frame in that of the network: netconvert shifts the town."""
    location = ET.parse(net_file).getroot().find("location")
    assert location is not None
    x, y = location.attrib["netOffset"].split(",")
    return float(x), float(y)


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
    ends = {node_name((i + di, j + dj)) for i, j, di, dj in approach_ends()}
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
    """Return the size of one object; depends on SEED and its id only and stays within two standard deviations."""
    rng = rng_for("size", actor_id)
    factors = [1 + kind.spread * max(-2.0, min(2.0, rng.gauss(0, 1))) for _ in range(3)]
    dimensions = (kind.length_m, kind.width_m, kind.height_m)
    return Size(*(round(d * f, 3) for d, f in zip(dimensions, factors, strict=True)))


def _type_element(kind: Kind, actor_id: str, size: Size, parked: bool) -> ET.Element:
    """Return the SUMO type of one object: its own size and its own tendency to keep left or right in the lane."""
    offset_m = max(-2.0, min(2.0, rng_for("lateral", actor_id).gauss(0, 1))) * kind.lateral_spread_m
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
    rng = rng_for("trip", actor_id)
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
        rng = rng_for("departures", kind.name)
        for number in range(round(kind.departures_per_s * (WARM_UP_S + RECORD_S))):
            yield rng.uniform(0, WARM_UP_S + RECORD_S), f"{kind.name}{number:04d}", kind


def parked_vehicles(edges: Edges) -> Iterator[tuple[str, Kind, str, int, float]]:
    """(id, kind, edge, lane index, front position along the lane) of the vehicles parked at the kerb."""
    kinds = {kind.name: kind for kind in KINDS}
    rng = rng_for("parking")
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
    """Write types and trips in order of departure; return all objects by id."""
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
    write_xml(root, path)
    return actors


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
