"""Who may open a page on this machine: a browser here, at an address of this machine, that knows the page's token.

A server on 127.0.0.1 can be reached by every page that the browser shows: by a request of another origin, and by a name
that another server resolves to 127.0.0.1 (DNS rebinding). The origin and the host of a request give both away, and the
token keeps out other users of the machine.

References
----------
RFC 6455, sections 4.2.2 and 10.2: a server of WebSockets must itself refuse handshakes of other origins.
"""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from hmac import compare_digest
from http import HTTPStatus
from secrets import token_urlsafe
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from websockets.asyncio.server import ServerConnection
    from websockets.http11 import Request, Response

    Handler = Callable[[ServerConnection, Request], Response | None]

HERE = ("127.0.0.1", "localhost")
#: What a browser is told about each answer: not to be framed, not to be read by others, not to hand on the address.
HEADERS = {
    "Content-Security-Policy": "frame-ancestors 'none'",
    "Cross-Origin-Resource-Policy": "same-origin",
    "Referrer-Policy": "no-referrer",
    "X-Content-Type-Options": "nosniff",
}
REFUSED = "This page opens only at the whole address that the command printed, with its token.\n"
_STARTING = threading.Lock()


@dataclass(frozen=True)
class Guard:
    """The token of one page, and the check of every request for it.

    Attributes
    ----------
    token : str
        The first part of the path of every request.
    head : str
        HTML that goes into the head of the page, in place of the title that it has.
    """

    token: str = field(default_factory=lambda: token_urlsafe(24))
    head: str = ""

    def address(self, port: int) -> str:
        """Return where a browser finds the page.

        Parameters
        ----------
        port : int
            Of the server.

        Returns
        -------
        str
            With the token.
        """
        return f"http://{HERE[0]}:{port}/{self.token}/"

    def admits(self, path: str, port: int, host: str | None, origin: str | None, *, handshake: bool) -> bool:
        """Say whether a request is one of the page that was printed.

        Parameters
        ----------
        path : str
            Of the request, with the token in front.
        port : int
            At which the request arrived.
        host, origin : str or None
            What the request says of itself. A browser sends the origin with every handshake of a WebSocket.
        handshake : bool
            Whether the request opens a WebSocket.

        Returns
        -------
        bool
            False for a request to be refused.

        Examples
        --------
        >>> guard = Guard("secret")
        >>> guard.admits("/secret/", 8321, "localhost:8321", None, handshake=False)
        True
        >>> guard.admits("/secret", 8321, "localhost:8321", "https://example.org", handshake=True)
        False
        """
        hosts = [f"{name}:{port}" for name in HERE]
        known = origin in [f"http://{name}" for name in hosts] or (origin is None and not handshake)
        token = path.partition("?")[0].removeprefix("/").partition("/")[0]
        return host in hosts and known and compare_digest(token.encode(), self.token.encode())

    def around(self, handler: Handler | None) -> Handler:
        """Return a handler of requests that refuses those of others and hands the rest on without the token.

        Parameters
        ----------
        handler : callable or None
            What answers a request; None for handshakes alone.

        Returns
        -------
        callable
            As `process_request` of `websockets.asyncio.server.serve`.
        """

        def guarded(connection: ServerConnection, request: Request) -> Response | None:
            headers, port = request.headers, connection.local_address[1]
            given = {name: headers.get_all(name) for name in ("Host", "Origin")}
            host, origin = (values[0] if len(values) == 1 else None for values in given.values())
            handshake = "Upgrade" in headers
            if len(given["Origin"]) > 1 or not self.admits(request.path, port, host, origin, handshake=handshake):
                return connection.respond(HTTPStatus.FORBIDDEN, REFUSED)
            request.path = "/" + request.path.removeprefix(f"/{self.token}").removeprefix("/")
            if not handshake:
                request.headers.pop("Accept-Encoding", None)  # the head is put into plain text
            response = handler(connection, request) if handler is not None else None
            if response is not None:
                self._dress(response)
                for name, value in HEADERS.items():
                    response.headers[name] = value
            return response

        return guarded

    def _dress(self, response: Response) -> None:
        """Put the head into an answer that is a page."""
        if response.headers.get("Content-Type", "").startswith("text/html") and self.head:
            before, _, rest = response.body.decode().partition("<title>")
            response.body = (before + self.head + rest.partition("</title>")[2]).encode()
            del response.headers["Content-Length"]
            response.headers["Content-Length"] = str(len(response.body))

    @contextmanager
    def over_the_next_server(self) -> Iterator[None]:
        """Guard the server of WebSockets that starts in the body of a `with` statement.

        viser has no option for a check of requests, and asks `websockets` for its server by this name. One server
        starts at a time.
        """
        from websockets.asyncio import server

        serve: Any = server.serve

        def guarded(*arguments: Any, process_request: Handler | None = None, **options: Any) -> Any:
            return serve(*arguments, process_request=self.around(process_request), **options)

        with _STARTING:
            server.serve = guarded  # type: ignore[misc,assignment]
            try:
                yield
            finally:
                server.serve = serve  # type: ignore[misc]
