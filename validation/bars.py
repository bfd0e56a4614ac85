"""Bars of bricks and a roller with friction against closed forms: patch, pull, bending, twist, a curved bar,
waves, rotation, order, energy, sliding and rolling.
"""

from __future__ import annotations

import numpy as np
import scipy.sparse as sparse
from numpy.typing import NDArray
from scipy.sparse.linalg import eigsh, spsolve

from validation.row import Row, book_case
from valvetrain.coil_contact.law import LINEAR, law_numbers
from valvetrain.continuum import contact_kernels as contact
from valvetrain.continuum import friction_kernels as friction
from valvetrain.continuum import time_kernels
from valvetrain.continuum.bricks import Bricks, sweep_bricks
from valvetrain.continuum.section import disc_section
from valvetrain.continuum.statics import SolidStatics
from valvetrain.continuum.transient import SolidDynamics, simulate_solid
from valvetrain.continuum.wire import SeatPlanes, SolidContactLaw, SolidWire
from valvetrain.parameters.curves import Constant
from valvetrain.parameters.material import OTEVA_90_SC as STEEL
from valvetrain.parameters.spring import SpringDefinition
from valvetrain.parameters.winding import OPEN_END

Array = NDArray[np.float64]
Integers = NDArray[np.int64]
#: Length and radius (m) of the straight bars.
LENGTH, RADIUS = 40e-3, 2e-3
#: Mass (kg), stations and stiffness on the plane (N/m) of a roller of that radius, weight over mass
#: (m/s2) that presses each section, and step (s).
MASS, STATIONS, STIFFNESS, PRESS, STEP = 2e-4, 4, 1e8, 1e4, 2e-7
NUMBERS = law_numbers(LINEAR)


def disc(core: int = 2, rings: int = 1) -> tuple[Array, Integers]:
    """Nodes (n, 2) and quadrilaterals (q, 4) of the unit disc."""
    section = disc_section(core, rings, quadratic=False)
    used, quads = np.unique(section.quads[:, :4], return_inverse=True)
    return section.nodes[used], quads.reshape(-1, 4)


def area_moments(core: int, rings: int) -> tuple[float, float]:
    """Second moments of the meshed unit section about one axis, over that of the disc, and its area
    over the disc's: what the polygon makes of the circle is known exactly.
    """
    nodes, quads = disc(core, rings)
    x, y = nodes[quads].transpose(2, 0, 1)
    x1, y1 = np.roll(x, -1, axis=1), np.roll(y, -1, axis=1)
    cross = x * y1 - x1 * y
    moment = float(np.sum(cross * (y * y + y * y1 + y1 * y1))) / 12
    return moment / (np.pi / 4), float(np.sum(cross)) / 2 / np.pi


def bar(
    length: float, radius: float, spans: int, core: int = 2, rings: int = 1, arc: float = 0.0
) -> tuple[Bricks, Array]:
    """Bricks of a round bar along z, or bent to an ``arc`` (rad) in the x-z plane of that length, and
    their positions (nodes, 3, stations).
    """
    nodes, quads = disc(core, rings)
    along = np.linspace(0.0, length, spans + 1)
    grid = np.zeros((spans + 1, len(nodes), 3))
    grid[:, :, 1] = radius * nodes[:, 1]
    if arc:
        middle = length / arc
        angle = along / middle
        reach = middle - radius * nodes[None, :, 0]
        grid[:, :, 0] = middle - reach * np.cos(angle)[:, None]
        grid[:, :, 2] = reach * np.sin(angle)[:, None]
    else:
        grid[:, :, 0] = radius * nodes[:, 0]
        grid[:, :, 2] = along[:, None]
    bricks = sweep_bricks(grid, quads, STEEL)
    return bricks, np.ascontiguousarray(grid.transpose(1, 2, 0))


def stiffness(bricks: Bricks, position: Array) -> sparse.csr_matrix:
    """Stiffness (N/m) of all nodes."""
    elements, places = bricks.tangent(position)
    rows, columns = np.repeat(places, 24, axis=1).ravel(), np.tile(places, (1, 24)).ravel()
    size = position.size
    return sparse.csr_matrix((elements.ravel(), (rows, columns)), shape=(size, size))


