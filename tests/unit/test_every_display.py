"""How results show themselves: every sentence, short text, small table and frame with each part
there once and missing once.
"""

from __future__ import annotations

import math
import re
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

import synthetic_study as made
from valvetrain.cosserat.static import compress
from valvetrain.errors import InputError
from valvetrain.integrate.run import joined
from valvetrain.lift.page import lift_notes
from valvetrain.parameters.constructors import cylindrical
from valvetrain.report.json import study_json
from valvetrain.report.study import write_study
from valvetrain.solution.critical import CriticalSpeed, CriticalSpeeds, Crossing, SpeedBracket
from valvetrain.solution.display import frame, span, table, value_text
from valvetrain.solution.modes import ModalResult, TrainModes
from valvetrain.solution.partial_failures import PartialFailures
from valvetrain.solution.provenance import Provenance
from valvetrain.solution.quantity import Quantities, Quantity
from valvetrain.solution.result import Solution
from valvetrain.solution.status import Status
from valvetrain.solution.study import Study
from valvetrain.springs.finite_element import FiniteElementRod
from valvetrain.springs.finite_element_channels import _strains

RPM = math.pi / 30


@pytest.mark.parametrize(
    ("value", "unit", "told"),
    [
        (0.0071234567, "m", "7.1235 mm"),
        (1.0, "rad", "57.296 deg"),
        (RPM * 3000, "rad/s", "3000 rpm"),
        (41e3, "N/m", "41 N/mm"),
        (3e8, "Pa", "300 MPa"),
        (0.05, "kg", "50 g"),
        (0.002, "J", "2 mJ"),
        (0.003, "N s", "3 mN s"),
        (0.25, "1", "0.25"),
        (7.0, "N", "7 N"),
    ],
)
def test_a_value_in_the_units_of_the_field(value, unit, told):
    assert value_text(value, unit) == told


def test_least_and_largest():
    assert span([0.002, np.nan, -0.001], "m") == "-1 to 2 mm"
    assert span([], "m") == span([np.nan, np.nan], "m") == "none"
    assert span([3.0, 4.0], "N") == "3 to 4 N"


def test_a_small_table_escapes_its_words_and_counts_what_it_leaves_out():
    whole = table("a < b\nc", ("x", "y"), [(str(n), "<") for n in range(30)])
    assert (
        whole.count("<tr>") == 31
        and "more" not in whole
        and "a &lt; b<br>c" in whole
        and "<td>&lt;</td>" in whole
    )
    longer = table("t", ("x", "y"), [(str(n), "") for n in range(33)])
    assert longer.count("<tr>") == 32 and "<td colspan='2'>and 3 more</td>" in longer
    assert "<td>29</td>" in longer and "<td>30<" not in longer


def test_a_frame_keeps_units_and_its_index():
    bare = frame({"a": [1, 2]})
    assert bare.attrs["units"] == {} and list(bare.index) == [0, 1]
    told = frame({"a": [1, 2], "b": [3, 4]}, "a", {"b": "N"})
    assert (
        told.attrs["units"] == {"b": "N"}
        and list(told.index) == [1, 2]
        and list(told.columns) == ["b"]
    )


@pytest.mark.parametrize(
    ("status", "told"),
    [
        (Status(), "completed"),
        (Status("completed", "twice"), "completed: twice"),
        (Status("completed", "twice", 0.5, "coil 2", "do it once"), "completed: twice; do it once"),
        (
            Status("diverged", "too fast", 0.0125, "coil 2", "shorten the step"),
            "diverged: too fast, at time 0.0125 s at coil 2; shorten the step",
        ),
        (Status("diverged", "too fast", 0.0125), "diverged: too fast, at time 0.0125 s"),
        (Status("refused", "no mass", 0.5, "card"), "refused: no mass"),
        (Status("buckled", "bowed", 0.5), "buckled: bowed"),
        (Status("worker-lost", "gone", 0.5), "worker-lost: gone"),
        (Status("interrupted", "stopped"), "interrupted: stopped"),
        (Status("interrupted", "stopped", 0.25), "interrupted: stopped, at time 0.25 s"),
    ],
)
def test_a_status_in_one_line(status, told):
    assert status.sentence() == told


