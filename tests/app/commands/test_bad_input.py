"""Bad input ends with exit code 2 and one line that says where, what was found and what is accepted."""

import shlex

import pytest

from riglens.app.commands import running
from riglens.app.commands.parsing import COMMANDS, GROUPS, app, meant_command
from riglens.core.rig.presets import PRESETS
from tests.app.conftest import SMALL_GRID

HEADER = "seq,frame,cls,x,y,z,length,width,height,yaw\n"
LIDAR = "{name: A, kind: lidar, position: [0, 0, 2], elevations_deg: [0]}"


def rig_text(*sensors: str) -> str:
    return "riglens: 1\nname: bad\nsensors:\n" + "".join(f"  - {sensor}\n" for sensor in sensors)


def test_a_bad_rig_file_is_refused_in_one_line_with_its_name_and_line(riglens, tmp_path, boxes):
    path, target = tmp_path / "bad.yaml", tmp_path / "scores.json"
    path.write_text(rig_text(LIDAR, LIDAR.replace("A", "B").replace("2]", "high]")), encoding="utf-8")
    target.write_text("kept", encoding="utf-8")
    line = riglens("evaluate", path, "--boxes", boxes, *SMALL_GRID, "--json", target).refused()
    assert 'bad.yaml:5: lidar "B": position' in line and target.read_text(encoding="utf-8") == "kept"


def test_a_rig_that_is_neither_file_nor_preset_is_refused_with_the_presets(riglens):
    line = riglens("evaluate", "W+X").refused()
    assert "W+X" in line
    assert "W+T" in line


@pytest.mark.parametrize(
    ("words", "hint"),
    [
        (("evalute", "W+T"), "unknown command 'evalute' (did you mean 'riglens evaluate'?)"),
        (("Evaluates",), "riglens evaluate"),
        (("blind", "W+T"), "unknown command 'blind'"),
        (("help",), "riglens --help"),
        (("evaluate", "W+T", "--json", ""), "empty word"),
        (("data", ""), "empty word"),
        (("evaluate", "W+T", "--pog", "."), "cannot be read: Is a directory"),
    ],
)
def test_a_slip_of_the_fingers_is_told_in_words_that_help(riglens, words, hint):
    assert hint in riglens(*words).refused()


@pytest.mark.parametrize(
    ("command", "option"),
    [
        ("study stability", "--edits"),
        ("study targets", "--azimuths"),
        ("study external", "--frames"),
        ("study detection", "--seeds"),
        ("render", "--scale"),
    ],
)
def test_help_lists_the_options_that_take_a_number(riglens, command, option):
    assert option in riglens(*command.split(), "--help").out


def test_no_line_of_a_docstring_breaks_the_help_of_an_option():
    groups = [(group, name) for group, (_, commands) in GROUPS.items() for name in commands]
    for words in (*((name,) for name in COMMANDS), *groups):
        command = app
        for word in words:
            command = command[word]
        options = command.assemble_argument_collection(parse_docstring=True)
        assert [one.name for one in options if "\n" in (one.parameter.help or "")] == [], words


def test_no_preset_is_taken_for_a_misspelt_command():
    assert [name for name in PRESETS if meant_command(name)] == []


@pytest.mark.parametrize("command", ["evaluate --json", "pog --out", "data --json", "convert"])
def test_a_result_never_takes_the_place_of_what_it_is_made_of(riglens, boxes, tmp_path, command):
    rig = tmp_path / "mine.yaml"
    riglens("list", "rigs", "Line", "--out", rig)
    words = {
        "evaluate --json": ("evaluate", rig, "--boxes", boxes, *SMALL_GRID, "--json", rig),
        "pog --out": ("data", "build", boxes, *SMALL_GRID, "--out", boxes),
        "data --json": ("data", "show", boxes, "--json", boxes),
        "convert": ("convert", rig, rig, "--to", "nuscenes"),
    }
    before = rig.read_bytes(), boxes.read_bytes()
    assert "read as well" in riglens(*words[command]).refused()
    assert (rig.read_bytes(), boxes.read_bytes()) == before


