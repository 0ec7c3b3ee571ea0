"""Only the page itself, at the address where it is served, gets answers; no other page of a browser does."""

from __future__ import annotations

import platform
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

LOOPBACK = ("127.0.0.1", "localhost", "::1")
FORBIDDEN = 403  # status of a request that is refused
HTTP_PORT = 80  # which browsers leave out
ALL_ADDRESSES = ("0.0.0.0", "::")  # as a person may ask for


@contextmanager
def own_pages_only(host: str) -> Iterator[None]:
    """Let viser's server, if it is started in this block, answer only its own page (`refusal`).

    Any page in the same browser can open a WebSocket to this machine, and a name of its own can lead here
    (DNS rebinding). viser passes no check on, so websockets' function that it calls is replaced meanwhile.
    Raises RuntimeError where viser did not call it.
    """
    from websockets.asyncio import server as websockets

    serve_any, calls = websockets.serve, list[bool]()

    def serve_own(*arguments: Any, process_request: Callable[[Any, Any], Any], **options: Any) -> Any:
        def respond(connection: Any, request: Any) -> Any:
            address = connection.local_address
            if rule := refusal(request.headers, host, address[0], address[1]):
                return connection.respond(FORBIDDEN, f"{rule}\n")
            return process_request(connection, request)

        calls.append(True)
        return serve_any(*arguments, process_request=respond, **options)

    websockets.serve = serve_own  # type: ignore[assignment,misc]
    try:
        yield
    finally:
        websockets.serve = serve_any  # type: ignore[misc]
    if not calls:
        raise RuntimeError("this version of viser starts its server another way: requests cannot be checked")


def refusal(headers: Any, host: str, reached: str, port: int) -> str:
    """Return why a request is not answered, "" for one that is.

    `Host` must be this machine, `host`, or the address `reached` that the request came in at, each with the
    port. `Origin` must be that same address; a page of another one, or a WebSocket without any, is refused.
    """
    names = {*LOOPBACK, host.lower(), reached.lower().removeprefix("::ffff:")}
    if host in ALL_ADDRESSES:
        names.add(platform.node().lower())
    addresses = {f"{bracketed(name)}:{port}" for name in names}
    if port == HTTP_PORT:
        addresses |= {bracketed(name) for name in names}
    hosts, origins = headers.get_all("Host"), headers.get_all("Origin")
    if len(hosts) != 1 or hosts[0].lower() not in addresses:
        return f"Host: must be one of {', '.join(sorted(addresses))}; --host adds a name"
    opens = any("websocket" in value.lower() for value in headers.get_all("Upgrade"))
    if (origins or opens) and [origin.lower() for origin in origins] != [f"http://{hosts[0].lower()}"]:
        return f"Origin: must be http://{hosts[0].lower()}, the page's own"
    return ""


def bracketed(host: str) -> str:
    """Return a host as an address has it: an IPv6 number in brackets."""
    return f"[{host}]" if ":" in host else host
