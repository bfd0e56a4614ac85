"""The refinement study of any case: of a spring under prescribed motion, or of a train."""

from __future__ import annotations

from collections.abc import Sequence

from valvetrain.parameters.case import Case
from valvetrain.parameters.loading import AnyCase, case_of
from valvetrain.runs.cost import FEWER_REFINED, Limits, limits_of, refuse_cost
from valvetrain.runs.engine import Progress, worker_count
from valvetrain.runs.error_bars import UncertaintyStudy
from valvetrain.runs.request_cost import refine_cost
from valvetrain.runs.train_uncertainty import train_uncertainty
from valvetrain.runs.uncertainty import uncertainty_study
from valvetrain.units import Given, si_speeds


def refine(
    case: AnyCase,
    engine_speeds: Given | Sequence[Given] | None = None,
    *,
    workers: int | None = None,
    progress: Progress | None = None,
    limit: str = "",
    implausible: bool = False,
) -> UncertaintyStudy:
    """Error bars of the headline numbers: finer meshes and steps, other contact constants.

    Numerical uncertainty by the grid convergence index (Roache 1994; Celik et al. 2008), of a
    spring from three meshes and a halved step,
    of a train from three steps and finer springs.

    Parameters
    ----------
    case : Case, name of a library case, or path of a case file; a spring with its wire and a lift
        law, or a train
    engine_speeds : speeds of the crank, "4200 rpm", rad/s or pint quantities; the case's own by
        default
    workers : runs at a time; results do not depend on it
    progress : told the share done and what was done
    limit : largest estimated time and memory, such as "2 h, 8 GB"; 10 min and 2 GB by default
    implausible : let values pass that no valvetrain can have (docs/plausible.md)

    Returns
    -------
    UncertaintyStudy whose ``rows`` hold value and uncertainty (SI) by quantity and speed; a variant
    that fails is one of its ``failures``

    Raises
    ------
    InputError : what cannot be built or refined, is too large or implausible
    RefinementStopped : a KeyboardInterrupt whose ``study`` holds what was finished

    Examples
    --------
    >>> import valvetrain as vt
    >>> case = vt.load_case("tdi-pushrod")
    >>> stock = case.replace(train=case.train.replace(variants=case.train.variants[:1]))
    >>> row = next(row for row in vt.refine(stock, "2000 rpm").rows if row.quantity == "peak_spring_force")
    >>> row.numerical < 0.01 * row.value
    True
    """
    limits, asked = limits_of(limit), case_of(case)
    speeds = None if engine_speeds is None else si_speeds(engine_speeds)
    count = worker_count(workers)
    refuse_cost(refine_cost(asked, speeds, count), limits, "limit=", FEWER_REFINED)
    return refined(
        asked, speeds, workers=count, progress=progress, limits=limits, implausible=implausible
    )


def refined(
    case: Case,
    engine_speeds: Sequence[float] | None = None,
    *,
    workers: int = 2,
    progress: Progress | None = None,
    limits: Limits = Limits(),
    implausible: bool = False,
) -> UncertaintyStudy:
    """Error bars of a case's headline numbers at ``engine_speeds`` (rad/s of the crank; None: the
    case's own), whatever they cost.

    ``limits`` of one run; ``implausible``: let pass what :mod:`valvetrain.quantities.plausible`
    calls nonsense. Raises
    :class:`InputError` for a case that cannot be refined, :class:`RefinementStopped` with what is
    finished when it is stopped.
    """
    if case.train is None:
        return uncertainty_study(
            case,
            engine_speeds,
            workers=workers,
            progress=progress,
            limits=limits,
            implausible=implausible,
        )
    return train_uncertainty(
        case, engine_speeds, workers=workers, progress=progress, implausible=implausible
    )
