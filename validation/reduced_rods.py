"""Springs reduced from their rods: at rest, in small swings and in motion with clash, next to the
finite-element rod at 24 elements per coil.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache
from importlib import resources

import numpy as np
from numpy.typing import ArrayLike, NDArray

from validation.against_rod import (
    MINIMUM_TOO_FAR,
    PEAK_TOO_FAR,
    TOO_FAR,
    RodDifference,
    difference_from_rods,
    rod_difference,
)
from validation.row import Row, book_case
from valvetrain.cosserat.buffer import RodDynamics
from valvetrain.cosserat.modes import natural_modes
from valvetrain.integrate.contract import Cycles
from valvetrain.integrate.run import run as integrate
from valvetrain.parameters.curves import PiecewiseLinear
from valvetrain.parameters.loading import parse_case
from valvetrain.parameters.spring import SpringDefinition
from valvetrain.springs.finite_element import FiniteElementRod, equilibrium_at
from valvetrain.springs.finite_element_channels import wire_points
from valvetrain.springs.reduced_rod import ReducedRod
from valvetrain.springs.stress import LOADS, wire_stress
from valvetrain.system.build import build
from valvetrain.system.prescribed import PrescribedSpring

TOPIC, CASE = "reduced rods", "gu2021-beehive-blind"
PER_COIL = "24 elements per coil"
#: Share of the rms of the seat force allowed without clash; difference (%) up to which a clash that the model
#: itself names as too hard is accepted.
WITHOUT_CLASH, HARD_CLASH = 0.01, 10.0


def wound(wire: str, mean: str | PiecewiseLinear, pitch: str, turns: float) -> SpringDefinition:
    """A spring of OTEVA 90 SC with closed and ground ends."""
    return SpringDefinition(wire, mean, pitch, total_coils=turns, material="OTEVA 90 SC")


#: Springs that are in no library, a short racing spring, a slender one of a motorcycle and a conical one:
#: wire, preload travel (m), lift (m) and cam speed (rad/s).
OTHER_SPRINGS = {
    "racing": (wound("4.5 mm", "24 mm", "9.2 mm", 6.2), 6e-3, 8e-3, 250.0),
    "motorcycle": (wound("2.9 mm", "19 mm", "6.2 mm", 8.5), 7e-3, 8.5e-3, 320.0),
    "conical": (
        wound("3.6 mm", PiecewiseLinear((0, 7), "30, 21 mm"), "8.4 mm", 7),
        7e-3,
        9e-3,
        210.0,
    ),
}


@dataclass(frozen=True)
class Pulse:
    """A lift law of a smooth event of ``largest`` (m) over a third of the revolution."""

    largest: float
    continuity: int = 3
    joints: tuple[float, ...] = ()

    def lift(self, cam_angle: ArrayLike, derivative: int = 0) -> NDArray[np.float64]:
        """See :class:`valvetrain.lift.contract.LiftLaw`."""
        angle = np.pi * (np.mod(cam_angle, 2 * np.pi) / (2 * np.pi / 3) - 1)
        inside = np.abs(angle / np.pi - 0.5) < 0.5
        sine, cosine = np.sin(angle), np.cos(angle)
        value = (sine**4, 6 * sine**3 * cosine, 9 * (3 * sine**2 * cosine**2 - sine**4))[derivative]
        return np.asarray(self.largest * np.where(inside, value, 0.0))


def _beehive() -> tuple[PrescribedSpring, ReducedRod]:
    system = build(CASE, spring_models=("reduced-rod",)).members[0].system()
    assert isinstance(system, PrescribedSpring)
    (spring,) = system.springs
    assert isinstance(spring, ReducedRod)
    return system, spring


@cache
def other_spring(name: str) -> ReducedRod:
    """One of :data:`OTHER_SPRINGS`, reduced up to its lift."""
    wire, travel, lift, _ = OTHER_SPRINGS[name]
    return ReducedRod(FiniteElementRod(wire, travel, 24, RodDynamics(40.0, 4e-6)), lift)


@book_case()
def reduced_rod_at_rest() -> list[Row]:
    """Force and six frequencies over lift, between the tables as well, of the beehive and of springs in
    no library.
    """
    lifts: dict[str, tuple[ReducedRod, tuple[float, ...]]] = {
        CASE: (_beehive()[1], (0.0, 2.1e-3, 5.3e-3, 9.0e-3))
    }
    for name, (*_, largest, _speed) in OTHER_SPRINGS.items():
        shares = (0.0, 0.33, 0.5, 0.71, 1.0)
        lifts[name] = (other_spring(name), tuple(share * largest for share in shares))
    forces, frequencies = [], {}
    for name, (spring, places) in lifts.items():
        furthest = []
        for lift in places:
            at = equilibrium_at(spring.rod, spring.rod.precompression + lift)
            modes = natural_modes(spring.statics, at.state, 6).natural_frequency
            force = spring.force(spring.initial_state(lift), lift).retainer
            forces.append(abs(force / at.retainer_force - 1))
            furthest.append(float(np.max(np.abs(spring.frequencies(lift) / modes - 1))))
        frequencies[name] = max(furthest)
    inputs = f"{', '.join(lifts)}; 4 or 5 lifts each, 24 elements per coil"
    reason = "0.1 %, tables are straight between their lifts"
    rows = [_of_rod("force at rest, largest difference", inputs, max(forces), 1e-3, reason)]
    for name, share in frequencies.items():
        what = f"{name}: six frequencies at rest, largest difference"
        inputs = f"{len(lifts[name][1])} lifts, 24 elements per coil"
        rows.append(_of_rod(what, inputs, share, 5e-3, "0.5 %, of any of them at any lift"))
    return rows


@book_case()
def reduced_rod_in_motion() -> list[Row]:
    """The beehive over two revolutions at three speeds, the fastest with clash; springs in no library under
    a smooth event.
    """
    system, spring = _beehive()
    beehive = [
        difference_from_rods([spring], system.valve_lift, engine_speed * np.pi / 60)
        for engine_speed in (4200.0, 5600.0, 8000.0)
    ]
    others = [
        difference_from_rods([other_spring(name)], Pulse(largest), cam_speed)
        for name, (*_, largest, cam_speed) in OTHER_SPRINGS.items()
    ]
    return [
        *_rms(f"{CASE}, 4200 and 5600 rpm", beehive[:2], WITHOUT_CLASH),
        *_rms(f"{CASE}, 8000 rpm", beehive[2:], TOO_FAR),
        *_ends(f"{CASE}, 4200 to 8000 rpm", beehive),
        *_rms("racing, motorcycle and conical spring", others, WITHOUT_CLASH),
        *_ends("racing, motorcycle and conical spring", others),
    ]


@book_case()
def reduced_rod_in_its_train() -> list[Row]:
    """The wire of the pushrod template and its rod, both under the motion that the train by the reduced rod
    gives the retainer, at 6000 rpm with clash.
    """
    text = resources.files("valvetrain").joinpath("templates/pushrod.toml").read_text("utf-8")
    problem = build(
        parse_case(text, "pushrod"), spring_models=("reduced-rod",), spring_set=("wire",)
    )
    train, rows = problem.members[0].system(), []
    for engine_speed, share in ((5500.0, WITHOUT_CLASH), (6000.0, TOO_FAR)):
        found = rod_difference(train, integrate(train, engine_speed * np.pi / 60))
        name = f"pushrod template, wire, {engine_speed:g} rpm"
        rows += [*_rms(name, [found], share), *_ends(name, [found])]
    return rows


def _rms(name: str, found: Sequence[RodDifference | None], share: float) -> list[Row]:
    """The row of the largest rms of some runs and of their rods."""
    largest = float(np.max([np.nan if one is None else one.rms for one in found]))
    clash = "with" if share > WITHOUT_CLASH else "without"
    what = f"{name}: seat force below 20 kHz, largest rms of the difference"
    return [_of_rod(what, PER_COIL, largest, share, f"{100 * share:g} % of the rms {clash} clash")]


def _ends(name: str, found: Sequence[RodDifference | None]) -> list[Row]:
    """Rows of the largest differences of peak and minimum of some runs. A peak of a clash that the model
    itself names as too hard is an explained miss.
    """
    peak, minimum = (
        float(np.max([np.nan if one is None else getattr(one, end) for one in found]))
        for end in ("peak", "minimum")
    )
    named = [one.too_far for one in found if one is not None and one.too_far]
    said = f"too hard a clash: the run says so ({', '.join(named)}) and names the rod"
    of = f"{name}: seat force below 20 kHz, largest difference of the"
    return [
        _of_rod(f"{of} peak", PER_COIL, peak, PEAK_TOO_FAR, "of the peak", said if named else ""),
        _of_rod(f"{of} minimum", PER_COIL, minimum, MINIMUM_TOO_FAR, "of the force as installed"),
    ]


def _of_rod(
    what: str, inputs: str, share: float, limit: float, reason: str, explained: str = ""
) -> Row:
    """A row of a share that is off the rod's, in per cent."""
    band = (0.0, HARD_CLASH) if explained else None
    return Row(
        TOPIC, what, "", inputs, 0.0, 100 * share, "%", 100 * limit, reason, "consistency", band, explained,
    )  # fmt: skip


@book_case()
def reduced_rod_stress() -> list[Row]:
    """Largest shear stress at the inner fibre of the beehive over the second of two revolutions."""
    system, spring = _beehive()
    rows = []
    for engine_speed in (4200.0, 5600.0):
        peaks = []
        for model in (spring, spring.rod):
            run = integrate(
                PrescribedSpring((model,), system.valve_lift),
                engine_speed * np.pi / 60,
                Cycles(2),
            )
            loads = {name: np.asarray(run.cycle[name]) for name in LOADS}
            coil = wire_points(spring.rod.definition.total_coils)
            stress = wire_stress(loads, spring.rod.definition, coil)
            peaks.append(float(np.max(stress["inner_fibre_shear_stress"])) / 1e6)
        rows.append(
            Row(
                TOPIC,
                f"largest shear stress at the inner fibre at {engine_speed:g} rpm",
                "",
                f"{CASE}, {engine_speed:g} rpm, 24 elements per coil",
                peaks[1],
                peaks[0],
                "MPa",
                3e-3 * peaks[1],
                "0.3 %, loads are those of the rod to first order about rest",
                "consistency",
            )
        )
    return rows
