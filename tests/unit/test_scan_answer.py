"""Every rule on a scanned spring in a scan in which it holds and in one in which it does not; what its page and notebook show."""

from __future__ import annotations

import sys
from dataclasses import replace
from functools import cache
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
import pytest

import valvetrain as vt
from valvetrain.findings.table import explain
from valvetrain.parameters.case_changes import changed_case
from valvetrain.scan.rules import causes
from valvetrain.solution.status import Status
from valvetrain.views.results import answer_of, figures_of

sys.path.insert(0, str(Path(__file__).parents[2] / "scripts"))
from sample_scan import Scanner, cloud, ply, springs, surface

#: The spring of job-t, and the same with thicker wire as its design.
JOB = vt.load_case("job-t")


def beside(spring, width: float = 0.0):
    """A cloud (m) of a spring at the origin without points in a sector of ``width`` degrees."""
    draw = np.random.default_rng(4)
    points = surface(spring, 6000, Scanner(), draw)
    points += draw.normal(0.0, 0.03e-3, points.shape)
    return points[np.mod(np.degrees(np.arctan2(points[:, 1], points[:, 0])) - 67.0, 360.0) >= width]


@cache
def scan(name: str) -> vt.scan.ScannedSpring:
    job, known = JOB.springs[0].wire, springs()["cylindrical"]
    points = {
        "all": lambda: cloud(job, 3000, Scanner(noise=0.03e-3, seed=6))[0],
        "one-sided": lambda: beside(known, 60.0),
        "strays": lambda: cloud(known, 3000, Scanner(outliers=0.3, seed=2))[0],
        "oval": lambda: cloud(known, 4000, Scanner(seed=5), ovality=0.05)[0],
    }[name]()
    with TemporaryDirectory() as folder:
        file = Path(folder) / "scan.ply"
        file.write_bytes(ply(points))
        return vt.scan.spring_from_scan(file)


@cache
def compared(wire: str) -> vt.scan.ScanComparison:
    design = changed_case(JOB, {"spring.wire_diameter": wire})
    return vt.scan.compare_scan(scan("all"), design)


def failed() -> vt.scan.ScanComparison:
    """The design and its scan where the static curve of the design was not found."""
    study, other = compared("4 mm").rest
    curve = replace(study.rest[0].curve, status=Status("diverged", "it grew", 0.1, "spring", ""))
    return replace(
        compared("4 mm"), rest=(replace(study, rest=(replace(study.rest[0], curve=curve),)), other)
    )


RESULTS = {
    name: lambda name=name: scan(name) for name in ("all", "one-sided", "strays", "oval")
} | {"as drawn": lambda: compared("4 mm"), "thicker": lambda: compared("4.15 mm"), "failed": failed}


@pytest.mark.parametrize(
    ("code", "holds", "holds_not"),
    [
        ("Y101", "one-sided", "all"), ("Y102", "strays", "all"), ("Y110", "failed", "as drawn"), ("Y111", "thicker", "as drawn"),
        ("Y112", "as drawn", "thicker"),
        ("Y114", "thicker", "as drawn"), ("Y113", "all", "one-sided"), ("Y120", "thicker", "as drawn"), ("Y121", "oval", "all"),
    ],
)  # fmt: skip
def test_a_rule_holds_in_one_scan_and_not_in_another(code, holds, holds_not):
    assert code in answer_of(RESULTS[holds]()).findings.codes
    assert code not in answer_of(RESULTS[holds_not]()).findings.codes
    assert explain(code)["code"] == code


@pytest.mark.parametrize(
    ("quantity", "cause", "share"),
    [
        ("installed_rate", "wire diameter", 4 * (4 / 4.15 - 1)),
        ("preload", "free length", -0.15 / 7),
    ],
)
def test_the_cause_of_a_difference_is_the_size_that_moves_it_most(quantity, cause, share):
    """Closed form of a round wire; thicker wire at the same pitch makes the spring of the design longer."""
    found = compared("4.15 mm")
    drawn, made = (case.springs[0] for case in found.cases)
    assert causes(found.number(quantity), made, drawn)[cause] == pytest.approx(share, abs=0.015)
    verdict = answer_of(found).verdict
    number = found.number(verdict.quantity)
    assert verdict.value == number.scanned and verdict.fields["cause"] == "wire diameter"
    assert number.difference == pytest.approx(number.scanned / number.design - 1)


@pytest.mark.parametrize("name", RESULTS)
def test_an_answer_is_short_has_rows_figures_and_a_next_step(name):
    answer = answer_of(RESULTS[name]())
    assert len(str(answer.verdict).split()) <= 30 and 4 <= len(answer.lines) <= 12
    assert all(len(line.cells) == len(answer.headings) for line in answer.lines)
    names = list(figures_of(answer))
    assert names[0] == ("cloud" if answer.compared is None else "force") and len(names) > 1
    assert answer.verdict.code == "Y110" or answer.next_step
    marked = {one.label for one in answer.lines if one.mark == "warn"} & {"wire diameter", "turns"}
    assert marked == {one.fields["name"] for one in answer.findings.by("Y114")} & {"wire diameter", "turns"}  # fmt: skip
    assert "<table>" in answer.scan._repr_html_() and answer.scan.plot().data


def test_a_report_has_the_case_file_the_curves_and_a_page(tmp_path):
    files = scan("all").report(tmp_path, compared=compared("4 mm"))
    assert {path.name for path in files.data} == {"spring.toml", "curves.csv"}
    assert files.page.stat().st_size < 2.3e6
    spring = vt.load_case(str(tmp_path / "spring.toml")).springs[0]
    assert spring.installed_height == pytest.approx(JOB.springs[0].installed_height, abs=5e-5)
