"""A case as an object: from anything, changed, run, studied, saved."""

from __future__ import annotations

import copy
import os
from collections.abc import Mapping, Sequence
from html import escape
from pathlib import Path
from typing import TYPE_CHECKING, Any

from valvetrain.api.parts import Lift, Spring, Train, as_table, lift_table, one_run
from valvetrain.errors import InputError
from valvetrain.parameters.case import Case as Parameters
from valvetrain.parameters.case_changes import tables_of
from valvetrain.parameters.loading import case_of_tree, load_case, parse_toml
from valvetrain.parameters.overrides import REMOVED, file_key, with_values
from valvetrain.parameters.templates import engine_text
from valvetrain.units import known_arguments, numbers_of, si_speeds
from valvetrain.units.text import clipped

if TYPE_CHECKING:
    from valvetrain.explore.experiment import Experiment
    from valvetrain.explore.identified import Identified
    from valvetrain.explore.optimum import Optimum
    from valvetrain.explore.table import StudyTable
    from valvetrain.runs.error_bars import UncertaintyStudy
    from valvetrain.solution.branches import Branches
    from valvetrain.solution.critical import CriticalSpeeds
    from valvetrain.solution.part_ranking import PartRanking
    from valvetrain.solution.result import Solution
    from valvetrain.solution.static import StaticCurve
    from valvetrain.solution.study import Study
    from valvetrain.views.study_files import StudyFiles

Source = str | os.PathLike[str] | Mapping[str, Any] | Parameters


