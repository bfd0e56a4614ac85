"""Checks before every request: address, token, Host and Origin, bounds and headers. Plain
ASGI, whatever framework is behind it.
"""

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
from collections.abc import Awaitable, Callable, Iterable, MutableMapping
from http.cookies import CookieError, SimpleCookie
from typing import Any
from urllib.parse import parse_qsl, urlencode, urlsplit

from valvetrain.errors import InputError
from valvetrain.workbench.settings import ServeSettings

_SCRIPT = re.compile(rb"<script\b([^>]*)>(.*?)</script>", re.DOTALL | re.IGNORECASE)
_DATA = re.compile(rb"""\btype\s*=\s*["']?application/json""", re.IGNORECASE)
#: On every answer.
HEADERS: tuple[tuple[str, str], ...] = (
    ("x-content-type-options", "nosniff"),
    ("x-frame-options", "DENY"),
    ("referrer-policy", "no-referrer"),
    ("cross-origin-opener-policy", "same-origin"),
    ("cross-origin-resource-policy", "same-origin"),
    ("permissions-policy", "camera=(), geolocation=(), microphone=(), payment=(), usb=()"),
)


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


Scope = MutableMapping[str, Any]
Message = MutableMapping[str, Any]
Receive = Callable[[], Awaitable[Message]]
Send = Callable[[Message], Awaitable[None]]
App = Callable[[Scope, Receive, Send], Awaitable[None]]

#: The cookie with the token, with the port behind it: browsers share cookies between the
#: ports of a host.
COOKIE = "valvetrain"
#: How long (s) a browser is known, and how many are; wrong tokens in a minute after which none is
#: looked at.
KNOWN_FOR, MAX_KNOWN, MAX_WRONG = 12 * 3600.0, 256, 20
#: How long (s) a body may take to arrive.
BODY_TIME = 30.0
#: Largest page that is read for its scripts (bytes).
_MAX_PAGE = 50_000_000
_METHODS = ("GET", "HEAD", "POST", "OPTIONS")
_HARMLESS = ("GET", "HEAD", "OPTIONS")


def is_loopback(host: str) -> bool:
    """Whether only this machine reaches the address.

    >>> is_loopback("127.0.0.1"), is_loopback("::1"), is_loopback("0.0.0.0"), is_loopback("10.0.0.5")
    (True, True, False, False)
    """
    try:
        return ipaddress.ip_address(host.strip("[]")).is_loopback
    except ValueError:
        return host.lower() == "localhost"


def new_token() -> str:
    """A random token of 192 bits.

    >>> len(new_token()) > 30
    True
    """
    return secrets.token_urlsafe(24)


