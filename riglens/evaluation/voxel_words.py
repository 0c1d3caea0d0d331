"""Explain the choice of the voxel edge: one sentence, and a table of the edges tried."""

from __future__ import annotations

from collections.abc import Iterator

from riglens.core.study.voxel_choice import Change, EdgeResult, Swap, VoxelChoice


def reason(choice: VoxelChoice) -> str:
    """Return one sentence that says which edge was picked and why."""
    place = [result.voxel_m for result in choice.edges].index(choice.voxel_m)
    picked = f"δ {choice.voxel_m:g} m"
    bound = f"{100 * choice.tolerance:g} pp of those at δ {choice.finest_m:g} m"
    if place + 1 < len(choice.edges):
        refused = choice.edges[place + 1]
        limit = f"at δ {refused.voxel_m:g} m {_refusal(refused, choice)}"
    else:
        limit = "no coarser one was tried"
    if place == 0:
        settled = "; a still finer edge might also change the scores" if len(choice.edges) > 1 else ""
        return f"{picked}, the finest that can be used: {limit}{settled}"
    return f"{picked}, the coarsest with every seen within {bound}: {limit}"


def tried_lines(choice: VoxelChoice) -> Iterator[str]:
    """Yield the table of the edges tried, one line per edge."""
    for result in choice.edges:
        mark = "→" if result.voxel_m == choice.voxel_m else " "
        yield f"{mark} δ {result.voxel_m:<5g}{_found(result, choice)}"
    for voxel_m, why in choice.left_out:
        yield f"  δ {voxel_m:<5g}left out: {why}"


def _found(result: EdgeResult, choice: VoxelChoice) -> str:
    if result.voxel_m == choice.finest_m:
        return "the finest: reference of the others"
    share = 0.0 if result.change is None else result.change.seen
    where = "" if result.change is None else f" ({_place(result.change, choice)})"
    swap = "" if result.swap is None else f"; {_swapped(result.swap)}"
    return f"seen differs by at most {_points(share)}{where}{swap}"


def _refusal(result: EdgeResult, choice: VoxelChoice) -> str:
    if result.swap is not None:
        return _swapped(result.swap)
    assert result.change is not None  # without a change and a swap it would have been picked
    return f"seen {_place(result.change, choice)} differs by {_points(result.change.seen)}"


def _place(change: Change, choice: VoxelChoice) -> str:
    of_rig = f" of {change.rig}" if choice.rigs > 1 else ""
    return f"by {change.by}, {change.cls}{of_rig}"


def _swapped(swap: Swap) -> str:
    return f"{swap.first} and {swap.second} change their order by S-MS for {swap.cls}"


def _points(share: float) -> str:
    return f"{100 * share:.2f} pp"
