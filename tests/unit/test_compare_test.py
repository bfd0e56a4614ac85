"""Unit: a model against measured cycles and values: what is said, by every way in, and what is
refused.

The tests are synthesised from a run whose motion is known, so that every shift, bias and verdict
has a known answer.
"""

from __future__ import annotations

import json
from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from scipy import stats

import valvetrain as vt
from unit.cli_parts import call as invoke
from unit.cli_parts import typed
from valvetrain.compare_test import compare as compare_test
from valvetrain.compare_test.answer import AgainstTestAnswer
from valvetrain.errors import InputError
from valvetrain.measured.cycles import MeasuredCycles, write_cycles
from valvetrain.measured.sensor import Sensor
from valvetrain.measured.value_table import MeasuredValue, ValueTable, read_value_table
from valvetrain.quantities.traces import Trace, trace_of
from valvetrain.solution.status import Status

SPEED = "3000 rpm"
CHAIN = ("multi-mass",)
RUNS: dict[object, vt.Study] = {}


@pytest.fixture(autouse=True)
def one_run_of_each(monkeypatch):
    """The computation itself is tested elsewhere: each run that is asked for is computed once."""
    monkeypatch.setattr(compare_test, "simulate", remembered)


def remembered(case, speeds, **more):
    key = case.name, case.text, speeds, tuple(more["models"]), more["workers"]
    if key not in RUNS:
        RUNS[key] = vt.simulate(case, speeds, **more)
    return RUNS[key]


@cache
def chain() -> Trace:
    return trace_of(vt.simulate("job-t", SPEED, models=CHAIN).solutions[0], "spring_force")


def cycles(count=8, angles=360, bias=0.0, late=0.0, seed=1, size=4.0):
    """Cycles of the chain's own force, later by ``late`` degrees and higher by ``bias`` (N), with
    scatter of 20 harmonics.
    """
    angle = np.arange(angles) * 2 * np.pi / angles
    turned = np.outer(np.arange(1, 21), angle)
    drawn = np.random.default_rng(seed).standard_normal((count, 2, 20)) * size / np.sqrt(20)
    values = (
        chain().at(angle - np.radians(late))
        + bias
        + drawn[:, 0] @ np.cos(turned)
        + drawn[:, 1] @ np.sin(turned)
    )
    return MeasuredCycles("spring_force", "N", angle, values, 50 * np.pi, "made up", synthetic=True)


def compared(test, **more):
    return vt.compare_test.compare_with_test("job-t", test, **{"models": CHAIN, **more})


def codes(found) -> set[str]:
    return set(AgainstTestAnswer(found).findings.codes)


def verdict(found):
    return AgainstTestAnswer(found).verdict


def test_the_truth_is_not_refuted_and_a_bias_is():
    true, off = compared(cycles()), compared(cycles(bias=12.0))
    assert true.best.adequacy.adequate and (verdict(true).code, verdict(true).mark) == (
        "T204",
        "ok",
    )
    assert not off.best.adequacy.adequate and (verdict(off).code, verdict(off).mark) == (
        "T203",
        "bad",
    )
    where = verdict(off).fields["where"].fields
    assert where["side"] == "too low" and 8.0 < where["off"].value < 20.0
    assert "finite-element" in AgainstTestAnswer(off).next_step
    assert off.best.agreement.bias == pytest.approx(-12.0, abs=1.0)
    assert not true.best.band.outside.any() and off.best.band.outside.mean() > 0.3


def test_a_shift_is_recovered_with_its_interval_and_taken_away():
    found = compared(cycles(late=1.3))
    near = found.best.agreement
    assert verdict(found).code == "T202" and verdict(found).fields["late"] == "early"
    assert np.degrees(near.shift) == pytest.approx(-1.3, abs=2 * np.degrees(near.shift_reach))
    assert 0.01 < np.degrees(near.shift_reach) < 0.3 and near.rest < 0.5 * near.rms