def test_quantities_by_name_by_run_and_at_rest():
    speed = 5600 * RPM
    few = Quantities(
        {
            Quantity("preload"): 300.0,
            Quantity("peak_seat_force", speed, "rod"): 820.0,
            Quantity("preload", None, "x"): 1.0,
        }
    )
    assert repr(few).splitlines() == [
        "Quantities: 3 values of 2 names",
        "  preload 300 N",
        "  peak_seat_force 820 N (rod, 5600 rpm)",
        "  preload 1 N (x)",
    ]
    assert (
        few.at_rest() == {"preload": 1.0}
        and few.at_rest("") == {"preload": 300.0}
        and few.at_rest("x") == {"preload": 1.0}
    )
    assert (
        few.of_run("rod", "5600 rpm") == {"peak_seat_force": 820.0} and few.of_run("x", speed) == {}
    )
    with pytest.raises(InputError, match=re.escape("computed 2 times ( at 0 rpm, x at 0 rpm)")):
        few["preload"]
    with pytest.raises(KeyError):
        few["peak_retainer_force"]
    with pytest.raises(KeyError):
        few[Quantity("peak_seat_force", speed, "other")]
    many = Quantities(
        {Quantity("peak_seat_force", n * 1000 * RPM, "rod"): 800.0 + n for n in range(1, 7)}
    )
    assert repr(many).splitlines()[-2:] == [
        "  peak_seat_force 804 N (rod, 4000 rpm)",
        "  and 2 more",
    ]
    told = many.to_pandas()
    assert list(told["value"]) == [801.0, 802, 803, 804, 805, 806] and told[
        "unit"
    ].unique().tolist() == ["N"]
    assert told["engine_speed"].iloc[1] == pytest.approx(2000 * RPM) and set(told["label"]) == {
        "rod"
    }
    assert np.isnan(few.to_pandas()["engine_speed"].iloc[0])


def test_a_study_tells_what_it_holds():
    study = made.own_study()
    lines = repr(study).splitlines()
    assert lines[0] == (
        "7 coil clashes (44 mJ in all), hardest 345 N between coils 1–2 at 251 cam deg "
        "at 5600 rpm (finite-element); "
        "clear of coil bind by 1.25 mm at full lift (at rest); "
        "peak spring force below 10 kHz 811 N, minimum 288 N at 4200 rpm (finite-element); "
        "models differ by 1.4 % in peak force at 5600 rpm."
    )
    assert (
        lines[1] == "  Study of own-spring (compare): 4 runs"
        and "4200 rpm" in lines[2]
        and "to" not in lines[2].split(";")[1]
    )
    assert lines[3].startswith(
        f"  quantities ({len(study.quantities)}): preload 287 N, coil_bind_lift 10.25 mm, "
    )
    assert lines[3].endswith(", ...") and len(lines) == 4
    bare = Study(study.record)
    assert repr(bare) == "Study of own-spring (run): no runs"
    one = repr(replace(study, solutions=study.solutions[:1])).splitlines()
    assert one[:2] == [
        "Clear of coil bind by 1.25 mm, no coil clash, peak spring force below 10 kHz 811 N, minimum 288 N.",
        "  Study of own-spring (compare): 1 run",
    ]
    published = made.published_study()
    assert (
        f"{len(published.comparisons)} comparisons with published values, {len(published.findings)} findings"
        in repr(published)
    )
    failed = replace(
        study,
        solutions=(made.rod_run(status=Status("diverged", "too fast", 0.1)), *study.solutions[2:]),
    )
    assert "1 not completed: " in repr(failed) and "too fast" in repr(failed)
    assert repr(failed).startswith("One of 3 runs diverged at 5600 rpm (finite-element); ")
    swept = repr(made.sweep_study(12)).splitlines()[2]
    assert "; 12 engine speeds, " in swept and " to " in swept


def test_a_study_finds_its_runs():
    study = made.own_study()
    label, speed = study.labels[0], study.engine_speeds[0]
    assert (
        study.solution(label, speed) is study.runs(label)[0]
        and study.solution(label, "4200 rpm") is study.runs(label)[0]
    )
    for asked in ((), (label,), ("", speed), ("none", speed)):
        with pytest.raises(InputError, match="runs fit") as refusal:
            study.solution(*asked)
        assert str(refusal.value).startswith(
            {(): "4", (label,): "2", ("", speed): "2"}.get(asked, "no")
        )
    assert f"{label} at 4200 rpm; " in str(refusal.value)
    assert [one.model for one in study.rest] == ["finite-element", "multi-mass"]
    assert study.at_rest() is study.rest[0] and study.at_rest("multi-mass") is study.rest[1]
    assert study.at_rest("multi-mass", "spring") is study.rest[1] and study.at_rest(
        "solid"
    ) is None is study.at_rest("", "inner")
    cells = re.findall(r"<th>(.*?)</th>", study._repr_html_())
    assert cells[:3] == ["run", "engine speed", "status"] and len(cells) <= 8


