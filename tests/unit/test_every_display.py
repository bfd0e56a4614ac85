"""Results as numbers by name, run and speed, and as frames."""

from __future__ import annotations

import math
import re
from dataclasses import replace

import numpy as np
import pytest

import synthetic_study as made
from spring_shapes import cylindrical
from valvetrain.cosserat.static import compress
from valvetrain.errors import InputError
from valvetrain.integrate.run import joined
from valvetrain.solution.critical import CriticalSpeed, CriticalSpeeds, SpeedBracket
from valvetrain.solution.quantity import Quantities, Quantity
from valvetrain.solution.status import Status
from valvetrain.solution.study import Study
from valvetrain.springs.finite_element import FiniteElementRod
from valvetrain.springs.finite_element_channels import _strains
from valvetrain.views.results import write_study

RPM = math.pi / 30


def test_quantities_by_name_by_run_and_at_rest():
    speed = 5600 * RPM
    few = Quantities(
        {
            Quantity("preload"): 300.0,
            Quantity("peak_seat_force", speed, "rod"): 820.0,
            Quantity("preload", None, "x"): 1.0,
        }
    )
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
    told = many.to_pandas()
    assert list(told["value"]) == [801.0, 802, 803, 804, 805, 806] and told[
        "unit"
    ].unique().tolist() == ["N"]
    assert told["engine_speed"].iloc[1] == pytest.approx(2000) and set(told["label"]) == {"rod"}
    assert np.isnan(few.to_pandas()["engine_speed"].iloc[0])


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


def bracket(low: float, high: float) -> SpeedBracket:
    return SpeedBracket(low * RPM, high * RPM)


def test_critical_speeds_by_kind_and_as_a_frame():
    searched = 1000 * RPM, 9000 * RPM
    lost = CriticalSpeed(
        "stock", "contact-loss", 0.0, *searched, (bracket(7010, 9000),), ("cam",),
        falling_engine_speed=6810 * RPM,
    )  # fmt: skip
    early = CriticalSpeed("stock", "bounce", 1e-4, *searched, (bracket(0, 9000),), ("seat",))
    never = CriticalSpeed("other", "float", 5e-5, *searched)
    assert lost.engine_speed == pytest.approx(7010 * RPM) and early.engine_speed == pytest.approx(
        1000 * RPM
    )
    assert math.isnan(never.engine_speed) and str(bracket(5000, 5000)) == "5000"
    assert lost.both_motions == pytest.approx((6810 * RPM, 7010 * RPM))
    assert early.both_motions is None
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
    assert told.attrs["units"]["engine_speed"] == "rpm"
    assert told["engine_speed"][0] == pytest.approx(7010)
    assert told["falling_engine_speed"][0] == pytest.approx(6810)
    assert np.isnan(told["falling_engine_speed"][1])


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
