"""Addresses that hand out parts of pages and files, and that take files."""

from __future__ import annotations

import asyncio
from collections.abc import Callable
from dataclasses import asdict
from pathlib import Path

from fastapi import FastAPI, Request
from fastapi.responses import FileResponse, HTMLResponse, JSONResponse, PlainTextResponse, Response

from valvetrain.errors import ValvetrainError
from valvetrain.workbench.answers import against
from valvetrain.workbench.pages.compare_page import comparison_part
from valvetrain.workbench.pages.desk import Desk
from valvetrain.workbench.pages.html import test_part
from valvetrain.workbench.pages.reports import report_part, report_rest

#: Comparisons with a test that are kept while the server runs.
MOST_OVERLAYS = 20


def register(app: FastAPI, desk: Desk) -> None:
    """Add the addresses of parts, downloads and uploads."""
    laid_over: dict[int, str] = {}

    @app.get("/part/{case}/{stamp}")
    def part(case: str, stamp: str) -> Response:
        return _part(lambda: report_part(desk.workspace.run(f"{case}/{stamp}")))

    @app.get("/rest/{case}/{stamp}")
    def rest(case: str, stamp: str) -> Response:
        return _part(lambda: report_rest(desk.workspace.run(f"{case}/{stamp}")))

    @app.get("/job/{case}")
    def job(case: str) -> Response:
        newest = next(iter(desk.jobs.jobs(case, 1)), None)
        return JSONResponse(None if newest is None else asdict(newest))

    @app.get("/download/{case}/{stamp}/{kind}")
    def download(case: str, stamp: str, kind: str) -> Response:
        try:
            path = desk.workspace.download(f"{case}/{stamp}", kind)  # type: ignore[arg-type]
        except ValvetrainError as error:
            return PlainTextResponse(str(error), 404)
        name = path.name if path.suffix == ".zip" else f"{case}-{stamp}-{path.name}"
        return FileResponse(path, filename=name)

    @app.get("/download-case/{case}")
    def download_case(case: str) -> Response:
        try:
            text = desk.workspace.text(case)
        except ValvetrainError as error:
            return PlainTextResponse(str(error), 404)
        head = {"Content-Disposition": f'attachment; filename="{case}.toml"'}
        return Response(text, media_type="application/toml", headers=head)

    @app.get("/part-compare")
    def part_compare(a: str, b: str) -> Response:
        return _part(lambda: comparison_part(desk, a, b))

    @app.get("/part-test/{number}")
    def part_test(number: int) -> Response:
        return HTMLResponse(laid_over[number]) if number in laid_over else PlainTextResponse("send the file of the test again", 404)

    @app.post("/upload/test")
    async def upload_test(request: Request, run: str, name: str) -> Response:
        content = await request.body()
        try:
            found = await asyncio.to_thread(lambda: against(desk.workspace.run(run), Path(name).name, content))
        except ValvetrainError as error:
            return JSONResponse({"refusal": str(error)})
        number = max(laid_over, default=0) + 1
        laid_over[number] = test_part(found)
        laid_over.pop(number - MOST_OVERLAYS, None)
        return JSONResponse({"part": f"/part-test/{number}"})

    @app.post("/upload/case")
    async def upload_case(request: Request, name: str) -> Response:
        try:
            case = desk.workspace.upload(Path(name).name, await request.body())
        except ValvetrainError as error:
            return JSONResponse({"refusal": str(error)})
        return JSONResponse({"open": f"/case/{case}"})


def _part(make: Callable[[], str]) -> Response:
    """A part of a page, or the sentence why there is none."""
    try:
        return HTMLResponse(make(), headers={"Cache-Control": "no-store"})
    except ValvetrainError as error:
        return PlainTextResponse(str(error), 404)
