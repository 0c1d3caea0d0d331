"""`riglens report`: one page without network, every number from the attached figures, which can be made again."""

import base64
import copy
import ctypes
import json
import math
import os
import re
import subprocess
import sys
import zlib
from dataclasses import replace
from html import unescape
from io import BytesIO

import numpy as np
import pypdfium2.raw as raw
import pytest
from PIL import Image
from pypdfium2 import PdfDocument
from scipy.spatial import ConvexHull

from riglens.app.commands import main
from riglens.app.commands import report as report_command
from riglens.core.errors import InputError
from riglens.core.figures.registry import figures as registered
from riglens.core.figures.registry import object_figures
from riglens.core.monitor import SILENT
from riglens.core.plain import to_text
from riglens.core.review.findings import amounts
from riglens.core.rig.presets import preset
from riglens.core.scene.boxes import CLASSES
from riglens.core.shown_text import numbered, visible
from riglens.evaluation.loading import load_rig
from riglens.rendering import system_libraries
from riglens.rendering.system_libraries import Requirement
from riglens.reporting import making
from riglens.reporting import reading as report_reading
from riglens.reporting.charts import estimate_of
from riglens.reporting.document import Drawings, ReportDocument
from riglens.reporting.drawings import car_shape
from riglens.reporting.figures import Labels, differences
from riglens.reporting.making import portable, rendered
from riglens.reporting.page import (
    at,
    few_words,
    first_text,
    hidden_on,
    limit_texts,
    metres,
    origin,
    percent,
    plain,
    report_page,
    square_metres,
    thousand_nat,
    verdict_text,
    whole,
)
from riglens.reporting.pdf import pdf_of
from riglens.reporting.reading import (
    attached_figures,
    figures_in_pdf,
    first_difference,
    inputs_of,
    look_alike,
)
from riglens.reporting.summary import (
    change_words,
    estimate_words,
    missed_objects,
    smallest_range,
    worst_failure,
    worst_profile,
)
from riglens.reporting.svg import Drawing, apart
from riglens.widgets.viewport.still import png_of
from tests.app.conftest import BOXES, SMALL_GRID

NAME = '<script>alert("1")</script>'
DOT, DARK = (png_of(np.full((2, 2, 3), grey, np.uint8)) for grey in (255, 0))


def _stored(png: bytes) -> bytes:
    """The same picture, packed in another way."""
    with Image.open(BytesIO(png)) as image, BytesIO() as stream:
        image.save(stream, "PNG", compress_level=0)
        return stream.getvalue()


LOOSE = _stored(DOT)
REQUIRED = (
    "riglens_requirements: 1\nsettings: {body: blocks, voxel_m: 0.5, roi_m: [20, 20, 4]}\n"
    "blind_areas: [{height_m: 0.3, at_most_m2: 0}]\n"
)


WHY = {
    "figure": "on_target",
    "sensors": ["left <b>", "right"],
    "sentence": "no pair on these 159 mounts is better in these 100 frames (proven).",
    "reference": "typical mounts",
    "verdict": "resolved",
    "checks": [{"case": "held-out frames", "gain": 0.03883, "se": 0.00092, "share": 0.92}],
}
RIG = """riglens: 1
name: {name}
sensors:
  - {{name: roof, kind: lidar, model: generic-16, position: [0, 0, 1.6], fails_with: [bracket]}}
  - {{name: rear, kind: camera, position: [-2.3, 0, 1.0], rpy_deg: [0, 20, 180], hfov_deg: 120, cast: [32, 24]}}
"""


RADAR = "  - {name: grille, kind: radar, model: generic-radar, position: [2.2, 0, 0.5]}\n"


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    """A report on two rigs, the first with a hostile name and a radar; (page, the words that made it, boxes)."""
    folder = tmp_path_factory.mktemp("report")
    out, required, boxes = folder / "report.html", folder / "required.yaml", folder / "boxes.csv"
    (folder / "one.yaml").write_text(RIG.format(name=json.dumps(NAME)) + RADAR, encoding="utf-8")
    (folder / "two.yaml").write_text(RIG.format(name="second"), encoding="utf-8")
    required.write_text(REQUIRED, encoding="utf-8")
    boxes.write_text(BOXES, encoding="utf-8")
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


def test_the_page_needs_no_network_and_holds_its_names_as_text(made):
    page = made[0].read_text("utf-8")
    assert "https://" not in re.sub(r'<script type="application/json".*?</script>', "", page, flags=re.S)
    assert re.findall(r"(?:src|href)=\"(?!data:)", page) == [] and "default-src 'none'" in page
    assert NAME not in page and "&lt;script&gt;alert" in page
    assert (
        len(re.findall(r"<script", page)) == 3
    )  # figures, the view of the second rig, and the code that turns it
    assert page.count("<canvas") == 1 and page.count("<svg") > 15