def test_the_numbers_do_not_depend_on_the_samples_of_the_model():
    found = [compared(cycles(bias=1.0), **more).best for more in ({}, {"models": CHAIN})]
    steps = [
        vt.compare_test.compare_with_test(
            vt.load_case("job-t", {"operation.output_step": step}),
            cycles(bias=1.0),
            models=CHAIN,
        ).best
        for step in ("0.5 deg", "2 deg")
    ]
    for one in (found[1], *steps):
        assert one.adequacy.ratio == pytest.approx(found[0].adequacy.ratio, rel=0.01)
        assert one.agreement.rms == pytest.approx(found[0].agreement.rms, rel=0.01)


def test_the_order_of_cycles_and_their_unit_do_not_matter(tmp_path):
    own = cycles()
    turned = replace(own, values=own.values[::-1])
    text = write_cycles(tmp_path / "own.csv", own).read_text().replace("# unit: N", "# unit: lbf")
    rows = [
        line if line[:1] in "#c" else _scaled(line, 1 / 4.4482216152605)
        for line in text.splitlines()
    ]
    (tmp_path / "pounds.csv").write_text("\n".join(rows))
    ratios = [
        compared(test).best.adequacy.ratio
        for test in (own, turned, tmp_path / "own.csv", tmp_path / "pounds.csv")
    ]
    assert ratios == pytest.approx([ratios[0]] * 4, rel=1e-9)


def _scaled(line, factor):
    first, *rest = line.split(",")
    return ",".join([first, *(repr(float(value) * factor) for value in rest)])


