"""Every rule on two identifications, one in which it holds and one in which it does not; rows, tables and figures of one."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from functools import cache

import numpy as np
import pytest

import valvetrain as vt
from valvetrain.explore import Datum, Prior, Search
from valvetrain.explore.identification_answer import IdentificationAnswer
from valvetrain.explore.identification_rules import data_name
from valvetrain.explore.identified import Identified
from valvetrain.views.results import figures_of

RATE = {"rate": Prior("uniform", 20e3, 60e3)}
BOTH = RATE | {"mass": Prior("normal", centre=0.05, spread=0.01)}
SEAT, SURGE = Datum("seat load", 280.0, 2.0), Datum("surge", 447.0, 3.0)
OPEN = Datum("open load", 680.0, 4.0)


def spring(points: np.ndarray) -> list[dict[str, float]]:
    """Loads (N) and surge frequency (Hz) by rate (N/m) and, where it is unknown, mass (kg)."""
    found = []
    for rate, *mass in points.tolist():
        loads = {"seat load": 7e-3 * rate, "open load": 17e-3 * rate}
        found.append(loads | {"surge": 0.5 * math.sqrt(rate / mass[0])} if mass else loads)
    return found


def in_parallel(points: np.ndarray) -> list[dict[str, float]]:
    return [{"seat load": 7e-3 * float(row.sum()), "open load": 17e-3 * float(row.sum())} for row in points]  # fmt: skip


def square(points: np.ndarray) -> list[dict[str, float]]:
    return [{"square": x * x} for (x,) in points]


def bent(points: np.ndarray) -> list[dict[str, float]]:
    return [{"bent": 0.3 * math.tanh(x / 0.3)} for (x,) in points]


TWINS = {name: Prior("normal", centre=centre, spread=5e3) for name, centre in (("outer_rate", 30e3), ("inner_rate", 15e3))}  # fmt: skip
#: Name -> priors, data, computation, search.
RUNS: dict[str, tuple[dict[str, Prior], list[Datum], Callable, Search]] = {
    "both": (BOTH, [SEAT, OPEN, SURGE], spring, Search()),
    "as many": (BOTH, [SEAT, SURGE], spring, Search()),
    "one": (RATE, [SEAT, OPEN], spring, Search()),
    "wide": ({"rate": Prior("log-uniform", 2e3, 2e6)}, [replace(SEAT, scatter=90.0)], spring, Search()),
    "narrow": ({"rate": Prior("log-uniform", 2e3, 2e6)}, [SEAT, OPEN], spring, Search()),
    "open": (BOTH, [SEAT, OPEN, replace(SURGE, scatter=900.0)], spring, Search()),
    "tied": (TWINS, [replace(SEAT, value=320.0), replace(OPEN, value=777.0)], in_parallel, Search()),
    "bound": ({"rate": Prior("uniform", 20e3, 39.8e3)}, [SEAT, OPEN], spring, Search()),
    "refused": (RATE, [SEAT, replace(OPEN, value=780.0)], spring, Search()),
    "missed": (RATE, [replace(SEAT, value=275.0), *(Datum(f"open load {k}", 680.0, 4.0) for k in range(9))],
               lambda points: [{"seat load": 7e-3 * rate, **{f"open load {k}": 17e-3 * rate for k in range(9)}} for (rate,) in points], Search()),
    "unlike": (RATE, [SEAT, replace(OPEN, value=900.0, used=False)], spring, Search()),
    "like": (RATE, [SEAT, replace(OPEN, used=False)], spring, Search()),
    "two": ({"x": Prior("uniform", -2.0, 2.5)}, [Datum("square", 1.0, 0.05)], square, Search(starts=6, keep=6)),
    "bent": ({"x": Prior("uniform", -50.0, 50.0)}, [Datum("bent", 0.0, 1.0)], bent, Search()),
}  # fmt: skip


@cache
def run(name: str) -> Identified:
    priors, data, evaluate, search = RUNS[name]
    return vt.identify(priors, data, evaluate, search=search)


def answer(name: str) -> IdentificationAnswer:
    return IdentificationAnswer(run(name))


def stopped() -> IdentificationAnswer:
    return IdentificationAnswer(replace(run("both"), whole=False))


#: Code -> a run in which it holds with fields, and one in which it does not.
RULES = {
    "I102": ("refused", {"name": "seat load"}, "both"),
    "I103": ("open", {"names": "mass", "first": "mass"}, "both"),
    "I104": ("bound", {"names": "rate"}, "one"),
    "I105": ("two", {"count": "2", "name": "x", "values": "−1.00 or 1.00"}, "one"),
    "I106": ("both", {"met": "3 of 3", "command": ""}, "open"),
    "I110": ("missed", {"name": "seat load"}, "both"),
    "I111": ("unlike", {"name": "open load", "count": "1 of 1"}, "like"),
    "I112": ("as many", {"used": "2", "count": "2"}, "like"),
    "I113": ("bent", {}, "both"),
}


@pytest.mark.parametrize("code", RULES)
def test_a_rule_holds_where_it_must_and_nowhere_else(code: str) -> None:
    name, fields, other = RULES[code]
    (found,) = answer(name).findings.by(code)
    assert {key: found.fields[key] for key in fields} == fields
    assert code not in answer(other).findings.codes


def test_the_verdict_of_each() -> None:
    names = ("both", "one", "as many", "like", "open", "tied", "bound", "refused", "two")
    verdicts = {name: answer(name).verdict.code for name in names}
    assert verdicts == {
        "both": "I106", "one": "I106", "as many": "I112", "like": "I106",
        "open": "I103", "tied": "I103", "bound": "I104", "refused": "I102", "two": "I105",
    }  # fmt: skip
    assert (
        answer("as many").verdict.mark == "warn" and "I106" not in answer("as many").findings.codes
    )
    assert stopped().verdict.code == "I101" and "I106" not in stopped().findings.codes


def test_what_cannot_be_told_apart_is_no_number() -> None:
    found = answer("tied")
    assert found.result.branches[0].information.groups == ((0, 1),)
    assert found.findings[0].fields["names"] == "any unknown"
    rows = found.lines[:2]
    assert all(row.mark == "warn" and not any(char.isdigit() for char in row.cells[1]) for row in rows)  # fmt: skip
    assert {row.remark.rpartition("with ")[2] for row in rows} == {"outer rate", "inner rate"}


def test_a_range_of_more_than_a_factor_of_two_determines_nothing() -> None:
    wide, narrow = run("wide").branches[0], run("narrow").branches[0]
    assert wide.information.determined[0] > 0.9  # the prior spans a factor of a thousand
    assert answer("wide").findings.codes[0] == "I103"
    assert answer("narrow").findings.codes[0] == "I106"
    assert narrow.quantities["rate"].high < 2 * narrow.quantities["rate"].low


def test_rows_of_unknowns_and_data() -> None:
    found = answer("like")
    assert [row.label for row in found.lines] == ["rate", "data used", "data not used"]
    assert found.lines[0].cells[:2] == ("40000", "40000")
    assert all(row.mark == "ok" for row in found.lines)
    assert found.lines[1].cells[:2] == ("1 of 1 met", "1 of 1 met")
    many = answer("missed").tables()["data"]
    assert len(many.rows) == 10 and {len(row) for row in many.rows} == {len(many.columns)}


def test_figures_show_what_the_verdict_is_about() -> None:
    assert list(figures_of(answer("both"))) == ["unknowns", "data"]
    assert list(figures_of(answer("refused"))) == ["data", "unknowns"]
    (start, value), off = figures_of(answer("refused"))["data"].data, run("refused").predicted
    assert sorted(map(float, value.x)) == pytest.approx(sorted(one.off for one in off))
    assert list(start.y) == list(value.y) and set(value.y) == {data_name(one.datum) for one in off}
