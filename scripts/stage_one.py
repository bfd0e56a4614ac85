"""Why the rod's Stage I is small: every experiment of
docs/decisions/0077-why-stage-one-is-small.md, its tables and its pictures.

python scripts/stage_one.py            # some four minutes of processor time; prints the tables,
draws docs/pictures/stage-one-*.svg
"""

from __future__ import annotations

import sys
import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from stage_one_parts import (
    CASE,
    EVENT,
    LAW,
    SPEEDS,
    SPRING,
    WIRE,
    LinearPieces,
    Scaled,
    damped,
    linear_force,
    polydyne,
    rod_of,
    slide_work,
    tilted_modes,
    tuned,
    vibration,
    with_clearance,
    with_coils,
    with_kink,
)

import valvetrain as vt
from valvetrain.cam.contract import LiftLaw
from valvetrain.cosserat.modes import natural_modes
from valvetrain.cosserat.rates import axial_rate
from valvetrain.cosserat.static import compress
from valvetrain.integrate.contract import Cycles, Integrator, RunOptions
from valvetrain.integrate.hht import HilberHughesTaylor
from valvetrain.integrate.run import run
from valvetrain.parameters.spring import EndCoil
from valvetrain.quantities.cycle import reported_cycle
from valvetrain.registry import find
from valvetrain.report import theme
from valvetrain.solution.provenance import Provenance
from valvetrain.solution.result import Solution
from valvetrain.sources.gu2021_collisions import separation_angle
from valvetrain.sources.gu2021_stages import stage_quantities
from valvetrain.springs.finite_element import FiniteElementRod
from valvetrain.system.prescribed import PrescribedSpring

Array = NDArray[np.float64]
PICTURES = Path(__file__).resolve().parents[1] / "docs" / "pictures"
BLUE, ORANGE, GREEN, VIOLET = theme.SERIES[:4]
#: Frequencies (Hz) tried for the first mode's share of the seat force, and the angle (deg) up to
#: which the retainer stands still.
TRIED, STILL = np.arange(480.0, 960.0, 5.0), 90.0


@dataclass(frozen=True)
class Reading:
    """One run: least and largest force of Stage I (N), the sine in it while the retainer stands
    still (N) and its frequency (Hz), the
    valley of Stage II (N; deg) where it has two maxima, the largest force of Stage III at any
    instant (N)."""

    least: float
    largest: float
    first_mode: float
    frequency: float
    valley: float
    valley_angle: float
    spike: float

    @property
    def stage_1(self) -> float:
        """Range of the seat force (N) in Stage I."""
        return self.largest - self.least


def sine_in(time_: Array, force: Array) -> tuple[float, float]:
    """Peak-to-peak (N) and frequency (Hz) of the sine that leaves the least of a force at rest."""
    best = (np.inf, 0.0, 0.0)
    for frequency in TRIED:
        phase = 2 * np.pi * frequency * (time_ - time_[0])
        matrix = np.stack([np.ones_like(phase), np.cos(phase), np.sin(phase)], axis=1)
        found = np.linalg.lstsq(matrix, force, rcond=None)[0]
        best = min(
            best,
            (
                float(np.sum((matrix @ found - force) ** 2)),
                2 * float(np.hypot(found[1], found[2])),
                float(frequency),
            ),
        )
    return best[1], best[2]


def read(solution: Solution) -> Reading:
    """The numbers of a run, by the study's own quantities."""
    assert solution.status.completed, solution.status.sentence()
    cycle = reported_cycle(solution)
    told = stage_quantities(cycle, separation_angle(cycle, 630.0), EVENT)
    still = np.degrees(cycle.cam_angle) <= STILL
    first_mode, frequency = sine_in(cycle.time[still], cycle.channel("seat_force")[still])
    valley, angle = (told.get(f"stage_2_valley_{word}", np.nan) for word in ("force", "cam_angle"))
    spike = told.get("stage_3_every_instant_peak_force", told["stage_3_peak_force"])
    return Reading(
        told["stage_1_minimum_force"],
        told["stage_1_maximum_force"],
        first_mode,
        frequency,
        valley,
        float(np.degrees(angle)),
        spike,
    )


def moved(spring: FiniteElementRod, rpm: float, law: LiftLaw = LAW, cycles: int = 2) -> Solution:
    """A run of the rod by its end forces."""
    return run(
        PrescribedSpring((spring,), law), rpm * np.pi / 60, Cycles(cycles), RunOptions(keep="ends")
    )


