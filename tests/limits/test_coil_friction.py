"""Friction between coils of the rod: Coulomb's law, balance of forces and moments, and the energy of a run."""

from __future__ import annotations

import numpy as np
import pytest

import valvetrain as vt
from valvetrain.cosserat import quaternion as quat
from valvetrain.cosserat.buffer import fill_buffer, stepping_numbers
from valvetrain.cosserat.coil_friction import rub_coils
from valvetrain.cosserat.layout import GROUP, ROW, row
from valvetrain.cosserat.time_stepping import STRETCHES, all_contact, section_forces, watch_contacts
from valvetrain.springs.finite_element import FiniteElementRod

COEFFICIENT, STEP = 0.15, 1e-16


def rows(buffer, names: str, count: int) -> np.ndarray:
    return np.stack([row(buffer, name, count) for name in names.split()], axis=1).copy()


@pytest.mark.parametrize("elements", [24, 8])
def test_friction_opposes_sliding_by_coulombs_law_and_leaves_all_momentum(elements):
    """Closed form. Random motion of a compressed beehive whose lower coils touch, with one contact point an
    element and, on the coarse mesh, two: forces and moments of friction sum to zero, its power is the loss,
    and no point is pushed by more than coefficient times normal force."""
    spring = vt.load_case("gu2021-beehive").springs[0].wire
    rod = FiniteElementRod(spring, 12e-3, elements)
    mesh, dynamics = rod.mesh, rod.dynamics
    buffer = fill_buffer(mesh, rod.installed.state, dynamics, 1e-9)
    integers, numbers, places = stepping_numbers(mesh, dynamics, 1e-9)
    random = np.random.default_rng(1)
    count = mesh.vertices
    for names, size, scale in (("VX VY VZ", count, 1.0), ("W1 W2 W3", count + 1, 200.0)):
        for name in names.split():
            row(buffer, name, size)[:] = scale * random.standard_normal(size)
    stretches = np.zeros((STRETCHES, 2))
    watched = watch_contacts(buffer, integers, 1e-4, stretches)
    first, last = np.uint64(0), np.uint64(count)
    all_contact(buffer, integers, numbers, places, stretches, watched, first, last)
    section_forces(buffer, np.uint64(mesh.first + 1), np.uint64(mesh.last + 1))
    normal = [
        np.linalg.norm([buffer[int(ROW[n] + g * GROUP) :][:count] for n in ("PX", "PY", "PZ")], axis=0)
        for g in (np.uint64(0), np.uint64(1))
    ]  # fmt: skip
    pressed = sum(float(one.sum()) for one in normal)
    assert pressed > 50.0
    force, torque = rows(buffer, "CX CY CZ", count), rows(buffer, "T1 T2 T3", count + 1)
    lost = rows(buffer, "LOSS LOSSb", count).sum()
    offset, groups = np.uint64(mesh.contact.offset), mesh.contact.groups
    rub_coils(buffer, COEFFICIENT, STEP, offset, groups, places, stretches, watched)

    force = rows(buffer, "CX CY CZ", count) - force
    turned = rows(buffer, "T1 T2 T3", count + 1) - torque
    turned /= row(buffer, "INVH", count + 1)[:, None]
    frame = rows(buffer, "Q0 Q1 Q2 Q3", count + 1)
    space = (quat.to_matrix(frame) @ turned[:, :, None])[:, :, 0]
    assert (
        0.2 * COEFFICIENT * pressed
        < np.linalg.norm(force, axis=1).sum()
        < 2 * COEFFICIENT * pressed
    )
    assert np.abs(force.sum(axis=0)).max() < 1e-12 * pressed
    position = rows(buffer, "X Y Z", count)
    moment = np.cross(position, force).sum(axis=0) + space.sum(axis=0)
    assert np.abs(moment).max() < 1e-12 * pressed
    velocity, spin = rows(buffer, "VX VY VZ", count), rows(buffer, "W1 W2 W3", count + 1)
    power = float(np.sum(velocity * force) + np.sum(spin * turned))
    lost = (rows(buffer, "LOSS LOSSb", count).sum() - lost) / STEP
    assert power == pytest.approx(-lost, rel=1e-6)


def imbalance(coefficient: float, time_step: float | None = None) -> float:
    """Energy imbalance of the 8000 rpm run with clash."""
    case = vt.load_case("gu2021-beehive")
    options = {"elements_per_coil": 12, "coil_friction": coefficient, "time_step": time_step}
    case = case.replace(springs=(case.springs[0].with_options("finite-element", **options),))
    study = vt.simulate(case, "8000 rpm", models=["finite-element"], workers=1)
    return float(study.solutions[0].quantities["energy_imbalance_ratio"])


def test_energy_of_a_run_with_friction_between_coils_closes():
    """Limit: work of the retainer less what is stored is what dampers, contact and friction took; what is
    left of a large friction falls with the step."""
    assert imbalance(0.1) < 1e-3
    assert imbalance(0.3, 0.3e-6) < 0.5 * imbalance(0.3)