def reactions(bricks: Bricks, position: Array, moved: Array) -> Array:
    """Forces (nodes, 3) in N that move the last section by ``moved`` (nodes, 3) in m, the first being
    fixed: linear.
    """
    whole = stiffness(bricks, position)
    number = np.arange(position.size).reshape(position.shape)
    free, end = number[:, :, 1:-1].ravel(), number[:, :, -1].ravel()
    given = np.zeros(position.size)
    given[end] = moved.ravel()
    given[free] = spsolve(whole[free][:, free].tocsc(), -(whole @ given)[free])
    found: Array = (whole @ given)[end].reshape(-1, 3)
    return found


def frequencies(bricks: Bricks, position: Array, fixed: NDArray[np.bool_], count: int) -> Array:
    """The lowest natural frequencies (Hz) with the unknowns in the mask ``fixed`` held."""
    free = np.flatnonzero(~fixed.ravel())
    mass = np.repeat(bricks.mass[:, None, :], 3, axis=1).ravel()[free]
    inner = stiffness(bricks, position)[free][:, free]
    scale = sparse.diags(1 / np.sqrt(mass))
    found = eigsh((scale @ inner @ scale).tocsc(), k=count, sigma=0.0, return_eigenvectors=False)
    return np.sort(np.sqrt(np.maximum(found, 0.0))) / (2 * np.pi)


class Rolled:
    """A round bar along x on a plane, its sections rigid, and what friction has taken (J)."""

    def __init__(self) -> None:
        nodes, quads = disc()
        x, y = nodes[quads].transpose(2, 0, 1)
        area = np.sum(x * np.roll(y, -1, axis=1) - np.roll(x, -1, axis=1) * y, axis=1)
        self.weights = np.zeros(len(nodes))
        np.add.at(self.weights, quads, area[:, None] / area.sum() / 4)
        #: Moment of inertia over mass and radius squared.
        self.inertia = float(self.weights @ np.sum(nodes**2, axis=1))
        place = np.zeros((len(nodes), 3, STATIONS))
        place[:, 0] = 1e-3 * np.arange(STATIONS)
        place[:, 1:] = RADIUS * nodes[:, :, None]
        place[:, 2] += RADIUS - MASS * PRESS / STIFFNESS
        self.x, self.v = place.ravel(), np.zeros(place.size)
        self.planes = SeatPlanes(
            np.arange(STATIONS), np.ones(STATIONS), np.full(STATIONS, RADIUS), np.full(STATIONS, STIFFNESS),
            np.full(STATIONS, RADIUS), np.zeros(STATIONS), np.zeros((3, STATIONS)),
        )  # fmt: skip
        self.heat, self.stored = 0.0, 0.0

    def run(self, steps: int, coefficient: float, across: float = 0.0) -> tuple[float, float]:
        """Speed (m/s) across and that of its rim by the spin after steps under ``across`` (m/s2)."""
        n, size = STATIONS, 3 * STATIONS
        centre, rate, spin, inverse = (np.zeros(k * n) for k in (3, 3, 3, 6))
        mass = np.repeat(MASS * self.weights, n)
        work = np.zeros(time_kernels.SECTION_ROWS * time_kernels.STRIDE)
        for _ in range(steps):
            push, couple, force, totals = (
                np.zeros(size),
                np.zeros(size),
                np.zeros(self.x.size),
                np.zeros(2),
            )
            contact.section_centres(self.x, self.weights, n, centre)
            contact.section_centres(self.v, self.weights, n, rate)
            contact.plane_forces(centre, push, n, self.planes, 0.0, 0, NUMBERS.ctypes.data, totals)
            totals[:] = 0.0
            friction.section_spins(self.x, self.v, self.weights, n, centre, rate, inverse, spin)
            friction.rub_planes(rate, spin, push, couple, n, self.planes, coefficient, STEP, totals)
            push[n : 2 * n] += MASS * across
            push[2 * n :] -= MASS * PRESS
            self.heat, self.stored = self.heat + STEP * totals[1], totals[0]
            contact.spread_push(push, self.weights, n, force)
            friction.spread_couple(self.x, couple, inverse, self.weights, n, centre, force)
            time_kernels.accelerate(self.x, force, mass, work, len(self.weights), n, 0, n, np.inf)
            self.v += STEP * force
            self.x += STEP * self.v
        contact.section_centres(self.v, self.weights, n, rate)
        friction.section_spins(self.x, self.v, self.weights, n, centre, rate, inverse, spin)
        return float(rate[n]), float(-RADIUS * spin[0])


