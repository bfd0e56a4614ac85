"""Unit: when a blow of a contact is due, how long its force rises, and the step that resolves it,
beside closed forms.
"""

from __future__ import annotations

import math
from types import SimpleNamespace

import numpy as np
import pytest

from valvetrain.contact import kernels as laws
from valvetrain.integrate import train_impacts

PARTS, MAX_LENGTH, LEAST = 8, 4e-4, 1e-3  # parts of a rise, s, N
MASSES, GRADIENTS = np.array([0.1, 0.25, 0.04]), np.array([1.0, -0.6])
MOBILITY = 1.0 / 0.25 + 0.36 / 0.04  # 1/kg, of bodies 1 and 2


@pytest.fixture(autouse=True)
def plain_python(monkeypatch):
    """The kernels as they are written, not compiled."""
    for name in ("_force", "meets_damper", "_rise", "finest_step", "parts_of"):
        monkeypatch.setattr(train_impacts, name, getattr(train_impacts, name).py_func)


def train(stiffness: float, exponent: float = 1.0, damping: float = 0.0, kind: int = laws.POWER):
    """Two interactions; the second is the contact."""
    row = np.zeros((2, laws.WIDTH))
    row[1, [laws.STIFFNESS, laws.EXPONENT, laws.DAMPING]] = stiffness, exponent, damping
    places = np.array([[0, -1, -1, -1], [1, 2, -1, -1]])
    bodies = np.column_stack([MASSES, np.zeros((3, 4))])
    return SimpleNamespace(
        laws=np.array([-1, kind]),
        law_parameters=row,
        memory_of=np.zeros(3, dtype=int),
        coordinate_of=places,
        body=bodies,
    )


def at(pen: float, rate: float, before: float = -1e-6, blow: tuple[float, float] = (0.0, 0.0)):
    """Both interactions as the step finds them."""
    scratch = SimpleNamespace(
        gaps=np.array([[5e-6, 0.0, 0.0, 0.0], [pen, 0.0, 0.0, 0.0]]),
        rate=np.array([3.0, rate]),
        before=np.array([[0.0], [before]]),
        impacts=np.array([[7.0, 7.0, 0.0, 0.0], [*blow, 0.0, 0.0]]),
        gradients=np.zeros((2, 4)),
        trial=np.zeros(4),
    )
    scratch.gradients[1, :2] = GRADIENTS
    return scratch


def motion():
    clock = np.zeros(15)
    clock[3], clock[13] = MAX_LENGTH / PARTS, LEAST
    return SimpleNamespace(
        counters=np.array([0, 0, 0, 0, 0, PARTS]),
        clock=clock,
        law_state=np.zeros(4),
        law_addresses=np.zeros(1),
    )


@pytest.mark.parametrize(
    ("stiffness", "exponent"), [(3e6, 1.0), (4e7, 1.0), (2e10, 1.5), (5e9, 1.5), (6e8, 1.25)]
)
@pytest.mark.parametrize("rate", [0.05, 1.0, 8.0])
def test_a_force_rises_for_the_time_in_which_it_stops_the_bodies(stiffness, exponent, rate):
    """k (r tau)^e W tau = r; of a linear contact 1 / omega."""
    due = (rate / (stiffness * rate**exponent * MOBILITY)) ** (1 / (1 + exponent))
    if exponent == 1.0:
        assert due == pytest.approx(1 / math.sqrt(stiffness * MOBILITY))
    found = train_impacts._rise(
        1, train(stiffness, exponent), motion(), at(1e-7, rate), rate, MAX_LENGTH, 0.0
    )
    assert (
        found == pytest.approx(due, rel=2 ** (12 / 2**8) - 1) and due < MAX_LENGTH
    )  # 12 octaves, halved eight times


@pytest.mark.parametrize(
    ("stiffness", "rate", "least", "why"),
    [
        (1e3, 1.0, 0.0, "slower than the longest"),
        (4e7, 1.0, 1e9, "a force that nobody feels"),
        (4e7, 1e-9, 1.0, "hardly any rate"),
        (4e7, 0.0, 0.0, "no rate"),
    ],
)
def test_a_blow_that_needs_no_step_of_its_own_is_as_long_as_the_longest(
    stiffness, rate, least, why
):
    assert (
        train_impacts._rise(1, train(stiffness), motion(), at(1e-7, rate), rate, MAX_LENGTH, least)
        == MAX_LENGTH
    ), why