def check_settings(settings: ServeSettings) -> ServeSettings:
    """The settings; raises :class:`InputError` for an address beyond this machine without a token,
    or a short one.
    """
    if not settings.token and not is_loopback(settings.host):
        raise InputError(
            f"address '{settings.host}' is reached from elsewhere, so it needs a token",
            "--host",
        )
    if settings.token and (
        len(settings.token) < 16 or not settings.token.isascii() or not settings.token.isprintable()
    ):
        raise InputError(
            "a token has at least 16 plain characters; leave the variable out to get a random one",
            "VALVETRAIN_TOKEN",
        )
    return settings


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

    def __init__(self, app: App, settings: ServeSettings) -> None:
        self.app, self.settings = app, check_settings(settings)
        self.cookie = f"{COOKIE}-{settings.port}"
        self._known: dict[bytes, float] = {}
        self._wrong = Rate(MAX_WRONG, 60.0)
        self._sockets = self._requests = 0

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """One request."""
        if scope["type"] == "websocket":
            await self._socket(scope, receive, send)
        elif scope["type"] == "http":
            await self._request(scope, receive, send)
        else:
            await self.app(scope, receive, send)

    async def _socket(self, scope: Scope, receive: Receive, send: Send) -> None:
        heads = _heads(scope)
        refused = self._refusal(scope, heads, "origin" in heads) or (
            "" if self._is_known(heads) else "this server requires its token"
        )
        if refused or self._sockets >= self.settings.most_sessions:
            await receive()
            await send(
                {
                    "type": "websocket.close",
                    "code": 1008 if refused else 1013,
                    "reason": refused or "too many pages are open",
                }
            )
            return
        self._sockets += 1
        try:
            await self.app(scope, self._bounded_socket(receive), send)
        finally:
            self._sockets -= 1

    def _bounded_socket(self, receive: Receive) -> Receive:
        async def bounded() -> Message:
            message = await receive()
            size = len(message.get("text") or "") + len(message.get("bytes") or b"")
            return (
                {"type": "websocket.disconnect", "code": 1009}
                if size > self.settings.most_body
                else message
            )

        return bounded

    async def _request(self, scope: Scope, receive: Receive, send: Send) -> None:
        heads = _heads(scope)
        sender = _Sender(send, heads.get("host", ""))
        if scope["method"] not in _METHODS:
            await sender.refuse(405, "this server answers GET, HEAD and POST only")
        elif refused := self._refusal(
            scope,
            heads,
            scope["method"] in _HARMLESS or "origin" in heads or "sec-fetch-site" in heads,
        ):
            await sender.refuse(403, refused)
        elif _length(heads) > self.settings.most_body:
            await sender.refuse(413, self._too_large)
        elif self._requests >= self.settings.most_requests:
            await sender.refuse(503, "too many requests at a time; try again in a moment")
        elif (query := _query(scope)) and self.is_token(query.pop("token", "")):
            await self._admit(scope, query, sender)
        elif not self._is_known(heads):
            await self._turn_away("token" in _query(scope), sender)
        else:
            await self._answer(scope, receive, sender)

    @property
    def _too_large(self) -> str:
        return f"what was sent is larger than {self.settings.most_body / 1e6:.3g} MB, the most that is taken"

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

        if sender.wants_page(scope):  # a compressed page cannot be read for its scripts
            scope = {
                **scope,
                "headers": [
                    (name, value)
                    for name, value in scope["headers"]
                    if name.lower() != b"accept-encoding"
                ],
            }
        self._requests += 1
        try:
            await self.app(scope, bounded, sender.send)
        except _TooLargeError:
            await sender.refuse(413, self._too_large)
        except _LateError:
            await sender.refuse(408, "the rest of what was sent did not arrive; send it again")
        finally:
            self._requests -= 1

    async def _admit(self, scope: Scope, query: dict[str, str], sender: _Sender) -> None:
        """Set the cookie of a visitor who showed the token, which leaves the address."""
        name = secrets.token_urlsafe(24)
        self._know(name)
        secure = "; Secure" if scope.get("scheme") in ("https", "wss") else ""
        mark = f"{self.cookie}={name}; HttpOnly; SameSite=Strict; Path=/; Max-Age={KNOWN_FOR:.0f}{secure}"
        place = scope["path"] + (f"?{urlencode(query)}" if query else "")
        place = "/" + place.lstrip("/")  # two slashes would name another host
        await sender.redirect(place, mark)

    async def _turn_away(self, guessed: bool, sender: _Sender) -> None:
        """Refuse a visitor who is not known; ``guessed``: the address has a token that is wrong."""
        if guessed and not self._wrong.take():
            await sender.refuse(429, "too many wrong tokens; wait a minute")
        else:
            await sender.refuse(
                401,
                "this server requires its token: open the address that 'valvetrain serve' printed",
            )

    def is_token(self, given: str) -> bool:
        """Whether ``given`` is the token, compared in the same time however much of it is right;
        never where none is required.
        """
        same = hmac.compare_digest(given.encode("utf-8", "replace"), self.settings.token.encode())
        return same and bool(given)

    def _know(self, name: str) -> None:
        now = time.monotonic()
        self._known = {key: until for key, until in self._known.items() if until > now}
        while len(self._known) >= MAX_KNOWN:
            del self._known[next(iter(self._known))]
        self._known[hashlib.sha256(name.encode()).digest()] = now + KNOWN_FOR

    def _is_known(self, heads: dict[str, str]) -> bool:
        """Whether no token is required, or the cookie is one that was given for it."""
        if not self.settings.token:
            return True
        try:
            mark = SimpleCookie(heads.get("cookie", "")).get(self.cookie)
        except CookieError:
            return False
        return (
            mark is not None
            and self._known.get(hashlib.sha256(mark.value.encode()).digest(), 0.0)
            > time.monotonic()
        )

    def _refusal(self, scope: Scope, heads: dict[str, str], is_declared: bool) -> str:
        """Why a request is refused before anything looks at it, empty where not; ``is_declared``: it says
        where it comes from, or need not.
        """
        if not self.is_own(heads.get("host", "")):
            return "this server is not called by that name; open the address that 'valvetrain serve' printed"
        if "origin" in heads and not self._same_origin(heads["origin"], heads["host"]):
            return "another site sent this request"
        site, mode = heads.get("sec-fetch-site", "none"), heads.get("sec-fetch-mode", "")
        if site not in ("none", "same-origin") and not (
            mode == "navigate" and scope.get("method") == "GET"
        ):
            return "another site sent this request"
        if not is_declared:
            return "this request does not give its origin"
        return "" if _is_plain(scope) else "this address leads nowhere"

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
    def _same_origin(origin: str, host: str) -> bool:
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


