"""Published studies as data: the files that ship are whole, and claims and numbers of labelled runs follow
from runs whose numbers are known.
"""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from synthetic_spring import ENGINE_SPEED, run
from synthetic_train import ANGLE, CAM_SPEED, found, lift_of, train
from valvetrain import registry
from valvetrain.errors import InputError
from valvetrain.quantities.cycle import Frame
from valvetrain.solution.definition import is_defined
from valvetrain.solution.provenance import CaseRecord, PublishedValue
from valvetrain.solution.quantity import Quantity
from valvetrain.solution.result import Solution
from valvetrain.solution.study import Study
from valvetrain.sources.contract import (
    MULTIBODY4B17,
    VASILYEV2016,
    Claim,
    SourceStudy,
    Term,
    against_source,
    read_source,
)
from valvetrain.sources.reader import MORE_KINDS
from valvetrain.sources.readings import KINDS
from valvetrain.sources.rows import angle_of

SPEED = 2 * CAM_SPEED
CHANNELS = ("coil_contact_force",)


def spring_run(model: str = "finite-element", **quantities: float) -> Solution:
    made = run({"seat_force": lambda degrees: 300 + 0 * degrees}, model=model)
    return made.with_found((), quantities)


@pytest.mark.parametrize("key", ["gu2021", "vasilyev2016", "multibody4b17"])
def test_a_file_that_ships_names_kinds_and_quantities_that_exist(key):
    source = registry.find("sources", key)
    assert isinstance(source, SourceStudy) and source.key == key and source.description
    names = {term.quantity for one in source.claims for term in (one.left, one.right)}
    names -= {term.quantity for one in source.claims for term in (one.left,) if term.beside} | {""}
    for reading in source.readings:
        assert reading.kind in (
            {"run", "rise", "difference"} if reading.runs else {*KINDS, *MORE_KINDS}
        )
        assert reading.point in ("", *source.points)
        names |= {one.replace("{n}", "1") for one in (*reading.names, *reading.of)} - {*CHANNELS}
        if reading.with_angle and reading.kind != "rebound":
            names |= {angle_of(one) for one in reading.names if not one.endswith("_angle")}
    assert not [name for name in names if not is_defined(name)]
    assert source.quantities(spring_run(), Frame()) is not None


@pytest.mark.parametrize(
    "text",
    [
        "[[readings]]\nkind = 'extreme'",
        "[[readings]]\nkind = 'highest'\nnames = ['preload']",
        "[[readings]]\nkind = 'end'\nnames = ['preload']\ncolour = 3",
        "[sampling]\nspacing = '3 mm'\nphases = 2",
    ],
)
def test_a_file_that_is_not_whole_is_refused(tmp_path, text):
    path = tmp_path / "own1999.source"
    path.write_text(text)
    with pytest.raises(InputError):
        read_source(path)


FORCE = "peak_spring_force"
OURS, THEIRS = Term("finite-element", FORCE), Term("modal-varied", FORCE)


@pytest.mark.parametrize(
    ("left", "claim", "verdict"),
    [
        (500.0, Claim("1", "more", OURS, THEIRS), "agrees"),
        (300.0, Claim("1", "more", OURS, THEIRS), "not seen"),
        (500.0, Claim("1", "more", OURS, replace(THEIRS, times=2.0)), "not seen"),
        (410.0, Claim("1", "as much", OURS, THEIRS, "equal", 0.03), "agrees"),
        (410.0, Claim("1", "as much", OURS, THEIRS, "equal", 0.02), "not seen"),
        (410.0, Claim("1", "about 400", OURS, Term(value=400.0), "equal", 0.03), "agrees"),
        (math.nan, Claim("1", "more", OURS, THEIRS), "not seen"),
        (500.0, Claim("1", "more", OURS, Term("solid", FORCE)), None),
        (500.0, Claim("1", "more", OURS, THEIRS, engine_speed="11200 rpm"), None),
    ],
)
def test_a_claim_is_borne_out_or_not_or_cannot_be_compared(left, claim, verdict):
    ours = {"preload": 300.0} | ({} if math.isnan(left) else {FORCE: left})
    runs = (spring_run(**ours), spring_run("modal-varied", **{FORCE: 400.0}))
    item = claim.finding(Study(CaseRecord("own"), solutions=runs))
    assert (item and item.verdict) == verdict


