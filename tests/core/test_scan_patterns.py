"""Scan patterns: closed forms, files, and the same answers as ray by ray."""

import math
import os
import pickle
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import pytest
from pyarrow import parquet
from pydantic import ValidationError

from riglens.core.engine.engine import Engine
from riglens.core.errors import InputError
from riglens.core.formats.exchange import FORMATS
from riglens.core.rig.library import default_library, sensor_from_model
from riglens.core.rig.model import Lidar, LinearAngles, Rig
from riglens.core.rig.yaml.file import dumps, load_rig, loads, rig_sha256
from riglens.core.sensing.rays import sensor_rays
from riglens.core.sensors.scan import RayTable, Scan, Swing
from riglens.core.simulate.settings import SimulationSettings
from riglens.core.simulate.sweeps import Simulator
from riglens.core.simulate.world import Worlds
from riglens.core.targets.engine import TargetEngine
from riglens.core.targets.settings import EXACT
from riglens.core.vehicle.solid import Solid, solid_of
from riglens.core.view.frames import FrameBoxes
from riglens.core.view.hits import cast
from riglens.core.view.range_image import range_image
from tests.core.builders import grid_of, random_field, rig_of, seen_by, seen_ray_by_ray
from tests.core.targets import brute_force
from tests.core.targets.cases import random_traffic
from tests.core.vehicle.solids import body_ends

PRISMS = Scan(
    points_per_s=3000.0,
    integration_s=0.1,
    swings=(
        Swing(rate_hz=-121.5657, azimuth_deg=18.0, elevation_deg=18.0),
        Swing(rate_hz=77.743, azimuth_deg=17.0, elevation_deg=17.0),
    ),
)
GRID = grid_of(40, 40, 8, 0.5)


def lidar(rays: Any = PRISMS, **fields: Any) -> Lidar:
    return Lidar(**({"name": "L", "position": (0.1, 0.2, 1.7), "rays": rays} | fields))


# ---------------------------------------------------------------- formulas


def test_two_prisms_draw_a_ring_between_the_difference_and_the_sum_of_their_angles() -> None:
    shots = PRISMS.ray_rows()
    off_deg = np.hypot(shots.azimuth_deg, shots.elevation_deg)
    assert off_deg.min() >= 1.0 - 1e-9 and off_deg.max() <= 35.0 + 1e-9
    assert off_deg.min() < 1.5 and off_deg.max() > 34.5
    np.testing.assert_allclose(shots.time_s, np.arange(300) / 3000.0)


def test_lasers_fire_in_turn_each_from_its_own_place() -> None:
    scan = Scan(
        points_per_s=100.0,
        integration_s=0.11,
        swings=(Swing(rate_hz=10.0, azimuth_deg=40.0, elevation_deg=4.0, wave="ramp"),),
        lasers_deg=((0.0, 0.0), (1.0, 20.0)),
    )
    shots = scan.ray_rows()
    assert scan.ray_count == 10 and lidar(scan).resolution == (5, 2)
    np.testing.assert_allclose(shots.time_s, [0.0, 0.02, 0.04, 0.06, 0.08, 0.01, 0.03, 0.05, 0.07, 0.09])
    np.testing.assert_allclose(shots.azimuth_deg[:5], [-40.0, -24.0, -8.0, 8.0, 24.0])
    np.testing.assert_allclose(shots.azimuth_deg[5:], [-31.0, -15.0, 1.0, 17.0, 33.0])
    np.testing.assert_allclose(shots.elevation_deg[5:], 20.0 + (shots.azimuth_deg[5:] - 1.0) / 10.0)


def test_azimuths_beyond_half_a_turn_come_in_on_the_other_side() -> None:
    scan = Scan(
        points_per_s=4.0, integration_s=1.0, swings=(Swing(rate_hz=1.0, azimuth_deg=200.0, wave="ramp"),)
    )
    np.testing.assert_allclose(scan.ray_rows().azimuth_deg, [160.0, -100.0, 0.0, 100.0])


@pytest.mark.parametrize(
    ("fields", "said"),
    [
        ({"points_per_s": 5.0}, "1 shot of each laser"),
        ({"points_per_s": 1e8, "integration_s": 1.0}, "1 shot of each laser"),
        (
            {"swings": ({"rate_hz": 1.0, "elevation_deg": 60.0}, {"rate_hz": 2.0, "elevation_deg": 40.0})},
            "±90",
        ),
        ({"swings": ()}, "at least 1"),
        ({"integration_s": math.inf}, "10"),
        ({"swings": ({"rate_hz": math.nan},)}, "finite"),
    ],
)
def test_wrong_formulas_are_refused(fields: dict[str, Any], said: str) -> None:
    with pytest.raises(ValidationError, match=said):
        Scan(**(PRISMS.model_dump() | fields))


