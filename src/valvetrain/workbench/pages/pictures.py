"""Pictures of cases to scale, at addresses of their own."""

from __future__ import annotations

from contextlib import suppress
from functools import lru_cache
from pathlib import Path
from typing import Any
from urllib.parse import quote

from fastapi import FastAPI
from fastapi.responses import Response

from valvetrain.errors import ValvetrainError
from valvetrain.parameters.case import Case
from valvetrain.parameters.loading import load_case, parse_case
from valvetrain.parameters.overrides import read_assignment
from valvetrain.parameters.templates import KINDS, template_text
from valvetrain.workbench.pages.desk import Desk
from valvetrain.workbench.pages.forms import ENGINE_SPEED
from valvetrain.workbench.side_files import stored_files
from valvetrain.workbench.workspace import CaseId

#: Pictures that stay in the cache.
MAX_CACHED = 64
#: What a case may raise whose parts cannot be drawn, and a run whose files are damaged.
FAULTS = (
    ValvetrainError, ArithmeticError, ValueError, LookupError, OSError, TypeError, AttributeError,
)  # fmt: skip
#: What is drawn of a case that has nothing to draw.
EMPTY = '<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 1 1"></svg>'


def of_source(name: str) -> str:
    """Address of the picture of a template or a case of the library."""
    return f"/picture/source/{quote(name)}.svg"


def of_case(desk: Desk, case: CaseId, key: str = "", value: str = "", small: bool = False) -> str:
    """Address of the picture of a case with ``value`` at ``key``; another case unchanged is
    another address.
    """
    stamp = (
        hash((desk.workspace.text(case), stored_files(desk.workspace.case_folder(case))))
        & 0xFFFFFFFF
    )
    changed = "" if not key or key == ENGINE_SPEED else f"&key={quote(key)}&value={quote(value)}"
    return f"/picture/case/{quote(case)}.svg?at={stamp:x}{'&small=1' if small else ''}{changed}"


def prepare(desk: Desk, case: CaseId, key: str, value: str) -> None:
    """Draw the picture of a case, so that its address answers at once; blocks for about 0.2 s."""
    changed = "" if key == ENGINE_SPEED else key
    with suppress(*FAULTS):
        _of_workspace(desk, case, changed, value if changed else "", False)


def has_picture(case: Case) -> bool:
    """Whether a case has a train, or a spring whose wire can be drawn."""
    known = (one.wire is not None or (one.card and one.card.mass) for one in case.springs)
    return case.train is not None or any(known)


def register(app: FastAPI, desk: Desk) -> None:
    """Add the addresses of pictures."""

    @app.get("/picture/source/{name}.svg")
    def source(name: str) -> Response:
        return _response(lambda: _of_source(name), 3600)

    @app.get("/picture/case/{case}.svg")
    def case(case: str, key: str = "", value: str = "", small: str = "") -> Response:
        return _response(lambda: _of_workspace(desk, case, key, value, bool(small)), 0)


def _of_workspace(desk: Desk, case: CaseId, key: str, value: str, small: bool) -> str:
    text, stamps = desk.workspace.text(case), stored_files(desk.workspace.case_folder(case))
    return _of_case(text, str(desk.workspace.case_folder(case)), stamps, key, value, small)


def _response(make: Any, seconds: int) -> Response:
    svg = ""
    with suppress(*FAULTS):
        svg = make()
    headers = {"Cache-Control": f"private, max-age={seconds}"}
    return Response(svg or EMPTY, media_type="image/svg+xml", headers=headers)


@lru_cache(maxsize=MAX_CACHED)
def _of_source(name: str) -> str:
    return _drawn(parse_case(template_text(name), name) if name in KINDS else load_case(name), True)


@lru_cache(maxsize=MAX_CACHED)
def _of_case(
    text: str, folder: str, stamps: tuple[Any, ...], key: str, value: str, small: bool
) -> str:
    changes = dict([read_assignment(f"{key}={value}", key)]) if key else None
    return _drawn(parse_case(text, "case", Path(folder), "case", changes), small)


def _drawn(case: Case, small: bool) -> str:
    from valvetrain.views.motion.still import case_picture

    return case_picture(case, closed_alone=small)
