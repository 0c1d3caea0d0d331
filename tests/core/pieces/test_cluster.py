"""A cluster that is not there, fails or goes away ends the work in one line, and what is finished is kept."""

import json
import os
import shutil
import signal
import socket
import subprocess
import sys
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Self

import pytest

from riglens.core.errors import InputError
from riglens.core.pieces.cluster import Limits, cluster_workers, is_unencrypted
from riglens.core.pieces.folder import PieceFolder, count_kept
from riglens.core.pieces.work import Piece, Workers, results
from riglens.core.scene.pog import build_pog
from riglens.core.scene.readers import open_boxes
from tests.core.test_pog_parts import GRID, HEADER, Build, assert_same, sequence, tables
from tests.waiting import TIMEOUT_S, poll

SOON = Limits(silent_s=2.0)
BARE_SOON = Limits(without_workers_s=0.2)
REPOSITORY = Path(__file__).parents[3]


@pytest.mark.parametrize("address", ["", "localhost", "tcp://", "tcp://host", "http://host:1", "tcp://a b:1"])
def test_what_is_no_address_is_refused(address: str) -> None:
    with pytest.raises(InputError, match=r"^dask must be tcp://HOST:PORT"), cluster_workers(address):
        pass


def test_a_scheduler_that_is_not_there_is_said_in_one_line() -> None:
    with socket.socket() as unused:
        unused.bind(("127.0.0.1", 0))
        address = f"tcp://127.0.0.1:{unused.getsockname()[1]}"
        with pytest.raises(InputError) as caught, cluster_workers(address):
            pass
    assert str(caught.value) == f"dask finds no scheduler at {address} (Connection refused)"


def test_a_host_that_has_no_address_is_said_in_one_line() -> None:
    address = "tcp://no-such.invalid:8786"
    with pytest.raises(InputError, match=f"finds no scheduler at {address} ."), cluster_workers(address):
        pass


def test_a_port_that_is_none_is_said_in_one_line() -> None:
    with pytest.raises(InputError, match="finds no scheduler"), cluster_workers("tcp://127.0.0.1:99999"):
        pass


def test_a_server_that_says_nothing_is_given_up() -> None:
    with socket.socket() as silent:
        silent.bind(("127.0.0.1", 0))
        silent.listen()
        address = f"tcp://127.0.0.1:{silent.getsockname()[1]}"
        with pytest.raises(InputError) as caught, cluster_workers(address, Limits(connect_s=0.5)):
            pass
    assert str(caught.value) == f"dask finds no scheduler at {address} (not within 0.5 s)"


@contextmanager
def listener(says: bytes, waits_for: bytes = b"") -> Iterator[str]:
    """A server that answers the first connection once it has read something with these bytes."""
    with socket.create_server(("127.0.0.1", 0)) as server:

        def serve() -> None:
            connection, _ = server.accept()
            with connection:
                heard = b""
                while waits_for not in heard and (more := connection.recv(1 << 10)):
                    heard += more
                connection.sendall(says)

        thread = threading.Thread(target=serve)
        thread.start()
        yield f"tcp://127.0.0.1:{server.getsockname()[1]}"
        thread.join(TIMEOUT_S)


@pytest.mark.parametrize(
    ("says", "waits_for"),
    [
        (b"HTTP/1.1 400 Bad Request\r\nContent-Length: 0\r\n\r\n", b"\r\n\r\n"),
        (b"SSH-2.0-OpenSSH_9.6\r\n", b""),
        (b"\xff" * 64, b""),
        (b"\x20" + bytes(7) + b"x" * 32, b""),
        (b"\x01", b""),
        (b"", b""),
    ],
    ids=["HTTP", "SSH", "a length of exabytes", "another content", "one byte", "nothing"],
)
def test_a_server_of_another_kind_is_one_line_at_once(says: bytes, waits_for: bytes) -> None:
    before = threading.active_count()
    with (
        listener(says, waits_for) as address,
        pytest.raises(InputError, match=f"at {address} .(another program than Dask|Connection reset)"),
        cluster_workers(address),
    ):
        pass
    assert threading.active_count() == before  # Dask's client was never begun, so that none is left behind


@pytest.mark.parametrize(
    ("address", "expected"),
    [
        ("tcp://10.0.0.1:8786", True),
        ("tcp://node7:8786", True),
        ("tls://10.0.0.1:8786", False),
        ("tcp://127.0.0.1:8786", False),
        ("tcp://localhost:8786", False),
        ("tcp://[::1]:8786", False),
    ],
)
def test_messages_to_another_host_without_tls_are_unencrypted(address: str, expected: bool) -> None:
    assert is_unencrypted(address) is expected


def test_an_encrypted_connection_needs_certificates() -> None:
    with (
        pytest.raises(InputError, match="needs certificates for tls://"),
        cluster_workers("tls://127.0.0.1:9"),
    ):
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
        poll(lambda: file.exists() and file.read_text(encoding="utf-8").endswith("}"))
        self.address: str = json.loads(file.read_text(encoding="utf-8"))["address"]

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
def build(tmp_path: Path) -> Build:
    """Eight tables of one sequence each, whose content hashes are known already."""
    paths = tables(tmp_path / "data", [[number] for number in range(8)])
    build = Build.of(open_boxes(paths), tmp_path / "parts")
    assert all(group.content_hash for group in build.groups)
    return build


def test_a_cluster_gives_the_same_bits(cluster: Cluster, build: Build) -> None:
    with cluster_workers(cluster.address) as workers:
        assert_same(build.on(workers), build_pog(build.source, GRID))