def gear_run(label: str, early: float, late: float, samples: int = 1440) -> Solution:
    """A run whose force on the valve is ``early`` N off before the nose and ``late`` N after it."""
    force = 300 + np.where(ANGLE <= np.pi, early, late) * (lift_of(ANGLE) > 0)
    made = found(train(label=label, valve_tip_contact_force=force))
    return replace(made, channels=made.channels.isel(sample=slice(None, None, 1440 // samples)))


@pytest.mark.parametrize("samples", [1440, 720])
@pytest.mark.parametrize(
    ("masses", "single", "expected"),
    [
        ((1, 5), (20, 20), ["agrees", "agrees"]),
        ((5, 1), (20, 20), ["not seen", "agrees"]),
        ((1, 5), (5, 5), ["agrees", "not seen"]),
    ],
)
def test_models_differ_by_the_root_mean_square_of_their_forces(masses, single, expected, samples):
    runs = (
        gear_run("rod, lash 0 mm", 0, 0),
        gear_run("six masses, lash 0 mm", *masses, samples),
        gear_run("single mass, lash 0 mm", *single, samples),
    )
    study = Study(CaseRecord("gear", study="vasilyev2016"), solutions=runs)
    told = [claim.finding(study) for claim in VASILYEV2016.claims]
    assert [item.verdict for item in told if item] == expected
    far = VASILYEV2016.claims[0].left.number(study, None)
    assert far == pytest.approx(masses[1], rel=0.02)
    reduced = replace(study, solutions=tuple(one.reduced() for one in runs))
    assert {item.verdict for item in against_source(reduced).findings} <= {"not seen"}


def test_a_changed_case_is_compared_with_no_published_number():
    printed = PublishedValue(
        "stage_2_peak_force", 818.0, "N", engine_speed=ENGINE_SPEED, model="solid finite elements"
    )
    record = CaseRecord("beehive", study="gu2021", published=(printed,))
    study = Study(record, solutions=(spring_run(stage_2_peak_force=850.0),))
    assert [row.computed for row in against_source(study).comparisons] == [850.0]
    changed = replace(study, record=replace(record, changed=("spring.wire_diameter",)))
    own = replace(study, record=CaseRecord("own"))
    assert against_source(changed) is changed and against_source(own) is own


def nose(label: str, force: float, engine_speed: float = SPEED) -> Solution:
    made = train(label=label)
    where = replace(made.provenance, label=label, engine_speed=engine_speed)
    return replace(made, provenance=where, quantities={"nose_cam_contact_force": force})


def pushrod(*runs: Solution) -> Study:
    names = {
        "contact_force_rise_ratio": 0.4,
        "stock_nose_cam_contact_force": 283.0,
        "stock_peak_valve_lift": 8e-3,
    }
    values = tuple(
        PublishedValue(name, value, "N", engine_speed=SPEED, model="as printed")
        for name, value in names.items()
    )
    return Study(CaseRecord("pushrod", study="multibody4b17", published=values), solutions=runs)


def test_published_values_meet_the_runs_that_their_readings_name():
    runs = nose("stock, as printed", 270.0), nose("performance, as printed", 405.0)
    study = pushrod(*runs, nose("stock", 574.0))
    rows = against_source(study).comparisons
    assert [row.computed for row in rows] == [pytest.approx(0.5), 270.0, None]
    numbers = MULTIBODY4B17.of_runs(study)
    assert numbers[Quantity("contact_force_rise_ratio", SPEED)] == pytest.approx(0.5)


def test_published_values_wait_for_their_engine_speed():
    labels = ("stock, as printed", "performance, as printed")
    study = pushrod(*(nose(label, 300.0, 2 * SPEED) for label in labels))
    assert [row.computed for row in against_source(study).comparisons] == [None] * 3