def test_a_pattern_replaces_beams_and_one_of_the_two_is_needed() -> None:
    with pytest.raises(ValidationError, match="must be left out where rays are given"):
        lidar(elevations_deg=(0.0,))
    with pytest.raises(InputError, match='lidar "L": elevations_deg is missing'):
        loads("riglens: 1\nsensors:\n  - {name: L, kind: lidar, position: [0, 0, 1]}\n")


def test_a_raster_stands_in_for_it_over_the_same_field_of_view() -> None:
    raster = lidar().raster()
    np.testing.assert_array_equal(lidar().elevations(), raster.elevations())
    assert isinstance(raster.rays, type(None)) and 250 <= raster.ray_count <= 300
    assert raster.azimuths().max() == pytest.approx(PRISMS.ray_rows().azimuth_deg.max())
    assert raster.elevations().min() == pytest.approx(PRISMS.ray_rows().elevation_deg.min())
    beams = lidar(None, elevations_deg=(0.0, 1.0))
    assert beams.raster() is beams


# ---------------------------------------------------------------- rig files and tables


def test_a_rig_file_gives_formulas_back() -> None:
    rig = Rig(sensors=(lidar(), lidar(name="M")))
    assert loads(dumps(rig)).rig == rig
    model = sensor_from_model("livox-avia-pattern", "avia", lidar().pose)
    text = dumps(Rig(sensors=(model,)))
    assert "rays" not in text and "azimuths_deg" not in text
    assert loads(text).rig.sensors == (model,)


def test_beams_in_the_file_replace_the_pattern_of_the_model_and_the_other_way_round() -> None:
    head = "riglens: 1\nsensors:\n  - {name: L, kind: lidar, position: [0, 0, 1], "
    beams = loads(head + "model: livox-avia-pattern, elevations_deg: [0, 1]}\n").rig.enabled_lidars()[0]
    assert beams.rays is None and beams.beam_count == 2
    scan = "rays: {points_per_s: 100, integration_s: 0.1, swings: [{rate_hz: 1, azimuth_deg: 9}]}"
    pattern = loads(head + f"model: velodyne-vlp-32c, {scan}}}\n").rig.enabled_lidars()[0]
    assert pattern.ray_count == 10 and pattern.elevations_deg is None


def table_in(folder: Path, name: str = "pattern.csv", rows: int = 50) -> Path:
    columns = {
        "azimuth_deg": np.linspace(-30.0, 30.0, rows),
        "elevation_deg": np.linspace(-10.0, 5.0, rows),
        "time_s": np.arange(rows) / 1000.0,
    }
    if name.endswith(".parquet"):
        parquet.write_table(pa.table(columns), folder / name)
    else:
        lines = [
            ",".join(columns),
            *(
                ",".join(map(repr, row))
                for row in zip(*map(np.ndarray.tolist, columns.values()), strict=True)
            ),
        ]
        (folder / name).write_text("\n".join(lines) + "\n", encoding="utf-8")
    return folder / name


def rig_naming(folder: Path, rays: str) -> Path:
    path = folder / "rig.yaml"
    path.write_text(
        f"riglens: 1\nsensors:\n  - {{name: L, kind: lidar, position: [0, 0, 1.5], rays: {rays}}}\n",
        encoding="utf-8",
    )
    return path


@pytest.mark.parametrize("name", ["pattern.csv", "pattern.parquet"])
def test_a_table_is_read_from_the_folder_of_the_rig(tmp_path: Path, name: str) -> None:
    table_in(tmp_path, name)
    file = load_rig(rig_naming(tmp_path, f"{{file: {name}, integration_s: 0.02}}"))
    (sensor,) = file.rig.enabled_lidars()
    assert sensor.ray_count == 20 and isinstance(sensor.rays, RayTable)
    np.testing.assert_allclose(sensor.rays.ray_rows().azimuth_deg, np.linspace(-30.0, 30.0, 50)[:20])
    longer = sensor.replace(rays=sensor.rays.replace(integration_s=0.03))
    assert longer.ray_count == 30  # from what has been read
    changed = file.updated(file.rig.with_sensor("L", longer))
    assert "integration_s: 0.03" in changed.text
    saved = changed.save(tmp_path / "other.yaml")
    assert load_rig(tmp_path / "other.yaml").rig == saved.rig
    assert pickle.loads(pickle.dumps(saved.rig)) == saved.rig


def test_a_rig_is_not_saved_away_from_its_table(tmp_path: Path) -> None:
    table_in(tmp_path)
    file = load_rig(rig_naming(tmp_path, "{file: pattern.csv}"))
    away = tmp_path / "away"
    away.mkdir()
    with pytest.raises(InputError, match=r"its folder must hold pattern\.csv, the rays of L"):
        file.save(away / "rig.yaml")
    assert not list(away.iterdir())