def test_every_number_of_a_table_is_that_of_the_attached_figures_and_these_are_the_commands_own(
    made, riglens, boxes
):
    out, words, boxes = made
    page = out.read_text("utf-8")
    figures = attached_figures(out.read_bytes(), "report.html")
    cells = re.findall(r'data-from="([^"]+)">([^<]*)<', page)
    assert len(cells) > 250
    for path, text in cells:
        value, (*_, holder, name) = at(figures, unescape(path)), path.split("/")
        if isinstance(value, dict) and "min" in value:
            assert unescape(text) == first_text(value, 150.0), path
            continue
        if holder == "figures" or "sectors" in path:
            figure = next(one for one in registered() if name in (one.key, one.place.split(".")[-1]))
            found = value if isinstance(value, dict) else {"value": value, "se": 0.0}
            said = estimate_words(figure, estimate_of({"state": "exact", "reason": None} | found)).strip("()")
            assert unescape(text).strip("()") in (said, said.split(" ±")[0]), path
            continue
        written = [metres(value)]
        if value is not None:
            written += [
                write(value) for write in (percent, square_metres, hidden_on, thousand_nat, whole, plain)
            ]
        written.append("" if value is None else f"{value:.1f}")
        assert unescape(text) in written, path
    changes = re.findall(r'data-from="([^"]+)" data-less="([^"]+)">([^<]*)<', page)
    assert len(changes) >= 30 and all(path.replace("/1/", "/0/") == first for path, first, _ in changes)
    for path, first, text in changes:
        change, (_, _, _, _, cls, _, key, _) = at(figures, path) - at(figures, first), path.split("/")
        written = [f"{abs(change):.0f}", f"{100 * abs(change):.1f} pp", f"{abs(change) / 1e3:,.2f}"]
        assert text[0] == ("−" if change < 0 else "+"), path
        known = figures["rigs"][1]["against"]["changes"].get(key, {}).get(cls)
        if known is not None and known["se"]:
            figure = next(one for one in registered() if one.key == key)
            assert unescape(text) == change_words(figure, estimate_of(known)) and "±" in text, path
        else:
            assert text[1:] in written, path
    for path, text in re.findall(r'data-verdict="([^"]+)/found">([^<]*)<', page):
        verdict = at(figures, path)
        assert text == amounts(verdict["found"], verdict["limit"], verdict["unit"])[0], path
    rig, scene = words[1], ("--boxes", boxes, *SMALL_GRID, "--body", "blocks", "--json", "-")
    scores = json.loads(riglens("evaluate", rig, words[2], *scene).out)
    counted = scores.pop("targets")
    for one in (*scores["rigs"], *figures["evaluation"]["rigs"]):
        one.pop("elapsed_ms")
        one.pop("figures")
    for one in (*counted["rigs"], *figures["targets"]["rigs"]):
        one.pop("elapsed_ms")
    assert differences(figures["evaluation"], scores) == differences(figures["targets"], counted) == []
    blind = riglens("review", rig, "--only", "blind", "--json", "-").part("blind")
    judged = [one for one in blind["profiles"] if not one["from_memory"]]
    assert (
        len(judged) < len(blind["profiles"])
        and "fmvss" not in re.sub("<script.*", "", page, flags=re.S).split("Left out")[0]
    )
    assert differences(figures["rigs"][0]["blind"], blind | {"profiles": judged}) == []
    audited = riglens("review", rig, "--only", "audit", *scene[:-4], "--json", "-").part("audit")
    assert differences(figures["rigs"][0]["audit"], audited) == []
    ranges = riglens("review", rig, "--only", "range", "--json", "-").part("range")
    assert differences(figures["rigs"][0]["range"], ranges) == []
    lost = riglens("review", rig, "--only", "redundancy", *scene).part("redundancy")
    assert differences(figures["rigs"][0]["redundancy"]["voxels"], lost["voxels"]) == []
    assert differences(figures["rigs"][0]["redundancy"]["objects"], lost["objects"]) == []
    assert not figures["rigs"][0]["check"]["passes"] and "NOT MET" in page


@pytest.fixture(scope="module")
def document(made):
    """The document of the report, with drawings that take no time."""
    rigs = tuple(load_rig(str(name), SILENT) for name in made[1][1:3])
    figures = attached_figures(made[0].read_bytes(), "report.html")
    return ReportDocument(figures, rigs, [drawn(rig) for rig in rigs])


def drawn(rig):
    """Drawings that take no time: one with a picture, and the outlines of the car."""
    drawing = Drawing(f"{rig.name}-a", 30.0, 20.0, "A drawing")
    drawing.image(DOT, 1.0, 1.0, 5.0, 5.0)
    drawing.circle((12.5, 10.0), 3.0, "#111111")
    return Drawings(None, drawing, drawing, None, drawing, car_shape(rig), {"rays": []})


def test_a_tuple_is_no_difference_from_the_list_that_json_makes_of_it() -> None:
    assert differences({"rays": [5760, 205200]}, {"rays": (5760, 205200)}) == []
    assert differences({"rays": [5760]}, {"rays": (5761,)}) == ["rays[0]: attached 5760, recomputed 5761"]


def test_verify_makes_a_report_again(made, riglens):
    out, _, boxes = made
    same = riglens("report", "--verify", out, "--boxes", boxes)
    assert same.code == 0 and "every figure is the same" in same.out, same.err
    said = riglens("report", "--verify", out)
    assert said.code == 2 and "--boxes must name boxes.csv" in said.err


@pytest.fixture
def made_again(monkeypatch, made, document):
    """What `verify` makes again comes at once: the figures of the report, and the drawings of the document."""
    monkeypatch.setattr(making, "report_of", lambda plan, *_: None)
    monkeypatch.setattr(making, "document_of", lambda plan, report: copy.deepcopy(document))
    return made[2]


EDITS = {
    "a digit of a cell": (r">(\d+\.\d+ %)</td>", ">0.01 %</td>", "0.01"),
    "a verdict": ("NOT MET", "met", ""),
    "a sentence": ("Rays are straight", "Rays are curved", "curved"),
    "a row": (r"<tr>((?!</tr>).)*>difference, ((?!</tr>).)*</tr>", "", ""),
    "a label of a drawing": (r">bicycle</text>", ">tricycle</text>", "tricycle"),
    "a caption": (r"<caption>[^<]*", "<caption>Another title", "Another title"),
    "the words for a picture": ("<title>Detection", "<title>Reflection", "Reflection"),
    "a picture": (re.escape(base64.b64encode(DOT).decode()), base64.b64encode(DARK).decode(), "picture"),
    "a drawing": (r'cx="[\d.]+"', 'cx="1.0"', ""),
    "a script": ("const canvas", "const kanvas", "kanvas"),
    "a row that is hidden": ("<tr>", "<tr hidden>", "hidden"),
    "a heading": ("<h1>", "<h2>", "<h2>"),
}


