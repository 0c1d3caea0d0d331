"""What `riglens report` does: make all figures and write the page; or make those of a page again and compare."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any, NamedTuple

from riglens.app.commands.scores_job import missing_rays
from riglens.app.evaluation.options import SceneOptions, ScoreOptions
from riglens.app.launch.system_libraries import require_system_libraries
from riglens.app.studies.files import write_text
from riglens.app.studies.report_figures import ReportPlan, differences, report_of
from riglens.app.studies.report_page import attached_figures, report_page
from riglens.app.studies.report_pdf import FIGURES_NAME, figures_in_pdf, is_pdf
from riglens.app.terminal.console import note, progress_bar, results
from riglens.app.terminal.scores import mesh_called, rig_called
from riglens.core.engine.evaluation_json import to_text
from riglens.core.errors import InputError
from riglens.core.files import atomic_write, open_regular, require_writable
from riglens.core.review.requirements import Requirements, requirements_in
from riglens.core.review.tolerance import MAX_DRAWS
from riglens.core.rig.yaml.file import loads
from riglens.core.rig.yaml.nodes import read_text
from riglens.core.shown_text import visible

MAX_PAGE_BYTES = 200_000_000
SHOWN = 20


class Asked(NamedTuple):
    """Where the page goes, requirements, draws of the tolerance and their seed."""

    out: Path
    requirements: Path | None
    draws: int
    seed: int


def report(names: Sequence[str], scene: SceneOptions, score: ScoreOptions, asked: Asked) -> None:
    """Write a page about some rigs."""
    if asked.out.suffix.lower() not in (".html", ".pdf"):
        raise InputError(f"--out {asked.out}: found another ending, accepted are .html and .pdf")
    _check_draws(asked.draws, asked.seed)
    rigs = tuple(rig_called(name) for name in names)
    meshes = tuple(mesh_called(name, rig) for name, rig in zip(names, rigs, strict=True))
    reads: list[str | Path] = [*names, *scene.files]
    if asked.requirements is not None:
        reads.append(asked.requirements)
    require_writable(asked.out, reads)
    for line in (line for rig in rigs for line in missing_rays(rig)):
        note(line)
    text = None if asked.requirements is None else read_text(asked.requirements, "a file of requirements")
    required = _requirements(text, str(asked.requirements))
    if required is not None and asked.requirements is not None:
        score = score.as_required(required.body, asked.requirements)
    plan = ReportPlan(rigs, meshes, scene, score, asked.draws, asked.seed, required, text)
    with progress_bar("Making the report") as progress:
        found = report_of(plan, progress)
        page = report_page(plan, found)
    if asked.out.suffix.lower() == ".pdf":
        _write_pdf(asked.out, found.figures, page)
    else:
        write_text(asked.out, page)
    results().print(f"wrote {visible(str(asked.out))}", soft_wrap=True)


def print_page(page: Path, out: Path) -> None:
    """Write the PDF of a page that was made before: the very bytes that --out with its name would have written."""
    text = _page_text(page)
    _write_pdf(out, attached_figures(text, str(page)), text)


def draw_pages(page: Path, folder: Path) -> None:
    """Draw the pages of the PDF of a page that was made before, as 001.png and so on."""
    require_system_libraries("offscreen")
    from riglens.app.rendering.pdf import page_images  # Qt

    for number, image in enumerate(page_images(_page_text(page)), 1):
        image.save(str(folder / f"{number:03}.png"))


def _write_pdf(path: Path, figures: dict[str, Any], page: str) -> None:
    """Print the page, with the figures and the rigs attached."""
    require_system_libraries("offscreen")
    from riglens.app.rendering.pdf import pdf_of  # Qt

    attached = {FIGURES_NAME: to_text(figures).encode("utf-8")}
    for number, rig in enumerate(figures["inputs"]["rigs"], 1):
        attached[f"rig{number}.yaml"] = rig.encode("utf-8")
    title = ", ".join(visible(rig["name"]) for rig in figures["evaluation"]["rigs"])
    with atomic_write(path) as stream:
        stream.write(pdf_of(page, title, attached))


def _check_draws(draws: int, seed: int) -> None:
    if not 0 <= draws <= MAX_DRAWS:
        raise InputError(f"--draws: found {draws}, accepted is a whole number, 0 to {MAX_DRAWS}")
    if not 0 <= seed < 1 << 63:
        raise InputError(f"--seed: found {seed}, accepted is a whole number from 0 up to 2^63 - 1")


def _requirements(text: str | None, where: str) -> Requirements | None:
    return None if text is None else requirements_in(text, where)


def verify(path: Path, scene: SceneOptions, score: ScoreOptions) -> int:
    """Make the figures of a page again from what is attached to it; 0 when all are the same, else 1."""
    attached = attached_figures(_page_text(path), str(path))
    plan = _plan_of(attached, path, scene, score)
    with progress_bar("Making the figures again") as progress:
        again = report_of(plan, progress).figures
    again["inputs"]["boxes"] = attached["inputs"].get("boxes")
    lines = [line for line in differences(attached, again) if not line.startswith(_NAMES)]
    console = results()
    for line in lines[:SHOWN]:
        console.print(visible(line), soft_wrap=True, markup=False)
    if len(lines) > SHOWN:
        console.print(f"and {len(lines) - SHOWN} more", soft_wrap=True)
    console.print("differs" if lines else "every figure is the same", soft_wrap=True)
    return int(bool(lines))


_NAMES = ("evaluation.data.source:", "targets.data.source:")
"""Where data lie may differ; what they are is in their SHA-256."""


def _plan_of(attached: dict[str, Any], path: Path, scene: SceneOptions, score: ScoreOptions) -> ReportPlan:
    try:
        inputs = attached["inputs"]
        rigs = tuple(loads(str(text), f"{path}: rig {n}").rig for n, text in enumerate(inputs["rigs"], 1))
        text = inputs["requirements"]
        text = None if text is None else str(text)
        length, width, height = (float(side) for side in inputs["roi_m"])
        scene = replace(scene, voxel_m=float(inputs["voxel_m"]), roi_m=(length, width, height))
        how = ScoreOptions(
            inputs["method"], inputs["reading"], float(inputs["lambda"]), score.threads, inputs["body"]
        )
        draws, seed = int(inputs["draws"]), int(inputs["seed"])
    except (KeyError, TypeError, ValueError) as error:
        if isinstance(error, InputError):
            raise
        raise InputError(f"{path}: the attached inputs are damaged") from error
    if inputs.get("boxes") is not None and scene.boxes is None and scene.pog is None:
        name = visible(str(inputs["boxes"]))
        raise InputError(f"{path}: was made of {name}; name these data with --boxes, as the report did")
    _check_draws(draws, seed)
    meshes = tuple(mesh_called(str(path), rig) for rig in rigs)
    return ReportPlan(rigs, meshes, scene, how, draws, seed, _requirements(text, str(path)), text)


def _page_text(path: Path) -> str:
    accepted = "a page or PDF made by riglens report"
    try:
        with open_regular(path, accepted) as stream:
            content = stream.read(MAX_PAGE_BYTES + 1)
    except OSError as error:
        raise InputError(f"{path}: cannot be read: {error.strerror}; accepted is {accepted}") from error
    if len(content) > MAX_PAGE_BYTES:
        raise InputError(f"{path}: larger than {MAX_PAGE_BYTES / 1e6:g} MB; accepted is {accepted}")
    return (
        figures_in_pdf(content, str(path)) if is_pdf(content) else content.decode("utf-8", errors="replace")
    )