def test_a_switched_off_compiler_is_named(riglens, monkeypatch):
    monkeypatch.setenv("NUMBA_DISABLE_JIT", "1")
    assert "NUMBA_DISABLE_JIT=1: " in riglens("evaluate", "W+T").refused()


def test_a_file_that_is_no_pog_is_not_said_to_need_trust(riglens, boxes):
    assert "unsafe" not in riglens("evaluate", "W+T", "--pog", boxes).refused()


def test_a_bad_box_table_is_refused_with_its_line_and_the_old_pog_stays(riglens, tmp_path):
    rows = "".join(f"s,{i},car,{'1.2.3' if i == 4709 else '1'},0,1,4,2,1,0\n" for i in range(6000))
    (tmp_path / "bad.csv").write_text(HEADER + rows, encoding="utf-8")
    target = tmp_path / "old.npz"
    target.write_text("kept", encoding="utf-8")
    line = riglens("data", "build", tmp_path / "bad.csv", "--out", target, *SMALL_GRID).refused()
    assert "bad.csv" in line and "4711" in line
    assert target.read_text(encoding="utf-8") == "kept"
    assert sorted(path.name for path in tmp_path.iterdir()) == ["bad.csv", "old.npz"]


def test_a_missing_data_set_is_refused_with_what_is_accepted(riglens, tmp_path):
    line = riglens("evaluate", "W+T", "--boxes", tmp_path / "nowhere").refused()
    assert "nowhere" in line
    assert "CSV" in line and "nuScenes" in line


@pytest.mark.parametrize(
    ("options", "hint"),
    [
        (("--voxel", "0.3"), "multiple"),
        (("--voxel", "small"), "--voxel"),
        (("--roi", "60", "40"), "--roi"),
        (("--lambda", "1e308"), "--lambda must be between 0 and 1,000,000 (got 1e+308)"),
        (("--voxel", "1e-320"), "--voxel must be between 0.0001 and 1000 m"),
        (("--roi", "1e308", "40", "4"), "--roi L must be above 0 and at most 100000 m"),
        (
            ("--frames", str(10**30)),
            "--frames must be an integer from 1 to 1000000000 (got a very large number)",
        ),
        (("--frames", "9" * 5000), "--frames"),
        (
            ("--threads", str(10**30)),
            "--threads must be an integer from 1 to 1024 (got a very large number)",
        ),
        (("--threads", "0"), "--threads"),
        (("--method", "guess"), "bresenham"),
        (("--reading", "literal"), "residual"),
        (("--frames", "2"), "--frames"),
        (("--origin", "0", "0"), "--origin"),
        (("--classes", "tram"), "NAME=CLASS"),
        (("--classes", "tram=train"), "pedestrian"),
        (("--json",), "--json"),
        (("--json", "--lambda"), "--json"),
        (("--boxez", "a.csv"), "--boxez"),
    ],
)
def test_a_bad_option_is_refused_by_name(riglens, boxes, options, hint):
    assert hint in riglens("evaluate", "W+T", "--boxes", boxes, *options).refused()


def test_a_grid_too_large_for_memory_is_refused_with_its_size(riglens, boxes):
    line = riglens("evaluate", "W+T", "--boxes", boxes, "--voxel", "0.005").refused()
    assert "12000 x 8000 x 800" in line
    assert "GB" in line


@pytest.mark.parametrize("option", ["--origin 0 0 0", "--frames 9", "--classes tram=car"])
def test_options_about_a_data_set_need_one(riglens, option):
    assert "--boxes" in riglens("evaluate", "W+T", *option.split()).refused()


def test_evaluate_needs_a_rig(riglens):
    assert "RIG" in riglens("evaluate").refused()


def test_a_word_too_many_is_refused(riglens):
    assert "extra" in riglens("W+T", "extra").refused()


def test_a_bad_rig_is_refused_before_any_window_opens(riglens):
    assert "W+X" in riglens("W+X").refused()


