"""Every entry of a study's JSON and of its data files carries the number and unit that its key names."""

from __future__ import annotations

import csv
from dataclasses import replace

import numpy as np
import pytest

from synthetic_study import (
    at_rest,
    own_study,
    published_study,
    rod_run,
    sweep_study,
    train_run,
    train_study,
)
from valvetrain.solution.definition import label_of
from valvetrain.solution.netcdf import load_netcdf
from valvetrain.solution.status import Event, Status
from valvetrain.solution.study import Study
from valvetrain.solution.uncertainty import Comparison
from valvetrain.views.json import status_object, study_json
from valvetrain.views.results import write_study

RPM = np.pi / 30


def row(quantity: str, unit: str, given: float, computed: float | None, **more) -> Comparison:
    difference = None if computed is None else computed - given
    return Comparison(
        quantity=quantity, unit=unit, published=given, computed=computed, difference=difference, verdict="", model="finite-element",
        engine_speed=5600 * RPM, origin="engine head test", role="prediction", **{"tolerance": None} | more,
    )  # fmt: skip


COMPARED = (
    row("stage_2_peak_force", "N", 790.0, 805.0, tolerance=24.0),
    row("coil_1_2_installed_gap", "mm", 2e-3, 1.5e-3),
    row("preload", "N", 280.0, None),
)


def known(value: float | None, unit: str) -> dict:
    return {"value": None if value is None else pytest.approx(value), "unit": unit}


@pytest.mark.parametrize(
    ("status", "told"),
    [
        (Status(), {"code": "completed"}),
        (Status("completed", "twice"), {"code": "completed", "message": "twice"}),
        (Status("completed", "", 0.5, "coil 2", "do it once"), {"code": "completed"}),
        (
            Status("not-converged", "too few turns", 0.25, "cam", "allow more"),
            {
                "code": "not-converged",
                "time": known(0.25, "s"),
                "message": "too few turns",
                "where": "cam",
                "remedy": "allow more",
            },
        ),
        (
            Status("refused", "no wire"),
            {
                "code": "refused",
                "time": known(0.0, "s"),
                "message": "no wire",
                "where": "",
                "remedy": "",
            },
        ),
    ],
)
def test_a_status_keeps_its_message_and_what_was_not_reached_its_place_too(status, told):
    assert status_object(status) == told


def test_entries_of_a_run_have_their_units():
    options = {
        "elements_per_coil": 24,
        "mass_damping": 12.5,
        "coil_contact": True,
        "solver": "newton",
    }
    run = rod_run(4200 * RPM, bounces=1)
    run = replace(
        run,
        provenance=replace(run.provenance, options=options, spring_set="race"),
        statistics={"steps": 10, "time_step": np.float64(4e-6), "settled": False},
        quantities={"peak_spring_force": 811.0, "clash_energy": 0.044, "peak_shear_stress": np.nan},
    )
    (told,) = study_json(own_study((run,)))["runs"]
    assert (told["label"], told["spring_set"]) == ("finite-element", "race")
    assert told["engine_speed"] == known(4200, "rpm") and told["clash_count"] == known(1, "1")
    assert told["quantities"] == {
        "peak_spring_force": known(811, "N"), "clash_energy": known(0.044, "J"), "peak_shear_stress": known(None, "Pa"),
    }  # fmt: skip
    assert told["options"] == {
        "elements_per_coil": known(24, "1"), "mass_damping": known(12.5, "1/s"), "coil_contact": True, "solver": "newton",
    }  # fmt: skip
    assert told["statistics"] == {"steps": known(10, "1"), "time_step": known(4e-6, "s"), "settled": False}  # fmt: skip
    (event,) = told["events"]
    assert event.pop("details") == {
        "upper_coil": known(2, "1"), "lower_coil": known(1, "1"), "peak_cam_angle": known(np.radians(251), "rad"),
        "impulse": known(0.031, "N s"), "energy": known(0.017, "J"),
    }  # fmt: skip
    assert event == {
        "kind": "clash", "where": "", "cam_angle": known(np.radians(250), "rad"), "time": known(0.0101, "s"),
        "duration": known(2e-5, "s"), "size": known(345, "N"),
    }  # fmt: skip


