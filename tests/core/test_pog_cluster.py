"""A cluster that is not there, fails or goes away ends the build in one line, and what is done is kept."""

import json
import os
import shutil
import signal
import socket
import subprocess
import sys
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Self

import pytest

from riglens.core.errors import InputError
from riglens.core.scene import pog_cluster
from riglens.core.scene.pog import build_pog
from riglens.core.scene.pog_cluster import Limits, cluster_workers
from riglens.core.scene.pog_parts import PartsPlan, build_in_parts
from riglens.core.scene.readers import open_boxes
from tests.core.test_pog_parts import GRID, HEADER, assert_same, sequence, tables
from tests.waiting import TIMEOUT_S, poll

SOON = Limits(silent_s=2.0, without_workers_s=0.2)
REPOSITORY = Path(__file__).parents[2]


@pytest.mark.parametrize("address", ["", "localhost", "tcp://", "tcp://host", "http://host:1", "tcp://a b:1"])
def test_what_is_no_address_is_refused(address: str) -> None:
    with pytest.raises(InputError, match="accepted is tcp://HOST:PORT"), cluster_workers(address):
        pass


def test_a_scheduler_that_is_not_there_is_said_in_one_line() -> None:
    with socket.socket() as unused:
        unused.bind(("127.0.0.1", 0))
        address = f"tcp://127.0.0.1:{unused.getsockname()[1]}"
        with pytest.raises(InputError) as caught, cluster_workers(address):
            pass
    assert str(caught.value) == f"--dask: no scheduler answers at {address} (Connection refused)"


def test_a_host_that_has_no_address_is_said_in_one_line() -> None:
    address = "tcp://no-such.invalid:8786"
    with pytest.raises(InputError, match=f"no scheduler answers at {address} ."), cluster_workers(address):
        pass


def test_a_port_that_is_none_is_said_in_one_line() -> None:
    with pytest.raises(InputError, match="no scheduler answers"), cluster_workers("tcp://127.0.0.1:99999"):
        pass


def test_a_server_that_says_nothing_is_given_up() -> None:
    with socket.socket() as silent:
        silent.bind(("127.0.0.1", 0))
        silent.listen()
        address = f"tcp://127.0.0.1:{silent.getsockname()[1]}"
        with pytest.raises(InputError) as caught, cluster_workers(address, Limits(connect_s=0.5)):
            pass
    assert str(caught.value) == f"--dask: no scheduler answers at {address} (not within 0.5 s)"


def test_an_encrypted_connection_needs_certificates() -> None:
    with pytest.raises(InputError, match="tls:// needs certificates"), cluster_workers("tls://127.0.0.1:9"):
        pass


# ---------------------------------------------------------------- a scheduler and a worker


class Cluster:
    """A scheduler and one worker, as processes of their own."""

    def __init__(self, folder: Path, scheme: str = "tcp", **environment: str) -> None:
        self._folder, self._environment = folder, {**os.environ, "PYTHONPATH": str(REPOSITORY), **environment}
        file = folder / "scheduler.json"
        self.scheduler = self._start(
            "dask_scheduler", "--host", f"{scheme}://127.0.0.1:0", "--scheduler-file", str(file)
        )
        self.worker = self._start(
            *("dask_worker", "--scheduler-file", str(file), "--no-nanny", "--nthreads", "1"),
            *("--local-directory", str(folder), *(["--protocol", "tls"] if scheme == "tls" else [])),
        )
        poll(lambda: file.exists() and file.read_text().endswith("}"))
        self.address: str = json.loads(file.read_text())["address"]

    def _start(self, module: str, *arguments: str) -> "subprocess.Popen[bytes]":
        command = [sys.executable, "-m", f"distributed.cli.{module}", "--no-dashboard", *arguments]
        with (self._folder / f"{module}.log").open("wb") as log:
            return subprocess.Popen(command, env=self._environment, stdout=log, stderr=log)

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        for process in (self.scheduler, self.worker):
            process.kill()
            process.wait(TIMEOUT_S)


@pytest.fixture(scope="module")
def cluster(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Cluster]:
    """One for all tests that do it no harm."""
    with Cluster(tmp_path_factory.mktemp("cluster")) as cluster:
        yield cluster


@pytest.fixture(scope="module", autouse=True)
def threads_of_dask() -> None:
    """Start the one thread that Dask starts once in a process and never ends."""
    from distributed import utils

    utils._offload_executor.submit(int).result()


@pytest.fixture
def plan(tmp_path: Path) -> PartsPlan:
    """Eight tables of one sequence each, whose content hashes are known already."""
    paths = tables(tmp_path / "data", [[number] for number in range(8)])
    plan = PartsPlan.of(open_boxes(paths), GRID, tmp_path / "parts")
    assert all(group.content_hash for group in plan.groups)
    return plan


def test_a_cluster_gives_the_same_bits(cluster: Cluster, plan: PartsPlan) -> None:
    with cluster_workers(cluster.address) as workers:
        assert_same(build_in_parts(plan, GRID, workers), build_pog(plan.source, GRID))


