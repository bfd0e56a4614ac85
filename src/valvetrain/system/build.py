"""From a case to a problem: every part built once, what cannot work refused with its numbers. The
only place that makes parts from a case.
"""

from __future__ import annotations

import re
import warnings
from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np

from valvetrain.arrays import Array
from valvetrain.cam.contract import LiftLaw, build_lift_law
from valvetrain.cam.event import find_lift_event
from valvetrain.errors import InputError, UnusualValueWarning
from valvetrain.mechanism.build import build_mechanism
from valvetrain.mechanism.contour import monotone_table
from valvetrain.parameters.case import Case
from valvetrain.parameters.installed_spring import InstalledSpring, Rubbing, binding_lift
from valvetrain.parameters.loading import AnyCase, case_of, parse_case
from valvetrain.parameters.toml_text import find_line
from valvetrain.parameters.train import TrainParameters
from valvetrain.parameters.train_parts import CrankParameters
from valvetrain.registry import plain_name
from valvetrain.solution.definition import label_cut_off
from valvetrain.springs.nested import RadialRubbing
from valvetrain.springs.own_spring import model_names
from valvetrain.springs.spec import SpringModelSpec, spring_model
from valvetrain.system.problem import Gear, Member, Problem
from valvetrain.units import as_names, known_arguments

#: Largest valve mass over the cube of the lift (kg/m3) that passes without a warning.
HEAVIEST = 1.5e6
#: The same of light ones: 3.4 g at 12 mm, a quarter of what titanium valves of racing engines weigh.
LIGHTEST = 2e3
#: Mass (kg) beyond which the number itself is doubted.
BEYOND_ANY = 20.0
#: Spring models of a case of one's own that names none: those of a known wire, of a card with and
#: without a mass.
WIRE_MODELS, CARD_MODELS, BARE_MODELS = (
    ("finite-element", "modal-varied"),
    ("modal-uniform",),
    ("massless",),
)
#: Default models of a comparison: of a spring alone, of a train.
COMPARED_ALONE = (
    "massless", "multi-mass", "modal-varied", "wave-rod", "wave-rod-clash", "finite-element",
)  # fmt: skip
COMPARED_IN_TRAIN = ("massless", "multi-mass", "modal-uniform", "wave-rod", "reduced-rod")


@known_arguments
def build(
    case: AnyCase,
    *,
    spring_models: Sequence[str] | str = (),
    spring_set: Sequence[str] | str = (),
) -> Problem:
    """The problem of a case, every part built once: its variants, or one member per spring model
    (of each spring set) requested.

    Parameters
    ----------
    case : Case, name of a library case, or path of a case file
    spring_models : a spring model or several, by name, such as "multi-mass", class or instance; the
        case's own or the default ones by default
    spring_set : name of a spring set of a train, or several

    Returns
    -------
    Problem with its members, lift law and engine speeds (rad/s of the crank)

    Raises
    ------
    InputError : a case without spring and train, an unknown word, a spring that reaches coil bind
        within the lift, what parts refuse

    Examples
    --------
    >>> import valvetrain as vt
    >>> problem = vt.system.build.build("job-t", spring_models=["massless", "multi-mass"])
    >>> [member.label for member in problem.members]
    ['massless', 'multi-mass']
    """
    case = case_of(case)
    sets, named = as_names(spring_set), model_names(spring_models) if spring_models else ()
    try:
        law = lift_law_of(case)
        specs = tuple(spring_model(word, "models") for word in dict.fromkeys(named))
        if case.train is not None:
            members = _train_members(case, case.train, law, specs, sets)
        elif sets:
            raise InputError(
                f"case '{case.name}' is a spring alone and has no spring sets; leave them out",
                "spring_set",
            )
        else:
            members = _spring_members(case, law, specs)
        event = find_lift_event(law if case.lift_law is not None else None, case.lift_law)
    except (ArithmeticError, ValueError) as error:  # numbers at which the parts' formulas end
        raise InputError(
            f"the parts of case '{case.name}' cannot be built ({error}); check its numbers and their units"
        ) from error
    operation = case.operation
    label_cut_off(operation.force_bandwidth)
    return Problem(
        case.record(),
        members,
        law,
        event,
        operation.engine_speeds,
        operation.cycles,
        operation.output_step,
        operation.force_bandwidth,
        case.train.cycles if case.train is not None else None,
        case.lift_law is not None,
    )


