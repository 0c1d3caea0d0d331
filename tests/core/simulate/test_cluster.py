"""A data set made on a Dask cluster, whose workers have neither the data nor the folder."""

from collections.abc import Iterator
from pathlib import Path

import pytest

from riglens.core.errors import InputError
from riglens.core.scene.pog_cluster import cluster_workers
from riglens.core.simulate.dataset import DatasetFolder, simulate_pieces
from tests.core.simulate.small import dataset, make
from tests.core.test_pog_cluster import Cluster


@pytest.fixture(scope="module")
def cluster(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Cluster]:
    from distributed import utils

    utils._offload_executor.submit(int).result()  # the one thread that Dask starts and never ends
    with Cluster(tmp_path_factory.mktemp("cluster")) as cluster:
        yield cluster


def test_a_cluster_makes_the_same_files(cluster: Cluster, tmp_path: Path) -> None:
    what = dataset()
    folder = DatasetFolder(tmp_path / "there", what)
    folder.begin()
    with cluster_workers(cluster.address) as workers:
        simulate_pieces(folder, what, folder.missing(), workers, lambda _: None)
    folder.finish()
    make(tmp_path / "here", dataset())
    assert content(tmp_path / "there") == content(tmp_path / "here")


def content(folder: Path) -> dict[str, bytes]:
    return {str(path.relative_to(folder)): path.read_bytes() for path in folder.rglob("*") if path.is_file()}


def test_what_a_worker_cannot_do_is_told_in_one_line(cluster: Cluster) -> None:
    with (
        pytest.raises(
            InputError, match=r"--dask: on worker .*: found nothing, accepted is something"
        ) as caught,
        cluster_workers(cluster.address) as workers,
    ):
        (done,) = workers.wait([workers.call(_refuse)])
        done.result()
    assert "\n" not in str(caught.value)


def _refuse() -> bytes:
    raise InputError("found nothing, accepted is something")
