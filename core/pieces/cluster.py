"""Run workers on a Dask cluster, on as many machines as it has.

The cluster that a user names is trusted, as Dask is made for: every participant can run code on all the others
(docs/security.md). Dask gives a piece whose worker dies to another one. Every wait has a time limit.
"""

from __future__ import annotations

import asyncio
import contextlib
import logging
import re
import socket
import ssl
import threading
import time
from collections.abc import Callable, Collection, Iterator
from concurrent.futures import CancelledError, Future
from contextlib import contextmanager
from typing import Any, NamedTuple, TypeVar
from urllib.parse import urlsplit

from riglens.core.errors import InputError
from riglens.version import installed_version

Result = TypeVar("Result")


class Limits(NamedTuple):
    """Timeouts in seconds: for a scheduler and its first worker, for an answer, for new workers."""

    connect_s: float = 10.0
    silent_s: float = 60.0
    without_workers_s: float = 60.0


LIMITS = Limits()
_POLL_S, _LOOK_S = 0.05, 2.0
"""Seconds between checks for finished pieces, and between checks that the scheduler still has workers."""
_ADDRESS = re.compile(r"(tcp|tls)://[^\s/]+:\d{1,5}")
_NUDGE = b"?\r\n\r\n"
"""Makes servers of other protocols answer at once. Shorter than the 8-byte header of a message to Dask, so that a
scheduler keeps waiting."""
_GREETING_BYTES, _GREETING_HOLDS = 1 << 16, b"pickle-protocol"
_KEPT = "finished parts are kept: run the same command again"


class ClusterWorkers:
    """The workers of a cluster."""

    def __init__(self, client: Any, count: int, address: str, limits: Limits = LIMITS) -> None:
        self.ahead = 2 * count
        self.threads: int | None = None
        self._client, self._address, self._limits = client, address, limits
        self._tasks = dict[Future[bytes], Any]()
        self._bare_since_s: float | None = None

    def call(self, work: Callable[..., bytes], *arguments: object) -> Future[bytes]:
        """Start a call on some worker; `wait` returns when the result is there."""
        future = Future[bytes]()
        try:
            self._tasks[future] = self._client.submit(
                _called, installed_version(), work, *arguments, pure=False
            )
        except Exception as error:  # the client has closed itself, which is told in a dozen ways
            raise self._lost(f"takes no more work ({type(error).__name__})") from error
        return future

    def wait(self, waiting: Collection[Future[bytes]]) -> set[Future[bytes]]:
        """Wait for one of the futures at least, and return those that are done.

        Raise ChildProcessError when the scheduler stops answering or is without workers for too long.
        """
        looked_s = time.monotonic()
        while not (done := {future for future in waiting if self._is_over(future)}):
            time.sleep(_POLL_S)
            if time.monotonic() - looked_s >= min(_LOOK_S, self._limits.without_workers_s):
                self._require_alive()
                looked_s = time.monotonic()
        for future in done:
            try:
                future.set_result(self._content(self._tasks.pop(future)))
            except Exception as error:
                future.set_exception(error)
        return done

    def _is_over(self, future: Future[bytes]) -> bool:
        return self._tasks[future].status in ("finished", "error", "cancelled")

    def _content(self, task: Any) -> bytes:
        """Return a finished piece; InputError when the worker could not read its input."""
        try:
            answer = _within(self._limits.silent_s, task.result)
        except InputError as error:
            raise InputError(f"on worker {_line(str(error))}", "dask") from error
        except (CancelledError, asyncio.CancelledError) as error:  # what tasks of a lost scheduler raise
            raise self._lost("went away") from error
        except TimeoutError as error:
            raise self._lost(
                f"sent no result within {self._limits.silent_s:g} s (have its workers gone?)"
            ) from error
        except Exception as error:
            if task.status != "error":  # it was made, but did not arrive
                raise self._lost(f"went away ({type(error).__name__})") from error
            if type(error).__name__ == "KilledWorker":
                raise self._lost("lost several workers over the same piece (out of memory?)") from error
            raise self._lost(f"could not do its work ({_line(error)})") from error
        if not isinstance(answer, bytes):
            raise self._lost("returned no bytes (do its workers run this version of RigLens?)")
        return answer

    def _require_alive(self) -> None:
        try:
            workers = _within(self._limits.silent_s, lambda: self._client.sync(self._client.scheduler.ncores))
        except TimeoutError as error:
            raise self._lost(f"has not answered for {self._limits.silent_s:g} s") from error
        except Exception as error:  # the connection is lost, or the client has given up and closed itself
            raise self._lost("went away") from error
        now_s = time.monotonic()
        if workers:
            self._bare_since_s = None
        elif self._bare_since_s is None:
            self._bare_since_s = now_s
        elif now_s - self._bare_since_s >= self._limits.without_workers_s:
            raise self._lost(f"has had no workers for {self._limits.without_workers_s:g} s")

    def _lost(self, what: str) -> ChildProcessError:
        return ChildProcessError(f"the Dask cluster at {self._address} {what}; {_KEPT}")


@contextmanager
def cluster_workers(address: str, limits: Limits = LIMITS) -> Iterator[ClusterWorkers]:
    """Yield the workers of the cluster whose scheduler is at `address`, tcp:// or tls://HOST:PORT, while the block
    runs.

    Raises InputError when Dask is not installed, certificates are missing or nothing answers in time,
    ChildProcessError when the cluster goes away or several workers died of the same piece.
    """
    if not _ADDRESS.fullmatch(address):
        raise InputError(f"must be tcp://HOST:PORT or tls://HOST:PORT (got '{address}')", "dask")
    distributed = _distributed()
    with _quiet():
        client = _client(distributed, address, limits)
        try:
            yield ClusterWorkers(client, _count_workers(client, address, limits), address, limits)
        finally:
            with contextlib.suppress(Exception):
                _within(limits.connect_s, client.close)


