"""Every number of a table or Dataset that a reader meets has a unit, and engine speeds are in rpm."""

from __future__ import annotations

import numpy as np
import pytest

import valvetrain as vt

TRAIN = vt.Case("template:pushrod")


def tables():
    """Name -> maker of a public table or Dataset."""
    run = vt.Case("job-t").run("2000 rpm", "multi-mass")
    swept = TRAIN.sweep("3000, 4000 rpm", "massless", ranges=False)
    varied = TRAIN.study({"train.valve.mass": ["140 g", "150 g"]}, ["peak_spring_force", "loft_gap"], sampling="grid",
                         engine_speeds="3000, 4000 rpm", models="massless")  # fmt: skip
    static = vt.static_curve("job-t")
    yield from {
        "series": swept.series(swept.labels[0], "peak_spring_force").to_dataset(),
        "sweep": swept.to_pandas(), "critical": swept.critical_speeds.to_pandas(), "run": run.to_pandas(),
        "dataset": run.channels, "cycle": run.cycle, "static": static.to_pandas(),
        "study": varied.to_pandas(), "study dataset": varied.to_xarray(),
    }.items()  # fmt: skip


@pytest.mark.filterwarnings("ignore")
@pytest.mark.slow
def test_every_series_has_a_unit():
    checked = 0
    for name, one in tables():
        if hasattr(one, "columns"):
            numbers = [str(key) for key in one.columns if one[key].dtype.kind == "f"]
            units = one.attrs["units"]
            if "unit" in one.columns:  # a row for each number, with its own
                assert all(one["unit"].astype(str) != "")
                numbers.remove("value")
        elif hasattr(one, "variables"):
            floats = [key for key, item in one.variables.items() if item.dtype.kind == "f"]
            numbers, units = (
                [str(key) for key in floats],
                {str(key): one[key].attrs.get("units") for key in floats},
            )
        else:
            continue
        for key in numbers:
            checked += 1
            assert units.get(key), (name, key)
            if key in ("engine_speed", "speed") and name not in (
                "study",
                "critical",
            ):  # which its files hold in SI
                assert units[key] == "rpm" and float(np.nanmax(one[key])) in (3000.0, 4000.0), (
                    name,
                    key,
                )
    assert checked > 40
