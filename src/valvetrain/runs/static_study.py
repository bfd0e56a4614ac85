"""The springs of a case at rest, by one model or several: what ``valvetrain static`` and
``valvetrain modes`` show.
"""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from valvetrain.errors import InputError
from valvetrain.parameters.case import Case
from valvetrain.parameters.installed_spring import InstalledSpring
from valvetrain.quantities.plausible import plausible_rest, refuse_implausible_motion
from valvetrain.quantities.statics import buckling_quantities, rest_quantities, size_quantities
from valvetrain.runs.engine import Progress
from valvetrain.runs.notes import largest_lift
from valvetrain.runs.statics import at_rest, points_asked, reach_of, rest_by_model
from valvetrain.solution.provenance import collect_provenance
from valvetrain.solution.static import SpringAtRest, StaticCurve
from valvetrain.solution.study import Study
from valvetrain.springs.contract import SpringModel
from valvetrain.springs.finite_element import FiniteElementRod
from valvetrain.springs.spec import spring_model
from valvetrain.system.build import build

#: What computes a spring at rest where nothing else is asked for: of a wire, of a card with and
#: without a mass.
WIRE, CARD, BARE = "finite-element", "modal-uniform", "massless"
#: Steps of the curve beside modes.
CURVE_OF_MODES = 24


def rest_study(
    case: Case,
    spring_models: Sequence[str] = (),
    *,
    spring_sets: Sequence[str] = (),
    command: str = "static",
    largest_compression: float | None = None,
    compression: float | None = None,
    steps: int = CURVE_OF_MODES,
    modes: int = 0,
    heights: Sequence[float] = (),
    loads: Sequence[float] = (),
    attached_mass: float | None = None,
    progress: Progress | None = None,
    implausible: bool = False,
) -> Study:
    """Static curve and natural frequencies of every spring of a case by each of ``spring_models``
    (empty: the one that knows it best).

    ``largest_compression`` (m from the free state): end of the curve, None for a little beyond full
    lift. ``compression`` (m): state that
    the ``modes`` lowest modes are about, None for the installed one. ``heights`` (m), ``loads``
    (N): states to solve as well.
    ``attached_mass`` (kg): moves with the retainer in the modes of a wire, 0 for a free end, None
    for both ends fixed. ``implausible``:
    let pass what :mod:`valvetrain.quantities.plausible` calls nonsense. Raises :class:`InputError`
    for a compression beyond coil bind, a
    model that cannot stand for a spring and a lift that no cam gives.
    """
    begun = time.perf_counter()
    problem = build(case, spring_sets=spring_sets)
    if problem.moves and not implausible:
        refuse_implausible_motion(problem.valve_lift, ())
    lift = largest_lift(problem)
    found: list[SpringAtRest] = []
    still: dict[str, dict[str, float]] = {}
    for installed in problem.springs:
        spring = installed if compression is None else _compressed(installed, compression)
        reach = _reach(spring, lift, largest_compression)
        words = tuple(spring_models) or (default_name(spring),)
        rest = None
        for word in words:
            spec = spring_model(word, "--spring")
            if reason := spec.why_not(spring):
                raise InputError(reason, "--spring")
            if spec.no_motion:
                remedy = f"its curve and modes stand beside the rod's in 'valvetrain compare CASE --spring {WIRE},{word}'"
                raise InputError(
                    f"{word} finite elements are asked for by compare: {remedy}", "--spring"
                )
            if spec.needs_rest and rest is None:
                rest = _by_rod(problem.model_of(WIRE, spring), reach, None, max(modes, 8))
            if attached_mass is not None and word != WIRE:
                raise InputError(
                    f"modes with a mass on the retainer are those of {WIRE}; leave {word} out",
                    "--spring",
                )
            model = problem.model_of(word, spring, rest)
            one = (
                _by_rod(model, reach, steps, modes, attached_mass)
                if word == WIRE
                else rest_by_model(spring, word, model, np.linspace(0.0, reach, steps + 1), modes)
            )
            one = replace(one, points=points_asked(spring, model, one, heights, loads))
            found.append(one if implausible else plausible_rest(one))
            label = f"{one.spring}, {one.model}"
            again = sum(other == label or other.startswith(f"{label}, ") for other in still)
            told = (
                size_quantities(spring)
                | rest_quantities(one)
                | buckling_quantities(installed, one, lift)
            )
            still[f"{label}, {again + 1}" if again else label] = told
            if progress is not None:
                progress(
                    len(found) / (len(problem.springs) * len(words)), f"{spring.name} by {word}"
                )
    if len(found) == 1:
        still = {"": next(iter(still.values()))}
    record = problem.record
    origin = collect_provenance(
        record.name,
        ", ".join(dict.fromkeys(one.model for one in found)),
        citations=record.citations,
    )
    return Study(
        record,
        command,
        (),
        tuple(found),
        still,
        provenance=origin,
        wall_time=time.perf_counter() - begun,
    )


