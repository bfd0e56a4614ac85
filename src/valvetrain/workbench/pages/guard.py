"""Checks before every request: address, token, Host and Origin, bounds and headers."""

from __future__ import annotations

import base64
import hashlib
import hmac
import ipaddress
import re
import secrets
import time
from asyncio import wait_for
from collections import deque
from collections.abc import Iterable
from urllib.parse import urlencode, urlsplit

from starlette.datastructures import MutableHeaders
from starlette.requests import HTTPConnection
from starlette.responses import PlainTextResponse, RedirectResponse, Response
from starlette.types import ASGIApp, Message, Receive, Scope, Send
from starlette.websockets import WebSocketClose

from valvetrain.workbench.settings import ServeSettings, check_settings, is_loopback

_SCRIPT = re.compile(rb"<script\b([^>]*)>(.*?)</script>", re.DOTALL | re.IGNORECASE)
_DATA = re.compile(rb"""\btype\s*=\s*["']?application/json""", re.IGNORECASE)
#: On every answer.
HEADERS = {
    "x-content-type-options": "nosniff",
    "x-frame-options": "DENY",
    "referrer-policy": "no-referrer",
    "cross-origin-opener-policy": "same-origin",
    "cross-origin-resource-policy": "same-origin",
    "permissions-policy": "camera=(), geolocation=(), microphone=(), payment=(), usb=()",
}


def content_security_policy(host: str, page: bytes = b"") -> str:
    """The policy of one answer.

    ``host``: name and port by which the browser called; ``page``: its HTML, of whose own scripts
    each is let run by its hash, and none
    that gets into the page later. The framework of the pages compiles its templates in the browser,
    which takes ``unsafe-eval``, and sets
    styles on elements.

    >>> "script-src 'self' 'unsafe-eval';" in content_security_policy("127.0.0.1:8420")
    True
    """
    scripts = " ".join(("'self'", "'unsafe-eval'", *script_hashes(page)))
    return "; ".join(
        (
            "default-src 'self'",
            f"script-src {scripts}",
            "script-src-attr 'none'",
            "style-src 'self' 'unsafe-inline'",
            "img-src 'self' data: blob:",
            "font-src 'self' data:",
            "media-src 'self' blob:",
            "worker-src 'self' blob:",
            f"connect-src 'self' ws://{host} wss://{host}",
            "object-src 'none'",
            "base-uri 'none'",
            "form-action 'self'",
            "frame-src 'none'",
            "frame-ancestors 'none'",
        )
    )


def script_hashes(page: bytes) -> Iterable[str]:
    """The hash of each script in a page, as a policy names it.

    >>> list(script_hashes(b"<script>1</script><script src='/a.js'></script>"))
    ["'sha256-a4ayc/80/OGda4BO/1o/V0etpOqiLx1JwB5S3beHW0s='"]
    """
    found = (
        match[2]
        for match in _SCRIPT.finditer(page)
        if match[2].strip() and not _DATA.search(match[1])
    )
    digests = (hashlib.sha256(text.replace(b"\r\n", b"\n")).digest() for text in found)
    return dict.fromkeys(f"'sha256-{base64.b64encode(one).decode()}'" for one in digests)


#: The cookie that stands for the token, with the port behind it: browsers share cookies between the
#: ports of a host.
COOKIE = "valvetrain"
#: How long (s) a browser is known; wrong tokens in a minute after which none is looked at.
KNOWN_FOR, MAX_WRONG = 12 * 3600, 20
#: How long (s) a body may take to arrive.
BODY_TIME = 30.0
#: Largest page that is read for its scripts (bytes).
_MAX_PAGE = 50_000_000
_METHODS = ("GET", "HEAD", "POST", "OPTIONS")
_HARMLESS = ("GET", "HEAD", "OPTIONS")
#: Headers that a request has once at most.
_SINGLE = ("host", "origin", "content-length", "sec-fetch-site", "sec-fetch-mode")


class Rate:
    """At most ``most`` events in ``seconds``.

    >>> rate = Rate(1, 60.0)
    >>> rate.take(), rate.take()
    (True, False)
    """

    def __init__(self, most: int, seconds: float) -> None:
        self.most, self.seconds = most, seconds
        self._seen: deque[float] = deque()

    def take(self) -> bool:
        """Count an event; whether it is still within the bound."""
        now = time.monotonic()
        while self._seen and now - self._seen[0] > self.seconds:
            self._seen.popleft()
        if within := len(self._seen) < self.most:
            self._seen.append(now)
        return within