@pytest.mark.parametrize(
    ("spoil", "complaint"),
    [
        (
            lambda path: path.write_text(HEADER + "s,0,car,abc,0,0,1,1,1,0\n", encoding="utf-8"),
            r":2: column 'x': .*got 'abc'",
        ),
        (Path.unlink, r": cannot be read \(No such file or directory"),
    ],
    ids=["bad data", "no file"],
)
def test_data_that_a_worker_cannot_read_are_told_in_one_line_and_the_others_kept(
    cluster: Cluster, build: Build, tmp_path: Path, spoil: Callable[[Path], object], complaint: str
) -> None:
    spoil(tmp_path / "data" / "004.csv")
    with (
        pytest.raises(InputError, match=rf"^dask on worker .*004\.csv({complaint})") as caught,
        cluster_workers(cluster.address) as workers,
    ):
        build.on(workers)
    assert "\n" not in str(caught.value)
    assert 4 <= build.kept < 8


def test_a_worker_with_other_data_under_the_same_name_is_noticed(
    cluster: Cluster, build: Build, tmp_path: Path
) -> None:
    (tmp_path / "data" / "004.csv").write_text(HEADER + sequence(99), encoding="utf-8")
    with (
        pytest.raises(ChildProcessError, match="do the files there differ"),
        cluster_workers(cluster.address) as workers,
    ):
        build.on(workers)
    assert 4 <= build.kept < 8


def answer_of(workers: Workers, tmp_path: Path, answer: object) -> None:
    """Have a worker return something for a piece that has to be b"good"."""

    def read(key: str, content: bytes) -> bytes:
        if content != b"good":
            raise ValueError("not good")
        return content

    def work() -> bytes:
        return answer  # type: ignore[return-value]

    list(results([Piece("a", work, tuple)], PieceFolder(tmp_path / "kept", read), workers))


@pytest.mark.parametrize(
    ("answer", "complaint"),
    [
        (b"", r"an unexpected result \(not good\)"),
        ("good", "returned no bytes"),
        (7, "returned no bytes"),
    ],
)
def test_an_answer_that_is_not_the_piece_is_refused_and_not_kept(
    cluster: Cluster, tmp_path: Path, answer: object, complaint: str
) -> None:
    with (
        pytest.raises(ChildProcessError, match=complaint),
        cluster_workers(cluster.address) as workers,
    ):
        answer_of(workers, tmp_path, answer)
    assert count_kept(tmp_path / "kept") == 0


def test_an_error_of_the_program_on_a_worker_is_one_line(cluster: Cluster, tmp_path: Path) -> None:
    def fail() -> bytes:
        raise ModuleNotFoundError("No module named 'riglens'\n\x1b[31m")

    with (
        pytest.raises(ChildProcessError) as caught,
        cluster_workers(cluster.address) as workers,
    ):
        list(results([Piece("a", fail, tuple)], PieceFolder(tmp_path, lambda _, it: it), workers))
    assert str(caught.value) == (
        f"the Dask cluster at {cluster.address} could not do its work (ModuleNotFoundError: No module "
        "named 'riglens'  [31m); finished parts are kept: run the same command again"
    )


def test_what_a_worker_cannot_do_names_the_worker_in_one_line(cluster: Cluster) -> None:
    def refuse() -> bytes:
        raise InputError("nothing to do")

    with (
        pytest.raises(InputError, match=rf"^dask on worker {socket.gethostname()}: nothing to do"),
        cluster_workers(cluster.address) as workers,
    ):
        (done,) = workers.wait([workers.call(refuse)])
        done.result()


def test_a_worker_of_another_version_is_one_line(
    cluster: Cluster, build: Build, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("riglens.core.pieces.cluster.installed_version", lambda: "0.0.other")
    with (
        pytest.raises(InputError, match=r"^dask on worker \S+: RigLens must be .* 0\.0\.other \(got \S+\)$"),
        cluster_workers(cluster.address) as workers,
    ):
        build.on(workers)
    assert build.kept == 0


# Which of them a client notices first depends on the machine: a closed connection or a silence.
GONE = (
    r"went away|takes no more work|has not answered for 2 s|sent no result within 2 s"
    r"|has had no workers for 0\.2 s|have its workers gone\?"
)


@pytest.mark.parametrize(
    ("victim", "harm", "limits"),
    [
        pytest.param("worker", signal.SIGKILL, BARE_SOON, id="no workers"),
        pytest.param("scheduler", signal.SIGKILL, BARE_SOON, id="dead scheduler", marks=pytest.mark.slow),
        pytest.param("scheduler", signal.SIGSTOP, SOON, id="silent scheduler", marks=pytest.mark.slow),
    ],
)
def test_a_cluster_that_goes_away_ends_the_build_and_what_is_done_is_kept(
    build: Build, tmp_path: Path, victim: str, harm: signal.Signals, limits: Limits
) -> None:
    with (
        Cluster(tmp_path) as cluster,
        pytest.raises(ChildProcessError, match=f"({GONE}).*; finished parts are kept: run the same"),
        cluster_workers(cluster.address, limits) as workers,
    ):
        build.on(workers, lambda _: getattr(cluster, victim).send_signal(harm))
    assert 1 <= build.kept < 8


@pytest.mark.slow
@pytest.mark.skipif(not shutil.which("openssl"), reason="no openssl to make certificates")
def test_a_cluster_with_certificates(build: Build, tmp_path: Path) -> None:
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
        assert_same(build.on(workers), build_pog(build.source, GRID))
        plain = cluster.address.replace("tls://", "tcp://")
        with (
            pytest.raises(InputError, match=r"a scheduler that wants tls://|Connection reset"),
            cluster_workers(plain),
        ):
            pass
