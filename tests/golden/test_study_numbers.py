"""Golden: everything that small studies answer as JSON, entry by entry; run this file to write it
anew.

Quantities are held to formulas by ``tests/unit/test_every_quantity.py``; here no entry of an answer
may move, appear or go unsaid.
"""

from __future__ import annotations

import sys
from functools import cache
from pathlib import Path
from typing import Any

import pytest

if __name__ == "__main__":
    sys.path.insert(0, str(Path(__file__).parents[1]))

from known_sums import read, same, sums, write
from unit.cli_parts import PUBLISHED, SMALL
from valvetrain.parameters.loading import parse_case
from valvetrain.parameters.templates import TEMPLATES
from valvetrain.report.json import study_json
from valvetrain.runs.compare import compare_study
from valvetrain.runs.run import run_study, sweep_study
from valvetrain.runs.statics import static_study

KEPT = Path(__file__).parent / "study_numbers.json"
#: What differs from one machine, version or run to the next.
FLEETING = (
    "version",
    "time_taken",
    "seconds",
    "created",
    "digest",
    "platform",
    "python",
    "wall",
    "duration_of",
    "processor",
    "residual",
)
RPM = 3.141592653589793 / 30
LOOK = {"models": ("massless", "multi-mass", "finite-element"), "speeds": (3000 * RPM, 9000 * RPM)}


def entries(found: Any) -> Any:
    """An answer with its rows of numbers in sums, without what is of the day."""
    if isinstance(found, dict):
        return {
            key: entries(value)
            for key, value in found.items()
            if not any(word in key for word in FLEETING)
        }
    if isinstance(found, (list, tuple)):
        if found and all(
            isinstance(one, (int, float)) and not isinstance(one, bool) for one in found
        ):
            return sums(found)
        return {str(place): entries(one) for place, one in enumerate(found)}
    return float(found) if isinstance(found, int) and not isinstance(found, bool) else found


def template(kind: str) -> Any:
    return parse_case((TEMPLATES / f"{kind}.toml").read_text(encoding="utf-8"), kind)


@cache
def told(name: str) -> dict[str, Any]:
    """One study of each command."""
    small = parse_case(SMALL + PUBLISHED, "small")
    if name == "run":
        study = run_study(
            small, engine_speeds=(9000 * RPM,), spring_models=LOOK["models"], workers=1
        )
    elif name == "compare":
        study = compare_study(
            small, engine_speeds=LOOK["speeds"], spring_models=("massless", "multi-mass"), workers=1
        )
    elif name == "static":
        study = static_study(
            small, LOOK["models"], command="static", steps=6, heights=(20e-3,), loads=(100.0,)
        )
    elif name == "modes":
        study = static_study(
            small, ("finite-element",), command="modes", modes=5, attached_mass=0.05
        )
    elif name == "sweep":
        study = sweep_study(
            small, engine_speeds=LOOK["speeds"], spring_models=("multi-mass",), workers=1
        )
    else:
        study = run_study(
            template(name), engine_speeds=(3000 * RPM,), spring_models=("massless",), workers=1
        )
    return entries(study_json(study))


NAMES = ("run", "compare", "static", "modes", "sweep", "direct", "pushrod")


@pytest.mark.parametrize("name", NAMES)
def test_an_answer_is_what_it_was(name):
    assert not same(told(name), read(KEPT)[name], 2e-5)


if __name__ == "__main__":
    write(KEPT, {name: told(name) for name in NAMES})