class Guard:
    """ASGI middleware that lets through what ``settings`` allow and puts the headers of security on
    every answer.

    Parameters
    ----------
    app : what is behind it
    settings : address, token and bounds
    """

    def __init__(self, app: ASGIApp, settings: ServeSettings) -> None:
        self.app, self.settings = app, check_settings(settings)
        self.cookie, self._mark = f"{COOKIE}-{settings.port}", secrets.token_urlsafe(24)
        self._wrong = Rate(MAX_WRONG, 60.0)
        self._sockets = self._requests = 0

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """One request."""
        if scope["type"] == "websocket":
            await self._socket(scope, receive, send)
        elif scope["type"] == "http":
            sender = _Sender(scope, send)
            answer = self._refused(HTTPConnection(scope))
            if answer is not None:
                await answer(scope, receive, sender.send)
            else:
                await self._answer(scope, receive, sender)
        else:
            await self.app(scope, receive, send)

    async def _socket(self, scope: Scope, receive: Receive, send: Send) -> None:
        visit = HTTPConnection(scope)
        refused = self._refusal(visit, "origin" in visit.headers)
        if not refused and not self._is_known(visit):
            refused = "this server requires its token"
        if refused or self._sockets >= self.settings.most_sessions:
            await receive()
            code, reason = (1008, refused) if refused else (1013, "too many pages are open")
            await WebSocketClose(code, reason)(scope, receive, send)
            return

        async def bounded() -> Message:
            message = await receive()
            size = len(message.get("text") or "") + len(message.get("bytes") or b"")
            if size > self.settings.most_body:
                return {"type": "websocket.disconnect", "code": 1009}
            return message

        self._sockets += 1
        try:
            await self.app(scope, bounded, send)
        finally:
            self._sockets -= 1

    def _refused(self, visit: HTTPConnection) -> Response | None:
        """The answer to a request that is not let through, or that shows the token; None for another."""
        method, headers = visit.scope["method"], visit.headers
        declared = method in _HARMLESS or "origin" in headers or "sec-fetch-site" in headers
        length = headers.get("content-length", "0")
        if method not in _METHODS:
            return refusal(405, "this server answers GET, HEAD and POST only")
        if reason := self._refusal(visit, declared):
            return refusal(403, reason)
        if not length.isdecimal() or len(length) > 15 or int(length) > self.settings.most_body:
            return self._too_large
        if self._requests >= self.settings.most_requests:
            return refusal(503, "too many requests at a time; try again in a moment")
        token = visit.query_params.get("token")
        if token and self.settings.token and _same(token, self.settings.token):
            return self._admitted(visit)
        if self._is_known(visit):
            return None
        if token is not None and not self._wrong.take():
            return refusal(429, "too many wrong tokens; wait a minute")
        where = "open the address that 'valvetrain serve' printed"
        return refusal(401, f"this server requires its token: {where}")

    @property
    def _too_large(self) -> Response:
        most = f"{self.settings.most_body / 1e6:.3g} MB"
        return refusal(413, f"what was sent is larger than {most}, the most that is taken")

    async def _answer(self, scope: Scope, receive: Receive, sender: _Sender) -> None:
        """Let the request through, its body counted and its answer given the headers."""
        taken, whole, due = 0, False, time.monotonic() + BODY_TIME

        async def bounded() -> Message:
            nonlocal taken, whole
            try:
                message = await wait_for(receive(), None if whole else due - time.monotonic())
            except TimeoutError:
                raise _LateError from None
            whole = not message.get("more_body")
            taken += len(message.get("body") or b"")
            if taken > self.settings.most_body:
                raise _TooLargeError
            return message

        headers = MutableHeaders(scope=scope)
        if "text/html" in headers.get("accept", ""):
            del headers["accept-encoding"]  # a compressed page cannot be read for its scripts
        self._requests += 1
        try:
            await self.app(scope, bounded, sender.send)
        except _TooLargeError:
            await sender.refuse(self._too_large)
        except _LateError:
            late = "the rest of what was sent did not arrive; send it again"
            await sender.refuse(refusal(408, late))
        finally:
            self._requests -= 1

    def _admitted(self, visit: HTTPConnection) -> Response:
        """Give a visitor who showed the token its cookie, and an address without the token."""
        query = urlencode(
            {name: one for name, one in visit.query_params.items() if name != "token"}
        )
        place = visit.scope["path"].lstrip("/")  # two slashes would name another host
        answer = RedirectResponse(f"/{place}{'?' if query else ''}{query}", 303)
        secure = visit.scope.get("scheme") in ("https", "wss")
        answer.set_cookie(
            self.cookie, self._mark, KNOWN_FOR, httponly=True, samesite="strict", secure=secure
        )
        answer.headers["cache-control"] = "no-store"
        return answer

    def _is_known(self, visit: HTTPConnection) -> bool:
        """Whether no token is required, or the cookie is the one that is given for it."""
        return not self.settings.token or _same(visit.cookies.get(self.cookie, ""), self._mark)

    def _refusal(self, visit: HTTPConnection, is_declared: bool) -> str:
        """Why a request is refused before anything looks at it, empty where not; ``is_declared``: it says
        where it comes from, or need not.
        """
        headers, path = visit.headers, visit.scope["path"]
        twice = any(len(headers.getlist(name)) > 1 for name in _SINGLE)
        if twice or not self.is_own(headers.get("host", "")):
            return "this server is not called by that name; open the address that 'valvetrain serve' printed"
        site, mode = headers.get("sec-fetch-site", "none"), headers.get("sec-fetch-mode")
        followed = mode == "navigate" and visit.scope.get("method") == "GET"
        foreign = site not in ("none", "same-origin") and not followed
        if foreign or not self._same_origin(headers.get("origin"), headers["host"]):
            return "another site sent this request"
        if not is_declared:
            return "this request does not give its origin"
        # a path leads down only, however it is written, and holds nothing that a terminal obeys
        up = ".." in path.split("/") or not path.isprintable() or set("\\%") & set(path)
        return "this address leads nowhere" if up else ""

    def is_own(self, host: str) -> bool:
        """Whether a Host header names this server: one of its addresses or names with its port. A
        name that somebody else's name server
        leads here (DNS rebinding) does not."""
        try:
            parts = urlsplit(f"//{host}")
            name, port = (parts.hostname or "").lower(), parts.port
        except ValueError:
            return False
        if (
            not name
            or "@" in host
            or "/" in host
            or port not in (self.settings.port, None if self.settings.port == 80 else -1)
        ):
            return False
        if name == "localhost" or name in (
            self.settings.host.lower(),
            *(own.lower() for own in self.settings.names),
        ):
            return True
        try:
            address = ipaddress.ip_address(name)
        except ValueError:
            return False
        return address.is_loopback or not is_loopback(self.settings.host)

    @staticmethod
    def _same_origin(origin: str | None, host: str) -> bool:
        if origin is None:
            return True
        parts = urlsplit(origin)
        return (
            parts.scheme in ("http", "https")
            and parts.netloc.lower() == host.lower()
            and not parts.path
        )


