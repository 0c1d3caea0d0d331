"""`riglens study stability`: both tables, the files, and what it says to bad input."""

import contextlib
import csv
import io

import pytest

from riglens.app.commands import main
from tests.app.conftest import BOXES, SMALL_GRID

NAMES = ["stability-methods.csv", "stability-metric.csv", "stability.html"]


@pytest.fixture(scope="module")
def studied(tmp_path_factory):
    """Exit code, standard output and folder of a quick study of a small scene."""
    folder = tmp_path_factory.mktemp("stability")
    boxes = folder / "boxes.csv"
    boxes.write_text(BOXES)
    arguments = ["study", "stability", "--boxes", boxes, *SMALL_GRID, "--quick", "--edits", 30]
    out = io.StringIO()
    with contextlib.redirect_stdout(out):
        code = main([str(argument) for argument in (*arguments, "--out", folder / "deep" / "study")])
    return code, out.getvalue(), folder / "deep" / "study"


def test_it_writes_the_page_and_both_tables(studied):
    code, _, folder = studied
    assert code == 0
    assert sorted(path.name for path in folder.iterdir()) == NAMES
    assert (folder / "stability.html").read_text().startswith("<!DOCTYPE html>")
    methods = list(csv.DictReader((folder / "stability-methods.csv").read_text().splitlines()))
    assert {line["fast_verdict"] for line in methods} == {"ok"}
    assert "30 random edits" in {line["case"] for line in methods}
    orders = list(csv.DictReader((folder / "stability-metric.csv").read_text().splitlines()))
    assert {line["varied"] for line in orders} == {"default", "δ", "rays", "reading", "λ", "frames"}


def test_it_prints_cases_orders_and_findings(studied):
    _, out, _ = studied
    for text in ("rays through corners", "1, 2 and 8 threads", "default: δ 0.50 m", "reading hits"):
        assert text in out
    assert "a rig without sensors is not the best" in out
    assert "fast engine: right in all" in out


def test_it_fits_a_pipe_of_120_columns_and_cuts_nothing(studied):
    _, out, _ = studied
    tables = out.split("τ (Kendall)")[0]
    assert "…" not in tables
    assert max(len(line.rstrip()) for line in tables.splitlines()) <= 120


def test_bad_input_is_refused_before_anything_is_tried(riglens, boxes, tmp_path):
    file = tmp_path / "file"
    file.write_text("")
    common = ("study", "stability", "--boxes", boxes, *SMALL_GRID, "--quick")
    assert "--out" in riglens(*common, "--out", file).refused()
    assert "--edits" in riglens(*common, "--edits", "0", "--out", tmp_path).refused()
    assert "EDITS" in riglens(*common, "--edits", "1.5", "--out", tmp_path).refused().upper()
    assert "--threads" in riglens(*common, "--threads", "0", "--out", tmp_path).refused()
    assert "--lambda" in riglens(*common, "--lambda", "-1", "--out", tmp_path).refused()