def test_entries_at_rest_and_of_comparisons_have_their_units():
    told = study_json(replace(published_study(), comparisons=COMPARED))
    rod, _ = told["springs_at_rest"]
    assert rod["precompression"] == known(7e-3, "m")
    curve, steps = rod["static_curve"], np.linspace(0, 18e-3, 40)
    for name, unit, values in (
        ("compression", "m", steps),
        ("force", "N", 41e3 * steps),
        ("stiffness", "N/m", np.full(40, 41e3)),
    ):
        assert curve[name] == {"values": pytest.approx(values.tolist()), "unit": unit}
    second = rod["modes"]["modes"][1]
    assert second == {
        "mode": 2, "natural_frequency": known(631, "Hz"), "axial": 1, "axial_transmission_ratio": known(1, "1"),
    }  # fmt: skip
    force, gap, missing = told["comparisons"]
    assert {name: force[name] for name in ("published", "computed", "difference", "tolerance")} == {
        "published": known(790, "N"), "computed": known(805, "N"), "difference": known(15, "N"), "tolerance": known(24, "N"),
    }  # fmt: skip
    assert (gap["published"], gap["difference"]) == (known(2e-3, "m"), known(-0.5e-3, "m"))
    assert missing["computed"] is None and missing["difference"] is None


def test_numbers_at_rest_stand_under_their_labels():
    told = study_json(sweep_study())
    assert told["quantities_by_label"] == {"stock": {"float_engine_speed": known(701, "rad/s")}}
    # motion that does not settle is a finding of a sweep
    assert told["completed"] is True and told["quantities"] == {}
    assert study_json(replace(sweep_study(), command="run"))["completed"] is False


def rows(path) -> list[dict[str, str]]:
    with open(path, encoding="utf-8", newline="") as file:
        return list(csv.DictReader(file))


def numbered(study: Study) -> Study:
    """The study with the numbers of every run raised by a share of its own, so that none stands for another."""
    runs = (
        replace(run, quantities={name: value * (1 + place / 50) for name, value in run.quantities.items()})
        for place, run in enumerate(study.solutions, start=1)
    )  # fmt: skip
    return replace(study, solutions=tuple(runs))


@pytest.fixture(scope="module")
def written(tmp_path_factory):
    """Study and folder of each of three studies."""
    made = {"own": replace(own_study(), comparisons=COMPARED), "sweep": sweep_study(), "train": train_study()}  # fmt: skip
    found = {}
    for name, study in made.items():
        folder = tmp_path_factory.mktemp(name)
        found[name] = numbered(study), folder
        write_study(found[name][0], folder, page=False)
    return found


def test_quantities_in_their_file(written):
    study, folder = written["own"]
    found = rows(folder / "quantities.csv")
    bind = next(row for row in found if row["quantity"] == "coil_bind_lift")
    assert (float(bind["shown value"]), bind["shown unit"]) == (pytest.approx(10.25), "mm")
    for run in study.solutions:
        speed = run.engine_speed / RPM
        mine = {
            row["quantity"]: float(row["value [SI]"])
            for row in found
            if row["label"] == run.label
            and abs(float(row["engine speed [rpm]"] or "nan") - speed) < 1e-3
        }
        assert mine == pytest.approx(dict(run.quantities))
    units = {row["quantity"]: row["unit"] for row in found}
    names = ("peak_spring_force", "clash_energy", "coil_bind_clearance", "surge_frequency")
    assert [units[name] for name in names] == ["N", "J", "m", "Hz"]


def test_events_in_their_file(written):
    _, folder = written["own"]
    second = rows(folder / "events.csv")[1]
    expected = {
        "engine speed [rpm]": 5600.0, "cam angle [deg]": 251, "duration [ms]": 0.02, "size": 172.5, "lower coil": 1.0, "upper coil": 2.0,
        "impulse [N s]": 0.0155, "energy [J]": 0.0085,
    }  # fmt: skip
    assert {name: float(second[name]) for name in expected} == pytest.approx(expected)
    _, folder = written["train"]
    (first, _) = rows(folder / "events.csv")
    told = first["event"], first["place"], first["cause"], float(first["size"]), first["unit"]
    assert told == ("seating", "seat", "end of the ramp", 0.37, "m/s")


def test_comparisons_in_their_file(written):
    _, folder = written["own"]
    force, gap, _ = rows(folder / "comparison.csv")
    columns = ("given", "computed", "difference", "unit", "tolerance")
    assert [force[name] for name in columns] == ["790.0", "805.0", "15.0", "N", "24.0"]
    assert [gap[name] for name in columns] == ["2.0", "1.5", "-0.5", "mm", ""]
    assert float(gap["relative difference"]) == -0.25