class _Sender:
    """Sends answers with the headers of security; a page is buffered until its scripts are known."""

    def __init__(self, send: Send, host: str) -> None:
        self._send, self.host = send, host if _is_host(host) else "invalid"
        self._start: Message | None = None
        self._body = b""
        self._sent = False

    @staticmethod
    def wants_page(scope: Scope) -> bool:
        """Whether a browser requests a page."""
        return "text/html" in _heads(scope).get("accept", "")

    async def send(self, message: Message) -> None:
        """Pass on a message of the answer."""
        if message["type"] == "http.response.start":
            heads = {name.lower(): value for name, value in message["headers"]}
            plain = not heads.get(b"content-encoding")
            if (
                heads.get(b"content-type", b"").startswith(b"text/html")
                and plain
                and int(heads.get(b"content-length", b"0")) <= _MAX_PAGE
            ):
                self._start = message
                return
            await self._begin(message, b"")
        elif message["type"] == "http.response.body" and self._start is not None:
            self._body += message.get("body", b"")
            if not message.get("more_body") or len(self._body) > _MAX_PAGE:
                start, page = self._start, self._body
                self._start, self._body = None, b""
                await self._begin(start, page)
                await self._send({**message, "body": page})
        else:
            await self._send(message)

    async def _begin(self, message: Message, page: bytes) -> None:
        own = {name.encode() for name, _ in HEADERS} | {b"content-security-policy"}
        heads = [
            (name, value) for name, value in message.get("headers", ()) if name.lower() not in own
        ]
        heads += [(name.encode(), value.encode()) for name, value in HEADERS]
        heads.append(
            (
                b"content-security-policy",
                content_security_policy(self.host, page).encode("ascii", "replace"),
            )
        )
        self._sent = True
        await self._send({**message, "headers": heads})

    async def refuse(self, status: int, sentence: str) -> None:
        """Answer with a sentence; nothing where an answer has begun."""
        if self._sent:
            return
        body = f"{sentence[:1].upper()}{sentence[1:]}.\n".encode()
        plain = [
            (b"content-type", b"text/plain; charset=utf-8"),
            (b"content-length", str(len(body)).encode()),
        ]
        if status in (408, 413, 503):
            plain.append((b"connection", b"close"))
        await self._begin(
            {
                "type": "http.response.start",
                "status": status,
                "headers": [*plain, (b"cache-control", b"no-store")],
            },
            b"",
        )
        await self._send({"type": "http.response.body", "body": body})

    async def redirect(self, place: str, mark: str) -> None:
        """Send the visitor on with a cookie."""
        heads = [
            (b"location", place.encode("ascii", "replace")),
            (b"set-cookie", mark.encode()),
            (b"cache-control", b"no-store"),
        ]
        await self._begin(
            {
                "type": "http.response.start",
                "status": 303,
                "headers": [*heads, (b"content-length", b"0")],
            },
            b"",
        )
        await self._send({"type": "http.response.body", "body": b""})


def _heads(scope: Scope) -> dict[str, str]:
    """Headers by lower-case name; one that occurs twice and must not is spoilt, so that nothing
    takes it for the other.
    """
    found: dict[str, str] = {}
    for name, value in scope["headers"]:
        key = name.decode("latin-1").lower()
        text = value.decode("latin-1")
        found[key] = (
            f"{found[key]}, {text}"
            if key in found and key != "cookie"
            else text
            if key not in found
            else f"{found[key]}; {text}"
        )
    return found


def _query(scope: Scope) -> dict[str, str]:
    return dict(parse_qsl(scope.get("query_string", b"").decode("latin-1")))


def _length(heads: dict[str, str]) -> float:
    text = heads.get("content-length", "0")
    return int(text) if text.isdecimal() and len(text) < 16 else float("inf")


def _is_host(host: str) -> bool:
    return bool(host) and all(char.isalnum() or char in ".-:[]" for char in host) and host.isascii()


def _is_plain(scope: Scope) -> bool:
    """Whether a path leads down only: no way up, however it is written, and nothing that a terminal obeys."""
    path = scope["path"]
    return ".." not in path.split("/") and path.isprintable() and not set("\\%") & set(path)
