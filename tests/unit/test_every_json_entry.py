"""Every entry of a study's JSON, of its data files and of its quick plots carries the number and
unit that its key names.
"""

from __future__ import annotations

import csv
from dataclasses import replace

import numpy as np
import pytest

from numbered_studies import STUDIES
from synthetic_study import (
    CITED,
    at_rest,
    modal_run,
    own_study,
    published_study,
    rod_run,
    sweep_study,
    train_run,
)
from valvetrain.solution.comparison import Comparison
from valvetrain.solution.netcdf import load_netcdf
from valvetrain.solution.status import Event, Status
from valvetrain.views.json import status_object, study_json
from valvetrain.views.results import write_study

RPM = np.pi / 30


def row(
    quantity: str, unit: str, given: float, computed: float | None, verdict: str, **more
) -> Comparison:
    difference = None if computed is None else computed - given
    known = {
        "engine_speed": 5600 * RPM,
        "model": "finite-element",
        "origin": "engine head test",
        "role": "prediction",
        "tolerance": None,
    }
    return Comparison(
        quantity=quantity,
        unit=unit,
        published=given,
        computed=computed,
        difference=difference,
        verdict=verdict,
        **(known | more),
    )


COMPARED = (
    row("stage_2_peak_force", "N", 790.0, 805.0, "within tolerance", tolerance=24.0, source="table 3"),
    row("coil_1_2_installed_gap", "mm", 2e-3, 1.5e-3, "misses by -25.0 %, tolerance 3.0 %", engine_speed=None, role="calibration",
        used_for="the pitch"),
    row("stage_2_peak_cam_angle", "deg", np.radians(170), np.radians(171.5), "differs by +1.5 deg", model="modal-varied",
        origin="solid finite elements"),
    row("preload", "N", 280.0, None, "not computed", engine_speed=None, model=""),
    row("largest_clash_impulse", "mN s", 0.031, 0.031, "differs by +0.0 %", engine_speed=4200 * RPM),
)  # fmt: skip

RPM = np.pi / 30


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


