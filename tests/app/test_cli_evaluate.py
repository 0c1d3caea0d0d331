"""`riglens evaluate`: a table for people, JSON for programs, and nothing else on standard output."""

import json
import math
import subprocess
import sys

import pytest

from tests.app.conftest import REPOSITORY
from tests.waiting import TIMEOUT_S

SMALL = ("--voxel", "0.5", "--roi", "20", "20", "4")


def test_the_json_holds_every_key_of_the_promise(riglens, boxes):
    result = riglens("evaluate", "W+T", "Center", "--boxes", boxes, *SMALL, "--json", "-")
    assert result.code == 0
    document = json.loads(result.out)
    assert list(document) == ["riglens", "grid", "data", "method", "reading", "lambda", "rigs"]
    assert document["riglens"] == 1
    assert document["grid"]["shape"] == [40, 40, 8]
    assert document["grid"]["origin_m"] == [-10, -10, 0]
    assert document["data"]["frames"] == 3
    assert document["data"]["boxes"] == {"car": 2, "bicycle": 1, "pedestrian": 1}
    assert len(document["data"]["sha256"]) == 64
    wide, center = document["rigs"]
    assert (wide["name"], center["name"]) == ("W+T", "Center")
    assert len(wide["sha256"]) == 64
    assert wide["sha256"] != center["sha256"]
    assert set(wide["covered_voxels"]) == {"camera", "lidar", "any"}
    for scores in wide["classes"].values():
        assert list(scores) == ["h_total", "camera", "lidar", "any", "s_ms"]


def test_the_json_figures_fit_together(riglens, boxes):
    result = riglens("evaluate", "W+T", "--boxes", boxes, *SMALL, "--lambda", "0.25", "--json", "-")
    document = json.loads(result.out)
    assert document["lambda"] == 0.25
    for scores in document["rigs"][0]["classes"].values():
        camera, lidar = scores["camera"], scores["lidar"]
        assert scores["h_total"] > 0.0
        assert camera["seen"] == pytest.approx(-camera["s_mig"] / scores["h_total"], rel=1e-12)
        assert scores["s_ms"] == pytest.approx(0.25 * camera["s_mig"] + lidar["s_mig"], rel=1e-12)
        assert max(camera["seen"], lidar["seen"]) <= scores["any"]["seen"] <= 1.0


def test_a_rig_without_sensors_or_a_class_without_boxes_gives_zeros_not_nan(riglens, tmp_path):
    (tmp_path / "empty.yaml").write_text("riglens: 1\nname: empty\nsensors: []\n")
    (tmp_path / "cars.csv").write_text(
        "seq,frame,cls,x,y,z,length,width,height,yaw\ns,0,car,0,0,1,4,2,1.5,0\ns,1,car,9,9,1,4,2,1.5,0\n"
    )
    result = riglens(
        "evaluate", tmp_path / "empty.yaml", "--boxes", tmp_path / "cars.csv", *SMALL, "--json", "-"
    )
    assert "NaN" not in result.out
    classes = json.loads(result.out)["rigs"][0]["classes"]
    assert classes["pedestrian"]["h_total"] == 0.0
    assert classes["pedestrian"]["any"]["seen"] == 0.0
    assert classes["car"]["s_ms"] == 0.0
    assert math.copysign(1.0, classes["car"]["s_ms"]) == 1.0


def test_standard_output_is_json_alone_and_notes_go_to_standard_error(riglens, boxes):
    result = riglens("evaluate", "W+T", "--boxes", boxes, *SMALL, "--json", "-")
    json.loads(result.out)
    assert result.err == "note: 1 box belongs to no class and does not count: shopping_cart 1\n"


def test_a_json_file_is_written_beside_the_table(riglens, boxes, tmp_path):
    target = tmp_path / "scores.json"
    result = riglens("evaluate", "W+T", "--boxes", boxes, *SMALL, "--json", target)
    assert result.code == 0
    assert json.loads(target.read_text())["rigs"][0]["name"] == "W+T"
    for word in ("S-MIG", "S-MS", "seen", "W+T", "pedestrian, H(Ω)", "3 frames", "reading covered"):
        assert word in result.out


