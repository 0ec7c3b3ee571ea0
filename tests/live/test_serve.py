"""The address of a page, and the command as a process."""

from __future__ import annotations

import random
import signal
import socket
import subprocess
import sys
from collections.abc import Iterator

import pytest
import viser

import skincad
from skincad.base import InputError
from skincad.live import Page, free_port, guard, serve
from tests.processes import started


def test_a_taken_port_gives_way_to_the_next() -> None:
    with socket.socket() as listener:
        listener.bind(("127.0.0.1", 0))
        listener.listen()
        port = listener.getsockname()[1]
        assert port < free_port("127.0.0.1", port) <= port + serve.TRIES


@pytest.mark.parametrize(
    ("host", "port", "says"),
    [
        ("no.such.host.invalid", 8642, "host: is no"),
        ("127.0.0.1", 70000, "port: must"),
        ("127.0.0.1", -1, "port: must"),
    ],
)
def test_what_cannot_be_listened_at_is_told(host: str, port: int, says: str) -> None:
    with pytest.raises(InputError, match=says):
        free_port(host, port)


def test_the_missing_extra_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(serve, "find_spec", lambda _: None)
    with pytest.raises(InputError, match=r"pip install 'skincad\[live\]'"):
        serve.serve(skincad.load("plain-ridges"), "plain-ridges", "127.0.0.1", 0, browser=False, say=print)


@pytest.mark.slow
def test_ctrl_c_ends_it_with_130_and_nothing_else_is_printed() -> None:
    words = [sys.executable, "-m", "skincad", "live", "plain-ridges", "--port", "0"]
    with started(words, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as process:
        assert process.stdout is not None
        line = process.stdout.readline()
        process.send_signal(signal.SIGINT)
        out, err = process.communicate(timeout=60)
    assert line.startswith("plain-ridges: http://127.0.0.1:")
    assert (process.returncode, out, err) == (130, "", "skincad: interrupted\n")


@pytest.fixture(scope="module")
def port() -> Iterator[int]:
    page = Page(skincad.load("plain-ridges"), "plain-ridges", "127.0.0.1", free_port("127.0.0.1", 0))
    yield page.server.get_port()
    page.close()


def status(port: int, *headers: str, opens: bool) -> int:
    """What the server answers to a request, or to a WebSocket's handshake as the page makes it."""
    lines = ["GET / HTTP/1.1", *headers]
    if opens:
        lines += ["Upgrade: websocket", "Connection: Upgrade", "Sec-WebSocket-Version: 13"]
        lines += [
            "Sec-WebSocket-Key: " + "A" * 22 + "==",
            f"Sec-WebSocket-Protocol: viser-v{viser.__version__}",
        ]
    with socket.create_connection(("127.0.0.1", port), timeout=30) as line:
        line.sendall(("\r\n".join(lines) + "\r\n\r\n").encode())
        return int(line.recv(65536).split()[1])


@pytest.mark.parametrize("name", ["127.0.0.1", "localhost", "[::1]", "LocalHost"])
def test_the_page_itself_is_answered(name: str, port: int) -> None:
    host, origin = f"Host: {name}:{port}", f"Origin: http://{name}:{port}"
    assert [status(port, host, opens=False), status(port, host, origin, opens=False)] == [200, 200]
    assert status(port, host, origin, opens=True) == 101


def test_other_pages_and_names_that_lead_here_are_refused(port: int) -> None:
    """Pages of other origins, of another port of this machine, of none; names that lead here; two at once."""
    dice, address = random.Random(19), f"127.0.0.1:{port}"
    others = [
        "evil.example",
        "localhost.evil.example",
        "127.0.0.1.evil.example",
        "10.0.0.7",
        "[::2]",
        "localhost.",
    ]
    ends = ["", f":{port}", f":{port + 1}", f":{port}0"]
    foreign = [name + end for name in others for end in ends] + ["localhost", f"localhost:{port + 1}", ""]
    for host in dice.sample(foreign, 12):  # its own origin, as a browser that was misled sends it
        assert status(port, f"Host: {host}", f"Origin: http://{host}", opens=True) == 403
        assert status(port, f"Host: {host}", opens=False) == 403
    origins = [f"http://{host}" for host in foreign] + [
        f"https://{address}",
        f"http://{address}/",
        "null",
        "",
        address,
    ]
    for origin in [*dice.sample(origins, 12), "null", f"http://localhost:{port}"]:
        assert status(port, f"Host: {address}", f"Origin: {origin}", opens=True) == 403
    assert status(port, f"Host: {address}", opens=True) == 403  # a browser says where a page is from
    good = f"Host: {address}", f"Origin: http://{address}"
    assert status(port, *good, "Origin: http://evil.example", opens=True) == 403
    assert status(port, *good, "Host: evil.example", opens=True) in (400, 403)


def test_host_adds_a_name() -> None:
    """A page is reached by the name that --host gives; on all addresses, by the one that was used."""

    class Headers(dict[str, str]):
        def get_all(self, name: str) -> list[str]:
            return [self[name]] if name in self else []

    def answered(host: str, listens: str, reached: str = "192.0.2.7", port: int = 8642) -> bool:
        page = Headers(Host=host, Origin=f"http://{host}", Upgrade="websocket")
        return not guard.refusal(page, listens, reached, port)

    assert answered("bench.lan:8642", "bench.lan")
    assert not answered("bench.lan:8642", "127.0.0.1", "127.0.0.1")
    assert answered("192.0.2.7:8642", "0.0.0.0")
    assert answered("192.0.2.7:8642", "::", "::ffff:192.0.2.7")
    assert answered("[2001:db8::7]:8642", "::", "2001:db8::7")
    assert not answered("192.0.2.8:8642", "0.0.0.0")
    assert answered(f"{socket.gethostname()}:8642", "0.0.0.0")
    assert answered("bench.lan", "bench.lan", port=80)  # which browsers leave out


def test_a_server_that_cannot_be_checked_is_a_fault() -> None:
    with pytest.raises(RuntimeError, match="cannot be checked"), guard.own_pages_only("127.0.0.1"):
        pass
