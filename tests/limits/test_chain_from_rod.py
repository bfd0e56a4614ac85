"""Limits: a chain of masses of a wire against the finite elements of that wire (other model), on a
spring that no library has; a contract of what is left as it was.
"""

from __future__ import annotations

import numpy as np
import pytest

import valvetrain as vt
from fact_parts import with_code
from valvetrain.errors import InputError
from valvetrain.explore.evaluate import PointRequest, evaluate
from valvetrain.explore.outputs import Run
from valvetrain.springs import chain_from_rod
from valvetrain.springs.finite_element import equilibrium_at
from valvetrain.springs.multi_mass import MultiMassSpring
from valvetrain.springs.spec import spring_model

OWN = {
    "wire_diameter": "4.3 mm", "outer_diameter": "33 mm", "total_coils": 6.8,
    "pitch": {"formula": "closed-ends", "pitch": "11.5 mm", "ramp": 0.25},
    "ends": {"kind": "closed-ground", "inactive_coils": 0.9, "ground_coils": 0.9},
    "material": "OTEVA 90 SC", "installed_height": "46 mm",
}  # fmt: skip
CHAIN = spring_model("multi-mass")


def spring(**options):
    return vt.Spring(**OWN, options={"multi-mass": options}).parameters


def test_a_chain_has_the_force_and_the_first_frequency_of_its_rod():
    """Limit: at 0.3 of the travel to solid, and next to it within a percent at rest."""
    own = spring()
    chain = CHAIN.build(own)
    rod = spring_model("finite-element").build(own)
    lift = 0.3 * own.room
    middle = equilibrium_at(rod, own.precompression + lift)
    force = chain.force(chain.initial_state(lift), lift).retainer
    assert force == pytest.approx(middle.retainer_force, rel=4e-3)
    found = chain_from_rod.natural_modes(rod.statics, middle.state, 16)
    first = found.natural_frequency[found.axial_modes(1)[0]]
    assert chain.frequencies(lift, 1)[0] == pytest.approx(first, rel=4e-3)
    by_formula = CHAIN.build(spring(from_rod=False))
    assert by_formula.frequencies(lift, 1)[0] > 1.02 * first
    installed = chain.force(chain.initial_state(0.0), 0.0).retainer
    assert installed == pytest.approx(rod.installed.retainer_force, rel=1e-2)


def test_a_chain_by_formula_and_a_card_are_as_they_were():
    """Contract: bit for bit."""
    own = spring(from_rod=False, masses_per_coil=6)
    plain = MultiMassSpring.from_definition(
        own.wire, own.precompression, masses_per_coil=6, contact_stiffness=own.contact.stiffness
    )
    assert np.array_equal(CHAIN.build(own).layout.stiffness, plain.layout.stiffness)
    assert np.array_equal(CHAIN.build(own).layout.masses, plain.layout.masses)
    card = vt.Spring(preload="300 N", rate="40 N/mm", mass="60 g").parameters
    assert np.allclose(CHAIN.build(card).layout.stiffness, 5 * 40e3)


@pytest.mark.parametrize("error", [InputError, ValueError, RuntimeError, ZeroDivisionError])
@pytest.mark.parametrize("place", ["equilibrium_at", "natural_modes"])
def test_a_chain_whose_rod_cannot_be_had_runs_by_no_formula(monkeypatch, error, place):
    """Contract: whatever the rod failed of, the chain ran on by formula, with another peak force."""

    def fails(*given, **more):
        raise error("the rod refuses")

    chain_from_rod._reference.cache_clear()
    monkeypatch.setattr(chain_from_rod, place, fails)
    with pytest.raises(InputError, match="the rod refuses"):
        CHAIN.build(spring())
    assert CHAIN.build(spring(from_rod=False)).unknowns  # by formula on request
    case = vt.Case(spring=OWN, lift_law=vt.Case("job-t").tree["lift_law"], name="own")
    (run,) = case.compare("2000 rpm", ["multi-mass"]).solutions
    assert run.status.code == "refused" and "the rod refuses" in run.status.message
    assert "peak_spring_force" not in run.quantities
    request = PointRequest(("peak_spring_force",))
    point = evaluate(case.parameters, {}, Run(200.0, "multi-mass"), request)
    assert not point.status.completed
    chain_from_rod._reference.cache_clear()


@pytest.mark.parametrize(("name", "value"), [("MAX_COILS", 5), ("CREDIBLE", (0.0, 0.5))])
def test_a_chain_far_from_its_rod_is_refused_with_the_reason(monkeypatch, name, value):
    chain_from_rod._reference.cache_clear()
    monkeypatch.setattr(chain_from_rod, name, value)
    with pytest.raises(InputError, match="from_rod"):
        CHAIN.build(spring())
    chain_from_rod._reference.cache_clear()


def test_a_run_says_how_far_its_chain_is_from_the_rod():
    """Contract: the fact stands on the study and on its run."""
    damping = {"ratio": 0.016, "ratio_frequency": "500 Hz"}
    lift = vt.Case("job-t").tree["lift_law"]
    case = vt.Case(spring={**OWN, "damping": damping}, lift_law=lift, name="own")
    study = case.compare("2000 rpm", ["multi-mass", "massless"])
    chain, massless = study.solutions
    (fact,) = with_code(chain.facts, "chain-of-wire")
    assert fact.fields["surge_frequency"] > 0 and fact.fields["force_error"] < 0.05
    assert not with_code(massless.facts, "chain-of-wire") and fact in study.facts
