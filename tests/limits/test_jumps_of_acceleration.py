"""A lift law whose second derivative jumps keeps its jump where it states it, anywhere in a cell of
the table (closed forms: the law itself, and the flight of a rigid follower over a dwell).
"""

from __future__ import annotations

import numpy as np
import pytest

from train_parts import direct, finger, system
from valvetrain.cam.closed_form import Harmonic
from valvetrain.cam.pieces import PeriodicPieces
from valvetrain.cam.spline import Stations
from valvetrain.contact.elastic import LinearContact
from valvetrain.integrate.train_record import TrainOptions, TrainState
from valvetrain.integrate.train_run import runner
from valvetrain.integrate.train_tuples import PEAK_PLACE
from valvetrain.mechanism.contour import lift_jumps, lift_table
from valvetrain.mechanism.gap_kinds import CAM_LIFT
from valvetrain.mechanism.gaps import table_value
from valvetrain.mechanism.parts import AssembledMechanism, Coordinate, Interaction
from valvetrain.parameters.train_parts import FollowerParameters
from valvetrain.system.train_system import TrainSystem

LIFT, HALF = 8e-3, np.radians(30)
ACCELERATION = LIFT / HALF**2
ANGLES = np.linspace(0.0, 2 * np.pi, 20001)


def parabolic(start: float) -> PeriodicPieces:
    """Constant acceleration, then as much deceleration, up to a dwell, and back (cam rad)."""
    breaks = start + np.radians([0, 30, 60, 180, 210, 240, 360])
    a, v = ACCELERATION / 2, ACCELERATION * HALF
    rows = [[0, 0, a], [LIFT / 2, v, -a], [LIFT, 0, 0], [LIFT, 0, -a], [LIFT / 2, -v, a], [0, 0, 0]]
    return PeriodicPieces(breaks, np.array(rows), continuity=1)


def values(table) -> np.ndarray:
    return np.array([table_value(table[None], 0, angle) for angle in ANGLES])


@pytest.mark.parametrize("offset", [0.0, 0.0005, 0.1, 0.2495])
@pytest.mark.parametrize("contour", ["table", "flat", "roller"])
def test_a_table_holds_the_law_on_both_sides_of_its_jumps(offset, contour):
    """A quintic through both sides of a jump is off by all of it."""
    start = np.radians(100 + offset)
    law = Harmonic(
        maximum_lift=9e-3, opening_start=start, opening_end=start + 1.4, closing_start=3.5, closing_end=5.0
    )  # fmt: skip
    base = 0.0
    if contour == "table":
        table = lift_table(law)
    else:
        radius = {"flat": 0.0, "roller": 12e-3}[contour]
        follower = FollowerParameters(contour, mass=0.05, radius=radius)
        table = system(direct(follower=follower), law).mechanism.tables["cam contour"]
        base = 18e-3 + radius
    jumps, sizes, _ = lift_jumps(law)
    assert len(jumps) == 4 and np.all(np.abs(sizes) > 1e-2)
    apart = np.min(np.abs(ANGLES[:, None] - jumps), axis=1) > 1e-6
    found = values(table)[apart]
    for derivative, share in enumerate((1e-9, 1e-7, 1e-5)):
        exact = law.lift(ANGLES[apart], derivative)
        error = np.abs(found[:, derivative] - exact - (base if derivative == 0 else 0.0)).max()
        assert error < share * np.abs(exact).max()


def test_stations_closer_than_the_table_state_a_jump():
    """As a law is written down that knows no jumps: two stations a thousandth of a degree apart."""
    width = np.radians(1e-3)
    law = Stations(
        cam_angles=tuple(np.radians([0, 30.1, 30.101, 60.2, 90, 150])),
        lifts=(0.0, 2e-3, 2e-3 + 8e-3 * width, 4e-3, 2e-3, 0.0),
        velocities=(0.0, 8e-3, 8e-3 + 5e-3 * width, 0.0, -5e-3, 0.0),
        accelerations=(0.0, 0.05, -0.04, -0.04, 0.0, 0.0),
    )
    jumps, sizes, widths = lift_jumps(law)
    assert np.degrees(jumps) == pytest.approx([30.1005]) and sizes == pytest.approx([-0.09])
    apart = np.abs(ANGLES - jumps[0]) > widths[0]
    error = np.abs(values(lift_table(law))[:, 2] - law.lift(ANGLES, 2))[apart]
    assert error.max() < 1e-4


def test_a_law_without_jumps_keeps_its_table():
    """Bit-identical: three columns, one node every quarter degree."""
    from train_parts import LAW

    assert lift_table(LAW).shape == (1440, 3)
    assert system(finger(), LAW).mechanism.tables["cam contour"].shape == (1440, 3)


def loft(start: float) -> float:
    """Height (m) above the dwell to which a rigid follower flies that leaves the cam on its jump."""
    cam_speed = 60.0
    pull = ACCELERATION * cam_speed**2 / 1.012
    law = LinearContact(contact_stiffness=1e12, damping=1.4e6)
    contact = Interaction("cam", CAM_LIFT, ("valve",), (0.0, 1.0, 0.0, 0.0, 0.0, 1.0), law, "cam")
    tables = {"cam": lift_table(parabolic(start))}
    body = (Coordinate("valve", 1.0, force=-pull),)
    built = TrainSystem(AssembledMechanism("rig", body, (contact,), tables, "valve", "valve"))
    ready = runner(built, cam_speed, TrainOptions(samples=1440))
    state = TrainState(np.array([-pull / 1e12]), np.zeros(1), (), np.zeros(0), np.zeros(5))
    _, record = ready.cycle(state)
    return float(record.bodies[0, PEAK_PLACE]) - LIFT


def test_the_flight_of_a_rigid_follower_does_not_depend_on_where_in_a_cell_it_begins():
    """Exact: half the lift times (deceleration over pull, less one) = 48 um; by a smeared jump, 47.9 to 51.6."""
    found = [loft(np.radians(20 + share * 0.25)) for share in (0.0, 0.1, 0.35, 0.6, 0.9)]
    assert np.ptp(found) < 0.01 * 48e-6
    assert found == pytest.approx([LIFT / 2 * 0.012] * 5, rel=0.06)
