"""A pytest plugin: which test enters which functions of the package, in its own process.

Active where VALVETRAIN_TRAIL names a file: one JSON object {"import": [places], "tests": {node:
{"seconds", "places"}}, "failed"}; a place
is ``path below src:name of the function``, which outlives changes of other lines. What a fixture of
a module enters counts for each test
that uses the fixture, since the others of the module find its result ready.
"""

from __future__ import annotations

import json
import os
import sys
import threading
import time
from collections.abc import Iterator
from pathlib import Path
from types import CodeType
from typing import Any

import pytest


class Steps:
    """Functions of the package entered since ``start``."""

    def __init__(self, source: str) -> None:
        self.source = source + os.sep
        self.codes: set[CodeType] = set()

    def note(self, frame: Any, _event: str, _argument: object) -> None:
        """The trace function: one call a function, none a line."""
        self.codes.add(frame.f_code)

    def start(self) -> None:
        self.codes = set()
        threading.settrace(self.note)
        sys.settrace(self.note)

    def stop(self) -> set[str]:
        sys.settrace(None)
        threading.settrace(None)  # type: ignore[arg-type, unused-ignore]
        cut = len(self.source)
        return {
            f"{code.co_filename[cut:]}:{code.co_qualname}"
            for code in self.codes
            if code.co_filename.startswith(self.source)
        }


class Trail:
    """Collects the steps of each test; fixtures keep their own."""

    def __init__(self, file: Path, source: Path) -> None:
        self.file = file
        self.steps = Steps(str(source))
        self.tests: dict[str, dict[str, Any]] = {}
        self.fixtures: dict[int, set[str]] = {}
        self.failed: set[str] = set()
        self.steps.start()
        self.imported: set[str] = set()

    def pytest_collection_finish(self) -> None:
        self.imported = self.steps.stop()

    @pytest.hookimpl(wrapper=True)
    def pytest_fixture_setup(self, fixturedef: Any) -> Iterator[None]:
        before, self.steps.codes = self.steps.codes, set()
        sys.settrace(self.steps.note)
        try:
            return (yield)
        finally:
            mine = self.steps.codes
            self.fixtures[id(fixturedef)] = self.steps.stop()
            self.steps.start()
            self.steps.codes = before | mine

    @pytest.hookimpl(wrapper=True)
    def pytest_runtest_protocol(self, item: Any) -> Iterator[None]:
        begun = time.perf_counter()
        self.steps.start()
        try:
            return (yield)
        finally:
            places = self.steps.stop()
            for known in item._fixtureinfo.name2fixturedefs.values():
                for one in known:
                    places |= self.fixtures.get(id(one), set())
            self.tests[item.nodeid] = {
                "seconds": round(time.perf_counter() - begun, 3),
                "places": sorted(places),
            }

    def pytest_runtest_logreport(self, report: Any) -> None:
        self.failed |= {report.nodeid} if report.failed else set()

    def pytest_sessionfinish(self) -> None:
        self.file.write_text(
            json.dumps(
                {
                    "import": sorted(self.imported),
                    "tests": self.tests,
                    "failed": sorted(self.failed),
                }
            )
        )


def pytest_configure(config: pytest.Config) -> None:
    """Begins before the test file is imported."""
    if file := os.environ.get("VALVETRAIN_TRAIL"):
        config.pluginmanager.register(
            Trail(Path(file), Path(config.rootpath) / "src" / "valvetrain")
        )