def thin_quarter(radius: float, inertia: float, section: float) -> float:
    """Stiffness (N/m) of a clamped quarter ring whose end is pushed along the clamp's tangent and does not
    turn, by bending, stretch and shear of a thin ring (second moment m4, area m2).
    """
    angle = np.linspace(0, np.pi / 2, 4001)
    # end loads: forces along x and z and a moment; compliance of the clamped quarter
    place = np.stack([radius * (1 - np.cos(angle)), radius * np.sin(angle)], axis=1)
    arm = np.stack([place[:, 1] - radius, radius - place[:, 0], np.ones_like(angle)], axis=1)
    tangent = np.stack([np.sin(angle), np.cos(angle), 0 * angle], axis=1)
    normal = np.stack([np.cos(angle), -np.sin(angle), 0 * angle], axis=1)
    rigidities = (
        (arm, STEEL.youngs_modulus * inertia),
        (tangent, STEEL.youngs_modulus * section),
        (normal, shear_share() * STEEL.shear_modulus * section),
    )
    compliance = sum(
        np.trapezoid(part[:, :, None] * part[:, None, :], angle, axis=0) * radius / rigidity
        for part, rigidity in rigidities
    )
    return float(np.linalg.solve(compliance, np.array([0.0, 1.0, 0.0]))[1])


def shear_share() -> float:
    """Cowper's share of the area of a round bar that bears shear."""
    ratio = STEEL.poisson_ratio
    return 6 * (1 + ratio) / (7 + 6 * ratio)


def _row(name: str, what: str, due: float, found: float, unit: str, within: float, why: str) -> Row:
    return Row("solids", f"bricks, {name}", "", what, due, found, unit, within, why)


