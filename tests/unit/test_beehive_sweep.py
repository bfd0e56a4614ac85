"""Unit: the sweep of the beehive's draws, from forces of known numbers: where they jump,
percentiles, each cell and line; draws and points
are those of the kept identification."""

from __future__ import annotations

import json
import sys

import numpy as np
import pytest
import xarray as xr

from architecture.layout import ROOT
from beehive_parts import assert_written_anew

sys.path.insert(0, str(ROOT / "scripts"))
import sweep_beehive_studies as script

from valvetrain.explore.evaluate import evaluate_case
from valvetrain.explore.identification_file import read_request
from valvetrain.explore.paths import vary
from valvetrain.explore.point import Point, Wanted

SPEEDS = np.array([4000.0, 5000.0, 6000.0, 7000.0])


def test_the_jump_lies_where_a_straight_line_first_passes_the_force_between():
    force = np.array([
        [900.0, 1000.0, 1400.0, 900.0],  # passes 1200 N in the middle
        [900.0, np.nan, 1500.0, 1600.0],  # a run that failed is passed over
        [900.0, 900.0, 900.0, 900.0],
        [1300.0, 900.0, 900.0, 900.0],
    ])  # fmt: skip
    assert script.jumps(force, SPEEDS) == pytest.approx(
        [5500.0, 5000.0, np.nan, 4000.0], nan_ok=True
    )


def kept_of(factor: float) -> dict:
    force = factor * np.outer([0.9, 1.0, 1.1], np.linspace(800.0, 2000.0, len(script.SPEEDS)))
    force[0, -1] = np.nan
    return script.summary(force, 1e-3 * force / factor)


def test_what_is_kept_holds_percentiles_by_speed_and_failed_runs():
    found = kept_of(1.0)
    assert (found["draws"], found["failed_runs"], found["never_jumps"]) == (3, 1, 0)
    assert found["peak_spring_force_N"]["50 %"][0] == 800.0 and found["peak_spring_force_N"][
        "50 %"
    ][-1] == pytest.approx(2100.0)
    assert found["peak_spring_force_N"]["95 %"][0] == pytest.approx(872.0) and found[
        "clash_energy_mJ"
    ]["50 %"][0] == pytest.approx(800.0)
    assert found["jump_rpm"]["50 %"] == pytest.approx(8000, abs=2)
    gone = np.full((3, len(script.SPEEDS)), 900.0)
    gone[:, -1] = np.nan
    assert script.summary(gone, gone)["peak_spring_force_N"]["5 %"][-2:] == [900.0, None], (
        "no draw came to its end at the highest speed"
    )
    low = script.summary(np.full((3, len(script.SPEEDS)), 900.0), np.zeros((3, len(script.SPEEDS))))
    assert low["never_jumps"] == 3 and low["jump_rpm"]["50 %"] is None


def test_table_and_picture_carry_each_study_under_its_name(tmp_path):
    kept = {
        "engine_speed_rpm": script.SPEEDS.tolist(),
        "blind": kept_of(1.0),
        "joint": kept_of(2.0),
    }
    lines = script.table(kept).splitlines()
    assert lines[0] == "| engine speed | blind, peak spring force | joint, peak spring force |"
    assert lines[2] == "| 4000 rpm | 800 (728 to 872) N | 1600 (1456 to 1744) N |"
    assert len(lines) == 7 + len(script.SHOWN) and lines[-5].startswith(
        "| passes 1200 N at | 8000 ("
    )
    assert lines[-5].endswith("| 4000 (4000 to 4000) rpm |")
    assert lines[-3].endswith(
        "pass 1200 N: the blind study holds it; the joint study jumps earlier."
    )
    assert lines[-1].startswith(
        "1 of 147 runs of the blind study and 1 of 147 runs of the joint study did not come"
    )
    (panel,) = script.chart(kept).panels
    (middle,) = [one for one in panel.layers if one.name == "joint, median"]
    assert middle.y[0] == 1600.0 and middle.x.tolist() == kept["engine_speed_rpm"]
    assert [one.y[0] for one in panel.layers if one.name == "blind, 5 and 95 %"] == pytest.approx(
        [728.0, 872.0]
    )
    never = kept | {
        "joint": script.summary(
            np.full((3, len(script.SPEEDS)), 900.0), np.zeros((3, len(script.SPEEDS)))
        )
    }
    assert script.table(never).splitlines()[-5].endswith("| never |")
    assert script.table(never).splitlines()[-3].endswith("the joint study jumps later.")
    gone = np.full((3, len(script.SPEEDS)), 900.0)
    gone[:, -1] = np.nan
    cells = (
        script.table(kept | {"blind": script.summary(gone, gone)})
        .splitlines()[2 + len(script.SHOWN) - 1]
        .split(" | ")
    )
    assert (
        cells[0] == "| 16000 rpm"
        and cells[1] == "no run to its end"
        and cells[2] == "4200 (4020 to 4380) N |"
    )
    (tmp_path / "data" / "beehive").mkdir(parents=True)
    (tmp_path / "pictures").mkdir()
    (tmp_path / script.DATA).write_text(json.dumps(kept))
    (tmp_path / script.PAGE).write_text(f"before\n{script.BEGIN}old\n{script.END}\nafter\n")
    script.main([], tmp_path)
    text = (tmp_path / script.PAGE).read_text()
    assert text == f"before\n{script.BEGIN}{script.table(kept)}\n{script.END}\nafter\n"
    assert (tmp_path / script.PICTURE).read_text().startswith("<svg")


def test_draws_are_taken_by_weight_and_each_point_is_the_case_at_its_values(tmp_path):
    request = read_request(ROOT / "examples" / "identify-beehive-blind.toml")
    names = [one.name for one in request.unknowns]
    own = np.array([one.prior.centre for one in request.unknowns], dtype=float)
    values = np.vstack([own, 1.01 * own])
    columns = {
        f"quantity_{name}": ("draw", values[:, place], {"long_name": name})
        for place, name in reversed(list(enumerate(names)))
    }
    xr.Dataset(columns | {"weight": ("draw", [0.0, 1.0])}).to_netcdf(
        tmp_path / "draws.nc", engine="h5netcdf"
    )
    (draw,) = script.values_of_draws(request, tmp_path, 4)
    assert draw == pytest.approx(values[1])
    force, energy = script.forces_of(request, values[:1], np.array([5000.0]))
    case = vary(
        request.case,
        {
            key: float(value)
            for row, value in zip(request.varied, values[0], strict=True)
            for key in row
        },
    )
    wanted = Wanted(("peak_spring_force", "clash_energy"))
    alone = evaluate_case(
        case, Point(case, (), 5000 * np.pi / 30, "finite-element", "", wanted)
    ).values
    assert (force[0, 0], energy[0, 0]) == (alone["peak_spring_force"], alone["clash_energy"])


def test_the_page_of_the_beehive_says_what_is_kept_of_the_sweep(tmp_path):
    assert_written_anew(script.main, tmp_path, script.DATA, script.PAGE, script.PICTURE)
