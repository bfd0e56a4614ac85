"""Contract: a value of a case that has its unit is taken as written in every spring model, with a
warning where it is unusual; a bare number from Python is doubted where it stands. On an own case.
"""

from __future__ import annotations

import subprocess
import sys
import warnings

import pytest

import valvetrain as vt
from valvetrain.errors import InputError, UnusualValueWarning

LIFT = {
    "kind": "polynomial", "exponents": "3-4-5", "maximum_lift": "2 mm", "opening_start": "100 deg", "opening_end": "160 deg",
    "closing_start": "160 deg", "closing_end": "220 deg",
}  # fmt: skip


def soft(rate: object) -> vt.Case:
    """A case of an instrument's spring, far softer than those of engines."""
    spring = vt.Spring(rate=rate, preload="0.05 N", mass="1 g")
    return vt.Case(name="own", spring=spring, lift_law=LIFT, engine_speeds="60 rpm")


@pytest.mark.parametrize("model", ["massless", "modal-uniform", "multi-mass", "wave-rod"])
def test_a_rate_with_its_unit_is_believed_by_every_model(model):
    with pytest.warns(UnusualValueWarning, match="'10 N/m' of spring rate is unusual"):
        case = soft("10 N/m")
    run = case.run(None, model)
    assert run.status.completed
    # preload and rate times lift: 0.05 N + 10 N/m x 2 mm
    assert run.quantities["peak_spring_force"] == pytest.approx(0.07, rel=0.02)


def test_a_bare_rate_is_doubted_at_its_key():
    with pytest.raises(InputError, match=r"spring\.rate: 41 N/m of spring rate can only be meant"):
        soft(41)


def test_speeds_with_their_unit_are_believed_by_a_case_of_python():
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        case = vt.Case("job-t", engine_speeds="1680 rad/s")
    assert case.parameters.operation.engine_speeds == pytest.approx((1680.0,))


def test_the_command_prints_the_warning_as_one_line(tmp_path):
    with pytest.warns(UnusualValueWarning):
        soft("10 N/m").save(tmp_path / "own.toml")
    done = subprocess.run(
        [sys.executable, "-m", "valvetrain", "check", str(tmp_path / "own.toml")],
        capture_output=True, text=True, check=False,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    assert done.stderr.startswith("warning: '10 N/m' of spring rate is unusual")
    assert "inputs.py" not in done.stderr
