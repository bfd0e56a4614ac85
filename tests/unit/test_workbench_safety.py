"""The guard before every request: who may call, under which name, from which page, how much, and
what an answer carries.

Evidence: contract of HTTP as browsers keep it (Host, Origin, Sec-Fetch-*, cookies, CSP), on a bare
ASGI application and on real sockets.
"""

from __future__ import annotations

import asyncio
import base64
import hashlib
import re
import socket
import threading
import time
from typing import Any

import pytest

pytest.importorskip("starlette")

from valvetrain.errors import InputError
from valvetrain.workbench.pages import guard as safety
from valvetrain.workbench.pages.guard import Guard, Rate, content_security_policy
from valvetrain.workbench.settings import ServeSettings, check_settings, new_token

PAGE = b"<html><script>one()</script><script type='module'>two()</script><script src='/x.js'></script></html>"
OWN = {"host": "127.0.0.1:8420"}
TOKEN = "t" * 32


async def inner(scope: Any, receive: Any, send: Any) -> None:
    """A page at /, what was sent back at /echo, and a socket that answers."""
    if scope["type"] == "websocket":
        await receive()
        await send({"type": "websocket.accept"})
        while (message := await receive())["type"] == "websocket.receive":
            await send({"type": "websocket.send", "text": str(len(message.get("text") or ""))})
        return
    body, more = b"", True
    while more:
        message = await receive()
        body, more = body + message.get("body", b""), message.get("more_body", False)
    page = scope["path"] == "/"
    kind = b"text/html; charset=utf-8" if page else b"text/plain"
    told = PAGE if page else body
    encoded = any(name == b"accept-encoding" for name, _ in scope["headers"])
    heads = [
        (b"content-type", kind),
        (b"content-length", str(len(told)).encode()),
        (b"x-encoded", str(encoded).encode()),
    ]
    await send({"type": "http.response.start", "status": 200, "headers": heads})
    await send({"type": "http.response.body", "body": told[:10], "more_body": True})
    await send({"type": "http.response.body", "body": told[10:]})


class Answer:
    """Status, headers and body of one answer."""

    def __init__(self, sent: list[Any]) -> None:
        starts = [message for message in sent if message["type"] == "http.response.start"]
        assert len(starts) == 1, "one answer to one request"
        self.status = starts[0]["status"]
        self.heads = {name.decode().lower(): value.decode() for name, value in starts[0]["headers"]}
        self.body = b"".join(
            message["body"] for message in sent if message["type"] == "http.response.body"
        )


def scope_of(path: str, heads: dict[str, str], method: str, kind: str = "http") -> dict[str, Any]:
    place, _, query = path.partition("?")
    listed = [(name.encode(), value.encode("latin-1")) for name, value in heads.items()]
    return {
        "type": kind,
        "method": method,
        "path": place,
        "query_string": query.encode(),
        "headers": listed,
        "scheme": "http",
    }


def ask(
    guard: Guard,
    path: str = "/",
    heads: dict[str, str] | None = None,
    method: str = "GET",
    chunks: tuple[bytes, ...] = (),
) -> Answer:
    sent: list[Any] = []
    parts = [*chunks] or [b""]

    async def receive() -> Any:
        return {"type": "http.request", "body": parts.pop(0), "more_body": bool(parts)}

    async def send(message: Any) -> None:
        sent.append(message)

    asyncio.run(guard(scope_of(path, OWN if heads is None else heads, method), receive, send))
    return Answer(sent)


def talk(guard: Guard, heads: dict[str, str], text: str = "hello") -> list[Any]:
    """What a socket sends back."""
    sent: list[Any] = []
    given = [
        {"type": "websocket.connect"},
        {"type": "websocket.receive", "text": text},
        {"type": "websocket.disconnect"},
    ]

    async def receive() -> Any:
        return given.pop(0)

    async def send(message: Any) -> None:
        sent.append(message)

    asyncio.run(guard(scope_of("/ws", heads, "GET", "websocket"), receive, send))
    return sent


@pytest.fixture
def guard():
    return Guard(inner, ServeSettings(most_body=1000))