def test_the_columns_of_livox_are_understood(tmp_path: Path) -> None:
    (tmp_path / "mid.csv").write_text(
        "Time/s,Azimuth/deg,Zenith/deg\n0.0,350.0,95.0\n0.01,10.0,80.0\n", encoding="utf-8"
    )
    (sensor,) = load_rig(rig_naming(tmp_path, "{file: mid.csv}")).rig.enabled_lidars()
    assert isinstance(sensor.rays, RayTable)
    assert sensor.rays.ray_rows().azimuth_deg.tolist() == [-10.0, 10.0]
    assert sensor.rays.ray_rows().elevation_deg.tolist() == [-5.0, 10.0]


def test_the_hash_of_a_rig_holds_the_content_of_its_table(tmp_path: Path) -> None:
    path = rig_naming(tmp_path, "{file: pattern.csv}")
    hashes = []
    for rows in (50, 51, 50):
        table_in(tmp_path, rows=rows)
        hashes.append(rig_sha256(load_rig(path).rig))
    assert hashes[0] == hashes[2] != hashes[1]


@pytest.mark.parametrize(
    ("content", "said"),
    [
        (None, "cannot be read"),
        (b"", "not a table"),
        (b"azimuth_deg,elevation_deg\n", "1 to"),
        (b"azimuth_deg\n1\n", "column elevation_deg is missing"),
        (b"azimuth_deg,elevation_deg\n1,2\n3,up\n", "must hold numbers"),
        (b"azimuth_deg,elevation_deg\n1,2\n3,\n", "row 2: elevation must be"),
        (b"azimuth_deg,elevation_deg\n1,2\n3,91\n", "row 2: elevation must be -90 to 90"),
        (b"azimuth_deg,elevation_deg\n1,2\nnan,0\n", "row 2: azimuth must be"),
        (b"azimuth_deg,elevation_deg,time_s\n1,2,-1\n", "row 1: time must be"),
        (b"azimuth_deg,elevation_deg,time_s\n1,2,5\n", "within the integration time"),
        (b"PAR1 and no more", "not a table"),
        (b"\xff\xfe\x00\x01" * 100, "is missing|not a table"),
    ],
)
def test_wrong_tables_end_with_one_line(tmp_path: Path, content: bytes | None, said: str) -> None:
    if content is not None:
        (tmp_path / "pattern.csv").write_bytes(content)
    path = rig_naming(tmp_path, "{file: pattern.csv, integration_s: 1}")
    with pytest.raises(InputError, match=said) as error:
        load_rig(path)
    assert str(error.value).startswith(f"{path}:3: ") and "\n" not in str(error.value)


def test_texts_of_a_parquet_table_are_refused_by_their_type(tmp_path: Path) -> None:
    """A text that is written once and meant for each row would take 200 MB."""
    texts = pa.DictionaryArray.from_arrays(pa.array([0] * 2000, pa.int32()), pa.array(["x" * 100_000]))
    columns = {"azimuth_deg": texts, "elevation_deg": pa.array(np.zeros(2000))}
    parquet.write_table(pa.table(columns), tmp_path / "pattern.parquet", store_schema=False)
    assert (tmp_path / "pattern.parquet").stat().st_size < 110_000
    before, pool = pa.default_memory_pool(), pa.proxy_memory_pool(pa.default_memory_pool())
    pa.set_memory_pool(pool)
    try:
        with pytest.raises(InputError, match=r"column azimuth_deg must hold numbers \(got type string\)"):
            load_rig(rig_naming(tmp_path, "{file: pattern.parquet}"))
    finally:
        pa.set_memory_pool(before)
    assert pool.max_memory() < 1_000_000


def test_a_pipe_is_no_table_and_text_alone_has_no_folder(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "pattern.csv")
    path = rig_naming(tmp_path, "{file: pattern.csv}")
    with pytest.raises(InputError, match="pipe"):
        load_rig(path)
    with pytest.raises(InputError, match="without the folder"):
        loads(path.read_text(encoding="utf-8"))


# ---------------------------------------------------------------- rays


@pytest.mark.parametrize("rpy_deg", [(0.0, 0.0, 20.0), (5.0, -8.0, 100.0)])
@pytest.mark.parametrize("model", ["livox-avia-pattern", "livox-mid-360-pattern", "robosense-m1-pattern"])
def test_voxels_are_those_of_every_ray(model: str, rpy_deg: tuple[float, float, float]) -> None:
    field = random_field(GRID, np.random.default_rng(3))
    sensor = sensor_from_model(model, "L", lidar(rpy_deg=rpy_deg).pose)
    np.testing.assert_array_equal(seen_by(field, sensor), seen_ray_by_ray(field, sensor))