@dataclass(frozen=True)
class Change:
    """One experiment: ``words``, the rod, and what moves it."""

    words: str
    spring: Callable[[], FiniteElementRod]
    law: LiftLaw = LAW
    cycles: int = 2

    def readings(self) -> tuple[FiniteElementRod, list[Reading]]:
        spring = self.spring()
        return spring, [read(moved(spring, rpm, self.law, self.cycles)) for rpm in SPEEDS]


def cluster(frequencies: Array, shares: Array) -> str:
    """Modes of the first cluster that carry a twentieth or more: frequency and transmission."""
    near = (frequencies > 450) & (frequencies < 850) & (np.abs(shares) > 0.05)
    return ", ".join(
        f"{f:.0f}: {t:.2f}" for f, t in zip(frequencies[near], shares[near], strict=True)
    )


def cells(readings: Sequence[Reading]) -> list[str]:
    """Cells of a table: Stage I (first mode) at each speed, the valley at the highest, spikes."""
    last = readings[-1]
    valley = "-" if np.isnan(last.valley) else f"{last.valley:.0f} at {last.valley_angle:.0f}"
    return [
        *(f"{one.stage_1:.1f} ({one.first_mode:.0f})" for one in readings),
        valley,
        *(f"{one.spike:.0f}" for one in readings),
    ]


HEAD = [
    "preload, N", "modes, Hz: transmission", *(f"Stage I {rpm}" for rpm in SPEEDS), f"valley {SPEEDS[-1]}, at deg",
    *(f"spike {rpm}" for rpm in SPEEDS),
]  # fmt: skip


