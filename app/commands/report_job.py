"""What `riglens report` does: make all figures and write the page; or make those of a page again and compare."""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import suppress
from dataclasses import replace
from pathlib import Path, PurePath
from typing import TYPE_CHECKING, Any, NamedTuple

from riglens.app.background.own_process import Tell
from riglens.app.background.report import PAGE, PDF, ReportJob, page_picture
from riglens.app.commands.scores_job import missing_rays
from riglens.app.evaluation.options import USUAL_DRAWS, SceneOptions, ScoreOptions
from riglens.app.launch.system_libraries import require_system_libraries
from riglens.app.studies.report_document import ReportDocument, document_of
from riglens.app.studies.report_figures import Labels, ReportPlan, differences, report_of
from riglens.app.studies.report_page import printed_page, report_page
from riglens.app.studies.report_reading import (
    FIGURES_NAME,
    attached_figures,
    first_difference,
    form_of,
    inputs_of,
    read_report,
)
from riglens.app.terminal.console import note, results, stage_bar
from riglens.app.terminal.scores import mesh_called, rig_called
from riglens.core.engine.evaluation_json import to_text
from riglens.core.errors import InputError
from riglens.core.files import atomic_write, require_writable
from riglens.core.review.requirements import Requirements, requirements_in
from riglens.core.review.tolerance import MAX_DRAWS
from riglens.core.rig.model import Rig
from riglens.core.rig.yaml.file import loads
from riglens.core.rig.yaml.nodes import read_text
from riglens.core.shown_text import visible
from riglens.core.vehicle.mesh import BodyMesh
from riglens.core.vehicle.mesh_file import mesh_of

if TYPE_CHECKING:  # Qt
    from riglens.app.rendering.pdf import Header

SHOWN = 20


class Asked(NamedTuple):
    """Where the page goes, requirements, draws of the tolerance and their seed, and words of the header."""

    out: Path
    requirements: Path | None
    draws: int
    seed: int
    labels: Labels = Labels()


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
    plan = ReportPlan(rigs, meshes, scene, score, asked.draws, asked.seed, required, text, asked.labels)
    with stage_bar("Making the report") as tell:
        document = document_of(plan, report_of(plan, tell))
    _write(asked.out, rendered(document, asked.out.suffix.lower()))
    results().print(f"wrote {visible(str(asked.out))}", soft_wrap=True)


def prepare(job: ReportJob, tell: Tell) -> None:
    """Write page, PDF and pictures of its pages into the folder of a job of the window."""
    meshes = tuple(mesh_of(rig.vehicle, job.folder, note) for rig in job.rigs)
    plan = ReportPlan(job.rigs, meshes, job.scene, job.score, USUAL_DRAWS, 0)
    document = document_of(plan, report_of(plan, tell))
    tell(1.0, "Drawing the pages")
    for name in (PAGE, PDF):
        _write(job.folder / name, rendered(document, PurePath(name).suffix))
    from riglens.app.rendering.pdf import page_images  # Qt

    for number, image in enumerate(page_images(*printed_page(document), _header(document)), 1):
        image.save(str(page_picture(job.folder, number)))


def _write(path: Path, content: bytes) -> None:
    with atomic_write(path) as stream:
        stream.write(content)


def rendered(document: ReportDocument, form: str) -> bytes:
    """Return the file of a report: .html, .pdf with figures and rigs attached, or .json for the figures alone.

    Equal documents give equal bytes on the same system.
    """
    figures = to_text(document.figures).encode("utf-8")
    if form == ".json":
        return figures
    if form == ".html":
        return report_page(document).encode("utf-8")
    require_system_libraries("offscreen")
    from riglens.app.rendering.pdf import pdf_of  # Qt

    rigs = enumerate(document.figures["inputs"]["rigs"], 1)
    attached = {FIGURES_NAME: figures} | {f"rig{number}.yaml": text.encode("utf-8") for number, text in rigs}
    return pdf_of(*printed_page(document), _header(document), attached)


