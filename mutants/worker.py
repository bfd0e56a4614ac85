"""One worker: its own copy, one fault after the other, each judged by a fresh process in which only
the libraries stand ready.
"""

from __future__ import annotations

import ast
import json
import os
import signal
import sys
import time
from importlib import import_module
from pathlib import Path
from typing import Any

import pytest

from mutants.copies import compiles, drop_kernels, restore_kernels
from mutants.faults import Fault, seeded


class Order:
    """Runs the chosen tests in their order, up to the first that fails, and writes down what it
    says.
    """

    def __init__(self, nodes: list[str], answer: Path) -> None:
        self.rank, self.answer = {node: place for place, node in enumerate(nodes)}, answer

    def pytest_sessionstart(self, session: pytest.Session) -> None:
        self.session = session

    @pytest.hookimpl(trylast=True)
    def pytest_collection_modifyitems(self, items: list[pytest.Item]) -> None:
        items[:] = sorted(
            (item for item in items if item.nodeid in self.rank),
            key=lambda item: self.rank[item.nodeid],
        )

    def pytest_runtest_logreport(self, report: Any) -> None:
        if report.failed:
            self._tell(report.nodeid, report)
            self.session.shouldstop = "noticed"

    def pytest_collectreport(self, report: Any) -> None:
        if report.failed:
            self._tell(report.nodeid, report)

    def _tell(self, node: str, report: Any) -> None:
        crash = getattr(report.longrepr, "reprcrash", None)
        self.answer.write_text(f"{node} | {str(crash.message if crash else report.longrepr)[:200]}")


def judge(copy: Path, nodes: list[str], limit: float) -> tuple[str, str]:
    """(verdict, first test that failed): noticed, unseen or endless."""
    answer = copy.with_suffix(".answer")
    answer.unlink(missing_ok=True)
    begun = time.monotonic()
    child = os.fork()
    if not child:
        os.setsid()
        os.chdir(copy)
        with open(copy.with_suffix(".log"), "w") as log:
            os.dup2(log.fileno(), 1)
            os.dup2(log.fileno(), 2)
        files = list(dict.fromkeys(node.split("::")[0] for node in nodes))
        code = pytest.main(
            ["-q", "--tb=short", "-p", "no:cacheprovider", *files], plugins=[Order(nodes, answer)]
        )
        os._exit(int(code))
    while time.monotonic() - begun < limit:
        done, status = os.waitpid(child, os.WNOHANG)
        if done:
            if os.waitstatus_to_exitcode(status) == 0:
                return "unseen", ""
            return (
                "noticed",
                answer.read_text()
                if answer.exists()
                else f"exit {os.waitstatus_to_exitcode(status)}",
            )
        time.sleep(0.05)
    os.killpg(child, signal.SIGKILL)
    os.waitpid(child, 0)
    if answer.exists():
        return "noticed", answer.read_text()
    return "endless", f"no end in {limit:.0f} s"


def seed_and_judge(
    base: Path, copy: Path, fault: Fault, nodes: list[str], limit: float
) -> tuple[str, str]:
    """Seeds one fault into the copy, asks the tests and takes it out again."""
    path = copy / "src" / "valvetrain" / fault.file
    text, times = path.read_text(encoding="utf-8"), path.stat()
    below = f"valvetrain/{fault.file}"
    dropped = (
        drop_kernels(copy, below) if _reaches_kernels(text, fault.line, compiles(below)) else []
    )
    try:
        path.write_text(seeded(text, fault), encoding="utf-8")
        return judge(copy, nodes, limit + (300.0 if dropped else 0.0))
    finally:
        path.write_text(text, encoding="utf-8")
        os.utime(path, ns=(times.st_atime_ns, times.st_mtime_ns))
        for old in (path.parent / "__pycache__").glob(f"{path.stem}.*.pyc"):
            old.unlink()
        restore_kernels(base, copy, dropped)


def _reaches_kernels(text: str, line: int, kernels_here: bool) -> bool:
    """Whether compiled code may hold the line: all outside functions (constants are built in); of a
    file with ``kernels_here`` the
    functions that are decorated, hold decorated ones, or speak of the compiler."""
    functions = [node for node in ast.walk(ast.parse(text)) if isinstance(node, ast.FunctionDef)]
    around = [
        node
        for node in functions
        if min([node.lineno, *(mark.lineno for mark in node.decorator_list)])
        <= line
        <= (node.end_lineno or 0)
    ]
    if not around or not kernels_here:
        return not around
    inside = [
        one for one in ast.walk(around[0]) if isinstance(one, ast.FunctionDef)
    ]  # a walk meets the outermost first
    return any(one.decorator_list for one in inside) or "njit" in ast.dump(around[0])


def main() -> None:
    """Reads tasks, one JSON a line, and answers each with one line."""
    for library in (
        "numba",
        "scipy.optimize",
        "xarray",
        "pydantic",
        "pint",
        "tomlkit",
        "typer",
        "rich",
        "jinja2",
        "hypothesis",
    ):
        import_module(library)
    base, copy = Path(sys.argv[1]), Path(sys.argv[2])
    for line in sys.stdin:
        task = json.loads(line)
        begun = time.monotonic()
        verdict, by = seed_and_judge(
            base, copy, Fault(**task["fault"]), task["tests"], task["limit"]
        )
        print(
            json.dumps(
                {"verdict": verdict, "by": by, "seconds": round(time.monotonic() - begun, 1)}
            ),
            flush=True,
        )


if __name__ == "__main__":
    main()
