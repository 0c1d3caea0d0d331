"""A data set made on a Dask cluster, whose workers have neither the data nor the folder."""

from pathlib import Path

import pytest

from riglens.core.pieces.cluster import cluster_workers
from tests.core.pieces.test_cluster import Cluster
from tests.core.simulate.small import dataset, make


@pytest.fixture(scope="module", autouse=True)
def offload_thread() -> None:
    """Start the one thread that Dask starts and never ends, before threads are counted."""
    from distributed import utils

    utils._offload_executor.submit(int).result()


@pytest.mark.slow
def test_a_cluster_makes_the_same_files(tmp_path: Path) -> None:
    with Cluster(tmp_path) as cluster, cluster_workers(cluster.address) as workers:
        make(tmp_path / "there", dataset(), workers=workers)
    make(tmp_path / "here", dataset())
    assert content(tmp_path / "there") == content(tmp_path / "here")


def content(folder: Path) -> dict[str, bytes]:
    return {str(path.relative_to(folder)): path.read_bytes() for path in folder.rglob("*") if path.is_file()}
