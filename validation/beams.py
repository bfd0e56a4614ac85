"""Geometrically exact beam benchmarks: 45-degree bend, roll-up, straight rod to helix, uniform
helix under large compression.
"""

from __future__ import annotations

import numpy as np

from validation.row import Row, book_case
from validation.wires import Array, Helix, mesh_wire, section, state_on, tube
from valvetrain.cosserat.mesh import RodMesh
from valvetrain.cosserat.state import free_state
from valvetrain.cosserat.static import Equilibrium, NewtonOptions, RodStatics, TipLoads

#: The wires of this file have lengths of 1 to 100 and loads of 1 to 1000 in units of their own.
TIGHT = NewtonOptions(tolerance=1e-7, iterations=60)
#: Turns of the helix that is squeezed.
TURNS = 5


def bend_tip(
    mesh: RodMesh, loads: TipLoads, steps: int = 10, options: NewtonOptions | None = None
) -> Equilibrium:
    """Equilibrium of a wire clamped at its first end under dead loads on its free last end, raised
    in even ``steps``.

    The last equilibrium reached is returned; ``converged`` is False when the path ended early.
    """
    state = free_state(mesh)
    for share in np.linspace(0.0, 1.0, steps + 1)[1:]:
        force, torque = (
            tuple(float(share * part) for part in vector) for vector in (loads.force, loads.torque)
        )
        result = RodStatics(mesh, 0.0, options, TipLoads(force, torque)).solve(state, 0.0)  # type: ignore[arg-type]
        if not result.converged:
            return result
        state = result.state
    return result


def _shoot(load: float) -> Array:
    """Tip displacement (3,) of the 45-degree bend by shooting on the rod's ordinary differential
    equations.
    """
    from scipy.integrate import solve_ivp
    from scipy.optimize import fsolve

    radius, bending, shear, tension = 100.0, 8.33333e5, 4.16667e6, 1e7
    start = np.concatenate([[radius, 0, 0], np.array([[1.0, 0, 0], [0, 0, 1], [0, -1, 0]]).ravel()])

    def rate(arc: float, y: Array, force: Array) -> Array:
        turn = y[3:12].reshape(3, 3)
        along = turn @ (turn.T @ force / [shear, shear, tension] + [0, 0, 1])
        k = turn.T @ y[12:] / bending - [0, 1 / radius, 0]
        spin = np.array([[0, -k[2], k[1]], [k[2], 0, -k[0]], [-k[1], k[0], 0]])
        return np.concatenate([along, (turn @ spin).ravel(), -np.cross(along, force)])

    def end(moment: Array, force: Array) -> Array:
        span = (0, radius * np.pi / 4)
        found = solve_ivp(
            rate,
            span,
            np.concatenate([start, moment]),
            args=(force,),
            method="DOP853",
            rtol=1e-9,
            atol=1e-9,
        )
        return np.asarray(found.y[:, -1])

    moment = np.zeros(3)
    for share in (0.25, 0.5, 0.75, 1.0):
        force = np.array([0, 0, share * load])
        moment = fsolve(lambda m, f=force: end(m, f)[12:] / load, moment)
    return end(moment, force)[:3] - radius * np.array([np.cos(np.pi / 4), np.sin(np.pi / 4), 0])


@book_case()
def bend_of_45_degrees() -> list[Row]:
    """Cantilever arc of 45 degrees, radius 100, under an end force of 600 out of its plane."""
    wire = section(4.16667e6, 1e7, 8.33333e5, 8.33333e5)
    mesh = mesh_wire(Helix(100.0, 0.0, wire), 100 * np.pi / 4, 64)
    result = bend_tip(mesh, TipLoads((0.0, 0.0, 600.0)), 12, NewtonOptions(tolerance=1e-4))
    moved, exact = result.state.position[-1] - mesh.position[-1], _shoot(600.0)
    about, rows = "R 100, section 1 x 1, E 1e7, nu 0, force 600, 64 elements", []
    for axis, name, printed in (
        (0, "radial", 13.4),
        (1, "tangential", -23.5),
        (2, "out of plane", 53.4),
    ):
        value = float(moved[axis])
        rows.append(
            Row(
                "beams",
                f"45-degree bend, tip {name}",
                "bathe1979",
                about,
                printed,
                value,
                "in",
                0.3,
                "the source's beam elements; later codes are up to 0.3 in from it",
                "published",
            )
        )
        rows.append(
            Row(
                "beams",
                f"45-degree bend, tip {name}, differential equations",
                "simo1985",
                about,
                float(exact[axis]),
                value,
                "in",
                0.02,
                "second order: 0.0090 in at 64 elements",
                "independent computation",
            )
        )
    return rows


@book_case()
def roll_up_to_a_circle() -> list[Row]:
    """An end moment 2 pi E I / L rolls a straight cantilever up to a full circle: equilibrium of
    the free tip next to the closed circle.
    """
    length, bending = 1.0, 2.0
    wire = tube(bending, bending, length)
    mesh = mesh_wire(Helix(0.0, 0.0, wire), length, 48)
    circle = Helix(length / (2 * np.pi), 0.0, wire)
    start = state_on(circle, mesh)
    # The arc starts at (R, 0, 0) along y and turns about z: moment along z; the clamp is that of
    # the arc.
    statics = RodStatics(
        mesh,
        0.0,
        NewtonOptions(tolerance=1e-5),
        TipLoads(torque=(0.0, 0.0, 2 * np.pi * bending / length)),
    )
    result = statics.solve(start, 0.0)
    place = result.state.position
    gap = float(np.linalg.norm(place[-1] - place[0])) if result.converged else float("nan")
    return [
        Row(
            "beams",
            "roll-up, gap of the closed circle",
            "simo1985",
            "moment 2 pi E I / L, 48 elements",
            0.0,
            gap,
            "L",
            3e-3,
            "second order: (2 pi / 48)^2 / 6 of the length",
        ),
        Row(
            "beams",
            "roll-up, diameter of the circle",
            "simo1985",
            "as above",
            1 / np.pi,
            float(np.ptp(place[:, 0])),
            "L",
            1e-3,
            "second order: (2 pi / 48)^2 / 6 of the diameter",
        ),
    ]


