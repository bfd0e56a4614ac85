"""Unit: limit speeds as outputs of a study: those of a sweep, their cost, what is refused before the
first point.
"""

from __future__ import annotations

import numpy as np
import pytest

import valvetrain as vt
from train_parts import SINGLE_MASS
from valvetrain.explore.engine import Engine
from valvetrain.explore.files import FileText
from valvetrain.explore.study import StudyModel, estimate_study, read_plan
from valvetrain.explore.study_answer import StudyAnswer

RPM = np.pi / 30
PRELOAD = 'vary = [{ key = "train.springs.card.0.preload", values = "250, 300 N" }]\n'
LIMIT = '[[limit_speed]]\nkind = "{}"\nengine_speeds = "{}"\n'


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    place = tmp_path_factory.mktemp("limits")
    (place / "train.toml").write_text(SINGLE_MASS)
    return place


def study(folder, text: str, case: str = "train.toml") -> vt.explore.StudyTable:
    (folder / "study.toml").write_text(f'case = "{case}"\n{text}')
    return vt.study(folder / "study.toml", workers=1)


@pytest.mark.slow
def test_a_limit_speed_is_that_of_a_sweep_at_every_point(folder):
    """Other path: the search for critical speeds between the speeds of a sweep."""
    speeds = "4500:9000:1500 rpm"
    text = PRELOAD + LIMIT.format("contact-loss", speeds) + LIMIT.format("float", speeds)
    table = study(folder, f'outputs = "minimum_spring_margin_ratio"\n{text}')
    assert table.outputs[1:] == ("contact_loss_engine_speed", "float_engine_speed")
    for row, preload in enumerate(("250 N", "300 N")):
        case = vt.Case(str(folder / "train.toml")).set({"train.springs.card.0.preload": preload})
        found = {one.kind: one for one in case.critical_speeds(speeds, ranges=False)}
        for column, kind in ((1, "contact-loss"), (2, "float")):
            nominal = found[kind].engine_speed
            assert table.values[row, column] == pytest.approx(nominal, abs=11 * RPM)
    assert np.all(np.diff(table.values, axis=0) > 0), "more preload keeps control longer"
    assert table.to_pandas().attrs["units"]["contact_loss_engine_speed"] == "rad/s"
    assert StudyAnswer(table).verdict.quantity == "contact_loss_engine_speed"
    assert "--rpm 4500:9000:1500" in StudyAnswer(table).next_step
    dataset = table.to_xarray()
    assert dataset.float_engine_speed.dims == ("point", "model")


def test_points_beyond_the_speeds_searched_are_counted(folder):
    table = study(folder, PRELOAD + LIMIT.format("float", "3000, 4000 rpm"))
    assert table.completed.all() and table.values.ravel() == pytest.approx([4000 * RPM] * 2)
    (one,) = StudyAnswer(table).findings.by("J133")
    assert one.value == pytest.approx(4000 * RPM) and one.fields["side"] == "above"
    assert one.fields["share"] == "2 of 2 points"
    lost = study(folder, PRELOAD + LIMIT.format("contact-loss", "9000, 9500 rpm"))
    assert lost.values.ravel() == pytest.approx([9000 * RPM] * 2)
    (one,) = StudyAnswer(lost).findings.by("J133")
    assert one.fields["side"] == "below" and one.value == pytest.approx(9000 * RPM)


SPRING = 'case = "gu2021-beehive-blind"\nvary = [{ key = "spring.wire_diameter", values = "3.7, 3.8 mm" }]\n'
REFUSED = {
    "float of a spring alone": (SPRING + LIMIT.format("float", "5000, 6000 rpm"), "a spring has no lift above the rigid lift"),
    "a name of a sweep": (SPRING + 'outputs = "float_engine_speed"', "request a limit_speed with kind = 'float'"),
    "a number at rest": (
        SPRING + '[[limit_speed]]\nquantity = "preload"\nat_most = "3 N"\nengine_speeds = "5000, 6000 rpm"\n', "springs at rest"),
    "an unknown kind": (SPRING + LIMIT.format("flaot", "5000, 6000 rpm"), "no kind of limit speed; use one of contact-loss"),
    "a kind with a bound": (SPRING + LIMIT.format("clash", "5000, 6000 rpm") + 'at_most = "3 N"\n', "leave those out"),
    "no speeds": (SPRING + '[[limit_speed]]\nkind = "clash"\n', "engine_speeds"),
    "a varied speed": (
        'case = "gu2021-beehive-blind"\nvary = [{ key = "engine_speed", values = "5000, 6000 rpm" }]\n' + LIMIT.format("clash", "5000, 6000 rpm"),
        "the engine speed is varied"),
    "a share of the case": (
        SPRING + '[[limit_speed]]\nquantity = "clash_energy"\nat_most = "2 x case"\nengine_speeds = "5000, 6000 rpm"\n', "belongs to a search"),
}  # fmt: skip


@pytest.mark.parametrize("name", REFUSED)
def test_what_cannot_be_had_is_refused_before_anything_is_computed(name, folder, monkeypatch):
    monkeypatch.setattr(Engine, "outcomes", None)
    monkeypatch.setattr(Engine, "compute", None)
    text, words = REFUSED[name]
    with pytest.raises(vt.InputError, match=words):
        vt.study(text + "\n", workers=1)


def test_a_model_that_lacks_the_quantity_is_refused_before_the_first_point(folder, monkeypatch):
    """The middle of the space is run once by each model; the points are not."""
    own, computed = Engine.compute, []

    def compute(engine: Engine, jobs) -> None:
        computed.extend(jobs := list(jobs))
        own(engine, jobs)

    monkeypatch.setattr(Engine, "compute", compute)
    text = f'spring_models = "massless"\noutputs = "minimum_spring_margin_ratio"\n{PRELOAD}'
    with pytest.raises(vt.InputError, match=r"limit_speed: the coil contacts .*by card alone"):
        study(folder, text + LIMIT.format("clash", "5000, 6000 rpm"))
    assert not computed
    pair = '[[limit_speed]]\nquantity = "outer_peak_spring_force"\nat_most = "1 kN"\nengine_speeds = "5000, 6000 rpm"\n'
    with pytest.raises(vt.InputError, match=r"outer .*by massless"):
        study(folder, text + pair)
    assert len(computed) == 1


def test_the_cost_of_limit_speeds_is_estimated_before(folder):
    text = f'case = "train.toml"\noutputs = "minimum_spring_margin_ratio"\n{PRELOAD}'

    def plan(more: str):
        return read_plan(FileText(text + more, "study", folder, StudyModel))

    plans = plan(""), plan(LIMIT.format("float", "5000:9000:1000 rpm"))
    assert [len(one.experiment.tasks) for one in plans] == [1, 2]
    alone, both = (estimate_study(one, 1) for one in plans)
    assert both.seconds > 10 * alone.seconds