def test_edits_give_the_scores_of_evaluations_from_scratch() -> None:
    field, sensor = random_field(GRID, np.random.default_rng(4)), lidar()
    engine = Engine(field, 1)
    for x in (0.0, 0.3, -1.2):
        rig = Rig(sensors=(sensor.replace(position=(x, 0.1, 1.6)),))
        assert engine.evaluate(rig).scores == Engine(field, 1).evaluate(rig).scores


def test_the_car_stops_its_rays() -> None:
    rig = Rig(sensors=(lidar(position=(0.0, 0.0, 1.6), rpy_deg=(0.0, 20.0, 0.0)),))
    (sensor,), solid = rig.sensors, solid_of(rig.vehicle)
    ends = body_ends(sensor, solid)
    assert ends.shape == (300,) and 10 < np.isfinite(ends).sum() < 300


@pytest.mark.parametrize("seed", range(4))
def test_points_on_objects_are_those_of_every_ray_against_every_box(seed: int) -> None:
    rng = np.random.default_rng(seed)
    held = random_traffic(rng, 4).within(1e6)
    names = ("livox-mid-360-pattern", "livox-mid-70-pattern")
    rig = rig_of(
        *(
            sensor_from_model(name, name, lidar(rpy_deg=tuple(rng.uniform(-20.0, 20.0, 3).tolist())).pose)
            for name in names
        )
    )
    found, truth = TargetEngine(held).evaluate(rig, EXACT).objects, brute_force.count(held, rig, EXACT)
    assert truth.rays.sum() > 0
    np.testing.assert_array_equal(found.points, truth.rays)
    np.testing.assert_array_equal(found.cells, truth.cells)


def test_the_range_image_holds_every_ray_and_shows_the_gaps_between_them() -> None:
    sensor, body = lidar(rpy_deg=(0.0, 20.0, 0.0)), Solid.of(np.zeros((0, 3, 3)))
    image = range_image(sensor, FrameBoxes.none(), body)
    rays = sensor_rays(sensor)
    from riglens.core.sensing.body_ends import barrier_of

    hits = cast(sensor.position, rays.directions, FrameBoxes.none(), barrier_of(sensor, body), sensor.range_m)
    assert image.returns == np.isfinite(hits.range_m).sum() > 0
    shown = np.isfinite(image.range_m).sum()
    assert image.returns / 2 < shown <= image.returns
    assert np.isin(image.range_m[np.isfinite(image.range_m)], hits.range_m).all()
    below = image.elevations_deg < -20.5
    assert not np.isfinite(image.range_m[below]).all()  # a rosette leaves the corners out


def test_a_simulated_sweep_has_the_laser_and_the_time_of_each_point() -> None:
    rng = np.random.default_rng(1)
    scan = PRISMS.replace(lasers_deg=((0.0, -10.0), (0.0, -20.0)))
    rig = Rig(
        sensors=(
            lidar(scan),
            lidar(None, name="beams", elevations_deg=LinearAngles(from_=-20.0, to=0.0, count=4)),
        )
    )
    settings = SimulationSettings(noise_m=0.0, dropout=0.0, range_law=False)
    sweep = Simulator(rig, Worlds(random_traffic(rng, 1), settings)).sweep(0)
    mine = sweep.of(0)
    assert len(mine.ring) > 50 and set(mine.ring.tolist()) == {0, 1}
    shots = np.round(mine.time_s * 3000.0).astype(int)
    np.testing.assert_array_equal(shots % 2, mine.ring)
    ray = mine.ring.astype(int) * 150 + shots // 2
    away = (mine.points_m - np.array(rig.sensors[0].position)).astype(np.float64)
    along = away / np.linalg.norm(away, axis=1, keepdims=True)
    np.testing.assert_allclose(along, sensor_rays(rig.sensors[0], ray).directions, atol=1e-5)
    assert not sweep.of(1).time_s.any() and len(sweep.of(1).ring) > 50


@pytest.mark.parametrize("name", ["urdf", "carla", "carla-toml", "osi"])
def test_formats_of_beams_say_what_they_write_instead(name: str) -> None:
    (told,) = [
        line for line in FORMATS[name].write(Rig(sensors=(lidar(),))).report.lines() if "scan pattern" in line
    ]
    assert "even raster" in told


def test_models_say_what_is_assumed_of_their_patterns() -> None:
    models = [entry for entry in default_library().entries("lidar") if entry.name.endswith("-pattern")]
    assert len(models) == 6
    told = {entry.name: entry.caveat() for entry in models}
    assert "scan pattern" in told.pop("livox-mid-40-pattern").partition(";")[0]
    assert all("assumed: scan pattern" in caveat for caveat in told.values())