@pytest.mark.parametrize("command", ["evaluate", "pog", "presets", "table1", "render"])
def test_an_unwritable_output_is_refused_before_any_work(riglens, tmp_path, boxes, monkeypatch, command):
    monkeypatch.setattr("riglens.core.scene.pog_store.build_pog", None)  # building would fail the test
    monkeypatch.setattr("riglens.jobs.building.build_pog", None)
    (tmp_path / "folder.png").mkdir()
    for path in (tmp_path / "no" / "such" / "folder" / "out.png", tmp_path / "folder.png"):
        words = {
            "evaluate": ("evaluate", "W+T", "--boxes", boxes, *SMALL_GRID, "--json", path),
            "pog": ("data", "build", boxes, *SMALL_GRID, "--out", path),
            "presets": ("list", "rigs", "W+T", "--out", path),
            "table1": ("study", "table1", "--boxes", boxes, *SMALL_GRID, "--csv", path),
            "render": ("render", "W+T", "--boxes", boxes, *SMALL_GRID, "--out", path),
        }[command]
        assert "cannot be written" in riglens(*words).refused()


def test_a_failure_of_the_program_ends_with_3_and_a_traceback(riglens, monkeypatch):
    for error, said in ((RuntimeError("a bug"), "Traceback"), (OSError(28, "full"), "riglens: full")):

        def failing(tokens, error=error):
            raise error

        monkeypatch.setattr(running, "_run", failing)
        found = riglens("list", "rigs")
        assert found.code == 3 and said in found.err and found.out == ""


@pytest.mark.parametrize(
    ("words", "said"),
    [
        ("review Center --blind-width -1", "--blind-width must be between 0 and 5 m (got -1)"),
        ("review Center --blind-within 1000", "--blind-within must be between 1 and 100 m (got 1000)"),
        ("review Center --blind-map map.gif", "--blind-map must end in .csv or .png"),
        ("review Center --profile missing.yaml", "missing.yaml: no such file"),
        ("review Center --only blind --blind-voxel 0", "--blind-voxel must be above 0"),
        ("review Center --only blind --blind-voxel 0.001", "--blind-voxel makes a grid"),
        ("review Center --only range --blind-map a.csv", "--blind-map needs blind in --only"),
        ("review Center --range-to 1", "--range-to must be between"),
        ("review Center --deceleration 0", "--deceleration must be between"),
        ("review Center --directions 0", "--directions must be between 1 and 72 (got 0)"),
        ("review Center --only range --min-points 0", "--min-points must be between"),
        ("review Center --range-chart a.bmp", "--range-chart must end in .png or .svg (got a.bmp)"),
        ("review Center --only blind,card", "--only must be some of blind,range,"),
        ("review Center --draws 0", "--draws must be an integer from 1 to"),
        ("review Center --errors magic", "--errors must be one of assembly"),
        ("review Center --min-points 0", "--min-points must be"),
        ("review Center --seed -1", "--seed must be an integer from 0 to"),
        ("review Center --worst-by 'seen lorry'", "--worst-by must be one of "),
        ("evaluate --targets W+T --within 0", "--within must be above 0"),
        ("evaluate --targets W+T --sample 0", "--sample must be an integer ≥ 1 (got 0)"),
        ("evaluate --targets W+T --min-points -1", "--min-points must be an integer ≥ 1 (got -1)"),
        ("evaluate --targets W+T --seed 1.5", "must be an integer (got 1.5)"),
        ("evaluate --targets W+T --objects o.txt", "--objects must end in .csv or .parquet (got o.txt)"),
        ("evaluate --targets W+T --objects no/folder/o.csv", "cannot be written"),
        ("evaluate --targets W+T Center --objects o.csv", "--objects is for one rig (got 2 rigs)"),
        ("evaluate --targets W+T --frames 3", "specify it with --boxes"),
    ],
)
def test_a_bad_option_of_any_command_is_one_line(riglens, words, said):
    assert said in riglens(*shlex.split(words)).refused()
