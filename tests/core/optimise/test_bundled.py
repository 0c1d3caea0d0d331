"""What the search finds on a sedan's skin in the bundled town, against proofs and bounds."""

import numpy as np
import pytest

from riglens.core.optimise.additions import Additions
from riglens.core.optimise.bounds import branch_and_bound, fractional_bound
from riglens.core.optimise.candidates import candidates, conflicts, rules_for
from riglens.core.optimise.object_makers import HitTableMaker, Objects, hit_shares
from riglens.core.optimise.search import Limits, search
from riglens.core.optimise.tables import CoverTable
from riglens.core.optimise.weights import EVEN
from riglens.core.rig.model import Rig
from riglens.core.scene.readers.bundled import bundled_source
from riglens.core.targets.settings import TargetSettings
from riglens.core.targets.traffic import read_traffic
from riglens.core.vehicle.solid import solid_of
from tests.core.optimise.problems import done

pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def skin() -> tuple[CoverTable, Limits]:
    """Mounts of one LiDAR of 16 beams."""
    rig, added = Rig(), Additions(("generic-16",), mirrored=False, spots_m=0.28)
    listed = candidates(rig, added)
    settings = TargetSettings(body="blocks")
    maker = HitTableMaker(
        Objects(read_traffic(bundled_source()), 30, settings, solid_of(rig.vehicle), 2, EVEN), hit_shares()
    )
    table = maker.table(np.zeros(0, np.int32), [maker.cells_of(one.sensors) for one in listed])
    apart = conflicts(listed, rig, rules_for(rig, added.rules))
    return table, Limits(1, np.ones(len(listed)), np.inf, apart)


@pytest.mark.parametrize("count", [2, 3])
def test_the_search_finds_the_proven_best_to_one_percent(skin: tuple[CoverTable, Limits], count: int) -> None:
    table, limits = skin[0], Limits(count, skin[1].costs, np.inf, skin[1].conflicts)
    found = done(search(table, limits))
    best, is_proven = done(branch_and_bound(table, limits, found, most_gains=2_000_000))
    assert is_proven
    assert table.value(found) >= 0.99 * table.value(best)


@pytest.mark.parametrize("count", [2, 4, 6, 8])
def test_the_bound_by_cuts_is_within_5_percent(skin: tuple[CoverTable, Limits], count: int) -> None:
    table, limits = skin[0], Limits(count, skin[1].costs, np.inf, skin[1].conflicts)
    found = done(search(table, limits))
    bound = done(fractional_bound(table, limits, found))
    assert table.value(found) <= bound <= 1.05 * table.value(found)