def test_a_study_is_told_entry_by_entry():
    options = {
        "elements_per_coil": 24,
        "mass_damping": 12.5,
        "output_step": 0.01,
        "coil_contact": True,
        "solver": "newton",
    }
    stopped = Status("diverged", "the force is not finite", 0.0123, "coil 2", "use a smaller step")
    run = rod_run(4200 * RPM, bounces=1)
    run = replace(
        run,
        status=stopped,
        provenance=replace(run.provenance, options=options, spring_set="race"),
        statistics={"steps": 10, "time_step": np.float64(4e-6), "settled": False},
        quantities={"peak_spring_force": 811.0, "clash_energy": 0.044, "peak_shear_stress": np.nan},
    )
    study = replace(published_study(), solutions=(run, modal_run()), comparisons=COMPARED[:2])
    told = study_json(study)
    assert told.pop("runs") == [
        {
            "label": "finite-element",
            "model": "finite-element",
            "spring_set": "race",
            "engine_speed": known(4200, "rpm"),
            "status": {
                "code": "diverged",
                "time": known(0.0123, "s"),
                "message": "the force is not finite",
                "where": "coil 2",
                "remedy": "use a smaller step",
            },
            "quantities": {
                "peak_spring_force": known(811, "N"),
                "clash_energy": known(0.044, "J"),
                "peak_shear_stress": known(None, "Pa"),
            },
            "clash_count": known(1, "1"),
            "events": [
                {
                    "kind": "clash",
                    "where": "",
                    "cam_angle": known(np.radians(250), "rad"),
                    "time": known(0.0101, "s"),
                    "duration": known(2e-5, "s"),
                    "size": known(345, "N"),
                    "details": {
                        "upper_coil": known(2, "1"),
                        "lower_coil": known(1, "1"),
                        "peak_cam_angle": known(np.radians(251), "rad"),
                        "impulse": known(0.031, "N s"),
                        "energy": known(0.017, "J"),
                    },
                }
            ],
            "options": {
                "elements_per_coil": known(24, "1"),
                "mass_damping": known(12.5, "1/s"),
                "output_step": known(0.01, "rad"),
                "coil_contact": True,
                "solver": "newton",
            },
            "statistics": {
                "steps": known(10, "1"),
                "time_step": known(4e-6, "s"),
                "settled": False,
            },
        },
        {
            "label": "modal-varied",
            "model": "modal-varied",
            "spring_set": "",
            "engine_speed": known(5600, "rpm"),
            "status": {"code": "completed"},
            "clash_count": known(0, "1"),
            "events": [],
            "options": {},
            "statistics": {},
            "quantities": {
                "peak_spring_force": known(800, "N"),
                "minimum_spring_force": known(299, "N"),
                "open_nominal_shear_stress": known(533e6, "Pa"),
                "closed_nominal_shear_stress": known(201e6, "Pa"),
            },
        },
    ]
    rod, chain = told.pop("springs_at_rest")
    curve = rod.pop("static_curve")
    assert (
        rod["spring"] == "spring"
        and rod["model"] == "finite-element"
        and rod["precompression"] == known(7e-3, "m")
    )
    steps = np.linspace(0, 18e-3, 40)
    for name, unit, values in (
        ("compression", "m", steps),
        ("force", "N", 41e3 * steps),
        ("stiffness", "N/m", np.full(40, 41e3)),
    ):
        assert curve[name] == {"values": pytest.approx(values.tolist()), "unit": unit}
    assert curve["status"] == {"code": "completed"} and set(curve) == {
        "status",
        "compression",
        "force",
        "stiffness",
    }
    assert rod["modes"]["compression"] == known(7e-3, "m") and rod["modes"]["modes"] == [
        {
            "mode": n,
            "natural_frequency": known(hertz, "Hz"),
            "axial": axial,
            "axial_transmission_ratio": known(share, "1"),
        }
        for n, hertz, axial, share in (
            (1, 400, None, 0.01),
            (2, 631, 1, 1),
            (3, 1120, 2, -0.7),
            (4, 1300, None, 0.1),
            (5, 1639, 3, 0.5),
        )
    ]
    assert chain["model"] == "multi-mass" and chain["static_curve"]["force"]["values"][
        -1
    ] == pytest.approx(0.98 * 41e3 * 18e-3)
    assert told.pop("comparisons") == [
        {
            "quantity": "stage_2_peak_force",
            "engine_speed": known(5600, "rpm"),
            "model": "finite-element",
            "published_by": "engine head test",
            "role": "prediction",
            "published": known(790, "N"),
            "computed": known(805, "N"),
            "difference": known(15, "N"),
            "tolerance": known(24, "N"),
            "blind": None,
            "verdict": "within tolerance",
            "source": "table 3",
            "used_for": "",
            "doubt": "",
            "reading": "",
            "samples": None,
        },
        {
            "quantity": "coil_1_2_installed_gap",
            "engine_speed": None,
            "model": "finite-element",
            "published_by": "engine head test",
            "role": "calibration",
            "published": known(2e-3, "m"),
            "computed": known(1.5e-3, "m"),
            "difference": known(-0.5e-3, "m"),
            "tolerance": None,
            "blind": None,
            "verdict": "misses by -25.0 %, tolerance 3.0 %",
            "source": "",
            "used_for": "the pitch",
            "doubt": "",
            "reading": "",
            "samples": None,
        },
    ]
    assert told.pop("critical_speeds") == []
    failures = told.pop("failures")
    assert len(failures) == 1 and "the force is not finite" in failures[0]
    expected = {
        "command": "compare", "case": "gu2021-beehive-blind", "title": "Spring of my own", "digest": study.record.digest, "changed": [],
        "completed": False, "quantities": {"preload": known(287, "N"), "coil_bind_lift": known(10.25e-3, "m")}, "quantities_by_label": {},
        "findings": [{"place": "section 4", "statement": "Stage II has a valley", "computed": "valley of 412 N", "verdict": "holds"}],
        "notes": list(study.notes),
        "cite": list(dict.fromkeys((*CITED, *(one for run in study.solutions for one in run.cite())))),
    }  # fmt: skip
    assert {key: told[key] for key in expected} == expected
    assert not [key for key, value in told.items() if key not in expected and value], (
        "write down what the new entry carries"
    )


def test_numbers_at_rest_stand_under_their_labels():
    told = study_json(sweep_study())
    assert (
        told["quantities_by_label"] == {"stock": {"float_engine_speed": known(701, "rad/s")}}
        and told["quantities"] == {}
    )
    assert (
        told["completed"] is True and told["cite"][0] == CITED[0]
    )  # motion that does not settle is a finding of a sweep
    assert study_json(replace(sweep_study(), command="run"))["completed"] is False


def rows(path) -> list[dict[str, str]]:
    with open(path, encoding="utf-8", newline="") as file:
        return list(csv.DictReader(file))


@pytest.fixture(scope="module")
def written(tmp_path_factory):
    """Folders of three studies."""
    folder = tmp_path_factory.mktemp("written")
    made = {
        "own": replace(STUDIES["own"](), comparisons=COMPARED), "sweep": STUDIES["sweep"](), "train": STUDIES["train"](),
    }  # fmt: skip
    return {
        name: (
            study,
            folder / name,
            write_study(study, folder / name, page=name == "own"),
        )
        for name, study in made.items()
    }


def test_every_file_is_told_and_there(written):
    _, folder, files = written["own"]
    runs = [
        f"{label}-{speed}rpm.{kind}"
        for label in ("finite-element", "modal-varied")
        for speed in (4200, 5600)
        for kind in ("nc", "csv")
    ]
    rest = [
        f"{part}-spring-{model}.{kind}"
        for model in ("finite-element", "multi-mass")
        for part in ("static", "modes")
        for kind in ("nc", "csv")
    ]
    assert sorted(path.name for path in files.data) == sorted(
        [*runs, *rest, "quantities.csv", "events.csv", "comparison.csv"]
    )
    assert files.page == folder / "report.html"
    assert {path.name for path in folder.iterdir() if path.is_file()} >= {
        path.name for path in (*files.data, files.page)
    }
    _, _, swept = written["sweep"]
    assert sorted(path.name for path in swept.data) == sorted(
        [
            "quantities.csv",
            "events.csv",
            "sweep-stock.csv",
            "sweep-race-co.csv",
            "orders-stock.csv",
            "orders-race-co.csv",
        ]
    )
    assert swept.page is None and swept.figures == ()