FOREIGN = (
    "evil.example:8420", "evil.example", "127.0.0.1:80", "127.0.0.1", "127.0.0.1.evil.example:8420", "", "127.0.0.1:8420@evil.example",
    "127.0.0.1:8420, evil.example", "192.168.0.7:8420", "0.0.0.0:8420", "x:8420/",
)  # fmt: skip
PORT = "http://127.0.0.1:8420"
UP = ("/../x", "/a/../../etc/passwd", "/%2e%2e/x", "/a\\..\\b", "/a\0b", "/..", "/a\r\nb")
#: Method, path and headers -> status: names of the server, those that a page of another site leads here (DNS rebinding), requests
#: of other sites and of its own pages, paths that lead up, and methods.
VISITS = [
    *(("GET", "/", {"host": host}, 200) for host in ("127.0.0.1:8420", "localhost:8420", "[::1]:8420", "LOCALHOST:8420")),
    *(("GET", "/", {"host": host}, 403) for host in FOREIGN),
    *(("POST", "/echo", {"origin": one}, 403) for one in ("http://evil.example", "null", "http://127.0.0.1:9999", "file://")),
    ("GET", "/echo", {"origin": "http://evil.example"}, 403),
    ("POST", "/echo", {}, 403),
    ("GET", "/echo", {"sec-fetch-site": "cross-site", "sec-fetch-mode": "no-cors"}, 403),
    ("GET", "/echo", {"sec-fetch-site": "same-site", "sec-fetch-mode": "cors"}, 403),
    ("POST", "/echo", {"sec-fetch-site": "cross-site", "sec-fetch-mode": "navigate"}, 403),
    ("POST", "/echo", {"origin": PORT}, 200),
    ("POST", "/echo", {"sec-fetch-site": "same-origin"}, 200),
    ("GET", "/echo", {}, 200),
    ("GET", "/echo", {"sec-fetch-site": "cross-site", "sec-fetch-mode": "navigate"}, 200),
    ("GET", "/echo", {"sec-fetch-site": "none"}, 200),
    *(("GET", path, {}, 403) for path in UP),
    *((method, "/echo", {"origin": PORT}, 405) for method in ("PUT", "DELETE", "PATCH", "TRACE", "CONNECT")),
]  # fmt: skip


@pytest.mark.parametrize(("method", "path", "heads", "status"), VISITS)
def test_a_request_is_answered_or_refused_by_where_it_comes_from(
    guard, method, path, heads, status
):
    assert ask(guard, path, OWN | heads, method).status == status


@pytest.mark.parametrize(
    "heads",
    [
        *({"host": host, "origin": f"http://{host}"} for host in FOREIGN),
        *(OWN | one for one in ({}, {"origin": "http://evil.example"}, {"origin": "http://localhost:8420"})),
    ],
)  # fmt: skip
def test_a_socket_of_another_page_is_refused(guard, heads):
    (closed,) = talk(guard, heads)
    assert closed["type"] == "websocket.close" and closed["code"] == 1008


def test_a_socket_of_its_own_page_talks_within_the_bound(guard):
    own = OWN | {"origin": "http://127.0.0.1:8420"}
    assert [message["type"] for message in talk(guard, own)] == [
        "websocket.accept",
        "websocket.send",
    ]
    assert [message["type"] for message in talk(guard, own, "x" * 1001)] == ["websocket.accept"]


def test_pages_that_are_open_at_a_time_are_bounded():
    guard = Guard(inner, ServeSettings(most_sessions=0))
    (closed,) = talk(guard, OWN | {"origin": "http://127.0.0.1:8420"})
    assert (closed["code"], closed["reason"]) == (1013, "too many pages are open")
    (closed,) = talk(guard, OWN | {"origin": "http://evil.example"})
    assert closed["code"] == 1008 and closed["reason"] not in ("", "too many pages are open")


def test_requests_at_a_time_are_bounded():
    assert ask(Guard(inner, ServeSettings(most_requests=0))).status == 503


def test_a_body_beyond_the_bound_is_refused_told_or_not(guard):
    own = OWN | {"origin": "http://127.0.0.1:8420"}
    assert (
        ask(guard, "/echo", own | {"content-length": "1000"}, "POST", (b"x" * 1000,)).body
        == b"x" * 1000
    )
    assert ask(guard, "/echo", own | {"content-length": "1001"}, "POST", (b"x",)).status == 413
    assert ask(guard, "/echo", own, "POST", (b"x" * 600, b"x" * 600)).status == 413
    assert ask(guard, "/echo", own | {"content-length": "-1"}, "POST").status == 413


def test_every_answer_carries_the_headers_of_security(guard):
    for answer in (ask(guard), ask(guard, "/echo"), ask(guard, heads={"host": "evil.example"})):
        assert answer.heads["x-content-type-options"] == "nosniff"
        assert answer.heads["x-frame-options"] == "DENY"
        assert answer.heads["referrer-policy"] == "no-referrer"
        policy = dict(
            part.split(" ", 1) for part in answer.heads["content-security-policy"].split("; ")
        )
        assert (
            policy["frame-ancestors"]
            == policy["object-src"]
            == policy["base-uri"]
            == policy["script-src-attr"]
            == "'none'"
        )
        assert policy["default-src"] == policy["form-action"] == "'self'"
        assert "unsafe-inline" not in policy["script-src"] and "http" not in policy["script-src"]


def test_each_script_of_a_page_is_let_run_by_its_hash_and_no_other():
    """The hashes are those of the standard (CSP level 3): base64 of SHA-256 of what stands in the
    element.
    """
    answer = ask(
        Guard(inner, ServeSettings()),
        heads=OWN | {"accept": "text/html", "accept-encoding": "gzip"},
    )
    due = {
        f"'sha256-{base64.b64encode(hashlib.sha256(text).digest()).decode()}'"
        for text in (b"one()", b"two()")
    }
    assert set(re.findall(r"'sha256-[^']*'", answer.heads["content-security-policy"])) == due
    assert answer.body == PAGE and answer.heads["x-encoded"] == "False", (
        "a compressed page could not be read"
    )


