"""A live view is for this machine alone: nothing but the loopback interface may listen for it."""

import socket
from pathlib import Path
from urllib.parse import urlsplit

import pytest
from pydrake.geometry import Meshcat

from a2s_drake.views.replay import start_meshcat

LOOPBACK = {"0100007F", "00000000000000000000000001000000", "0000000000000000FFFF00000100007F"}  # as /proc writes them
LISTENING = "0A"


@pytest.fixture
def meshcat() -> Meshcat:
    return start_meshcat(port=0)


def port_of(meshcat: Meshcat) -> int:
    url = urlsplit(meshcat.web_url())
    assert url.hostname in ("localhost", "127.0.0.1")
    assert url.port
    return url.port


def listening_addresses(port: int) -> set[str]:
    """Where sockets of this process listen on a port, as Linux writes addresses."""
    own = {str(link.readlink()) for link in Path("/proc/self/fd").iterdir() if link.is_symlink()}
    found = set()
    for table in ("/proc/net/tcp", "/proc/net/tcp6"):
        if Path(table).exists():
            for line in Path(table).read_text().splitlines()[1:]:
                _, local, _, state, *_, inode = line.split()[:10]
                address, _, local_port = local.partition(":")
                if state == LISTENING and int(local_port, 16) == port and f"socket:[{inode}]" in own:
                    found.add(address)
    return found


@pytest.mark.skipif(not Path("/proc/net/tcp").exists(), reason="Linux tells where a socket listens")
def test_a_live_view_listens_on_the_loopback_interface_alone(meshcat: Meshcat) -> None:
    addresses = listening_addresses(port_of(meshcat))
    assert addresses
    assert addresses <= LOOPBACK


def other_address() -> str | None:
    """An address of this machine that others could reach it by; None where there is none."""
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
        try:
            probe.connect(("192.0.2.1", 9))  # of a network that does not exist; no packet is sent
        except OSError:
            return None
        address = probe.getsockname()[0]
    return None if address.startswith("127.") else address


def test_a_live_view_is_not_served_to_other_machines(meshcat: Meshcat) -> None:
    address = other_address()
    if address is None:
        pytest.skip("this machine has only a loopback interface")
    for host, answers in (("127.0.0.1", True), (address, False)):
        with socket.socket() as client:
            client.settimeout(5.0)
            assert (client.connect_ex((host, port_of(meshcat))) == 0) == answers
