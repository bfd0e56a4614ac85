"""What a study says in the terminal: every line beside the made-up numbers that it has to carry,
units and signs with it.
"""

from __future__ import annotations

import csv
import re
from dataclasses import replace
from io import StringIO
from pathlib import Path

import numpy as np
import pytest
from rich.console import Console

from known_figures import STUDIES
from synthetic_study import at_rest, own_study, published_study, rod_run, sweep_study
from unit.test_every_table import COMPARED, four
from valvetrain.cli.answers import published_summary, show_study
from valvetrain.cli.outcome import quantity_rows, shown_text
from valvetrain.cli.published import difference_text, short_verdict, show_comparisons, tally
from valvetrain.runs.saved_runs import SavedRun

RPM = np.pi / 30


def lines(study, **more) -> list[list[str]]:
    """Lines of the answer, each cut where two spaces or more stand."""
    console = Console(file=StringIO(), width=140, no_color=True)
    show_study(console, study, Path("out"), Path("out/report.html"), **more)
    return [re.split(r"\s{2,}", line.strip()) for line in console.file.getvalue().splitlines()]


def test_a_run_says_each_number_once_under_its_run():
    study = STUDIES["own"]()
    told = lines(study)
    assert told[0] == ["Spring of my own"] and told[-2:] == [
        ["results", "out"],
        ["report", "out/report.html"],
    ]
    start = next(
        place for place, line in enumerate(told) if line[0] == "finite-element" and len(line) == 4
    )
    assert told[start : start + 2] == [
        ["finite-element"] * 2 + ["modal-varied"] * 2,
        ["4200 rpm", "5600 rpm"] * 2,
    ]
    expected = []
    for words, unit, name, factor in (
        ("Peak spring force below 10 kHz", "N", "peak_spring_force", 1),
        ("Minimum spring force", "N", "minimum_spring_force", 1),
        ("Peak retainer force below 10 kHz", "N", "peak_retainer_force", 1),
        ("Minimum retainer force", "N", "minimum_retainer_force", 1),
        ("Clearance to coil bind", "mm", "coil_bind_clearance", 1e3),
        ("Surge frequency", "Hz", "surge_frequency", 1),
        ("Surge order", "", "surge_cam_order", 1),
        ("Surge amplitude, 0 to peak", "N", "surge_amplitude_force", 1),
        ("Coil contacts", "", "clash_count", 1),
        ("largest by energy: coils", "", "–/1–2/–/–", 0),
        ("its peak at cam angle", "deg", "–/251/–/–", 0),
        ("valve lift there", "mm", "–/0/–/–", 0),
        ("impulse", "mN s", "–/31/–/–", 0),
        ("Clash energy", "mJ", "clash_energy", 1e3),
        ("Peak shear stress", "MPa", "peak_shear_stress", 1e-6),
        ("Minimum shear stress", "MPa", "minimum_shear_stress", 1e-6),
        (
            "Shear stress by EN 13906-1 at the largest lift",
            "MPa",
            "open_nominal_shear_stress",
            1e-6,
        ),
        ("Shear stress by EN 13906-1, valve closed", "MPa", "closed_nominal_shear_stress", 1e-6),
    ):
        runs = study.solutions
        cells = (
            name.split("/")
            if not factor
            else [
                four(run.quantities[name] * factor if name in run.quantities else None)
                for run in runs
            ]
        )
        expected.append([words, *([unit] if unit else []), *cells])
    assert told[start + 2 : -2] == expected


def test_springs_at_rest_stand_beside_the_first_model():
    told = lines(own_study(()))
    assert told[2] == [
        "at rest",
        "preload (N)",
        "rate (N/mm)",
        "mode 1 (Hz)",
        "mode 2 (Hz)",
        "mode 3 (Hz)",
    ]
    assert told[3] == ["finite-element", "287", "41", "631", "1120", "1639"]
    assert told[4] == [
        "multi-mass",
        "281.3 (−2.0 %)",
        "40.18 (−2.0 %)",
        "620 (−1.7 %)",
        "1210 (+8.0 %)",
        "–",
    ]
    rod, chain = at_rest()
    nested = lines(replace(own_study(()), rest=(rod, replace(chain, spring="inner"))))
    assert nested[3][0] == "spring, finite-element" and nested[4] == [
        "inner, multi-mass",
        "281.3",
        "40.18",
        "620",
        "1210",
        "–",
    ]
    outside = lines(replace(own_study(()), rest=(rod, replace(chain, precompression=0.03))))
    assert outside[4][:3] == ["multi-mass", "–", "–"]


