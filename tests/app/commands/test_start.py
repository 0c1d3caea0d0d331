"""What a start loads before the window's first picture and before --help, and what waits until somebody needs it."""

from __future__ import annotations

import os
import subprocess
import sys

import pytest

from riglens.app.commands import start
from riglens.app.commands.parsing import app, run
from tests.app.conftest import REPOSITORY
from tests.waiting import TIMEOUT_S

FOR_LATER = (
    *("numba", "riglens.core.kernels.runtime.jit", "scipy", "pyarrow", "pandas", "trimesh", "dask", "rich"),
    *(
        "riglens.evaluation.scenario",
        "riglens.core.scene.readers",
        "riglens.core.formats.exchange",
        "http.client",
    ),
    *(
        "riglens.core.study.stability_metric",
        "cyclopts",
        "matplotlib.pyplot",
        "matplotlib.figure",
        "qtpy.QtWidgets",
    ),
)
OPENED = """
import sys
import riglens.app.commands, riglens.app.commands.start
riglens.app.commands.start.load_packages()
assert "pyvista.plotting" in sys.modules and "PySide6" not in sys.modules, "Qt slows down what comes after it"
import riglens.app.window.start, riglens.widgets.viewport.viewport
"""


def output_of(script: str) -> tuple[str, str]:
    """What a Python of its own prints, on standard output and standard error."""
    done = subprocess.run(
        [sys.executable, "-c", script],
        cwd=REPOSITORY,
        env={**os.environ, "PYTHONPATH": str(REPOSITORY)},
        capture_output=True,
        encoding="utf-8",
        timeout=TIMEOUT_S,
        check=False,
    )
    return done.stdout, done.stderr


def test_what_only_few_commands_need_is_not_loaded_with_the_window_and_whole_later() -> None:
    script = f"print([name for name in ('riglens.app.window.features.maps', *{FOR_LATER}) if name in sys.modules])\n"
    loaded = "['riglens.app.window.features.maps']\n"  # all features are loaded, as for a window
    script += """
import pyvista
from pyvista.plotting.colors import get_matplotlib_theme_cycler
canvas, colours = pyvista.ChartMPL()._canvas, pyvista.LookupTable("turbo").cmap
print(len(get_matplotlib_theme_cycler()), type(canvas).__name__, colours.name)
import matplotlib.pyplot, qtpy.QtWidgets
print(matplotlib.pyplot.figure().number, qtpy.QtWidgets.QAction.__module__)
"""
    assert output_of(OPENED + script) == (loaded + "10 FigureCanvasAgg turbo\n2 PySide6.QtGui\n", "")


def test_a_rig_alone_opens_the_window_as_the_parser_of_commands_would(riglens, monkeypatch) -> None:
    opened = []
    monkeypatch.setattr(start, "start", lambda *asked: opened.append(asked) or 0)
    for words in ([], ["W+T"], ["rigs/mine.yaml"]):
        assert riglens(*words).code == run(words) == 0
    assert opened[::2] == opened[1::2] and len(opened) == 6
    assert opened[0][0] == "nuScenes car"


def test_no_word_that_opens_the_window_at_once_is_a_command() -> None:
    commands = [name for name in app if not name.startswith("-")]
    assert "evaluate" in commands and all(name.isalpha() for name in commands)


# ---------------------------------------------------------------- help


@pytest.mark.parametrize(
    "words",
    [
        [],
        ["evaluate"],
        ["review"],
        ["data", "build"],
        ["render"],
        ["list", "rigs"],
        ["study"],
        ["study", "table1"],
    ],
)
def test_help_explains_every_option(riglens, words):
    result = riglens(*words, "--help")
    assert result.code == 0
    assert "Usage: riglens" in result.out
    assert result.err == ""


@pytest.mark.parametrize("words", [["--help"], ["evaluate", "--help"]])
def test_help_loads_no_heavy_package(words):
    script = (
        f"import sys; from riglens.app.commands import main; main({words});"
        "heavy = ('numpy', 'numba', 'pydantic', 'PySide6', 'pyvista');"
        "print([name for name in heavy if name in sys.modules], file=sys.stderr)"
    )
    result = subprocess.run(
        [sys.executable, "-c", script],
        cwd=REPOSITORY,
        capture_output=True,
        encoding="utf-8",
        timeout=TIMEOUT_S,
    )
    assert result.stderr == "[]\n"


def test_an_option_has_one_form_wherever_it_is_listed():
    forms: dict[str, set[str]] = {}
    for found in _listed(app):
        for argument in found.assemble_argument_collection() if found.default_command else ():
            for name in argument.names if argument.parameter.show is not False else ():
                if name.startswith("--"):
                    forms.setdefault(name, set()).add(str(argument.parameter.metavar))
    assert len(forms) > 60
    several = {name for name, metavars in forms.items() if len(metavars) > 1}
    assert several == {"--out"}, "it is the one result of a command, of whatever form"


def _listed(of):
    for name in of:
        if not name.startswith("-"):
            yield of[name]
            yield from _listed(of[name])


def test_the_module_and_the_console_script_are_the_same_program():
    result = subprocess.run(
        [sys.executable, "-m", "app", "--version"],
        cwd=REPOSITORY,
        capture_output=True,
        encoding="utf-8",
        timeout=TIMEOUT_S,
    )
    assert result.returncode == 0
    assert result.stdout.strip()
