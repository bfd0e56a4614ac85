"""Contact in the rod's time step: the gradient of its energy, every point force once, and which wire is watched."""

from __future__ import annotations

import numpy as np
import pytest

from twins import rod_energy as energies
from twins.rod_cases import random_state, small_mesh
from valvetrain.coil_contact.kernels import LINEAR
from valvetrain.cosserat import step_kernels as kern
from valvetrain.cosserat import time_stepping as stepping
from valvetrain.cosserat.buffer import RodDynamics, fill_buffer, stepping_numbers
from valvetrain.cosserat.layout import row

DYNAMICS = RodDynamics(mass_damping=100.0, stiffness_damping=8e-6)
STEP = 3e-7


def buffer(seed=0, per_coil=12, closed=0.12, speed=3.0, shift=1e-4):
    """A buffer in a random state with coils in touch, vertices at about ``speed`` (m/s); the mesh."""
    mesh = small_mesh(per_coil)
    b = fill_buffer(mesh, random_state(mesh, seed, shift=shift, closed=closed), DYNAMICS, STEP)
    rng = np.random.default_rng(100 + seed)
    for name in ("VX", "VY", "VZ"):
        inside = row(b, name, mesh.vertices)[mesh.first + 1 : mesh.last]
        inside[:] = speed * rng.standard_normal(len(inside))
    return b, mesh


def all_contact(b, mesh, stretches=None, count=None):
    """Contact forces on the vertices (count, 3), N, of the wire in ``stretches`` or of all of it."""
    integers, numbers, places = stepping_numbers(mesh, DYNAMICS, STEP)
    if stretches is None:
        stretches = np.zeros((stepping.STRETCHES, 2))
        count = stepping.watch_contacts(b, integers, 1.0, stretches)
    ends = np.uint64(0), np.uint64(mesh.vertices)
    stepping.all_contact(b, integers, numbers, places, stretches, count, *ends)
    return np.stack([row(b, name, mesh.vertices) for name in ("CX", "CY", "CZ")], axis=1)


def test_contact_of_a_wire_at_rest_is_the_gradient_of_its_energy():
    """Twin: energy and gradient written as in books. The kernel expands overlap and normal in
    e = 1 - dist^2 / d0^2 and leaves terms of e^3 (5/32 and 5/16 of the leading ones); its foot takes the slope of the free wire, so shifts are small.
    """
    b, mesh = buffer(2, closed=0.1, speed=0.0, shift=1e-6)
    position = np.stack([row(b, name, mesh.vertices) for name in "XYZ"], axis=1)
    line = mesh.contact
    _, gradient, gaps = energies.contact(
        position, line.offset, line.upper_place, line.lower_place, line.distance, line.length,
        DYNAMICS.contact_stiffness,
    )  # fmt: skip
    assert np.count_nonzero(gaps < 0) > 3 and np.count_nonzero(gaps > 0) > 3
    leading = 1 - (1 + (gaps / line.distance).min()) ** 2
    assert 0.01 < leading < 0.1
    expected = -gradient[:, :3]
    assert np.abs(all_contact(b, mesh) - expected).max() < leading**3 * np.abs(expected).max()


def test_a_seat_presses_where_the_wire_would_pass_it():
    b, mesh = buffer()
    z = row(b, "Z", mesh.vertices)
    lower, upper = row(b, "LOWER", mesh.vertices), row(b, "UPPER", mesh.vertices)
    lower[:] = z + 1e-5 * np.sin(np.arange(mesh.vertices))
    upper[:] = z + 1e-5 * np.cos(np.arange(mesh.vertices)) + 1e-3
    seat, inside = row(b, "SEAT", mesh.vertices), slice(2, mesh.vertices - 2)
    below = (seat * np.maximum(lower - z, 0.0))[inside].sum()
    above = (seat * np.maximum(z - upper + 1e-3, 0.0))[inside].sum()
    ends = np.uint64(inside.start), np.uint64(inside.stop)
    forces = kern.seat_contact(b, *ends, 1e-3, LINEAR, 0)
    assert forces == pytest.approx((below, above), rel=1e-12) and min(forces) > 0


@pytest.mark.parametrize("width", range(1, 7))
def test_every_point_force_reaches_the_wire_once(width):
    """Two pressed stretches of wire with ``width`` vertices out of contact between them."""
    b, mesh = buffer(2, per_coil=24)
    integers, _, places = stepping_numbers(mesh, DYNAMICS, STEP)
    offset, vertices = mesh.contact.offset, mesh.vertices
    for name in ("KC", "KCb"):
        row(b, name, vertices)[offset + 9 : offset + 9 + width] = 0.0
    stretches = np.zeros((stepping.STRETCHES, 2))
    count = stepping.watch_contacts(b, integers, 1e-5, stretches)
    assert count == 1 if width < 4 else width < 6 or count == 2
    for _ in range(2):
        force = all_contact(b, mesh, stretches, count)
    assert np.abs(force.sum(axis=0)).max() < 1e-9 * np.abs(force).sum()
    assert np.abs(force - single_spread(b, mesh, places)).max() < 1e-9 * np.abs(force).max()


@pytest.mark.parametrize("reach", [1e-6, 1e-4, 5e-4])
def test_watched_is_the_wire_whose_gap_to_the_turn_below_lies_within_reach(reach):
    """Gaps across the chord of the wire below; stretches hold a vertex more at either end, and join
    over three.
    """
    b, mesh = buffer(2, per_coil=24)
    vertices, offset = mesh.vertices, mesh.contact.offset
    row(b, "Z", vertices)[:] += 4e-4 * np.sin(np.arange(vertices) / 9)
    place = np.stack([row(b, name, vertices) for name in "XYZ"], axis=1)
    upper = np.arange(offset + 1, vertices - 1)
    below = place[upper - offset + 1] - place[upper - offset - 1]
    away, along = (
        place[upper] - place[upper - offset],
        below / np.linalg.norm(below, axis=1)[:, None],
    )
    gap = np.linalg.norm(away - np.sum(away * along, axis=1)[:, None] * along, axis=1)
    thick = 2 * np.maximum(*(row(b, name, vertices)[upper] for name in ("DH", "DHb")))
    pressed = row(b, "KC", vertices)[upper] + row(b, "KCb", vertices)[upper] > 0
    due = upper[pressed & (gap < thick + reach)]
    assert 0 < len(due) < np.count_nonzero(pressed)
    stretches = np.zeros((stepping.STRETCHES, 2))
    count = stepping.watch_contacts(b, stepping_numbers(mesh, DYNAMICS, STEP)[0], reach, stretches)
    watched = {one for first, end in stretches[:count].astype(int) for one in range(first, end)}
    assert 0 < count < stepping.STRETCHES - 1 and watched >= set(due)
    assert max(np.min(np.abs(due - one)) for one in watched) <= 2


def single_spread(b, mesh, places):
    """Contact force per vertex from the point forces, each spread once."""
    offset, vertices = mesh.contact.offset, mesh.vertices
    force = np.zeros((vertices + 2, 3))
    for group, suffix in enumerate(("", "b")):
        above = energies.span(np.zeros((3, 3)), 1, places[group, 0])[3]
        pressed, below = (
            np.stack([row(b, f"{name}{suffix}", vertices) for name in names.split()], axis=1)
            for names in ("PX PY PZ", "S0 S1 S2")
        )
        for vertex in range(offset + 1, vertices - 1):
            force[vertex - 1 : vertex + 2] += above[:, None] * pressed[vertex]
            lower = vertex - offset
            force[lower - 1 : lower + 2] -= below[vertex][:, None] * pressed[vertex]
    return force[:vertices]