class Case:
    """Everything that defines a study, with verbs that run it.

    Parameters
    ----------
    source : name of a library case, path of a case file, TOML text, a dict with the tables of the
        file, or another case
    name : of the case, by which its runs are found
    spring : a :class:`Spring`, or two that are nested, outer first, moved by ``lift_law``
    train : a :class:`Train`, which carries its springs
    lift_law : table ``[lift_law]``, function of the cam angle (rad) that gives the lift (m), or cam
        angles (rad) and lifts (m)
    engine_speeds : of the crank: "4000, 6000 rpm", rad/s, pint quantities
    tables : other tables and keys of the file, such as ``operation={"cycles": 4}``, ``title="..."``

    ``tree`` holds the tables as its file would, ``parameters`` what they say, frozen and in SI.
    Cases are equal, and have one ``digest``, when their parameters are, whatever text and units
    said so.

    Raises
    ------
    InputError : one sentence: where, what is wrong and the remedy

    Examples
    --------
    >>> import valvetrain as vt
    >>> case = vt.Case("job-t").set({"spring.wire_diameter": "3.9 mm"})
    >>> case == vt.Case("job-t").set({"spring.wire_diameter": 0.0039}), case == vt.Case("job-t")
    (True, False)
    >>> run = case.run("2000 rpm", models="massless")
    >>> round(float(run["seat_force"].max()))
    472
    """

    def __init__(
        self,
        source: Source | Case | None = None,
        /,
        *,
        name: str = "",
        spring: Spring | Mapping[str, Any] | Sequence[Any] | None = None,
        train: Train | Mapping[str, Any] | None = None,
        lift_law: Lift | None = None,
        engine_speeds: Any = None,
        **tables: Any,
    ) -> None:
        tree, known, self._folder = _tree_of(source)
        tree |= as_table(tables)
        if spring is not None:
            tree["spring"] = as_table(spring)
        if train is not None:
            tree["train"] = as_table(train)
        if lift_law is not None:
            tree["lift_law"] = lift_table(lift_law)
        if engine_speeds is not None:
            speeds = [f"{speed!r} rad/s" for speed in si_speeds(engine_speeds)]
            others = {
                key: item for key, item in tree.get("operation", {}).items() if key != "cam_speeds"
            }
            tree["operation"] = others | {"engine_speeds": speeds}
        if name:
            tree["name"] = name
        self.tree: dict[str, Any] = tree
        label = name or known
        self.parameters: Parameters = case_of_tree(
            tree, label or "case", self._folder, label or "vt.Case"
        )

    @classmethod
    def like(cls, name: str) -> Case:
        """The case of an engine whose numbers have sources: "sbc-flat-tappet", "ls-beehive", "ls-dual" (docs/engines.md).

        Raises :class:`InputError` for an unknown one.
        """
        return cls(engine_text(name), name=name)

    @property
    def name(self) -> str:
        """Name of the case."""
        return self.parameters.name

    @property
    def digest(self) -> str:
        """Short fingerprint of what the case says, the same for the same parameters."""
        return self.parameters.digest

    def set(self, changes: Mapping[str, Any] | None = None, /, **tables: Any) -> Case:
        """A case with values changed; this one stays as it is.

        Parameters
        ----------
        changes : key path -> text with a unit, SI number or pint quantity; None removes the value
        tables : whole tables or keys of the file, as for :class:`Case`

        Raises
        ------
        InputError : a path that does not exist, a value that cannot be

        Examples
        --------
        >>> import valvetrain as vt
        >>> sorted(vt.Case("job-t").set({"operation.cycles": 3}).diff(vt.Case("job-t")))
        ['operation.cycles']
        """
        made = {
            path: REMOVED if value is None else as_table(value, tuple(file_key(path).split(".")))
            for path, value in (changes or {}).items()
        }
        new = object.__new__(Case)
        new._folder = self._folder
        new.tree = with_values(self.tree, made) if made else copy.deepcopy(self.tree)
        new.parameters = case_of_tree(new.tree, self.name, self._folder, self.name)
        return Case(new, **tables) if tables else new

    @known_arguments
    def run(self, engine_speed: Any = None, models: Any = (), **options: Any) -> Solution:
        """One run: at one engine speed, by one spring model. Several: :meth:`compare`, :meth:`sweep`.

        Parameters
        ----------
        engine_speed : of the crank: "6000 rpm", rad/s or a pint quantity; the case's own where it has one
        models : the spring model: its name, class or an instance, a function of the compression, or a
            class of one's own (docs/extend/own-parts-in-a-script.md); the case's own by default
        options : as for :func:`valvetrain.simulate`, among them ``spring_sets``, and ``outputs``, names of
            quantities and channels: only these are computed

        Returns
        -------
        Solution: channels by name, ``run["seat_force"]``, numbers ``run.quantities["peak_spring_force"]``

        Raises
        ------
        InputError : several runs; what cannot be built or run
        """
        return one_run(self.parameters, engine_speed, models, **options)

    @known_arguments
    def compare(self, engine_speeds: Any = None, models: Any = (), **options: Any) -> Study:
        """Spring models side by side, at rest and in motion; options as for
        :func:`valvetrain.compare`.
        """
        from valvetrain.runs.api import compare

        return compare(self.parameters, engine_speeds, models, **options)

    @known_arguments
    def sweep(self, engine_speeds: Any = None, models: Any = (), **options: Any) -> Study:
        """Numbers over engine speed and, of a train, its critical speeds; options as for
        :func:`valvetrain.sweep`, among them ``outputs``, names of what alone is computed.
        """
        from valvetrain.runs.api import sweep

        return sweep(self.parameters, engine_speeds, models, **options)

    def compare_springs(
        self,
        first: Source,
        second: Source,
        engine_speeds: Any = None,
        models: Any = (),
        **options: Any,
    ) -> Study:
        """Two springs side by side in this train over engine speed: surge, clash, stress, float.

        Parameters
        ----------
        first, second : cases with a spring, as for :class:`Case`; of a train the spring set in use
        engine_speeds, models, options : as for :func:`valvetrain.sweep`

        Returns
        -------
        Study with the runs of both, labelled by their names

        Raises
        ------
        InputError : a case without train or springs, and as :func:`valvetrain.sweep`

        Examples
        --------
        >>> import valvetrain as vt
        >>> stiff = vt.Case('spring = { preload = "320 N", rate = "42 N/mm", mass = "48 g" }', name="stiff")
        >>> study = vt.Case("tdi-pushrod").compare_springs(stiff, "tdi-pushrod", "3000 rpm", "massless", critical_speeds=False)
        >>> len(study.solutions)
        2
        """
        from valvetrain.runs.api import affordable
        from valvetrain.runs.compare_springs import paired
        from valvetrain.runs.requests import CompareSprings, Watch
        from valvetrain.runs.run import sweep_study

        one, other = (
            source if isinstance(source, (Case, Parameters)) else Case(source)
            for source in (first, second)
        )
        watch = Watch(options.pop("progress", None))
        given = {"case": self.parameters, "engine_speeds": engine_speeds, "models": models}
        request = CompareSprings.read(given | options)
        pair = getattr(one, "parameters", one), getattr(other, "parameters", other)
        return sweep_study(affordable(paired(request, *pair)), watch)

    @known_arguments
    def critical_speeds(
        self, engine_speeds: Any = None, models: Any = (), **options: Any
    ) -> CriticalSpeeds:
        """Where a train loses contact, floats and bounces; as :func:`valvetrain.critical_speeds`."""
        from valvetrain.runs.api import critical_speeds

        return critical_speeds(self.parameters, engine_speeds, models, **options)

    @known_arguments
    def parts(self, engine_speeds: Any = None, models: Any = (), **options: Any) -> PartRanking:
        """Parts of its train by the engine speed of control that each gains when it alone is changed.

        Parameters
        ----------
        engine_speeds : at which the train is searched as it is; by default to 1.2 times the red line
        models : the spring model; the case's own by default
        options : ``spring_sets``, name of the set that is changed, ``workers`` and others of :func:`valvetrain.sweep`

        Returns
        -------
        PartRanking: ``best``, ``changes`` by gain with their ranges, ``plot()``, ``to_pandas()``

        Raises
        ------
        InputError : a case without train, several spring sets or models
        """
        from valvetrain.runs.api import affordable
        from valvetrain.runs.part_ranking import rank_parts
        from valvetrain.runs.requests import Parts, Watch

        watch = Watch(options.pop("progress", None))
        given = {"case": self.parameters, "engine_speeds": engine_speeds, "models": models}
        return rank_parts(affordable(Parts.read(given | options)), watch)

    def branches(self, engine_speeds: Any, models: Any = (), **options: Any) -> Branches:
        """Motions of its train over engine speed, rising and falling; as :func:`valvetrain.runs.branches`."""
        from valvetrain.runs.branch_march import branches

        return branches(self.parameters, engine_speeds, models, **options)

    def static(self, largest_compression: Any = None, **options: Any) -> StaticCurve:
        """Force over compression of its spring; as :func:`valvetrain.static_curve`."""
        from valvetrain.runs.api import static_curve

        return static_curve(self.parameters, largest_compression, **options)

    def refine(self, **options: Any) -> UncertaintyStudy:
        """Error bars of the headline numbers; as :func:`valvetrain.refine`."""
        from valvetrain.runs.refine import refine

        return refine(self.parameters, **options)

    def report(
        self, folder: str | os.PathLike[str], engine_speeds: Any = None, **options: Any
    ) -> StudyFiles:
        """Run the case and write its report page and data files to ``folder``."""
        from valvetrain.runs.api import simulate
        from valvetrain.views.results import write_study

        return write_study(simulate(self.parameters, engine_speeds, **options), folder)

    @known_arguments
    def study(
        self,
        varied: Mapping[str, Any],
        outputs: Sequence[str] | str,
        *,
        sampling: str = "sobol",
        count: int = 64,
        seed: int = 1,
        engine_speeds: Any = None,
        models: Any = (),
        spring_sets: Sequence[str] | str = (),
        **options: Any,
    ) -> StudyTable:
        """Outputs at points of a space, and only these.

        Parameters
        ----------
        varied : key path -> distribution (``vt.Uniform("7 mm", "8 mm")``) or list of values
        outputs : names of quantities (docs/quantities.md); for numbers of your own see :func:`valvetrain.map`
        sampling : name of a sampler (docs/studies.md)
        count, seed : points and random seed of the sampler; a grid and a list have neither
        engine_speeds, models, spring_sets : a run of each combination at every point
        options : ``workers``, ``output`` and others of :class:`valvetrain.Experiment`

        Returns
        -------
        StudyTable; ``to_xarray()`` has the dimensions point, speed and model, ``report(folder)``
        writes its page, ``save("table.nc")`` its file

        Raises
        ------
        InputError : an unknown quantity or sampler, units that do not fit
        """
        experiment = self._experiment(varied, outputs, engine_speeds, models, spring_sets)
        settings = {} if sampling in ("grid", "list") else {"count": count, "seed": seed}
        return experiment.sample(sampling, settings, **options)

    @known_arguments
    def optimise(
        self,
        varied: Mapping[str, Any],
        objective: Mapping[str, str],
        constraints: Mapping[str, Mapping[str, Any]] | None = None,
        *,
        engine_speeds: Any = None,
        models: Any = (),
        search: Mapping[str, Any] | None = None,
        spring_sets: Sequence[str] | str = (),
        **options: Any,
    ) -> Optimum:
        """The best design.

        Parameters
        ----------
        varied : as for :meth:`study`
        objective : quantity, or key among the varied ones, -> ``"minimise"`` or ``"maximise"``
        constraints : likewise -> ``{"at_most": "800 MPa"}``, ``at_least`` or both
        engine_speeds, models, spring_sets : as for :meth:`study`
        search : as in an optimisation file (docs/optimisation.md), such as ``{"trials": 60}``
        options : as for :meth:`study`

        Raises
        ------
        InputError : as :meth:`study`; MissingExtraError without the extra ``studies``
        """
        limits = constraints or {}
        keys = {file_key(key) for key in varied}  # their values need no run
        names = [one for one in dict.fromkeys([*objective, *limits]) if file_key(one) not in keys]
        experiment = self._experiment(varied, names, engine_speeds, models, spring_sets)
        return experiment.optimise(
            [{"quantity": name, "direction": way} for name, way in objective.items()],
            [{"quantity": name, **bound} for name, bound in limits.items()],
            search,
            **options,
        )

    @known_arguments
    def identify(
        self,
        unknowns: Mapping[str, Any],
        measured: Any,
        *,
        scatter: Any = None,
        engine_speeds: Any = None,
        models: Any = (),
        spring_sets: Sequence[str] | str = (),
        **options: Any,
    ) -> Identified:
        """Unknowns that agree with measurements.

        Parameters
        ----------
        unknowns : key path -> (least, largest) or a distribution
        measured : quantity -> (value, standard deviation), SI or text with units; or a trace over
            ``cam_angle`` (rad): an xarray.DataArray or pandas.Series whose name is a channel
            (``run["seat_force"]``), a pandas.DataFrame with the columns ``cam_angle`` and ``seat_force``,
            or ``{"seat_force": [(cam angle, force), ...]}``
        scatter : standard deviation of a trace; a hundredth of its span without
        engine_speeds, models, spring_sets : as for :meth:`study`
        options : ``search`` (:class:`valvetrain.explore.Search`) and those of :meth:`study`

        Raises
        ------
        InputError : as :meth:`study`; no start that can be computed, with the reason
        """
        from valvetrain.api.trace import ACCEPTED, identify_by_trace, is_trace
        from valvetrain.explore.distributions import Uniform
        from valvetrain.explore.posterior import Datum
        from valvetrain.solution.definition import definition_of

        priors = {
            key: Uniform(*item) if isinstance(item, tuple) else item
            for key, item in unknowns.items()
        }
        if is_trace(measured):
            chosen = {"engine_speed": engine_speeds, "models": models, "spring_sets": spring_sets}
            ways = {name: one for name, one in chosen.items() if one}
            return identify_by_trace(self, priors, measured, scatter, ways, **options)
        data = []
        for name, pair in measured.items():
            if not isinstance(pair, (list, tuple)) or len(pair) != 2:
                raise InputError(
                    f"{name} has no value with its standard deviation; {ACCEPTED}", "measured"
                )
            (value, scatter), _ = numbers_of(*pair, dimension=definition_of(name).dimension or None)
            data.append(Datum(name, value, scatter))
        return self._experiment(
            priors, list(measured), engine_speeds, models, spring_sets
        ).calibrate(data, **options)

    def _experiment(
        self, varied: Mapping[str, Any], outputs: Any, speeds: Any, models: Any, sets: Any
    ) -> Experiment:
        from valvetrain.explore.distributions import Prior, Values
        from valvetrain.explore.experiment import Experiment
        from valvetrain.explore.outputs import Outputs
        from valvetrain.explore.space import Space

        space = {
            key: item if isinstance(item, (Prior, Values)) else Values(tuple(item))
            for key, item in varied.items()
        }
        return Experiment(
            self.parameters,
            Space(space),
            Outputs(outputs, engine_speeds=speeds, spring_models=models, spring_set=sets),
        )

    def save(self, path: str | os.PathLike[str]) -> Path:
        """Write the case file, whole or not at all; read again it gives an equal case."""
        from valvetrain.solution.atomic import write_text

        target = Path(path)
        mode = target.stat().st_mode if target.exists() else None
        write_text(target, self.text)
        if mode is not None:  # a file that was there keeps its mode
            target.chmod(mode)
        return target

    @property
    def text(self) -> str:
        """The case file (TOML)."""
        return self.parameters.text

    def diff(self, other: Case | Parameters) -> dict[str, tuple[Any, Any]]:
        """Key path -> (value here, value there) of everything that differs; notes on where values
        come from are left out.
        """
        found = self.parameters.diff(other.parameters if isinstance(other, Case) else other)
        return {path: pair for path, pair in found.items() if not path.startswith("notes.")}

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Case) and self.digest == other.digest

    def __hash__(self) -> int:
        return hash(self.digest)

    def _lines(self) -> list[str]:
        found = self.parameters
        springs = found.springs or tuple(
            spring
            for one in (found.train.springs.values() if found.train else ())
            for spring in one
        )
        speeds = [f"{speed * 9.549296585513721:.0f}" for speed in found.operation.engine_speeds]
        return [
            f"Case {found.name}" + (f": {found.title}" if found.title else ""),
            *([f"train: {found.train.kind}"] if found.train else []),
            *(
                [f"springs: {', '.join(one.name or 'spring' for one in springs)}"]
                if springs
                else []
            ),
            *([f"lift: {found.lift_law.kind}"] if found.lift_law else []),
            *([f"engine speeds: {', '.join(speeds)} rpm"] if speeds else []),
        ]

    def __repr__(self) -> str:
        return "\n  ".join(self._lines())

    def _repr_html_(self) -> str:
        first, *others = self._lines()
        rows = "".join(f"<li>{escape(line)}</li>" for line in others)
        return f"<b>{escape(first)}</b><ul>{rows}</ul><details><summary>case file</summary><pre>{escape(self.text)}</pre></details>"


def _tree_of(source: Source | Case | None) -> tuple[dict[str, Any], str, Path]:
    """Tables, name and folder of what a case is made from."""
    if source is None:
        return {}, "", Path()
    if isinstance(source, Case):
        return copy.deepcopy(source.tree), source.name, source._folder
    if isinstance(source, Mapping):
        return as_table(source), "", Path()
    if isinstance(source, str) and ("\n" in source or "=" in source):
        return parse_toml(source, "TOML text"), "", Path()
    if isinstance(source, Parameters):
        return copy.deepcopy(tables_of(source).tree), source.name, Path()
    if not isinstance(source, (str, os.PathLike)):
        raise InputError(
            f"{clipped(repr(source))} is no case; give a name of the library, a path, TOML text or a dict of tables",
            "vt.Case",
        )
    case = load_case(source)
    path = Path(source)
    return parse_toml(case.text, case.name), case.name, path.parent if path.is_file() else Path()