@book_case()
def straight_and_curved_bars() -> list[Row]:
    """Pull, bending and twist of bars whose clamps keep sections plane; stiffness of a quarter ring."""
    one, nodes = 1e-6, RADIUS * disc(4, 2)[0]
    moment, area = area_moments(4, 2)
    inertia, section = moment * np.pi * RADIUS**4 / 4, area * np.pi * RADIUS**2
    pull, push, twist = np.zeros((3, len(nodes), 3))
    pull[:, 2], push[:, 0] = one, one
    twist[:, :2] = one / RADIUS * np.stack([-nodes[:, 1], nodes[:, 0]], axis=1)
    body, longer = (
        bar(LENGTH, RADIUS, 40, core=4, rings=2),
        bar(2 * LENGTH, RADIUS, 80, core=4, rings=2),
    )
    soft = [one / reactions(*which, pull)[:, 2].sum() for which in (body, longer)]
    stretch = STEEL.youngs_modulus * section / LENGTH
    bent = LENGTH**3 / (12 * STEEL.youngs_modulus * inertia)
    bent += LENGTH / (shear_share() * STEEL.shear_modulus * section)
    force = reactions(*body, twist)
    torque = float(np.sum(nodes[:, 0] * force[:, 1] - nodes[:, 1] * force[:, 0])) * RADIUS / one
    due = STEEL.shear_modulus * 2 * inertia / LENGTH
    what, clamps = "bar 4 x 40 mm, 48 bricks in the section, 40 along", "clamps keep sections round"
    rows = [
        _row("stiffness of a bar pulled", what, 1e-6 * stretch, 1e-6 / (soft[1] - soft[0]), "kN/mm", 1e-13 * stretch, "difference of two lengths"),
        _row("stiffness of a bar bent", what, 1e-3 / bent, 1e-3 * reactions(*body, push)[:, 0].sum() / one, "N/mm", 2e-5 / bent, clamps),
        _row("stiffness of a bar twisted", what, due, torque, "N m", 1e-3 * due, clamps),
    ]  # fmt: skip
    radius = 24 * RADIUS
    for per_turn, within in ((96, 0.045), (192, 0.025)):
        moved = np.zeros((len(nodes), 3))
        moved[:, 2] = one
        ring = bar(radius * np.pi / 2, RADIUS, per_turn // 4, core=4, rings=2, arc=np.pi / 2)
        found, due = (
            1e-3 * reactions(*ring, moved)[:, 2].sum() / one,
            1e-3 * thin_quarter(radius, inertia, section),
        )
        name, about = (
            f"stiffness of a quarter ring, {per_turn} slices a turn",
            "wire 4 mm, index 24, clamped",
        )
        why = "slices long over the radius are too stiff; clamps 1 %"
        rows.append(_row(name, about, due, found, "N/mm", within * due, why))

    def lateral(spans: int) -> float:
        own = bar(16 * RADIUS, RADIUS, spans, arc=np.pi / 2)
        moved = np.zeros((own[0].nodes, 3))
        moved[:, 0] = one
        return float(reactions(*own, moved)[:, 0].sum())

    coarse, middle, fine = lateral(6), lateral(12), lateral(24)
    what = "quarter ring of 6, 12 and 24 slices"
    order = float(np.log2((coarse - middle) / (middle - fine)))
    return [*rows, _row("order of convergence", what, 2.0, order, "1", 0.2, "three meshes")]


def torsional_speed(core: int, rings: int) -> float:
    """Speed (m/s) by the first torsional frequency of a bar held at one end, its axis straight."""
    bricks, free = bar(LENGTH, RADIUS, 40, core, rings)
    fixed = np.zeros(free.shape, dtype=bool)
    fixed[:, :, 0] = fixed[:, 2] = fixed[int(np.argmin(np.hypot(*disc(core, rings)[0].T)))] = True
    return float(4 * LENGTH * frequencies(bricks, free, fixed, 1)[0])


@book_case()
def waves_and_rotation() -> list[Row]:
    """Longitudinal and torsional waves of a bar, bricks in even strain, rigid rotation."""
    bricks, free = bar(LENGTH, RADIUS, 40)
    nodes, what = disc()[0], "bar 4 x 40 mm, one end held, 12 bricks in the section, 40 along"
    centre, side = int(np.argmin(np.hypot(*nodes.T))), int(np.argmax(nodes[:, 0]))
    fixed = np.zeros(free.shape, dtype=bool)
    fixed[:, 2, 0] = fixed[centre, :2] = fixed[side, 1] = True
    wave = np.pi / (2 * LENGTH)
    slow = np.sqrt(1 + (STEEL.poisson_ratio * wave * RADIUS) ** 2 / 2)
    bar_speed = np.sqrt(STEEL.youngs_modulus / STEEL.density) / slow
    found = 4 * LENGTH * frequencies(bricks, free, fixed, 1)[0]
    shear_speed = np.sqrt(STEEL.shear_modulus / STEEL.density)
    turning, fine = torsional_speed(2, 1), torsional_speed(8, 4)
    rng = np.random.default_rng(1)
    grid = free.transpose(2, 0, 1).copy()
    grid[1:-1] += 0.1 * RADIUS / 4 * rng.uniform(-1, 1, grid[1:-1].shape)
    rough, place = sweep_bricks(grid, disc()[1], STEEL), grid.transpose(1, 2, 0)
    gradient = np.eye(3) + 0.05 * rng.standard_normal((3, 3))
    force = rough.forces(np.einsum("ij,njs->nis", gradient, place))
    inner = np.hypot(*nodes.T) < 0.99
    patch = np.abs(force[inner][:, :, 1:-1]).max() / np.abs(force).max()
    axis, angle = np.cross(np.eye(3), [0.6, -0.48, 0.64]), 3.0
    turn = np.eye(3) - np.sin(angle) * axis + (1 - np.cos(angle)) * axis @ axis
    turned = rough.energy(np.einsum("ij,njs->nis", turn, place)) / rough.energy(1.001 * place)
    turned = float(np.sqrt(max(turned, 0.0)))
    return [
        _row("speed of longitudinal waves", what, bar_speed, found, "m/s", 2e-3 * bar_speed, "lumped masses"),
        Row(
            "solids", "bricks, speed of torsional waves", "", what, shear_speed, turning, "m/s", 0.01 * shear_speed, "masses at the nodes",
            band=(0.9 * shear_speed, 0.93 * shear_speed),
            explanation="masses at the nodes of 12 bricks have 17 % more polar inertia than the section; 192 bricks: the row below. "
            "Coils turn little about their wire: axial frequencies of helices agree within 0.03 % (rows above)",
        ),
        _row("speed of torsional waves, 192 bricks", "the same, 192 in the section", shear_speed, fine, "m/s", 0.01 * shear_speed, "nodal masses"),
        _row("patch test, force on inner nodes over the largest", "distorted bricks under even strain of 5 %", 0.0, patch, "1", 2e-12, "rounding"),
        _row("rotation, root of its energy over that of 0.1 % strain", "distorted bricks, 3 rad", 0.0, turned, "1", 2e-11, "rounding"),
    ]  # fmt: skip


@book_case()
def balance_of_energy() -> list[Row]:
    """A clamped helix in motion: work less energy stored and heat."""
    spring = SpringDefinition(
        Constant(3.8e-3),
        Constant(22e-3),
        Constant(7e-3),
        total_coils=5.0,
        material=STEEL,
        lower_end=OPEN_END,
        upper_end=OPEN_END,
    )
    statics = SolidStatics(SolidWire(spring, contact=SolidContactLaw(0.0)))
    made = simulate_solid(
        statics, statics.start(), lambda time: 2e-3 * (1 - np.cos(2e3 * time)), 2e-5, 100, SolidDynamics(40.0, 2e-6)
    )  # fmt: skip
    work = float(np.ptp(made.energy[:, time_kernels.WORK_DONE]))
    found, what = (
        float(np.abs(made.energy_gap).max()) / work,
        "wire 3.8, D 22, 5 turns, moved 4 mm, damped",
    )
    return [
        _row("gap of energy over work", what, 0.0, found, "1", 1e-5, "second order in the step")
    ]


@book_case()
def a_roller_that_slides() -> list[Row]:
    """A round bar thrown across itself on a plane with friction, until it rolls; one on a slope."""
    roller, speed, coefficient = Rolled(), 1.0, 0.2
    roller.v.reshape(-1, 3, STATIONS)[:, 1] = speed
    k = roller.inertia
    time = speed / (coefficient * PRESS * (1 + 1 / k))
    across, _ = roller.run(round(1.5 * time / STEP), coefficient)
    due, what = STATIONS * MASS * speed**2 / 2 * k / (1 + k), "bar of 4 mm, 1 m/s, mu 0.2"
    why, rows = "what sticks swings on its spring", list[Row]()
    for slope in (0.3, 1.2):
        bar_on_slope, rolls = Rolled(), slope < coefficient * (1 + 1 / k)
        found = bar_on_slope.run(1000, coefficient, slope * PRESS)[0] / (1000 * STEP * PRESS)
        goal = slope / (1 + k) if rolls else slope - coefficient
        name = f"acceleration on a slope over the weight across it, {'rolling' if rolls else 'sliding'}"
        rows.append(
            _row(name, f"bar of 4 mm, slope {slope:g}, mu 0.2", goal, found, "1", 0.02 * goal, why)
        )
    return [
        _row("speed at which a thrown roller rolls", what, speed / (1 + k), across, "m/s", 0.01, why),
        _row("heat of a thrown roller", what, 1e3 * due, 1e3 * roller.heat, "mJ", 0.2 * due, why),
        *rows,
    ]  # fmt: skip
