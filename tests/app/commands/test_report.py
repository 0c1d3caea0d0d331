"""`riglens report`: one page without network, every number from the attached figures, which can be made again."""

import json
import re
from html import unescape

import pytest

from riglens.app.commands import main
from riglens.app.rendering.pdf import pdf_of
from riglens.app.studies.report_figures import differences
from riglens.app.studies.report_page import (
    at,
    attached_figures,
    number_text,
    percent,
    plain,
    square_metres,
    thousand_nat,
)
from tests.app.conftest import BOXES, SMALL_GRID

NAME = '<script>alert("1")</script>'
REQUIRED = "riglens_requirements: 1\nbody: blocks\nblind_areas: [{height_m: 0.3, at_most_m2: 0}]\n"


RIG = """riglens: 1
name: {name}
sensors:
  - {{name: roof, kind: lidar, model: generic-16, position: [0, 0, 1.6], fails_with: [bracket]}}
  - {{name: rear, kind: camera, position: [-2.3, 0, 1.0], rpy_deg: [0, 20, 180], hfov_deg: 120, cast: [32, 24]}}
"""


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    """A report on two rigs, one of which has a hostile name; (page, the words that made it, boxes)."""
    folder = tmp_path_factory.mktemp("report")
    out, required, boxes = folder / "report.html", folder / "required.yaml", folder / "boxes.csv"
    for name, title in (("one.yaml", json.dumps(NAME)), ("two.yaml", "second")):
        (folder / name).write_text(RIG.format(name=title))
    required.write_text(REQUIRED)
    boxes.write_text(BOXES)
    words = (
        "report",
        folder / "one.yaml",
        folder / "two.yaml",
        "--boxes",
        boxes,
        *SMALL_GRID,
        "--draws",
        "2",
    )
    words = (*words, "--requirements", required, "--out")
    assert main([str(word) for word in (*words, out)]) == 0
    return out, words, boxes


def test_the_page_needs_no_network_holds_its_names_as_text_and_is_the_same_twice(made, riglens, tmp_path):
    out, words, _ = made
    page = out.read_text("utf-8")
    assert "https://" not in re.sub(r'<script type="application/json".*?</script>', "", page, flags=re.S)
    assert re.findall(r"(?:src|href)=\"(?!data:)", page) == [] and "default-src 'none'" in page
    assert NAME not in page and "&lt;script&gt;alert" in page
    assert len(re.findall(r"<script", page)) == 4  # figures, two views, and the code that turns them
    assert (
        "<svg" in page and page.count("<canvas>") == 2 and "no evidence of a safety integrity level" in page
    )
    again = tmp_path / "again.html"
    assert riglens(*words, again).code == 0 and again.read_bytes() == out.read_bytes()


def test_every_number_of_a_table_is_that_of_the_attached_figures_and_these_are_the_commands_own(
    made, riglens, boxes
):
    out, words, boxes = made
    page = out.read_text("utf-8")
    figures = attached_figures(page, "report.html")
    cells = re.findall(r'<td data-from="([^"]+)">([^<]*)</td>', page)
    assert len(cells) > 150
    for path, text in cells:
        value = at(figures, unescape(path))
        written = [write(value) for write in (percent, square_metres, thousand_nat, number_text, plain)]
        assert unescape(text) in written, path
    rig, scene = words[1], ("--boxes", boxes, *SMALL_GRID, "--body", "blocks", "--json", "-")
    scores = json.loads(riglens("evaluate", rig, words[2], *scene).out)
    for one in (*scores["rigs"], *figures["evaluation"]["rigs"]):
        one.pop("elapsed_ms")
    assert differences(figures["evaluation"], scores) == []
    blind = json.loads(riglens("blind", rig, "--json", "-").out)
    assert differences(figures["rigs"][0]["blind"], blind) == []
    lost = json.loads(riglens("redundancy", rig, *scene).out)
    assert differences(figures["rigs"][0]["redundancy"]["voxels"], lost["voxels"]) == []
    assert differences(figures["rigs"][0]["redundancy"]["road_users"], lost["road_users"]) == []
    assert not figures["rigs"][0]["check"]["passes"] and "NOT MET" in page


def test_verify_makes_the_figures_again_and_names_what_differs(made, riglens, tmp_path):
    out, _, boxes = made
    same = riglens("report", "--verify", out, "--boxes", boxes)
    assert same.code == 0 and "every figure is the same" in same.out, same.err
    page = out.read_text("utf-8")
    seen = attached_figures(page, "a")["rigs"][0]["blind"]["zones"][0]["share_seen_10m"]
    changed = tmp_path / "changed.html"
    changed.write_text(page.replace(repr(seen), "0.123", 1), "utf-8")
    other = riglens("report", "--verify", changed, "--boxes", boxes)
    assert other.code == 1 and "rigs[0].blind.zones[0].share_seen_10m: attached 0.123" in other.out
    said = riglens("report", "--verify", out)
    assert said.code == 2 and "name these data with --boxes" in said.err


def test_the_same_as_a_pdf_holds_figures_and_rigs_and_is_the_same_twice(made, qapp):
    out, _, _ = made
    page, files = out.read_text("utf-8"), {"figures.json": b"{}", "rig1.yaml": b"riglens: 1"}
    first = pdf_of(page, NAME, files)
    assert first[:5] == b"%PDF-" and first == pdf_of(page, NAME, files)
    assert first.count(b"/Type/Filespec") == 2 and "rig1.yaml".encode("utf-16-be") in first
    assert len(re.findall(rb"/Type /Page\b", first)) >= 4
    dates = re.findall(rb"/CreationDate \(D:(\d+)", first)
    assert dates and set(dates[0]) == {ord("0")}


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (("Center",), "give either rigs with --out"),
        (("--out", "a.html"), "found no rig"),
        (("Center", "--out", "a.docx"), "accepted are .html and .pdf"),
        (("Center", "--out", "a.html", "--draws", "-1"), "--draws: found -1"),
        (("--verify", "missing.html"), "cannot be read"),
        (("Center", "--verify", "a.html"), "it brings its own"),
    ],
)
def test_bad_input_is_told_in_one_line(riglens, arguments, said):
    assert said in riglens("report", *arguments).refused()


@pytest.mark.parametrize("text", ["", "<html>", '<script type="application/json" id="figures">{', "{}"])
def test_what_is_no_report_is_refused(riglens, tmp_path, text):
    path = tmp_path / "a.html"
    path.write_text(text if text != "{}" else '<script type="application/json" id="figures">{}</script>')
    assert "a.html: " in riglens("report", "--verify", path).refused()
