"""A cluster that is not there, and addresses that are none, end in one line."""

import socket

import pytest

from riglens.core.errors import InputError
from riglens.core.scene.pog_cluster import cluster_workers


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
