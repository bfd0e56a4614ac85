"""Functions for programs: simulate, compare, sweep, critical_speeds, static_curve, with units in
their arguments.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, TypeVar

import numpy as np

from valvetrain.errors import InputError
from valvetrain.parameters.installed_spring import InstalledSpring
from valvetrain.parameters.loading import AnyCase
from valvetrain.parameters.spring import SpringDefinition
from valvetrain.runs.compare import compare_study
from valvetrain.runs.cost import FEWER_AT_REST, refuse_cost, spring_cost
from valvetrain.runs.prepared import largest_lift
from valvetrain.runs.request_fields import read_limit
from valvetrain.runs.requests import Compare, Run, SpeedRequest, Sweep, Watch
from valvetrain.runs.run import run_study, sweep_study
from valvetrain.runs.static_study import curve_by_model
from valvetrain.runs.statics import STEPS
from valvetrain.runs.stopping import shows_progress
from valvetrain.runs.workers import Progress
from valvetrain.solution.critical import CriticalSpeeds
from valvetrain.solution.static import StaticCurve
from valvetrain.solution.study import Study
from valvetrain.springs.own_spring import model_name
from valvetrain.springs.spec import spring_model as spec_of_model
from valvetrain.system.build import build, default_model
from valvetrain.units import Given, known_arguments, si

#: Engine speeds: ``"4200, 5600 rpm"``, ``"1000:9000:100 rpm"``, one or several numbers (rad/s of
#: the crank), pint quantities.
Speeds = Given | Sequence[Given]
#: A spring model or several, by name, class or instance (:func:`valvetrain.springs.own_spring.model_name`).
Models = Any
SpeedRequested = TypeVar("SpeedRequested", bound=SpeedRequest)


def simulate(
    case: AnyCase,
    engine_speeds: Speeds | None = None,
    models: Models = (),
    *,
    progress: Progress | None = None,
    **options: Any,
) -> Study:
    """Run a case at its engine speeds, or at given ones, by its variants or by given spring models.

    Parameters
    ----------
    case : Case, name of a library case, or path of a case file
    engine_speeds : speeds of the crank, "4200 rpm", "4000-8000", rad/s or pint quantities; the case's own by
        default
    models : a spring model, or several: its name, such as "multi-mass", its class, an instance, a function of
        the compression or a class of one's own (docs/extend/own-parts-in-a-script.md); the case's own or the default ones by default
    progress : called with the share done and a text
    options : further fields of :class:`valvetrain.runs.requests.Run`:
        ``spring_sets``, names of spring sets of a train;
        ``outputs``, names of quantities (docs/quantities.md) and channels: only these are computed and in the solutions;
        ``compute``, what else is computed: "error_bars", which takes two further runs of each that has none stored;
        ``workers``, runs at a time: results do not depend on it;
        ``limit``, largest estimated time and memory, such as "2 h, 8 GB"; 10 min and 2 GB by default;
        ``implausible``, True lets values pass that no valvetrain can have (docs/plausible.md)

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
    >>> study = vt.simulate("job-t", "2000 rpm", models=["massless"])
    >>> round(study.solution("massless").quantities["peak_spring_force"])
    522
    >>> study = vt.simulate("job-t", "2000 rpm", models="multi-mass", outputs="minimum_spring_force")
    >>> {name: round(value) for name, value in study.solutions[0].quantities.items()}
    {'minimum_spring_force': 216}
    """
    given = {"case": case, "engine_speeds": engine_speeds, "models": models, **options}
    return run_study(affordable(Run.read(given)), Watch(progress))


@shows_progress("compare")
def compare(
    case: AnyCase,
    engine_speeds: Speeds | None = None,
    models: Models = (),
    *,
    progress: Progress | None = None,
    **options: Any,
) -> Study:
    """A case by several spring models side by side, at rest and in motion.

    Parameters
    ----------
    models : as for :func:`simulate`; by default those that suit the case
    case, engine_speeds, progress, options : as for :func:`simulate`

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
    given = {"case": case, "engine_speeds": engine_speeds, "models": models, **options}
    return compare_study(affordable(Compare.read(given)), Watch(progress))


