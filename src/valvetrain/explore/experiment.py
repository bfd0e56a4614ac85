"""The experiment: a case or a function, a space and outputs, with sampling, sensitivity,
optimisation and calibration as verbs.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from valvetrain.errors import InputError
from valvetrain.explore.engine import Evaluation
from valvetrain.explore.execution import Execution, Watch, silent
from valvetrain.explore.samplers import listed
from valvetrain.explore.samplers import sampler as find_sampler
from valvetrain.explore.study import run_experiment
from valvetrain.explore.table import StudyTable
from valvetrain.runs.stopping import shows_progress
from valvetrain.runs.workers import Progress

if TYPE_CHECKING:
    import xarray

    from valvetrain.explore.identification_file import Search
    from valvetrain.explore.identified import Identified
    from valvetrain.explore.optimum import Optimum
    from valvetrain.explore.posterior import Datum


class Experiment(Evaluation):
    """Outputs over a space: of a ``case`` (a :class:`Case`, a name of the library or the path of a
    file), or of the function of ``outputs`` where it is None.

    ``runs``: engine speed, spring model and set of each run of a point; by default those of
    ``outputs``. The options of the verbs: ``workers`` (points at a time, all cores by default),
    ``dask`` (a cluster), ``output`` (folder of the finished points: an interrupted verb continues
    there), ``limit`` (largest time and memory, such as ``"2 h, 8 GB"``) and ``progress``. Results
    depend on none of them.

    >>> import valvetrain as vt
    >>> space = vt.Space({"spring.precompression": vt.explore.Prior("uniform", 6e-3, 8e-3)})
    >>> outputs = vt.Outputs(["peak_spring_force"], engine_speeds="4000 rpm", spring_models=["massless"])
    >>> found = vt.Experiment("job-c", space, outputs).run([[6e-3], [8e-3]], workers=1)
    >>> found.peak_spring_force.dims, found.status.values.ravel().tolist()
    (('point', 'speed', 'model'), ['completed', 'completed'])
    """

    def run(self, points: ArrayLike, **options: Any) -> xarray.Dataset:
        """Outputs at ``points`` (n, d) in SI: a Dataset over point, speed and model, with the
        status of every run of every point.
        """
        return self.table(points, **options).to_xarray()

    def table(self, points: ArrayLike, **options: Any) -> StudyTable:
        """The same as a :class:`StudyTable`."""

        given = np.atleast_2d(np.asarray(points, dtype=float))
        if given.shape[1] != len(self.space):
            raise InputError(
                f"a point has {len(self.space)} values; given are {given.shape[1]}", "points"
            )
        return run_experiment(self, listed(given), {}, **options)

    def sample(
        self,
        sampler: str = "sobol",
        options: Mapping[str, Any] | None = None,
        **execution: Any,
    ) -> StudyTable:
        """Points that a ``sampler`` draws with its ``options`` (docs/studies.md), such as
        ``{"count": 200, "seed": 1}``; those of ``saltelli`` with Sobol indices, ``sensitivities``.
        """

        return run_experiment(self, find_sampler(sampler, "sampler"), options or {}, **execution)

    @shows_progress("optimise")
    def optimise(
        self,
        objective: Sequence[Mapping[str, Any]],
        constraint: Sequence[Mapping[str, Any]] = (),
        search: Mapping[str, Any] | None = None,
        *,
        progress: Progress | None = None,
        **execution: Any,
    ) -> Optimum:
        """The best point by objectives within constraints; tables as in an optimisation file
        (docs/optimisation.md), such as ``{"quantity": "preload", "direction": "minimise"}``.
        """
        from valvetrain.explore.objective import plan_of_experiment
        from valvetrain.explore.optimise import run_search

        plan = plan_of_experiment(self, objective, constraint, search or {})
        return run_search(plan, Execution.read(execution), Watch(progress or silent))

    @shows_progress("identify")
    def calibrate(
        self,
        measurements: Sequence[Datum],
        search: Search | None = None,
        *,
        progress: Progress | None = None,
        **execution: Any,
    ) -> Identified:
        """The quantities that agree with measurements, with the distributions of the space as
        priors. The key of a datum is that of ``key_of_output``.
        """
        from valvetrain.explore.identification_file import IdentificationPlan, Search
        from valvetrain.explore.identify import run_identification

        plan = IdentificationPlan(self.space, tuple(measurements), self, search=search or Search())
        return run_identification(plan, Execution.read(execution), Watch(progress or silent))