def test_springs_at_rest_in_their_files(written):
    _, folder = written["own"]
    steps = np.linspace(0, 18e-3, 40)
    curve = rows(folder / "static-spring-multi-mass.csv")
    for column, values in (
        ("compression [mm]", 1e3 * steps),
        ("force [N]", 0.98 * 41e3 * steps),
        ("stiffness [N/mm]", np.full(40, 40.18)),
        ("closed turns", np.zeros(40)),
    ):
        assert [float(row[column]) for row in curve] == pytest.approx(values.tolist()), column
    modes = rows(folder / "modes-spring-finite-element.csv")
    assert [float(row["natural frequency [Hz]"]) for row in modes] == [400, 631, 1120, 1300, 1639]
    assert [float(row["transmission"]) for row in modes] == [0.01, 1, 0.7, 0.1, 0.5]
    assert [row["axial"] for row in modes] == ["False", "True", "True", "False", "True"]


def test_closed_turns_are_counted_by_their_share_of_the_wire():
    from valvetrain.views.study_files import static_table

    (rod, _) = at_rest()
    force = np.zeros_like(rod.curve.coil_contact_force)
    force[10:, :3] = 5.0  # three of thirteen pairs half a turn apart
    table = static_table(rod, replace(rod.curve, coil_contact_force=force))
    turns = [float(row["closed turns"]) for row in csv.DictReader(table.splitlines())]
    assert turns[9:11] == [0.0, 1.5]


def test_a_sweep_in_its_files(written):
    study, folder = written["sweep"]
    found = rows(folder / "sweep-race-co.csv")
    runs = sorted(
        (run for run in study.solutions if run.label != "stock"), key=lambda run: run.engine_speed
    )
    for column, name, factor in (
        ("peak spring force below 10 kHz [N]", "peak_spring_force", 1),
        ("clash energy [mJ]", "clash_energy", 1e3),
        ("seating velocity [m/s]", "seating_velocity", 1),
        ("lift lost [mm]", "lift_loss_displacement", 1e3),
        ("surge frequency [Hz]", "surge_frequency", 1),
    ):
        assert [float(row[column]) for row in found] == pytest.approx(
            [factor * run.quantities[name] for run in runs]
        ), column
    assert [float(row["engine speed [rpm]"]) for row in found] == pytest.approx(
        np.linspace(2000, 8000, 12).tolist()
    )
    order = f"{label_of('surge_order_7_force')} [N]"
    for row, run in zip(found, runs, strict=True):
        assert float(row[order]) == pytest.approx(run.quantities["surge_order_7_force"])


def test_stored_runs_hold_every_wire_point_and_text_files_every_half_turn(written, tmp_path):
    study, folder = written["own"]
    back = load_netcdf(folder / "finite-element-4200rpm.nc")
    mine = study.solution("finite-element", 4200 * RPM)
    np.testing.assert_array_equal(back.channel("axial_position"), mine.channel("axial_position"))
    header = (folder / "finite-element-4200rpm.csv").read_text(encoding="utf-8")
    assert header.count("axial_position") >= 15
    dense = np.arange(0.0, 7.05, 0.1)
    places = np.interp(dense, np.arange(0, 7.25, 0.5), np.arange(15))
    channels = mine.channels.isel(wire_point=np.round(places).astype(int)).assign_coords(
        coil_number=("wire_point", dense)
    )
    from valvetrain.views.study_files import CSV_SPACING, at_wire_points

    few = at_wire_points(replace(mine, channels=channels), CSV_SPACING)
    assert few.channels["coil_number"].values == pytest.approx(np.arange(0, 7.25, 0.5)) and len(
        few.time
    ) == len(mine.time)
    np.testing.assert_array_equal(few.channel("axial_position"), mine.channel("axial_position"))


def test_an_event_without_clashes_is_no_clash_in_the_count():
    run = replace(
        train_run(),
        quantities={},
        events=(Event("loft", 1.0, 0.0, 0.0, 1e-5, "m"), Event("clash", 1.0, 0.0, 0.0, 9.0, "N")),
    )
    (told,) = study_json(replace(own_study((run,)), rest=()))["runs"]
    assert told["clash_count"] == known(1, "1") and [event["kind"] for event in told["events"]] == [
        "loft",
        "clash",
    ]
