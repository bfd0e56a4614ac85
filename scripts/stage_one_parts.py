"""Springs, lifts and linear theory for stage_one.py."""

from __future__ import annotations

import warnings
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.signal import lfilter
from scipy.sparse import diags
from scipy.sparse.linalg import LinearOperator, eigsh, splu

from valvetrain.cam.build import build_lift_law
from valvetrain.cam.contract import LiftLaw
from valvetrain.cosserat import quaternion as quat
from valvetrain.cosserat.buffer import RodDynamics, inertia_of
from valvetrain.cosserat.modes import natural_modes
from valvetrain.cosserat.rates import axial_rate
from valvetrain.cosserat.transient import RodTransient, simulate
from valvetrain.parameters.curves import Constant, PiecewiseLinear
from valvetrain.parameters.loading import load_case, parse_case
from valvetrain.parameters.spring import SpringDefinition
from valvetrain.solution.study import LiftEvent
from valvetrain.springs.finite_element import FiniteElementRod

Array = NDArray[np.float64]
CASE = load_case("gu2021-beehive")
SPRING, LAW = CASE.springs[0], build_lift_law(CASE.lift_law)
WIRE = SPRING.wire
assert WIRE is not None
#: Engine speeds (rpm) of the study, its Stage II, what every changed spring is tuned to: preload
#: (N) and centre of the first cluster (Hz).
SPEEDS, EVENT = (4200, 5600, 8000), LiftEvent(np.radians(127.0), np.radians(233.0))
MODES, SAMPLES = 24, 720
#: Share by which a tuned spring may miss preload and frequency.
AIM = 2e-4


def damped(**changes: Any) -> RodDynamics:
    """Damping and contact of the case with changes: ``ratio``, ``stiffness_share``, or fields of
    the dynamics.
    """
    own = {key: changes.pop(key) for key in ("ratio", "stiffness_share") if key in changes}
    damping = SPRING.damping.replace(**own) if own else SPRING.damping
    return replace(
        RodDynamics(
            mass_damping=damping.mass_damping,
            stiffness_damping=damping.stiffness_damping,
            contact_stiffness=SPRING.contact.stiffness,
            contact_damping_time=SPRING.contact.damping_time,
        ),
        **changes,
    )


def rod_of(
    wire: SpringDefinition = WIRE,
    elements: int = 24,
    dynamics: RodDynamics | None = None,
    seats: str = "planes",
) -> FiniteElementRod:
    """The rod of a wire, installed as the case has it."""
    return FiniteElementRod(
        wire, SPRING.precompression, elements, dynamics or damped(), seats=seats
    )


def _clearances(wire: SpringDefinition) -> tuple[float, Array]:
    diameter = float(wire.wire_diameter.value(0.0))
    assert isinstance(wire.pitch, PiecewiseLinear)
    return diameter, np.array(wire.pitch.values) - diameter


def with_clearance(wire: SpringDefinition, more: float) -> SpringDefinition:
    """Clearance (m) at coils 1 and 2 raised by ``more``; coil 3 and above as they are."""
    diameter, clearance = _clearances(wire)
    clearance[2:4] += more
    return wire.replace(pitch=PiecewiseLinear(wire.pitch.coils, tuple(clearance + diameter)))


def with_kink(wire: SpringDefinition, coil: float, more: float) -> SpringDefinition:
    """Pitch (m per turn) raised by ``more`` at one ``coil``, straight to the corners of the law on
    either side.
    """
    assert isinstance(wire.pitch, PiecewiseLinear)
    coils = np.sort(np.append(wire.pitch.coils, coil))
    pitch = np.interp(coils, wire.pitch.coils, wire.pitch.values) + more * (coils == coil)
    return wire.replace(pitch=PiecewiseLinear(tuple(coils), tuple(pitch)))


def with_coils(wire: SpringDefinition, total: float) -> SpringDefinition:
    """Other ``total`` coils: the level stretch of the pitch and the straight one of the diameter
    are longer or shorter.
    """
    more = total - wire.total_coils
    pitch = PiecewiseLinear(tuple(c + more * (c >= 6) for c in wire.pitch.coils), wire.pitch.values)
    mean = PiecewiseLinear(
        tuple(c + more * (c >= 4) for c in wire.mean_diameter.coils), wire.mean_diameter.values
    )
    return wire.replace(pitch=pitch, mean_diameter=mean, total_coils=total)


