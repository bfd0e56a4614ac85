"""Functions for programs: simulate, compare, sweep, critical_speeds, static_curve, with units in
their arguments.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from valvetrain.errors import InputError
from valvetrain.parameters.case import Case
from valvetrain.parameters.installed_spring import InstalledSpring
from valvetrain.parameters.loading import AnyCase, case_of
from valvetrain.parameters.spring import SpringDefinition
from valvetrain.registry import names as registered_names
from valvetrain.runs.compare import compare_study
from valvetrain.runs.cost import FEWER_AT_REST, Limits, limits_of, refuse_cost
from valvetrain.runs.critical_speeds import read_options
from valvetrain.runs.outputs import RequestedOutputs
from valvetrain.runs.prepared import largest_lift
from valvetrain.runs.request_cost import RunRequest, request_cost, spring_cost
from valvetrain.runs.run import run_study, sweep_speeds, sweep_study
from valvetrain.runs.statics import STEPS, curve_by_model, default_model
from valvetrain.runs.watch import shows_progress
from valvetrain.runs.workers import Progress, worker_count
from valvetrain.solution.critical import CriticalSpeeds
from valvetrain.solution.static import StaticCurve
from valvetrain.solution.study import Study
from valvetrain.springs.own_spring import model_name, model_names
from valvetrain.springs.spec import spring_model as spec_of_model
from valvetrain.system.build import build
from valvetrain.units import Given, as_names, known_arguments, si, si_speeds

#: Engine speeds: ``"4200, 5600 rpm"``, ``"1000:9000:100 rpm"``, one or several numbers (rad/s of
#: the crank), pint quantities.
Speeds = Given | Sequence[Given]
#: A spring model or several, by name, class or instance (:func:`valvetrain.springs.own_spring.model_name`).
Models = Any


def with_error_bars(compute: Sequence[str] | str) -> bool:
    """Whether error bars are among what is to be computed; :class:`InputError` for another name."""
    names = as_names(compute)
    for name in names:
        if name != "error_bars":
            raise InputError(f"'{name[:40]}' is nothing to compute; name error_bars", "compute")
    return bool(names)


@known_arguments
def simulate(
    case: AnyCase,
    engine_speeds: Speeds | None = None,
    spring_models: Models = (),
    *,
    spring_set: Sequence[str] | str = (),
    outputs: Sequence[str] | str = (),
    compute: Sequence[str] | str = (),
    workers: int | None = None,
    progress: Progress | None = None,
    limit: str = "",
    implausible: bool = False,
) -> Study:
    """Run a case at its engine speeds, or at given ones, by its variants or by given spring models.

    Parameters
    ----------
    case : Case, name of a library case, or path of a case file
    engine_speeds : speeds of the crank, "4200 rpm", rad/s or pint quantities; the case's own by
        default
    spring_models : a spring model, or several: its name, such as "multi-mass", its class, an instance, a function of
        the compression or a class of one's own (docs/extend/own-parts-in-a-script.md); the case's own or the default ones by default
    spring_set : name of a spring set of a train, or several
    outputs : names of quantities (docs/quantities.md) and channels; only these are computed and in
        the solutions
    compute : what else is computed: "error_bars", which takes two further runs of each that has none stored
    workers : runs at a time; results do not depend on it
    progress : called with the share done and a text
    limit : largest estimated time and memory, such as "2 h, 8 GB"; 10 min and 2 GB by default
    implausible : let values pass that no valvetrain can have (docs/plausible.md)

    Returns
    -------
    Study with one solution per run; a run that fails is a status in it

    Raises
    ------
    InputError : one sentence on what cannot be built or run, is too large or implausible, and the
        remedy; a name that no output has, with the nearest

    Examples
    --------
    >>> import valvetrain as vt
    >>> study = vt.simulate("job-t", "2000 rpm", spring_models=["massless"])
    >>> round(study.solution("massless").quantities["peak_spring_force"])
    522
    >>> study = vt.simulate("job-t", "2000 rpm", spring_models="multi-mass", outputs="minimum_spring_force")
    >>> {name: round(value) for name, value in study.solutions[0].quantities.items()}
    {'minimum_spring_force': 216}
    """
    spring_models, sets = model_names(spring_models), as_names(spring_set)
    case = case_of(case)
    requested = RequestedOutputs.of(outputs, case.train is not None) if outputs else None
    limits = _checked(
        "run",
        case,
        speeds := _speeds(engine_speeds),
        spring_models,
        sets,
        workers,
        limit,
    )
    study = run_study(
        case,
        engine_speeds=speeds,
        spring_models=spring_models,
        spring_sets=sets,
        workers=workers,
        progress=progress,
        limits=limits,
        implausible=implausible,
        rest=requested is None or requested.rest,
        ends_alone=requested is not None and requested.ends_alone,
        error_bars=with_error_bars(compute),
    )
    return study if requested is None else requested.of_study(study)


@known_arguments
@shows_progress("compare")
def compare(
    case: AnyCase,
    engine_speeds: Speeds | None = None,
    spring_models: Models = (),
    *,
    spring_set: Sequence[str] | str = (),
    compute: Sequence[str] | str = (),
    workers: int | None = None,
    progress: Progress | None = None,
    limit: str = "",
    implausible: bool = False,
) -> Study:
    """A case by several spring models side by side, at rest and in motion.

    Parameters
    ----------
    spring_models : as for :func:`simulate`; by default those that suit the case
    case, engine_speeds, spring_set, compute, workers, progress, limit, implausible : as for
        :func:`simulate`

    Returns
    -------
    Study with one solution per model and speed, and in ``rest`` the static curve and frequencies of
    each spring by each model

    Raises
    ------
    InputError : as :func:`simulate`, and for models where speeds belong; MissingExtraError for solid finite elements without their solver

    Examples
    --------
    >>> import valvetrain as vt
    >>> study = vt.compare("job-t", "2000 rpm", ["massless", "wave-rod"])
    >>> [round(one.curve.force_at(7e-3)) for one in study.rest]
    [215, 215]
    """
    spring_models, sets = model_names(spring_models), as_names(spring_set)
    limits = _checked(
        "compare",
        case := case_of(case),
        speeds := _speeds(engine_speeds),
        spring_models,
        sets,
        workers,
        limit,
    )
    return compare_study(
        case,
        engine_speeds=speeds,
        spring_models=spring_models,
        spring_sets=sets,
        workers=workers,
        progress=progress,
        limits=limits,
        implausible=implausible,
        error_bars=with_error_bars(compute),
    )


@known_arguments
@shows_progress("sweep")
def sweep(
    case: AnyCase,
    engine_speeds: Speeds | None = None,
    spring_models: Models = (),
    *,
    spring_set: Sequence[str] | str = (),
    outputs: Sequence[str] | str = (),
    compute: Sequence[str] | str = (),
    whole: bool = False,
    workers: int | None = None,
    progress: Progress | None = None,
    critical_speeds: bool = True,
    resolution: Given = "10 rpm",
    float_lift: Given = "50 um",
    bounce_height: Given = "100 um",
    ranges: bool = True,
    limit: str = "",
    implausible: bool = False,
) -> Study:
    """A case over engine speed: numbers per speed and, of a train, where it loses contact, floats
    and bounces.

    Parameters
    ----------
    case, spring_models, spring_set, outputs, compute, workers, progress, limit, implausible : as
        for :func:`simulate`
    engine_speeds : speeds of the crank, "1000:9000:100 rpm" (first:last:step), rad/s or pint
        quantities; by default to 1.2 times the red line or the highest speed of the case
    whole : store the channels of every solution (megabytes each); without it solutions hold their
        events and named quantities only
    critical_speeds : search a train's critical speeds between the lowest and the highest speed, as
        :func:`critical_speeds` does; with ``outputs`` only where one of them is among these
    resolution, float_lift, bounce_height, ranges : as for :func:`critical_speeds`

    Returns
    -------
    Study whose ``series(label, name)`` gives speeds (n,) in rad/s and values (n,) in SI, and whose
    ``critical_speeds`` what was found

    Raises
    ------
    InputError : as :func:`simulate`

    Examples
    --------
    >>> import valvetrain as vt
    >>> study = vt.sweep("job-t", "1000:3000:1000 rpm", spring_models=["massless"])
    >>> speeds, force = study.series("massless", "peak_spring_force")
    >>> len(speeds), round(force[0])
    (3, 522)
    """
    spring_models, sets = model_names(spring_models), as_names(spring_set)
    case = case_of(case)
    given = _speeds(engine_speeds)
    speeds = sweep_speeds(case) if given is None else given
    requested = RequestedOutputs.of(outputs, case.train is not None) if outputs else None
    if requested is not None:
        critical_speeds = critical_speeds and requested.searches
        whole = whole or bool(requested.channels)
    critical = (
        read_options(resolution, float_lift, bounce_height, ranges) if critical_speeds else None
    )
    limits = _checked(
        "sweep",
        case,
        speeds,
        spring_models,
        sets,
        workers,
        limit,
        whole,
        critical is not None,
    )
    study = sweep_study(
        case,
        speeds,
        spring_models=spring_models,
        spring_sets=sets,
        whole=whole,
        workers=workers,
        progress=progress,
        critical=critical,
        limits=limits,
        implausible=implausible,
        rest=requested is None or requested.rest,
        ends_alone=requested is not None and requested.ends_alone,
        error_bars=with_error_bars(compute),
    )
    return study if requested is None else requested.of_study(study)


@known_arguments
@shows_progress("critical speeds")
def critical_speeds(
    case: AnyCase,
    engine_speeds: Speeds | None = None,
    spring_models: Models = (),
    *,
    spring_set: Sequence[str] | str = (),
    resolution: Given = "10 rpm",
    float_lift: Given = "50 um",
    bounce_height: Given = "100 um",
    ranges: bool = True,
    workers: int | None = None,
    progress: Progress | None = None,
    limit: str = "",
    implausible: bool = False,
) -> CriticalSpeeds:
    """The engine speeds at which a train first loses contact, floats and bounces, each with its
    numerical error, its range over the damping of the springs and a word for the onset.

    Parameters
    ----------
    case, spring_models, spring_set, workers, progress, limit, implausible : as for
        :func:`simulate`
    engine_speeds : speeds of the crank between which settled motion is scanned, by default those of :func:`sweep`
    resolution : a fifth of the distance of the speeds scanned, and to what a change is narrowed where the motion does
        not repeat; "10 rpm", rad/s or a pint quantity
    float_lift : lift above the rigid one beyond which the valve floats, "50 um", m or a pint
        quantity
    bounce_height : height above the seat beyond which a bounce counts, likewise
    ranges : repeat each speed with finer numerics and with the springs' damping times 0.6 and 1.5;
        False gives the nominal speeds alone, in about half the time

    Returns
    -------
    CriticalSpeeds, a row per label and kind: ``engine_speed``, a root, moves smoothly with the inputs, ``span`` is its
    range, ``ranges`` are all of lost control, ``onset`` is sharp, graze or non-repeating; all in rad/s

    Raises
    ------
    InputError : as :func:`simulate`, and for a case without a train

    Examples
    --------
    >>> import valvetrain as vt
    >>> vt.critical_speeds("tdi-pushrod", "6800:7600:200 rpm", spring_models="massless", spring_set="stock", ranges=False)
    critical engine speeds (rpm)
      massless, contact-loss: 7121 (nominal), at the cam; until 7600 or more
      massless, float: none up to 7600
      massless, bounce: none up to 7600
    """
    found = sweep(
        case,
        engine_speeds,
        spring_models=spring_models,
        spring_set=spring_set,
        workers=workers,
        progress=progress,
        resolution=resolution,
        float_lift=float_lift,
        bounce_height=bounce_height,
        ranges=ranges,
        limit=limit,
        implausible=implausible,
    )
    if not len(found.critical_speeds):
        raise InputError(
            f"case '{found.record.name}' has no train that runs, so nothing loses contact; give a case with a [train] table"
        )
    return found.critical_speeds


@known_arguments
def static_curve(
    spring: SpringDefinition | InstalledSpring | AnyCase,
    largest_compression: Given | None = None,
    *,
    spring_model: Any = "",
    steps: int = STEPS,
    limit: str = "",
    implausible: bool = False,
) -> StaticCurve:
    """Force and stiffness over compression of one spring from its free state, coils closing.

    Parameters
    ----------
    spring : a spring of one's own, an installed spring (``case.springs[0]``), or a case with one
        spring (as for :func:`simulate`)
    largest_compression : end of the curve (m, "8 mm" or a pint quantity); by default a little
        beyond the largest lift of the case, or 80 %
        of the way to coil bind where there is no lift
    spring_model : the spring model, as for :func:`simulate`; by default finite elements of a wire. The
        curve of a card is the card's
    steps : even steps of the curve
    limit, implausible : as for :func:`simulate`

    Returns
    -------
    StaticCurve of arrays (steps + 1,): compression m, force N, stiffness N/m; shorter, with a
    status, where no equilibrium is found, and
    with the status "diverged" where its force is none that a spring can have

    Raises
    ------
    InputError : a compression beyond coil bind, several springs in the case, a model that cannot represent the spring,
        too many steps

    Examples
    --------
    >>> import valvetrain as vt
    >>> curve = vt.static_curve(vt.parameters.cylindrical("3.8 mm", "22 mm", "7 mm", total_coils=7), "8 mm", spring_model="multi-mass")
    >>> round(curve.force_at("4 mm")), round(curve.force_at("8 mm"))
    (149, 313)
    """
    installed, lift = (
        InstalledSpring(wire=spring) if isinstance(spring, SpringDefinition) else spring,
        0.0,
    )
    if not isinstance(installed, InstalledSpring):
        problem = build(installed)
        if len(problem.springs) > 1:
            names = ", ".join(f"'{one.name}'" for one in problem.springs)
            raise InputError(
                f"case '{problem.record.name}' holds {len(problem.springs)} springs ({names}); give one, such as case.springs[0]"
            )
        installed, lift = problem.springs[0], largest_lift(problem)
    spring_model = model_name(spring_model or default_model(installed), "spring_model")
    spec_of_model(spring_model, "spring_model")
    if not (isinstance(steps, (int, np.integer)) and steps >= 1):
        raise InputError(
            f"a static curve needs a whole number of steps, one or more; it is '{str(steps)[:40]}'",
            "steps",
        )
    end = None
    if largest_compression is not None:
        end = si(largest_compression, "compression", "largest_compression")
    limits = limits_of(limit)
    refuse_cost(spring_cost(installed, spring_model, steps), limits, "limit=", FEWER_AT_REST)
    return curve_by_model(installed, spring_model, lift, end, steps, implausible)


def _checked(
    command: str,
    case: Case,
    speeds: tuple[float, ...] | None,
    models: Sequence[str],
    sets: Sequence[str],
    workers: int | None,
    limit: str,
    whole: bool = True,
    searches: bool = False,
) -> Limits:
    """The limits of a request. Raises :class:`InputError` where its estimated cost is beyond them."""
    limits = limits_of(limit)
    request = RunRequest(command, case, speeds, tuple(models), tuple(sets), worker_count(workers))
    refuse_cost(request_cost(request, whole, searches), limits, "limit=")
    return limits


def _speeds(engine_speeds: Speeds | None) -> tuple[float, ...] | None:
    if engine_speeds is None:
        return None
    given = (engine_speeds,) if isinstance(engine_speeds, str) else engine_speeds
    texts = [one for one in given if isinstance(one, str)] if isinstance(given, Sequence) else []
    models = set(",".join(texts).replace(" ", "").split(",")) & set(registered_names("springs"))
    if models:
        raise InputError(
            f"'{min(models)}' is a spring model, and engine speeds come first: (case, engine_speeds, spring_models), such as "
            "compare('job-t', '3000 rpm', ['massless', 'multi-mass'])",
            "engine_speeds",
        )
    return si_speeds(engine_speeds)