def test_a_run_tells_what_it_holds():
    run = made.rod_run()
    told = repr(run).splitlines()
    assert (
        told[0] == "7 coil clashes (44 mJ in all), hardest 345 N between coils 1–2 "
        "at 251 cam deg, clear of coil bind by 1.25 mm at full lift (at rest), peak spring force below 10 kHz 811 N, minimum 288 N."
    )
    assert told[1] == "  Solution of own-spring, finite-element, 5600 rpm: completed"
    assert (
        told[2]
        == f"  {len(run.time)} samples, 0 to 719.5 deg of the cam; {len(run.arrays.variables)} channels"
    )
    assert told[3].startswith("  seat_force ") and told[4].startswith("  retainer_force ")
    short = repr(
        replace(
            run,
            quantities={"peak_seat_force": 820.0, "preload": 300.0, "maximum_lift": 9e-3},
            gaps=("one is lost",),
        )
    )
    assert (
        "quantities (3): peak_seat_force 820 N, preload 300 N, maximum_lift 9 mm" in short
        and ", ..." not in short
    )
    assert short.splitlines()[-1] == "  1 not found: one is lost"
    more = repr(
        replace(
            run,
            quantities={
                "preload": 1.0,
                "peak_seat_force": 2.0,
                "maximum_lift": 1e-3,
                "minimum_seat_force": 3.0,
            },
        )
    )
    assert "quantities (4): preload 1 N, peak_seat_force 2 N, maximum_lift 1 mm, ..." in more
    assert (
        repr(Solution(run.reduced().channels, provenance=Provenance("", "")))
        == "Solution of a case, unnamed model: completed"
    )
    assert len(run.reduced().time) == 0 and run.reduced().quantities == run.quantities


def test_modes_tell_the_first_six():
    count = 8
    modes = ModalResult(
        7e-3,
        np.arange(1, 9) * 100.0,
        np.zeros((8, 0, 3)),
        np.zeros(0),
        np.ones(8),
        tuple(range(count)),
    )
    assert (
        repr(modes)
        == "ModalResult at 7 mm compression, 8 modes, completed\n  8 axial: 100, 200, 300, 400, 500, 600, ... Hz"
    )
    assert repr(replace(modes, axial_modes=(1, 3))).endswith("\n  2 axial: 200, 400 Hz")
    assert (
        repr(replace(modes, axial_modes=()))
        == "ModalResult at 7 mm compression, 8 modes, completed"
    )
    assert replace(modes, axial_modes=(1, 3)).to_pandas().shape[0] == 8
    for wrong in (
        {"axial_modes": (8,)},
        {"axial_modes": (-1,)},
        {"axial_transmission": np.ones(7)},
        {"shape": np.zeros((7, 0, 3))},
    ):
        with pytest.raises(InputError, match="modal result must"):
            replace(modes, **wrong)


def test_modes_of_a_train_tell_what_moves():
    share = np.array([[0.62, 0.2, 0.18], [0.1, 0.1, 0.1]])
    modes = TrainModes(
        "stock",
        "open",
        1.5,
        9e-3,
        np.array([500.0, 900.0]),
        ("valve",),
        ("valve", "spring", "rod"),
        np.ones((2, 1)),
        share,
    )
    assert (
        modes.moving(0, 0.19) == "valve 62 %, spring 20 %"
        and modes.moving(0) == "valve 62 %, spring 20 %, rod 18 %"
    )
    assert modes.moving(1) == "valve 10 %"
    assert repr(modes) == "TrainModes of stock, open, 9 mm of lift\n  500, 900 Hz"
    many = replace(
        modes,
        natural_frequency=np.arange(1.0, 8),
        shape=np.ones((7, 1)),
        energy_share=np.ones((7, 3)) / 3,
    )
    assert repr(many).endswith("  1, 2, 3, 4, 5, 6, ... Hz")
    assert list(modes.to_pandas().columns) == [
        "natural_frequency",
        "valve",
        "spring",
        "rod",
    ] and list(modes.to_pandas().index) == [1, 2]
    with pytest.raises(
        InputError,
        match=r"energy_share of the modes of a train must have shape \(2, 3\); it has \(2, 2\)",
    ):
        replace(modes, energy_share=np.ones((2, 2)))


