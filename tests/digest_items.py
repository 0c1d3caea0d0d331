"""Invocations of the command line, and the rigs, traffic and requirements that they run on, for `digest.py`."""

from __future__ import annotations

import io
import json
import shlex
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

import pyarrow.csv
import pyarrow.parquet


class Item(NamedTuple):
    """Commands that run in turn in one folder; items of a group share a process, in this order."""

    group: str
    name: str
    commands: tuple[str, ...]


# ---------------------------------------------------------------- invocations

PRESETS = (
    "W+T", "W+C", "N+P", "W+LR", "N+PP", "Center", "Pyramid", "Line", "Trapezoid", "Wide", "Narrow", "nuScenes car",
    "KITTI car", "PandaSet car", "Argoverse 2 car", "Waymo car",
)  # fmt: skip
OWN_RIGS = ("skew", "van", "truck", "mesh", "odd")
FORMATS = {
    "nuscenes": "nu", "autoware": "kit", "urdf": "r.urdf", "carla": "objects.json", "carla-toml": "r.toml",
    "driveworks": "dw.json",
}  # fmt: skip
BOX = "--boxes ../in/boxes.csv"
PER_RIG = {
    "evaluate": "evaluate RIG --voxel 0.2 --json -",
    "evaluate-table": "evaluate RIG W+T --voxel 0.2",
    "evaluate-bresenham": "evaluate RIG --voxel 0.2 --method bresenham --reading hits --lambda 0.3 --json -",
    "evaluate-residual": "evaluate RIG --voxel 0.2 --reading residual --body blocks --json scores.json",
    "evaluate-hits": "evaluate RIG --voxel 0.2 --reading hits --body ignored --json -",
    "evaluate-boxes": f"evaluate RIG {BOX} --voxel 0.25 --roi 40 30 3 --origin 0.1 -0.2 0 --frames 80 --json -",
    "targets": "evaluate RIG --targets --voxel 0.4 --sample 30 --json -",
    "targets-table": "evaluate RIG --targets --voxel 0.4 --sample 15 --surroundings block --seed 3"
    " --min-points 8 --within 45",
    "targets-plain": f"evaluate RIG --targets --voxel 0.4 {BOX} --shape box --range-law off --phase 0"
    " --body ignored --json t.json"
    " --objects objects.csv",
    "targets-behind": f"evaluate RIG --targets --voxel 0.4 {BOX}"
    " --occluders ../in/occluders.csv ../in/poses.csv --body blocks"
    " --objects objects.parquet --json -",
    "audit": "review RIG --only audit --voxel 0.2 --json audit.json",
    "audit-table": f"review RIG --only audit {BOX} --voxel 0.4",
    "range": "review RIG --only range --directions 4 --range-csv range.csv --json -",
    "range-table": "review RIG --only range --min-points 10 --min-height 40 --range-to 90 --directions 3"
    " --reaction 0.8",
    "blind": "review RIG --only blind --blind-voxel 0.25 --json -",
    "blind-map": "review RIG --only blind --blind-voxel 0.5 --blind-width 0 --blind-by lidar --blind-sensors 2"
    " --blind-within 8 --blind-map map.csv",
    "redundancy": f"review RIG --only redundancy {BOX} --voxel 0.2 --json -",
    "redundancy-table": "review RIG --only redundancy --voxel 0.4 --no-objects --reading covered",
    "tolerance": f"review RIG --only tolerance {BOX} --voxel 0.4 --draws 8 --sample 10 --json - --worst worst.yaml",
    "tolerance-table": f"review RIG --only tolerance {BOX} --voxel 0.5 --draws 4 --sample 0 --errors ride --seed 2",
    "check": f"check RIG {BOX} --requirements ../in/easy.yaml --voxel 0.25 --json verdicts.json",
    "check-hard": f"check RIG {BOX} --requirements ../in/hard.yaml --voxel 0.25",
}
FEW = "--add generic-16 --spots 1.4 --frames 4 --held-out 12"
OTHERS = {
    "scene": {
        "fine": "evaluate W+T ../in/skew.yaml --voxel 0.1 --json -",
        "fine-blocks": "evaluate Trapezoid 'nuScenes car' --voxel 0.1 --body blocks --json -",
        "auto-voxel": f"evaluate Center {BOX} --voxel auto --voxel-tolerance 3 --json -",
        "threads": "evaluate W+T ../in/van.yaml --voxel 0.2 --threads 1 --json -",
        "classes": f"evaluate Line {BOX} --classes tram=car --classes 'bi*=ignore' --voxel 0.25 --json -",
        "ground": f"evaluate Line {BOX} --ground auto --voxel 0.25 --json -",
        "pog": "data build ../in/boxes.csv --voxel 0.2 --out a.npz; evaluate W+T --pog a.npz --json -;"
        "review Line --only audit --pog a.npz --json -; review W+T --only redundancy --pog a.npz --json -",
        "pog-two": "data build ../in/boxes.csv ../in/more.parquet --voxel 0.25 --workers 1 --out b.npz",
        "pog-kitti": "data build ../in/kitti --voxel 0.25 --roi 50 40 4 --out c.npz",
        "data": "data show ../in/boxes.csv --json -",
        "data-two": "data show ../in/boxes.csv ../in/more.parquet --origin -1.35 0 0.1",
        "data-kitti": "data show ../in/kitti --json -; evaluate Center --targets --voxel 0.4"
        " --boxes ../in/kitti --json -",
    },
    "lists": {
        "rigs": "list rigs",
        "sensors": "list sensors",
        "sensors-json": "list sensors --json -",
        "sensors-lidars": "list sensors --kind lidar --json -",
        "sensors-one": "list sensors velodyne-vlp-32c; list sensors waymo-front --json -",
    },
    "library": {
        "own": "list sensors --library ../in/library.yaml;"
        "list sensors bench-lidar --library ../in/library.yaml --json -",
    },
    "library rig": {
        "own": "evaluate ../in/bench.yaml --library ../in/library.yaml --voxel 0.2 --json -;"
        "convert ../in/bench.yaml r.urdf --rear-axle-x -1.2",
    },
    "study": {
        "table1": f"study table1 {BOX} --voxel 0.25 --csv t1.csv --detection-csv t2.csv",
        "table1-town": "study table1 --voxel 0.4 --reading residual --csv t1.csv",
        "stability": f"study stability {BOX} --voxel 0.5 --roi 20 20 4 --quick --edits 20 --out .",
        "targets": "study targets ../in/true.csv --rig Center --out .",
        "targets-rigs": "study targets ../in/true.csv --rigs ../in/rigs.json --azimuths 360 --out .",
    },
    "simulate": {
        "own": f"simulate ../in/small.yaml {BOX} --out set --points parquet --workers 1 --every 6",
        "two": f"simulate ../in/skew.yaml Center {BOX} --out s --pictures off --workers 1 --every 9 --body blocks"
        " --seed 4 --noise 0.05 --dropout 0.1 --clutter 9 --road flat --phase 0",
        "town": "simulate ../in/small.yaml --out set --every 40 --sequences 4 --workers 1",
        "plain": f"simulate Line {BOX} --out set --road none --clutter 0 --noise 0 --dropout 0 --shape box"
        " --range-law off --workers 1 --every 7",
    },
    "report": {
        "two": f"report W+T ../in/skew.yaml {BOX} --requirements ../in/easy.yaml --voxel 0.25 --draws 4 --out r.html;"
        f"report --verify r.html {BOX}",
        "town": "report 'nuScenes car' --voxel 0.4 --draws 0 --out r.html",
        "van": f"report ../in/van.yaml Wide {BOX} --voxel 0.5 --draws 4 --seed 3 --out r.html",
        "mesh": f"report ../in/mesh.yaml {BOX} --requirements ../in/hard.yaml --voxel 0.25 --draws 0 --out r.html",
    },
    "optimise": {
        "front": f"optimise Center {BOX} {FEW} --blind 0.3 --json -",
        "budget": f"optimise Line {BOX} {FEW} --count 2 --budget 4 --weight pedestrian=2 --out found",
        "move": f"optimise 'KITTI car' {BOX} --move velodyne=0.5 --frames 4 --held-out 12 --json -",
        "ground": f"optimise '../in/van.yaml' {BOX} {FEW} --objective blind_m2 --json -",
        "voxels": f"optimise Center {BOX} {FEW} --objective seen_lidar --json -",
        "predicted": f"optimise Center {BOX} {FEW} --objective predicted --json -",
        "no bound": f"optimise Center {BOX} {FEW} --objective share_5 --json -",
    },
    "extras": {
        "blind-profile": "review W+T --only blind --blind-voxel 0.25 --profile ../in/profiles.yaml --json -",
        "blind-camera": "review ../in/van.yaml --only blind --blind-by camera --blind-map map.png --blind-voxel 0.2",
        "range-chart": "review ../in/truck.yaml --only range --directions 6 --range-chart range.png",
        "check-profile": "check Center --requirements ../in/mounts.yaml --profile ../in/profiles.yaml --json -",
        "check-own": f"check ../in/skew.yaml {BOX} --requirements ../in/own.yaml --voxel 0.25 --json -",
        "brackets": f"review ../in/skew.yaml --only tolerance {BOX} --errors brackets --voxel 0.25 --draws 8"
        " --no-sensitivities"
        " --worst w.yaml --worst-by 'on_target pedestrian' --json -",
    },
}  # fmt: skip
BAD = (
    "evaluate W+X", "evaluate", "evalute W+T", "Evaluates", "data show ''", "evaluate W+T --json ''",
    "evaluate W+T --pog .",
    "evaluate W+T --voxel 0.3", "evaluate W+T --voxel nan", "evaluate W+T --voxel small", "evaluate W+T --roi 60 40",
    "evaluate W+T --roi 60 -40 4", "evaluate W+T --lambda -1", "evaluate W+T --threads 1.5", "evaluate W+T --frames 9",
    "evaluate W+T --method guess", "evaluate W+T --reading literal", "evaluate W+T --body glass",
    "evaluate W+T --boxez a.csv", "evaluate W+T --boxes nowhere", "evaluate W+T --voxel-tolerance 2",
    "evaluate ../in/bad-key.yaml", "evaluate ../in/bad-number.yaml", "evaluate ../in/bad-yaml.yaml",
    "evaluate ../in/bad-twice.yaml", "evaluate ../in/bad-version.yaml", "evaluate W+T --boxes ../in/bad.csv",
    "evaluate W+T --boxes ../in/short.csv", "data build ../in/boxes.csv --out no/such.npz",
    "data build ../in/boxes.csv --out ../in/boxes.csv",
    f"evaluate W+T {BOX} --frames 2", f"evaluate W+T {BOX} --classes tram=train", f"evaluate W+T {BOX} --classes tram",
    "convert W+T a --to nothing", "convert ../in/boxes.csv a.urdf", "convert nowhere a.yaml", "list rigs X",
    "list sensors nothing", "evaluate --targets W+T --min-points 0", "evaluate --targets W+T --sample 0",
    "evaluate --targets W+T Line --objects a.csv", "review W+T --directions 0", "review W+T --range-chart a.txt",
    "review W+T --blind-within 0",
    "review W+T --blind-map a.txt", "review W+T --profile ../in/easy.yaml", "review W+T --errors magic",
    "review W+T --draws 0", "check W+T", "check W+T --requirements ../in/bad-need.yaml", "report W+T --out a.txt",
    "report --verify ../in/easy.yaml", "simulate W+T --out s --every 0", "simulate ../in/bare.yaml --out s",
    "study table1 --csv no/such.csv", "study targets ../in/true.csv --out .", "study nothing",
    "review W+T --only audit --voxel 7",
    "review W+T --only redundancy --within -1",
    "list sensors --library ../in/easy.yaml",  # the last: a library stays in use
)  # fmt: skip
REAL = {
    "nuscenes": "evaluate 'nuScenes car' --boxes DATA/boxes/nuscenes_mini_val_ego.csv.gz --origin -1.35 0 0"
    " --voxel 0.2 --json -",
    "nuscenes-targets": "evaluate --targets --voxel 0.2 'nuScenes car' --origin -1.35 0 0 --json -"
    " --boxes DATA/boxes/nuscenes_mini_val_ego.csv.gz",
    "kitti": "data show DATA/kitti/tracking --json -;"
    "evaluate 'KITTI car' --boxes DATA/kitti/tracking --voxel 0.2 --json -",
    "kitti-object": "evaluate --targets --voxel 0.2 'KITTI car' --boxes DATA/kitti/object --json -",
    "study-targets": "study targets DATA/boxes/nuscenes_mini_val_points.csv.gz"
    " --rigs DATA/nuscenes/mini_val_rigs.json --out .",
    "autoware": "convert DATA/rigs/autoware/sample_sensor_kit r.yaml --report r.txt",
    "xacro": "convert DATA/rigs/aip_launcher/aip_xx1_description/urdf/sensors.xacro r.yaml",
    "carla": "convert DATA/rigs/carla_ros_bridge/objects.json r.yaml",
    "driveworks": "convert DATA/rigs/driveworks/hesai_lidar_rig_template.json r.yaml",
    "pandaset": "convert DATA/rigs/pandaset/static_extrinsic_calibration.yaml r.yaml",
}  # fmt: skip


