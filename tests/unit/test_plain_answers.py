"""Unit: numbers and names of answers that fresh users took for something else."""

from __future__ import annotations

import numpy as np

from synthetic_study import rod_run
from valvetrain.cam.event import LiftEvent
from valvetrain.parameters.summary import number
from valvetrain.quantities import clash
from valvetrain.quantities.cycle import reported_cycle


def test_what_rounding_leaves_is_printed_as_zero():
    """A least torque of -2.22e-16 N m stood on the page of a bucket."""
    assert [number(value) for value in (-2.22e-16, 9e-13, 0.0)] == ["0"] * 3
    assert number(4.24e-9).startswith("4.24")


def test_spikes_below_the_base_are_no_main_clash(monkeypatch):
    """Ends that lift leave spikes below the force of the base circle; a sweep failed with an IndexError."""
    angle = np.linspace(0.0, 2 * np.pi, 721)[:-1]
    force = 100.0 + 20.0 * np.sin(40 * angle)

    def held(base: float) -> clash._Force:
        return clash._Force(angle / 400, angle, force, force, force, base)

    monkeypatch.setattr(clash, "_force", lambda cycle, frequency, end: held(200.0))
    event, cycle = LiftEvent(np.radians(60.0), np.radians(200.0)), reported_cycle(rod_run())
    assert clash.find_clash_window(cycle, 600.0, event) is None