def test_a_sweep_says_the_worst_of_each_label_and_where():
    every = lines(sweep_study())
    told = {line[0]: line[1:] for line in every}
    assert told["Peak spring force below 10 kHz"] == ["N", "740 at 5818", "768 at 5818"]
    place = next(k for k, line in enumerate(every) if line[0] == "Minimum spring force")
    assert every[place][1:] == ["N"] + ["217 at 5818"] * 2
    assert every[place + 1] == ["beyond 6217 rpm", "N"] + ["181 at 8000"] * 2
    assert told["Surge frequency"] == ["Hz", "560", "672"]
    assert told["Surge amplitude, 0 to peak"] == ["N", "64.71 at 4182", "64.8 at 4727"]
    assert (
        told["Clash energy"] == ["mJ", "7 at 5818", "8.4 at 5818"]
        and told["Lift lost"] == ["mm"] + ["0.07 at 5818"] * 2
    )
    assert (
        told["Engine speeds run"] == ["12", "12"] and told["that did not settle"] == ["1: 8000"] * 2
    )
    study = sweep_study()
    settled = tuple(
        replace(
            run,
            status=study.solutions[0].status,
            quantities={**run.quantities, "float_excess_lift": 0.0},
        )
        for run in study.solutions
    )
    assert "that did not settle" not in {
        line[0] for line in lines(replace(study, solutions=settled))
    }


def test_a_sweep_says_the_brackets_of_critical_speeds_and_what_was_not_searched():
    """1 rad/s is 9.549 rpm; the second label was not searched, and without a search no label was."""
    study = sweep_study()
    told = lines(study)
    first = next(place for place, line in enumerate(told) if line[0] == "Contact-loss speed")
    assert told[first : first + 7] == [
        ["Contact-loss speed", "rpm", "6207–6217, at the cam", "not computed"],
        ["until", "rpm", "6494–6503"],
        ["again", "rpm", "6589–8000"],
        [
            "Float speed",
            "rpm",
            "6688 (6493 to 6876: model, damping)",
            "not computed",
        ],
        ["until", "rpm", "8000 or more"],
        ["rising / falling speed", "rpm", "6875–6885 / 6589–6599"],
        ["Bounce speed", "rpm", "none up to 8000", "not computed"],
    ]
    bare = {
        line[0]: line[1:]
        for line in lines(replace(study, critical_speeds=type(study.critical_speeds)()))
    }
    assert all(
        bare[name] == ["rpm", "not computed", "not computed"]
        for name in ("Contact-loss speed", "Float speed", "Bounce speed")
    )


def test_many_runs_stand_below_each_other():
    runs = [
        replace(
            rod_run(speed * RPM),
            quantities={
                name: value * (1 + place / 100) for name, value in rod_run().quantities.items()
            },
        )
        for place, speed in enumerate(range(1000, 1700, 100))
    ]
    told = lines(replace(own_study(tuple(runs)), rest=()))
    assert ["Clearance to coil bind", "mm", "1.25 to 1.325"] in told and [
        "Surge frequency",
        "Hz",
        "631 to 668.9",
    ] in told
    assert ["finite-element", "1300", "835.3", "296.6", "48.41", "7.21", "45.32"] in [
        line[:7] for line in told
    ]
    assert sum(line[0] == "finite-element" for line in told) >= 7
    many = [
        replace(run, provenance=replace(run.provenance, engine_speed=(1000 + n) * RPM))
        for n in range(30)
        for run in runs[:1]
    ]
    assert ["and 6 more"] in lines(replace(own_study(tuple(many)), rest=()))


def test_published_values_are_told_in_a_line_and_in_full():
    study = replace(published_study(), comparisons=COMPARED)
    told = [" ".join(line) for line in lines(study)]
    sentence = "5 published values; 1 of 2 stated tolerances met"
    assert (
        sentence in told
        and "1 finding and 2 notes in the report; --published prints all of it" in told
    )
    whole = lines(study, published=True)
    for line in (
        ["installed gap of coils 1 and 2", "EX", "2 mm", "1.5", "−25.0 %", "misses (3.0 %)"],
        ["preload", "EX", "280 N", "–", "–", "not computed"],
        ["largest clash impulse", "EX", "31 mN s", "31", "0.0 %", "–"],
        ["Stage II peak force", "EX", "790 N", "805", "+1.9 %", "within tolerance"],
        ["Stage II peak, cam angle", "FE", "170 deg", "171.5", "+1.5 deg", "–"],
        ["prediction: 4 published values, 1 of 1 stated tolerances met, 1 not computed"],
        ["calibration: 1 published values, 0 of 1 stated tolerances met"],
        ["section 4: Stage II has a valley"],
        ["computed: valley of 412 N"],
        ["verdict:", "holds"],
        ["The first note <for> readers."],
    ):
        assert line in whole, line
    heads = [line[0] for line in whole if "identif" in line[0]]
    assert [head.split(" (")[0] for head in heads] == [
        "statics and modes",
        "statics and modes",
        "4200 rpm",
        "5600 rpm",
    ]
    bare = [" ".join(line) for line in lines(replace(own_study(), notes=("Mind the gap.",)))]
    assert "note: Mind the gap." in bare and not [line for line in bare if "--published" in line]


