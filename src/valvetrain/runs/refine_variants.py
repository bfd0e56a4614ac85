"""Variants of a refinement: members of a case with finer springs, a halved step or other contact constants, prepared."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import replace
from functools import partial
from typing import Any, NamedTuple

from valvetrain.contact.dissipative import damping_number, rebound
from valvetrain.errors import InputError
from valvetrain.parameters.case import Case
from valvetrain.parameters.installed_spring import InstalledSpring
from valvetrain.parameters.schema_contact import ContactParameters
from valvetrain.quantities.statics import modal_quantities
from valvetrain.runs.error_bars import STIFFNESS_FACTORS, Numbers, damped, divided, stiffened
from valvetrain.runs.prepared import FAILURES, PreparedRun, prepare
from valvetrain.runs.statics import MODES
from valvetrain.runs.stored_error_bars import ROD
from valvetrain.runs.train_runs import member_statics
from valvetrain.solution.critical import DAMPING_FACTORS
from valvetrain.solution.status import reason
from valvetrain.solution.uncertainty import CONSTANTS
from valvetrain.springs.finite_element import FiniteElementRod, modal_result
from valvetrain.system.build import build
from valvetrain.system.prescribed import names_of
from valvetrain.system.problem import Member, Problem

#: Parts of a spring over those of the case.
DIVISION = (1.5, 2.25)
#: The variant that finite-element springs of a train leave out: their elements and steps would both be 2.25 times as many.
TOO_FINE = "mesh 3"
#: A spring of a member, changed.
Change = Callable[[Member, InstalledSpring], InstalledSpring]


class Variant(NamedTuple):
    """A member, by its index, of a ``problem`` in which something is changed, and the ``change`` of its springs."""

    name: str
    member: int
    problem: Problem
    change: Change


def place_of(member: Member, variant: str) -> str:
    """A variant as failures and stored numbers name it."""
    return variant if member.gear is None else f"{member.label}, {variant}"


def is_large(member: Member) -> bool:
    """Whether the springs of a train are too large for many runs."""
    return member.gear is not None and member.model.word == ROD


def variants_of(
    case: Case, problem: Problem, own: Mapping[int, PreparedRun], failures: list[str]
) -> list[Variant]:
    """The variants of the members that run; why others cannot be built is added to ``failures``."""
    variants = []
    for name, other, change in _changes(case, problem):
        try:
            built = build(other).settled() if isinstance(other, Case) else other
        except FAILURES as error:
            failures.append(f"{name}: {reason(error)}")
            continue
        variants += [
            Variant(name, index, built, change)
            for index in own
            if name != TOO_FINE or not is_large(problem.members[index])
        ]
    return variants


def _changes(case: Case, problem: Problem) -> Iterator[tuple[str, Problem | Case, Change]]:
    """Name of each variant, its problem or the case to build it from, and the change of its springs."""

    def half_step(_: Member, spring: InstalledSpring) -> InstalledSpring:
        rod = problem.model_of(ROD, spring)
        assert isinstance(rod, FiniteElementRod)
        return spring.with_options(ROD, time_step=0.5 * (rod.time_step or rod.stable_time_step()))

    for n, factor in enumerate(DIVISION, start=2):
        yield f"mesh {n}", problem, partial(divided, factor=factor)
    if case.train is None:
        yield "step 2", problem, half_step
    for constant, factors in zip(CONSTANTS, (STIFFNESS_FACTORS, DAMPING_FACTORS), strict=True):
        change = stiffened if constant == CONSTANTS[0] else damped
        for n, factor in enumerate(factors, start=1):
            name = f"{constant} {n}"
            if case.train is None:
                yield name, problem, _alone(change, factor)
                continue
            own = case.train.contacts.items()
            contacts = {place: with_constant(one, constant, factor) for place, one in own}
            springs = {
                label: tuple(change(one, factor) for one in group)
                for label, group in case.train.springs.items()
            }
            changed = case.train.replace(contacts=contacts, springs=springs)
            yield name, case.replace(train=changed), lambda _, one: one


def _alone(change: Callable[[InstalledSpring, float], InstalledSpring], factor: float) -> Change:
    return lambda _, spring: change(spring, factor)


def with_constant(contact: ContactParameters, constant: str, factor: float) -> ContactParameters:
    """A contact with another stiffness, or with another damping, which its restitution may replace."""
    values: Mapping[str, Any] = contact.values
    name = "contact_stiffness" if constant == CONSTANTS[0] else "damping"
    if name in values:
        return contact.replace(**{name: factor * values[name]})
    if constant == "damping" and 0 < values.get("restitution", 0.0) < 1:
        return contact.replace(restitution=rebound(factor * damping_number(values["restitution"])))
    return contact


def prepare_refined(
    problem: Problem, member: Member, surge: tuple[float, ...] = ()
) -> tuple[PreparedRun, Numbers]:
    """A member prepared, and of springs alone their static numbers.

    ``surge``: first surge frequencies (Hz) of springs alone, empty for those of this mesh. Raises
    :class:`InputError` for what cannot run.
    """
    ready = prepare(problem, member, member_statics(problem, member), problem.record.study)
    if ready.refusal:
        raise InputError(ready.refusal)
    if member.gear is not None:
        return ready, {}
    rods = rods_of(ready)
    if len(rods) != len(member.springs):
        raise InputError(
            "springs that rub on each other cannot be refined; leave the rubbing out of the case"
        )
    numbers: dict[str, float] = {}
    first: list[float] = []
    for rod, name in zip(rods, names_of(rods), strict=True):
        modes = modal_quantities(modal_result(rod, MODES))
        prefix = f"{name}_" if len(rods) > 1 else ""
        numbers |= {f"{prefix}preload": float(rod.installed.retainer_force)}
        numbers |= {prefix + key: value for key, value in modes.items()}
        first += [modes["mode_1_frequency"]] if "mode_1_frequency" in modes else []
    frame = replace(ready.frame, surge_frequencies=surge or tuple(first))
    return replace(ready, frame=frame), numbers


def prepare_variant(
    own: Mapping[int, PreparedRun], variant: Variant
) -> tuple[PreparedRun | None, Numbers, str]:
    """A variant prepared with its static numbers, or why it cannot be; nothing of one that changes nothing."""
    base, member = own[variant.member], variant.problem.members[variant.member]
    try:
        springs = tuple(variant.change(member, spring) for spring in member.springs)
        if member is base.member and springs == member.springs:
            return None, {}, ""
        if member.instead != base.member.instead:
            raise InputError(member.instead)  # another model is no variant
        changed, surge = replace(member, springs=springs), base.frame.surge_frequencies
        return (*prepare_refined(variant.problem, changed, surge), "")
    except FAILURES as error:
        return None, {}, f"{place_of(member, variant.name)}: {reason(error)}"


def rods_of(ready: PreparedRun) -> tuple[FiniteElementRod, ...]:
    """The finite-element rods of springs alone."""
    springs = () if ready.system is None else ready.system.springs
    return tuple(spring for spring in springs if isinstance(spring, FiniteElementRod))
