"""Springs reduced from their rods: at rest, in small swings and in motion with clash, beside the
finite-element rod at 24 elements per coil.
"""

from __future__ import annotations

from dataclasses import dataclass
from importlib import resources

import numpy as np
from numpy.typing import ArrayLike, NDArray

from valvetrain.cosserat.buffer import RodDynamics
from valvetrain.cosserat.modes import natural_modes
from valvetrain.integrate.contract import Cycles
from valvetrain.integrate.run import run as integrate
from valvetrain.parameters.constructors import conical, cylindrical
from valvetrain.parameters.loading import parse_case
from valvetrain.runs.against_rod import RodDifference, difference_from_rods, rod_difference
from valvetrain.springs.finite_element import FiniteElementRod
from valvetrain.springs.finite_element_channels import wire_points
from valvetrain.springs.finite_element_statics import equilibrium_at
from valvetrain.springs.reduced_rod import ReducedRod
from valvetrain.springs.stress import LOADS, wire_stress
from valvetrain.system.build import build
from valvetrain.system.prescribed import PrescribedSpring
from valvetrain.system.train_system import TrainSystem
from valvetrain.validation.row import Row, book_case

TOPIC, CASE = "reduced rods", "gu2021-beehive-blind"
#: Difference (%) up to which a clash that the model itself names as too hard is accepted.
HARD_CLASH = 10.0


def _beehive() -> tuple[PrescribedSpring, ReducedRod]:
    system = build(CASE, spring_models=("reduced-rod",)).members[0].system()
    assert isinstance(system, PrescribedSpring)
    (spring,) = system.springs
    assert isinstance(spring, ReducedRod)
    return system, spring


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


#: Springs that are in no library: wire, preload travel (m), lift (m) and cam speed (rad/s).
OTHER_SPRINGS = {
    "racing": (cylindrical("4.5 mm", "24 mm", "9.2 mm", 6.2), 6e-3, 8e-3, 250.0),
    "motorcycle": (cylindrical("2.9 mm", "19 mm", "6.2 mm", 8.5), 7e-3, 8.5e-3, 320.0),
    "conical": (conical("3.6 mm", "30 mm", "21 mm", "8.4 mm", 7), 7e-3, 9e-3, 210.0),
}


def other_spring(name: str) -> ReducedRod:
    """One of :data:`OTHER_SPRINGS`, reduced up to its lift."""
    wire, travel, lift, _ = OTHER_SPRINGS[name]
    return ReducedRod(FiniteElementRod(wire, travel, 24, RodDynamics(40.0, 4e-6)), lift)


@book_case()
def reduced_rod_at_rest() -> list[Row]:
    """Force and six frequencies over lift, between the tables as well, of the beehive and of springs in no
    library.
    """
    beehive = _beehive()[1]
    points = [(CASE, beehive, lift) for lift in (0.0, 2.1e-3, 5.3e-3, 9.0e-3)]
    for name, (*_, largest, _speed) in OTHER_SPRINGS.items():
        spring = other_spring(name)
        points += [(name, spring, share * largest) for share in (0.5, 1.0)]
    rows = []
    for name, spring, lift in points:
        at = equilibrium_at(spring.rod, spring.rod.precompression + lift)
        modes = natural_modes(spring.statics, at.state, 6).natural_frequency
        force = spring.force(spring.initial_state(lift), lift).retainer
        furthest = float(np.max(np.abs(spring.frequencies(lift) / modes - 1)))
        where = f"{name}, retainer at {lift * 1e3:.3g} mm"
        label = "" if name == CASE else f"{name} spring: "
        rows.append(
            Row(
                TOPIC,
                f"{label}force at rest at {lift * 1e3:.3g} mm",
                "",
                where,
                at.retainer_force,
                force,
                "N",
                1e-3 * at.retainer_force,
                "0.1 %, tables are straight between their lifts",
                "consistency",
            )
        )
        rows.append(
            Row(
                TOPIC,
                f"{label}largest difference of six frequencies at {lift * 1e3:.3g} mm",
                "",
                where,
                0.0,
                100 * furthest,
                "%",
                0.5,
                "0.5 %, of any of them",
                "consistency",
            )
        )
    return rows


@book_case()
def reduced_rod_in_motion() -> list[Row]:
    """The beehive over two revolutions at three speeds, the fastest with clash."""
    system, spring = _beehive()
    rows = []
    for engine_speed, share in ((4200.0, 0.01), (5600.0, 0.01), (8000.0, 0.03)):
        found = difference_from_rods([spring], system.valve_lift, engine_speed * np.pi / 60)
        rows += _against_rod(CASE, f"{engine_speed:g} rpm", found, share)
    return rows


@book_case()
def reduced_rod_of_other_springs() -> list[Row]:
    """Springs in no library under a smooth event, and the wire of the pushrod template under the motion
    that its train gives the retainer, at 6000 rpm with clash.
    """
    rows = []
    for name, (*_, largest, cam_speed) in OTHER_SPRINGS.items():
        found = difference_from_rods([other_spring(name)], Pulse(largest), cam_speed)
        rows += _against_rod(f"{name} spring", f"{cam_speed:g} rad/s of the cam", found, 0.01)
    text = resources.files("valvetrain").joinpath("templates/pushrod.toml").read_text("utf-8")
    case = parse_case(text, "pushrod")
    member = build(case, spring_models=("reduced-rod",), spring_set=("wire",)).members[0]
    train = member.system()
    assert isinstance(train, TrainSystem)
    for engine_speed, share in ((5500.0, 0.01), (6000.0, 0.03)):
        run = integrate(train, engine_speed * np.pi / 60)
        found = rod_difference(train, run)
        rows += _against_rod("pushrod template, wire", f"{engine_speed:g} rpm", found, share)
    return rows


def _against_rod(name: str, speed: str, found: RodDifference | None, share: float) -> list[Row]:
    """Rows of a run beside its rod: rms, peak and minimum of the seat force below 20 kHz. What the model names
    itself as too far from its rod is an explained miss.
    """
    assert found is not None
    rows = []
    for what, value, limit, of in (
        ("rms of the difference", found.rms, share, "of the rms: 1 % without, 3 % with clash"),
        ("difference of the peak", found.peak, 0.01, "of the peak"),
        ("difference of the minimum", found.minimum, 0.02, "of the force as installed"),
    ):
        said = value > limit and bool(found.too_far)
        rows.append(
            Row(
                TOPIC,
                f"{name}, {speed}: seat force below 20 kHz, {what}",
                "",
                f"{name}, {speed}, 24 elements per coil",
                0.0,
                100 * value,
                "%",
                100 * limit,
                of,
                "consistency",
                (0.0, HARD_CLASH) if said else None,
                f"coils clash: a run says so itself ({found.too_far}) and names the rod"
                if said
                else "",
            )
        )
    return rows


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
