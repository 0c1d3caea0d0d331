"""What the search finds on a sedan's skin in the bundled town, against proofs and bounds."""

import numpy as np
import pytest

from riglens.core.optimise.additions import Additions
from riglens.core.optimise.bounds import branch_and_bound, fractional_bound
from riglens.core.optimise.candidates import choices_of
from riglens.core.optimise.makers import HitTableMaker, Objects
from riglens.core.optimise.search import Limits, search
from riglens.core.optimise.tables import CoverTable
from riglens.core.optimise.weights import EVEN
from riglens.core.rig.model import Rig
from riglens.core.scene.readers.bundled import bundled_source
from riglens.core.targets.settings import TargetSettings
from riglens.core.targets.traffic import read_traffic
from riglens.core.vehicle.solid import solid_of

pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def skin() -> tuple[CoverTable, Limits]:
    """Mounts of one LiDAR of 16 beams."""
    rig, added = Rig(), Additions(("generic-16",), mirrored=False, spots_m=0.28)
    choices = choices_of(rig, added)
    settings = TargetSettings(body="blocks")
    objects = Objects(read_traffic(bundled_source()), 30, settings, solid_of(rig.vehicle), 2, EVEN)
    maker = HitTableMaker(objects)
    table = maker.table(np.zeros(0, np.int32), [maker.cells_of(one.sensors) for one in choices.candidates])
    return table, choices.limits


@pytest.mark.parametrize("count", [2, 3])
def test_the_search_finds_the_proven_best_to_one_percent(skin: tuple[CoverTable, Limits], count: int) -> None:
    table, limits = skin[0], Limits(count, skin[1].costs, np.inf, skin[1].conflicts)
    found = search(table, limits)
    best, is_proven = branch_and_bound(table, limits, found, most_gains=2_000_000)
    assert is_proven
    assert table.value(found) >= 0.99 * table.value(best)


@pytest.mark.parametrize("count", [2, 4, 6, 8])
def test_the_bound_by_cuts_is_within_5_percent(skin: tuple[CoverTable, Limits], count: int) -> None:
    table, limits = skin[0], Limits(count, skin[1].costs, np.inf, skin[1].conflicts)
    found = search(table, limits)
    bound = fractional_bound(table, limits, found)
    assert table.value(found) <= bound <= 1.05 * table.value(found)
