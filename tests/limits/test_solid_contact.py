"""Contact of the solid on its section centres, against closed forms: bars that collide, a ring that
bounces, forces as the slope of the energy, action and reaction.
"""

from __future__ import annotations

import numpy as np
import pytest

from solid_parts import helix
from valvetrain.coil_contact.law import LINEAR, law_numbers
from valvetrain.continuum import contact_kernels
from valvetrain.continuum.wire import (
    ContactPoints,
    SeatPlanes,
    SolidContactLaw,
    SolidMeshSize,
    SolidWire,
)
from valvetrain.cosserat.contact_line import true_distance

STIFFNESS, DIAMETER = 1e6, 4e-3
#: Stations of each of two parallel bars along x, one above the other.
BAR = 12
NUMBERS = law_numbers(LINEAR)


def two_bars(gap: float) -> tuple[np.ndarray, ContactPoints]:
    """Centres (3 x stations) of a lower and an upper bar that are ``gap`` (m) apart, and one contact
    point per station of the upper one away from its ends."""
    along = np.arange(BAR) * 1e-3
    x = np.concatenate([along, along])
    z = np.concatenate([np.zeros(BAR), np.full(BAR, DIAMETER + gap)])
    station = BAR + np.arange(2, BAR - 2)
    count = len(station)
    points = ContactPoints(
        station,
        np.zeros(count),
        np.full(count, DIAMETER),
        np.full(count, STIFFNESS),
        np.zeros(count, dtype=np.int64),
        (station - BAR).astype(float),
        np.zeros(count),
        np.ones(count, dtype=bool),
        np.zeros((2, count)),
        np.zeros((2, 1)),
        np.zeros(count),
        np.zeros((4, count)),
    )
    return np.concatenate([x, 0 * x, z]), points


def pushed(
    centre: np.ndarray, rate: np.ndarray, points: ContactPoints, damping_time: float = 0.0
) -> tuple[np.ndarray, np.ndarray]:
    """Forces on the centres (3, stations), and energy stored and power lost."""
    push, totals = np.zeros(len(centre)), np.zeros(2)
    contact_kernels.coil_forces(
        centre, rate, push, len(centre) // 3, points, 0, NUMBERS.ctypes.data, damping_time, totals
    )
    return push.reshape(3, -1), totals


def test_two_bars_collide():
    """Closed form: rigid bars of masses m and 3 m meet at v: duration pi / omega, deepest overlap
    v / omega, omega^2 = k (1/m + 1/3m), and velocities exchanged as by an elastic impact."""
    mass, velocity = np.array([0.01, 0.03]), 2.0  # upper, lower
    centre, points = two_bars(1e-6)
    upper = np.arange(2 * BAR) >= BAR
    stiffness = points.stiffness.sum()
    omega = np.sqrt(stiffness * np.sum(1 / mass))
    step, moved = 0.002 / omega, np.array([-velocity, 0.0])
    touching, deepest = 0, 0.0
    for _ in range(4000):
        push, totals = pushed(centre, np.zeros(len(centre)), points)
        force = np.array([push[2, upper].sum(), push[2, ~upper].sum()])
        touching += force[0] > 0
        deepest = max(deepest, np.sqrt(2 * totals[0] / stiffness))
        moved = moved + step * force / mass
        centre[2 * 2 * BAR :] += step * np.where(upper, moved[0], moved[1])
    assert touching * step == pytest.approx(np.pi / omega, rel=2e-3)
    assert deepest == pytest.approx(velocity / omega, rel=1e-4)
    after = [-velocity * (mass[0] - mass[1]) / mass.sum(), -velocity * 2 * mass[0] / mass.sum()]
    assert moved == pytest.approx(after, rel=1e-3)


def test_a_damped_contact_loses_what_the_damper_takes():
    """Closed form: Kelvin and Voigt's contact that lets go when it would pull returns with the
    coefficient of a damped half-swing, exp(-2 zeta atan(s / zeta) / s), s = sqrt(1 - zeta^2)."""
    mass, velocity, zeta = 0.02, 1.0, 0.2
    centre, points = two_bars(0.0)
    upper = np.arange(2 * BAR) >= BAR
    omega = np.sqrt(points.stiffness.sum() / mass)
    step, speed, lost = 1e-4 / omega, -velocity, 0.0
    rate = np.zeros(len(centre))
    for _ in range(60_000):
        rate[4 * BAR :] = np.where(upper, speed, 0.0)
        push, totals = pushed(centre, rate, points, 2 * zeta / omega)
        lost += step * totals[1]
        speed += step * push[2, upper].sum() / mass
        centre[4 * BAR :] += step * np.where(upper, speed, 0.0)
        if speed > 0 and push[2, upper].sum() == 0.0:
            break
    share = np.sqrt(1 - zeta**2)
    swing = np.exp(-zeta / share * 2 * np.arctan2(share, zeta))
    assert speed / velocity == pytest.approx(swing, rel=2e-3)
    left = 0.5 * mass * (velocity**2 - speed**2)
    stored = 0.5 * points.stiffness.sum() * max(DIAMETER - centre[-1], 0.0) ** 2
    assert lost == pytest.approx(left - stored, rel=5e-3)


