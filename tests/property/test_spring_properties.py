"""Any spring that can exist gets a chain with an equilibrium, a rising curve and a stable step."""

from __future__ import annotations

import numpy as np
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from spring_shapes import beehive, cylindrical
from valvetrain.errors import InputError
from valvetrain.parameters.curves import PiecewiseLinear
from valvetrain.springs.chain_statics import static_curve
from valvetrain.springs.equivalent import EquivalentSpring
from valvetrain.springs.multi_mass import MultiMassSpring


@st.composite
def springs(draw):
    wire = draw(st.floats(1e-3, 6e-3))
    index = draw(st.floats(3.5, 12.0))
    pitch = draw(st.floats(1.15, 4.0)) * wire
    turns = draw(st.floats(4.6, 11.0))
    try:
        if draw(st.booleans()):
            return cylindrical(wire, index * wire, pitch, turns)
        law = PiecewiseLinear(
            (0.0, 1.0, 2.0, turns - 1.0, turns), (wire, wire, pitch, pitch, 1.05 * wire)
        )
        return beehive(
            wire, index * wire, draw(st.floats(0.6, 1.0)) * index * wire, turns / 2, law, turns
        )
    except InputError:
        assume(False)


@settings(max_examples=60, deadline=None)
@given(
    spring=springs(),
    share=st.floats(0.05, 0.9),
    mesh=st.integers(1, 14),
    damping=st.floats(0, 5e-6),
)
def test_chain_of_any_spring(spring, share, mesh, damping):
    travel = spring.free_length - spring.solid_height
    assume(travel > 1e-3)
    model = MultiMassSpring.from_definition(
        spring, share * travel, masses_per_coil=mesh, stiffness_damping=damping
    )
    forces, rates = static_curve(model.layout, np.linspace(0.0, share * travel, 7))
    assert np.all(np.diff(forces) > 0) and np.all(rates > 0.999 * rates[0])
    state = model.initial_state(0.0)
    force = model.force(state, 0.0)
    assert abs(force.retainer - force.seat) < 1e-6 * force.retainer
    step = 0.98 * model.stable_time_step()
    rng = np.random.default_rng(0)
    state[: model.unknowns] += 1e-5 * travel * rng.standard_normal(model.unknowns)
    start = model.energy(state, 0.0).total
    for _ in range(400):
        model.kernel(model.parameters(), model.integers(), state, 0.0, 0.0, step)
    assert np.all(np.isfinite(state))
    # Near the limit the leapfrog's own energy swings, but it must not grow.
    assert (
        model.energy(state, 0.0).potential
        < start + 50 * (1e-5 * travel) ** 2 * np.max(model.layout.stiffness) * model.unknowns
    )


@settings(max_examples=40, deadline=None)
@given(spring=springs(), share=st.floats(0.05, 0.6))
def test_any_spring_reduces_to_an_equivalent_one(spring, share):
    travel = spring.free_length - spring.solid_height
    assume(travel > 1e-3)
    equivalent = EquivalentSpring.from_definition(spring, share * travel)
    chain = MultiMassSpring.from_definition(spring, share * travel, masses_per_coil=24)
    assert abs(equivalent.surge_frequency / chain.frequencies(0.0, 1)[0] - 1) < 1e-6
    assert 0 < equivalent.active_mass < 1.3 * spring.mass
    assert equivalent.inactive_mass < spring.mass
