"""Points of a study whose outputs are functions of a run, or whose inputs are functions and tables."""

from __future__ import annotations

import pickle
from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from valvetrain.errors import InputError

if TYPE_CHECKING:
    from valvetrain.explore.experiment import Experiment
    from valvetrain.solution.study import Study

Output = str | Callable[..., float]
#: A case with its verbs (:class:`valvetrain.Case`), whose module this one serves.
CaseWithVerbs = Any


def is_object(item: Any) -> bool:
    """Whether one of the values of a varied key is no number: a function, a table, an array."""
    values = item if isinstance(item, (list, tuple)) else ()
    return any(
        callable(one) or isinstance(one, (Mapping, np.ndarray, list, tuple)) for one in values
    )


def name_of(output: Output) -> str:
    """Name of an output in the table."""
    return output if isinstance(output, str) else getattr(output, "__name__", "output")


class StudyPoint:
    """The outputs of a case at one point, by the names of its varied keys.

    ``objects``: key -> functions, tables or arrays, of which a point names one by its place.
    """

    def __init__(
        self,
        case: CaseWithVerbs,
        outputs: Sequence[Output],
        objects: Mapping[str, Sequence[Any]],
        engine_speed: Any,
        model: str,
    ) -> None:
        self.case, self.outputs, self.objects = case, tuple(outputs), dict(objects)
        self.engine_speed, self.model = engine_speed, model
        self.__name__ = case.name

    def __reduce__(self) -> tuple[Any, ...]:
        try:
            from cloudpickle import dumps  # functions of a notebook's cell travel by their content
        except ImportError:
            dumps = pickle.dumps
        given = self.case, self.outputs, self.objects, self.engine_speed, self.model
        return _restored, (dumps(given),)

    def __call__(self, **values: float) -> dict[str, float]:
        """The numbers by name. Raises :class:`InputError` for a case that cannot be built or does
        not complete its run.
        """
        from valvetrain.explore.space import ENGINE_SPEED
        from valvetrain.runs.api import simulate

        speed = self.engine_speed
        if ENGINE_SPEED in values:  # read before, with its unit
            speed = f"{values.pop(ENGINE_SPEED)!r} rad/s"
        plain: dict[str, Any] = {}
        tables: dict[str, Any] = {}
        for key, value in values.items():
            if key in self.objects:
                (plain if "." in key else tables)[key] = self.objects[key][int(value)]
            else:
                plain[key] = value
        case = self.case.set(plain, **tables)
        found = simulate(case.parameters, speed, models=self.model, workers=1)
        if len(found.solutions) != 1:
            raise InputError(
                f"these are {len(found.solutions)} runs; name one engine speed and one model"
            )
        return {name_of(one): self._number(one, found, case) for one in self.outputs}

    def _number(self, output: Output, found: Study, case: CaseWithVerbs) -> float:
        (run,) = found.solutions
        if not run.status.completed:
            raise InputError(run.status.sentence())
        if callable(output):
            return float(output(run, case) if _takes_two(output) else output(run))
        if output in run.quantities:
            return float(run.quantities[output])
        still = (values for values in found.still.values() if output in values)
        return float(next(still, {output: np.nan})[output])


def experiment_of_points(
    case: CaseWithVerbs,
    varied: Mapping[str, Any],
    outputs: Sequence[Output],
    engine_speeds: Any,
    models: Sequence[str] | str,
) -> Experiment:
    """The experiment of a case with functions among its ``outputs`` or values. Raises
    :class:`InputError` for an unknown quantity and several models.
    """
    from valvetrain.explore.distributions import Prior, Values
    from valvetrain.explore.engine import with_case_units
    from valvetrain.explore.experiment import Experiment
    from valvetrain.explore.outputs import Outputs
    from valvetrain.explore.space import Space
    from valvetrain.solution.definition import is_defined, no_quantity

    names = [name_of(one) for one in outputs]
    for one in outputs:
        if isinstance(one, str) and not is_defined(one):
            raise InputError(no_quantity(one), "outputs")
    if len(set(names)) < len(names):
        raise InputError(
            "two outputs have one name; give each function a name of its own", "outputs"
        )
    model = models if isinstance(models, str) else next(iter(models), "")
    if not isinstance(models, str) and len(models) > 1:
        raise InputError("outputs that are functions take one model; name one", "models")
    objects = {key: tuple(item) for key, item in varied.items() if is_object(item)}
    plain = {
        key: item if isinstance(item, (Prior, Values)) else Values(tuple(item))
        for key, item in varied.items()
        if key not in objects
    }
    known = (
        {one.key: one for one in with_case_units(case.parameters, Space(plain))} if plain else {}
    )
    places = {key: Values(tuple(range(len(items)))) for key, items in objects.items()}
    every = Space({key: plain.get(key) or places[key] for key in varied})
    space = Space([known.get(one.key, one) for one in every])
    point = StudyPoint(case, outputs, objects, engine_speeds, model)
    return Experiment(None, space, Outputs(names, function=point))


def _restored(content: bytes) -> StudyPoint:
    return StudyPoint(*pickle.loads(content))


def _takes_two(function: Callable[..., Any]) -> bool:
    """Whether a function takes the run and the case."""
    from inspect import Parameter, signature

    try:
        given = list(signature(function).parameters.values())
    except (TypeError, ValueError):
        return False
    plain = (Parameter.POSITIONAL_ONLY, Parameter.POSITIONAL_OR_KEYWORD)
    return sum(one.kind in plain and one.default is Parameter.empty for one in given) > 1
