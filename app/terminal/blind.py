"""Blind zones and verdicts on objects as tables in the terminal."""

from __future__ import annotations

from collections.abc import Sequence

from rich import box
from rich.table import Table
from rich.text import Text

from riglens.app.evaluation.blind_text import hole_text
from riglens.app.terminal.console import results
from riglens.core.review.blind import HEIGHTS_M, BlindMap, By, unseen_by
from riglens.core.review.blind_json import SHARE_WITHIN_M, share_seen
from riglens.core.review.outline import SECTORS
from riglens.core.review.profiles import ONLY_GEOMETRY
from riglens.core.review.verdicts import ProfileVerdict
from riglens.core.shown_text import visible


def print_blind(found: BlindMap, profiles: Sequence[ProfileVerdict], by: By, k: int) -> None:
    """Print areas by height and sector, the largest holes, and the verdicts, on standard output."""
    console, settings = results(), found.settings
    title = f"{visible(found.rig.name)}: ground in m² where an object of a height is {unseen_by(by, k)}"
    console.print(Text(title), soft_wrap=True)
    console.print(areas_table(found, by, k))
    console.print(
        f"Less is better. Objects {settings.width_m:g} m wide, up to {settings.within_m:g} m from the car; "
        f"δ {settings.voxel_m:g} m, body {settings.body}. Heights count in whole voxels, to the safe side.",
        soft_wrap=True,
    )
    share = 100.0 * share_seen(found, by, k)
    console.print(
        f"Of the ground within {SHARE_WITHIN_M:g} m of the car an object of {HEIGHTS_M[0]:g} m is seen on "
        f"{share:.1f} % (more is better).",
        soft_wrap=True,
    )
    console.print(profiles_table(profiles))
    console.print(f"Objects: {ONLY_GEOMETRY}. Sources:", soft_wrap=True)
    for verdict in profiles:
        one = verdict.profile
        for_whom = f" (for {', '.join(one.vehicles)})" if one.vehicles else ""
        console.print(Text(f"  {one.name}{for_whom}: {visible(one.source)}"), soft_wrap=True)


def areas_table(found: BlindMap, by: By, k: int) -> Table:
    """Heights as rows: area by sector, in all, and the largest connected patch."""
    table = Table(box=box.SIMPLE_HEAD, pad_edge=False, padding=(0, 1, 0, 0))
    table.add_column("height")
    for sector in SECTORS:
        table.add_column(sector.replace("-", "\n"), justify="right")
    for title in ("all", "largest\npatch"):
        table.add_column(title, justify="right")
    for height in HEIGHTS_M:
        areas = found.area_m2(height, by, k)
        cells = (f"{area:.1f}" for area in areas.sum(axis=1).tolist())
        table.add_row(
            f"{height:.2f} m", *cells, f"{areas.sum():.1f}", hole_text(found.largest_hole(height, by, k))
        )
    ground = found.ground_m2()
    table.add_section()
    table.add_row(
        "ground", *(f"{area:.0f}" for area in ground.sum(axis=1).tolist()), f"{ground.sum():.0f}", ""
    )
    return table


def profiles_table(profiles: Sequence[ProfileVerdict]) -> Table:
    """Profiles as rows: how many of their objects are seen, and which are not."""
    table = Table(box=box.SIMPLE_HEAD, pad_edge=False, padding=(0, 1, 0, 0))
    table.add_column("profile")
    table.add_column("seen", justify="right", no_wrap=True)
    table.add_column("not seen")
    for verdict in profiles:
        count = len(verdict.objects)
        seen = f"{count - len(verdict.failed)} of {count}"
        table.add_row(Text(visible(verdict.profile.title)), seen, Text(failed_text(verdict)))
    return table


def failed_text(verdict: ProfileVerdict) -> str:
    """The first objects that are not seen, with why."""
    words = [
        f"{visible(one.target.name)} ({one.rays} rays, {100.0 * one.share:.0f} %)"
        for one in verdict.failed[:3]
    ]
    more = len(verdict.failed) - len(words)
    return ", ".join(words) + (f", {more} more" if more else "")