def lift_law_of(case: Case) -> LiftLaw:
    """The lift law of a case, zero lift where it has none; what it refuses is reported with its location
    in the case file.

    Raises :class:`InputError` for numbers that make no law.
    """
    try:
        return build_lift_law(case.lift_law)
    except InputError as error:
        if error.where or case.lift_law is None:
            raise
        keys = {word for word in re.findall(r"\w+", error.reason) if word in case.lift_law.values}
        path = ("lift_law", *keys) if len(keys) == 1 else ("lift_law",)
        line = find_line(case.text, path) if _is_text_of(case.text, case) else None
        place = f"case '{case.name}'" + (f", line {line}" if line else "")
        raise InputError(error.reason, f"{place}, {'.'.join(path)}") from error


def valve_lift_of(case: AnyCase) -> Callable[[Array], Array]:
    """The lift (m over cam rad) of the valve of a case where all parts are rigid and follow the cam.

    Raises :class:`InputError` for a case without a lift.
    """
    problem = build(case)
    if not problem.moves:
        raise InputError(
            f"case '{problem.record.name}' has no lift law, so nothing can be laid on its lift; add a [lift_law] table",
            "case",
        )
    gear = problem.members[0].gear
    lift = problem.valve_lift.lift if gear is None else gear.mechanism.kinematics.valve_lift
    return lambda angle: np.asarray(lift(angle), dtype=float)


def _is_text_of(text: str, case: Case) -> bool:
    """Whether a case's text is the file that a user wrote and holds the lift law of the case."""
    try:
        return not case.changed and parse_case(text).lift_law == case.lift_law
    except InputError:
        return False


def _spring_members(
    case: Case, law: LiftLaw, specs: tuple[SpringModelSpec, ...]
) -> tuple[Member, ...]:
    if not case.springs:
        raise InputError(
            f"case '{case.name}' holds no spring and no train, so there is nothing to run; add a [spring] or [train] table"
        )
    lift = (
        float(np.max(law.lift(np.linspace(0.0, 2 * np.pi, 721))))
        if case.lift_law is not None
        else 0.0
    )
    if sentence := binding_lift(case.springs, lift):
        raise InputError(f"case '{case.name}': {sentence}")
    chosen = specs or tuple(spring_model(word) for word in default_models(case.springs))
    rubbing = _rubbing(case.rubbing)
    members: list[Member] = []
    for spec in chosen:
        label = _free_label(plain_name(spec.word), [member.label for member in members])
        members.append(Member(label, spec, case.springs, law, rubbing=rubbing, name=case.name))
    return tuple(members)


def default_model(spring: InstalledSpring) -> str:
    """The model that describes a spring at rest best by the data that it has."""
    of_card = "modal-uniform" if spring.card and spring.card.mass else "massless"
    return "finite-element" if spring.wire else of_card


def default_models(springs: tuple[InstalledSpring, ...]) -> tuple[str, ...]:
    """Models of a spring case that names none: those of its spring that is known least."""
    models = set(map(default_model, springs))
    known = CARD_MODELS if "modal-uniform" in models else WIRE_MODELS
    return BARE_MODELS if "massless" in models else known


