"""Connections of the server, few and none of them silent, and what it logs of them."""

from __future__ import annotations

import asyncio
import logging
import time
import traceback
from collections import OrderedDict
from typing import Any, ClassVar

from uvicorn.protocols.http.h11_impl import H11Protocol

from valvetrain.units.text import clipped
from valvetrain.workbench.settings import ServeSettings

#: Connections that wait for a head at a time, and how long each may (s); largest head (bytes).
MAX_WAITING, HEAD_TIME, MAX_HEAD = 128, 15.0, 65_536


class Connection(H11Protocol):
    """A connection that ends when its next head does not come in time, or when it has waited
    longest of too many.
    """

    waiting: ClassVar[OrderedDict[Connection, asyncio.TimerHandle]] = OrderedDict()

    def connection_made(self, transport: asyncio.Transport) -> None:  # type: ignore[override]
        """It waits for its first head."""
        super().connection_made(transport)
        self._wait()

    def connection_lost(self, exc: Exception | None) -> None:
        """It waits no more."""
        self._wait_no_more()
        super().connection_lost(exc)

    def handle_events(self) -> None:
        """A request that is being answered has no head to wait for."""
        super().handle_events()
        if self.cycle is not None and not self.cycle.response_complete:
            self._wait_no_more()

    def handle_websocket_upgrade(self, event: Any) -> None:
        """Messages come over it from now on."""
        self._wait_no_more()
        super().handle_websocket_upgrade(event)

    def on_response_complete(self) -> None:
        """It waits for the next head."""
        self._wait()
        super().on_response_complete()

    def _wait(self) -> None:
        self._wait_no_more()
        self.waiting[self] = self.loop.call_later(HEAD_TIME, self.transport.abort)
        if len(self.waiting) > MAX_WAITING:
            oldest, timer = self.waiting.popitem(last=False)
            timer.cancel()
            oldest.transport.abort()

    def _wait_no_more(self) -> None:
        if (timer := self.waiting.pop(self, None)) is not None:
            timer.cancel()


def uvicorn_options(settings: ServeSettings) -> dict[str, Any]:
    """Options of the server (uvicorn) that belong to safety: bounds of messages, heads and
    connections, no trust in headers of a proxy, a quick end.
    """
    return {
        "http": Connection,
        "proxy_headers": False,
        "server_header": False,
        "ws_max_size": settings.most_body,
        "h11_max_incomplete_event_size": MAX_HEAD,
        "timeout_keep_alive": HEAD_TIME,
        "timeout_graceful_shutdown": 3,
        "backlog": MAX_WAITING,
    }


class Brief(logging.Filter):
    """Writes a message in one line without signs that a terminal obeys, and the same once a
    minute.
    """

    def __init__(self) -> None:
        super().__init__()
        self._written: dict[str, float] = {}

    def filter(self, record: logging.LogRecord) -> bool:
        """Whether the message is written."""
        text, error = record.getMessage(), record.exc_info[1] if record.exc_info else None
        if error is not None:
            (*_, place) = traceback.extract_tb(error.__traceback__) or (None,)
            text = f"{type(error).__name__}: {error} ({place})"
        record.msg, record.args, record.exc_info = clipped(text, 400), (), None
        last, now = self._written.pop(record.msg, -60.0), time.monotonic()
        self._written[record.msg] = now if now - last >= 60.0 else last
        if len(self._written) > 100:
            self._written.clear()
        return now - last >= 60.0


def tell_briefly() -> None:
    """Log what goes wrong in lines, none of them again and again."""
    for name in ("nicegui", "uvicorn.error", "asyncio"):
        logging.getLogger(name).addFilter(Brief())
