"""The small data set on the disk, made once; tests read it only."""

from pathlib import Path

import pytest

from tests.core.simulate.small import dataset, make


@pytest.fixture(scope="session")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("simulated") / "set"
    make(path, dataset())
    return path