def bracket(low: float, high: float) -> SpeedBracket:
    return SpeedBracket(low * RPM, high * RPM)


def test_critical_speeds_in_words_and_as_a_frame():
    begins = Crossing(bracket(7000, 7010), bracket(7100, 7110), bracket(6800, 6810))
    lost = CriticalSpeed(
        "stock", "contact-loss", 0.0, 1000 * RPM, 9000 * RPM, 10 * RPM, True, "cam", begins
    )
    early = CriticalSpeed("stock", "bounce", 1e-4, 1000 * RPM, 9000 * RPM, 10 * RPM, True, "seat")
    never = CriticalSpeed("other", "float", 5e-5, 1000 * RPM, 9000 * RPM, 10 * RPM)
    assert (
        lost.text == "7000–7010, at the cam"
        and early.text == "below 1000"
        and never.text == "none up to 9000"
    )
    assert lost.engine_speed == pytest.approx(7010 * RPM) and early.engine_speed == pytest.approx(
        1000 * RPM
    )
    assert math.isnan(never.engine_speed) and str(bracket(5000, 5000)) == "5000"
    assert (
        begins.hysteresis == pytest.approx(290 * RPM)
        and Crossing(bracket(1, 2), bracket(1, 2), bracket(2, 3)).hysteresis == 0.0
    )
    assert math.isnan(replace(begins, rising=None).hysteresis) and math.isnan(
        replace(begins, falling=None).hysteresis
    )
    found = CriticalSpeeds((lost, early, never))
    assert (
        found.of("bounce") is early
        and found.of("float", "stock") is None
        and found.of("float", "other") is never
    )
    assert found.quantities("stock") == {
        "contact_loss_engine_speed": lost.engine_speed,
        "bounce_engine_speed": early.engine_speed,
    }
    assert (
        found.quantities("other") == {} and found.labels == ("stock", "other") and len(found) == 3
    )
    told = found.to_pandas()
    assert told["from_rest_lower_engine_speed"][0] == pytest.approx(7000 * RPM)
    assert told["falling_upper_engine_speed"][0] == pytest.approx(6810 * RPM) and np.isnan(
        told["rising_lower_engine_speed"][1]
    )
    assert "ritical engine speeds (rpm)\n  stock, contact-loss: 7000–7010, at the cam" in repr(
        found
    )


def test_a_gap_says_why():
    def fails(error: Exception) -> None:
        raise error

    gaps = PartialFailures()
    for error in (
        MemoryError(),
        OSError(28, "No space left"),
        OSError("odd"),
        ValueError("no root"),
        InputError("too wide"),
    ):
        assert gaps.part("this", "instead", fails, error) == "instead"
    told = gaps.sentences
    assert (
        len(told) == 5
        and all("this" in one for one in told)
        and "memory" in told[0]
        and "No space left" in told[1]
    )
    assert (
        "no root" in told[3]
        and "too wide" in told[4]
        and gaps.part("that", 0, lambda: 7) == 7
        and len(gaps.sentences) == 5
    )


@pytest.mark.parametrize(
    "study",
    [
        made.own_study(),
        made.published_study(),
        made.train_study(),
        made.sweep_study(3),
        Study(made.record()),
        replace(made.own_study(), solutions=(), still={}),
    ],
    ids=["own", "published", "train", "sweep", "nothing", "rest"],
)
def test_every_table_that_is_written_holds_a_row(study, tmp_path):
    """An empty table would be a file that says nothing; where there is something to tell, its file
    is there.
    """
    written = write_study(study, tmp_path, page=False)
    names = {path.stem for path in written.data if path.suffix == ".csv"}
    for path in written.data:
        if path.suffix == ".csv":
            rows = [
                line
                for line in path.read_text(encoding="utf-8").splitlines()
                if not line.startswith("#")
            ]
            assert len(rows) > 1, path.name
    assert ("quantities" in names) == bool(len(study.quantities)) and (
        "comparison" in names
    ) == bool(study.comparisons)
    assert ("events" in names) == any(run.events for run in study.solutions) and not written.gaps