def _rescaled(wire: SpringDefinition, wire_share: float, mean_share: float) -> SpringDefinition:
    """Wire and coil diameter times a share each, clearances as they are."""
    diameter, clearance = _clearances(wire)
    mean = PiecewiseLinear(
        wire.mean_diameter.coils, tuple(mean_share * np.array(wire.mean_diameter.values))
    )
    pitch = PiecewiseLinear(wire.pitch.coils, tuple(clearance + wire_share * diameter))
    return wire.replace(
        wire_diameter=Constant(wire_share * diameter), pitch=pitch, mean_diameter=mean
    )


def _preload_and_centre(wire: SpringDefinition) -> Array:
    """Preload (N), and mean frequency (Hz) of the first cluster by transmission: the cluster's
    split leaves it alone.
    """
    spring = rod_of(wire, 12)
    modes = natural_modes(spring.statics, spring.installed.state, 12)
    near = (
        (modes.natural_frequency > 450)
        & (modes.natural_frequency < 900)
        & (modes.axial_transmission > 0.02)
    )
    share = modes.axial_transmission[near]
    return np.array(
        [spring.installed.retainer_force, share @ modes.natural_frequency[near] / share.sum()]
    )


def tuned(wire: SpringDefinition, rounds: int = 15) -> FiniteElementRod:
    """The rod of ``wire`` with wire and coil diameter rescaled to the preload and the first cluster
    of the case (Broyden's method).

    Warns where one of the two is missed by more than :data:`AIM` of itself after all ``rounds``.
    """
    aim, place = _preload_and_centre(WIRE), np.ones(2)
    jacobian, miss = (
        np.array([[4.0, -3.0], [1.0, -2.0]]),
        _preload_and_centre(wire) / aim - 1,
    )  # F ~ d4 / D3, f ~ d / D2
    for _ in range(rounds):
        if np.max(np.abs(miss)) < AIM:
            break
        step = np.clip(-np.linalg.solve(jacobian, miss), -0.05, 0.05)
        place = place + step
        now = _preload_and_centre(_rescaled(wire, *place)) / aim - 1
        jacobian, miss = (
            jacobian + np.outer(now - miss - jacobian @ step, step) / (step @ step),
            now,
        )
    if not np.max(np.abs(miss)) < AIM:
        warnings.warn(
            f"not tuned: the preload is missed by {miss[0]:.1%}, the centre of the first cluster by {miss[1]:.1%}",
            stacklevel=2,
        )
    return rod_of(_rescaled(wire, *place))


@dataclass(frozen=True)
class Scaled:
    """A lift law times a ``share``."""

    law: LiftLaw
    share: float

    @property
    def continuity(self) -> int:
        return self.law.continuity

    @property
    def joints(self) -> tuple[float, ...]:
        return self.law.joints

    def lift(self, cam_angle: ArrayLike, derivative: int = 0) -> Array:
        return self.share * self.law.lift(cam_angle, derivative)