class _TooLargeError(Exception):
    """A body went beyond the bound while it was read."""


class _LateError(Exception):
    """A body did not arrive in time."""


def refusal(status: int, sentence: str) -> Response:
    """The answer that refuses a request."""
    headers = {"cache-control": "no-store"}
    if status in (408, 413, 503):
        headers["connection"] = "close"
    return PlainTextResponse(f"{sentence[:1].upper()}{sentence[1:]}.\n", status, headers)


class _Sender:
    """Sends answers with the headers of security; a page is buffered until its scripts are known."""

    def __init__(self, scope: Scope, send: Send) -> None:
        host = HTTPConnection(scope).headers.get("host", "")
        self.scope, self._send = scope, send
        self.host = host if re.fullmatch(r"[\w.:\[\]-]+", host, re.ASCII) else "invalid"
        self._page: Message | None = None
        self._body, self._sent = b"", False

    async def send(self, message: Message) -> None:
        """Pass on a message of the answer."""
        if message["type"] == "http.response.start":
            headers = MutableHeaders(scope=message)
            is_page = headers.get("content-type", "").startswith("text/html")
            small = int(headers.get("content-length", "0")) <= _MAX_PAGE
            if is_page and small and "content-encoding" not in headers:
                self._page = message
                return
            self._protect(message, b"")
        elif self._page is not None:
            self._body += message.get("body", b"")
            if message.get("more_body") and len(self._body) <= _MAX_PAGE:
                return
            page, self._page = self._page, None
            self._protect(page, self._body)
            await self._send(page)
            message = {**message, "body": self._body}
        await self._send(message)

    def _protect(self, message: Message, page: bytes) -> None:
        self._sent = True
        policy = content_security_policy(self.host, page)
        MutableHeaders(scope=message).update({**HEADERS, "content-security-policy": policy})

    async def refuse(self, answer: Response) -> None:
        """Send a refusal; nothing where an answer has begun."""
        if not self._sent:
            self._page = None
            await answer(self.scope, _nothing, self.send)


async def _nothing() -> Message:
    return {"type": "http.disconnect"}


def _same(given: str, due: str) -> bool:
    """Whether two texts are the same, compared in the same time however much of them is."""
    return hmac.compare_digest(given.encode("utf-8", "replace"), due.encode())
