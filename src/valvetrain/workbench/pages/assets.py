"""Styles and scripts that the pages load, all from this server: the report's own, the workbench's, and Plotly."""

from __future__ import annotations

import asyncio
import hashlib
from collections.abc import Callable
from functools import cache
from importlib import resources

from fastapi import FastAPI, HTTPException
from fastapi.responses import Response

from valvetrain.report.motion.script import motion_script
from valvetrain.report.page import page_script, page_style, plotly_script

_KINDS = {"css": "text/css; charset=utf-8", "js": "text/javascript; charset=utf-8"}


@cache
def content(name: str) -> bytes:
    """The content of an asset; KeyError for another name."""
    made: dict[str, Callable[[], str]] = {
        "page.css": page_style,
        "page.js": page_script,
        "plotly.js": plotly_script,
        "motion.js": motion_script,
        "workbench.css": _own_style,
    }
    return made[name]().encode()


@cache
def address(name: str) -> str:
    """Where an asset is asked for; it changes with the content, so that a browser may keep it."""
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


def _own_style() -> str:
    return resources.files("valvetrain.workbench.pages").joinpath("static", "workbench.css").read_text(encoding="utf-8")


async def warm() -> None:
    """Make ready, while nobody waits for it, what the first pages need: assets, and the tables behind forms."""
    await asyncio.to_thread(_make_ready)


def _make_ready() -> None:
    from valvetrain.parameters.loading import load_case
    from valvetrain.workbench.form import fields
    from valvetrain.workbench.pages.orders import choices_for

    case = load_case("job-c")
    fields(case)
    choices_for(case, (), {})
    for name in ("page.css", "workbench.css", "page.js", "plotly.js", "motion.js"):
        address(name)
