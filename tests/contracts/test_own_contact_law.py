"""A contact law with a compiled kernel of its own stands in the loop like the built-in ones, memory
included.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any, ClassVar

import numpy as np
import pytest
from numba import njit

from train_parts import KINDS, system
from valvetrain.contact.dissipative import Flores
from valvetrain.contact.elastic import LinearContact
from valvetrain.contact.kernels import OWN_LAW
from valvetrain.contact.law import OwnLaw
from valvetrain.integrate.train_record import TrainOptions
from valvetrain.integrate.train_run import runner
from valvetrain.system.train_forces import law_force


@njit
def linear_kernel(
    parameters, memory, penetration, previous_penetration, penetration_rate, time_step
):
    if penetration <= 0.0:
        return 0.0, 0.0
    return parameters[0] * penetration, parameters[2]


@njit
def flores_kernel(
    parameters, memory, penetration, previous_penetration, penetration_rate, time_step
):
    if penetration <= 0.0:
        if time_step > 0.0:
            memory[0] = 0.0
        return 0.0, 0.0
    if time_step > 0.0:
        memory[0] = max(memory[0], abs(penetration_rate), parameters[5])
    restitution, elastic = parameters[3], parameters[0] * penetration * np.sqrt(penetration)
    return elastic, elastic * 1.6 * (1.0 - restitution) / (
        restitution * max(memory[0], parameters[5])
    )


@dataclass(frozen=True)
class Own:
    """What a user's package brings: here, a built-in law retold."""

    told: Any
    kernel: Any
    states: ClassVar[int] = 1
    code: ClassVar[int] = OWN_LAW

    # A protocol is met by what stands in the class; from Python 3.12 on __getattr__ no longer
    # counts.
    name = property(lambda self: self.told.name)
    parameters, force, tangent, dissipated_power, stiffness = (
        (lambda self, *given, _word=word: getattr(self.told, _word)(*given))
        for word in ("parameters", "force", "tangent", "dissipated_power", "stiffness")
    )


LAWS = {
    "linear": (LinearContact(3e7, 300.0), linear_kernel),
    "flores": (Flores(3.16e9, 0.6), flores_kernel),
}


def with_law(built, law, own=None):
    """The train with one law in all its contacts; ``own`` in the seat."""
    parts = [
        replace(part, law=(own or law) if part.name == "seat" else law)
        if part.law.code >= 0
        else part
        for part in built.mechanism.interactions
    ]
    return replace(built, mechanism=replace(built.mechanism, interactions=tuple(parts)))


@pytest.mark.parametrize("name", LAWS)
@pytest.mark.parametrize("kind", ["direct", "pushrod"])
def test_a_law_of_its_own_is_a_law_like_any_other(name, kind):
    law, kernel = LAWS[name]
    own = Own(law, kernel)
    assert isinstance(own, OwnLaw)
    records = []
    for chosen in (None, own):
        built = with_law(system(KINDS[kind](lash=1e-4)), law, chosen)
        ready = runner(built, 250.0, TrainOptions(samples=720))
        state = ready.initial_state()
        for _ in range(2):
            state, record = ready.cycle(state)
        records.append((record, law_force(built, built.mechanism.interaction_index("seat"), 1e-6)))
    (told, still), (found, own_still) = records
    assert own_still == pytest.approx(still, rel=1e-12)
    assert found.q == pytest.approx(told.q, rel=1e-6, abs=1e-10)
    assert found.peak_forces == pytest.approx(told.peak_forces, rel=1e-5)


def test_several_own_laws_keep_their_memories_apart():
    built = system(KINDS["pushrod"](lash=1e-4))
    kernels = [LAWS["linear"], LAWS["flores"]]
    parts, place = [], 0
    for part in built.mechanism.interactions:
        if part.law.code >= 0:
            part, place = replace(part, law=Own(*kernels[place % 2])), place + 1
        parts.append(part)
    mixed = replace(built, mechanism=replace(built.mechanism, interactions=tuple(parts)))
    assert len(mixed.law_kernels) == 2 and mixed.arrays.memory_of[-1] == place
    ready = runner(mixed, 250.0, TrainOptions(samples=720))
    end, record = ready.cycle(ready.initial_state())
    assert record.status.completed and np.max(record.q) > 4e-3
    own = [part.law.code == OWN_LAW and part.law.kernel is flores_kernel for part in parts]
    remembering = mixed.arrays.memory_of[:-1][own]
    others = np.delete(end.law_state, remembering)
    assert np.all(others == 0.0) and np.any(end.law_state[remembering] > 0.0)
