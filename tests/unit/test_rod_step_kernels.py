"""Each pass of the rod's time step against its plain NumPy twin on random states."""

from __future__ import annotations

import numpy as np
import pytest

from twins import rod_energy as energies
from twins import rod_step as twin
from twins.rod_cases import random_state, small_mesh
from valvetrain.coil_contact.kernels import LINEAR
from valvetrain.cosserat import step_kernels as kern
from valvetrain.cosserat import time_stepping as stepping
from valvetrain.cosserat.buffer import RodDynamics, fill_buffer, stepping_numbers
from valvetrain.cosserat.layout import GROUP, ROW, row

DYNAMICS = RodDynamics(mass_damping=100.0, stiffness_damping=8e-6)
STEP = 3e-7
ONE, NO = np.uint64(1), np.uint64(0)


def buffer(seed=0, per_coil=12, closed=0.12):
    """A buffer in a random moving state with coils in touch, and the mesh."""
    mesh = small_mesh(per_coil)
    b = fill_buffer(mesh, random_state(mesh, seed, shift=1e-4, closed=closed), DYNAMICS, STEP)
    rng = np.random.default_rng(100 + seed)
    moving = slice(mesh.first + 1, mesh.last)
    scales = {
        "VX": 3.0,
        "VY": 3.0,
        "VZ": 3.0,
        "W1": 2e3,
        "W2": 2e3,
        "W3": 2e3,
        "L1": 1e-3,
        "L2": 1e-3,
        "L3": 1e-3,
    }
    for name, scale in scales.items():
        row(b, name, mesh.vertices)[moving] = scale * rng.standard_normal(
            mesh.last - mesh.first - 1
        )
    return b, mesh


def both(kernel, plain, b, *arguments, **options):
    """Run kernel and twin on copies; returns (result, buffer, expected result, expected buffer)."""
    got, expected = b.copy(), b.copy()
    unsigned = [np.uint64(a) if isinstance(a, int | np.integer) else a for a in arguments]
    return kernel(got, *unsigned), got, plain(expected, *arguments, **options), expected


def agree(got, expected, before, rel=1e-12):
    """Rows are equal to rounding, and something was written."""
    stride = int(ROW["Y"] - ROW["X"])
    changed = False
    for name, start in ROW.items():
        a, b, c = (v[int(start) : int(start) + stride - 8] for v in (got, expected, before))
        assert np.abs(a - b).max() <= rel * max(np.abs(b).max(), 1e-300), name
        changed |= bool(np.any(b != c))
    assert changed


@pytest.mark.parametrize("seed", [0, 1])
def test_section_forces(seed):
    b, mesh = buffer(seed)
    _, got, _, expected = both(
        kern.section_forces_of(ONE), twin.section_forces, b, mesh.first + 1, mesh.last + 1
    )
    agree(got, expected, b, 1e-10)


def test_bending_torques_with_their_branch():
    b, mesh = buffer()
    numbers = stepping_numbers(mesh, DYNAMICS, STEP)[1]
    arguments = (
        mesh.first,
        mesh.last + 1,
        *numbers[[stepping.DECAY, stepping.GAIN_OLD, stepping.GAIN_NEW, stepping.VISCOUS]],
    )
    power, got, expected_power, expected = both(
        kern.bending_torques_of(ONE), twin.bending_torques, b, *arguments
    )
    assert power == pytest.approx(expected_power, rel=1e-10)
    agree(got, expected, b, 1e-10)


def test_turning_of_edges():
    b, mesh = buffer()
    twin.section_forces(b, mesh.first + 1, mesh.last + 1)
    twin.bending_torques(b, mesh.first, mesh.last + 1, 0.9, 0.05, 0.05, 2.0)
    _, got, _, expected = both(
        kern.turn_edges_of(ONE), twin.turn_edges, b, mesh.first + 1, mesh.last + 1, STEP, 0.99, STEP
    )
    agree(got, expected, b, 1e-11)


def test_moving_of_vertices():
    b, mesh = buffer()
    twin.section_forces(b, mesh.first + 1, mesh.last + 1)
    motion, got, expected_motion, expected = both(
        kern.move_vertices_of(ONE),
        twin.move_vertices,
        b,
        mesh.first + 1,
        mesh.last,
        STEP,
        0.99,
        STEP,
    )
    assert motion == pytest.approx(expected_motion, rel=1e-12)
    agree(got, expected, b)


