"""What a study, a search or an identification of a file is asked: one frozen request per command, whose fields are its options and
its arguments in Python; and the functions that take them.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, partial
from importlib import import_module
from typing import TYPE_CHECKING, Any, ClassVar

from valvetrain.errors import InputError
from valvetrain.explore.execution import Execution, Watch, silent
from valvetrain.runs.request_fields import option, read_count, read_text
from valvetrain.runs.stopping import shows_progress

if TYPE_CHECKING:
    from valvetrain.explore.distributions import Prior
    from valvetrain.explore.files import FileText
    from valvetrain.explore.identification_file import Search
    from valvetrain.explore.identified import Identified
    from valvetrain.explore.optimum import Optimum
    from valvetrain.explore.posterior import Datum, Evaluate
    from valvetrain.explore.table import StudyTable
    from valvetrain.runs.workers import Progress


#: The model of a file, what makes a plan of its text, and what computes the plan.
Steps = tuple[type[Any], Callable[[Any], Any], Callable[..., Any]]


@dataclass(frozen=True, kw_only=True)
class FileRequest(Execution):
    """A request that a file makes."""

    command: ClassVar[str]

    file: str = option(
        read_text,
        "File (TOML): its case, what is varied, and what is asked of it.",
        metavar="FILE",
    )

    @property
    def steps(self) -> Steps:
        """Those of the module of the command."""
        steps: Steps = import_module(f"valvetrain.explore.{self.command}").STEPS
        return steps

    @cached_property
    def text(self) -> FileText[Any]:
        """The file, read and checked."""
        from valvetrain.explore.files import FileText

        return FileText.read(self.file, self.steps[0])

    @cached_property
    def plan(self) -> Any:
        """What the file plans."""
        return self.steps[1](self.text)

    def compute(self, watch: Watch) -> Any:
        """The result of the plan."""
        return self.steps[2](self.plan, self, watch)


@dataclass(frozen=True, kw_only=True)
class Study(FileRequest):
    """A parameter study."""

    command = "study"


@dataclass(frozen=True, kw_only=True)
class Optimise(FileRequest):
    """A search of the best design."""

    command = "optimise"


@dataclass(frozen=True, kw_only=True)
class Identify(FileRequest):
    """An identification from measurements."""

    command = "identify"

    search: Search | None = option(
        lambda given, where: given, "Method and options of the search, instead of the file's."
    )
    method: str | None = option(
        read_text, "least-squares or nested instead of the file's.", "--method", "METHOD"
    )
    seed: int | None = option(
        partial(read_count, 0, 10**7), "Seed of all random numbers.", "--seed", "N"
    )

    @cached_property
    def plan(self) -> Any:
        """What the file plans, by the method and the seed of the request."""
        plan = super().plan
        given = {"method": self.method, "seed": self.seed}
        changes = {key: one for key, one in given.items() if one is not None}
        return replace(plan, search=(self.search or plan.search).changed(**changes))


@shows_progress("study")
def study(
    file: str | os.PathLike[str], *, progress: Progress | None = None, **options: Any
) -> StudyTable:
    """Points of a study over any quantities of a case: how outputs scatter, what makes them
    scatter.

    Parameters
    ----------
    file : path of a study file (docs/studies.md), or its text
    progress : called with the share done and a text
    options : further fields of :class:`valvetrain.explore.requests.Study`:
        ``workers``, points at a time: results do not depend on it;
        ``dask``, "local", the address of a Dask scheduler or the path of its file; empty for processes of
        this machine;
        ``output``, folder of the finished points, where a study that was stopped or killed continues: none by default;
        ``limit``, largest estimated time and memory, such as "2 h, 8 GB"; 10 min and 2 GB by default

    Returns
    -------
    StudyTable with a row per point: inputs (n, d) and outputs (n, m) in SI, their status, Sobol
    indices where requested

    Raises
    ------
    InputError : one sentence on what is wrong in the file and where, or on a request that is too
        large
    MissingExtraError : Dask or SALib is needed and not installed

    Examples
    --------
    >>> import valvetrain as vt
    >>> table = vt.study('''
    ... case = "job-c"
    ... engine_speeds = "4000 rpm"
    ... spring_models = "massless"
    ... outputs = "peak_spring_force"
    ... points = { sampler = "list" }
    ... vary = [{ key = "spring.precompression", values = "6, 8 mm" }]
    ... ''', workers=1)
    >>> bool(table.column("peak_spring_force")[1] > table.column("peak_spring_force")[0])
    True
    """
    table: StudyTable = Study.read({"file": file, **options}).compute(Watch(progress or silent))
    return table


@shows_progress("optimise")
def optimise(
    file: str | os.PathLike[str], *, progress: Progress | None = None, **options: Any
) -> Optimum:
    """Search springs and lift laws for the best values of any quantities within bounds on any
    others.

    Parameters
    ----------
    file : path of an optimisation file (docs/optimisation.md), or its text
    progress : called with the share done and a text
    options : further fields of :class:`valvetrain.explore.requests.Optimise`: ``workers``, ``dask``, ``output`` and ``limit``, as for
        :func:`valvetrain.study`

    Returns
    -------
    Optimum with every trial in SI, the case itself as trial 0, the best design or the front of
    several objectives, and the numbers of the best by other models

    Raises
    ------
    InputError : one sentence on what is wrong in the file and where, or on a request that is too
        large
    MissingExtraError : the library of the search is not installed

    Examples
    --------
    The smallest preload with 20 mm of lift left until the coils are solid:

    >>> import valvetrain as vt
    >>> found = vt.optimise('''
    ... case = "job-c"
    ... vary = [{ key = "spring.precompression", low = "5 mm", high = "9 mm" }]
    ... objective = [{ quantity = "preload", direction = "minimise" }]
    ... constraint = [{ quantity = "installed_compression", at_least = "6 mm" }]
    ... rest_model = "massless"
    ... search = { trials = 12 }
    ... ''', workers=1)
    >>> round(1e3 * float(found.best.trial.values[0]), 1)
    6.0
    """
    found: Optimum = Optimise.read({"file": file, **options}).compute(Watch(progress or silent))
    return found


@shows_progress("identify")
def identify(
    quantities: Mapping[str, Prior] | str | os.PathLike[str],
    measurements: Sequence[Datum] = (),
    evaluate: Evaluate | None = None,
    *,
    search: Search | None = None,
    progress: Progress | None = None,
    **options: Any,
) -> Identified:
    """Quantities that meet measurements, with their prior: their most probable
    values, intervals and branches.

    Parameters
    ----------
    quantities : path of an identification file (docs/identification.md), which says all the rest, or its text;
        or the prior of each quantity by name
    measurements : data of a computation of one's own
    evaluate : points (n, quantities) in SI -> for each a mapping of names to numbers (SI), None for
        one that is impossible
    search : method and its options; those of the file by default
    progress : called with the share done and a text
    options : ``output``, ``workers``, ``dask`` and ``limit``, as for :func:`valvetrain.study`; of a file also ``method`` and
        ``seed`` instead of the file's. A computation of one's own has no workers and no limit

    Returns
    -------
    Identified: branches, intervals, correlations, what the data determine, and the percentile of
    each measurement in its prediction

    Raises
    ------
    InputError : one sentence on what is wrong with the file or the data, cannot be computed or is
        too large; MissingExtraError where the
        library of a method is not installed; RunFailedError where a point is lost with its worker

    Examples
    --------
    >>> import valvetrain as vt
    >>> def surge(points):
    ...     return [{"load": 7e-3 * rate, "surge": 0.5 * (rate / mass) ** 0.5} for rate, mass in points]
    >>> priors = {"rate": vt.explore.Prior("uniform", 20e3, 60e3), "mass": vt.explore.Prior("normal", centre=0.05, spread=0.01)}
    >>> found = vt.identify(priors, [vt.explore.Datum("load", 280.0, 2.0), vt.explore.Datum("surge", 447.0, 3.0)], surge)
    >>> print(f"{found.best['rate']:.0f} N/m, {1e3 * found.best['mass']:.1f} g")
    40000 N/m, 50.0 g
    """
    watch = Watch(progress or silent)
    if not isinstance(quantities, Mapping):
        request = Identify.read({"file": quantities, "search": search, **options})
        result: Identified = request.compute(watch)
        return result
    if evaluate is None:
        raise InputError(
            "a computation is missing; give evaluate, or the path of an identification file"
        )
    import numpy as np

    from valvetrain.explore.identification_file import IdentificationPlan
    from valvetrain.explore.identify import run_identification
    from valvetrain.explore.observe import FunctionPoints
    from valvetrain.explore.space import Space

    space, data = Space(quantities), tuple(measurements)
    points = FunctionPoints(lambda row: evaluate(np.array([row]))[0], repr((tuple(space), data)))
    plan = IdentificationPlan(space, data, points)
    if search is not None:
        plan = replace(plan, search=search)
    return run_identification(plan, Execution.read({**options, "workers": 1}), watch)