def test_python_command_line_and_page_say_the_same(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    write_cycles("own.csv", cycles(bias=5.0))
    found = compared("own.csv", models=("multi-mass", "massless"))
    command = typed("compare-test job-t --test own.csv --model multi-mass,massless --output out")
    data = json.loads(invoke(*command, "--json").stdout)
    for told, one in zip(data["runs"], found.runs, strict=True):
        assert (
            told["f_test"]["ratio"] == one.adequacy.ratio
            and told["f_test"]["p_value"] == one.adequacy.p_value
        )
        assert told["agreement"]["shift"] == one.agreement.shift
        assert told["band"]["share_outside"] == one.band.outside.mean()
    assert data["findings"][0]["code"] == verdict(found).code and "verdict" not in data
    shown, page = invoke(*command).stdout, (tmp_path / "out" / "report.html").read_text()
    assert "synthetic" in shown and "synthetic" in page and verdict(found).reason in page
    assert {path.rsplit("/")[-1] for path in data["files"]} >= {
        "curves.csv",
        "report.html",
        "run.json",
    }
    rows = np.genfromtxt(tmp_path / "out" / "curves.csv", delimiter=",", skip_header=1)
    assert rows[:, 2] - rows[:, 1] == pytest.approx(rows[:, 3], abs=1e-5)


def test_one_cycle_two_cycles_and_alike_cycles_say_what_they_cannot():
    one = compared(cycles(1))
    assert one.best.adequacy is None and one.best.band is None
    assert (verdict(one).code, verdict(one).mark) == ("T205", "warn")
    two = compared(cycles(2))
    assert two.best.adequacy is not None and two.best.band is None
    assert "T214" in codes(two) and "T214" not in codes(one)
    own = cycles(12)
    drifting = replace(own, values=own.values + 8 * np.linspace(-1, 1, 12)[:, None])
    assert "T215" in codes(compared(drifting)) and compared(drifting).separate < 6
    assert "T215" not in codes(compared(own)) and "T211" in codes(compared(own))


def test_errors_that_all_cycles_share_are_stated_apart():
    """A bias within what is stated refutes nothing; the sums of variances and degrees of freedom
    are those of Satterthwaite.
    """
    alone, shared = (
        compared(cycles(bias=5.0)).best,
        compared(cycles(bias=5.0), shared="4 N, 0.1 deg"),
    )
    test = shared.best.adequacy
    assert (
        not alone.adequacy.adequate
        and test.adequate
        and len(test.shared) == 2
        and test.shared[0] == pytest.approx(16.0)
    )
    own, part, angle = test.reproducibility, 8 * 16.0, 8 * test.shared[1]
    assert test.expected == pytest.approx(own + part + angle)
    assert test.degrees[0] == pytest.approx(
        test.expected**2 / (own**2 / test.independent + part**2 + angle**2)
    )
    assert "offset 4 N, angle 0.1 cam deg" in " ".join(shared.notes)
    assert "T291" not in codes(shared) and "T291" in codes(compared(cycles(bias=5.0)))
    assert shared.best.band.half_width.min() > alone.band.half_width.min() + 4


def test_angles_are_one_turn_of_the_cam():
    """A last angle that is the first again is left out; two turns, as crank angles make, are
    refused; any zero of the angle will do.
    """
    own = cycles()
    closed = replace(
        own,
        cam_angle=np.append(own.cam_angle, 2 * np.pi),
        values=np.hstack([own.values, own.values[:, :1]]),
    )
    turned = replace(own, cam_angle=own.cam_angle - np.pi, values=np.roll(own.values, 180, axis=1))
    found = [compared(test).best for test in (own, closed, turned)]
    assert [one.adequacy.ratio for one in found] == pytest.approx(
        [found[0].adequacy.ratio] * 3, rel=1e-9
    )
    assert [one.agreement.shift for one in found] == pytest.approx(
        [found[0].agreement.shift] * 3, abs=1e-9
    )
    with pytest.raises(InputError, match="half of the crank's"):
        compared(replace(own, cam_angle=2 * own.cam_angle))


def test_numbers_nobody_measures_are_refused():
    for factor in (1e6, 1e-6, 1e200):
        with pytest.raises(InputError, match=r"reaches .* N, outside"):
            replace(cycles(), values=factor * cycles().values)
    few = replace(cycles(), values=np.broadcast_to(cycles(1).values, (2001, 360)))
    with pytest.raises(InputError, match="at most 2000 cycles"):
        compared(few)


def test_runs_that_fail_are_told_and_no_run_is_no_verdict(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    whole = vt.simulate("job-t", SPEED, models=CHAIN)
    lost = replace(
        whole.solutions[0],
        status=Status("diverged", "the force grew without bound", remedy="take a smaller step"),
    )
    monkeypatch.setattr(
        compare_test, "simulate", lambda *_, **__: replace(whole, solutions=(lost,))
    )
    compared_before = compare_test.compare_study_with_test(whole, "job-t", cycles())
    found = compared(cycles())
    assert not found.runs and "multi-mass at 3000 rpm of the crank: " in found.failures[0]
    with pytest.raises(InputError, match="nothing to compare"):
        _ = found.best
    assert verdict(found).code == "T201" and "T210" in codes(found)
    assert not codes(compared_before) & {"T201", "T210"}
    write_cycles("own.csv", cycles())
    shown = invoke("compare-test", "job-t", "--test", "own.csv", "--model", "multi-mass")
    assert shown.exit_code == 1 and "grew without bound" in shown.output


def test_missing_values_are_left_out_and_said():
    own = cycles()
    values = own.values.copy()
    values[0, :250], values[3, 10:20] = np.nan, np.nan
    found = compared(replace(own, values=values))
    assert found.test.values.shape == (7, 350) and any(
        "1 cycles lack" in note for note in found.notes
    )
    assert any("10 of 360 angles" in note for note in found.notes)
    values[:, ::2] = np.nan
    values[1:4] = np.nan
    with pytest.raises(InputError, match="fewer than 8 angles"):
        compared(replace(own, values=np.full_like(values, np.nan)))


def test_the_speed_of_the_test_is_run_and_a_wrong_one_is_said():
    found = compared(replace(cycles(), cam_speed=49 * np.pi))
    assert found.study.engine_speeds == pytest.approx((98 * np.pi,))
    assert "2940 rpm of the crank, the case names" in found.notes[0]
    other = compared(cycles(), engine_speed="3300 rpm")
    assert "T213" in codes(other) and "T213" not in codes(found)
    silent = compared(replace(cycles(), cam_speed=0.0))
    assert "does not state its speed" in silent.notes[0]
    with pytest.raises(InputError, match="give the engine speed"):
        vt.compare_test.compare_with_test("gu2021-beehive-blind", replace(cycles(), cam_speed=0.0))


@pytest.mark.parametrize(
    ("changes", "more", "words"),
    [
        (
            {"quantity": "shoe_size"},
            {},
            "has no curve 'shoe_size'; it has spring_force, retainer_force",
        ),
        ({"quantity": "valve_lift"}, {}, "gives valve_lift in N, the model in m"),
        ({}, {"fitted": -1}, "-1 is outside 0"),
        ({}, {"shared": "2 mm"}, "no error of a quantity in N"),
        ({}, {"shared": "2 N, 3 N"}, "the second offset"),
        ({}, {"shared": "-1 %"}, "above zero"),
    ],
)
def test_what_does_not_fit_is_refused_in_one_sentence(changes, more, words):
    with pytest.raises(InputError, match=words) as told:
        compared(replace(cycles(), **changes), **more)
    assert "\n" not in str(told.value)


@pytest.mark.parametrize(
    ("content", "words"),
    [
        (b"", "empty"),
        (b"\x00\x01\x02" * 40, "no text"),
        (b"hello", "holds no row of numbers"),
        (b"# quantity: valve_lift\nangle,1\n0,1\n10,2\n", "does not say its unit"),
        (b"quantity,unit,value,scatter\npeak_spring_force,N,800,\n", "scatter is missing"),
        (b"quantity,unit,value,scatter\npeak_spring_force,N,800,0\n", "is positive"),
        (b"quantity,unit,repeat 1\npeak_spring_force,N,800\n", "one repeat"),
        (b"quantity,value,scatter\npeak_spring_force,800,1\n", "column 'unit'"),
        (b"quantity,unit,value,scatter,colour\n", "holds no table"),
        (b"quantity,unit,value,scatter,colour\na,N,1,1,red\n", "column 'colour'"),
        (b"quantity,unit,value,scatter,cam angle\na,N,1,1,2\n", "has no unit"),
    ],
)
def test_damaged_files_are_refused_in_one_sentence(tmp_path, monkeypatch, content, words):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "test.csv").write_bytes(content)
    monkeypatch.setattr("valvetrain.cli.progress.seconds_to_compile", lambda *kinds: 30.0)
    shown = invoke("compare-test", "job-t", "--test", "test.csv")
    assert "compil" not in shown.output  # a file is read before anything that takes long
    assert (
        shown.exit_code == 2
        and words in " ".join(shown.output.split())
        and len(list(tmp_path.iterdir())) == 1
    )


def test_values_with_stated_scatter_are_counted_in_it(tmp_path):
    """Chi square by scipy of the same deviations; an angle counted through the cycle meets its
    neighbour whatever its number.
    """
    force = vt.simulate("job-t", SPEED, models=CHAIN).solutions[0].quantities
    peak, angle = force["peak_spring_force"], np.degrees(force["peak_spring_force_cam_angle"])
    (tmp_path / "values.csv").write_text(
        "# engine speed: 3000 rpm\n# note: no scatter is stated; assumed are 1 %\n"
        "quantity,unit,value,scatter,cam angle [deg],angle scatter [deg]\n"
        f"peak_spring_force,N,{peak - 6},3,{angle + 1},2\nleast_spring_force,N,{chain().values.min() + 2},1 %,,\n"
        f"spring_force,N,{chain().at(np.array([np.pi]))[0]},5,180,\nshoe_size,mm,1,1,,\n"
    )
    found = compared(tmp_path / "values.csv")
    off = [row.in_scatters for row in found.best.values if np.isfinite(row.model)]
    assert (
        off[0] == pytest.approx(2.0, abs=1e-9)
        and off[1] == pytest.approx(-0.5, abs=1e-6)
        and off[3] == pytest.approx(0.0, abs=1e-6)
    )
    assert found.best.adequacy.p_value == pytest.approx(
        stats.chi2.sf(np.sum(np.square(off)), 4), rel=1e-6
    )
    assert verdict(found).code == "T204" and {"T212", "T291"} <= codes(found)
    assert any("no scatter is stated" in note for note in found.notes)
    assert [line.mark for line in AgainstTestAnswer(found).lines].count("ok") == 5


def test_repeats_of_values_give_fishers_ratio_and_are_compared_in_pairs(tmp_path):
    """Four places, six repeats: the ratio of the sums of squares, and the worth of a bias."""
    drawn = np.random.default_rng(8).standard_normal((4, 6))
    drawn += np.array([[0.3], [-0.3], [0.2], [0.0]]) - drawn.mean(axis=1, keepdims=True)
    truth = [float(chain().at(np.radians([place]))[0]) for place in (60.0, 150.0, 180.0, 300.0)]
    for bias, adequate in ((0.0, True), (3.0, False)):
        values = tuple(
            MeasuredValue(
                "spring_force",
                "N",
                level + bias + own,
                cam_angle=np.radians(place),
                engine_speed=100 * np.pi,
            )
            for level, own, place in zip(truth, drawn, (60.0, 150.0, 180.0, 300.0), strict=True)
        )
        test = compared(ValueTable(values)).best.adequacy
        mean = drawn.mean(axis=1) + bias
        within = np.sum((drawn - drawn.mean(axis=1, keepdims=True)) ** 2) / 20
        assert (
            test.ratio == pytest.approx(6 * np.mean(mean**2) / within, rel=1e-6)
            and test.adequate is adequate
        )


def test_tables_that_mix_units_have_no_f_test():
    values = (
        MeasuredValue("peak_spring_force", "N", np.array([1.0, 2.0])),
        MeasuredValue("peak_valve_lift", "mm", np.array([1.0, 2.0])),
    )
    found = compared(ValueTable(values), engine_speed=SPEED)
    assert found.best.adequacy is None and verdict(found).code == "T205"
    assert "several units" in verdict(found).reason


def test_a_model_is_seen_through_the_gauge_of_the_test():
    """A harmonic at the -3 dB frequency of a first-order gauge comes out lower by the root of two
    and an eighth of its period later.
    """
    angle = np.arange(720) * 2 * np.pi / 720
    trace = Trace(angle, np.sin(6 * angle), "N", 0.02, True)
    seen = trace.through(Sensor(bandwidth=300.0, order=1)).at(angle)
    assert seen == pytest.approx(np.sin(6 * angle - np.pi / 4) / np.sqrt(2), abs=1e-3)
    late = compared(cycles(), sensor=Sensor(bandwidth="200 Hz")).best.agreement
    assert late.shift > 3 * late.shift_reach


def test_a_model_without_the_curve_is_left_out_and_said():
    """A massless spring has no coils."""
    run = vt.simulate("job-t", SPEED, models=CHAIN).solutions[0]
    angle = np.arange(180) * 2 * np.pi / 180
    moved = trace_of(run, "coil_3_displacement").at(angle)
    test = MeasuredCycles(
        "coil_3_displacement",
        "m",
        angle,
        moved + 1e-5 * np.outer([1.0, -1.0, 0.5, -0.5], np.cos(angle)),
        50 * np.pi,
    )
    found = compared(test, models=("massless", "multi-mass"))
    assert [one.label for one in found.runs] == ["multi-mass"] and found.best.adequacy.adequate
    (left_out,) = AgainstTestAnswer(found).findings.by("T212")
    assert left_out.fields["names"] == "massless" and "T212" not in codes(compared(test))
    with pytest.raises(InputError, match="the massless run has no curve"):
        compared(test, models=("massless",))


def test_a_table_is_read_in_the_units_it_says(tmp_path):
    file = tmp_path / "table.csv"
    file.write_text(
        "# source: own rig\n# synthetic: yes\nquantity;unit;repeat 1;repeat 2;cam speed [rpm]\npeak_valve_lift;mm;9.1;9.3;1500\n"
    )
    found = read_value_table(file)
    assert found.synthetic and found.source == "own rig" and found.repeats == 2
    assert found.values[0].value == pytest.approx(9.2e-3) and found.values[
        0
    ].engine_speed == pytest.approx(100 * np.pi)
