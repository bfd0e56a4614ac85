"""One thread per worker; tests that need a missing program are skipped, or fail under CI=true."""

from __future__ import annotations

import os

import pytest

from system_parts import PROGRAMS, program, under_ci

for variable in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "NUMBA_NUM_THREADS"):
    os.environ.setdefault(variable, "1")


import chart_watch  # noqa: E402, F401
import table_watch  # noqa: E402, F401  before any module takes the function that it watches

#: Set to 1, the long tests run too; ``make test-long`` runs them alone.
LONG = "VALVETRAIN_LONG"


def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> None:
    if os.environ.get(LONG) != "1":
        left = [item for item in items if item.get_closest_marker("long")]
        config.hook.pytest_deselected(items=left)
        items[:] = [item for item in items if not item.get_closest_marker("long")]


def pytest_runtest_setup(item: pytest.Item) -> None:
    for marker, (_, package) in PROGRAMS.items():
        if item.get_closest_marker(marker) and program(marker) is None:
            give_up = pytest.fail if under_ci() else pytest.skip
            give_up(f"{package} is not installed; 'make test' as root on Debian installs it")
