"""docs/models.md says what runs, and all of it is run to say so."""

from __future__ import annotations

import re
from pathlib import Path

import pytest
import write_pages as tool

import valvetrain
from valvetrain import registry
from valvetrain.parameters.loading import load_case

ROOT = Path(__file__).parents[2]
PAGE = ROOT / "docs" / "models.md"


@pytest.mark.long
def test_the_committed_page_is_what_runs():
    assert PAGE.read_text(encoding="utf-8") == tool.models_page()


def row_of(page: str, case: str) -> list[str]:
    """Cells of a case, the letters of their reasons left out."""
    (line,) = (line for line in page.splitlines() if line.startswith(f"| `{case}`"))
    return [re.sub(r" ?\(\w\)", "", cell).strip() for cell in line.strip("|").split("|")]


@pytest.mark.parametrize("case", ["job-c"])
def test_a_row_of_the_committed_page_is_what_runs(case):
    """One spring alone; the other rows are asked by the long test."""
    found = row_of(tool.models_text({case: tool.outcomes(tool.coarse(load_case(case)))}), case)
    assert found == row_of(PAGE.read_text(encoding="utf-8"), case) and "all" in found


def test_the_page_has_every_case_every_model_and_a_reason_for_every_gap():
    lines = PAGE.read_text(encoding="utf-8").splitlines()
    head = next(line for line in lines if line.startswith("| case |"))
    assert tuple(
        word.strip().strip("`") for word in head.strip("|").split("|")[1:]
    ) == registry.names("springs")
    rows = {
        line.split("`")[1]: [cell.strip() for cell in line.strip("|").split("|")[1:]]
        for line in lines
        if line.startswith("| `")
    }
    reasons = {line[2:5] for line in lines if line.startswith("- (")}
    for summary in valvetrain.list_cases():
        for cell in rows[summary.name]:
            assert cell == "all" or any(mark in reasons for mark in (cell[-3:],)), (
                summary.name,
                cell,
            )