def test_a_host_header_cannot_write_a_policy():
    answer = ask(Guard(inner, ServeSettings()), heads={"host": "a; script-src *"})
    assert answer.status == 403 and "script-src *" not in answer.heads["content-security-policy"]
    assert "ws://127.0.0.1:8420" in content_security_policy("127.0.0.1:8420")


@pytest.fixture
def locked():
    return Guard(inner, ServeSettings(host="0.0.0.0", token=TOKEN, names=("bench.example",)))


def test_an_address_beyond_this_machine_needs_a_token():
    with pytest.raises(InputError, match="needs a token"):
        Guard(inner, ServeSettings(host="0.0.0.0"))
    with pytest.raises(InputError, match="at least 16"):
        check_settings(ServeSettings(host="192.168.0.7", token="short"))
    assert len({new_token() for _ in range(50)}) == 50


def test_without_the_token_nothing_is_answered(locked):
    for heads in (
        OWN,
        OWN | {"cookie": "valvetrain-8420=x"},
        OWN | {"cookie": f"valvetrain-8420={TOKEN}"},
    ):
        assert ask(locked, heads=heads).status == 401
        assert (
            talk(locked, heads | {"origin": "http://127.0.0.1:8420"})[0]["type"]
            == "websocket.close"
        )
    assert ask(locked, f"/?token={TOKEN[:-1]}").status == 401


def test_the_token_is_shown_once_and_a_cookie_stands_for_it(locked):
    answer = ask(locked, f"/case?name=a&token={TOKEN}")
    assert answer.status == 303 and answer.heads["location"] == "/case?name=a", (
        "it does not stay in the address"
    )
    mark, *attributes = answer.heads["set-cookie"].split("; ")
    assert {"HttpOnly", "SameSite=strict", "Path=/"} <= set(attributes) and TOKEN not in mark
    assert ask(locked, heads=OWN | {"cookie": f"other=1; {mark}"}).status == 200
    own = OWN | {"cookie": mark, "origin": "http://127.0.0.1:8420"}
    assert talk(locked, own)[0]["type"] == "websocket.accept"
    assert ask(Guard(inner, locked.settings), heads=OWN | {"cookie": mark}).status == 401, (
        "another server gave it"
    )
    assert ask(locked, f"//evil.example/?token={TOKEN}").heads["location"].startswith("/evil")


def test_beyond_this_machine_addresses_and_its_names_are_its_own_and_no_others(locked):
    for host, status in (
        ("10.0.0.5:8420", 401),
        ("bench.example:8420", 401),
        ("evil.example:8420", 403),
        ("10.0.0.5:80", 403),
    ):
        assert ask(locked, heads={"host": host}).status == status


def test_tokens_cannot_be_tried_without_end(locked):
    answers = [ask(locked, f"/?token=wrong-{place}").status for place in range(21)]
    assert answers[:20] == [401] * 20 and answers[20] == 429
    assert ask(locked, f"/?token={TOKEN}").status == 303, "the right one is compared first"


def test_a_rate_forgets():
    rate = Rate(1, 0.05)
    assert rate.take() and not rate.take()
    time.sleep(0.06)
    assert rate.take()


@pytest.fixture
def served():
    """The guard on a real port of this machine."""
    uvicorn = pytest.importorskip("uvicorn")
    from valvetrain.workbench.pages.connections import uvicorn_options

    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        port = free.getsockname()[1]
    settings = ServeSettings(port=port, most_body=1000)
    server = uvicorn.Server(
        uvicorn.Config(
            Guard(inner, settings),
            host="127.0.0.1",
            port=port,
            log_level="error",
            lifespan="off",
            **uvicorn_options(settings),
        )
    )
    thread = threading.Thread(target=server.run, daemon=True)
    thread.start()
    while not server.started:
        time.sleep(0.01)
    yield port
    server.should_exit = True
    thread.join()


def raw(port: int, *lines: str, body: bytes = b"") -> bytes:
    """What a server answers to lines of HTTP as they are."""
    with socket.create_connection(("127.0.0.1", port), timeout=10) as line:
        line.sendall("\r\n".join((*lines, "", "")).encode("latin-1") + body)
        line.settimeout(1.0)
        found = b""
        try:
            while part := line.recv(65536):
                found += part
        except TimeoutError:
            pass
        return found


def test_a_body_that_does_not_arrive_is_not_waited_for(served, monkeypatch):
    """128 of them would keep out everybody else."""
    monkeypatch.setattr(safety, "BODY_TIME", 0.3)
    own = (f"Host: 127.0.0.1:{served}", f"Origin: http://127.0.0.1:{served}")
    begun = time.monotonic()
    answer = raw(served, "POST /echo HTTP/1.1", *own, "Content-Length: 100")
    assert b" 408 " in answer[:20] and time.monotonic() - begun < 3.0
