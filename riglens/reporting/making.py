"""Make the report of rigs, and an earlier one again."""

from __future__ import annotations

import io
from collections.abc import Sequence
from contextlib import redirect_stdout
from dataclasses import replace
from pathlib import Path, PurePath
from typing import Any, NamedTuple

from riglens.core.errors import InputError
from riglens.core.files import write_file
from riglens.core.monitor import Monitor
from riglens.core.plain import to_text
from riglens.core.review.requirements import Requirements, requirements_in
from riglens.core.rig.model import Rig
from riglens.core.rig.ray_file import read_ray_rows
from riglens.core.rig.yaml.file import loads
from riglens.core.rig.yaml.nodes import read_text
from riglens.core.shown_text import numbered, visible
from riglens.core.vehicle.mesh_file import with_mesh_read
from riglens.evaluation.options import ReportOptions, SceneOptions, ScoreOptions
from riglens.rendering.system_libraries import require_system_libraries
from riglens.reporting.document import ReportDocument, document_of
from riglens.reporting.figures import (
    Labels,
    ReportPlan,
    differences,
    report_of,
    report_profiles,
)
from riglens.reporting.page import report_page
from riglens.reporting.reading import (
    FIGURES_NAME,
    attached_figures,
    first_difference,
    form_of,
    inputs_of,
    read_report,
)


class Verified(NamedTuple):
    """An earlier report next to the same made again: `lines` say which figures differ, `place` is the first place where
    the files do, None where there is none; given: words that no data can confirm."""

    lines: list[str]
    place: str | None
    given: tuple[str, ...] = ()


def write_report(
    rigs: Sequence[Rig],
    out: Path,
    scene: SceneOptions,
    score: ScoreOptions,
    holds: ReportOptions,
    monitor: Monitor,
    files: Sequence[str] = (),
) -> None:
    """Make the page or PDF of some rigs; files: what tells rigs of one name apart."""
    text = required = None
    if holds.requirements is not None:
        text = read_text(holds.requirements, "a file of requirements")
        required = _requirements(text, str(holds.requirements), rigs)
        score = score.as_required(required.settings.body, holds.requirements)
        scene = scene.as_required(required.settings, holds.requirements)
    names = numbered([rig.name for rig in rigs], files)
    labels = Labels(**holds.labels)
    plan = ReportPlan(
        portable(rigs), scene, score, holds.draws, holds.seed, required, text, labels, names=names
    )
    with monitor.stage("Making the report") as tell:
        document = document_of(plan, report_of(plan, tell, monitor))
    write_file(out, rendered(document, out.suffix.lower()))


def portable(rigs: Sequence[Rig]) -> tuple[Rig, ...]:
    """Return rigs that name the mesh files of their bodies without folders, which tell about this machine."""
    return tuple(
        rig.model_copy(
            update={"vehicle": rig.vehicle.model_copy(update={"body": _named_below(rig.vehicle.body)})}
        ).with_body_mesh(rig.vehicle.body_mesh)
        if rig.vehicle.has_mesh_file
        else rig
        for rig in rigs
    )


def require_pango() -> None:
    """Raise MissingLibraries or InputError unless a PDF can be laid out."""
    require_system_libraries("pdf")
    try:
        with redirect_stdout(io.StringIO()):  # WeasyPrint prints advice
            import riglens.reporting.pdf  # noqa: F401
    except OSError as error:  # on systems whose packages are not checked
        raise InputError(
            f"a PDF needs the library Pango, a page (.html) does not: {str(error).split(chr(10))[0]}"
        ) from error


def rendered(document: ReportDocument, form: str) -> bytes:
    """Return the file of a report: .html, .pdf with figures and rigs attached, or .json for the figures alone.

    Equal documents give equal bytes on the same system.
    """
    figures = to_text(document.figures).encode("utf-8")
    if form == ".json":
        return figures
    if form == ".html":
        return report_page(document).encode("utf-8")
    from riglens.reporting.pdf import pdf_of  # Pango

    rigs = enumerate(document.figures["inputs"]["rigs"], 1)
    attached = {FIGURES_NAME: figures} | {f"rig{number}.yaml": text.encode("utf-8") for number, text in rigs}
    return pdf_of(report_page(document), attached)