def is_unencrypted(address: str) -> bool:
    """Return whether messages to a scheduler cross a network as they are."""
    where = urlsplit(address)
    host = where.hostname or ""
    return where.scheme == "tcp" and not (host in ("localhost", "::1") or host.startswith("127."))


def _client(distributed: Any, address: str, limits: Limits) -> Any:
    where = urlsplit(address)
    certificates = _certificates(distributed) if where.scheme == "tls" else None
    try:
        # Dask's own client believes any length that it is sent, and leaves its thread behind when nobody answers
        plain = socket.create_connection((where.hostname or "", where.port or 0), limits.connect_s)
        with certificates.wrap_socket(plain) if certificates else plain as connection:
            _require_greeting(connection)
        return _within(
            limits.connect_s,
            lambda: distributed.Client(address, timeout=limits.connect_s, set_as_default=False),
        )
    except Exception as error:  # whatever listens there may send anything
        in_time = f"not within {limits.connect_s:g} s"
        other = in_time if isinstance(error, TimeoutError | ValueError) else _line(error)
        reason = getattr(error, "strerror", None) or other
        raise InputError(f"finds no scheduler at {address} ({reason})", "dask") from error


def _require_greeting(connection: socket.socket) -> None:
    """Raise OSError unless the first message is of a size and content with which Dask greets."""
    connection.sendall(_NUDGE)
    size = int.from_bytes(_received(connection, 8), "little")
    if not 8 <= size <= _GREETING_BYTES or _GREETING_HOLDS not in _received(connection, size):
        raise ConnectionError(
            None, "another program than Dask listens there, or a scheduler that wants tls://"
        )


def _received(connection: socket.socket, size: int) -> bytes:
    """Return the next bytes, fewer where the connection ends; TimeoutError when they do not come in time."""
    end_s = time.monotonic() + (connection.gettimeout() or 0.0)
    found = b""
    while len(found) < size and (more := connection.recv(size - len(found))):
        found += more
        if time.monotonic() > end_s:
            raise TimeoutError
    return found


def _certificates(distributed: Any) -> ssl.SSLContext:
    """Return Dask's own settings for encrypted connections; InputError when there are none."""
    try:
        context = distributed.Security().get_connection_args("client").get("ssl_context")
    except Exception as error:
        raise InputError(f"cannot use the certificates for tls://: {_line(error)}", "dask") from error
    if not isinstance(context, ssl.SSLContext):
        raise InputError(
            "needs certificates for tls://: name them in DASK_DISTRIBUTED__COMM__TLS__CA_FILE, "
            "DASK_DISTRIBUTED__COMM__TLS__CLIENT__CERT and DASK_DISTRIBUTED__COMM__TLS__CLIENT__KEY",
            "dask",
        )
    return context


def _count_workers(client: Any, address: str, limits: Limits) -> int:
    end_s = time.monotonic() + limits.connect_s
    while True:
        try:
            workers = _within(limits.connect_s, lambda: client.sync(client.scheduler.ncores))
        except Exception as error:
            raise InputError(f"lost the scheduler at {address}, which no longer answers", "dask") from error
        if workers:
            return len(workers)
        if time.monotonic() >= end_s:
            raise InputError(f"finds no workers at the scheduler at {address}", "dask")
        time.sleep(_POLL_S)


def _called(version: str, work: Callable[..., bytes], *arguments: object) -> bytes:
    """Call a function on a worker; errors that the user can mend say on which machine they happened.

    Raise InputError where RigLens is of another version: its pieces may differ without a trace.
    """
    try:
        if (own := installed_version()) != version:
            raise InputError(f"RigLens must be the version of this command, {version} (got {own})")
        return work(*arguments)
    except (InputError, OSError) as error:
        raise InputError(f"{socket.gethostname()}: {error}") from error
    except MemoryError as error:
        raise InputError(f"{socket.gethostname()}: out of memory; give its workers more") from error


def _within(limit_s: float, call: Callable[[], Result]) -> Result:
    """Return what `call` returns; TimeoutError when that takes longer. Dask's own limits do not hold everywhere."""
    result = Future[Result]()

    def run() -> None:
        try:
            result.set_result(call())
        except BaseException as error:
            result.set_exception(error)

    threading.Thread(target=run, daemon=True).start()
    return result.result(limit_s)


@contextmanager
def _quiet() -> Iterator[None]:
    """Suppress Dask's tracebacks for errors that are reported in one line here."""
    before = logging.root.manager.disable
    logging.disable(logging.CRITICAL)
    try:
        yield
    finally:
        logging.disable(before)


def _line(what: object) -> str:
    """Return an error or a worker's text as one short line of printable characters."""
    text = f"{type(what).__name__}: {what}" if isinstance(what, BaseException) else str(what)
    return "".join(sign if sign.isprintable() else " " for sign in text)[:500].strip()


def _distributed() -> Any:
    try:
        import distributed
    except ImportError as error:
        raise InputError(
            "needs the package distributed; install it with: pip install 'riglens[cluster]'", "dask"
        ) from error
    return distributed