def items(data: Path | None) -> Iterator[Item]:
    """Yield every item, always in the same order."""
    for rig in (*PRESETS, *OWN_RIGS):
        named = shlex.quote(rig) if rig in PRESETS else f"../in/{rig}.yaml"
        for name, command in PER_RIG.items():
            yield Item(rig, f"{rig} {name}", (command.replace("RIG", named),))
        start = f"list rigs {named} --out own.yaml" if rig in PRESETS else f"convert {named} own.yaml"
        for form, target in FORMATS.items():
            there = f"convert own.yaml {target} --to {form} --report there.txt"
            back = f"convert {target} back.yaml --from {form} --report back.txt"
            yield Item(rig, f"{rig} to {form}", (start, there, back))
        yield Item(rig, f"{rig} to osi", (start, "convert own.yaml osi.json --to osi"))
    for group, named_commands in OTHERS.items():
        for name, text in named_commands.items():
            yield Item(group, f"{group} {name}", tuple(one.strip() for one in text.split(";")))
    for number, text in enumerate(BAD, 1):
        yield Item("bad", f"bad {number:02} {text[:40]}", (text,))
    for name, text in REAL.items() if data is not None else ():
        yield Item(
            "real", f"real {name}", tuple(one.strip() for one in text.replace("DATA", str(data)).split(";"))
        )