def _train_members(
    case: Case,
    train: TrainParameters,
    law: LiftLaw,
    specs: tuple[SpringModelSpec, ...],
    sets: tuple[str, ...],
) -> tuple[Member, ...]:
    if case.lift_law is None:
        raise InputError(f"case '{case.name}' holds no lift law; add a [lift_law] table")
    variants = train.requested(sets, [spec.word for spec in specs])
    if train.crank is not None and train.crank.top_dead_centre is None:
        train = train.replace(crank=_placed_crank(train.crank, law))
    gears: dict[TrainParameters, Gear] = {}
    members: list[Member] = []
    for variant in variants:
        own = variant.apply(train)
        chosen = own.spring_set or next(iter(own.springs), "")
        springs = own.spring_parts(chosen)
        # the same parts for all members whose train differs in its springs only
        bare = own.replace(
            springs={}, spring_set="", spring_model="", variants=(), rubbing=Rubbing()
        )
        if bare not in gears:
            mechanism = build_mechanism(bare, law, case.lift_law.lift_of)
            gas = None
            if bare.gas is not None:
                gas = monotone_table(np.asarray(bare.gas.cam_angles), np.asarray(bare.gas.forces))
            top = (
                case.lift_law.top_dead_centre if bare.crank is None else bare.crank.top_dead_centre
            )
            gears[bare] = Gear(mechanism, bare, gas, top)
        gear = gears[bare]
        _warn_of_valve(own.valve.mass, gear.mechanism.kinematics.maximum_lift)
        if sentence := binding_lift(springs, gear.mechanism.kinematics.maximum_lift, chosen):
            raise InputError(f"case '{case.name}': {sentence}")
        model = spring_model(own.model_of(chosen), "train.spring_model")
        name = plain_name(variant.spring_model or train.model_of(chosen))
        of_set = f"{variant.spring_set}, {name}" if len(sets) > 1 else name if specs else chosen
        label = _free_label(variant.label or of_set, [member.label for member in members])
        members.append(
            Member(
                label,
                model,
                springs,
                law,
                chosen,
                gear,
                _rubbing(own.rubbing),
                case.name,
                variant.note,
                not own.spring_model,
                own.why_no_rod(chosen),
            )
        )
    return tuple(members)


def _warn_of_valve(mass: float, lift: float) -> None:
    """Warn (:class:`UnusualValueWarning`) of a valve that is heavy for its lift: masses grow with the
    cube of the size, from 0.1 kg at 9 mm (cars) to some 400 kg at 80 mm (ships).
    """
    most, least = HEAVIEST * lift**3, LIGHTEST * lift**3
    if 0 < mass < least:
        warnings.warn(
            f"a valve of {mass * 1e3:.4g} g is light for a lift of {lift * 1e3:.4g} mm, where valves with retainer and locks weigh "
            f"{least * 1e3:.2g} g and more; check train.valve.mass and its unit",
            UnusualValueWarning,
            stacklevel=2,
        )
    if max(most, 0.1) < mass < BEYOND_ANY:
        warnings.warn(
            f"a valve of {mass:.4g} kg is heavy for a lift of {lift * 1e3:.4g} mm, where valves with retainer and locks weigh up to "
            f"{most:.2g} kg; check train.valve.mass and its unit",
            UnusualValueWarning,
            stacklevel=2,
        )


def _placed_crank(crank: CrankParameters, law: LiftLaw) -> CrankParameters:
    """The crank with the cam angle of its top dead centre, by the middle of the nose."""
    assert crank.lobe_centre is not None
    angle = np.linspace(0.0, 2 * np.pi, 14401)[:-1]
    lift = np.asarray(law.lift(angle), dtype=float)
    top = float(angle[int(np.argmax(lift))])
    away = np.mod(angle - top + np.pi, 2 * np.pi) - np.pi
    nose = top + float(np.mean(away[lift >= np.max(lift) * (1 - 1e-4)]))
    return replace(crank, top_dead_centre=nose - crank.lobe_centre / 2)


def _free_label(label: str, taken: list[str]) -> str:
    """The label, with a number where another variant bears it: it distinguishes results."""
    return next(
        one
        for n in range(1, len(taken) + 2)
        if (one := label if n == 1 else f"{label} ({n})") not in taken
    )


def _rubbing(rubbing: Rubbing) -> RadialRubbing | None:
    if rubbing.coefficient > 0 and rubbing.normal_force > 0:
        return RadialRubbing(rubbing.coefficient, rubbing.normal_force)
    return None
