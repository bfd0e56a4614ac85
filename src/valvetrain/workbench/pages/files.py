"""Addresses that serve parts of pages and files, and that take files."""

from __future__ import annotations

import asyncio
from collections.abc import Callable
from dataclasses import asdict
from functools import lru_cache
from pathlib import Path

from fastapi import FastAPI, Request
from fastapi.responses import FileResponse, JSONResponse, PlainTextResponse, Response
from jinja2 import TemplateError
from starlette.datastructures import UploadFile
from starlette.exceptions import HTTPException

from valvetrain.errors import InputError, ValvetrainError
from valvetrain.units.text import clipped
from valvetrain.workbench.answers import against
from valvetrain.workbench.pages.desk import Desk
from valvetrain.workbench.pages.parts import Part, comparison_part, run_part, test_part
from valvetrain.workbench.pages.pictures import FAULTS
from valvetrain.workbench.saved_runs import Run, keep_test, saved_test
from valvetrain.workbench.side_files import CASE_FILE, MAX_FILES
from valvetrain.workbench.store import writing

#: Comparisons with a test that are cached, each with the bytes of its test.
MAX_OVERLAYS = 5


@lru_cache(maxsize=MAX_OVERLAYS)
def _overlay(run: Run, name: str, content: bytes) -> Part:
    """The comparison of a run with a test of this content as a part of a page."""
    found = against(run, name, content)
    if not found.runs:
        raise InputError(
            "; ".join(found.failures)
            or "no run of this kind completed; run the case at the speed of the test",
            "test",
        )
    return test_part(found)


def _laid(run: Run, name: str, content: bytes) -> str:
    """Lay a test over a run and store it with the run; its name there. Raises :class:`InputError` with the reason why it
    cannot be.
    """
    _overlay(run, name, content)
    return keep_test(run, name, content).name


def _shown(run: Run, name: str) -> Part:
    """The comparison with a test that was laid over a run. Raises :class:`InputError` where there is
    none, or it cannot be read.
    """
    return _overlay(run, name, saved_test(run, name).path.read_bytes())


def register(app: FastAPI, desk: Desk) -> None:
    """Add the addresses of parts, downloads and uploads."""
    app.add_exception_handler(ValvetrainError, _missing)

    @app.get("/part/{case}/{stamp}")
    def part(case: str, stamp: str) -> Response:
        return _part(lambda: run_part(desk.workspace.run(f"{case}/{stamp}")))

    @app.get("/job/{case}")
    def job(case: str) -> Response:
        newest = next(iter(desk.jobs.jobs(case, 1)), None)
        return JSONResponse(None if newest is None else asdict(newest))

    @app.get("/download/{case}/{stamp}/{kind}")
    def download(case: str, stamp: str, kind: str) -> Response:
        path = desk.workspace.download(f"{case}/{stamp}", kind)  # type: ignore[arg-type]
        name = path.name if path.suffix == ".zip" else f"{case}-{stamp}-{path.name}"
        return FileResponse(path, filename=name)

    @app.get("/download-case/{case}")
    def download_case(case: str) -> Response:
        path = desk.workspace.case_folder(case) / CASE_FILE
        return FileResponse(path, filename=f"{case}.toml", media_type="application/toml")

    @app.get("/case-file/{case}/{name}")
    def case_file(case: str, name: str) -> Response:
        path = desk.workspace.side_file(case, name)
        return FileResponse(path, filename=name, media_type="application/octet-stream")

    @app.get("/part-compare")
    def part_compare(a: str, b: str) -> Response:
        return _part(lambda: comparison_part(desk.workspace.run(a), desk.workspace.run(b)))

    @app.get("/part-test/{case}/{stamp}/{name}")
    def part_test(case: str, stamp: str, name: str) -> Response:
        return _part(lambda: _shown(desk.workspace.run(f"{case}/{stamp}"), name))

    @app.post("/upload/test")
    async def upload_test(request: Request, run: str, name: str) -> Response:
        content = await request.body()
        return await _answered(lambda: {"test": _laid(desk.workspace.run(run), name, content)})

    @app.post("/upload/file")
    async def upload_file(request: Request, case: str, name: str) -> Response:
        content = await request.body()
        return await _answered(lambda: {"file": _attached(desk, case, name, content)})

    @app.post("/upload/case")
    async def upload_case(request: Request) -> Response:
        try:
            with writing("what was sent", "upload"):
                name, content, sides = await _sent_case(request)
        except ValvetrainError as error:
            return _refused(error)
        return await _answered(
            lambda: {"open": f"/case/{desk.workspace.upload(name, content, sides)}"}
        )


def _attached(desk: Desk, case: str, name: str, content: bytes) -> str:
    desk.workspace.attach(case, name, content)
    return name


async def _answered(take: Callable[[], dict[str, str]]) -> Response:
    """What was taken in, or the sentence why it was not; it is read in a thread."""
    try:
        with writing("what was sent", "upload"):
            return JSONResponse(await asyncio.to_thread(_made, take))
    except ValvetrainError as error:
        return _refused(error)


def _refused(error: ValvetrainError) -> Response:
    return JSONResponse({"refusal": str(error)})


def _missing(_: Request, error: Exception) -> Response:
    return PlainTextResponse(str(error), 404)


async def _sent_case(request: Request) -> tuple[str, bytes, dict[str, bytes]]:
    """Name and content of the case file that was sent, and the files sent with it.

    Raises :class:`InputError` for more files than a case may have, and where none or several
    of them are case files.
    """
    try:
        async with request.form(max_files=MAX_FILES + 1, max_fields=1) as form:
            sent = [
                (one.filename or "", await one.read())
                for _, one in form.multi_items()
                if isinstance(one, UploadFile)
            ]
    except HTTPException as error:
        raise InputError(
            f"what was sent cannot be read ({clipped(str(error.detail), 80)}); choose the files again",
            "upload",
        ) from None
    cases = sent if len(sent) == 1 else [one for one in sent if one[0].lower().endswith(".toml")]
    if len(cases) != 1:
        raise InputError(
            f"{len(sent)} files were sent, of which {len(cases)} are case files; choose one .toml file and what it names"
        )
    ((name, content),) = cases
    return Path(name).name, content, {other: held for other, held in sent if other != name}


def _part(make: Callable[[], Part]) -> Response:
    """A part of a page as JSON, which runs nothing where it is opened as a page."""
    return JSONResponse(_made(make), headers={"Cache-Control": "no-store"})


def _made(make: Callable[[], dict[str, str]]) -> dict[str, str]:
    """What ``make`` gives; a fault in it becomes an :class:`InputError`."""
    try:
        return make()
    except ValvetrainError:
        raise
    except (*FAULTS, RuntimeError, TemplateError) as error:
        reason = clipped(f"{type(error).__name__}: {error}", 120)
        raise InputError(f"a file of this run is damaged ({reason}); repeat it") from error