def test_the_table_fits_a_terminal_of_100_columns(riglens, boxes):
    result = riglens("evaluate", "W+C", "N+T", "--boxes", boxes, *SMALL)
    *table, _ = result.out.rstrip().splitlines()[3:]  # without what was scored, and the explanation
    assert max(len(line.rstrip()) for line in table) <= 100


def test_negative_numbers_are_values_not_options(riglens, boxes):
    moved = riglens(
        "evaluate", "W+T", "--origin", "-1.35", "0", "-1e-3", "--boxes", boxes, *SMALL, "--json", "-"
    )
    assert moved.code == 0
    here = riglens("evaluate", "W+T", "--boxes", boxes, *SMALL, "--json", "-")
    assert json.loads(moved.out)["data"]["sha256"] != json.loads(here.out)["data"]["sha256"]


def test_scores_do_not_depend_on_the_number_of_threads(riglens, boxes):
    runs = [
        json.loads(riglens("evaluate", "N+P", "--boxes", boxes, *SMALL, "--threads", n, "--json", "-").out)
        for n in (1, 2)
    ]
    assert runs[0]["rigs"][0]["classes"] == runs[1]["rigs"][0]["classes"]


def test_each_reading_and_method_says_its_name(riglens, boxes):
    for extra in (("--reading", "residual"), ("--reading", "hits"), ("--method", "bresenham")):
        document = json.loads(
            riglens("evaluate", "Line", "--boxes", boxes, *SMALL, *extra, "--json", "-").out
        )
        assert document[extra[0].lstrip("-")] == extra[1]


def test_residual_leaves_what_covered_sees(riglens, boxes):
    def s_mig(reading: str) -> tuple[float, float]:
        run = riglens("evaluate", "Line", "--boxes", boxes, *SMALL, "--reading", reading, "--json", "-")
        car = json.loads(run.out)["rigs"][0]["classes"]["car"]
        return car["lidar"]["s_mig"], car["h_total"]

    covered, total = s_mig("covered")
    residual, _ = s_mig("residual")
    assert covered + residual == pytest.approx(-total, rel=1e-12)


def test_a_class_can_be_mapped_or_ignored_by_the_user(riglens, boxes):
    mapped = ("--classes", "shopping_cart=pedestrian", "--classes", "bicycle=ignore")
    result = riglens("evaluate", "W+T", "--boxes", boxes, *SMALL, *mapped, "--json", "-")
    assert json.loads(result.out)["data"]["boxes"] == {"car": 2, "bicycle": 0, "pedestrian": 2}


def test_a_rig_name_is_printed_as_it_is(riglens, boxes, tmp_path):
    (tmp_path / "odd.yaml").write_text("riglens: 1\nname: '[red]odd[/]'\nsensors: []\n")
    result = riglens("evaluate", tmp_path / "odd.yaml", "--boxes", boxes, *SMALL)
    assert "[red]odd[/]" in result.out


def test_a_reader_that_goes_away_early_is_no_error(riglens_process, boxes):
    process = riglens_process("evaluate", "W+T", "--boxes", boxes, *SMALL, "--json", "-")
    assert process.stdout is not None
    process.stdout.close()
    _, err = process.communicate(timeout=TIMEOUT_S)
    assert "Traceback" not in err
    assert "BrokenPipe" not in err
    assert process.returncode == 0


def test_a_full_disk_is_told_in_one_line(riglens_process, boxes):
    process = riglens_process("evaluate", "Line", "--boxes", boxes, *SMALL, "--json", "/dev/full")
    _, err = process.communicate(timeout=TIMEOUT_S)
    assert process.returncode == 1
    assert err.splitlines()[-1] == "riglens: No space left on device"
    assert "Traceback" not in err


def test_a_command_that_draws_nothing_loads_neither_qt_nor_vtk(boxes):
    script = (
        "import sys; from riglens.app.commands import main; code = main(sys.argv[1:]);"
        "loaded = [m for m in sys.modules if m.split('.')[0] in ('PySide6', 'vtkmodules', 'pyvista')];"
        "sys.exit(f'loaded {loaded}' if loaded else code)"
    )
    command = [sys.executable, "-c", script, "evaluate", "W+T", "--boxes", str(boxes), *SMALL]
    result = subprocess.run(command, cwd=REPOSITORY, capture_output=True, text=True, timeout=TIMEOUT_S)
    assert result.returncode == 0, result.stderr
