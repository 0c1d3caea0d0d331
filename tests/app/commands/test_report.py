"""`riglens report`: one page without network, every number from the attached figures, which can be made again."""

import json
import re
import zlib
from html import unescape

import numpy as np
import pytest
from PySide6.QtCore import QSizeF

from riglens.app.commands import main
from riglens.app.rendering.pdf import keep_together, pdf_of, printable
from riglens.app.studies import report_pdf
from riglens.app.studies.report_card import first_text
from riglens.app.studies.report_drawings import Label, labels
from riglens.app.studies.report_figures import differences
from riglens.app.studies.report_page import (
    _origin,
    at,
    attached_figures,
    number_text,
    percent,
    plain,
    square_metres,
    thousand_nat,
)
from riglens.app.studies.report_pdf import figures_in_pdf
from riglens.core.engine.evaluation_json import to_text
from riglens.core.errors import InputError
from riglens.core.rig.presets import preset
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
        if isinstance(value, dict):
            assert unescape(text) == first_text(value, 150.0), path
            continue
        written = [write(value) for write in (percent, square_metres, thousand_nat, number_text, plain)]
        assert unescape(text) in written, path
    rig, scene = words[1], ("--boxes", boxes, *SMALL_GRID, "--body", "blocks", "--json", "-")
    scores = json.loads(riglens("evaluate", rig, words[2], *scene).out)
    for one in (*scores["rigs"], *figures["evaluation"]["rigs"]):
        one.pop("elapsed_ms")
    assert differences(figures["evaluation"], scores) == []
    blind = json.loads(riglens("blind", rig, "--json", "-").out)
    assert differences(figures["rigs"][0]["blind"], blind) == []
    card = json.loads(riglens("card", rig, "--body", "blocks", "--json", "-").out)
    assert differences(figures["rigs"][0]["card"], card) == []
    lost = json.loads(riglens("redundancy", rig, *scene).out)
    assert differences(figures["rigs"][0]["redundancy"]["voxels"], lost["voxels"]) == []
    assert differences(figures["rigs"][0]["redundancy"]["road_users"], lost["road_users"]) == []
    assert not figures["rigs"][0]["check"]["passes"] and "NOT MET" in page


def test_verify_makes_the_figures_of_a_page_or_a_pdf_again_and_names_what_differs(
    made, riglens, tmp_path, qapp
):
    out, _, boxes = made
    same = riglens("report", "--verify", out, "--boxes", boxes)
    assert same.code == 0 and "every figure is the same" in same.out, same.err
    figures = attached_figures(out.read_text("utf-8"), "a")
    figures["rigs"][0]["blind"]["zones"][0]["share_seen_10m"] = 0.123
    changed = tmp_path / "changed.pdf"  # a PDF brings its figures along, too
    changed.write_bytes(pdf_of("<p>a page</p>", "a title", {"figures.json": to_text(figures).encode()}))
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
    large = {"riglens_report": 1, "many": list(range(20_000))}
    assert (
        json.loads(figures_in_pdf(pdf_of("<p>", "", {"figures.json": to_text(large).encode()}), "a")) == large
    )
    dates = re.findall(rb"/CreationDate \(D:(\d+)", first)
    assert dates and set(dates[0]) == {ord("0")}


TABLE = (
    '<div class="wide"><table><caption>Lost</caption><thead><tr><th></th><th class="left">pair</th><th>rear-right</th>'
    "</tr></thead>{rows}</table></div>"
)
ROW = '<tr><td>pedestrian</td><td class="left short">one + other</td><td data-from="a/b">12.34 %</td></tr>'


def pages(document, high):
    """On which pages texts of a laid-out document stand, by text."""
    layout, block, found = document.documentLayout(), document.begin(), {}
    while block.isValid():
        found.setdefault(block.text(), []).append(int(layout.blockBoundingRect(block).center().y() / high))
        block = block.next()
    return found


