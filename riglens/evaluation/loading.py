"""Load rigs, scenes and traffic for a front end: a monitor gets the progress, and remarks on rigs and data."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from riglens.core.formats.opening import open_rig
from riglens.core.formats.report import Report
from riglens.core.metric.entropy import EntropyField
from riglens.core.metric.scores import Body
from riglens.core.monitor import Monitor
from riglens.core.rig.library import use_libraries
from riglens.core.rig.model import Rig
from riglens.core.rig.plausible import implausible
from riglens.core.scene.boxes import DataReport
from riglens.core.scene.pog import Pog
from riglens.core.sensing.rays import missing_ray_count
from riglens.core.targets.traffic import Traffic
from riglens.core.vehicle.mesh_file import with_mesh_read
from riglens.core.vehicle.standing import mount_statuses, problems_in_short
from riglens.evaluation.names import option_of
from riglens.evaluation.options import SceneOptions, ScoreOptions
from riglens.evaluation.scenario import load_scenario, remarks_on
from riglens.evaluation.traffic import load_traffic as read_traffic
from riglens.evaluation.voxel_words import reason, tried_lines


def note_report(report: Report | None, monitor: Monitor) -> None:
    """Note what became of a rig of another program, one remark per line."""
    if report is not None:
        for line in report.lines(option_of):
            monitor.note(f"{report.title}: {line}")


def note_doubts(rig: Rig, monitor: Monitor) -> None:
    """Note what is implausible about a rig that was read."""
    for line in implausible(rig):
        monitor.note(f"{rig.name}: {line}")


def load_rig(name: str, monitor: Monitor) -> Rig:
    """Open a preset, a rig file or a file of another program.

    What could not be taken over as it was, and what is implausible, is noted.
    """
    opened = open_rig(name)
    note_report(opened.report, monitor)
    note_doubts(opened.rig, monitor)
    return opened.rig


def with_choice(rig: Rig, housings: Body | None) -> Rig:
    """Return a rig whose housings block or not as given for this run, or else as the rig says."""
    return rig if housings is None else rig.model_copy(update={"housings": housings})


def load_rigs(
    names: Sequence[str],
    score: ScoreOptions,
    monitor: Monitor,
    libraries: Sequence[Path] = (),
    housings: Body | None = None,
) -> list[Rig]:
    """Open rigs with the meshes of bodies that stop rays; raise InputError for the first that cannot be read.

    Each enabled camera whose lens model gives some of its pixels no direction is noted.
    """
    use_libraries(libraries)
    loaded = [with_choice(load_rig(name, monitor), housings) for name in names]
    rigs = with_meshes(loaded, names, score.body, monitor)
    for rig in rigs:
        for camera in rig.enabled_cameras():
            if missing := missing_ray_count(camera):
                share = (
                    f"{missing:,} of {camera.ray_count:,} rays are outside the valid range of its lens model"
                )
                monitor.note(f"{rig.name}: {camera.name}: {share}, and are left out")
    return rigs


def note_mounts(rigs: Sequence[Rig], monitor: Monitor) -> None:
    """Note each sensor with an impossible mount; none on a body that was not read."""
    for rig in rigs:
        if not rig.vehicle.lacks_mesh:
            for line in problems_in_short(mount_statuses(rig)):
                monitor.note(f"{rig.name}: {line}")


def with_meshes(rigs: Sequence[Rig], names: Sequence[str], body: Body | None, monitor: Monitor) -> list[Rig]:
    """Return the rigs with the meshes of bodies that stop rays, found from the folders of their files.

    A size that is not a car's is noted.
    """
    return [
        with_mesh_read(rig, Path(name).parent, monitor.note) if (body or rig.body) == "blocks" else rig
        for name, rig in zip(names, rigs, strict=True)
    ]


def load_scene(
    options: SceneOptions,
    monitor: Monitor,
    rigs: Sequence[Rig] = (),
    score: ScoreOptions | None = None,
) -> tuple[Pog, EntropyField]:
    """Load the scene that rigs are scored on; note which boxes do not count and which voxel edge was picked."""
    if score is not None:
        options = options.for_rigs(rigs, score)
    with monitor.stage("Building the POG") as progress:
        found = load_scenario(options, progress)
    note_data(found.field.data, monitor)
    if found.choice is not None:
        monitor.note(f"voxel auto: {reason(found.choice)}")
        for line in tried_lines(found.choice):
            monitor.note(line)
    return found.pog, found.field


def load_traffic(options: SceneOptions, within_m: float, monitor: Monitor) -> Traffic:
    """Load the objects that points and pixels are counted on; note what deserves it."""
    with monitor.stage("Reading boxes") as progress:
        found = read_traffic(options, within_m, progress)
    note_data(found.data, monitor)
    return found


def note_data(data: DataReport, monitor: Monitor) -> None:
    """Note what is implausible about data, which boxes do not count, and classes without any."""
    for line in remarks_on(data, monitor.advice):
        monitor.note(line)