@dataclass(frozen=True)
class LinearPieces:
    """A lift law read every ``step`` degrees and straight between, as load steps of the source."""

    law: LiftLaw
    step: float

    continuity = 0
    joints = ()

    def lift(self, cam_angle: ArrayLike, derivative: int = 0) -> Array:
        station = np.arange(0.0, 360.0 + self.step / 2, self.step)
        told = self.law.lift(np.radians(station))
        angle = np.degrees(np.mod(np.asarray(cam_angle, dtype=float), 2 * np.pi))
        if derivative == 0:
            return np.interp(angle, station, told)
        if derivative > 1:
            return np.zeros_like(angle)
        piece = np.clip((angle // self.step).astype(int), 0, len(station) - 2)
        slope: Array = np.diff(told)[piece] / np.radians(self.step)
        return slope


def polydyne() -> LiftLaw:
    """An ordinary law with more of the 13th to 14th harmonic, of the case's largest lift."""
    return build_lift_law(
        parse_case(
            f'title = "polydyne"\n[lift_law]\nkind = "polydyne"\nlift_of = "valve"\nmaximum_lift = "{1e3 * LAW.lift(np.pi).item():.4f} mm"\n'
            'exponents = "2-10-18-26-34"\nopening_start = "115 deg"\nclosing_end = "245 deg"'
        ).lift_law
    )


def linear_force(
    frequency: Array,
    share: Array,
    rate: float,
    law: LiftLaw,
    rpm: float,
    cycles: int = 2,
    steps: int = 7200,
) -> tuple[Array, Array]:
    """Cam angle (deg) and dynamic seat force (N) of the last of ``cycles`` turns from rest, by
    linear modes of these transmissions.

    F = k y + 2 k sum t p with p'' + 2 z w p' + w2 p = -y'', each stepped exactly for an
    acceleration straight between the steps.
    """
    speed = rpm * np.pi / 60
    at = 2 * np.pi / speed / steps * np.arange(cycles * steps + 1)
    forcing, step = -law.lift(speed * at, 2) * speed**2, at[1]
    force = rate * law.lift(speed * at)
    for hertz, part in zip(frequency, share, strict=True):
        omega, ratio = 2 * np.pi * hertz, SPRING.damping.ratio_at(hertz)
        ringing = omega * np.sqrt(1 - ratio**2)
        pole = complex(-ratio * omega, ringing)
        grown = np.exp(pole * step)
        constant, ramp = (grown - 1) / pole, ((grown - 1) / pole - step) / (pole * step)
        pushed = np.concatenate(([0.0], constant * forcing[:-1] + ramp * np.diff(forcing)))
        force = force + 2 * rate * part * lfilter([1.0], [1.0, -grown], pushed).imag / ringing
    last = slice((cycles - 1) * steps, None)
    return np.degrees(speed * at[last]) - 360 * (cycles - 1), force[last]


def _moved(spring: FiniteElementRod, rpm: float, law: LiftLaw, discard: int) -> RodTransient:
    speed = rpm * np.pi / 60
    return simulate(
        spring.mesh,
        spring.installed.state,
        lambda time: spring.precompression + law.lift(speed * np.asarray(time)),
        2 * np.pi / speed / SAMPLES,
        2 * SAMPLES,
        spring.dynamics,
        spring.stable_time_step(),
        discard=discard,
    )


@dataclass(frozen=True)
class Vibration:
    """Energies (J) over the cam ``angle`` (deg) of two turns from rest, of each mode (samples,
    modes; ``frequency`` in Hz), and the losses
    since the start; all referred to the full lift."""

    angle: Array
    frequency: Array
    modal: Array
    wire_loss: Array
    contact_loss: Array

    @property
    def energy(self) -> Array:
        """Energy (J) of all modes."""
        found: Array = self.modal.sum(axis=1)
        return found

    def share(self, at: int, low: float, high: float) -> float:
        """Energy (mJ) of the modes between two frequencies (Hz) at a sample."""
        return 1e3 * float(self.modal[at, (self.frequency > low) & (self.frequency <= high)].sum())


def vibration(spring: FiniteElementRod, rpm: float, law: LiftLaw) -> Vibration:
    """The motion of the rod taken apart by its modes about the installed state; the retainer stands
    still from 270 degrees on.
    """
    modes, mesh = natural_modes(spring.statics, spring.installed.state, MODES), spring.mesh
    made, share = _moved(spring, rpm, law, 0), law.lift(np.pi).item() / LAW.lift(np.pi).item()
    index = np.arange(mesh.vertices)
    mass = np.where((index > mesh.first) & (index < mesh.last), mesh.node_mass, 0.0)
    place = np.einsum(
        "ivc,v,nvc->ni", modes.shape, mass, made.position - spring.installed.state.position
    )
    rate = np.einsum("ivc,v,nvc->ni", modes.shape, mass, made.velocity)
    modal = (rate**2 + (2 * np.pi * modes.natural_frequency * place) ** 2) / 2 / share**2
    losses = (series / share**2 for series in (made.energy_dissipated, made.contact_loss))
    return Vibration(
        np.degrees(rpm * np.pi / 60 * made.time), modes.natural_frequency, modal, *losses
    )


def slide_work(
    spring: FiniteElementRod, rpm: float, coefficient: float
) -> Callable[[float, float], float]:
    """Work (J) between two cam angles (deg) of the second turn that friction would do on the
    touching coils of a run without any.

    Normal force times sliding speed of the two surfaces, the turning of the sections about the wire
    included; the motion is left as it is,
    so this bounds what friction can take: where it would take all, the coils stick.
    """
    made, mesh = _moved(spring, rpm, LAW, SAMPLES), spring.mesh
    upper = np.arange(mesh.contact.offset, mesh.vertices)
    lower, radius = upper - mesh.contact.offset, mesh.wire_diameter / 2
    axes = quat.to_matrix(made.frame.reshape(-1, 4)).reshape(*made.frame.shape[:2], 3, 3)
    spin = np.einsum("tvij,tvj->tvi", axes, made.spin)
    spin = (spin[:, :-1] + spin[:, 1:]) / 2
    normal = made.position[:, upper] - made.position[:, lower]
    normal /= np.linalg.norm(normal, axis=2)[..., None]
    speed = made.velocity[:, upper] - radius[upper, None] * np.cross(spin[:, upper], normal)
    speed = speed - made.velocity[:, lower] - radius[lower, None] * np.cross(spin[:, lower], normal)
    slide = np.linalg.norm(speed - np.sum(speed * normal, axis=2)[..., None] * normal, axis=2)
    pressed = made.contact_force.sum(axis=1)[1:, upper]
    power = coefficient * np.sum(pressed * (slide[1:] + slide[:-1]) / 2, axis=1)
    angle, interval = (
        np.degrees(rpm * np.pi / 60 * made.time[1:]) - 360,
        made.time[1] - made.time[0],
    )
    return lambda first, last: float(interval * np.sum(power[(angle > first) & (angle <= last)]))


def tilted_modes(spring: FiniteElementRod, stiffness: float) -> tuple[Array, Array]:
    """Frequencies (Hz) and axial transmissions with the retainer free to tilt about both horizontal
    axes against ``stiffness`` (N m/rad).

    The retainer has no inertia in tilt: its two angles follow at rest. It tilts about the point of
    the axis at the height where the wire
    ends. Linear, about the installed state; the moving rod has no such retainer.
    """
    statics, state = spring.statics, spring.installed.state
    last, x = statics.mesh.last, state.position
    frames, arm = (
        quat.to_matrix(state.frame[last + 1 :]),
        x[last:] - np.array([0.0, 0.0, x[last, 2]]),
    )
    fields = np.zeros((2, statics.mesh.vertices, 6))
    for axis in range(2):
        fields[axis, last:, :3], fields[axis, last:, 3:] = (
            np.cross(np.eye(3)[axis], arm),
            frames[:, axis, :],
        )
    unit, tangent, inertia = (
        fields.reshape(2, -1).T,
        statics.tangent(state),
        inertia_of(statics.mesh),
    )
    free = statics.free & (inertia > 0)
    pulled, scale = tangent @ unit, 1 / np.sqrt(inertia[free])
    own = unit.T @ pulled + stiffness * np.eye(2)
    scaled, column = (
        (diags(scale) @ tangent[free][:, free] @ diags(scale)).tocsc(),
        scale[:, None] * pulled[free],
    )
    shift = 1e3
    solver = splu((scaled + shift * diags(np.ones(len(scale)))).tocsc())
    reached = solver.solve(column)
    small = np.linalg.inv(own - column.T @ reached)

    def apply(vector: Array) -> Array:
        found: Array = scaled @ vector.ravel() - column @ np.linalg.solve(
            own, column.T @ vector.ravel()
        )
        return found

    def invert(vector: Array) -> Array:
        found = solver.solve(vector.ravel())
        bent: Array = found + reached @ (small @ (column.T @ found))
        return bent

    shape = scaled.shape
    values, vectors = eigsh(
        LinearOperator(shape, matvec=apply),
        k=MODES,
        sigma=-shift,
        OPinv=LinearOperator(shape, matvec=invert),
        which="LM",
        v0=np.sin(1.0 + np.arange(shape[0])),
        tol=1e-10,
    )
    order = np.argsort(values)
    values, vectors = values[order], scale[:, None] * vectors[:, order]
    whole = np.zeros((len(free), MODES))
    whole[free] = vectors
    whole -= unit @ np.linalg.solve(own, pulled[free].T @ vectors)
    reaction = tangent[2::6] @ whole
    seat, retainer = reaction[: statics.mesh.first + 1].sum(axis=0), reaction[last:].sum(axis=0)
    return np.sqrt(np.abs(values)) / (2 * np.pi), seat * retainer / (
        2 * axial_rate(statics, state) * values
    )
