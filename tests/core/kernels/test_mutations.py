"""Small mistakes in kernels, engine and metric are caught by the direct tests, each within a second or two.

Every mutation of `mutations.py` is made in a copy of the sources, and the direct tests of that file run there as plain
Python, without the compiler (see `plain_kernels.py`): at least one must fail.
"""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.core.kernels.mutations import GUARD
from tests.core.mutants import FAILED, PASSED, Mutation


@pytest.fixture(scope="module")
def copy(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A copy of what the tests need, in which they have passed."""
    root = tmp_path_factory.mktemp("sources")
    GUARD.copy(root)
    code, output = GUARD.run(root, GUARD.every_test(), keeps_bytecode=True)
    assert code == PASSED, f"the tests fail without any mutation:\n{output[-4000:]}"
    return root


def test_the_list_follows_the_sources() -> None:
    GUARD.check()


@pytest.mark.slow
@pytest.mark.parametrize(
    "mutation", GUARD.mutations, ids=lambda mutation: f"{Path(mutation.file).stem}: {mutation.right}"
)
def test_a_mutation_is_caught(copy: Path, mutation: Mutation) -> None:
    code, output = GUARD.with_mistake(copy, mutation)
    assert code == FAILED, f"with {mutation.wrong!r} the tests say:\n{output[-2000:]}"
