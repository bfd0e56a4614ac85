"""The model of a train that names none: the reduced rod of wires, the chain with a sentence where
the rod cannot be reduced.

Evidence: contract of the case files; by name the same is refused with the same reason.
"""

from __future__ import annotations

from collections import OrderedDict

import pytest

import valvetrain as vt
from fact_parts import with_code
from spring_shapes import cylindrical
from valvetrain.errors import InputError
from valvetrain.explore.evaluate import PointRequest, evaluate
from valvetrain.explore.outputs import Run
from valvetrain.findings.table import findings_of
from valvetrain.parameters.loading import parse_case
from valvetrain.parameters.templates import template_text
from valvetrain.springs import reduced_rod_cache
from valvetrain.springs.reduced_rod import ReducedRod
from valvetrain.system.build import build

TRAIN = template_text("direct")
HEIGHT = 'installed_height = "36 mm"'
INNER = (
    '[[train.springs.stock]]\nname = "inner"\nwire_diameter = "2.6 mm"\nmean_diameter = "14.5 mm"\ntotal_coils = 8.5\n'
    'pitch = { formula = "closed-ends", pitch = "5.6 mm" }\nmaterial = "OTEVA 90 SC"\ninstalled_height = "34 mm"\n'
)
RUBBING = TRAIN.replace(
    "[train]\n", '[train]\nrubbing = { coefficient = 0.1, normal_force = "30 N" }\n'
)
CARD = (
    '[[train.springs.stock]]\nname = "inner"\npreload = "100 N"\nrate = "12 N/mm"\nmass = "20 g"\n'
)


def test_wires_run_by_their_reduced_rod_and_cards_by_modes():
    case = parse_case(TRAIN, "case")
    assert case.train.why_no_rod() == ""
    labels = [
        build(case, spring_set=chosen).members[0].model.word for chosen in ("", "stock", "stiff")
    ]
    assert labels == ["reduced-rod", "reduced-rod", "modal-uniform"]
    named = case.replace(train=case.train.replace(spring_model="wave-rod"))
    assert build(named).members[0].model.word == "wave-rod"


@pytest.mark.parametrize(
    ("text", "reason", "model"),
    [
        (TRAIN.replace(HEIGHT, f'{HEIGHT}\nend_contact = "lifting"'), "the ends of spring 'spring' lift", "multi-mass"),
        (TRAIN.replace("# Another set", f"{CARD}\n# Another set"), "spring 'inner' is known by its card only", "modal-uniform"),
        (RUBBING.replace("# Another set", f"{INNER}\n# Another set"), "springs 'outer' and 'inner' rub on one another", "multi-mass"),
    ],
    ids=["lifting", "a card beside the wire", "rubbing"],
)  # fmt: skip
def test_a_set_that_no_reduced_rod_knows_runs_by_another_model_and_says_why(text, reason, model):
    study = vt.simulate(parse_case(text, "case"), "2000 rpm", workers=1)
    assert [run.label for run in study.solutions] == [model]
    (fact,) = with_code(study.facts, "not-the-default")
    assert fact.fields == {"model": model, "reason": reason}
    (found,) = findings_of(study).by("A118")
    assert found.fields["model"] == model


def test_a_wire_whose_tables_cannot_be_made_runs_by_the_chain_and_by_name_is_refused(monkeypatch):
    def without(_: ReducedRod) -> None:
        raise InputError("the rod has too few equilibria; compress the spring less")

    monkeypatch.setattr(ReducedRod, "_made", without)
    monkeypatch.setattr(reduced_rod_cache, "_MADE", OrderedDict())
    monkeypatch.setattr(reduced_rod_cache, "_folder", lambda: None)
    case = parse_case(TRAIN, "case")
    study = vt.simulate(case, "2000 rpm", workers=1)
    (run,) = study.solutions
    assert (run.label, run.model, run.status.code) == ("multi-mass", "multi-mass", "completed")
    (fact,) = with_code(study.facts, "not-the-default")
    assert fact.fields["reason"] == "the rod has too few equilibria"
    (chain,) = with_code(study.facts, "chain-of-wire")
    assert chain.fields["better"] == "finite-element"
    (run,) = vt.simulate(case, "2000 rpm", models="reduced-rod", workers=1).solutions
    assert run.status.code == "refused" and "too few equilibria" in run.status.message
    # A table of points has no facts: a point is by the model of its neighbours or is none.
    request = PointRequest(("peak_spring_force",))
    outcome = evaluate(case, {}, Run(200.0), request)
    assert outcome.status.code == "refused" and "too few equilibria" in outcome.status.message
    assert not outcome.values


def test_a_lift_that_the_equilibria_do_not_reach_is_no_table(monkeypatch):
    """Beyond its tables a reduced rod would go on along their last slope."""
    from valvetrain.springs import reduced_rod

    whole = reduced_rod.path_of_equilibria

    def half(*given):
        path = whole(*given)
        return path[: len(path) // 2]

    monkeypatch.setattr(reduced_rod, "path_of_equilibria", half)
    monkeypatch.setattr(reduced_rod_cache, "_MADE", OrderedDict())
    monkeypatch.setattr(reduced_rod_cache, "_folder", lambda: None)
    wire = cylindrical("4 mm", "24 mm", total_coils=5, free_length="40 mm")
    rod = vt.springs.FiniteElementRod(wire, "7 mm", elements_per_coil=12)
    with pytest.raises(InputError, match=r"no equilibria beyond .* mm of lift"):
        ReducedRod(rod, 6e-3).make_tables()
    with pytest.raises(InputError, match=r"no equilibria beyond .* mm of lift"):
        ReducedRod(rod, 6e-3).refuse_unreached()


def test_check_refuses_what_tables_would_refuse_and_makes_none(monkeypatch):
    """Known answer: the refusal is that of the rod, and no rod is reduced for a file that is only read."""
    from valvetrain.cli.cases import put_together
    from valvetrain.springs import reduced_rod

    def made(*given):
        raise AssertionError("a rod was reduced")

    monkeypatch.setattr(reduced_rod, "reduce_rod", made)
    monkeypatch.setattr(reduced_rod_cache, "_MADE", OrderedDict())
    monkeypatch.setattr(reduced_rod_cache, "_folder", lambda: None)
    case = parse_case(TRAIN, "case")
    assert put_together(case, ()) is not None
    monkeypatch.setattr(reduced_rod, "path_of_equilibria", lambda statics, at, *given: [at])
    assert put_together(case, ()) is not None  # it runs by the chain of masses
    with pytest.raises(InputError, match="no equilibria beyond"):
        put_together(case, ("reduced-rod",))