def default_name(spring: InstalledSpring) -> str:
    """The model that knows a spring at rest best, of what is told of it."""
    return WIRE if spring.wire else CARD if spring.card and spring.card.mass else BARE


def curve_by_model(
    spring: InstalledSpring,
    word: str,
    valve_lift: float,
    wanted: float | None,
    steps: int,
    implausible: bool = False,
) -> StaticCurve:
    """Static curve of one spring by a model up to ``wanted`` (m from the free state), None for a
    little beyond ``valve_lift`` (m);
    ``implausible`` as for :func:`rest_study`.

    Raises :class:`InputError` for a model that cannot stand for the spring or has no static curve,
    and for a compression beyond coil bind.
    """
    spec, reach = (
        spring_model(word, "spring_model"),
        _reach(spring, valve_lift, wanted, "largest_compression"),
    )
    if reason := spec.why_not(spring):
        raise InputError(reason, "spring_model")
    if spec.no_motion:
        raise InputError(
            f"{word} is asked for by compare, or by SolidSpring.static_curve; choose another model",
            "spring_model",
        )
    rest = _by_rod(spring_model(WIRE).build(spring), reach, None, 8) if spec.needs_rest else None
    one = rest_by_model(
        spring, word, spec.build(spring, rest), np.linspace(0.0, reach, steps + 1), 0
    )
    curve = (one if implausible else plausible_rest(one)).curve
    assert curve is not None
    return curve


def _by_rod(
    rod: SpringModel,
    reach: float,
    steps: int | None,
    modes: int,
    attached_mass: float | None = None,
) -> SpringAtRest:
    assert isinstance(rod, FiniteElementRod)
    return at_rest(rod, reach, steps, modes, attached_mass=attached_mass)


def _compressed(spring: InstalledSpring, compression: float) -> InstalledSpring:
    if spring.wire is None:
        raise InputError(
            f"spring '{spring.name}' is known by its card, so only its installed state is; leave the option out",
            "--compression",
        )
    _check_room(spring, compression, "--compression")
    return replace(spring, precompression=compression)


def _reach(
    spring: InstalledSpring, lift: float, wanted: float | None, where: str = "--to"
) -> float:
    if wanted is not None:
        if not wanted > 0:
            raise InputError(
                f"a static curve needs a positive compression; it is {wanted * 1e3:g} mm", where
            )
        if spring.wire is not None:
            _check_room(spring, wanted, where)
        return wanted
    return (
        reach_of(spring, lift)
        if spring.wire is not None
        else spring.precompression + max(1.06 * lift, 0.2 * spring.precompression)
    )


def _check_room(spring: InstalledSpring, compression: float, where: str) -> None:
    assert spring.wire is not None
    room = spring.wire.free_length - spring.wire.solid_height
    if compression >= room:
        raise InputError(
            f"{compression * 1e3:g} mm is too much for '{spring.name}', which is solid at {room * 1e3:.4g} mm; give less",
            where,
        )
