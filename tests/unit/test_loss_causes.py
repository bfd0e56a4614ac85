"""Unit: the cause of a loss of control at a critical speed, from a run there with a known answer."""

from __future__ import annotations

import numpy as np
import pytest

from synthetic_train import ANGLE, COUNT, degrees, rigid, train
from valvetrain.quantities.loss_cause import loss_cause
from valvetrain.quantities.train_events import (
    rigid_cycle,
)
from valvetrain.solution.status import Cause, Event

WINDOW = (np.pi / 2, 1.5 * np.pi)


def cause(kind: str, *events: Event, spring: float = 500.0, pressed: float = 400.0) -> dict:
    """Of a run whose cam force is least at 180 degrees, ``spring`` of 500 N left there and the cam
    ``pressed`` (N) by rigid parts.
    """
    near = degrees(170, 190)
    run = train(
        events,
        cam_contact_force=np.abs(ANGLE - np.pi),
        retainer_force=np.where(near, spring, 500.0),
        static_retainer_force=np.full(COUNT, 500.0),
    )
    still = rigid_cycle(run, rigid(contact_force=np.where(near, pressed, 400.0)))
    return dict(loss_cause(run, still, kind, ["cam"], WINDOW))


def event(kind: str, size: float, why: str, loss: float = 0.0, first: float = 170.0) -> Event:
    details = {"cause": why} | ({"spring_force_loss": loss} if loss else {})
    return Event(kind, np.radians(first), 0.0, 1e-3, size, "m", "cam", details)


def test_a_contact_without_a_gap_has_the_cause_of_the_moment_of_least_force():
    assert cause("contact-loss", spring=420.0) == {"cause": Cause.SURGE, "spring_force_loss": 80.0}
    assert cause("contact-loss") == {"cause": Cause.VIBRATION}
    # 30 N of surge are little of 500 N, and most of the 40 N that rigid parts leave
    assert cause("contact-loss", spring=470.0) == {"cause": Cause.VIBRATION}
    assert cause("contact-loss", spring=470.0, pressed=40.0)["cause"] == Cause.SURGE
    assert cause("contact-loss", pressed=-1.0) == {"cause": Cause.INERTIA}


def test_a_gap_in_the_open_valve_tells_its_own_cause_and_none_elsewhere_does():
    inside = event("loft", 1e-5, Cause.INERTIA)
    ramp = event("loft", 1e-4, Cause.INERTIA, first=300.0)
    assert cause("contact-loss", inside, ramp, spring=420.0) == {"cause": Cause.INERTIA}
    assert cause("contact-loss", ramp, spring=420.0)["cause"] == Cause.SURGE


@pytest.mark.parametrize(
    ("own", "loss", "expected"),
    [
        ((Cause.VIBRATION, 0.0), (Cause.SURGE, 57.0), Cause.SURGE),
        ((Cause.SURGE, 184.0), (Cause.VIBRATION, 0.0), Cause.SURGE),
        ((Cause.SURGE, 184.0), (Cause.INERTIA, 0.0), Cause.INERTIA),
        ((Cause.VIBRATION, 0.0), (Cause.VIBRATION, 0.0), Cause.VIBRATION),
    ],
)
def test_vibration_is_what_is_left_of_a_float_and_its_loss(own, loss, expected):
    lost = event("loft", 6e-5, *loss, first=165.0)
    assert cause("float", event("float", 5e-5, *own), lost)["cause"] == expected


def test_a_loss_that_is_over_before_a_float_begins_is_none_of_its_causes():
    early = event("loft", 6e-5, Cause.SURGE, 99.0, first=100.0)
    assert cause("float", event("float", 5e-5, Cause.VIBRATION), early) == {
        "cause": Cause.VIBRATION
    }
    assert cause("float") == cause("bounce") == {}


def test_the_cause_is_that_which_a_run_at_this_speed_gives():
    """Contract: `run` passed over a small gap of vibration for one that surge makes, `sweep` did not; and a gap
    that begins below a tenth of the lift did not count."""
    small = event("loft", 1e-5, Cause.VIBRATION)
    surge = event("loft", 8e-6, Cause.SURGE, 60.0, first=185.0)
    assert cause("contact-loss", small, surge)["cause"] == Cause.SURGE
    flight = event("loft", 3e-5, Cause.VIBRATION)
    assert cause("contact-loss", flight, surge)["cause"] == Cause.VIBRATION
    early = event("loft", 3e-5, Cause.SURGE, 60.0, first=89.9)
    assert cause("contact-loss", early)["cause"] == Cause.SURGE