@pytest.mark.parametrize(
    ("place", "difference", "verdict"),
    [
        (0, "+1.9 %", "within tolerance"),
        (1, "−25.0 %", "misses (3.0 %)"),
        (2, "+1.5 deg", "–"),
        (3, "–", "not computed"),
        (4, "0.0 %", "–"),
    ],
)
def test_difference_and_verdict_of_a_row(place, difference, verdict):
    assert (difference_text(COMPARED[place]), short_verdict(COMPARED[place])) == (
        difference,
        verdict,
    )


def test_a_bound_is_told_without_its_distance_and_a_zero_in_its_unit():
    bound = replace(COMPARED[0], verdict="stated as at most: beyond by 5.0 %")
    assert short_verdict(bound) == "stated as at most"
    nothing = replace(COMPARED[1], published=0.0, difference=-2e-6)
    assert difference_text(nothing) == "−0.002 mm"
    assert "no tolerance was stated" in tally(
        COMPARED[2:3], "prediction"
    ) and "not computed" not in tally(COMPARED[:1], "prediction")
    assert published_summary(COMPARED[3:4]) == "1 published value"
    assert published_summary(COMPARED[:1]) == "1 published value; 1 of 1 stated tolerances met"
    console = Console(file=StringIO(), width=140, no_color=True)
    show_comparisons(console, COMPARED[:1])
    assert "EX" in console.file.getvalue() and "FE" not in console.file.getvalue()


def test_numbers_in_the_fields_units():
    assert (
        shown_text("clash_energy", 0.0123) == ("12.3", "mJ")
        and shown_text("peak_spring_force", None)[0] == "–"
    )
    assert quantity_rows({"surge_cam_order": 13.523456, "peak_shear_stress": 551.23456e6}) == [
        ("Surge order", "13.523", ""),
        ("Peak shear stress", "551.23", "MPa"),
    ]


def _headline(answer):
    return SavedRun(Path(), answer).headline


def test_the_number_that_stands_for_a_kept_run():
    def number(value: float, unit: str = "N") -> dict:
        return {"value": value, "unit": unit}

    runs = [
        {"quantities": {"peak_spring_force": number(700.0), "peak_retainer_force": number(900.0)}},
        {"quantities": {"peak_spring_force": number(811.0)}},
    ]
    assert _headline({"runs": runs}) == {
        "quantity": "peak_spring_force",
        "value": 811.0,
        "unit": "N",
    }
    assert _headline({"quantities": {"preload": number(287.0)}, "runs": []}) == {
        "quantity": "preload",
        "value": 287.0,
        "unit": "N",
    }
    assert (
        _headline({"runs": [{"quantities": {"peak_spring_force": {"value": None, "unit": "N"}}}]})
        is None
    )
    labelled = {"quantities_by_label": {"a": {"float_engine_speed": number(701.0, "rad/s")}}}
    assert _headline(labelled) == {
        "quantity": "float_engine_speed",
        "value": 701.0,
        "unit": "rad/s",
    }


def test_static_curves_are_printed_thinned_and_written_whole():
    from valvetrain.cli.static import MAX_ROWS, _show, curve_text

    study = replace(
        own_study(()),
        still={"spring by finite-element": {"preload": 287.0}, "spring by multi-mass": {}},
    )
    console = Console(file=StringIO(), width=140, no_color=True)
    _show(console, study, Path("curve.csv"))
    told = [re.split(r"\s{2,}", line.strip()) for line in console.file.getvalue().splitlines()]
    printed = [line for line in told if line[0][:1].isdigit()]
    each = next(n for n in range(1, 99) if 40 / n <= MAX_ROWS)
    steps = np.linspace(0, 18, 40)[::each]  # the stress of the made-up wire is 41 MPa per mm
    rows = [[x, 41 * x, 41.0, 41 * x] for x in steps] + [[x, 0.98 * 41 * x, 40.18] for x in steps]
    assert [[float(cell) for cell in line] for line in printed] == [
        pytest.approx(row, rel=1e-4) for row in rows
    ]
    heads = ["compression (mm)", "force (N)", "stiffness (N/mm)"]
    assert (
        told.count(heads) == 1
        and told.count([*heads, "wire shear (MPa)"]) == 1
        and ["Preload", "287", "N"] in told
    )
    assert ["written to curve.csv"] in told
    text = list(csv.DictReader(curve_text(study).splitlines()))
    assert len(text) == 80 and (text[-1]["spring"], text[-1]["model"]) == ("spring", "multi-mass")
    last = [
        text[place][f"{name} [{unit}]"]
        for place in (39, 79)
        for name, unit in (("compression", "mm"), ("force", "N"), ("stiffness", "N/mm"))
    ]
    assert [float(one) for one in last] == pytest.approx([18.0, 738.0, 41.0, 18.0, 723.24, 40.18])
    alone = list(csv.DictReader(curve_text(replace(study, rest=study.rest[:1])).splitlines()))
    assert (
        len(alone) == 40
        and "spring" not in alone[0]
        and float(alone[-1]["force [N]"]) == pytest.approx(738.0)
    )