def table(first: str, head: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    """A table of the page."""
    lines = [f"| {first} | {' | '.join(head)} |", "|---" * (len(head) + 1) + "|"]
    return "\n".join([*lines, *(f"| {' | '.join(row)} |" for row in rows)])


def row_of(change: Change) -> list[str]:
    """A row of the table."""
    spring, readings = change.readings()
    modes = natural_modes(spring.statics, spring.installed.state, 24)
    near = cluster(modes.natural_frequency, modes.axial_transmission)
    return [change.words, f"{spring.installed.retainer_force:.1f}", near, *cells(readings)]


SHIPPED = Change("shipped", rod_of)


def ends(
    lower: float | None, upper: float | None, bonded_lower: float | None = None
) -> Callable[[], FiniteElementRod]:
    """The rod with other inactive turns; ``bonded_lower``: only so many of the ground lower turns
    are bonded, the rest lie on the seat.
    """
    own = WIRE.lower_end.inactive_coils, WIRE.upper_end.inactive_coils
    low, high = own[0] if lower is None else lower, own[1] if upper is None else upper
    return lambda: rod_of(
        WIRE.replace(
            lower_end=EndCoil("closed-ground", bonded_lower or low, low),
            upper_end=EndCoil("closed-ground", high, high),
        )
    )


def experiments() -> Iterator[tuple[str, list[Change]]]:
    """The changes, a table each."""
    yield (
        "a. Total coils, tuned (end phase)",
        [
            Change(f"{7 + more:.1f} coils", lambda more=more: tuned(with_coils(WIRE, 7 + more)))
            for more in (-0.5, -0.3, -0.1, 0.1, 0.3, 0.5)
        ],
    )
    yield (
        "b. Clearance at coils 1 and 2, tuned",
        [
            Change(f"{1e3 * more:+.1f} mm", lambda more=more: tuned(with_clearance(WIRE, more)))
            for more in 1e-3 * np.array([-0.2, -0.1, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6])
        ],
    )
    yield (
        "Pitch at one place",
        [
            Change(
                f"pitch {more:+.1f} mm at coil {coil:g}",
                lambda coil=coil, more=more: rod_of(with_kink(WIRE, coil, 1e-3 * more)),
            )
            for coil, more in ((1.5, -0.2), (1.5, 0.2), (2.3, -0.2), (2.3, 0.2))
        ],
    )
    yield (
        "c. Retainer and d. end faces",
        [
            Change(
                "retainer free to turn at rest", lambda: replace(rod_of(), retainer_rotation="free")
            ),
            Change("clamps, no seat planes", lambda: rod_of(seats="clamps")),
            Change(
                "lower end bonded over 0.5 of its 0.851 turns, the rest lies on the seat",
                ends(None, None, 0.5),
            ),
            Change("lower end bonded over 0.3 turns", ends(None, None, 0.3)),
        ],
    )
    yield (
        "e. Inactive turns",
        [
            *(
                Change(f"lower {turns:.2f}", ends(turns, None))
                for turns in (0.70, 0.75, 0.80, 0.90, 1.00)
            ),
            *(
                Change(f"upper {turns:.2f}", ends(None, turns))
                for turns in (0.70, 0.80, 0.90, 1.00)
            ),
        ],
    )
    yield (
        "f. Damping and contact",
        [
            *(
                Change(f"damping ratio {x}", lambda x=x: rod_of(dynamics=damped(ratio=x)))
                for x in (0.0, 0.004, 0.008, 0.03)
            ),
            *(
                Change(
                    f"stiffness share {x}", lambda x=x: rod_of(dynamics=damped(stiffness_share=x))
                )
                for x in (0.0, 0.4, 1.0)
            ),
            *(
                Change(
                    f"contact {x / 1e9:g}e9 N/m per m",
                    lambda x=x: rod_of(dynamics=damped(contact_stiffness=x)),
                )
                for x in (2.5e9, 1e10, 4e10)
            ),
            *(
                Change(
                    f"contact damping {x:g} us",
                    lambda x=x: rod_of(dynamics=damped(contact_damping_time=1e-6 * x)),
                )
                for x in (0.0, 10.0)
            ),
        ],
    )
    yield (
        "h. Lift",
        [
            Change("straight over 5 degrees", rod_of, LinearPieces(LAW, 5.0)),
            Change("straight over 1 degree", rod_of, LinearPieces(LAW, 1.0)),
            Change("polydyne 2-10-18-26-34, 9.33 mm, 115 to 245 deg", rod_of, polydyne()),
            Change(
                "the same, clearance +0.4 mm",
                lambda: tuned(with_clearance(WIRE, 0.4e-3)),
                polydyne(),
            ),
        ],
    )
    yield (
        "Cycles and mesh",
        [
            *(Change(f"{count} cam turns from rest", rod_of, LAW, count) for count in (3, 6)),
            *(Change(f"{n} elements per coil", lambda n=n: rod_of(elements=n)) for n in (12, 48)),
        ],
    )


def ladder() -> str:
    """Stage I from the ideal spring down to the rod, two cam turns from rest."""
    spring = rod_of()
    modes = natural_modes(spring.statics, spring.installed.state, 24)
    rate, strongest = modes.axial_stiffness, int(modes.axial_modes(1)[0])
    frequency, share = modes.natural_frequency, modes.axial_transmission
    kept = {
        "one ideal mode (transmission 1)": ((strongest,), (1.0,)),
        "the rod's own modes, linear": (range(24), share),
    }
    rows = []
    for words, (which, shares) in kept.items():
        found = []
        for rpm in SPEEDS:
            angle, force = linear_force(frequency[list(which)], np.asarray(shares), rate, LAW, rpm)
            still = angle <= STILL
            at = np.radians(angle[still]) / (rpm * np.pi / 60)
            found.append(f"{np.ptp(force[angle <= 127]):.1f} ({sine_in(at, force[still])[0]:.0f})")
        rows.append([words, *found])
    for model in ("wave-rod", "wave-rod-clash", "multi-mass", "finite-element"):
        readings = [read(one) for one in vt.simulate(CASE, spring_models=[model]).solutions]
        rows.append(
            [
                theme.model_words(model),
                *(f"{one.stage_1:.1f} ({one.first_mode:.0f})" for one in readings),
            ]
        )
    rows.append(
        ["modal model as published, settled", *(f"{one:.1f}" for one in settled_modal(LAW))]
    )
    rows.append(
        [
            "the same, lift straight over 5 degrees",
            *(f"{one:.1f}" for one in settled_modal(LinearPieces(LAW, 5.0))),
        ]
    )
    return table("Stage I, N (first mode)", [f"{rpm} rpm" for rpm in SPEEDS], rows)


def settled_modal(law: LiftLaw) -> list[float]:
    """Stage I range (N) of the modal model with varied stiffness at each speed."""
    rest = vt.simulate(CASE, "4200 rpm", spring_models=["modal-varied"]).rest[0]
    assert rest.curve is not None and rest.modes is not None
    model = vt.ModalVaried(
        tuple(rest.modes.axial_frequencies),
        0.016,
        tuple(rest.curve.compression),
        tuple(rest.curve.force),
        SPRING.precompression,
    )
    found = [model.solve(law.lift, rpm * np.pi / 60, 7200) for rpm in SPEEDS]
    return [
        float(np.ptp(one.seat_force_as_printed[np.degrees(one.cam_angle) <= 127])) for one in found
    ]


#: Groups of modes of the energy books: name, lowest and highest frequency (Hz).
GROUPS = (
    ("surge (595, 629 Hz)", 0.0, 650.0),
    ("sway (711, 731 Hz)", 650.0, 800.0),
    ("20 modes above", 800.0, np.inf),
)


def books() -> str:
    """Energy (mJ) of the modes when the valve has closed and a third of a turn later, and what was
    lost before and between.
    """
    rows = []
    for rpm in SPEEDS:
        for words, law in (("linear (lift times 0.001)", Scaled(LAW, 1e-3)), ("rod", LAW)):
            told = vibration(rod_of(), rpm, law)
            event, closed, later = (
                int(np.argmin(np.abs(told.angle - place))) for place in (127.0, 271.0, 360.0)
            )
            row = [f"{rpm} rpm, {words}"]
            for first, last in ((event, closed), (closed, later)):
                row += [
                    f"{1e3 * (series[last] - series[first]):.2f}"
                    for series in (told.wire_loss, told.contact_loss)
                ]
                row += [f"{told.share(last, low, high):.2f}" for _, low, high in GROUPS]
            rows.append(row)
    names = [name for name, _, _ in GROUPS]
    head = [
        "lost in the wire, 127 to 271 deg",
        "in contact",
        *(f"at 271: {name}" for name in names),
        "lost in the wire, 271 to 360 deg",
        "in contact",
    ]
    return table("mJ", [*head, *(f"at 360: {name}" for name in names)], rows)


def energies() -> str:
    """Energy above rest (mJ) of the chain and of the rod in the second turn: the rod's sway costs
    little of it.
    """
    rows = []
    for model in ("multi-mass", "finite-element"):
        for run_ in vt.simulate(CASE, spring_models=[model]).solutions:
            cycle = reported_cycle(run_)
            total = sum(
                cycle.channel(f"{name}_energy") for name in ("kinetic", "elastic", "contact")
            )
            angle, lost, work = (
                np.degrees(cycle.cam_angle),
                cycle.channel("energy_dissipated"),
                cycle.channel("work_done"),
            )
            event, closed, later = (
                int(np.argmin(np.abs(angle - place))) for place in (127.0, 271.0, 359.5)
            )
            row = [f"{theme.model_words(model)}, {round(run_.engine_speed * 30 / np.pi)} rpm"]
            row += [f"{1e3 * (series[closed] - series[event]):.1f}" for series in (work, lost)]
            rows.append(
                [*row, *(f"{1e3 * (total[at] - at_rest(model)):.2f}" for at in (closed, later))]
            )
    return table(
        "mJ",
        [
            "work of the retainer, 127 to 271 deg",
            "lost, 127 to 271 deg",
            "vibrating at 271 deg",
            "at 359.5 deg",
        ],
        rows,
    )


def at_rest(model: str) -> float:
    """Energy (J) of the installed spring at rest."""
    problem = vt.build(CASE)
    spring = problem.model_of(model, problem.springs[0])
    told = spring.energy(spring.initial_state(0.0), 0.0)
    return told.elastic + told.contact


#: Springs whose force curves are compared: words, clearance of coils 1 and 2 more by (mm), colour.
CURVES = (
    ("shipped", 0.0, BLUE),
    ("clearance -0.1 mm", -0.1, VIOLET),
    ("clearance +0.3 mm", 0.3, ORANGE),
    ("clearance +0.6 mm", 0.6, GREEN),
)


def rates(spring: FiniteElementRod) -> tuple[Array, Array]:
    """Compression (mm) and tangent rate (N/mm), touching coils as they are."""
    reach = np.arange(3.0, 12.01, 0.05)
    path = compress(spring.statics, (1e-3 * reach).tolist())
    return reach, 1e-3 * np.array([axial_rate(spring.statics, one.state) for one in path])


def corners() -> str:
    """The two steepest rises of the rate within 0.1 mm, and Stage I of the same spring."""
    rows = []
    for words, more, _ in CURVES:
        spring = tuned(with_clearance(WIRE, 1e-3 * more)) if more else rod_of()
        reach, rate = rates(spring)
        rise, row = rate[2:] - rate[:-2], [words]
        top = int(np.argmax(np.where(reach[2:] < 11.5, rise, 0.0)))
        away = np.abs(reach - reach[top])[:-2] > 0.8
        for at in sorted((top, int(np.argmax(np.where(away & (reach[2:] < 11.5), rise, 0.0))))):
            row.append(f"{reach[at + 1]:.2f} mm: {rate[at]:.1f} to {rate[at + 2]:.1f}")
        readings = [read(moved(spring, rpm)) for rpm in SPEEDS]
        rows.append(
            [
                *row,
                *(
                    f"{one.least:.0f} to {one.largest:.0f} ({one.first_mode:.0f})"
                    for one in readings
                ),
            ]
        )
    return table(
        "spring",
        ["first corner, N/mm", "second corner, N/mm", *(f"Stage I {rpm}" for rpm in SPEEDS)],
        rows,
    )


def corner(spring: FiniteElementRod) -> float:
    """Compression (mm) before the steepest rise of the rate within 1 mm of the installed one, on a
    grid of 0.05 mm.
    """
    reach, rate = rates(spring)
    rise = np.where(
        np.abs(reach - 1e3 * SPRING.precompression) < 1, np.append(np.diff(rate), 0.0), 0.0
    )
    return float(reach[np.argmax(rise)])


def kinks() -> str:
    """Where a pitch changed at one place puts the corner."""
    kinked = {
        f"pitch {more:+.1f} mm at coil {coil:g}": with_kink(WIRE, coil, 1e-3 * more)
        for coil in (1.5, 2.3)
        for more in (-0.2, 0.2)
    }
    return table(
        "spring",
        ["corner, mm"],
        [
            [words, f"{corner(rod_of(wire)):.2f}"]
            for words, wire in ({"shipped": WIRE} | kinked).items()
        ],
    )


def ramp() -> str:
    """Seat force above the preload (N) that the lift's ramp gives the spring at rest."""
    spring, angles = rod_of(), (120.0, 127.0)
    path = compress(
        spring.statics,
        [SPRING.precompression + float(LAW.lift(np.radians(angle))) for angle in angles],
    )
    return table(
        "at rest",
        [f"at {angle:g} deg, N" for angle in angles],
        [["shipped", *(f"{one.seat_force - spring.installed.seat_force:.1f}" for one in path)]],
    )


#: Compressions (mm) at which the shipped spring is installed, to move nothing but its distance from
#: the corner.
INSTALLED = (5.5, 6.0, 6.5, 6.75, 7.0, 7.25, 7.5, 7.75, 8.0, 8.5)


def installed_at(compression: float) -> tuple[FiniteElementRod, list[float]]:
    """The shipped wire installed at a compression (mm), and the first mode in Stage I (N) at each
    speed by linear theory about that.
    """
    spring = FiniteElementRod(WIRE, 1e-3 * compression, 24, damped())
    modes, found = natural_modes(spring.statics, spring.installed.state, 24), []
    for rpm in SPEEDS:
        angle, force = linear_force(
            modes.natural_frequency, modes.axial_transmission, modes.axial_stiffness, LAW, rpm
        )
        still = angle <= STILL
        found.append(sine_in(np.radians(angle[still]) / (rpm * np.pi / 60), force[still])[0])
    return spring, found


def installed() -> str:
    """Stage I of the shipped wire over the compression at which it is installed, beside linear
    theory of the same.
    """
    rows = []
    for compression in INSTALLED:
        spring, linear = installed_at(compression)
        row = [f"{compression:g} mm", *row_of(Change("", lambda spring=spring: spring))[1:6]]
        readings = [read(moved(spring, rpm)).first_mode for rpm in SPEEDS]
        rows.append(
            [
                *row,
                *(
                    f"{100 * one / line:.0f} % of {line:.0f} N"
                    for one, line in zip(readings[1:], linear[1:], strict=True)
                ),
            ]
        )
    return table(
        "installed at", [*HEAD[:5], *(f"first mode {rpm} of linear" for rpm in SPEEDS[1:])], rows
    )


def linearity() -> str:
    """Stage I over the share of the lift that makes it."""
    rows = []
    for share in (0.001, 0.01, 0.05, 0.1, 0.2, 0.4, 0.6, 0.8, 1.0):
        readings = [read(moved(rod_of(), rpm, Scaled(LAW, share))) for rpm in SPEEDS]
        rows.append(
            [
                f"{share:g}",
                *(f"{one.stage_1 / share:.1f} ({one.first_mode / share:.0f})" for one in readings),
            ]
        )
    return table("lift times", [f"Stage I {rpm} over that" for rpm in SPEEDS], rows)


def by_rule(words: str, way: Integrator, part: int) -> list[str]:
    """Row of the chain by an integrator at half a degree over ``part`` a step (0: its own choice)."""
    problem, readings = vt.build(CASE), []
    system = PrescribedSpring((problem.model_of("multi-mass", problem.springs[0]),), LAW)
    for rpm in SPEEDS:
        speed = rpm * np.pi / 60
        options = RunOptions(
            time_step=2 * np.pi / speed / 720 / part if part else None, keep="ends"
        )
        readings.append(read(way.run(system, speed, Cycles(2), options, Provenance("", ""))))
    return [words, *cells(readings)]


def integrators() -> str:
    """The chain by the leapfrog and by the implicit rule of Hilber, Hughes and Taylor at half a
    degree and below.
    """
    ways: list[tuple[str, Integrator, int]] = [("leapfrog", find("integrators", "leapfrog"), 0)]
    for alpha in (0.0, -0.05, -1 / 3):
        ways += [
            (f"HHT, alpha {alpha:.2f}, {0.5 / part:g} deg", HilberHughesTaylor(alpha), part)
            for part in (1, 4)
        ]
    ways.append(("HHT, alpha -0.05, 0.03125 deg", HilberHughesTaylor(-0.05), 16))
    return table("chain by", HEAD[2:], [by_rule(*way) for way in ways])


def tilt() -> str:
    """Modes with the retainer held and free to tilt, and what linear theory makes of both."""
    spring = rod_of()
    modes = natural_modes(spring.statics, spring.installed.state, 24)
    rows = []
    for words, stiffness in (
        ("held", None),
        ("tilts against 1 kN m/rad", 1e3),
        ("free to tilt", 0.0),
    ):
        frequency, share = (
            (modes.natural_frequency, modes.axial_transmission)
            if stiffness is None
            else tilted_modes(spring, stiffness)
        )
        found = []
        for rpm in SPEEDS:
            angle, force = linear_force(frequency, share, modes.axial_stiffness, LAW, rpm)
            found.append(f"{np.ptp(force[angle <= 127]):.1f}")
        rows.append([words, cluster(frequency, share), *found])
    return table(
        "retainer", ["modes, Hz: transmission", *(f"linear Stage I {rpm}" for rpm in SPEEDS)], rows
    )


def friction() -> str:
    """Work of friction of 0.1 in the touching coils of the shipped runs, beside the energy that
    vibrates.
    """
    rows = []
    for rpm in SPEEDS:
        work = slide_work(rod_of(), rpm, 0.1)
        told = vibration(rod_of(), rpm, LAW)
        at = int(np.argmin(np.abs(told.angle - 271.0)))
        rows.append(
            [
                f"{rpm} rpm",
                f"{1e3 * told.energy[at]:.2f}",
                f"{1e3 * work(271, 360):.2f}",
                f"{1e3 * work(0, 127):.2f}",
            ]
        )
    return table(
        "speed",
        ["vibrating at 271 deg, mJ", "friction 271 to 360 deg, mJ", "friction 0 to 127 deg, mJ"],
        rows,
    )


def main(wanted: Sequence[str]) -> None:
    """Print the tables and draw the pictures; ``wanted``: letters of the tables, or ``pictures``;
    all without any.
    """
    begin = time.process_time()
    extra = {
        "ladder": ladder, "linearity": linearity, "corners": corners, "installed": installed, "books": books, "energies": energies,
        "tilt": tilt, "friction": friction, "integrators": integrators, "kinks": kinks, "ramp": ramp,
    }  # fmt: skip
    for name, make in extra.items():
        if not wanted or name in wanted:
            print(f"{name}\n\n{make()}\n", flush=True)
    for title, changes in experiments():
        if not wanted or title[0] in wanted:
            print(
                f"{title}\n\n{table('change', HEAD, [row_of(one) for one in (SHIPPED, *changes)])}\n",
                flush=True,
            )
    if not wanted or "pictures" in wanted:
        from stage_one_pictures import draw

        draw()
    print(f"{time.process_time() - begin:.0f} s of processor time")


if __name__ == "__main__":
    main(sys.argv[1:])
