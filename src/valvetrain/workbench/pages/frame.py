"""What every page has: head, skip link, navigation, light and dark."""

from __future__ import annotations

import asyncio
import hashlib
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import cache, partial
from importlib import resources

from fastapi import FastAPI, HTTPException
from fastapi.responses import Response
from nicegui import ui
from nicegui.context import context

from valvetrain.views.page import motion_script, static
from valvetrain.workbench.pages.elements import Theme, link, tag

_KINDS = {"css": "text/css; charset=utf-8", "js": "text/javascript; charset=utf-8"}


@cache
def content(name: str) -> bytes:
    """The content of an asset; KeyError for another name."""
    if name == "plotly.js":
        return resources.files("plotly").joinpath("package_data", "plotly.min.js").read_bytes()
    made: dict[str, Callable[[], str]] = {
        **{one: partial(static, one) for one in ("page.css", "parts.css", "page.js")},
        "motion.js": motion_script,
        "workbench.css": _style,
    }
    return made[name]().encode()


@cache
def address(name: str) -> str:
    """Address of an asset; it changes with the content, so that a browser may cache it."""
    return f"/assets/{hashlib.sha256(content(name)).hexdigest()[:12]}/{name}"


def register(app: FastAPI) -> None:
    """Add the addresses of all assets."""

    @app.get("/assets/{digest}/{name}")
    def asset(digest: str, name: str) -> Response:
        try:
            whole = content(name)
        except KeyError:
            raise HTTPException(404) from None
        headers = {"Cache-Control": "public, max-age=31536000, immutable"}
        return Response(whole, media_type=_KINDS[name.rpartition(".")[2]], headers=headers)


def _style() -> str:
    return (
        resources.files("valvetrain.workbench.pages")
        .joinpath("static", "workbench.css")
        .read_text(encoding="utf-8")
    )


async def warm() -> None:
    """Prepare in the background what the first pages need: assets, and the tables
    behind forms.
    """
    await asyncio.to_thread(_prepare)


def _prepare() -> None:
    from valvetrain.parameters.loading import load_case
    from valvetrain.workbench.form import CaseForm
    from valvetrain.workbench.pages.orders import orders_for

    case = load_case("job-c")
    CaseForm(case.text)
    orders_for(case, ())
    for name in ("page.css", "parts.css", "workbench.css", "page.js", "plotly.js", "motion.js"):
        address(name)


#: Places of the navigation: words and address.
PLACES = (("Start", "/"), ("Runs", "/runs"), ("Compare", "/compare"))
# Light or dark is known before anything is drawn.
_HEAD = """
<meta name="description" content="Valve springs and valvetrains: cases, runs and results on this machine">
<script>
document.documentElement.lang = "en";
document.documentElement.dataset.workbench = "";
(function () {
  let theme = null;
  try { theme = localStorage.getItem("valvetrain-theme"); } catch (error) { theme = null; }
  const dark = theme ? theme === "dark" : window.matchMedia("(prefers-color-scheme: dark)").matches;
  document.documentElement.dataset.theme = dark ? "dark" : "light";
})();
</script>
"""
# What draws figures is large: it is fetched once the page is shown.
_LATER = """<script>
window.valvetrainDrawing = new Promise(function (done) {
  window.addEventListener("load", function () {
    let left = 2;
    [%s].forEach(function (address) {
      const script = document.createElement("script");
      script.src = address;
      script.onload = function () { left -= 1; if (left === 0) { done(); } };
      document.head.append(script);
    });
  });
});
</script>"""


@contextmanager
def frame(title: str, here: str = "", figures: bool = True) -> Iterator[None]:
    """A page with ``title``; what is made inside is in its main part. ``figures``: it draws
    some.
    """
    ui.page_title(f"{title} - valvetrain")
    drawing = _LATER % ", ".join(f'"{address(name)}"' for name in ("plotly.js", "motion.js"))
    scripts = f'<script defer src="{address("page.js")}"></script>{drawing}' if figures else ""
    styles = "".join(
        f'<link rel="stylesheet" href="{address(name)}">'
        for name in ("page.css", "parts.css", "workbench.css")
    )
    ui.add_head_html(_HEAD + styles + scripts)
    with context.client.layout:
        top = tag("header", classes="top")
    top.move(target_index=0)
    with top:
        link("valvetrain", "/", "brand")
        with tag("nav", aria_label="places"):
            for label, href in PLACES:
                link(label, href, aria_current="page" if href == here else None)
        Theme()
    with tag("div", classes="sheet") as sheet:
        yield
    ui.skip_link("Skip to the content", target=sheet)
