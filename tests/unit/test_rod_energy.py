"""Statics of the rod: gradient and tangent against finite differences of the energy, kernels
against their NumPy twins.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from twins import rod_energy as twin
from twins.rod_cases import random_state, small_mesh
from valvetrain.coil_contact.kernels import LINEAR, NO_NUMBERS
from valvetrain.cosserat import energy_kernels as kern
from valvetrain.cosserat.contact_line import no_contact
from valvetrain.cosserat.mesh import RodMesh
from valvetrain.cosserat.state import RodState, advance
from valvetrain.cosserat.static import RodStatics

NOTHING = {"stretch_stiffness": 0.0, "bend_stiffness": 0.0}


def only(term: str, mesh: RodMesh) -> RodMesh:
    """The mesh with one energy term left: stretch, bend, contact or seat."""
    silent = {name: 0 * getattr(mesh, name) for name in NOTHING if not name.startswith(term)}
    if term != "contact":
        silent["contact"] = no_contact(mesh.vertices)
    if term == "seat":
        middle = 0.6 * float(mesh.position[:, 2].max())
        return replace(
            mesh,
            **silent,
            lower_seat_limit=np.where(np.arange(mesh.vertices) < 20, 2e-3, -np.inf),
            upper_seat_limit=np.where(np.arange(mesh.vertices) > 25, middle, np.inf),
        )
    return replace(mesh, **silent)


def case(term: str, **shape: float) -> tuple[RodStatics, RodState, np.ndarray]:
    """Statics, a random state and the free unknowns."""
    mesh = only(term, small_mesh())
    state = random_state(mesh, 3, **shape)
    statics = RodStatics(mesh)
    return statics, state, np.flatnonzero(statics.free)


def shifted(state: RodState, size: int, unknown: int, step: float) -> RodState:
    change = np.zeros(size)
    change[unknown] = step
    return advance(state, change, state.compression)


@pytest.mark.parametrize("term", ["stretch", "bend", "seat"])
def test_gradient_is_the_difference_of_the_energy(term):
    statics, state, free = case(term)
    energy, gradient, *_ = statics.assemble(state)
    assert energy > 0
    size, step = len(gradient), 1e-7
    for unknown in free[:: 7 if term != "seat" else 1]:
        up, down = (
            statics.assemble(shifted(state, size, unknown, sign * step))[0] for sign in (1, -1)
        )
        assert (up - down) / (2 * step) == pytest.approx(
            gradient[unknown], rel=1e-5, abs=1e-6 * np.abs(gradient).max()
        )


def test_contact_force_is_nearly_the_gradient_of_its_energy():
    """One Newton step leaves a foot that is not exactly perpendicular: force and energy agree to
    the square of that error.
    """
    statics, state, free = case("contact")
    _, gradient, *_ = statics.assemble(state)
    found = np.zeros(len(gradient))
    for unknown in free[free % 6 < 3]:
        up, down = (
            statics.assemble(shifted(state, len(gradient), unknown, sign * 1e-9))[0]
            for sign in (1, -1)
        )
        found[unknown] = (up - down) / 2e-9
    held = ~statics.free
    assert np.abs(gradient[held]).max() < 1e6 and np.abs(gradient).max() > 100
    assert np.linalg.norm((found - gradient)[free]) < 5e-3 * np.linalg.norm(gradient[free])


@pytest.mark.parametrize("term", ["stretch", "bend", "seat"])
def test_tangent_is_the_difference_of_the_gradient(term):
    statics, state, free = case(term)
    tangent = statics.tangent(state).toarray()
    size, step = tangent.shape[0], 1e-6
    assert (
        np.abs(tangent[np.ix_(free, free)] - tangent[np.ix_(free, free)].T).max()
        < 1e-9 * np.abs(tangent).max()
    )
    for unknown in free[::5]:
        up, down = (
            statics.assemble(shifted(state, size, unknown, sign * step), False)[1]
            for sign in (1, -1)
        )
        difference = (up - down) / (2 * step)
        # In rotations the Hessian is the symmetric part; the rest is half the moment's cross
        # product on the same edge.
        error = symmetric(difference, unknown, statics, state) - tangent[:, unknown]
        for kind in (free[free % 6 < 3], free[free % 6 >= 3]):
            assert (
                np.abs(error[kind]).max()
                <= 3e-6 * np.abs(tangent[np.ix_(kind, [unknown, *free[:12]])]).max()
            )


def symmetric(column: np.ndarray, unknown: int, statics: RodStatics, state: RodState) -> np.ndarray:
    """Take the antisymmetric part m x / 2 of a body rotation's own block off a difference of
    gradients.
    """
    if unknown % 6 < 3:
        return column
    block = 6 * (unknown // 6) + 3
    moment = statics.assemble(state, False)[1][block : block + 3]
    out = column.copy()
    out[block : block + 3] -= 0.5 * np.cross(moment, np.eye(3)[unknown - block])
    return out


def test_contact_tangent_is_nearly_the_difference_of_the_gradient():
    statics, state, free = case("contact", shift=1e-5, closed=0.075)
    tangent = statics.tangent(state)
    rng = np.random.default_rng(1)
    for _ in range(5):
        direction = np.where(statics.free, rng.standard_normal(tangent.shape[0]), 0.0)
        up, down = (
            statics.assemble(advance(state, s * 1e-9 * direction, state.compression), False)[1]
            for s in (1, -1)
        )
        difference = (up - down) / 2e-9
        assert np.linalg.norm((difference - tangent @ direction)[free]) < 0.03 * np.linalg.norm(
            difference[free]
        )


def same(energy, residual, expected, gradient):
    assert expected > 0
    assert energy == pytest.approx(expected, rel=1e-12)
    assert np.abs(residual - gradient.ravel()).max() < 1e-11 * np.abs(gradient).max()


@pytest.mark.parametrize("per_coil", [10, 24])
def test_contact_kernels_equal_their_twins(per_coil):
    mesh = small_mesh(per_coil)
    state, line = random_state(mesh, 5), mesh.contact
    arguments = (
        state.position,
        line.offset,
        line.upper_place,
        line.lower_place,
        line.distance,
        line.length,
    )
    energy, gradient, gaps = twin.contact(*arguments, 2e10)
    assert np.count_nonzero(gaps < 0) > 3
    found, residual = np.empty_like(line.length), np.zeros(6 * mesh.vertices)
    kern.contact_state(*arguments, found)
    assert np.array_equal(np.isfinite(found), np.isfinite(gaps))
    finite = np.isfinite(gaps)
    assert np.abs(found[finite] - gaps[finite]).max() < 1e-15
    none = np.empty(0, np.int64)
    got, used = kern.contact_terms(
        *arguments, 2e10, LINEAR, NO_NUMBERS, residual, none, none, np.empty(0)
    )
    assert used == 0
    same(got, residual, energy, gradient)
