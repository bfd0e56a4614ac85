"""A workbench in a real browser: a server with a folder of its own, a Chromium, pages of which
nothing may go wrong.
"""

from __future__ import annotations

import json
import os
import signal
import socket
import subprocess
import sys
import time
import tomllib
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pytest

from system_parts import program

pytest.importorskip("nicegui")
sync_api = pytest.importorskip("playwright.sync_api")
axe = pytest.importorskip("axe_playwright_python.sync_playwright")

CASE = "gu2021-beehive-blind"
#: What the drawing of a browser without a graphics card says of its own speed.
DRIVER = "GL Driver Message (OpenGL, Performance"
# Words, fields and buttons that reach beyond the window, and by how much the page is wider than it.
#: Figures are drawn anew a moment after the width has changed.
DRAWN = "document.documentElement.scrollWidth <= window.innerWidth"
CUT = """() => {
  const found = [];
  document.querySelectorAll("button, a, label, h1, h2, h3, summary, input, select, .plot .ytick text, .plot .xtick text").forEach((one) => {
    const place = one.getBoundingClientRect();
    if (!place.width || one.closest(".scroll, .off-screen, .nicegui-skip-link, .vtm-list")) { return; }
    if (place.left < -1 || place.right > window.innerWidth + 1) { found.push(one.tagName + " " + one.textContent.slice(0, 40)); }
  });
  return {found, wider: document.documentElement.scrollWidth - window.innerWidth};
}"""


@dataclass
class Bench:
    """A server with its folder, and a browser."""

    url: str
    folder: Path
    browser: Any

    def page(self, width: int = 1400, seen: list[str] | None = None) -> Any:
        """A page of that width in a context of its own; what goes wrong is told to ``seen``."""
        page = self.browser.new_context(
            viewport={"width": width, "height": 900}, accept_downloads=True
        ).new_page()
        told = [] if seen is None else seen
        page.on(
            "console",
            lambda message: (
                told.append(f"console: {message.text}")
                if message.type in ("error", "warning") and DRIVER not in message.text
                else None
            ),
        )
        page.on("pageerror", lambda error: told.append(f"error: {error}"))
        page.on(
            "request",
            lambda request: (
                None if self.own(request.url) else told.append(f"request: {request.url}")
            ),
        )
        return page

    def own(self, url: str) -> bool:
        """Whether an address is this server's, or none at all."""
        return url.startswith((self.url, self.url.replace("http", "ws"), "data:", "blob:"))

    def answer(self, run: str) -> dict[str, Any]:
        """The ``run.json`` of a run."""
        return json.loads((self.folder / "runs" / run / "run.json").read_text("utf-8"))

    def case(self, name: str = CASE) -> dict[str, Any]:
        """The case file."""
        return tomllib.loads((self.folder / "cases" / name / "case.toml").read_text("utf-8"))


@contextmanager
def opened(folder: Path) -> Iterator[Bench]:
    """A server on a port of its own that works in ``folder``, and a browser; both end with the
    block.
    """
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        port = free.getsockname()[1]
    plain = {
        name: value
        for name, value in os.environ.items()
        if not name.startswith(("PYTEST_", "NICEGUI_"))
    }
    environment = plain | {"PYTHONPATH": os.pathsep.join(path for path in sys.path if path)}
    command = [
        sys.executable,
        "-m",
        "valvetrain",
        "serve",
        "--folder",
        str(folder),
        "--port",
        str(port),
        "--no-open",
    ]
    told = folder.with_name(f"{folder.name}-server.txt")
    with told.open("wb") as stream:
        server = subprocess.Popen(command, env=environment, start_new_session=True, stderr=stream)
    try:
        _wait_for(port, server, told)
        with sync_api.sync_playwright() as driver:
            browser = driver.chromium.launch(
                executable_path=program("chromium"), args=["--no-sandbox", "--disable-gpu"]
            )
            yield Bench(f"http://127.0.0.1:{port}", folder, browser)
            browser.close()
    finally:
        os.killpg(server.pid, signal.SIGINT)
        try:
            server.wait(20)
        except subprocess.TimeoutExpired:
            os.killpg(server.pid, signal.SIGKILL)
            raise


@contextmanager
def watched(bench: Bench) -> Iterator[Any]:
    """A wide page of which nothing may go wrong."""
    seen: list[str] = []
    made = bench.page(seen=seen)
    yield made
    made.context.close()
    assert seen == [], seen


def open_case(bench: Bench, page: Any, case: str = CASE) -> None:
    """The page of a case, with its form."""
    page.goto(f"{bench.url}/case/{case}")
    page.wait_for_selector(".form")


def shown(page: Any) -> None:
    """Wait until the results of a run are drawn."""
    page.wait_for_selector(".results[data-shown]", timeout=30_000)


def nothing_serious(page: Any) -> None:
    """Nothing is cut off, and axe-core finds nothing serious."""
    page.wait_for_function(DRAWN, timeout=10_000)
    cut = page.evaluate(CUT)
    assert cut == {"found": [], "wider": 0}, cut
    results = axe.Axe().run(page).response["violations"]
    assert not [
        (one["id"], one["nodes"][0]["html"][:200])
        for one in results
        if one["impact"] in ("serious", "critical")
    ]


def _wait_for(port: int, server: subprocess.Popen[bytes], told: Path) -> None:
    """Until the server prints its address, at which it answers from then on."""
    for _ in range(600):
        if f"at http://127.0.0.1:{port}/" in told.read_text("utf-8"):
            with socket.socket() as door:
                assert door.connect_ex(("127.0.0.1", port)) == 0, "told before it listens"
            return
        assert server.poll() is None, "the server ended at once"
        time.sleep(0.02)
    raise AssertionError("the server does not listen")