def test_bodies_that_nothing_moves_meet_no_blow():
    held = train(4e7)
    held.coordinate_of[1] = -1
    assert train_impacts._rise(1, held, motion(), at(1e-7, 1.0), 1.0, MAX_LENGTH, 0.0) == MAX_LENGTH


TAU = 1 / math.sqrt(4e7 * MOBILITY)


@pytest.mark.parametrize(
    ("pen", "rate", "before", "blow", "step", "lasts"),
    [
        (-2e-6, 1.0, -3e-6, (0.0, 0.0), "new", "new"),  # due within the step
        (
            -6.2e-6,
            1.0,
            -9e-6,
            (0.0, 0.0),
            "new",
            "new",
        ),  # the gap may close faster than its rate tells
        (-6.3e-6, 1.0, -9e-6, (0.0, 0.0), 0.0, -1e-6),  # due later
        (-2e-6, -1.0, -1e-6, (3e-6, 5e-6), 0.0, 4e-6),  # opens
        (1e-7, 1.0, -1e-7, (0.0, 0.0), "new", "new"),  # closed in this step, seen late
        (1e-7, 1.0, 1e-8, (0.0, 0.0), 0.0, -1e-6),  # closed for long
        (1e-7, 1.0, -1e-7, (3e-6, 5e-6), 3e-6, 4e-6),  # its blow goes on
        (1e-7, -1.0, 1e-8, (3e-6, 5e-6), 3e-6, 4e-6),  # and while it springs back
        (1e-7, -1.0, 1e-8, (3e-6, 0.5e-6), 0.0, -0.5e-6),  # and is over
        (1e-7, -1.0, -1e-8, (0.0, 0.0), 0.0, -1e-6),  # opens again at once
    ],
)
def test_a_step_is_cut_where_a_blow_is_due_and_while_it_lasts(pen, rate, before, blow, step, lasts):
    """5 microseconds ahead, 1 since the last call."""
    scratch = at(pen, rate, before, blow)
    found = train_impacts.finest_step(train(4e7), motion(), scratch, 5e-6, 1e-6)
    due = TAU / PARTS if step == "new" else step
    assert found == pytest.approx(due or math.inf, rel=0.025) and scratch.impacts[
        1, 0
    ] == pytest.approx(due, rel=0.025)
    assert scratch.impacts[1, 1] == pytest.approx(
        8 * TAU + 5e-6 if lasts == "new" else lasts, rel=0.025
    )
    assert scratch.impacts[0].tolist() == [7.0, 7.0, 0.0, 0.0], "a link has no blows"


def test_a_soft_contact_asks_for_no_finer_step():
    scratch = at(-2e-6, 1.0)
    assert (
        train_impacts.finest_step(train(1e3), motion(), scratch, 5e-6, 1e-6) == math.inf
        and scratch.impacts[1, 0] == 0.0
    )


@pytest.mark.parametrize(
    ("length", "finest", "parts"),
    [
        (1e-6, 1e-6, 1),
        (1e-6, math.inf, 1),
        (1e-6, 0.999e-6, 2),
        (1e-6, 0.26e-6, 4),
        (1e-6, 0.2e-6 + 1e-12, 5),
        (1e-6, 1e-9, 64),
    ],
)
def test_no_part_of_a_step_is_longer_than_the_finest_up_to_64_parts(length, finest, parts):
    assert train_impacts.parts_of(length, finest) == parts


@pytest.mark.parametrize(
    ("kind", "damping", "rate", "meets"),
    [
        (laws.LINEAR, 0.0, 1.0, False),
        (laws.LINEAR, 2e4, 1.0, True),
        (laws.LINEAR, 2e4, -1.0, False),
        (laws.HUNT_CROSSLEY, 0.5, 1.0, False),
        (laws.POWER, 0.0, 1.0, False),
    ],
)
def test_a_damper_that_acts_from_the_touch_on_is_known(kind, damping, rate, meets):
    """Of laws with a smooth force the damping grows with the penetration."""
    pen, stiffness = 4e-6, 4e7
    contact = train(stiffness, 1.5 if kind == laws.HUNT_CROSSLEY else 1.0, damping, kind)
    scratch = at(pen, rate)
    force = laws.contact_force(kind, contact.law_parameters[1], rate, pen, rate)
    still = laws.contact_force(kind, contact.law_parameters[1], 0.0, pen, 0.0)
    scratch.gaps[1, 3] = (force - still) / rate  # N s/m, at this penetration
    assert train_impacts.meets_damper(1, contact, motion(), scratch, pen, rate) == meets