@pytest.mark.parametrize("lines", range(2, 20, 3))
def test_a_heading_is_never_left_alone_and_a_small_table_never_cut_where_a_pdf_is_printed(qapp, lines):
    high = 600.0
    page = "<p>line</p>" * lines + "<h3>Redundancy</h3><p>A remark.</p>" + TABLE.format(rows=ROW * 9)
    document = printable(page)
    document.setPageSize(QSizeF(500.0, high))
    keep_together(document)
    found = pages(document, high)
    assert len(set(found["pedestrian"])) == 1 and found["Lost"] == found["pair"] == found["pedestrian"][:1]
    assert found["Redundancy"] == found["A remark."] == found["Lost"]
    assert max(found["line"]) == 0


def test_names_of_columns_are_repeated_on_each_page_of_a_long_table_and_no_word_is_broken(qapp):
    document = printable(TABLE.format(rows=ROW * 90))
    document.setPageSize(QSizeF(500.0, 600.0))
    keep_together(document)
    (table,) = document.rootFrame().childFrames()
    assert table.format().headerRowCount() == 2 and table.columns() == 3 and document.pageCount() > 1
    layout, block = document.documentLayout(), document.begin()
    while block.isValid():
        assert block.layout().lineCount() <= 1 and layout.blockBoundingRect(block).height() < 20.0
        block = block.next()


def test_origins_of_models_are_told_in_one_line():
    assert "unverified" in _origin("waymo-top") and "\n" not in _origin("waymo-top")


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


def pdf_with(stream: bytes, entries: bytes = b"/Filter /FlateDecode", name: str = "figures.json") -> bytes:
    """As much of a PDF with an attachment as is read."""
    spec = b"/F (" + ("\ufeff" + name).encode("utf-16-be") + b")\n/EF <</F 7 0 R>>"
    held = b"\n7 0 obj\n<<\n/Length 8 0 R\n" + entries + b"\n>>\nstream\n" + stream + b"\nendstream"
    return b"%PDF-1.4" + held + b"\n8 0 obj\n%d\nendobj\n" % len(stream) + spec


def test_figures_in_a_pdf_that_is_wrong_are_told_and_no_bomb_is_unpacked(monkeypatch):
    good = zlib.compress(b"{}")
    assert figures_in_pdf(pdf_with(good), "a.pdf") == "{}"
    assert figures_in_pdf(pdf_with(b"{}", b""), "a.pdf") == "{}"
    wrong = {
        "found no attached figures.json": pdf_with(good, name="other.json"),
        "is damaged": pdf_with(b"no stream of zlib"),
        "cannot be read; save the attachment": pdf_with(good).replace(b"8 0 obj", b"9 0 obj"),
        "cannot be read": pdf_with(good).replace(b"\n%d\nendobj" % len(good), b"\n99999\nendobj"),
    }
    for said, content in wrong.items():
        with pytest.raises(InputError, match=f"^a.pdf: .*{said}"):
            figures_in_pdf(content, "a.pdf")
    monkeypatch.setattr(report_pdf, "MAX_FIGURES_BYTES", 1000)
    with pytest.raises(InputError, match=r"larger than 0\.001 MB"):
        figures_in_pdf(pdf_with(zlib.compress(b"0" * 1001)), "a.pdf")


def test_labels_of_plans_do_not_meet_and_pairs_that_are_one_in_a_plan_share_one():
    for name in ("W+T", "Trapezoid"):
        spots = np.array([sensor.position for sensor in preset(name).sensors])
        for axes in ([1, 0], [0, 2]):
            found = labels(62.0 * spots[:, axes])
            assert not any(one.meets(other) for n, one in enumerate(found) for other in found[:n])
            dots = [Label(x - 3.0, y + 4.0, "") for x, y in (62.0 * spots[:, axes]).tolist()]
            assert not any(label.meets(dot) for label in found for dot in dots)
            numbers = [int(number) for label in found for number in label.text.split(", ")]
            assert sorted(numbers) == list(range(1, len(spots) + 1))
    pair = labels(np.array([[10.0, 10.0], [80.0, 10.0], [10.0, 12.0]]))
    assert [label.text for label in pair] == ["1, 3", "2"]