def test_copying_and_returning():
    b, mesh = buffer()
    offset = mesh.contact.offset
    _, got, _, expected = both(
        kern.copy_lower_wire, twin.copy_lower_wire, b, offset, mesh.vertices, offset
    )
    agree(got, expected, b)
    for name in ("GX", "GY", "GZ"):
        row(b, name, mesh.vertices)[:] = np.random.default_rng(3).standard_normal(mesh.vertices)
    _, got, _, expected = both(
        kern.return_contact, twin.return_contact, b, offset + 1, mesh.vertices - 1, offset
    )
    agree(got, expected, b)


@pytest.mark.parametrize("group", [0, 1])
def test_contact_forces_and_their_spreading(group):
    """The kernel expands overlap and normal in e = 1 - dist^2 / d0^2 and leaves terms of e^3 (5/32
    and 5/16 of the leading ones).
    """
    b, mesh = buffer(2, closed=0.085)
    line, suffix, g = mesh.contact, "b" if group else "", GROUP if group else NO
    first, last = line.offset + 1, mesh.vertices - 1
    twin.copy_lower_wire(b, line.offset, mesh.vertices, line.offset)
    t, s = line.upper_place[group], line.lower_place[group]
    arguments = (first, last, t, s, 1e-6, STEP, LINEAR, 0)
    _, got, _, expected = both(
        kern.contact_forces_of(g, ONE), twin.contact_forces, b, *arguments, suffix=suffix
    )
    pressed = row(expected, f"IMPULSE{suffix}", mesh.vertices) / STEP
    assert np.count_nonzero(pressed) > 3 and np.count_nonzero(pressed[first:last] == 0) > 3
    position = np.stack([row(b, name, mesh.vertices) for name in "XYZ"], axis=1)
    gaps = energies.contact(
        position, line.offset, line.upper_place, line.lower_place, line.distance, line.length, 1.0
    )[2]
    leading = 1 - (1 + (gaps / line.distance).min()) ** 2
    assert 0.01 < leading < 0.1
    agree(got, expected, b, leading**3)
    b = expected
    _, got, _, expected = both(
        kern.spread_contact_of(g, ONE),
        twin.spread_contact,
        b,
        first - 1,
        last + 1,
        t,
        suffix=suffix,
    )
    agree(got, expected, b)
    total = sum(row(expected, name, mesh.vertices).sum() for name in ("CX", "CY", "CZ"))
    assert total == pytest.approx(
        sum(row(b, name + suffix, mesh.vertices).sum() for name in ("PX", "PY", "PZ"))
    )


def test_seat_contact():
    b, mesh = buffer()
    z = row(b, "Z", mesh.vertices)
    row(b, "LOWER", mesh.vertices)[:] = z + 1e-5 * np.sin(np.arange(mesh.vertices))
    row(b, "UPPER", mesh.vertices)[:] = z + 1e-5 * np.cos(np.arange(mesh.vertices)) + 1e-3
    forces, got, expected_forces, expected = both(
        kern.seat_contact, twin.seat_contact, b, 2, mesh.vertices - 2, 1e-3, LINEAR, 0
    )
    assert forces == pytest.approx(expected_forces, rel=1e-12) and min(forces) > 0
    agree(got, expected, b)


@pytest.mark.parametrize("width", range(1, 7))
def test_every_point_force_reaches_the_wire_once(width):
    """Two pressed stretches of wire with ``width`` vertices out of contact between them."""
    b, mesh = buffer(2, per_coil=24)
    integers, numbers, places = stepping_numbers(mesh, DYNAMICS, STEP)
    offset, vertices = mesh.contact.offset, mesh.vertices
    for name in ("KC", "KCb"):
        row(b, name, vertices)[offset + 9 : offset + 9 + width] = 0.0
    stretches = np.zeros((stepping.STRETCHES, 2))
    count = stepping.watch_contacts(b, integers, 1e-5, stretches)
    assert count == 1 if width < 4 else width < 6 or count == 2
    for _ in range(2):
        stepping.all_contact(
            b, integers, numbers, places, stretches, count, np.uint64(0), np.uint64(vertices)
        )
    force = np.stack([row(b, n, vertices) for n in ("CX", "CY", "CZ")], axis=1)
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
    work, offset, vertices = b.copy(), mesh.contact.offset, mesh.vertices
    for name in ("CX", "CY", "CZ", "GX", "GY", "GZ"):
        row(work, name, vertices + 2)[:] = 0.0
    for group, suffix in enumerate(("", "b")):
        twin.spread_contact(work, offset, vertices, places[group, 0], suffix=suffix)
    twin.return_contact(work, offset, vertices, offset)
    return np.stack([row(work, n, vertices) for n in ("CX", "CY", "CZ")], axis=1)
