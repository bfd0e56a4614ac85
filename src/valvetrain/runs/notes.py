"""Notes of a study on inputs that have no effect or need care, and refusals before its runs."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import replace

import numpy as np

from valvetrain.errors import InputError
from valvetrain.parameters.installed_spring import InstalledSpring
from valvetrain.quantities.end_events import PULL
from valvetrain.quantities.plausible import refuse_implausible_motion, refuse_implausible_parts
from valvetrain.quantities.statics import formula_compression
from valvetrain.quantities.stress import most_force_of_wire
from valvetrain.runs.prepared import FAILURES, largest_lift, law_lift, prepare
from valvetrain.solution.later import replaced
from valvetrain.solution.result import Solution
from valvetrain.system.contract import TRAIN
from valvetrain.system.problem import Member, Problem
from valvetrain.units import believed

#: Tensile strength (Pa) above that of any wire of a valve spring.
MAX_STRENGTH = 2.5e9
#: A raw peak over that below 5 kHz from which a spike is reported with its band.
SPIKE = 1.02
#: How the note on a ramp begins that the cam card does not give.
ASSUMED_RAMP = "Ramp of the cam assumed"
#: What the note on springs without damping says of them.
NO_DAMPING = "no damping, so that surge lives on from cycle to cycle"


def undamped_notes(members: Iterable[Member]) -> tuple[str, ...]:
    """A sentence per spring model without damping on the springs whose damping it leaves out."""
    left_out: dict[str, dict[str, None]] = {}
    for member in members:
        for spring in member.springs:
            if not member.model.damped and _is_damped(spring):
                left_out.setdefault(member.model.word, {})[repr(spring.name)] = None
    return tuple(
        f"A {model} spring has no inner motion: the damping of {' and '.join(names)} has no effect in it."
        for model, names in left_out.items()
    )


def _is_damped(spring: InstalledSpring) -> bool:
    damping = spring.damping
    return bool(damping.mass_damping or damping.stiffness_damping or damping.ratio)


def ringing_note(members: Iterable[Member]) -> str:
    """A sentence on the springs without damping whose models have inner motion; empty where there
    are none.
    """
    names = dict.fromkeys(
        repr(spring.name)
        for member in members
        for spring in member.springs
        if member.model.damped and not _is_damped(spring)
    )
    if not names:
        return ""
    springs, its = ("springs", "their") if len(names) > 1 else ("spring", "its")
    return (
        f"The case gives {springs} {' and '.join(names)} {NO_DAMPING}: give {its} "
        "damping, such as 'damping = { ratio = 0.016, ratio_frequency = \"600 Hz\" }' at the first surge frequency (0.016: the beehive of "
        "gu2021)."
    )


def ramp_notes(members: Iterable[Member]) -> tuple[str, ...]:
    """A sentence on the ramp of a cam card that gives none, which the seating velocity follows."""
    laws = [member.gear.mechanism.kinematics.law for member in members if member.gear is not None]
    found = (getattr(law, "assumed_ramp", None) for law in laws)
    return tuple(
        dict.fromkeys(
            f"{ASSUMED_RAMP}: {np.radians(velocity) * 1e3:.4g} mm per cam degree, for your card gives none; the seating velocity follows "
            "from it (ramp_velocity, ramp_lift)."
            for velocity in found
            if velocity is not None
        )
    )


def on_assumed_ramp(notes: Iterable[str]) -> str:
    """What a sentence says behind a seating velocity that rests on an assumed ramp, by the notes of its
    run or study; empty elsewhere.
    """
    assumed = any(one.startswith(ASSUMED_RAMP) for one in notes)
    return " (on a ramp that is assumed)" if assumed else ""


def rings(run: Solution) -> bool:
    """Whether no spring of a run damps, by its :func:`ringing_note`."""
    noted = [note for note in run.provenance.notes if NO_DAMPING in note]
    return any(all(repr(name) in note for name in run.springs) for note in noted)


def chain_notes(members: Iterable[Member]) -> tuple[str, ...]:
    """A sentence per wire that a chain of masses replaces: what it takes from the rod, and what not."""
    found: dict[str, None] = {}
    for member in members:
        if member.instead:
            found[
                f"Runs by {member.model.word}, not by the default reduced-rod: {member.instead}."
            ] = None
        for spring in member.springs if member.model.word == "multi-mass" else ():
            if spring.wire is not None and (text := _chain_note(member, spring)):
                found[text] = None
    return tuple(found)


def _chain_note(member: Member, spring: InstalledSpring) -> str:
    from valvetrain.springs.chain_from_rod import match  # most runs have no chain of a wire

    given = dict(spring.options_of("multi-mass"))
    if not getattr(member.model.read_options(given), "from_rod", False):
        return ""
    try:
        options = member.model.read_options(given | {"from_rod": False})
        with believed():
            chain = member.model.make(spring, options, None)
            compared = match(chain, spring)
    except FAILURES:  # its run says why
        return ""
    force_error, second = compared.errors()
    high = "" if second is None else f", second frequency {percent(second)} off"
    return (
        f"Chain of '{spring.name}': rate and first frequency ({compared.surge_frequency:.0f} Hz) of its rod, force at rest within "
        f"{percent(force_error)}{high}; surge and clash are estimates (right: {'finite-element' if member.instead else 'reduced-rod'})."
    )


def percent(share: float) -> str:
    """A share in per cent, two digits."""
    return f"{100 * abs(share):.2g} %"


def run_notes(problem: Problem, member: Member, run: Solution) -> tuple[str, ...]:
    """The notes of a study that concern one run of a ``member``."""
    alone = replace(problem, members=(member,))
    return tuple(
        filter(
            None,
            (
                *parting_notes((member,)),
                ringing_note((member,)),
                *ramp_notes((member,)),
                *undamped_notes((member,)),
                *chain_notes((member,)),
                *buckling_notes(alone),
                *unknown_solid_notes((member,)),
                *card_notes((member,)),
                *pulling_end_notes((run,)),
                *driven_notes((run,)),
            ),
        )
    )


def parting_notes(members: Iterable[Member]) -> tuple[str, ...]:
    """How the total loads of dual springs were parted, a sentence each."""
    said = (
        spring.card.remark
        for member in members
        for spring in member.springs
        if spring.card is not None and spring.card.remark
    )
    return tuple(dict.fromkeys(said))


def with_notes(problem: Problem, solutions: Sequence[Solution]) -> tuple[Solution, ...]:
    """The solutions of a problem, each with the notes that concern it."""
    members = {member.label: member for member in problem.members}
    return tuple(
        replaced(run, provenance=replace(run.provenance, notes=notes))
        if (notes := run_notes(problem, members[run.label], run))
        else run
        for run in solutions
    )


def card_notes(members: Iterable[Member]) -> tuple[str, ...]:
    """A sentence on the springs of trains that are known by their cards: what these do not have."""
    names = dict.fromkeys(
        repr(spring.name)
        for member in members
        if member.gear is not None
        for spring in member.springs
        if spring.card is not None
    )
    if not names:
        return ()
    springs = "Springs" if len(names) > 1 else "Spring"
    return (
        f"{springs} {' and '.join(names)} known by card alone: no clash of coils, no stress, no mass of end turns on the retainer; "
        "'valvetrain spring-card' makes the wire.",
    )


def buckling_notes(problem: Problem) -> tuple[str, ...]:
    """A sentence on each wire of a train without a guide that buckles by the formula before the
    largest lift.

    The rod at rest is not solved for the run of a train.
    """
    found: list[str] = []
    if problem.kind != TRAIN:
        return ()
    for spring in dict.fromkeys(spring for member in problem.members for spring in member.springs):
        if spring.wire is None or spring.guide is not None:
            continue
        buckling, open_compression = (
            formula_compression(spring.wire),
            spring.precompression + largest_lift(problem),
        )
        if buckling is not None and buckling < open_compression:
            found.append(
                f"Spring '{spring.name}' buckles at {buckling * 1e3:.4g} mm compression by the formula of EN 13906-1, before the "
                f"{open_compression * 1e3:.4g} mm at full lift: guide it, or make it shorter or wider; 'valvetrain static' "
                "finds the place by finite elements."
            )
    return tuple(found)


def unknown_solid_notes(members: Iterable[Member]) -> tuple[str, ...]:
    """A sentence on each nested spring whose solid height is unknown while that of the other is known: the
    clearance to coil bind is then that of the other alone.
    """
    return tuple(
        dict.fromkeys(
            f"Coil bind of spring '{spring.name}' is not checked: its card gives no solid height; the clearance is that of the other spring."
            for member in members
            for spring in member.springs
            if spring.room is None and any(one.room is not None for one in member.springs)
        )
    )


def _named(runs: Iterable[Solution]) -> str:
    """Labels and speeds of runs, each once."""
    names = (f"{run.label} at {run.engine_speed * 30 / np.pi:.6g} rpm" for run in runs)
    return ", ".join(dict.fromkeys(names))


def spike_notes(solutions: Iterable[Solution]) -> tuple[str, ...]:
    """The band of the clash spikes of solids, whose raw heights rest on mesh and contact constants."""
    heights = []
    bands = tuple(f"main_clash_{band}peak_force" for band in ("", "below_5_khz_"))
    for run in solutions:
        if run.model != "solid":  # numbers of others may not be computed yet
            continue
        raw, below_5 = (run.quantities.get(name, 0.0) for name in bands)
        if raw > SPIKE * below_5 > 0:
            rpm = run.engine_speed * 30 / np.pi
            heights.append(f"at {rpm:.6g} rpm {raw:.0f} N raw, {below_5:.0f} N below 5 kHz")
    if not heights:
        return ()
    return (
        f"Largest clash spike by the solid: {'; '.join(heights)}. The raw height of a clash spike rests on mesh, contact constants "
        "and sampling; compare heights below 5 kHz.",
    )


def pulling_end_notes(solutions: Sequence[Solution]) -> tuple[str, ...]:
    """A sentence on the runs whose model cannot lift ends that would pull."""
    modal = [run for run in solutions if any(event.kind == PULL for event in run.events)]
    forces = ("minimum_spring_force", "minimum_retainer_force")
    solid = [
        run
        for run in solutions
        if run.model == "solid" and any(run.quantities.get(name, 0.0) < 0 for name in forces)
    ]
    notes = (
        f"The ends of the spring would pull: {_named(modal)}. Its modes are those of fixed ends, so it shows no force there "
        "but does not lift, and what follows is not right: take wave-rod, multi-mass or finite-element.",
        f"The ends of the spring would lift: {_named(solid)}. The inactive turns of a solid are bonded to seat and retainer, so "
        "it pulls there; where the ends are not bonded in truth, take finite-element.",
    )
    return tuple(note for note, runs in zip(notes, (modal, solid), strict=True) if runs)


def driven_notes(solutions: Sequence[Solution]) -> tuple[str, ...]:
    """A sentence per run of solids in a train: whose motion they follow and what that leaves out."""
    found = []
    for run in solutions:
        driver = run.statistics.get("driver", "")
        if (
            not driver
        ):  # before any quantity is read, which would compute values that may never be used
            continue
        difference = run.quantities["driver_difference_force"]
        repeats = run.statistics.get("motion_period_count") == 1.0
        turns = "" if repeats else ", one of its turns over and over, which are not alike"
        found.append(
            f"{run.label} at {run.engine_speed * 30 / np.pi:.6g} rpm, one way: train and valve move as with {driver}{turns}; the solid's "
            f"force on the retainer differs from that one's by {difference:.3g} N root mean square, which is what the train does not feel."
        )
    return tuple(found)


def beyond_wire_notes(problem: Problem, solutions: Iterable[Solution]) -> tuple[str, ...]:
    """Sentences on runs whose peak force is above that at which all coils are closed, and whose
    stress is above the strength of the wire.
    """
    beyond: dict[str, list[str]] = {}
    broken: list[str] = []
    pairs = (
        (run, spring)
        for run in solutions
        for spring in _springs_of(problem, run)
        if spring.name in run.springs or len(run.springs) == 1
    )
    for run, spring in pairs:
        name = spring.name
        numbers, label = run.quantities, f"{run.label} at {run.engine_speed * 30 / np.pi:.6g} rpm"
        first = f"{name}_" if len(run.springs) > 1 else ""
        most, force = most_force_of_wire(spring), numbers.get(f"{first}peak_spring_force", 0.0)
        if force > most:
            own = numbers.get(f"{first}peak_shear_stress")
            shown = "" if own is None else f", {own / 1e6:.4g} MPa in its wire"
            beyond.setdefault(
                f"'{name}' solid at {most:.4g} N (all coils closed, at rest)", []
            ).append(f"{label} {force:.4g} N{shown}")
        strength = numbers.get(f"{first}wire_tensile_strength", MAX_STRENGTH)
        names = ("peak_shear_stress", "open_nominal_shear_stress")
        stress = max(numbers.get(first + one, 0.0) for one in names)
        if stress > strength:
            broken.append(f"{label} {stress / 1e6:.4g} MPa")
    return tuple(
        f"Spring {spring}; peaks are above that, for coils strike one another: {', '.join(runs)}. What is above goes from coil to coil and "
        "does not twist the wire."
        for spring, runs in beyond.items()
    ) + (
        (
            f"No spring wire bears the shear stress of {', '.join(broken)} (above its tensile strength): the numbers there hold for no real spring.",
        )
        if broken
        else ()
    )


def _springs_of(problem: Problem, run: Solution) -> tuple[InstalledSpring, ...]:
    """The springs that moved in a run: those of its member, of two sets its own alone."""
    own = next((one for one in problem.members if one.label == run.label), None)
    if own is not None:
        return own.springs
    return tuple({one.name: one for member in problem.members for one in member.springs}.values())


#: Parts of a train with friction.
RUBBING = ("follower", "valve")


def checked_speeds(
    problem: Problem, engine_speeds: Sequence[float] | None, implausible: bool
) -> tuple[float, ...]:
    """The engine speeds (rad/s of the crank; None: those of the problem), refused as the two
    functions below do.

    ``implausible`` motions and parts pass.
    """
    speeds = problem.engine_speeds if engine_speeds is None else tuple(map(float, engine_speeds))
    refuse_speeds(problem, speeds)
    if not implausible:
        refuse_implausible(problem, speeds)
    return speeds


def refuse_speeds(problem: Problem, engine_speeds: Sequence[float]) -> None:
    """Raise :class:`InputError` for engine speeds (rad/s of the crank) that are not positive, or
    without a lift.
    """
    if any(not (np.isfinite(speed) and speed > 0) for speed in engine_speeds):
        raise InputError(
            "every engine speed must be positive; give it as '4200 rpm'", "engine_speeds"
        )
    if engine_speeds and not problem.moves:
        remedy = "add a [lift_law] table, or leave the engine speed out for its statics and modes"
        raise InputError(
            f"case '{problem.record.name}' holds no lift law, so its spring does not move; {remedy}",
            "engine_speeds",
        )


def refuse_implausible(problem: Problem, engine_speeds: Sequence[float]) -> None:
    """Raise :class:`InputError` for an implausible motion or part."""
    if problem.moves:
        refuse_implausible_motion(problem.valve_lift, (speed / 2 for speed in engine_speeds))
    values: dict[str, float] = {}
    for member in problem.members:
        for spring in member.springs:
            if (wire := spring.wire) is not None:
                coil = np.linspace(0.0, wire.total_coils, 65)
                values[f"spring '{spring.name}'.wire_diameter"] = float(
                    np.min(wire.wire_diameter.value(coil))
                )
                values[f"spring '{spring.name}'.spring_index"] = float(np.max(wire.index(coil)))
        if member.rubbing is not None:
            values["rubbing.friction_coefficient"] = member.rubbing.coefficient
        if member.gear is not None:
            train = member.gear.parameters
            for part in RUBBING:
                values[f"train.{part}.friction"] = getattr(
                    getattr(train, part, None), "friction", 0.0
                )
            for place, contact in train.contacts.items():
                values[f"train.contacts.{place}.friction_coefficient"] = (
                    contact.friction_coefficient
                )
    refuse_implausible_parts(values)


def refusals_before_run(problem: Problem, implausible: bool = False) -> dict[str, str]:
    """Label -> why the member cannot be integrated, for those that cannot; found by the parts that
    a run is made of.

    Springs under prescribed motion are also built for their statics. Raises :class:`InputError`
    with what refuses the whole run; ``implausible`` values pass.
    """
    # A sweep of a train never needs these.
    from valvetrain.runs.statics import default_model, reach_of
    from valvetrain.springs.finite_element import FiniteElementRod

    checked_speeds(problem, None, implausible)
    lift = law_lift(problem)
    found = {}
    for member in problem.members:
        if member.refusal:
            found[member.label] = member.refusal
        elif not member.model.needs_rest and (
            refusal := prepare(problem, member, {}, problem.record.study).refusal
        ):
            found[member.label] = refusal
        for spring in member.springs:
            if spring.wire is None and member.gear is None:
                problem.model_of(default_model(spring), spring)
            elif spring.wire is not None and (member.gear is None or member.model.needs_rest):
                rod = problem.model_of("finite-element", spring)
                if spring.contact.stiffness > 0:
                    spring.wire.refuse_solid(reach_of(spring, lift))
                if isinstance(rod, FiniteElementRod):
                    _ = rod.installed  # its statics need no time step
    return found