# ---------------------------------------------------------------- their inputs

HEAD = "riglens: 1\nname: NAME\n"
CAMERA = "{name: C, kind: camera, position: [0.5, 0, 1.8], image: [320, 180], cast: [32, 18], hfov_deg: 70}"
SKEW = """vehicle: {body: suv, length: 4.9, width: 2.0, height: 1.8, rear_axle_x: -1.5}
keep_out: [[0.6, 0.1, 1.8, 0.3], [-1.0, -0.9, 1.1, 0.2]]
sensors:
  - {name: tilted, kind: lidar, position: [0.31, 0.02, 2.13], rpy_deg: [3.7, -4.1, 17.3], model: velodyne-vlp-16}
  - {name: offset, kind: lidar, position: [-0.9, 0.55, 2.0], rpy_deg: [0.5, 12, 95], fails_with: [left bracket, ecu],
     elevations_deg: [-21.3, -9.1, -4, 0, 2.5], azimuths_deg: {from: -100, to: 80, count: 211},
     azimuth_offsets_deg: [1.2, -1.2, 0.4, 0, 2.1], range_m: [0.7, 45]}
  - {name: off, kind: lidar, position: [0, 0, 2.5], elevations_deg: {from: -30, to: 5, count: 8}, enabled: false}
  - {name: bent, kind: camera, position: [1.4, 0.03, 1.5], rpy_deg: [1, 6, -3], image: [640, 400], cast: [160, 100],
     fx: 410.5, fy: 409.25, cx: 322.5, cy: 196.75, fails_with: [ecu],
     distortion: {model: brown_conrady, k1: -0.31, k2: 0.11, p1: 0.001, p2: -0.0007, k3: -0.012}}
  - {name: left, kind: camera, position: [0.2, 1.02, 1.4], rpy_deg: [2, 9, 80], image: [800, 500], cast: [120, 75],
     hfov_deg: 95, fails_with: [left bracket]}
  - {name: right, kind: camera, position: [0.2, -1.02, 1.4], rpy_deg: [-2, 9, -80], image: [800, 500], cast: [120, 75],
     hfov_deg: 95, mirror_of: left}
"""
VAN = """vehicle: {body: van, length: 5.4, width: 2.05, height: 2.3, rear_axle_x: -1.7}
sensors:
  - {name: roof, kind: lidar, model: velodyne-vlp-32c, position: [1.0, 0, 2.45], rpy_deg: [0, 2, 0]}
  - {name: fish, kind: camera, position: [-2.72, 0, 1.3], rpy_deg: [0, 25, 180], image: [1000, 800], cast: [150, 120],
     fx: 310, fy: 310, cx: 500, cy: 400, distortion: {model: kannala_brandt, k1: 0.02, k2: -0.006, k3: 0.001}}
  - {name: near, kind: lidar, model: robosense-bpearl, position: [2.72, 0.4, 0.7], rpy_deg: [0, 90, 10],
     range_m: [0.2, 20]}
"""
TRUCK = """vehicle: {body: truck, length: 9.5, width: 2.5, height: 3.4, rear_axle_x: -3.1}
sensors:
  - {name: l, kind: lidar, model: hesai-xt32, position: [4.6, 1.3, 2.6], rpy_deg: [-3, 4, 45], fails_with: [cab]}
  - {name: r, kind: lidar, model: hesai-xt32, position: [4.6, -1.3, 2.6], rpy_deg: [3, 4, -45], mirror_of: l,
     fails_with: [cab]}
  - {name: C, kind: camera, model: nuscenes-front, position: [4.76, 0, 2.2], rpy_deg: [0, 5, 0]}
"""
MESH = """vehicle: {body: car.obj, length: 4.2, width: 1.8, height: 1.5,
  mesh: {scale: 0.001, rpy_deg: [0, 0, 90], offset: [0.1, 0, 0]}}
sensors:
  - {name: top, kind: lidar, model: ouster-os1-64, position: [0.1, 0, 1.75],
     azimuths_deg: {from: -180, to: 180, count: 512}}
  - {name: door, kind: camera, position: [0.2, 0.95, 0.9], rpy_deg: [0, 20, 90], hfov_deg: 120, cast: [128, 72]}
"""
ODD = """vehicle: {body: sedan}
sensors:
  - {name: inside, kind: lidar, position: [0, 0, 0.8], elevations_deg: {from: -30, to: 30, count: 9}}
  - {name: below, kind: lidar, position: [3, 0, -0.5], elevations_deg: [10, 20],
     azimuths_deg: {from: -60, to: 60, count: 90}}
  - {name: down, kind: camera, position: [0, 0, 6.5], rpy_deg: [0, 90, 0], hfov_deg: 60, cast: [90, 60]}
  - {name: side, kind: lidar, position: [-2.4, 0, 1], rpy_deg: [90, 0, 180],
     elevations_deg: {from: -15, to: 15, count: 16}, azimuths_deg: [-40, -20.5, -3, 0, 3, 20.5, 40], range_m: [2, 18]}
  - {name: off, kind: camera, position: [1, 0, 1.5], hfov_deg: 40, enabled: false}
"""
NEED = """riglens_requirements: 1
settings: {blind_voxel_m: 0.25, voxel_m: 0.25}
seen: [{class: car, at_least: LOW}, {class: pedestrian, by: lidar, at_least: LOW}]
on_target: [{class: car, at_least: LOW}, {class: pedestrian, ring_m: [0, 20], figure: share_5, at_least: LOW}]
blind_areas: [{height_m: 1.15, at_most_m2: HIGH}, {height_m: 0.3, sector: rear, within_m: 5, at_most_m2: HIGH}]
blind_objects: [{profile: adults-around, at_most_unseen: 4}, {profile: un-r158-detection, at_most_unseen: 9}]
losses: [{of: voxels, class: car, failure: sensor, at_most: 1.0}, {of: objects, class: car, at_most: 1.0}]
covered: [{of: voxels, class: car, sensors: 2, at_least: LOW}]
tolerance: [{profile: assembly, figure: seen, class: car, limit: LOW, draws: 8, at_most: 0.5}]
mounts: {height_m: [0.3, 2.2], gap_m: 0.1, spacing_m: 0.1, beyond_m: {left: 0.1, top: 0.4}, width_m: 2.2}
"""
BENCH = """bench-lidar:
  {kind: lidar, maker: Bench, title: A prototype of the bench, source: Measured on the bench in March,
   range_m: [0.2, 80], elevations_deg: [-8, -4, -2, -1, 0, 1, 3], azimuths_deg: {from: -60, to: 60, count: 300},
   range_at: {0.1: 40}}
"""
PROFILES = """riglens_profiles: 1
profiles:
  - {name: bollard, title: A bollard, source: our choice, rays: 5, share: 0.2, object: {height: 0.9, diameter: 0.2},
     at: [{name: near, ahead: 0.5, left: 0.0}, {name: far, behind: 2, right: 1.1}]}
  - {name: strip, title: A strip, source: our choice, by: camera, object: {height: 0.8, diameter: 0.3},
     field: {behind: [0.2, 1.0], across: width}, spacing: 0.4}
"""
KITTI = (
    "0 0 Car 0 0 -1.5 0 0 10 10 1.5 1.6 4.0 1.0 1.7 10.0 0.1\n"
    "3 1 Cyclist 0 0 0 0 0 9 9 1.7 0.6 1.8 -2.0 1.7 7.0 1.1\n"
)
CALIB = """P2: 700 0 600 40 0 700 180 0.2 0 0 1 0.003
R_rect 1 0 0 0 1 0 0 0 1
Tr_velo_cam 0 -1 0 0 0 0 -1 -0.08 1 0 0 -0.27
Tr_imu_velo 1 0 0 0 0 1 0 0 0 0 1 0
"""
HEADER = "seq,frame,cls,x,y,z,length,width,height,yaw"


