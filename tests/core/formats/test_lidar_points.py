"""Beams of unknown LiDARs from their points: what is measured is measured, and anything else is told."""

import json
from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pytest

from riglens.core.formats import lidar_points
from riglens.core.formats.exchange import read_rig
from riglens.core.formats.report import OpenedRig
from tests.core.formats.cases import write_files
from tests.core.formats.test_reports import has, tables

SWEEP = "samples/LIDAR_LEFT/0.pcd.bin"
BEAMS_DEG = (-24.7, -11.2, -3.0, -2.5, 0.0, 1.5, 9.75)


def sweep(beams_deg: Sequence[float] = BEAMS_DEG, per_ring: int = 300, values: int = 5) -> bytes:
    """Points of a LiDAR with these beams, numbered from above, with noise, a hole and points on the own car."""
    random = np.random.default_rng(1)
    azimuth = random.uniform(-np.pi, np.pi, (len(beams_deg), per_ring))
    elevation = np.radians(np.array(beams_deg))[::-1, None] + random.normal(0.0, 1e-4, azimuth.shape)
    range_m = random.uniform(3.0, 60.0, azimuth.shape)
    range_m[:, :20] = 0.5
    elevation[:, :20] = 0.3
    flat = range_m * np.cos(elevation)
    ring = np.broadcast_to(np.arange(len(beams_deg))[:, None], azimuth.shape)
    columns = [flat * np.cos(azimuth), flat * np.sin(azimuth), range_m * np.sin(elevation), ring, ring]
    points = np.stack(columns, axis=-1).astype("<f4").reshape(-1, 5)
    points[7] = np.nan
    return points[:, :values].tobytes()


def with_sweep(folder: Path, content: bytes, said: str = SWEEP) -> OpenedRig:
    """The rig of another car's tables, which name a sweep of its LiDAR."""
    files = tables(("LIDAR_LEFT", "CAM_FRONT"), (1920, 1080))
    rows = json.loads(files["sample_data.json"])
    rows[0]["filename"] = said
    write_files(folder / "set" / "v1.0-mini", files | {"sample_data.json": json.dumps(rows)})
    path = folder / "set" / SWEEP
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_bytes(content)
    return read_rig(folder / "set" / "v1.0-mini")


def test_a_lidar_of_another_car_has_the_beams_of_its_points(tmp_path: Path) -> None:
    read = with_sweep(tmp_path, sweep())
    (found,) = read.rig.enabled_lidars()
    assert found.elevations() == pytest.approx(BEAMS_DEG, abs=0.01) and found.model is None
    assert has(read.report, "7 beams and their elevations are those of its points", "LIDAR_LEFT")
    assert has(read.report, "azimuths and range not in the tables") and not has(read.report, "unknown beams")


RANDOM = np.random.default_rng(2)
NO_BEAMS = np.column_stack([*RANDOM.normal(0, 9, (4, 900)), np.arange(900) % 9]).astype("<f4").tobytes()


@pytest.mark.parametrize(
    ("content", "words"),
    [
        (sweep()[:-3], "does not hold five numbers for each point"),
        (b"", "does not hold five numbers"),
        (sweep(per_ring=25), "too few points on its rings"),
        (sweep(tuple(np.linspace(-80, 80, 300))), "no ring index from 0 to 255"),
        (RANDOM.uniform(0, 9, (500, 5)).astype("<f4").tobytes(), "no ring index"),
        (NO_BEAMS, "not beams of one elevation each"),
    ],
    ids=["cut", "empty", "few", "rings", "random", "cloud"],
)
def test_points_that_tell_no_beams_are_told_and_beams_assumed(
    tmp_path: Path, content: bytes, words: str
) -> None:
    read = with_sweep(tmp_path, content)
    assert read.rig.enabled_lidars()[0].model == "generic-16" and has(read.report, "unknown beams", "assumed")
    assert has(read.report, words, "LIDAR_LEFT")


@pytest.mark.parametrize(
    "said",
    ["../out.pcd.bin", "/etc/hostname.bin", "link/out.pcd.bin", "a\0.bin", "x" * 600 + ".bin"],
    ids=range(5),
)
def test_sweeps_outside_the_folder_are_not_opened(tmp_path: Path, said: str) -> None:
    (tmp_path / "out.pcd.bin").write_bytes(sweep())
    (tmp_path / "set").mkdir()
    (tmp_path / "set" / "link").symlink_to(tmp_path)
    read = with_sweep(tmp_path, sweep(), said)
    assert read.rig.enabled_lidars()[0].model == "generic-16" and not has(
        read.report, "the sweep of its points"
    )


def test_a_sweep_larger_than_the_limit_is_not_read(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(lidar_points, "MAX_BYTES", 1000)
    assert has(with_sweep(tmp_path, sweep()).report, "is larger than")
