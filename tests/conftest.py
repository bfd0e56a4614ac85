"""One thread per worker; tests that need a missing program are skipped, or fail under CI=true."""

from __future__ import annotations

import os

import pytest

from system_parts import PROGRAMS, program, under_ci

for variable in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "NUMBA_NUM_THREADS"):
    os.environ.setdefault(variable, "1")


import one_parser  # noqa: E402, F401
from package_watch import package_stays_whole  # noqa: E402, F401
from valvetrain import session  # noqa: E402

#: Set to 1, the long tests run too; ``make test-long`` runs them alone.
LONG = "VALVETRAIN_LONG"


#: Files that take longest, longest first: begun first, so that no worker ends with one of them alone.
FIRST = (
    "test_workbench_browser", "test_code_blocks", "test_report_browser", "test_docstring_examples", "test_how_to",
    "test_workbench_files_browser", "test_motion_browser", "test_workbench_under_faults", "test_defaults_against_finest",
    "test_solid_in_motion", "test_solid_in_train", "test_killed_commands", "test_workers_and_signals", "test_added_laws",
    "test_output_samples", "test_cli_process", "test_damaged_files", "test_cli_runs", "test_cli_streams", "test_studies",
    "test_no_result_is_lost", "test_refinement_stopped", "test_lift_command", "test_options_of_commands", "test_card_default",
    "test_spring_models", "test_workbench_jobs", "test_python_cases", "test_scan_command", "test_study_command",
    "test_identification_goes_on", "test_springs_from_scans", "test_imports", "test_own_parts", "test_train_cli",
    "test_identification_closed_forms", "test_critical_speeds", "test_read_apart", "test_workbench_live",
)  # fmt: skip


@pytest.fixture(autouse=True)
def no_case_of_a_command():
    """Each test begins as a program does, in which no command line has named a case."""
    session.call_case([])


def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> None:
    items.sort(
        key=lambda item: FIRST.index(item.path.stem) if item.path.stem in FIRST else len(FIRST)
    )
    if os.environ.get(LONG) != "1":
        left = [item for item in items if item.get_closest_marker("long")]
        config.hook.pytest_deselected(items=left)
        items[:] = [item for item in items if not item.get_closest_marker("long")]


def pytest_runtest_setup(item: pytest.Item) -> None:
    for marker, (_, package) in PROGRAMS.items():
        if item.get_closest_marker(marker) and program(marker) is None:
            give_up = pytest.fail if under_ci() else pytest.skip
            give_up(f"{package} is not installed; 'make test' as root on Debian installs it")
