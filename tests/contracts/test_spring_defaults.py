"""What a spring model takes for granted where a caller leaves it out, and that no two numbers of a
rod's state share a place.
"""

from __future__ import annotations

import numpy as np
import pytest

from spring_parts import MODELS, drive, raised_cosine


@pytest.mark.parametrize("name", MODELS)
def test_without_a_word_the_retainer_rests_and_no_step_is_taken(name):
    model = MODELS[name]
    time_step = min(1e-5, 0.8 * model.stable_time_step())
    displacement, velocity = raised_cosine(3e-3, 2e-3, time_step)
    state = model.initial_state(0.0)
    drive(model, state, displacement[:60], velocity[:60], time_step)
    where = float(displacement[60])
    assert model.force(state, where) == model.force(state, where, 0.0)
    assert model.energy(state, where) == model.energy(state, where, 0.0, 0.0)
    told, rest = model.outputs(state, where), model.outputs(state, where, 0.0)
    assert told.retainer_force == rest.retainer_force and told.seat_force == rest.seat_force
    assert np.array_equal(told.axial_velocity, rest.axial_velocity)