def _header(document: ReportDocument) -> Header:
    from riglens.app.rendering.pdf import Header  # Qt

    return Header(visible(document.title), visible(" · ".join(document.labels)))


def _check_draws(draws: int, seed: int) -> None:
    if not 0 <= draws <= MAX_DRAWS:
        raise InputError(f"--draws: found {draws}, accepted is a whole number, 0 to {MAX_DRAWS}")
    if not 0 <= seed < 1 << 63:
        raise InputError(f"--seed: found {seed}, accepted is a whole number from 0 up to 2^63 - 1")


def _requirements(text: str | None, where: str) -> Requirements | None:
    return None if text is None else requirements_in(text, where)


def verify(path: Path, scene: SceneOptions, score: ScoreOptions, meshes: Path | None) -> int:
    """Make a report again from what is attached to it; 0 when it is the same byte for byte, else 1."""
    content = read_report(path)
    attached = attached_figures(content, str(path))
    plan = _plan_of(attached, path, scene, score, meshes or path.parent)
    with stage_bar("Making the figures again") as tell:
        document = document_of(plan, report_of(plan, tell))
    _take_names(document.figures, attached)
    lines = differences(attached, document.figures)
    console = results()
    for line in lines[:SHOWN]:
        console.print(visible(line), soft_wrap=True, markup=False)
    if len(lines) > SHOWN:
        console.print(f"and {len(lines) - SHOWN} more", soft_wrap=True)
    place = first_difference(content, rendered(document, form_of(content)))
    if place is None:
        console.print("every figure is the same, and the file is, byte for byte", soft_wrap=True)
        return 0
    figures = "" if lines else "every attached figure is the same, but what is shown of them "
    console.print(visible(f"{figures}differs, first at {place}"), soft_wrap=True, markup=False)
    return 1


def _take_names(figures: dict[str, Any], attached: dict[str, Any]) -> None:
    """Call data as the report does: where they lie may differ; what they are is in their SHA-256."""
    figures["inputs"]["boxes"] = attached["inputs"]["boxes"]
    for part in ("evaluation", "targets"):
        with suppress(KeyError, TypeError):
            source = attached[part]["data"]["source"]
            if isinstance(source, str):
                figures[part]["data"]["source"] = source


def _plan_of(
    attached: dict[str, Any], path: Path, scene: SceneOptions, score: ScoreOptions, folder: Path
) -> ReportPlan:
    inputs = inputs_of(attached, str(path))
    rigs = tuple(loads(text, f"{path}: rig {n}").rig for n, text in enumerate(inputs.rigs, 1))
    if not rigs:
        raise InputError(f"{path}: inputs.rigs: must name at least one rig")
    if inputs.boxes is not None and scene.boxes is None and scene.pog is None:
        name = visible(inputs.boxes)
        raise InputError(f"{path}: was made of {name}; name these data with --boxes, as the report did")
    length, width, height = inputs.roi_m
    return ReportPlan(
        rigs,
        tuple(_mesh(rig, folder) for rig in rigs),
        replace(scene, voxel_m=inputs.voxel_m, roi_m=(length, width, height), auto=None),
        ScoreOptions(inputs.method, inputs.reading, inputs.camera_weight, score.threads, inputs.body),
        inputs.draws,
        inputs.seed,
        _requirements(inputs.requirements, str(path)),
        inputs.requirements,
        inputs.labels,
    )


def _mesh(rig: Rig, folder: Path) -> BodyMesh | None:
    """The mesh of a report's rig, from below a folder alone: a report may name any file of this machine."""
    body = rig.vehicle.body
    named = PurePath(body)
    if named.is_absolute() or ".." in named.parts or body.startswith("~"):
        body = named.name
    if rig.vehicle.has_mesh_file and not (folder / body).is_file():
        raise InputError(
            f"{folder / body}: no such file; name the folder of the report's car bodies with --meshes"
        )
    return mesh_of(rig.vehicle.model_copy(update={"body": body}), folder, note)
