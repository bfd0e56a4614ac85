"""Unit: every number of an identification's answer and of its draws stands beside the unit it is
in, SI, whatever unit it was given in.
"""

from __future__ import annotations

import json
from dataclasses import asdict
from pathlib import Path

import pytest

from study_parts import identification_plan
from unit.cli_parts import call
from valvetrain.explore.execution import Execution
from valvetrain.explore.identification_answer import IdentificationAnswer
from valvetrain.explore.identify import run_identification

CARD = 'title = "card"\n[spring]\npreload = "250 N"\nrate = "32 N/mm"\nmass = "42 g"\n'
FILE = """
case = "card.toml"
[search]
draws = 6
[quantities.rate]
key = "spring.rate"
prior = "uniform"
low = "25 N/mm"
high = "40 N/mm"
[measurements.load]
compressions = "12 mm"
forces = "388 N"
scatter = "4 N"
spring_model = "massless"
[measurements.ringing]
frequencies = "430 Hz"
scatter = "1 %"
spring_model = "wave-rod"
fit = false
[predictions.float]
quantity = "preload"
"""


def test_the_answer_tells_si_values_with_their_units(tmp_path: Path) -> None:
    (tmp_path / "card.toml").write_text(CARD)
    (tmp_path / "rate.toml").write_text(FILE)
    words = (str(tmp_path / "rate.toml"), "--json", "--workers", "1", "--output", str(tmp_path / "out"))  # fmt: skip
    done = call("identify", *words)
    assert done.exit_code == 0, done.stderr
    told = json.loads(done.stdout)
    found = run_identification(identification_plan(FILE, "card", tmp_path), Execution(workers=1))
    rate = found.branches[0].quantities["rate"]
    assert 31e3 < rate.best < 34e3
    codes = [one["code"] for one in told["findings"]]
    assert codes == ["I106"] and "verdict" not in told
    assert told["start"] == {"rate": 32e3} and told["units"] == {"rate": "N/m"}
    assert told["branches"][0]["quantities"]["rate"] == asdict(rate)
    load, ringing = told["predicted"]
    assert (load["datum"]["value"], load["datum"]["scatter"]) == (388.0, 4.0)
    assert load["datum"]["used"] and not ringing["datum"]["used"]
    assert ringing["datum"]["value"] == 430.0 and ringing["datum"]["scatter"] == pytest.approx(4.3)
    assert (load["datum"]["unit"], ringing["datum"]["unit"]) == ("N", "Hz")
    assert [row["best"] for row in (load, ringing)] == [one.best for one in found.predicted]
    assert load["best"] == pytest.approx(0.012 * rate.best, rel=1e-9)
    (preload,) = told["predictions"]
    assert preload["best"] == pytest.approx(250.0) and preload["unit"] == "N"


def test_the_verdict_calls_an_unknown_by_its_label(tmp_path: Path) -> None:
    (tmp_path / "card.toml").write_text(CARD)
    text = FILE.replace("[quantities.rate]", "[quantities.stiffness]")
    found = run_identification(identification_plan(text, "card", tmp_path), Execution(workers=1))
    assert IdentificationAnswer(found).verdict.fields["subject"] == "stiffness"
