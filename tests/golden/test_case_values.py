"""Golden: every value that is read from the cases that ship, the templates and the examples of the
guides; run this file to write anew.

That each key means what its guide says is shown elsewhere; here no value of a case that people have
may move unsaid.
"""

from __future__ import annotations

import dataclasses
import re
import sys
from collections.abc import Iterator, Mapping
from enum import Enum
from pathlib import Path
from typing import Any

import numpy as np
import pytest

if __name__ == "__main__":
    sys.path.insert(0, str(Path(__file__).parents[1]))

from valvetrain.cam.build import build_lift_law
from valvetrain.cli.case_facts import case_facts
from valvetrain.errors import InputError
from valvetrain.parameters.loading import LIBRARY, parse_case
from valvetrain.parameters.templates import KINDS, TEMPLATES

KEPT = Path(__file__).parent / "case_values"
DOCS = Path(__file__).parents[2] / "docs"
ANGLES = np.radians(np.arange(0.0, 360.0, 7.5))


def texts() -> Iterator[tuple[str, str]]:
    """Name and text of every case file that people are given."""
    for path in sorted(LIBRARY.glob("*.toml")):
        yield path.stem, path.read_text(encoding="utf-8")
    for kind in KINDS:
        yield f"template-{kind}", (TEMPLATES / f"{kind}.toml").read_text(encoding="utf-8")
    for page in sorted(DOCS.glob("case-files*.md")):
        for place, block in enumerate(
            re.findall(r"```toml\n(.*?)```", page.read_text(encoding="utf-8"), flags=re.S)
        ):
            yield f"{page.stem}-{place}", block


def leaves(found: Any, where: str) -> Iterator[str]:
    """One line a value, with its place; long rows of numbers by their sums."""
    if dataclasses.is_dataclass(found) and not isinstance(found, type):
        for one in dataclasses.fields(found):
            if not one.name.startswith("_") and one.name not in (
                "text",
                "notes",
                "citations",
                "folder",
                "path",
            ):
                yield from leaves(getattr(found, one.name), f"{where}.{one.name}")
    elif isinstance(found, Mapping):
        for key in sorted(found, key=str):
            yield from leaves(found[key], f"{where}.{key}")
    elif isinstance(found, np.ndarray) or (
        isinstance(found, tuple) and len(found) > 8 and all(isinstance(one, float) for one in found)
    ):
        row = np.asarray(found, dtype=float).ravel()
        yield f"{where} = {len(row)} numbers, {row.sum():.9g}, {row @ np.cos(np.arange(len(row))):.9g}"
    elif isinstance(found, (tuple, list)):
        for place, one in enumerate(found):
            yield from leaves(one, f"{where}[{place}]")
    elif isinstance(found, float):
        yield f"{where} = {found:.9g}"
    elif found is None or isinstance(found, (str, int, bool, Enum)):
        yield f"{where} = {found!r}"
    else:
        yield f"{where} = a {type(found).__name__}"


def told(name: str, text: str) -> str:
    """Every value of a case, what is said of it and how far its lift law lifts; the reason where a
    block is no whole case.
    """
    try:
        case = parse_case(text, name)
    except InputError as error:
        return f"{error.where}: {error.reason}\n"
    lines = list(leaves(case, "case"))
    lines += [f"{subject}: {words}" for subject, words in case_facts(case)]
    if case.lift_law is not None:
        law = build_lift_law(case.lift_law)
        for order in range(4):
            row = np.asarray(law.lift(ANGLES, order))
            told = (
                row.sum() if abs(row.sum()) > 1e-12 * np.abs(row).sum() else 0.0
            )  # what rounding leaves differs between processors
            lines.append(
                f"lift, derivative {order}: {told:.8g}, {row @ np.cos(np.arange(len(row))):.8g}, {np.abs(row).max():.8g}"
            )
    return "\n".join(lines) + "\n"


CASES = dict(texts())


@pytest.mark.parametrize("name", CASES)
def test_a_case_says_what_it_said(name):
    assert told(name, CASES[name]) == (KEPT / f"{name}.txt").read_text(encoding="utf-8")


if __name__ == "__main__":
    KEPT.mkdir(exist_ok=True)
    for name, text in CASES.items():
        (KEPT / f"{name}.txt").write_text(told(name, text), encoding="utf-8")