def write_inputs(folder: Path) -> None:
    """Write rigs, traffic, requirements and wrong files, the same in every run."""
    rigs = {"skew": SKEW, "van": VAN, "truck": TRUCK, "mesh": MESH, "odd": ODD, "bare": "sensors: []\n"}
    rigs["small"] = (
        f"sensors:\n  - {CAMERA}\n  - {{name: L, kind: lidar, model: velodyne-vlp-16, position: [0, 0, 2]}}\n"
    )
    rigs["bench"] = (
        "sensors:\n  - {name: L, kind: lidar, model: bench-lidar, position: [2, 0.1, 1.1], rpy_deg: [1, 2, 3]}\n"
    )
    rigs |= {
        "bad-key": "colour: red\n",
        "bad-yaml": "sensors: [unclosed\n",
        "bad-twice": f"sensors: [{CAMERA}, {CAMERA}]\n",
    }
    rigs["bad-number"] = f"sensors: [{CAMERA.replace('hfov_deg: 70', 'hfov_deg: -70')}]\n"
    files = {f"{name}.yaml": HEAD.replace("NAME", name) + text for name, text in rigs.items()}
    files["bad-version.yaml"] = "riglens: 2\nname: future\nsensors: []\n"
    files |= {"easy.yaml": NEED.replace("LOW", "0.0").replace("HIGH", "9999").split("mounts")[0]}
    files |= {
        "hard.yaml": NEED.replace("LOW", "0.9").replace("HIGH", "0.5"),
        "library.yaml": BENCH,
        "profiles.yaml": PROFILES,
    }
    files["mounts.yaml"] = (
        "riglens_requirements: 1\nblind_objects: [{profile: bollard, at_most_unseen: 0}]\nmounts: {gap_m: 0.5}\n"
    )
    files["own.yaml"] = (
        "riglens_requirements: 1\nsettings: {voxel_m: 0.25}\n"
        "losses: [{of: voxels, class: car, failure: group, name: left bracket, at_most: 0.3}]\n"
        "tolerance: [{profile: line 3, class: car, limit: 0.1, draws: 8, at_most: 0.05}]\n"
        "tolerance_profiles: [{name: line 3, source: measured, position_mm: 2, angle_deg: 0.05}]\n"
    )
    files["bad-need.yaml"] = "riglens_requirements: 1\nseen: [{class: lorry, at_least: 0.5}]\n"
    files["bad.csv"] = f"{HEADER}\ns,0,car,0,0,1,4,-2,1,0\n"
    files["short.csv"] = "seq,frame,cls,x,y,z\ns,0,car,0,0,1\n"
    corners = [(x, y, z) for x in (-900, 900) for y in (-2100, 2100) for z in (200, 1500)]
    sides = ("1 2 4 3", "5 7 8 6", "1 5 6 2", "3 4 8 7", "1 3 7 5", "2 6 8 4")
    files["car.obj"] = "".join(f"v {x} {y} {z}\n" for x, y, z in corners) + "".join(
        f"f {side}\n" for side in sides
    )
    files["kitti/label_02/0000.txt"], files["kitti/calib/0000.txt"] = KITTI, CALIB
    rows, more = list(traffic(20231, 60)), list(traffic(77, 25))
    files["boxes.csv"] = "\n".join([HEADER, *rows, ""])
    files["true.csv"] = "\n".join(
        [f"{HEADER},num_lidar_pts", *(f"{row},{n * 7 % 41}" for n, row in enumerate(rows)), ""]
    )
    mount = {"LIDAR_TOP": {"translation": [0.9, 0, 1.84], "rotation_wxyz": [0.7071, 0.0015, 0.0045, -0.7071]}}
    files["rigs.json"] = json.dumps({f"s{number}": mount for number in range(3)})
    files["occluders.csv"] = (
        f"map,{HEADER[10:]}\ntown,building,9,9,3,8,5,6,0.3\ntown,wall,-6,-7,1,12,0.4,2,-0.2\n"
    )
    frames = (
        f"s{number // 20},{number},town,{number / 8},{number / 40},0,{number / 100}" for number in range(60)
    )
    files["poses.csv"] = "\n".join(["seq,frame,map,x,y,z,yaw", *frames, ""])
    for name, text in files.items():
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        (folder / name).write_text(text, encoding="utf-8")
    table = pyarrow.csv.read_csv(io.BytesIO("\n".join([HEADER, *more, ""]).encode()))  # noqa: TID251
    pyarrow.parquet.write_table(table, folder / "more.parquet")


def traffic(seed: int, frames: int) -> Iterator[str]:
    """Yield rows of a table of boxes; the numbers are a linear congruence, so no library decides what they are."""

    def number(low: float, high: float) -> float:
        nonlocal seed
        seed = (seed * 6364136223846793005 + 1442695040888963407) % 2**64
        return round(low + (high - low) * (seed >> 33) / 2**31, 3)

    kinds = {
        "car": (4.5, 1.9, 1.6),
        "bicycle": (1.8, 0.6, 1.7),
        "pedestrian": (0.6, 0.6, 1.75),
        "tram": (14, 2.4, 3.2),
    }
    for frame in range(frames):
        for kind, size in [*kinds.items(), *list(kinds.items())[:3]] * 2:
            x, y = number(-32, 32), number(-22, 22)
            if abs(x) > 7 or abs(y) > 3:
                sides = ",".join(str(round(side * number(0.8, 1.2), 3)) for side in size)
                yield f"s{frame // 20},{frame},{kind},{x},{y},{number(0.7, 1.0)},{sides},{number(-3.1, 3.1)}"
