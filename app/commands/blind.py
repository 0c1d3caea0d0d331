"""Near-field blind zones and test objects: part of `riglens review`."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Literal

import numpy as np
from cyclopts import Group, Parameter
from rich.table import Table
from rich.text import Text

from riglens.app.commands.kind_choices import SeenByChoice
from riglens.app.commands.options import Profiles, naming_options, taken
from riglens.app.commands.output import Part
from riglens.app.terminal.console import TERMINAL, results
from riglens.app.terminal.tables import table
from riglens.core.blind.zones import (
    HEIGHTS_M,
    SHARE_WITHIN_M,
    BlindMap,
    BlindSettings,
    By,
    Hole,
    share_seen,
    unseen_by,
)
from riglens.core.files import require_ending, write_file
from riglens.core.review.documents import blind_document
from riglens.core.review.profiles import ONLY_GEOMETRY, Profile
from riglens.core.review.verdicts import ProfileVerdict
from riglens.core.rig.model import Rig
from riglens.core.scene.sectors import SECTORS
from riglens.core.shown_text import visible
from riglens.jobs.reviewing import blind_zones
from riglens.studies.files import csv_text

ZONES = Group("Blind zones", sort_key=6)


BlindArguments = Annotated[BlindSettings, taken(ZONES, "width_m", "within_m", "voxel_m")]


@Parameter(name="*")
@dataclass(frozen=True)
class BlindTables:
    """Tables and the map of blind zones."""

    blind_by: Annotated[SeenByChoice, Parameter(group=ZONES, metavar="NAME")] = "any"
    """Sensors of the table and the map; the JSON has all."""
    blind_sensors: Annotated[Literal[1, 2], Parameter(group=ZONES, metavar="1|2")] = 1
    """Number of sensors that must see the object; the JSON has 1 and 2."""
    blind_map: Annotated[Path | None, Parameter(group=ZONES, metavar="FILE.csv|.png")] = None
    """Also write the lowest visible height around the car, as a table or as a picture."""
    profiles: Annotated[Profiles, Parameter(group=ZONES)] = ()

    def __post_init__(self) -> None:
        require_ending("blind_map", self.blind_map, ".csv", ".png")

    @property
    def files(self) -> dict[str, Path | None]:
        """The files to write, by option."""
        return {"blind_map": self.blind_map}

    def find(
        self, rig: Rig, settings: BlindSettings, profiles: Sequence[Profile], threads: int | None
    ) -> Part:
        """Find blind zones of a rig, write the map if it was asked for, and return the part of the review."""
        with naming_options(BlindSettings):
            found, judged = blind_zones(rig, settings, profiles, threads, TERMINAL)
        by, k = self.blind_by, self.blind_sensors
        if self.blind_map is not None:
            _write_map(self.blind_map, found, by, k)
        return blind_document(found, judged), lambda: print_blind(found, judged, by, k)


def _write_map(path: Path, found: BlindMap, by: By, k: int) -> None:
    """Write the lowest visible heights as a table or as a picture, whichever the name ends in."""
    if path.suffix.lower() == ".csv":
        write_file(path, csv_text(list(_rows(found, by, k))))
        return
    from riglens.studies.blind_chart import blind_figure  # matplotlib
    from riglens.studies.pictures import write_picture

    write_picture(path, blind_figure(found, by, k))


def _rows(found: BlindMap, by: By, k: int) -> Iterator[dict[str, object]]:
    """One row for every column that counts: where it is, and from what height on an object is seen; inf: never."""
    lowest, ground = found.lowest_m(by, k), found.ground
    for ix, iy in np.argwhere(ground.counts).tolist():
        x, y = (round(float(at), 6) for at in (ground.x_m[ix], ground.y_m[iy]))
        yield {"x_m": x, "y_m": y, f"lowest_{k}_{by}_m": round(float(lowest[ix, iy]), 6)}


def print_blind(found: BlindMap, profiles: Sequence[ProfileVerdict], by: By, k: int) -> None:
    """Print areas by height and sector, the largest holes, and the verdicts, on standard output."""
    console, settings = results(), found.settings
    title = f"{visible(found.rig.name)}: ground in m² on which an object of each height is {unseen_by(by, k)}"
    console.print(Text(title), soft_wrap=True)
    console.print(_areas_table(found, by, k))
    console.print(
        f"Less is better. Objects {settings.width_m:g} m wide, up to {settings.within_m:g} m from the car; "
        f"δ {settings.voxel_m:g} m, body {settings.body}. Heights are rounded up to whole voxels.",
        soft_wrap=True,
    )
    share = 100.0 * share_seen(found, by, k)
    console.print(
        f"Of the ground within {SHARE_WITHIN_M:g} m of the car an object of {HEIGHTS_M[0]:g} m is seen on "
        f"{share:.1f} % (more is better).",
        soft_wrap=True,
    )
    console.print(_profiles_table(profiles))
    console.print(f"Objects: {ONLY_GEOMETRY}. Sources:", soft_wrap=True)
    for verdict in profiles:
        one = verdict.profile
        for_whom = f" (for {', '.join(one.vehicles)})" if one.vehicles else ""
        console.print(Text(f"  {one.name}{for_whom}: {visible(one.source)}"), soft_wrap=True)


def _areas_table(found: BlindMap, by: By, k: int) -> Table:
    """Return the heights as rows: area by sector, in all, and the largest connected patch."""
    sectors = (sector.replace("-", "\n") for sector in SECTORS)
    made = table("height", *sectors, "all", "largest\npatch", dense=True)
    for height in HEIGHTS_M:
        areas = found.area_m2(height, by, k)
        cells = (f"{area:.1f}" for area in areas.sum(axis=1).tolist())
        made.add_row(
            f"{height:.2f} m", *cells, f"{areas.sum():.1f}", _hole_text(found.largest_hole(height, by, k))
        )
    ground = found.ground_m2()
    made.add_section()
    made.add_row(
        "ground", *(f"{area:.0f}" for area in ground.sum(axis=1).tolist()), f"{ground.sum():.0f}", ""
    )
    return made


def _hole_text(hole: Hole | None) -> str:
    """Return the area of a patch and its distance from the car."""
    return "none" if hole is None else f"{hole.area_m2:.1f} m², {hole.nearest_m:.1f} m off"


def _profiles_table(profiles: Sequence[ProfileVerdict]) -> Table:
    """Return profiles as rows: the number of objects seen, and the unseen ones."""
    made = table("profile", "seen", "not seen", words={0, 2}, wraps={0, 2}, dense=True)
    for verdict in profiles:
        count = len(verdict.objects)
        seen = f"{count - len(verdict.failed)} of {count}"
        made.add_row(Text(visible(verdict.profile.title)), seen, Text(_failed_text(verdict)))
    return made


def _failed_text(verdict: ProfileVerdict) -> str:
    """Return the first objects that are not seen, with why."""
    words = [
        f"{visible(one.target.name)} ({one.rays} rays, {100.0 * one.share:.0f} %)"
        for one in verdict.failed[:3]
    ]
    more = len(verdict.failed) - len(words)
    return ", ".join(words) + (f", {more} more" if more else "")