@shows_progress("sweep")
def sweep(
    case: AnyCase,
    engine_speeds: Speeds | None = None,
    models: Models = (),
    *,
    progress: Progress | None = None,
    **options: Any,
) -> Study:
    """A case over engine speed: numbers per speed and, of a train, where it loses contact, floats
    and bounces.

    Parameters
    ----------
    case, models, progress : as for :func:`simulate`
    engine_speeds : speeds of the crank, "1000:9000:100 rpm" (first:last:step), rad/s or pint
        quantities; by default to 1.2 times the red line or the highest speed of the case
    options : those of :func:`simulate`, and further fields of :class:`valvetrain.runs.requests.Sweep`:
        ``whole``, True stores the channels of every solution (megabytes each); without it solutions hold their
        events and named quantities only;
        ``critical_speeds``, False leaves out the search of a train's critical speeds; with ``outputs`` they are searched only
        where one of them is among these;
        ``resolution``, ``float_lift``, ``ranges`` as for :func:`critical_speeds`

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
    >>> study = vt.sweep("job-t", "1000:3000:1000 rpm", models=["massless"])
    >>> force = study.series("massless", "peak_spring_force")
    >>> [round(float(one)) for one in force.engine_speed], round(float(force[0])), force.attrs["units"]
    ([1000, 2000, 3000], 522, 'N')
    """
    given = {"case": case, "engine_speeds": engine_speeds, "models": models, **options}
    return sweep_study(affordable(Sweep.read(given)), Watch(progress))


@shows_progress("critical speeds")
def critical_speeds(
    case: AnyCase,
    engine_speeds: Speeds | None = None,
    models: Models = (),
    *,
    progress: Progress | None = None,
    **options: Any,
) -> CriticalSpeeds:
    """The engine speeds at which a train first loses contact, floats and bounces, each with its
    numerical error, its range over the damping of the springs and a word for the onset.

    Parameters
    ----------
    case, models, progress : as for :func:`simulate`
    engine_speeds : speeds of the crank between which settled motion is scanned, by default those of :func:`sweep`
    options : ``spring_sets``, ``workers``, ``limit`` and ``implausible`` as for :func:`simulate`;
        ``resolution``, a fifth of the distance of the speeds scanned, and to what a change is narrowed where the motion does
        not repeat; "10 rpm", rad/s or a pint quantity;
        ``float_lift``, lift above the rigid one beyond which the valve floats, "0.05 mm", m or a pint quantity;
        ``ranges``, repeat each speed with finer numerics and with the springs' damping times 0.6 and 1.5;
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
    >>> vt.critical_speeds("tdi-pushrod", "6800:7600:200 rpm", models="massless", spring_sets="stock", ranges=False)
    critical engine speeds (rpm)
      massless, contact-loss: 7121 (nominal), at the cam; until 7600 or more
      massless, float: none up to 7600
      massless, bounce: none up to 7600
    """
    study = sweep(case, engine_speeds, models, progress=progress, **options)
    if not len(study.critical_speeds):
        raise InputError(
            f"case '{study.record.name}' has no train that runs, so nothing loses contact; give a case with a [train] table"
        )
    return study.critical_speeds


def affordable(request: SpeedRequested) -> SpeedRequested:
    """The request with its speeds. Raises :class:`InputError` where its estimated cost is beyond its limits."""
    request = request.with_speeds()
    refuse_cost(request.cost(), request.limit, "limit=")
    return request


@known_arguments
def static_curve(
    spring: SpringDefinition | InstalledSpring | AnyCase,
    largest_compression: Given | None = None,
    *,
    models: Any = "",
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
    models : the spring model, as for :func:`simulate`; by default finite elements of a wire. The
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
    >>> wire = vt.parameters.SpringDefinition("3.8 mm", "22 mm", "7 mm", total_coils=7, material="OTEVA 90 SC")
    >>> curve = vt.static_curve(wire, "8 mm", models="multi-mass")
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
    model = model_name(models or default_model(installed), "models")
    spec_of_model(model, "models")
    if not (isinstance(steps, (int, np.integer)) and steps >= 1):
        raise InputError(
            f"a static curve needs a whole number of steps, one or more; it is '{str(steps)[:40]}'",
            "steps",
        )
    end = None
    if largest_compression is not None:
        end = si(largest_compression, "compression", "largest_compression")
    bounds = read_limit(limit, "limit")
    refuse_cost(spring_cost(installed, model, steps), bounds, "limit=", FEWER_AT_REST)
    return curve_by_model(installed, model, lift, end, steps, implausible)