def test_springs_of_a_pair_are_joined_in_the_order_of_time():
    first, second = (
        replace(made.rod_run(), events=tuple(made.clash(n) for n in order))
        for order in ((1, 3), (2, 4))
    )
    whole = joined((first, second), ("outer", "inner"), first.provenance)
    assert [event.where.split()[0] for event in whole.events] == [
        "outer",
        "inner",
        "outer",
        "inner",
    ]
    assert np.all(np.diff([event.time for event in whole.events]) > 0)
    assert whole.channel("seat_force") == pytest.approx(2 * first.channel("seat_force"))
    assert whole.channel("outer_seat_force") == pytest.approx(
        first.channel("seat_force")
    ) and whole.has("valve_lift")
    assert not whole.has("outer_valve_lift") and whole.status.completed
    late = replace(second, status=Status("diverged", "too fast", 0.1))
    assert joined((first, late), ("outer", "inner"), first.provenance).status is late.status
    half = made.rod_run(samples=360)
    with pytest.raises(InputError, match="sampled at different times"):
        joined((first, half), ("outer", "inner"), first.provenance)


def test_section_loads_are_of_the_free_wire_and_nothing_beyond():
    rod = FiniteElementRod(cylindrical("4 mm", "24 mm", "7.5 mm", 7), 8e-3, 12)
    result = compress(rod.statics, [8e-3])[-1]
    found = _strains(rod.mesh, result.state.position[None], result.state.frame[None])
    mesh, force = rod.mesh, result.retainer_force
    shear, normal = found["shear_force"][0], found["normal_force"][0]
    assert (
        np.all(shear[: mesh.first] == 0)
        and np.all(shear[mesh.last + 1 :] == 0)
        and np.all(normal[mesh.last + 1 :] == 0)
    )
    middle = slice(mesh.first + 24, mesh.last - 24)
    whole = np.hypot(shear, normal)
    # an axial load on a helix: the section force is the load all along, nearly all of it shear (cos
    # of the pitch angle)
    assert whole[middle] == pytest.approx(np.full(len(whole[middle]), force), rel=0.02)
    assert np.max(np.abs(normal[middle])) < 0.2 * force < np.min(shear[middle])
    for end, inner in ((mesh.first, mesh.first + 1), (mesh.last, mesh.last - 1)):
        assert (
            0.3 * force < whole[end] < 1.7 * force and abs(whole[end] - whole[inner]) < 0.25 * force
        )


def test_notes_of_a_measured_lift_speak_where_there_is_something_to_say():
    def notes(**change: object) -> tuple[str, ...]:
        quiet = {
            "noise": 2e-6,
            "base": 0.0,
            "runout": 0.0,
            "residuals": np.zeros(5),
            "cam_angles": np.radians(np.arange(5.0)),
            "widened": False,
        }
        return lift_notes(SimpleNamespace(smoothed=SimpleNamespace(**quiet | change)))

    said = "the noise of a station is 2 µm (standard deviation)"
    assert notes() == (said,) == notes(residuals=np.array([0.0, 7.9e-6, -7.9e-6, 0.0, 0.0]))
    assert notes(residuals=np.array([0.0, 9e-6, -11e-6, 0.0, 0.0]))[1:] == (
        "2 stations are more than four standard deviations off the law, the worst at 2 cam deg by -11 µm; look at them",
    )
    assert notes(runout=1e-6)[1:] == (
        "the base circle was at 0 µm, scattering by 1 µm, and was set to zero",
    )
    assert notes(base=3e-6)[1:] == (
        "the base circle was at 3 µm, scattering by 0 µm, and was set to zero",
    )
    assert "tighter than the noise" in notes(widened=True)[1] and len(notes(widened=True)) == 2


def test_the_count_of_clashes_is_that_of_the_numbers_or_of_the_events():
    run = replace(
        made.rod_run(), events=(made.clash(1), made.clash(2), replace(made.clash(3), kind="rest"))
    )
    for quantities, count in (
        ({}, 2),
        ({"modes_count": 3.0}, 2),
        ({"clash_count": 9.0, "modes_count": 3.0}, 9),
    ):
        found = study_json(made.own_study((replace(run, quantities=quantities),)))["runs"][0][
            "clash_count"
        ]
        assert found == {"value": count, "unit": "1"}, quantities
