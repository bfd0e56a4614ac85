"""A run on finite elements whose valve floats until its coils are solid: a status of that
run, the others are there and written.

vaz-ohc at 14 000 rpm ended so, without a file, in two minutes; the bucket tappet below does in two
seconds.
"""

from __future__ import annotations

import json

from unit.cli_parts import call, typed
from valvetrain.parameters.templates import TEMPLATES

SHORT = {
    "train.springs.stock.0.total_coils": "3.6", "train.springs.stock.0.installed_height": "15.5 mm", "lift_law.maximum_lift": "2.4 mm",
    "train.springs.stock.0.options.finite-element.elements_per_coil": "6",
}  # fmt: skip


def test_it_is_the_status_of_that_run(tmp_path):
    changes = [word for path, value in SHORT.items() for word in ("--set", f"{path}={value}")]
    result = call(
        "run",
        str(TEMPLATES / "direct.toml"),
        *changes,
        *typed("--model finite-element --rpm '6000, 18000 rpm' --workers 1 --output"),
        str(tmp_path / "out"),
        "--no-report",
    )
    assert result.exit_code == 1 and "Traceback" not in result.stderr
    (told,) = [line for line in result.stderr.splitlines() if line.startswith("failed: ")]
    assert "finite-element at 18000 rpm: coil-bind: spring 'spring' is solid at " in told
    runs = json.loads((tmp_path / "out" / "run.json").read_text())["runs"]
    assert [one["status"]["code"] for one in runs] == ["completed", "coil-bind"]
    assert all(one["quantities"]["peak_spring_force"]["value"] > 100 for one in runs)
    assert {path.name for path in (tmp_path / "out").glob("*.nc")} == {
        "finite-element-6000rpm.nc",
        "finite-element-18000rpm.nc",
    }