def _bent(
    free: Helix, bent: Helix, length: float, elements: int
) -> tuple[RodMesh, Equilibrium, float]:
    """Mesh, equilibrium near the bent helix with ends fixed there, and the axial torque (N m) at
    the last end.
    """
    mesh = mesh_wire(free, length, elements)
    statics = RodStatics(mesh, options=TIGHT)
    result = statics.solve(state_on(bent, mesh), 0.0)
    residual = statics.assemble(result.state, False)[1].reshape(-1, 6)
    from valvetrain.cosserat import quaternion as quat

    turn = quat.to_matrix(result.state.frame[-1:])[0] @ residual[mesh.last, 3:]
    arm = np.cross(result.state.position[-1], residual[mesh.last, :3])
    return mesh, result, float(turn[2] + arm[2])


def love_wrench(free: Helix, bent: Helix) -> tuple[float, float]:
    """Axial force (N, tensile positive) and torque (N m) of a uniform helix bent to another (Love
    1927, article 271).
    """

    def shape(helix: Helix) -> tuple[float, float]:
        if not helix.radius:
            return 0.0, 0.0
        return np.cos(helix.lead_angle) ** 2 / helix.radius, np.sin(helix.lead_angle) * np.cos(
            helix.lead_angle
        ) / helix.radius

    (k0, t0), (k, t) = shape(free), shape(bent)
    a, radius, bending, torsion = (
        bent.lead_angle,
        bent.radius,
        float(bent.wire.bending[0]),
        float(bent.wire.torsion[0]),
    )
    force = torsion * np.cos(a) / radius * (t - t0) - bending * np.sin(a) / radius * (k - k0)
    return float(force), float(torsion * np.sin(a) * (t - t0) + bending * np.cos(a) * (k - k0))


@book_case()
def straight_rod_to_helix() -> list[Row]:
    """A straight wire bent to a helix of three turns: end force and torque of Kirchhoff's helical
    equilibrium.
    """
    length = 3 * 2 * np.pi / np.cos(0.4)
    wire = tube(1.0, 1.6, length)
    free, bent = Helix(0.0, 0.0, wire), Helix(1.0, 0.4, wire)
    _, result, torque = _bent(free, bent, length, 144)
    force, couple = love_wrench(free, bent)
    about = "E I 1, G J 1.6, radius 1, lead angle 0.4, 48 elements per turn"
    return [
        Row(
            "beams",
            "straight rod to helix, axial force",
            "love1927",
            about,
            force,
            -result.retainer_force,
            "N",
            0.005 * abs(force),
            "second order: (pi / 48)^2",
        ),
        Row(
            "beams",
            "straight rod to helix, axial torque",
            "love1927",
            about,
            couple,
            torque,
            "N m",
            0.005 * abs(couple),
            "second order: (pi / 48)^2",
        ),
    ]


@book_case()
def helix_under_large_compression() -> list[Row]:
    """Uniform helix of lead angle 0.25 squeezed to 0.05: Love's force without end rotation, and his
    lead angle with free rotation.
    """
    from scipy.optimize import brentq

    lead, rows = 0.25, []
    free = Helix(1.0, lead, tube(1.0, 0.77, TURNS * 2 * np.pi / np.cos(lead)))
    for pressed in (0.15, 0.05):
        held = Helix(np.cos(pressed) / np.cos(lead), pressed, free.wire)
        torque = love_wrench(free, held)[1]
        rows += _love_rows(
            "no end rotation",
            free,
            held,
            torque,
            0.01 * abs(torque),
            "second order; the torque is a small difference",
        )
        radius = brentq(lambda r, a=pressed: love_wrench(free, Helix(r, a, free.wire))[1], 0.8, 1.3)
        rows += _love_rows(
            "free end rotation",
            free,
            Helix(radius, pressed, free.wire),
            0.0,
            0.002,
            "0.2 % of E I over the radius",
        )
    return rows


def _love_rows(
    ends: str, free: Helix, bent: Helix, torque: float, tolerance: float, reason: str
) -> list[Row]:
    """Force and torque that hold ``free`` bent to another helix of the same wire; ``tolerance`` (N
    m) of the torque.
    """
    force = love_wrench(free, bent)[0]
    _, result, found = _bent(free, bent, TURNS * 2 * np.pi / np.cos(free.lead_angle), 48 * TURNS)
    about, case = (
        "E I 1, G J 0.77, five turns of radius 1, 48 elements per turn",
        f"lead angle {bent.lead_angle}",
    )
    limit, why, computed = 0.003 * abs(force), "second order: (pi / 48)^2", -result.retainer_force
    return [
        Row(
            "beams",
            f"Love's helix, {ends}, force at {case}",
            "love1927",
            about,
            force,
            computed,
            "N",
            limit,
            why,
        ),
        Row(
            "beams",
            f"Love's helix, {ends}, torque at {case}",
            "love1927",
            about,
            torque,
            found,
            "N m",
            tolerance,
            reason,
        ),
    ]
