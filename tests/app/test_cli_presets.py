"""`riglens presets` and what every command says about itself."""

import subprocess
import sys
from pathlib import Path

import pytest

from riglens.core.rig.presets import PRESETS, preset
from riglens.core.rig.yaml.file import load_rig
from tests.waiting import TIMEOUT_S

REPOSITORY = Path(__file__).resolve().parents[2]


def test_all_presets_are_listed_with_their_sensors(riglens):
    result = riglens("presets")
    assert result.code == 0
    rows = {line.split()[0]: line for line in result.out.splitlines() if line.strip()}
    assert set(PRESETS) <= set(rows)
    assert rows["W+T"].split()[1:3] == ["6", "4"]
    assert rows["Center"].split()[1:3] == ["0", "4"]


@pytest.mark.parametrize("name", ["W+T", "N+C", "Pyramid-roll"])
def test_a_preset_written_to_a_file_is_the_same_rig(riglens, tmp_path, name):
    assert riglens("presets", name, "--out", tmp_path / "rig.yaml").code == 0
    assert load_rig(tmp_path / "rig.yaml").rig == preset(name)


def test_a_preset_is_printed_as_yaml(riglens, tmp_path):
    result = riglens("presets", "W+T")
    (tmp_path / "rig.yaml").write_text(result.out)
    assert load_rig(tmp_path / "rig.yaml").rig == preset("W+T")


def test_an_unknown_preset_is_refused_and_the_old_file_stays(riglens, tmp_path):
    (tmp_path / "rig.yaml").write_text("kept")
    assert "W+X" in riglens("presets", "W+X", "--out", tmp_path / "rig.yaml").refused()
    assert (tmp_path / "rig.yaml").read_text() == "kept"


def test_out_without_a_name_is_refused(riglens, tmp_path):
    assert "NAME" in riglens("presets", "--out", tmp_path / "rig.yaml").refused()
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(
    "words", [[], ["evaluate"], ["pog"], ["render"], ["presets"], ["study"], ["study", "table1"]]
)
def test_help_explains_every_option(riglens, words):
    result = riglens(*words, "--help")
    assert result.code == 0
    assert "Usage: riglens" in result.out
    assert result.err == ""


def test_help_loads_no_heavy_package():
    script = (
        "import sys; from riglens.app.commands import main; main(['--help']);"
        "heavy = ('numpy', 'numba', 'pydantic', 'PySide6', 'pyvista');"
        "print([name for name in heavy if name in sys.modules], file=sys.stderr)"
    )
    result = subprocess.run(
        [sys.executable, "-c", script],
        cwd=REPOSITORY,
        capture_output=True,
        text=True,
        timeout=TIMEOUT_S,
    )
    assert result.stderr == "[]\n"


def test_only_commands_that_exist_are_offered(riglens):
    text = riglens("--help").out
    for name in ("evaluate", "pog", "render", "presets", "convert", "study"):
        assert name in text
    for name in ("report", "optimise"):
        assert name not in text


def test_the_module_and_the_console_script_are_the_same_program():
    result = subprocess.run(
        [sys.executable, "-m", "app", "--version"],
        cwd=REPOSITORY,
        capture_output=True,
        text=True,
        timeout=TIMEOUT_S,
    )
    assert result.returncode == 0
    assert result.stdout.strip()