def test_quantities_in_their_file(written):
    study, folder, _ = written["own"]
    found = rows(folder / "quantities.csv")
    heads = ["label", "engine speed [rpm]", "quantity", "value [SI]", "unit"]
    assert list(found[0]) == [*heads, "shown value", "shown unit"]
    bind = next(row for row in found if row["quantity"] == "coil_bind_lift")
    assert (float(bind["shown value"]), bind["shown unit"]) == (pytest.approx(10.25), "mm")
    for run in study.solutions:
        speed = run.engine_speed / RPM
        mine = {
            row["quantity"]: (float(row["value [SI]"]), row["unit"])
            for row in found
            if row["label"] == run.label
            and abs(float(row["engine speed [rpm]"] or "nan") - speed) < 1e-3
        }
        assert {name: value for name, (value, _) in mine.items()} == pytest.approx(
            dict(run.quantities)
        )
    units = {row["quantity"]: row["unit"] for row in found}
    assert (
        units["peak_spring_force"],
        units["clash_energy"],
        units["coil_bind_clearance"],
        units["surge_frequency"],
    ) == (
        "N",
        "J",
        "m",
        "Hz",
    )
    assert [
        (row["label"], row["quantity"], float(row["value [SI]"]))
        for row in found
        if not row["engine speed [rpm]"]
    ] == [
        ("", "preload", 287.0),
        ("", "coil_bind_lift", 10.25e-3),
    ]


def test_events_in_their_file(written):
    _, folder, _ = written["own"]
    found = rows(folder / "events.csv")
    assert list(found[0]) == [
        "label",
        "engine speed [rpm]",
        "event",
        "place",
        "cam angle [deg]",
        "duration [ms]",
        "size",
        "unit",
        "lower coil",
        "upper coil",
        "impulse [N s]",
        "energy [J]",
        "cause",
    ]
    assert len(found) == 7
    second = [float(value) if value[:1].isdigit() else value for value in found[1].values()]
    assert second == [
        "finite-element",
        5600.0,
        "clash",
        "",
        pytest.approx(251),
        pytest.approx(0.02),
        172.5,
        "N",
        1.0,
        2.0,
        pytest.approx(0.0155),
        pytest.approx(0.0085),
        "",
    ]
    _, folder, _ = written["train"]
    (first, _) = rows(folder / "events.csv")
    assert (
        first["event"],
        first["place"],
        first["cause"],
        float(first["size"]),
        first["unit"],
    ) == (
        "seating",
        "seat",
        "end of the ramp",
        0.37,
        "m/s",
    )


def test_comparisons_in_their_file(written):
    _, folder, _ = written["own"]
    found = rows(folder / "comparison.csv")
    first, second = found[:2]
    for row, known in (
        (
            first,
            {
                "quantity": "stage_2_peak_force",
                "engine speed [rpm]": "5600.0",
                "given by": "engine head test",
                "given": "790.0",
                "computed by": "finite-element",
                "computed": "805.0",
                "difference": "15.0",
                "unit": "N",
                "tolerance": "24.0",
                "role": "prediction",
                "verdict": "within tolerance",
                "source": "table 3",
            },
        ),
        (
            second,
            {
                "quantity": "coil_1_2_installed_gap",
                "engine speed [rpm]": "",
                "given": "2.0",
                "computed": "1.5",
                "difference": "-0.5",
                "unit": "mm",
                "relative difference": "-0.25",
                "tolerance": "",
                "role": "calibration",
                "verdict": "misses by -25.0 %, tolerance 3.0 %",
                "source": "",
                "used for": "the pitch",
            },
        ),
    ):
        assert {name: row[name] for name in known} == known


def test_springs_at_rest_in_their_files(written):
    _, folder, _ = written["own"]
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
    assert static_table(rod, replace(rod.curve, coil_contact_force=force))["closed turns"][
        [9, 10]
    ].tolist() == [0.0, 1.5]


def test_a_sweep_in_its_files(written):
    study, folder, _ = written["sweep"]
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
    assert [row["status"] for row in found] == ["completed"] * 11 + ["not-converged"] and not [
        name for name in found[0] if "order" in name
    ]
    orders = rows(folder / "orders-race-co.csv")
    assert list(orders[0]) == ["engine speed [rpm]", *(f"order {n} [N]" for n in range(1, 25))]
    for row, run in zip(orders, runs, strict=True):
        assert float(row["order 7 [N]"]) == pytest.approx(run.quantities["surge_order_7_force"])
        assert float(row["engine speed [rpm]"]) == pytest.approx(run.engine_speed / RPM)


def test_stored_runs_hold_every_wire_point_and_text_files_every_half_turn(written, tmp_path):
    study, folder, _ = written["own"]
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