def verified(
    path: Path, scene: SceneOptions, score: ScoreOptions, meshes: Path | None, monitor: Monitor
) -> Verified:
    """Recompute a report from its attachment."""
    content = read_report(path)
    attached = attached_figures(content, str(path))
    if form_of(content) == ".pdf":
        require_pango()
    plan = _plan_of(attached, path, scene, score, meshes or path.parent, monitor)
    with monitor.stage("Recomputing the figures") as tell:
        document = document_of(plan, report_of(plan, tell, monitor))
    lines = differences(attached, document.figures)
    named = numbered([rig.name for rig in plan.rigs]) != plan.names
    given = (
        *plan.labels.words,
        *(() if plan.why is None else ("why sensors are where they are",)),
        *((f"files of rigs: {', '.join(plan.names)}",) if named else ()),
    )
    return Verified(lines, first_difference(content, rendered(document, form_of(content)), str(path)), given)


def _requirements(text: str, where: str, rigs: Sequence[Rig]) -> Requirements:
    """Return requirements; InputError for unknown names, or for test objects that no report shows."""
    profiles, left_out = report_profiles()
    for one in requirements_in(text, where).blind_objects:
        if one.profile in left_out:
            raise InputError(f"{where}: profile '{one.profile}' is from memory and not used in reports")
    return requirements_in(text, where, rigs, profiles)


def _plan_of(
    attached: dict[str, Any],
    path: Path,
    scene: SceneOptions,
    score: ScoreOptions,
    folder: Path,
    monitor: Monitor,
) -> ReportPlan:
    inputs = inputs_of(attached, str(path))
    rigs = tuple(
        loads(text, f"{path}: rig {n}", lambda file: read_ray_rows(folder / _named_below(file), file)).rig
        for n, text in enumerate(inputs.rigs, 1)
    )
    if not rigs:
        raise InputError(f"{path}: inputs.rigs: must name at least one rig")
    if inputs.boxes is not None and scene.boxes is None and scene.pog is None:
        name = visible(inputs.boxes)
        raise InputError(f"must name {name}, as {path} was made from it", "boxes")
    length, width, height = inputs.roi_m
    return ReportPlan(
        tuple(_with_mesh(rig, folder, monitor) for rig in rigs),
        replace(scene, voxel_m=inputs.voxel_m, roi_m=(length, width, height), tolerance_pp=None),
        ScoreOptions(inputs.method, inputs.reading, inputs.camera_weight, score.threads, inputs.body),
        inputs.draws,
        inputs.seed,
        None if inputs.requirements is None else _requirements(inputs.requirements, str(path), rigs),
        inputs.requirements,
        inputs.labels,
        inputs.why,
        tuple(inputs.names),
    )


def _named_below(file: str) -> str:
    """Return a path that stays below the folder: a report may name any file of this machine."""
    named = PurePath(file)
    is_elsewhere = named.is_absolute() or ".." in named.parts or file.startswith("~")
    return named.name if is_elsewhere else file


def _with_mesh(rig: Rig, folder: Path, monitor: Monitor) -> Rig:
    """Return a report's rig with its mesh, read only from below a folder."""
    body = _named_below(rig.vehicle.body)
    if rig.vehicle.has_mesh_file and not (folder / body).is_file():
        raise InputError(
            f"{folder / body}: no such file; name the folder of the report's car bodies", other="meshes"
        )
    there = rig.model_copy(update={"vehicle": rig.vehicle.model_copy(update={"body": body})})
    return rig.with_body_mesh(with_mesh_read(there, folder, monitor.note).vehicle.body_mesh)