def test_what_a_case_holds_is_said_in_the_fields_units():
    from valvetrain.cli.case_facts import case_facts, case_quantities
    from valvetrain.parameters.loading import load_case
    from valvetrain.system.build import build

    case = load_case("uniform-spring")
    told, turning = (
        dict(case_facts(case)),
        2 * np.pi * 600,
    )  # both dampings take half of the ratio at 600 Hz
    end = "open, 0 coils inactive, 0 ground"
    assert (
        told["wire diameter"] == "3.8 mm"
        and told["mean coil diameter"] == "22 mm"
        and told["pitch"] == "7 mm"
    )
    assert (
        told["damping"]
        == f"ratio 0.016: mass {four(0.016 * turning)} 1/s, stiffness {four(0.016 / turning * 1e6)} µs"
    )
    assert (
        told["end coils"] == f"lower {end}; upper {end}" and told["seats"] == "inactive ends only"
    )
    assert (
        told["spring"] == "uniform-spring, right-handed"
        and told["cam revolutions"] == "until the motion repeats, the last one reported"
    )
    assert (
        told["title"] == case.title
        and "206 GPa" in told["material"]
        and "7850 kg/m³" in told["material"]
    )
    train = load_case("vaz-ohc")
    told = dict(case_facts(train))
    assert (
        told["lift law"] == "ramped, lift of the valve"
        and told["train"] == "finger, planar model, multi-mass springs, lash 0 mm"
    )
    assert (
        told["contacts"] == "cam hunt-crossley, valve tip hunt-crossley, seat linear"
        and told["engine speeds"] == "4136 rpm of the crank"
    )
    assert (
        told["springs 'nested'"]
        == "outer: wire known, compressed 16.3 mm when installed; inner: wire known, compressed 9.5 mm when installed"
    )
    cards = "outer: rate 17.39 N/mm, preload 283.4 N, mass 31.8 g; inner: rate 14.35 N/mm, preload 136.3 N, mass 11.5 g"
    assert told["springs 'nested-cards'"] == cards
    numbers = case_quantities(train, build(train))
    assert numbers["maximum_lift"] == pytest.approx(9.7e-3, rel=1e-6) and numbers[
        "outer_free_length"
    ] == pytest.approx(0.05, rel=1e-4)
    # the lift of a card is that of the lobe; the user asks for the valve's
    from valvetrain.parameters.loading import parse_case
    from valvetrain.parameters.templates import template_text

    card = parse_case(template_text("pushrod", cards=True), "v8")
    both = case_quantities(card, build(card))
    assert both["rigid_maximum_valve_lift"] == pytest.approx(1.6 * both["maximum_lift"], rel=0.02)
    assert numbers["maximum_lift_cam_angle"] == pytest.approx(np.radians(78), abs=1e-3) and numbers[
        "inner_free_length"
    ] == pytest.approx(39.2e-3, rel=1e-4)


def test_sizes_are_said_as_people_say_them():
    from valvetrain.runs.cost import duration_text, memory_text

    assert [memory_text(size) for size in (3e5, 4.4e7, 9.99e8, 2.5e9)] == [
        "1 MB",
        "44 MB",
        "999 MB",
        "2.5 GB",
    ]
    assert [
        duration_text(size) for size in (0.2, 42.0, 89.0, 91.0, 5399.0, 7200.0, 129599.0, 259200.0)
    ] == [
        "1 s",
        "42 s",
        "89 s",
        "1.52 min",
        "90 min",
        "2 h",
        "36 h",
        "3 d",
    ]


def test_springs_at_rest_are_told_where_no_run_has_a_number():
    """A stretch of motion by solid finite elements has no headline number; the answer said nothing
    at all.
    """
    silent = replace(
        own_study(),
        solutions=tuple(replace(one, quantities={}) for one in own_study().solutions[:1]),
        rest=own_study().rest[:1],
    )
    heads = [row for row in lines(silent) if row[0] == "at rest"]
    assert heads and "preload (N)" in heads[0]
    assert not [
        row for row in lines(replace(own_study(), rest=own_study().rest[:1])) if row[0] == "at rest"
    ]
