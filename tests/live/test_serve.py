"""The address of a page, and the command as a process."""

from __future__ import annotations

import os
import signal
import socket
import subprocess
import sys

import pytest

import skincad
from skincad.base.errors import InputError
from skincad.live import serve
from skincad.live.serve import free_port


def test_a_taken_port_gives_way_to_the_next() -> None:
    with socket.socket() as taken:
        taken.bind(("127.0.0.1", 0))
        taken.listen()
        port = taken.getsockname()[1]
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


def test_ctrl_c_ends_it_with_130_and_nothing_else_is_printed() -> None:
    words = [sys.executable, "-m", "skincad", "live", "plain-ridges", "--port", "0"]
    pipes = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE, "text": True}
    with subprocess.Popen(words, env=dict(os.environ), **pipes) as process:  # type: ignore[call-overload]
        line = process.stdout.readline()
        process.send_signal(signal.SIGINT)
        out, err = process.communicate(timeout=60)
    assert line.startswith("plain-ridges: http://127.0.0.1:")
    assert (process.returncode, out, err) == (130, "", "skincad: interrupted\n")
