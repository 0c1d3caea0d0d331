"""Make the bundled scenario: objects around ego cars that drive through a simulated town, and its occluders.

The town (curved multi-lane streets, traffic lights, bike lanes, sidewalks, crossings, parked cars) and its traffic
are simulated with SUMO, which is needed only here; what stands beside the streets (surroundings.py) needs none:

    python3 -m venv sumo-env && sumo-env/bin/pip install eclipse-sumo==1.28.0 libsumo==1.28.0 numpy
    sumo-env/bin/python -m tools.town.make      # writes the files of assets/scenarios/town

Everything follows from streets.SEED: a second run gives the same bytes.
"""

from __future__ import annotations

import argparse
import gzip
import hashlib
import json
import math
import tempfile
from collections import Counter
from dataclasses import dataclass
from pathlib import Path

import libsumo

from tools.town.drives import Drive, Place, drives, fixed
from tools.town.streets import SEED, Point, street_table
from tools.town.surroundings import MAP, Standing, occluder_table, surroundings
from tools.town.traffic import KINDS, build_network, map_origin, read_edges, simulate, write_traffic

SUMO_VERSION = "1.28.0"
FOLDER = Path(__file__).parents[2] / "assets" / "scenarios" / "town"


@dataclass(frozen=True)
class Scenario:
    """Inputs of the files; `origin_m`: origin of the streets' map in that of the drives."""

    drives: list[Drive]
    origin_m: Point
    standing: list[Standing]


def simulated() -> Scenario:
    """Build the town, let the traffic run, and look around from the ego cars."""
    with tempfile.TemporaryDirectory() as scratch:
        net_file, traffic_file = build_network(Path(scratch)), Path(scratch) / "town.rou.xml"
        actors = write_traffic(traffic_file, read_edges(net_file))
        frames = simulate(net_file, traffic_file)
        return Scenario(drives(frames, actors), map_origin(net_file), surroundings())


def tables(scenario: Scenario) -> dict[str, str]:
    """The text of each table by its file name, without the ending .gz."""
    boxes = ["seq,frame,cls,x,y,z,length,width,height,yaw"]
    poses = ["seq,frame,map,x,y,z,yaw"]
    for seq, drive in enumerate(scenario.drives):
        for number, (place, around) in enumerate(zip(drive.places, drive.boxes, strict=True)):
            boxes += [box.row(seq, number) for box in around]
            poses.append(f"{seq},{number},{MAP},{_pose_text(place, scenario.origin_m)}")
    return {
        "boxes.csv": "\n".join(boxes) + "\n",
        "occluders.csv": occluder_table(scenario.standing),
        "poses.csv": "\n".join(poses) + "\n",
        "streets.csv": street_table(MAP),
    }


def _pose_text(place: Place, origin_m: Point) -> str:
    x_m, y_m, heading_rad = place
    yaw_rad = math.remainder(heading_rad, math.tau)
    return f"{fixed(x_m - origin_m[0], 3)},{fixed(y_m - origin_m[1], 3)},0.000,{fixed(yaw_rad, 5)}"


def packed(text: str) -> bytes:
    """The gzipped table; no time stamp or name inside, so that equal tables are equal files."""
    return gzip.compress(text.encode(), compresslevel=9, mtime=0)


def sidecar(scenario: Scenario, files: dict[str, bytes]) -> dict[str, object]:
    """Return the data that the tables cannot hold: above all the number of frames, empty ones included."""
    counts = Counter(box.kind for drive in scenario.drives for boxes in drive.boxes for box in boxes)
    return {
        "name": "town",
        "frames": sum(len(drive.boxes) for drive in scenario.drives),
        "seed": SEED,
        "sumo_version": SUMO_VERSION,
        "sha256": {name: hashlib.sha256(content).hexdigest() for name, content in files.items()},
        "boxes": {kind.name: counts[kind.name] for kind in KINDS},
        "occluders": dict(sorted(Counter(thing.kind for thing in scenario.standing).items())),
    }


def print_statistics(scenario: Scenario, files: dict[str, bytes]) -> None:
    """Frames, empty frames, boxes per frame and class, file sizes."""
    frames = [boxes for drive in scenario.drives for boxes in drive.boxes]
    print(
        f"{len(scenario.drives)} sequences, {len(frames)} frames, {sum(not f for f in frames)} without boxes"
    )
    mean = sum(map(len, frames)) / len(frames)
    sizes = ", ".join(f"{name} {len(content)} bytes" for name, content in files.items())
    print(f"{mean:.1f} boxes a frame, at most {max(map(len, frames))}; {sizes}")
    for kind in KINDS:
        per_frame = [sum(box.kind == kind.name for box in boxes) for boxes in frames]
        print(f"  {kind.name:<11}{sum(per_frame):>7} boxes; in {sum(n > 0 for n in per_frame):>5} frames")


def main() -> None:
    """Simulate, look around, write the files."""
    parser = argparse.ArgumentParser(description="Make the bundled town scenario with SUMO.")
    parser.add_argument("--out", type=Path, default=FOLDER, help="folder to write to")
    folder: Path = parser.parse_args().out
    if SUMO_VERSION not in libsumo.getVersion()[1]:
        raise SystemExit(f"needs SUMO {SUMO_VERSION}, got {libsumo.getVersion()[1]}")
    scenario = simulated()
    files = {f"{name}.gz": packed(text) for name, text in tables(scenario).items()}
    for name, content in files.items():
        (folder / name).write_bytes(content)
    (folder / "scenario.json").write_text(
        json.dumps(sidecar(scenario, files), indent=2) + "\n", encoding="utf-8"
    )
    print_statistics(scenario, files)


if __name__ == "__main__":
    main()