def test_a_ring_bounces_on_a_plane():
    """Closed form: a rigid ring that falls on a plane is pressed for pi sqrt(m / k), to the depth
    v sqrt(m / k), leaves as fast as it came, and is never pulled."""
    stations, mass, velocity = 24, 0.05, 1.5
    planes = SeatPlanes(
        np.arange(stations),
        np.ones(stations),
        np.zeros(stations),
        np.full(stations, STIFFNESS),
        np.full(stations, DIAMETER / 2),
        np.zeros(stations),
        np.zeros((3, stations)),
    )
    omega = np.sqrt(stations * STIFFNESS / mass)
    centre, step, speed = np.zeros(3 * stations), 0.002 / omega, -velocity
    centre[2 * stations :] = 1e-6
    touching, deepest = 0, 0.0
    for _ in range(4000):
        push = np.zeros(3 * stations)
        seat, retainer = contact_kernels.plane_forces(
            centre, push, stations, planes, 0.0, 0, NUMBERS.ctypes.data, np.zeros(2)
        )
        assert seat == pytest.approx(push.sum()) and seat >= 0 and retainer == 0
        touching += seat > 0
        deepest = max(deepest, -centre[-1])
        speed += step * push.sum() / mass
        centre[2 * stations :] += step * speed
    assert touching * step == pytest.approx(np.pi / omega, rel=2e-3)
    assert deepest == pytest.approx(velocity / omega, rel=1e-3)
    assert speed == pytest.approx(velocity, rel=1e-3)


@pytest.fixture(scope="module")
def pressed() -> tuple[SolidWire, np.ndarray]:
    """A short helix, squeezed and shaken until coils press on one another."""
    wire = SolidWire(helix(coils=3.0, pitch=4.0e-3), SolidMeshSize(16), SolidContactLaw(1e9))
    centre = wire.centres(wire.free_position)
    centre[2] *= 0.93
    centre += 2e-5 * np.random.default_rng(3).standard_normal(centre.shape)
    return wire, centre.ravel()


def test_contact_forces_are_the_slope_of_their_energy(pressed):
    """Property: with its feet found, the force on a centre is minus the derivative of the energy."""
    wire, centre = pressed
    rate, step = np.zeros(len(centre)), 1e-9 * np.random.default_rng(4).standard_normal(len(centre))

    def energy(at: np.ndarray) -> tuple[float, np.ndarray]:
        points = wire.contact_points.copy()
        contact_kernels.follow_feet(at, wire.stations, points, 1.0, 20)
        push, totals = pushed(at, rate, points)
        return totals[0], push.ravel()

    slope = (energy(centre + step)[0] - energy(centre - step)[0]) / 2
    whole, push = energy(centre)
    assert whole > 0 and -push @ step == pytest.approx(slope, rel=1e-4)


def test_coils_push_one_another_equally(pressed):
    """Property: contact forces between coils have no resultant and no moment."""
    wire, centre = pressed
    points = wire.contact_points.copy()
    contact_kernels.follow_feet(centre, wire.stations, points, 1.0, 20)
    push, _ = pushed(centre, np.zeros(len(centre)), points)
    size = np.abs(push).sum()
    moment = np.cross(centre.reshape(3, -1).T, push.T).sum(axis=0)
    assert size > 1.0
    assert np.abs(push.sum(axis=1)).max() < 1e-12 * size
    assert np.abs(moment).max() < 1e-9 * size * np.abs(centre).max()


def test_the_first_contact_point_stands_off_the_wire_as_all_others():
    """Closed form: coils of an even helix lie equally far apart everywhere, also where the foot falls
    within half a station of the end; there the spline goes on as its parabola. A foot held at its
    end stood 22 um farther, askew."""
    spring = helix(coils=3.0, pitch=4.4e-3)
    points = SolidWire(spring, SolidMeshSize(24)).contact_points
    assert points.foot.min() < 0.5
    due = true_distance(spring.centreline, np.full(1, 2.0))[0]
    assert points.apart == pytest.approx(np.full(len(points.apart), due), abs=2e-6)


def test_a_copy_of_contact_points_leaves_the_original_as_it_was():
    """Contract: what kernels write into a copied state (foot, gap, forces, peaks) stays there."""
    _, points = two_bars(0.1e-3)
    before = {name: array.copy() for name, array in points._asdict().items()}
    copied = points.copy()
    for name in ("foot", "apart", "drag", "pressed", "peak", "held"):
        getattr(copied, name)[...] = 7.0
    copied.near[...] = False
    for name, array in points._asdict().items():
        assert np.array_equal(array, before[name]), name
