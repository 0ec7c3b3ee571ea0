"""Where a page is served: an address that is free, until somebody ends it."""

from __future__ import annotations

import socket
import webbrowser
from collections.abc import Callable
from importlib.util import find_spec
from time import sleep

from skincad.base.errors import InputError
from skincad.base.interrupt import safe_point
from skincad.live.guard import LOOPBACK, bracketed
from skincad.live.session import Editable

PORT = 8642  # where nobody says another
TRIES = 100  # ports from the wanted one on
FIRST_PICTURE_TIMEOUT = 60.0  # s, for the first picture
POLL = 0.1  # s, until Ctrl-C ends it


def serve(
    subject: Editable, source: str, host: str, port: int, *, browser: bool, say: Callable[[str], None]
) -> None:
    """Serve the page of a design or scene until Ctrl-C; `say` gets its address.

    Raises InputError for a host or port that cannot be listened at, and without the package.
    """
    if find_spec("viser") is None:
        raise InputError("live", "needs the package viser", remedy="pip install 'skincad[live]'")
    from skincad.live.page import Page
    from skincad.live.worker import preload

    free = free_port(host, port)
    preload()
    page = Page(subject, source, host, free)
    try:
        page.desk.wait_until_drawn(FIRST_PICTURE_TIMEOUT)
        address = f"http://{bracketed(host)}:{free}"
        say(f"{subject.name}: {address} (Ctrl-C ends it)")
        if host not in LOOPBACK:
            say(f"Whoever reaches {host} can change it and write files here.")
        if browser:
            webbrowser.open(address)
        while True:
            safe_point()
            sleep(POLL)
    finally:
        page.close()


def free_port(host: str, port: int) -> int:
    """Return the first port from `port` on that nobody listens at; any free one for 0."""
    if not 0 <= port < 2**16:
        raise InputError("port", "must be from 0 to 65535", port)
    for candidate in range(port, min(port + TRIES, 2**16)):
        try:
            kind = socket.getaddrinfo(host, candidate, type=socket.SOCK_STREAM)[0][0]
            with socket.socket(kind, socket.SOCK_STREAM) as listener:
                listener.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
                listener.bind((host, candidate))
                return int(listener.getsockname()[1])
        except (socket.gaierror, UnicodeError) as failure:
            raise InputError("host", f"is no address here ({failure})", host, "leave it out") from None
        except OSError as failure:
            trouble = failure
    rule = f"cannot be listened at, nor the {TRIES} after it ({trouble.strerror or trouble})"
    raise InputError("port", rule, port, "name another port or host")
