"""Explain the choice of the voxel edge: one sentence, and a table of the edges tried."""

from __future__ import annotations

from collections.abc import Iterator

from riglens.core.study.voxel_choice import Change, Rung, Swap, VoxelChoice


def reason(choice: VoxelChoice) -> str:
    """Return one sentence that says which edge was picked and why."""
    place = [rung.voxel_m for rung in choice.rungs].index(choice.voxel_m)
    picked = f"δ {choice.voxel_m:g} m"
    bound = f"{100 * choice.tolerance:g} pp of those at δ {choice.finest_m:g} m"
    if place + 1 < len(choice.rungs):
        refused = choice.rungs[place + 1]
        limit = f"at δ {refused.voxel_m:g} m {_refusal(refused, choice)}"
    else:
        limit = "no coarser one was tried"
    if place == 0:
        settled = "; a still finer edge might also change the scores" if len(choice.rungs) > 1 else ""
        return f"{picked}, the finest that can be used: {limit}{settled}"
    return f"{picked}, the coarsest with every seen within {bound}: {limit}"


def tried_lines(choice: VoxelChoice) -> Iterator[str]:
    """Yield the table of the edges tried, one line per edge."""
    for rung in choice.rungs:
        mark = "→" if rung.voxel_m == choice.voxel_m else " "
        yield f"{mark} δ {rung.voxel_m:<5g}{_found(rung, choice)}"
    for voxel_m, why in choice.left_out:
        yield f"  δ {voxel_m:<5g}left out: {why}"


def _found(rung: Rung, choice: VoxelChoice) -> str:
    if rung.voxel_m == choice.finest_m:
        return "the finest: reference of the others"
    share = 0.0 if rung.change is None else rung.change.seen
    where = "" if rung.change is None else f" ({_place(rung.change, choice)})"
    swap = "" if rung.swap is None else f"; {_swapped(rung.swap)}"
    return f"seen differs by at most {_points(share)}{where}{swap}"


def _refusal(rung: Rung, choice: VoxelChoice) -> str:
    if rung.swap is not None:
        return _swapped(rung.swap)
    assert rung.change is not None  # without a change and a swap it would have been picked
    return f"seen {_place(rung.change, choice)} differs by {_points(rung.change.seen)}"


def _place(change: Change, choice: VoxelChoice) -> str:
    of_rig = f" of {change.rig}" if choice.rigs > 1 else ""
    return f"by {change.by}, {change.cls}{of_rig}"


def _swapped(swap: Swap) -> str:
    return f"{swap.first} and {swap.second} change their order by S-MS for {swap.cls}"


def _points(share: float) -> str:
    return f"{100 * share:.2f} pp"
