"""Unit: the sentence of a sweep and of two springs compared holds what lies between the speeds,
little room to coil bind, missing damping, the place of a loss, the lowest speed and error bars.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from typer.testing import CliRunner

from synthetic_study import train_study
from valvetrain.cli.main import app
from valvetrain.quantities.train_events import CAUSE_INERTIA, CAUSE_SURGE
from valvetrain.report.headlines import headline_rows
from valvetrain.report.key_figures import key_figures
from valvetrain.report.run_charts import line_styles
from valvetrain.report.study import study_page
from valvetrain.report.sweep_chart import regime_chart
from valvetrain.runs.notes import NO_DAMPING
from valvetrain.solution.critical import CriticalSpeed, CriticalSpeeds, Crossing, SpeedBracket
from valvetrain.solution.netcdf import load_result
from valvetrain.solution.provenance import CaseRecord
from valvetrain.solution.result import Solution
from valvetrain.solution.status import Event, Status
from valvetrain.solution.study import Study
from valvetrain.solution.uncertainty import ErrorBars, Uncertainty

RPM = np.pi / 30


def run(name: str, speed: float, notes: tuple[str, ...] = (), **values: float) -> Solution:
    """A run of a spring set at a speed (rpm)."""
    first = train_study().solutions[0]
    held = {"loss_of_contact_duration": 0.0, "surge_amplitude_force": 10.0, **values}
    origin = replace(first.provenance, engine_speed=speed * RPM, label=f"{name}, modal-uniform", spring_set=name, notes=notes)  # fmt: skip
    return replace(first, events=(), quantities=held, provenance=origin)


def bar(name: str, speed: float, value: float, size: float) -> Uncertainty:
    same = (value, value)
    label = f"{name}, modal-uniform"
    return Uncertainty("surge_amplitude_force", speed * RPM, value, size, None, value, 0.0, same, same, label)  # fmt: skip


def pair(command: str = "compare-springs", *bars: Uncertainty, **heavy: float) -> Study:
    """At the swept speeds ``heavy`` surges less, between them more."""
    swept = [
        run(
            name,
            speed,
            **{"surge_amplitude_force": surge - (speed > 6000)}
            | (heavy if name == "heavy" else {}),
        )
        for name, surge in (("heavy", 280.0), ("light", 340.0))
        for speed in (6000, 7000)
    ]
    between = (
        run("heavy", 6444, surge_amplitude_force=475.7, surge_amplitude_cam_order=9.0),
        run("light", 6555, surge_amplitude_force=393.0),
    )
    return Study(
        CaseRecord("own"), command, tuple(swept), between=between, error_bars=ErrorBars(bars)
    )


def test_the_winner_is_that_of_all_speeds_those_between_the_swept_ones_too():
    assert pair().verdict == "light surges less (393 N against 476 N)."


def test_a_sweep_names_the_surge_between_its_speeds():
    assert "Worst surge amplitude 476 N at 6444 rpm (order 9)" in pair("sweep").verdict


def test_little_room_to_coil_bind_is_named_by_the_spring_that_has_it():
    assert "heavy only 0.154 mm clear of coil bind;" in pair(coil_bind_clearance=1.538e-4).verdict
    assert "Only 0.154 mm clear of" in pair("sweep", coil_bind_clearance=1.538e-4).verdict
    assert "coil bind" not in pair(coil_bind_clearance=1.5e-3).verdict


@pytest.mark.parametrize("command", ["run", "sweep", "compare-springs"])
def test_without_damping_the_sentence_begins_with_that(command):
    note = f"The case gives spring 'valve spring' {NO_DAMPING}: give it."
    study = pair(command)
    runs = [
        replace(one, provenance=replace(one.provenance, notes=(note,), springs=("valve spring",)))
        for one in study.solutions
    ]
    said = replace(study, solutions=tuple(runs)).verdict
    assert said.startswith("Without damping of the springs, ") and not study.verdict.startswith("Without")  # fmt: skip
    inner = [replace(one, provenance=replace(one.provenance, springs=("valve spring", "inner"))) for one in runs]  # fmt: skip
    assert not replace(study, solutions=tuple(inner)).verdict.startswith("Without")


def test_a_sweep_above_the_loss_says_that_its_lowest_speed_is_lost_already():
    lost = {"loss_of_contact_duration": 1e-3}
    study = Study(CaseRecord("own"), "sweep", (run("a", 7800, **lost), run("a", 8000, **lost)), critical_speeds=CriticalSpeeds())  # fmt: skip
    assert study.verdict.startswith("Contact is lost already at 7800 rpm, the lowest speed run. ")
    later = replace(study, solutions=(run("a", 7800), run("a", 8000, **lost)))
    assert later.verdict.startswith("Contact is lost first at 8000 rpm. ")


def test_a_loss_names_its_place_and_a_flight_its_angles():
    def lost(where: str, kind: str, **values: float) -> str:
        details = {"landing_cam_angle": np.radians(306.0)}
        event = Event(kind, np.radians(221.0), 0.01, 1e-3, values.get("loft_gap", 1e-5), "m", where, details)  # fmt: skip
        one = replace(run("a", 7000, loss_of_contact_duration=3e-5, minimum_cam_contact_force=505.0, **values), events=(event,))  # fmt: skip
        return Study(CaseRecord("own"), solutions=(one,)).verdict

    assert "ontact lost at the tappet for 0.03 ms" in lost("tappet", "loss-of-contact")
    flight = lost("cam", "loft", loft_gap=1.2e-3)
    assert (
        "oft of 1.2 mm, 0.03 ms without contact, leaves the cam at 221 cam deg, lands at 306 cam deg"
        in flight
    )
    assert "deg" not in lost("cam", "loft", loft_gap=1e-5)
    periods = {1: " in every cycle", 2: ", again after 2 cycles", 0: ", elsewhere in other cycles"}
    for period, said in periods.items():
        assert f"306 cam deg{said}" in lost(
            "cam", "loft", loft_gap=1.2e-3, motion_period_count=float(period)
        )


def test_wide_error_bars_stand_in_the_sentence_and_hide_a_surge_below_them():
    wide = bar("light", 6000, 340.0, 47.0)
    flat = {"surge_amplitude_force": 200.0}
    study = replace(pair("compare-springs", wide, **flat), between=())
    assert "heavy surges less (200 N against 340 ± 47 N)" in study.verdict
    swept = replace(pair("sweep", wide), between=())
    assert "Worst surge amplitude 340 ± 47 N at 6000 rpm" in swept.verdict
    hidden = replace(swept, error_bars=ErrorBars((bar("light", 6000, 340.0, 400.0),)))
    assert hidden.verdict.endswith("Worst surge amplitude 340 N (not resolved) at 6000 rpm.")  # fmt: skip
    assert "urge not resolved" in replace(hidden, command="compare-springs").verdict


def lost_at(label: str, speed: float, kind: str = "contact-loss") -> CriticalSpeed:
    return CriticalSpeed(label, kind, 0.0, 6000 * RPM, 7000 * RPM, RPM, True, "cam",
                         Crossing(SpeedBracket(speed * RPM, (speed + 1) * RPM)), nominal_engine_speed=speed * RPM)  # fmt: skip


def test_two_springs_are_weighed_at_the_speeds_in_use():
    """Contract: surge, clash and stress were those of speeds at which a spring had lost control long before, and named
    the other winner.
    """
    rows = CriticalSpeeds((lost_at("heavy, modal-uniform", 6300), lost_at("light, modal-uniform", 6600)))  # fmt: skip
    study = replace(pair(), critical_speeds=rows)
    assert study.verdict.endswith(
        "up to 6300 rpm heavy surges less (280 N against 340 N); at all speeds light surges less (393 N against 476 N)."
    )
    red = replace(study, record=replace(study.record, red_line=6500 * RPM))
    assert "; up to 6500 rpm light surges less (340 N against 476 N); at all speeds " in red.verdict
    beyond = {"heavy": 0.5, "light": 2.0}
    stress = [
        replace(
            one,
            quantities={
                **one.quantities,
                "open_nominal_shear_stress": (9e8 if one.spring_set == "heavy" else 8e8)
                * (beyond[one.spring_set] if one.engine_speed > 6500 * RPM else 1.0),
            },
        )
        for one in study.solutions
    ]
    assert replace(study, solutions=tuple(stress), between=()).verdict.startswith(
        "Up to 6300 rpm heavy is stressed more, so of equal wires it breaks first (peak 900 MPa against 800 MPa)"
    )


def test_runs_that_end_beyond_control_come_after_control():
    """Contract: the page of a pushrod controlled to 7056 rpm opened with two runs at coil bind at 8500 and 8600 rpm, and
    said it was clear of it.
    """
    bound = Status("coil-bind", "solid")
    runs = (run("a", 6000, coil_bind_clearance=4e-4), *(replace(run("a", speed), status=bound) for speed in (6800, 7000)))  # fmt: skip
    row = lost_at("a, modal-uniform", 6500)
    study = Study(CaseRecord("own"), "sweep", runs, critical_speeds=CriticalSpeeds((row,)))
    said = study.verdict
    assert said.startswith("Controlled to 6500 rpm, where contact is lost at the cam.")
    assert "2 of 3 runs reached coil bind at 6800 and 7000 rpm" in said and "clear of" not in said
    early = replace(study, critical_speeds=CriticalSpeeds((lost_at("a, modal-uniform", 6900),)))
    assert early.verdict.startswith("2 of 3 runs reached coil bind at 6800 and 7000 rpm; ")


def test_a_tile_says_beyond_only_what_reads_otherwise():
    """Contract: "2.5 mm at 6000 rpm (beyond control 2.5 mm at 7000 rpm)", and two brackets in a row."""
    row = lost_at("a, modal-uniform", 6500)
    runs = tuple(run("a", speed, coil_bind_clearance=bind) for speed, bind in ((5000, 2.9e-3), (6000, 2.5004e-3), (7000, 2.4986e-3)))  # fmt: skip
    study = Study(CaseRecord("own"), "sweep", runs, critical_speeds=CriticalSpeeds((row,)))
    assert dict(key_figures(study))["clearance to coil bind at full lift"] == "2.5 mm at 6000 rpm"
    stress, least = "open_nominal_shear_stress", "closed_nominal_shear_stress"
    found = {"minimum_spring_force": 100.0, least: 1e8}
    slow = run("a", 6000, **{stress: 5e8, "peak_spring_force": 500.0}, **found)
    fast = run("a", 7000, **{stress: 8e8, "peak_spring_force": 900.0}, **found)
    closed = dict(key_figures(replace(study, solutions=(slow, fast))))
    assert closed["shear stress"] == ("100 to 500 MPa (beyond control 800 MPa at 7000 rpm)")
    far = replace(study, solutions=(*runs[:2], run("a", 7000, coil_bind_clearance=2e-3)))
    assert dict(key_figures(far))["clearance to coil bind at full lift"] == "2.5 mm at 6000 rpm (beyond control 2 mm at 7000 rpm)"  # fmt: skip


def test_large_numbers_are_written_out():
    stress = {"open_nominal_shear_stress": 1.26e9}
    study = pair(**stress)
    runs = [
        replace(one, quantities={"open_nominal_shear_stress": 9e8, **one.quantities})
        for one in study.solutions
    ]
    said = replace(study, solutions=tuple(runs)).verdict
    assert said.startswith(
        "heavy is stressed more, so of equal wires it breaks first (peak 1260 MPa against 900 MPa);"
    )


def test_the_page_opens_with_the_comparison_and_its_curves_differ_in_colour():
    study = pair()
    page = study_page(study)
    assert page.verdict == study.verdict and page.kicker == "Comparison of springs"
    assert len({look.colour for look in line_styles(study).values()}) == 2


def test_the_runs_between_are_kept_in_a_file(tmp_path):
    study = pair()
    assert load_result(study.save(tmp_path / "study.nc")).verdict == study.verdict


def test_the_help_keeps_its_brackets():
    told = CliRunner().invoke(app, ["compare-springs", "--help"]).output
    assert "A spring is a case with [spring], as" in " ".join(told.split())


def test_stress_is_compared_with_what_the_wire_is_permitted():
    def stressed(light: dict[str, float], **heavy: float) -> str:
        study = pair(**heavy)
        runs = [replace(one, quantities={**one.quantities, **light}) if one.spring_set == "light" else one for one in study.solutions]  # fmt: skip
        return replace(study, solutions=tuple(runs), between=()).verdict

    bound = {"open_nominal_shear_stress": 1.354e9, "open_uncorrected_shear_stress": 1.1e9, "permitted_shear_stress": 1.014e9}  # fmt: skip
    other = {"open_nominal_shear_stress": 1.216e9, "open_uncorrected_shear_stress": 1e9, "permitted_shear_stress": 1.1e9}  # fmt: skip
    assert stressed(bound, **other).startswith(
        "light is stressed more, so of equal wires it breaks first (peak 1354 MPa against 1216 MPa, 108 % against 91 % of the static limit);"
    )
    unnamed = {"open_nominal_shear_stress": 1.216e9}
    assert "(peak 1354 MPa (108 % of its static limit) against 1216 MPa)" in stressed(bound, **unnamed)  # fmt: skip
    assert stressed(bound).endswith("stress of heavy unknown without its wire.")


def test_the_worst_surge_says_where_in_the_range_it_is():
    """What was worst at the last speed swept, or where the valve flies, was told as a resonance."""
    assert "Worst surge amplitude 476 N at 6444 rpm (order 9)." in pair("sweep").verdict
    rising = pair("sweep", surge_amplitude_force=600.0)
    runs = [replace(one, quantities={**one.quantities, "surge_amplitude_force": one.engine_speed}) for one in rising.solutions]  # fmt: skip
    ended = replace(rising, solutions=tuple(runs), between=())
    assert ended.verdict.endswith(
        "Worst surge amplitude 733 N at 7000 rpm, at the end of the range."
    )
    control = CriticalSpeed("heavy, modal-uniform", "float", 5e-5, 6000 * RPM, 7000 * RPM, RPM, True, "valve",
                            Crossing(SpeedBracket(6300 * RPM, 6310 * RPM)), nominal_engine_speed=6305 * RPM)  # fmt: skip
    lost = replace(pair("sweep"), critical_speeds=CriticalSpeeds((control,)))
    assert "Worst surge amplitude 280 N at 6000 rpm, beyond 6305 rpm 476 N at 6444 rpm (order 9)." in lost.verdict  # fmt: skip


def test_the_table_of_a_sweep_has_the_runs_between_its_speeds_as_the_sentence():
    """The sentence had 476 N between the speeds, the table 280 N at one of them."""
    rows = {row.name: row for row in headline_rows(pair("sweep"))}
    assert rows["surge_amplitude_force"].values == pytest.approx((475.7, 393.0))
    assert rows["surge_amplitude_force"].engine_speeds == pytest.approx((6444 * RPM, 6555 * RPM))


def test_a_sweep_says_why_control_is_lost():
    def event(kind: str, size: float, cause: str, **details: float) -> Event:
        return Event(kind, np.pi, 0.01, 1e-3, size, "m", "cam", {"cause": cause, **details})

    lost = event("loft", 1e-4, CAUSE_SURGE, spring_force_loss=215.0)
    flies = event("float", 2e-4, CAUSE_INERTIA)
    runs = (
        run("a", 6000, loss_of_contact_duration=0.0),
        replace(run("a", 6250, loss_of_contact_duration=1e-3, surge_amplitude_cam_order=8.0), events=(lost,)),
        replace(run("a", 7000, loss_of_contact_duration=1e-3), events=(lost, flies)),
    )  # fmt: skip
    found = [
        CriticalSpeed("a, modal-uniform", kind, limit, 6000 * RPM, 7000 * RPM, RPM, True, "cam",
                      Crossing(SpeedBracket(speed * RPM, (speed + 1) * RPM)), nominal_engine_speed=speed * RPM)
        for kind, limit, speed in (("contact-loss", 0.0, 6140), ("float", 5e-5, 6917))
    ]  # fmt: skip
    said = Study(CaseRecord("own"), "sweep", runs, critical_speeds=CriticalSpeeds(tuple(found))).verdict  # fmt: skip
    assert said.startswith(
        "Controlled to 6140 rpm, where contact is lost at the cam because surge lowers the spring force by 215 N "
        "at 6250 rpm (order 8); floats from 6917 rpm (inertia exceeds the spring force); contact opens at 180 cam deg (run at 6250 rpm). "
    )
    none = Study(CaseRecord("own"), "sweep", runs, critical_speeds=CriticalSpeeds()).verdict
    assert none.startswith("Contact is lost first at 6250 rpm because surge lowers the spring force by 215 N at 6250 rpm (order 8)")  # fmt: skip


def test_the_power_of_a_sweep_is_that_of_its_controlled_speeds():
    """The tile gave the power at 7000 rpm, where the valve flies and parts meet again on the cam."""
    runs = (
        run("a", 6000, mean_cam_power=20.0, minimum_cam_contact_force=90.0),
        run("a", 6500, mean_cam_power=31.0, minimum_cam_contact_force=8.0),
        run("a", 7000, mean_cam_power=900.0, minimum_cam_contact_force=0.0),
    )
    assert dict(key_figures(Study(CaseRecord("own"), "sweep", runs)))["cam power per valve"] == "31 W at 6500 rpm"  # fmt: skip
    flying = dict(key_figures(Study(CaseRecord("own"), "sweep", runs[2:])))
    assert flying["cam power per valve"] == "900 W, beyond control: with impacts"


def test_a_cause_at_the_critical_speed_goes_before_those_of_swept_speeds():
    """The cause was that of the next speed swept, and so of the grid."""
    lost = Event("loft", 4.0, 0.01, 1e-3, 1e-4, "m", "cam", {"cause": CAUSE_INERTIA})
    runs = (run("a", 6000), replace(run("a", 6250), events=(lost,)))
    row = CriticalSpeed("a, modal-uniform", "contact-loss", 0.0, 6000 * RPM, 6250 * RPM, RPM, True, "cam",
                        Crossing(SpeedBracket(6140 * RPM, 6141 * RPM)), nominal_engine_speed=6140 * RPM,
                        cause=CAUSE_SURGE, spring_force_loss=54.6, surge_order=6)  # fmt: skip
    said = Study(CaseRecord("own"), "sweep", runs, critical_speeds=CriticalSpeeds((row,))).verdict
    assert "because surge lowers the spring force by 54.6 N there (order 6)" in said
    assert "inertia" not in said


def test_a_sweep_says_where_float_ends_and_returns():
    again = (SpeedBracket(7600 * RPM, 7700 * RPM), SpeedBracket(7900 * RPM, 8000 * RPM))
    row = CriticalSpeed("a, modal-uniform", "float", 5e-5, 6000 * RPM, 8000 * RPM, RPM, True, "valve",
                        Crossing(SpeedBracket(7093 * RPM, 7094 * RPM)), Crossing(SpeedBracket(7300 * RPM, 7306 * RPM)),
                        nominal_engine_speed=7094 * RPM)  # fmt: skip
    for ranges, text in (
        ((), "until 7300 rpm"),
        (again[:1], "until 7300 and again from 7600 rpm"),
        (again, "until 7300 and again in 2 ranges from 7600 rpm"),
    ):
        found = CriticalSpeeds((replace(row, again=ranges),))
        said = Study(CaseRecord("own"), "sweep", (run("a", 6000),), critical_speeds=found).verdict
        assert f"controlled to 7094 rpm, where the valve floats, {text}." in said.lower()


def test_the_curve_of_a_sweep_passes_through_the_runs_of_its_search():
    """The curve stood above zero at the speed at which it was marked that contact is lost."""
    runs = tuple(run("a", speed, minimum_cam_contact_force=force) for speed, force in ((6000, 90.0), (7000, 40.0)))  # fmt: skip
    row = CriticalSpeed("a, modal-uniform", "contact-loss", 0.0, 6000 * RPM, 7000 * RPM, RPM, True, "cam",
                        Crossing(SpeedBracket(6499 * RPM, 6500 * RPM)), nominal_engine_speed=6500 * RPM,
                        curve=((6000 * RPM, 90.0), (6500 * RPM, 0.0), (6750 * RPM, 3.0)))  # fmt: skip
    chart = regime_chart(Study(CaseRecord("own"), "sweep", runs, critical_speeds=CriticalSpeeds((row,))))  # fmt: skip
    (curve,) = chart.panels[0].layers
    assert curve.x == pytest.approx([6000, 6500, 6750, 7000])
    assert curve.y == pytest.approx([90, 0, 3, 40])


def test_a_verdict_says_where_the_ends_of_the_spring_would_lift():
    """A note alone said so, and the sentence gave the flight on a spring that pulls as if it were right."""
    pull = Event("end-pull", 4.0, 0.01, 1e-3, 0.0, "N", "retainer")
    fast = replace(run("a", 7000), events=(pull,))
    said = "the ends of the spring would lift, which modal-uniform does not show (take wave-rod)"
    model = replace(fast, provenance=replace(fast.provenance, model="modal-uniform"))
    assert said in Study(CaseRecord("own"), "run", (model,)).verdict.lower()
    swept = Study(CaseRecord("own"), "sweep", (run("a", 6000), model)).verdict
    assert f" At 7000 rpm {said};" in swept
    assert "would lift" not in Study(CaseRecord("own"), "sweep", (run("a", 6000),)).verdict