@pytest.mark.parametrize(
    ("spoil", "complaint"),
    [
        (lambda path: path.write_text(HEADER + "s,0,car,abc,0,0,1,1,1,0\n"), r":2: column 'x': found 'abc'"),
        (Path.unlink, r": cannot be read \(No such file or directory"),
    ],
    ids=["bad data", "no file"],
)
def test_data_that_a_worker_cannot_read_are_told_in_one_line_and_the_others_kept(
    cluster: Cluster, plan: PartsPlan, tmp_path: Path, spoil: Callable[[Path], object], complaint: str
) -> None:
    spoil(tmp_path / "data" / "004.csv")
    with (
        pytest.raises(InputError, match=rf"--dask: on worker .*004\.csv({complaint})") as caught,
        cluster_workers(cluster.address) as workers,
    ):
        build_in_parts(plan, GRID, workers)
    assert "\n" not in str(caught.value)
    assert 4 <= plan.store.count() < 8


def test_a_worker_with_other_data_under_the_same_name_is_noticed(
    cluster: Cluster, plan: PartsPlan, tmp_path: Path
) -> None:
    (tmp_path / "data" / "004.csv").write_text(HEADER + sequence(99))
    with (
        pytest.raises(ChildProcessError, match="its files differ"),
        cluster_workers(cluster.address) as workers,
    ):
        build_in_parts(plan, GRID, workers)
    assert 4 <= plan.store.count() < 8


def test_what_a_worker_returns_is_never_unpickled(
    cluster: Cluster, plan: PartsPlan, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    victim = tmp_path / "victim"

    class Attack:
        def __reduce__(self) -> tuple[object, tuple[str]]:
            return os.mkdir, (str(victim),)

    monkeypatch.setattr(pog_cluster, "_build", lambda group, grid: Attack())
    with (
        pytest.raises(ChildProcessError, match="sent a result that is none"),
        cluster_workers(cluster.address) as workers,
    ):
        build_in_parts(plan, GRID, workers)
    assert not victim.exists()


@pytest.mark.parametrize(
    ("answer", "complaint"),
    [
        (b"", "sent a result that is none"),
        (b"+PK\x03\x04", "sent a damaged part"),
        ("+", "sent a result that is none"),
    ],
)
def test_an_answer_that_is_no_pog_is_refused_and_not_kept(
    cluster: Cluster, plan: PartsPlan, monkeypatch: pytest.MonkeyPatch, answer: object, complaint: str
) -> None:
    monkeypatch.setattr(pog_cluster, "_build", lambda group, grid: answer)
    with (
        pytest.raises(ChildProcessError, match=complaint),
        cluster_workers(cluster.address) as workers,
    ):
        build_in_parts(plan, GRID, workers)
    assert plan.store.count() == 0


def test_an_error_of_the_program_on_a_worker_is_one_line(
    cluster: Cluster, plan: PartsPlan, monkeypatch: pytest.MonkeyPatch
) -> None:
    def fail(*_: object) -> bytes:
        raise ModuleNotFoundError("No module named 'riglens'\n\x1b[31m")

    monkeypatch.setattr(pog_cluster, "_build", fail)
    with (
        pytest.raises(ChildProcessError) as caught,
        cluster_workers(cluster.address) as workers,
    ):
        build_in_parts(plan, GRID, workers)
    assert str(caught.value) == (
        f"--dask: the cluster at {cluster.address} could not build a group (ModuleNotFoundError: No module "
        "named 'riglens'  [31m); what is finished is kept: run the same command again"
    )


@pytest.mark.parametrize(
    ("victim", "harm", "complaint"),
    [
        ("worker", signal.SIGKILL, r"has had no workers for 0\.2 s|have its workers gone\?"),
        ("scheduler", signal.SIGKILL, "went away|takes no more work"),
        ("scheduler", signal.SIGSTOP, "has not answered for 2 s|sent no result within 2 s"),
    ],
    ids=["no workers", "dead scheduler", "silent scheduler"],
)
def test_a_cluster_that_goes_away_ends_the_build_and_what_is_done_is_kept(
    plan: PartsPlan, tmp_path: Path, victim: str, harm: signal.Signals, complaint: str
) -> None:
    with (
        Cluster(tmp_path) as cluster,
        pytest.raises(ChildProcessError, match=f"({complaint}).*; what is finished is kept: run the same"),
        cluster_workers(cluster.address, SOON) as workers,
    ):
        build_in_parts(plan, GRID, workers, lambda _: getattr(cluster, victim).send_signal(harm))
    assert 1 <= plan.store.count() < 8


@pytest.mark.skipif(not shutil.which("openssl"), reason="no openssl to make certificates")
def test_a_cluster_with_certificates(plan: PartsPlan, tmp_path: Path) -> None:
    import dask

    key, certificate = tmp_path / "key.pem", tmp_path / "certificate.pem"
    command = [
        "openssl",
        "req",
        "-x509",
        "-newkey",
        "rsa:2048",
        "-nodes",
        "-days",
        "2",
        "-subj",
        "/CN=localhost",
    ]
    command += ["-keyout", str(key), "-out", str(certificate)]
    subprocess.run(command, check=True, capture_output=True)
    files = {"CA_FILE": str(certificate)}
    for role in ("SCHEDULER", "WORKER", "CLIENT"):
        files |= {f"{role}__CERT": str(certificate), f"{role}__KEY": str(key)}
    variables = {f"DASK_DISTRIBUTED__COMM__TLS__{name}": file for name, file in files.items()}
    settings = {
        f"distributed.comm.tls.{name.replace('__', '.').replace('_', '-').lower()}": file
        for name, file in files.items()
    }
    with (
        Cluster(tmp_path, "tls", **variables) as cluster,
        dask.config.set(settings),
        cluster_workers(cluster.address) as workers,
    ):
        assert cluster.address.startswith("tls://")
        assert_same(build_in_parts(plan, GRID, workers), build_pog(plan.source, GRID))