def edited(document, form, pattern, new):
    """The file of a report whose page was edited by hand; what is attached is that of the report."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(
            making, "report_page", lambda d: re.sub(pattern, new, report_page(d), count=1, flags=re.S)
        )
        return rendered(document, form)


@pytest.mark.parametrize("edit", EDITS)
def test_a_page_that_was_edited_by_hand_differs_and_the_place_is_named(
    made_again, document, riglens, tmp_path, edit
):
    pattern, new, said = EDITS[edit]
    page = tmp_path / "report.html"
    page.write_bytes(edited(document, ".html", pattern, new))
    found = riglens("report", "--verify", page, "--boxes", made_again)
    assert found.code == 1 and "every attached figure is the same" in found.out
    assert re.search(rf"first at line \d+: report has .*{said}", found.out), found.out


SHORT = (
    "<h1>A title</h1><p>Rays are straight.</p><div style='break-before: page'></div><table><caption>Lost</caption>"
    "<thead><tr><th>fails<th>share</thead><tr><th>one<td>12 %</tr><tr><th>two<td>34 %</tr></table>"
    f"<figure><img alt='A chart' src='data:image/png;base64,{base64.b64encode(DOT).decode()}'></figure>"
    "<figure><svg width='9' height='9' role='img'><title>A plan</title><circle cx='4' cy='4' r='3' fill='#111'/></svg>"
    "<figcaption>From above</figcaption></figure>"
)
"""The parts of a report on two pages, which are soon laid out."""


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ("straight", "curved", "page 1: report has Rays are curved., recomputed Rays are straight."),
        ("12 %", "13 %", "page 2: report has | one | 13 %, recomputed | one | 12 %"),
        ("<tr><th>two<td>34 %</tr>", "", "page 2: "),
        ("Lost", "Found", "page 2: report has Found, recomputed Lost"),
        ("A chart", "A photo", "A ?photo"),
        ("From above", "From below", "From below"),
        (base64.b64encode(DOT).decode(), base64.b64encode(DARK).decode(), "page 2: report has .*picture"),
        ("cx='4'", "cx='5'", "page 2: report has .*drawing"),
        ("#111", "#222", "page 2: report has .*drawing"),
        ("</figure>", "</figure><p>More</p>", "page 2: report has More"),
    ],
)
def test_a_pdf_of_a_page_that_was_edited_differs_and_its_page_is_named(old, new, said):
    one, other = (pdf_of(f"<html lang='en'><body>{body}", {}) for body in (SHORT, SHORT.replace(old, new, 1)))
    assert first_difference(one, one, "a.pdf") is None
    found = first_difference(other, one, "a.pdf")
    assert found is not None and re.search(said.replace("|", r"\|"), found), found


def test_an_attached_rig_that_was_edited_differs(made_again, document, riglens, tmp_path, qapp):
    figures = to_text(document.figures).encode()
    rigs = {f"rig{n}.yaml": text.encode() for n, text in enumerate(document.figures["inputs"]["rigs"], 1)}
    path = tmp_path / "a.pdf"
    path.write_bytes(pdf_of(report_page(document), {"figures.json": figures} | rigs | {"rig2.yaml": b"x"}))
    found = riglens("report", "--verify", path, "--boxes", made_again)
    assert found.code == 1 and "first at attachments: report has [rig2.yaml" in found.out


PACKED = {
    "other breaks of pages and lines": (".pdf", "size: A4;", "size: A4 landscape;"),
    "white space": (".html", "<tr>", "\n  <tr>\n"),
    "a picture packed in another way": (
        ".html",
        re.escape(base64.b64encode(DOT).decode()),
        base64.b64encode(LOOSE).decode(),
    ),
}


@pytest.mark.parametrize("how", PACKED)
def test_a_report_that_another_version_of_a_library_writes_says_the_same(
    made_again, document, riglens, tmp_path, qapp, how
):
    form, *edit = PACKED[how]
    path = tmp_path / f"a{form}"
    path.write_bytes(edited(document, form, *edit))
    assert path.read_bytes() != rendered(document, form)
    found = riglens("report", "--verify", path, "--boxes", made_again)
    assert found.code == 0, found.out


def test_a_figure_that_was_edited_is_named_by_its_path_whatever_the_file(
    made_again, document, riglens, tmp_path, qapp
):
    figures = copy.deepcopy(document.figures)
    figures["rigs"][0]["blind"]["zones"][0]["share_seen_10m"] = 0.123
    edited = ReportDocument(figures, document.rigs, document.drawings)
    for form in (".html", ".pdf", ".json"):
        path = tmp_path / f"changed{form}"
        path.write_bytes(rendered(document, form))
        assert riglens("report", "--verify", path, "--boxes", made_again).code == 0
        path.write_bytes(rendered(edited, form))
        other = riglens("report", "--verify", path, "--boxes", made_again)
        assert other.code == 1 and "rigs[0].blind.zones[0].share_seen_10m: attached 0.123" in other.out


def test_a_forged_name_of_the_data_differs(made_again, document, riglens, tmp_path):
    figures = copy.deepcopy(document.figures)
    figures["inputs"]["boxes"] = "measured.csv"
    for part in ("evaluation", "targets"):
        assert figures[part]["data"]["source"] == "boxes.csv"
        figures[part]["data"]["source"] = "measured.csv"
    path = tmp_path / "forged.html"
    path.write_bytes(rendered(ReportDocument(figures, document.rigs, document.drawings), ".html"))
    found = riglens("report", "--verify", path, "--boxes", made_again)
    assert found.code == 1 and "inputs.boxes: attached 'measured.csv', recomputed 'boxes.csv'" in found.out


def test_verify_says_what_it_takes_as_given(made_again, document, riglens, tmp_path, monkeypatch):
    figures = copy.deepcopy(document.figures)
    labels = Labels(project="Van")
    figures["inputs"]["labels"] = labels.model_dump()
    labelled = ReportDocument(figures, document.rigs, document.drawings, labels.words)
    monkeypatch.setattr(making, "document_of", lambda plan, report: copy.deepcopy(labelled))
    path = tmp_path / "a.html"
    path.write_bytes(rendered(labelled, ".html"))
    found = riglens("report", "--verify", path, "--boxes", made_again)
    assert found.code == 0 and "taken as given" in found.out and "Project: Van" in found.out


def test_rigs_of_one_name_are_told_apart(document):
    rigs = tuple(rig.model_copy(update={"name": "twin"}) for rig in document.rigs)
    figures = copy.deepcopy(document.figures)
    twins = ReportDocument(figures, rigs, document.drawings)
    assert len(set(twins.names)) == 2
    page = re.sub("<script.*?</script>", "", report_page(twins), flags=re.S)
    for name in twins.names:
        assert f"<h2>{name}: details</h2>" in page and page.count(name) > 10
    assert not re.search(r"twin(?! \()", page)


def test_the_page_says_in_which_settings_requirements_hold(made):
    page = made[0].read_text("utf-8").split('<script type="application/json"')[0]
    (said,) = re.findall(r"Requirements hold for ([^<]*)<", page)
    assert all(word in said for word in ("0.5 m", "20 × 20 × 4 m", "boxes.csv", "seed 0"))


def test_a_damaged_pdf_is_refused_in_one_line(made_again, document, riglens, tmp_path, qapp):
    path = tmp_path / "a.pdf"
    path.write_bytes(pdf_with(zlib.compress(to_text(document.figures).encode())))
    assert "a.pdf: damaged PDF" in riglens("report", "--verify", path, "--boxes", made_again).refused()


WRONG = {
    "inputs": [None, 7, []],
    "rigs": [None, [], [3], {"a": 1}, "x", ["name: \ud800"]],
    "voxel_m": ["0.5", None, -1.0, True],
    "roi_m": [[1.0], "abc", [1.0, 2.0, None], [[], [], []], {}],
    "method": ["magic", 1],
    "reading": [[], None],
    "lambda": ["x", -1.0],
    "body": [3, "glass", "\ud800"],
    "\ud800": [1],
    "draws": [1.5, -1, 10**30, True, "2"],
    "seed": [None, -1, 1 << 63],
    "boxes": [[], {"a": 1}],
    "why": [1, {**WHY, "checks": [{}]}],
    "requirements": [1, [], "riglens_requirements: 1\nnames: \ud800"],
}


@pytest.mark.parametrize("key", WRONG)
def test_odd_values_among_the_inputs_of_a_report_are_refused_in_one_line(
    made, document, riglens, tmp_path, key
):
    for value in WRONG[key]:
        figures = copy.deepcopy(document.figures)
        (figures if key == "inputs" else figures["inputs"])[key] = value
        path = tmp_path / "odd.json"
        path.write_text(json.dumps(figures), encoding="utf-8")
        said = riglens("report", "--verify", path, "--boxes", made[2]).refused()
        assert "odd.json:" in said or key in ("voxel_m", "roi_m", "lambda"), (value, said)


def test_odd_figures_beside_the_inputs_are_differences(made_again, document, riglens, tmp_path):
    path = tmp_path / "odd.json"
    for part, value in (
        ("evaluation", 3),
        ("targets", [[]]),
        ("rigs", {"a": None}),
        ("version", [[[[[[]]]]]]),
    ):
        path.write_text(json.dumps({**document.figures, part: value}), encoding="utf-8")
        found = riglens("report", "--verify", path, "--boxes", made_again)
        assert found.code == 1 and f"{part}" in found.out and "differs" in found.out


def test_verify_reads_the_tables_of_rays_beside_a_page(made, riglens, tmp_path):
    there, here = tmp_path / "there", tmp_path / "here"
    (there / "rays").mkdir(parents=True), here.mkdir()
    rows = "".join(f"{azimuth},{elevation}\n" for azimuth in range(-40, 41, 8) for elevation in (-12, -4))
    (there / "rays" / "a.csv").write_text("azimuth_deg,elevation_deg\n" + rows, encoding="utf-8")
    (there / "rig.yaml").write_text(
        "riglens: 1\nname: table\nsensors:\n"
        "  - {name: front, kind: lidar, position: [1.5, 0, 1.6], rays: {file: rays/a.csv}}\n",
        encoding="utf-8",
    )
    arguments, page = ("--boxes", made[2], *SMALL_GRID, "--draws", "2"), there / "a.html"
    found = riglens("report", there / "rig.yaml", *arguments, "--out", page)
    assert found.code == 0, found.err
    same = riglens("report", "--verify", page, "--boxes", made[2])
    assert same.code == 0 and "every figure is the same" in same.out, same.err
    moved = here / "a.html"
    moved.write_bytes(page.read_bytes().replace(b"rays/a.csv", str(there / "rays" / "a.csv").encode()))
    said = riglens("report", "--verify", moved, "--boxes", made[2]).refused()
    assert "cannot be read (No such file" in said


@pytest.mark.parametrize("named", ["{there}/car.stl", "../there/car.stl", "~/car.stl"])
def test_verify_reads_no_mesh_outside_the_folder_of_a_page(
    made, document, riglens, tmp_path, named, monkeypatch
):
    there, here = tmp_path / "there", tmp_path / "here"
    there.mkdir(), here.mkdir()
    (there / "car.stl").write_text("not a mesh", encoding="utf-8")
    monkeypatch.setenv("HOME", str(there))
    figures = copy.deepcopy(document.figures)
    rig = figures["inputs"]["rigs"][1]
    figures["inputs"]["rigs"][1] = re.sub(r"body: sedan", f"body: {named.format(there=there)}", rig)
    assert figures["inputs"]["rigs"][1] != rig
    (here / "a.json").write_text(json.dumps(figures), encoding="utf-8")
    said = riglens("report", "--verify", here / "a.json", "--boxes", made[2]).refused()
    assert f"{here / 'car.stl'}: no such file; name the folder" in said
    asked = riglens("report", "--verify", here / "a.json", "--boxes", made[2], "--meshes", there).refused()
    assert "no such file" not in asked and str(there / "car.stl") in asked


HOSTILE = "<script>alert(1)</script>\"'>&{{ 7*7 }}{% x %}\ud800\u202e\x1b[31m\n<b>"


def test_hostile_names_are_text_wherever_they_stand(document):
    def renamed(value):
        if isinstance(value, dict):
            return {key: HOSTILE if key in NAMED else renamed(one) for key, one in value.items()}
        return [renamed(one) for one in value] if isinstance(value, list) else value

    figures = renamed(document.figures)
    figures["evaluation"]["data"]["notes"] = [HOSTILE]
    figures["inputs"] |= {"boxes": HOSTILE, "requirements": "riglens_requirements: 1"}
    rigs = tuple(
        rig.model_copy(
            update={
                "name": HOSTILE,
                "sensors": tuple(
                    sensor.model_copy(update={"name": HOSTILE, "model": HOSTILE, "fails_with": (HOSTILE,)})
                    for sensor in rig.sensors
                ),
            }
        )
        for rig in document.rigs
    )
    drawings = [replace(one, view={"name": HOSTILE}) for one in document.drawings]
    hostile = ReportDocument(figures, rigs, drawings)
    for shown in (report_page(hostile),):
        shown.encode("utf-8")
        assert (
            "<script>alert" not in shown
            and "<b>" not in shown
            and "\u202e" not in shown
            and "\x1b" not in shown
        )
        assert "&lt;script&gt;alert(1)&lt;/script&gt;&#34;&#39;&gt;&amp;{{ 7*7 }}" in shown
        assert "\\ud800" in shown and "\"'>" not in shown
    scripts = re.findall(
        r'<script type="application/json" id="figures">(.*?)</script>', report_page(hostile), re.S
    )
    assert json.loads(scripts[0]) == figures


NAMED = ("name", "title", "text", "source", "note", "unit", "relation", "sha256", "version")


def test_the_same_as_a_pdf_holds_figures_and_rigs_and_is_the_same_twice(document, monkeypatch):
    first = rendered(document, ".pdf")
    monkeypatch.setenv("TZ", "Asia/Kolkata")
    assert first[:5] == b"%PDF-" and first == rendered(document, ".pdf")
    assert attached_figures(first, "a.pdf") == document.figures
    with PdfDocument(first) as read:
        files = [read.get_attachment(number) for number in range(read.count_attachments())]
        assert [one.get_name() for one in files] == ["figures.json", "rig1.yaml", "rig2.yaml"]
        assert [bytes(one.get_data()).decode() for one in files[1:]] == document.figures["inputs"]["rigs"]
        assert len(read) >= 3 and read.is_tagged() and read.get_metadata_dict()["CreationDate"] == ""


def test_a_pdf_is_the_same_from_process_to_process(tmp_path):
    program = (
        "import hashlib; from riglens.reporting.pdf import pdf_of; "
        "text = '<p>a <b>b</b> <i>c</i> <code>d</code></p><table><tr><td>e</td></tr></table>' * 3; "
        "text = '<html lang=en><title>a</title>' + text; "
        "print(hashlib.sha256(pdf_of(text, {'a.json': b'{}'})).hexdigest())"
    )
    found = {
        subprocess.run(
            [sys.executable, "-c", program],
            check=True, capture_output=True, env=os.environ | {"PYTHONHASHSEED": seed},
        ).stdout
        for seed in ("1", "2")
    }  # fmt: skip
    assert len(found) == 1


def tagged(pdf):
    """The tags of a PDF in their order: kind and alternative text of each."""
    found = []

    def collect(element):
        length = raw.FPDF_StructElement_GetType(element, None, 0)
        buffer = ctypes.create_string_buffer(length)
        raw.FPDF_StructElement_GetType(element, buffer, length)
        kind = buffer.raw.decode("utf-16-le").rstrip("\0")
        length = raw.FPDF_StructElement_GetAltText(element, None, 0)
        buffer = ctypes.create_string_buffer(length)
        raw.FPDF_StructElement_GetAltText(element, buffer, length)
        found.append((kind, buffer.raw.decode("utf-16-le").rstrip("\0")))
        for number in range(raw.FPDF_StructElement_CountChildren(element)):
            child = raw.FPDF_StructElement_GetChildAtIndex(element, number)
            if child:
                collect(child)

    with PdfDocument(pdf) as read:
        for page in read:
            tree = raw.FPDF_StructTree_GetForPage(page)
            for number in range(raw.FPDF_StructTree_CountChildren(tree)):
                collect(raw.FPDF_StructTree_GetChildAtIndex(tree, number))
            raw.FPDF_StructTree_Close(tree)
    return found


def test_a_pdf_has_tags_for_headings_tables_and_pictures_with_words_for_each(document):
    page, tags = report_page(document), tagged(rendered(document, ".pdf"))
    kinds = [kind for kind, _ in tags]
    shown = page.split('<script type="application/json" id="figures">')[0]
    for tag, kind in (("h1", "H1"), ("h2", "H2"), ("h3", "H3")):
        assert kinds.count(kind) == len(re.findall(rf"<{tag}[ >]", shown)) > 0, kind
    assert kinds.count("TH") >= len(re.findall(r"<th [^>]*>[^<]", shown)) > 100  # empty ones are in no page
    assert kinds.count("Table") >= shown.count("<table") > 20
    pictures = {unescape(alt) for alt in re.findall(r'alt="([^"]+)"', shown)} | {
        unescape(alt) for alt in re.findall(r"role=\"img\"[^>]*>\s*<title>([^<]+)</title>", shown)
    }
    assert len(pictures) > 10 and {alt for kind, alt in tags if kind == "Figure"} == pictures


def test_a_pdf_reads_no_file_and_no_address_that_a_page_names(tmp_path):
    (tmp_path / "secret.css").write_text("p { color: red; font-size: 90px }", encoding="utf-8")
    plain_page = "<html lang=en><title>a</title>%s<p>b</p>"
    named = f'<link rel="stylesheet" href="{(tmp_path / "secret.css").as_uri()}">'
    assert pdf_of(plain_page % named, {}) == pdf_of(plain_page % "", {})


def test_page_one_names_the_worst_of_each_kind_and_what_is_missed(document):
    page = report_page(document)
    order = ("Four figures", "The three worst", "Blind zones", "Limits", "Figures by class")
    assert sorted(order, key=page.index) == list(order)
    for rig in document.figures["rigs"]:
        lost = [
            one["lost"][name]
            for one in rig["redundancy"]["objects"]["failures"]
            if one["what"] in ("sensor", "group")
            for name in CLASSES
        ]
        assert at(rig, worst_failure(rig).path) == max(lost) > 0.0
        rows = rig["range"]["rigs"][0]["rows"]
        far = [max(row[k]["first_below_m"]["min"] or 0.0 for k in ("lidar", "camera")) for row in rows]
        assert None not in [row[k]["first_below_m"]["min"] for row in rows for k in ("lidar", "camera")]
        assert at(rig, smallest_range(rig).path)["min"] == min(far)
        missed = [
            (profile["name"], one["name"])
            for profile in rig["blind"]["profiles"]
            for one in profile["objects"]
            if not one["seen"]
        ]
        assert [(one.profile["name"], one.object["name"]) for one in missed_objects(rig)] == missed != []
        shares = {
            place: profile["seen"] / len(profile["objects"])
            for place, profile in enumerate(rig["blind"]["profiles"])
            if profile["for_this_vehicle"]
        }
        assert len(shares) < len(rig["blind"]["profiles"])
        found = worst_profile(rig)
        assert shares[int(found.path.split("/")[2])] == min(shares.values()) < 1.0
        assert found.path.startswith("blind/profiles")
        if rig is document.figures["rigs"][-1]:  # the first one is what it is compared with
            assert found.words in unescape(page) and found.title in unescape(page)
        seen = copy.deepcopy(rig)
        for profile in seen["blind"]["profiles"]:
            profile["passes"] = True
        assert worst_profile(seen) is None


def test_a_group_that_fails_is_a_single_failure(document):
    rig = copy.deepcopy(document.figures["rigs"][0])
    failures = rig["redundancy"]["objects"]["failures"]
    group = next(one for one in failures if one["what"] == "group")
    group["lost"]["bicycle"] = 1.5  # more than any sensor
    found = worst_failure(rig)
    assert at(rig, found.path) == 1.5 and found.title == "bracket fails"


def test_a_class_without_objects_has_no_figures_and_is_named(document):
    figures = copy.deepcopy(document.figures)
    assert "The data have no" not in report_page(document)
    assert 'data-from="evaluation/rigs/0/classes/pedestrian' in report_page(document)
    for rig in figures["evaluation"]["rigs"]:
        rig["classes"]["pedestrian"]["h_total"] = 0.0
    for rig in figures["targets"]["rigs"]:
        rig["classes"]["pedestrian"]["objects"] = 0
    absent = ReportDocument(figures, document.rigs, document.drawings)
    for page in (report_page(absent),):
        shown = page.split("<script")[0]
        assert "The data have no pedestrian." in shown
        assert not re.search(r"(lost: |first, |second, |target, )pedestrian", shown)
        assert not re.search(r'data-from="(evaluation|targets)[^"]*pedestrian', shown)


def object_cells(page, cls):
    """The table of objects: titles of the columns, and the cells of each row of a class by title."""
    (table,) = re.findall(r"<h3>Objects</h3>.*?</table>", page.replace("\u00a0", " "), re.S)
    head, *rows = (re.findall(r"<t[hd][^>]*>([^<]*)</t[hd]>", row) for row in table.split("<tr>")[1:])
    return head[1:], [dict(zip(head[1:], row[1:], strict=True)) for row in rows if row[0].endswith(cls)]


@pytest.mark.parametrize("is_reversed", [False, True])
def test_the_table_of_objects_has_the_columns_of_all_rigs_and_dashes_where_one_has_no_such_sensor(
    document, is_reversed
):
    figures, rigs = copy.deepcopy(document.figures), list(document.rigs)
    if is_reversed:
        rigs.reverse()
        for listed in (figures["rigs"], figures["evaluation"]["rigs"], figures["targets"]["rigs"]):
            listed.reverse()
    titles, rows = object_cells(report_page(ReportDocument(figures, rigs, document.drawings)), "car")
    titles = [title.removesuffix(", %") for title in titles]
    assert titles.index("Median height, px") < titles.index("By radars") < titles.index("By two kinds")
    with_radar, without = rows[1::-1] if is_reversed else rows[:2]
    share = figures["targets"]["rigs"][is_reversed]["classes"]["car"]["radar"]["share"]
    assert with_radar["By radars, %"] == f"{100 * share:.1f}"
    assert without["By radars, %"] == rows[2]["By radars, %"] == "—" != rows[2]["By two kinds, %"]


def test_a_rig_of_cameras_has_dashes_for_points(document):
    figures, reason = copy.deepcopy(document.figures), "the rig has no enabled LiDAR"
    made_by_lidars = [one.key for one in object_figures() if "lidar" in one.kinds]
    for found in figures["evaluation"]["rigs"][1]["classes"].values():
        for key in made_by_lidars:
            found["figures"][key] = {"value": None, "se": 0.0, "state": "none", "reason": reason}
    page = report_page(ReportDocument(figures, document.rigs, document.drawings))
    _, (before, after, change) = object_cells(page, "car")
    for title in ("At least 1 point, %", "Median points"):
        assert after[title] == change[title] == "—" != before[title], title
    assert "—" not in (after["Median height, px"], change["Median height, px"])
    assert f'title="{reason}"' in page
    assert not re.search(r'data-from="targets/rigs/1/classes/car/sectors/\d/(share_5|predicted)', page)


@pytest.mark.parametrize("figure", ["predicted", "found"])
def test_a_prediction_outside_its_domain_stands_in_brackets(document, figure):
    figures = copy.deepcopy(document.figures)
    for rig, written in zip(figures["targets"]["rigs"], figures["evaluation"]["rigs"], strict=True):
        rig["found_outside"] = ""
        for of_class in written["classes"].values():
            of_class["figures"][figure]["state"] = "sampled"
    own = figures["evaluation"]["rigs"][0]["classes"]["car"]["figures"][figure]
    cell = f'<td data-from="evaluation/rigs/%d/classes/car/figures/{figure}">%s<'
    written = [rig["classes"]["car"]["figures"][figure] for rig in figures["evaluation"]["rigs"]]
    words = [f"{100 * one['value']:.1f} ±{200 * one['se']:.1f}" for one in written]
    page = report_page(ReportDocument(figures, document.rigs, document.drawings))
    assert cell % (0, words[0]) in page and "within 30 m" in page, "the domain stands beside it"
    figures["targets"]["rigs"][0][f"{figure}_outside"], own["state"] = "too many rays", "outside"
    page = report_page(ReportDocument(figures, document.rigs, document.drawings))
    assert cell % (0, f"({words[0]})") in page
    assert cell % (1, words[1]) in page, "the other is within its domain"
    assert "is outside its domain, therefore in brackets: too many rays." in page


def test_verdicts_have_the_digits_that_decide_and_waivers_that_do_not_count():
    verdict = {"found": 0.86479, "limit": 0.8648, "unit": "share", "status": "not met", "passes": False}
    assert limit_texts(verdict) == ("86.479 %", "86.480 %")
    assert verdict_text(verdict | {"waived": None}) == "NOT MET"
    waived = verdict_text(verdict | {"waived": {"until": "2027-03-31", "reason": "a", "counts": False}})
    assert waived == "NOT MET; waiver until 2027-03-31 not counted"
    allowed = verdict | {"found": None, "status": "not applicable", "passes": True, "waived": None}
    assert verdict_text(allowed) == "not applicable, allowed" and limit_texts(allowed)[0] == "—"
    assert few_words(["a", "b", "c"]) == "a; b; c" and few_words(list("abcd")) == "a; b; 2 more"


def test_labels_stand_in_the_header_of_every_page_and_are_verified(
    made_again, document, riglens, tmp_path, qapp
):
    figures = copy.deepcopy(document.figures)
    labels = Labels(project="Van", revision="B", author="<A>")
    figures["inputs"]["labels"] = labels.model_dump()
    labelled = ReportDocument(figures, document.rigs, document.drawings, labels.words)
    assert "Project: Van · Revision: B · Author: &lt;A&gt;" in report_page(labelled)
    with PdfDocument(rendered(labelled, ".pdf")) as read:
        for number, page in enumerate(read, 1):
            words, wide = page.get_textpage(), page.get_width()
            below = words.get_text_bounded(top=42.0)  # in the margin of 15 mm
            assert "Project: Van · Revision: B · Author: <A>" in below and "second" in below
            assert f"{number} / {len(read)}" in words.get_text_bounded(top=42.0, left=wide / 2)
    path = tmp_path / "a.html"
    path.write_bytes(rendered(labelled, ".html"))
    found = riglens("report", "--verify", path, "--boxes", made_again)
    assert found.code == 1 and "inputs.labels.project: attached 'Van'" in found.out
    said = riglens("report", "Center", "--out", tmp_path / "b.html", "--author", "a" * 201).refused()
    assert "--author must have at most 200 characters (got 201)" in said


def test_why_sensors_are_where_they_are_is_said_as_the_search_found_it(document):
    figures = copy.deepcopy(document.figures)
    assert "Why here" not in report_page(document) and "why" not in figures["inputs"]
    figures["inputs"]["why"] = WHY
    page = report_page(ReportDocument(figures, document.rigs, document.drawings))
    assert "left &lt;b&gt;, right: " in page and WHY["sentence"] in page
    cells = dict(re.findall(r'data-from="(inputs/why[^"]+)">([^<]*)<', page))
    assert cells == {
        f"inputs/why/checks/0/{name}": text
        for name, text in (("gain", "3.88"), ("se", "0.09"), ("share", "92.0 %"))
    }
    kept = inputs_of(figures, "a").why
    assert kept is not None and kept.model_dump() == WHY


def test_the_outline_of_a_car_is_its_silhouette():
    rig = preset("nuScenes car")
    beside = np.array(re.findall(r"(-?[\d.]+),(-?[\d.]+)", car_shape(rig).beside), float)
    hull = ConvexHull(beside)
    area = 0.5 * abs(
        np.dot(beside[:, 0], np.roll(beside[:, 1], 1)) - np.dot(beside[:, 1], np.roll(beside[:, 0], 1))
    )
    assert 0.6 * hull.volume < area < 0.95 * hull.volume  # a hood and wheels, no bag around the car
    assert np.ptp(beside[:, 0]) == pytest.approx(rig.vehicle.length * 62.0, rel=0.02)


TABLE = "<div class='wide %s'><table><caption>Lost</caption><thead><tr><th>fails<th>pair</tr></thead>%s</table></div>"
ROW = "<tr><th scope='row'>pedestrian</th><td class='left short'>one + other</td></tr>"


def pages_of(document, body):
    """The words of each page of a report whose body is replaced."""
    page = report_page(document)
    page = page[: page.index("<body>")] + f"<body><h1>A title</h1>{body}</body></html>"
    with PdfDocument(pdf_of(page, {})) as read:
        return [page.get_textpage().get_text_range() for page in read]


@pytest.mark.parametrize("lines", range(26, 50, 4))
def test_a_heading_is_never_left_alone_and_a_small_table_never_cut_where_a_pdf_is_printed(document, lines):
    body = (
        "<p>line</p>" * lines + "<h3>Redundancy</h3><p class='quiet'>A remark.</p>" + TABLE % ("few", ROW * 9)
    )
    (found,) = (page for page in pages_of(document, body) if "Redundancy" in page)
    assert "A remark." in found and found.count("one + other") == 9


def test_what_follows_the_pages_of_a_rig_shares_the_last_of_them(document):
    section = "<section class='page'><h2>%s</h2></section>"
    found = pages_of(document, section % "first" + section % "second" + "<h2>Glossary</h2>")
    assert ["first" in page for page in found] == [True, False]
    assert ["second" in page and "Glossary" in page for page in found] == [False, True]


def test_page_one_says_which_rays_pass_through_the_body_and_nothing_where_none_does(document):
    figures = copy.deepcopy(document.figures)
    of_rigs = figures["evaluation"]["rigs"]
    for bodies, said in ((("blocks", "blocks"), False), (("blocks", "ignored"), True)):
        for rig, body in zip(of_rigs, bodies, strict=True):
            rig["body"] = body
        figures["evaluation"]["body"] = "blocks" if len(set(bodies)) == 1 else None
        page = report_page(ReportDocument(figures, document.rigs, document.drawings))
        front = page[: page.index("<h2>")]
        assert ("ignored for second" in front) == said and ("Body" in front) == said


def test_names_of_columns_are_repeated_on_each_page_of_a_long_table(document):
    found = pages_of(document, TABLE % ("", ROW * 150))
    assert len(found) >= 3 and sum(page.count("one + other") for page in found) == 150
    assert all("fails" in page and "pair" in page for page in found)


def test_on_a_phone_the_verdicts_of_two_rigs_are_within_the_screen(document):
    figures = copy.deepcopy(document.figures)
    names = [rig.name for rig in document.rigs]
    for number, rig in enumerate(figures["rigs"]):
        (verdict,) = rig["check"]["verdicts"]
        verdict["details"] = [f"a line of many words about what is missed {number}, to its end {number}"]
    page = report_page(ReportDocument(figures, document.rigs, document.drawings))
    page = page.replace("@media screen and (max-width: 640px)", "@media all").replace(
        "@media print", "@media tty"
    )
    start = page.index('<div class="wide', page.index("<h2>Requirements"))
    page = page[: page.index("<body>")] + "<body><h1>A title</h1>" + page[start : page.index("<h2>Glossary")]
    page = page.replace("@page {", "@page { size: 400px 3000px !important;")
    with PdfDocument(pdf_of(page, {})) as read:
        assert len(read) == 1 and read[0].get_size()[0] == pytest.approx(300.0)
        shown = " ".join(read[0].get_textpage().get_text_bounded(right=300.0).split())
    for number, name in enumerate(names):
        assert f"to its end {number}" in shown and shown.count(f"{visible(name)}:") == 1, name
    assert shown.count("NOT MET") == 2 and shown.count("limit: at most 0") == 1


def test_origins_of_models_are_told_in_one_line():
    assert "unverified" in origin("waymo-top") and "\n" not in origin("waymo-top")


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (("Center",), "name rigs and --out"),
        (("--out", "a.html"), "no rig named"),
        (("Center", "--out", "a.docx"), "--out must end in .html or .pdf"),
        (("Center", "--out", "a.html", "--draws", "-1"), "--draws must be an integer from 0 to"),
        (("--verify", "missing.html"), "cannot be read"),
        (("Center", "--out", "a.html", "--meshes", "there"), "--meshes applies to an earlier page only"),
        (("Center", "--verify", "a.html"), "--verify brings its own"),
    ],
)
def test_bad_input_is_told_in_one_line(riglens, arguments, said):
    assert said in riglens("report", *arguments).refused()


@pytest.mark.parametrize(
    ("profile", "said"),
    [("fmvss-111-near", "is from memory and not used in reports"), ("un-r999", "'un-r999' is unknown")],
)
def test_names_in_requirements_are_checked_before_any_work(riglens, tmp_path, monkeypatch, profile, said):
    monkeypatch.setattr(making, "report_of", None)
    path = tmp_path / "required.yaml"
    path.write_text(f"riglens_requirements: 1\nblind_objects: [{{profile: {profile}}}]\n", encoding="utf-8")
    out = riglens("report", "Center", "--requirements", path, "--out", tmp_path / "a.html").refused()
    assert "required.yaml" in out and said in out


def test_a_pdf_without_its_system_libraries_is_refused_before_any_work(riglens, tmp_path, monkeypatch, made):
    monkeypatch.setattr(making, "report_of", None)
    out = tmp_path / "a.pdf"
    with monkeypatch.context() as elsewhere:  # no Debian packages, and Pango missing
        elsewhere.delitem(sys.modules, "riglens.reporting.pdf")
        elsewhere.setattr(sys, "meta_path", [NoPango(), *sys.meta_path])
        assert "a PDF needs the library Pango" in riglens("report", "Center", "--out", out).refused()
    absent = Requirement("libabsent7", soname="libabsent.so.7")
    monkeypatch.setitem(system_libraries._REQUIREMENTS, "pdf", (absent,))
    assert "apt-get install -y libabsent7" in riglens("report", "Center", "--out", out).refused()
    path = tmp_path / "old.pdf"
    path.write_bytes(pdf_with(zlib.compress(to_text(attached_figures(made[0].read_bytes(), "a")).encode())))
    assert "libabsent7" in riglens("report", "--verify", path, "--boxes", made[2]).refused()


class NoPango:
    """Finds no library below what lays out a PDF."""

    def find_spec(self, name, path=None, target=None):
        if name == "riglens.reporting.pdf":
            raise OSError("cannot load library 'libpango-1.0'")


def test_only_a_pdf_loads_what_lays_it_out():
    program = (
        "import sys, riglens.app.commands.report, riglens.app.commands.parsing, riglens.app.window; "
        "sys.exit(bool({'weasyprint', 'pypdfium2', 'riglens.reporting.pdf'} & set(sys.modules)))"
    )
    subprocess.run([sys.executable, "-c", program], check=True)


@pytest.mark.parametrize("text", ["", "<html>", '<script type="application/json" id="figures">{', "{}"])
def test_what_is_no_report_is_refused(riglens, tmp_path, text):
    path = tmp_path / "a.html"
    path.write_text(
        text if text != "{}" else '<script type="application/json" id="figures">{}</script>', encoding="utf-8"
    )
    assert "a.html: " in riglens("report", "--verify", path).refused()


def pdf_with(stream: bytes) -> bytes:
    """As much of a PDF with an attachment as is read."""
    return (
        b"%PDF-1.4\n6 0 obj\n<<>>\nstream\nno stream of zlib\n7 0 obj\n<<>>\nstream\r\n"
        + stream
        + b"\nendstream"
    )


def test_figures_in_a_pdf_that_is_wrong_are_told_and_no_bomb_is_unpacked(monkeypatch):
    figures = to_text({"riglens_report": 1, "many": list(range(1000))})
    good = zlib.compress(figures.encode())
    assert figures_in_pdf(pdf_with(good), "a.pdf") == figures
    wrong = {
        "no attached figures.json": (b"", b"no zlib", zlib.compress(b"{}")),
        "are damaged": (good[: len(good) // 2], good[:100] + b"\0" * 9 + good[109:]),
    }
    for said, streams in wrong.items():
        for stream in streams:
            with pytest.raises(InputError, match=f"^a.pdf: .*({said}|no attached)"):
                attached_figures(pdf_with(stream), "a.pdf")
    monkeypatch.setattr(report_reading, "MAX_FIGURES_BYTES", 1000)
    with pytest.raises(InputError, match=r"larger than 0\.001 MB"):
        figures_in_pdf(pdf_with(good), "a.pdf")


@pytest.mark.parametrize("name", ["nuScenes car", "production car", "W+T"])
def test_numbers_beside_sensors_do_not_meet_and_stay_within_the_drawing(name):
    dots = [(30.0 - 12.0 * y, 35.0 - 12.0 * x) for x, y, _ in (one.position for one in preset(name).sensors)]
    found = apart(dots, (60.0, 70.0), 2.0, 6.0)
    assert all(2.0 <= x <= 58.0 and 2.0 <= y <= 68.0 for x, y in found)
    away = [math.dist(one, other) for n, one in enumerate(found) for other in found[:n]]
    assert len(found) == len(dots) and min(away) > 3.9


@pytest.mark.parametrize(
    ("count", "rest"), [(report_command.SHOWN, ""), (report_command.SHOWN + 3, "and 3 more")]
)
def test_of_many_differences_the_first_are_named_and_the_others_counted(riglens, monkeypatch, count, rest):
    lines = [f"line {number}" for number in range(count)]
    monkeypatch.setattr(report_command, "verified", lambda *_: making.Verified(lines, None))
    out = riglens("report", "--verify", "old.html").out
    assert "line 19" in out and "line 20" not in out
    assert rest in out and ("more" in out) == bool(rest)


def test_pictures_by_another_driver_look_alike_and_those_with_a_sensor_elsewhere_do_not():
    rng = np.random.default_rng(3)
    pixels = np.full((160, 240, 4), 255, np.uint8)
    pixels[40:120, 60:180, :3] = rng.integers(60, 200, (80, 120, 3))
    pixels[60:72, 100:112, :3] = (255, 120, 0)
    noisy, moved = pixels.copy(), pixels.copy()
    noisy[..., :3] = np.clip(
        pixels[..., :3].astype(int) + rng.integers(-20, 21, pixels[..., :3].shape), 0, 255
    )
    moved[60:72, 100:112], moved[60:72, 106:118] = pixels[60:72, 112:124], pixels[60:72, 100:112]
    one, driver, elsewhere = map(Image.fromarray, (pixels, noisy, moved))
    assert look_alike(driver, one) and not look_alike(elsewhere, one)
    assert not look_alike(one.resize((120, 80)), one)
    few = Image.fromarray(np.kron(rng.integers(0, 2, (20, 30), np.uint8) * 9, np.ones((8, 8), np.uint8)))
    assert not look_alike(few, few.copy()), "maps of few colours have to be equal"


def test_no_folder_of_this_machine_is_in_a_report(made, document, tmp_path):
    (tmp_path / "car.stl").write_text("solid a", encoding="utf-8")
    rig = document.rigs[0]
    vehicle = rig.vehicle.model_copy(update={"body": str(tmp_path / "car.stl")})
    (other,) = portable([rig.model_copy(update={"vehicle": vehicle})])
    assert other.vehicle.body == "car.stl" and portable(document.rigs) == document.rigs
    assert str(made[0].parent) not in made[0].read_text("utf-8")
    assert numbered(["a", "a", "b"], ["x.yaml", "y.yaml", "b"]) == ("a (x.yaml)", "a (y.yaml)", "b")
    assert numbered(["a", "a"], ["x.yaml", "x.yaml"]) == ("a (x.yaml) (1)", "a (x.yaml) (2)")
