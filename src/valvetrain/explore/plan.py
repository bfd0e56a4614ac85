"""A study file made ready: its case, what is varied over what, the points as they are asked for,
and the digest of each.
"""

from __future__ import annotations

import hashlib
import itertools
import json
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from valvetrain.errors import InputError
from valvetrain.explore.paths import numbers_of, part_of, tree_of, vary
from valvetrain.explore.point import Point, PointRequest
from valvetrain.explore.samplers import MAX_POINTS, SamplerOptions, SamplerSpec, sampler
from valvetrain.explore.space import (
    ENGINE_SPEED,
    SIGMAS,
    Distribution,
    LogNormal,
    Normal,
    Uniform,
    Values,
    Varied,
)
from valvetrain.explore.store import versions_digest
from valvetrain.explore.study_file import FileText, StudyText, VaryModel
from valvetrain.parameters.case import Case
from valvetrain.parameters.loading import library_names, load_case
from valvetrain.parameters.overrides import REMOVED
from valvetrain.registry import find
from valvetrain.solution.definition import is_defined, no_quantity
from valvetrain.units import parse_quantities, parse_quantity, si_speeds


def nominal(case: Case, varied: Varied) -> float:
    """The value (SI) of the case, 1 for a factor, 0 for an offset.

    Raises :class:`InputError` for a key that is not there, or under which no single number stands.

    >>> import valvetrain as vt
    >>> nominal(vt.load_case("gu2021-beehive"), Varied("spring.precompression", "mm"))
    0.007
    """
    if varied.operation != "value":
        return 1.0 if varied.operation == "factor" else 0.0
    found, place = _stands(case, varied.key)
    if place is not None:
        return numbers_of(found, varied)[0][place]
    if isinstance(found, str) and "," not in found:
        return numbers_of(found, varied)[0][0]
    if isinstance(found, (int, float)) and not isinstance(found, bool):
        return float(found)
    level = getattr(found, "level", None)
    if isinstance(level, float):
        return level
    raise InputError(
        "stands for several numbers in the case; vary it as = 'factor' or 'offset', or name one of its parts",
        varied.key,
    )


def unit_in_case(case: Case, key: str) -> str:
    """Unit in which the value of ``key`` is written in the case; empty for a plain number and where
    the case has no text.

    >>> import valvetrain as vt
    >>> unit_in_case(vt.load_case("gu2021-beehive"), "spring.precompression")
    'mm'
    """
    found, _ = _stands(case, key)
    return unit_of(found) if isinstance(found, str) else ""


def unit_of(text: str) -> str:
    """Unit of a text, of the last of several numbers.

    >>> unit_of("3.7, 3.8 mm"), unit_of("5 %"), unit_of("7")
    ('mm', '%', '')
    """
    words = text.split(",")[-1].strip()
    return words.lstrip("+-0123456789.eE ").strip() if words else ""


def _stands(case: Case, key: str) -> tuple[Any, int | None]:
    """What stands under ``key``, and the place in it where it is a text of several numbers of which
    one is meant.
    """
    tree = tree_of(case)
    if tree is None:
        return part_of(case, key), None
    found: Any = tree
    for part in key.split("."):
        if isinstance(found, dict) and part in found:
            found = found[part]
        elif isinstance(found, list) and part.isdecimal() and int(part) < len(found):
            found = found[int(part)]
        elif (
            isinstance(found, str)
            and "," in found
            and part.isdecimal()
            and int(part) < len(found.split(","))
        ):
            return found, int(part)
        else:
            raise InputError(
                "is not in the case, so it has no value to stand about; give low and high, or mean",
                key,
            )
    return found, None


Array = NDArray[np.float64]
#: (engine speed in rad/s or None, spring model, spring set) of a row.
Run = tuple[float | None, str, str]


@dataclass(frozen=True, eq=False)
class StudyPlan:
    """What a study does: every draw of ``varied`` by the sampler, each at all ``runs``; ``kind``:
    what is made of it.
    """

    title: str
    kind: str
    case: Case
    varied: tuple[Varied, ...]
    sampler: SamplerSpec
    options: SamplerOptions
    runs: tuple[Run, ...]
    wanted: PointRequest
    description: str = ""

    def point(self, values: Iterable[float], run: Run) -> Point:
        """One point: a draw (SI, in the order of ``varied``) at one of the runs."""
        engine_speed, model, spring_set = run
        return Point(
            self.case,
            tuple(zip(self.varied, map(float, values), strict=True)),
            engine_speed,
            model,
            spring_set,
            self.wanted,
        )

    def rows(self, draws: Array) -> Iterator[tuple[Array, Run]]:
        """Every draw at every run, in the order of the rows of the result."""
        yield from itertools.product(draws, self.runs)

    @cached_property
    def _base(self) -> bytes:
        """What all points share, as bytes: the case in full, what is varied, outputs, and the
        versions that matter.
        """
        keys = [[one.key, one.operation, one.si_unit] for one in self.varied]
        told = [
            _told(self.case),
            keys,
            list(self.wanted.outputs),
            self.wanted.rest_model,
            versions_digest(),
        ]
        return hashlib.blake2b(json.dumps(told, sort_keys=True).encode(), digest_size=16).digest()

    def digest(self, values: Iterable[float], run: Run) -> bytes:
        """16 bytes that change with anything of the point that can change its numbers, to the last
        bit of a value.
        """
        own = json.dumps(
            [
                [float(value).hex() for value in values],
                None if run[0] is None else float(run[0]).hex(),
                run[1],
                run[2],
            ]
        )
        return hashlib.blake2b(self._base + own.encode(), digest_size=16).digest()


def _told(case: Case) -> str:
    """The case as text, for a digest: everything that takes part in comparisons but words that move
    nothing.
    """
    bare = (
        case.springs,
        case.rubbing,
        case.lift_law,
        case.operation,
        case.train,
        case.study,
        case.published,
    )
    return repr(bare)


def read_plan(text: StudyText) -> StudyPlan:
    """The plan of a study file. Raises :class:`InputError`, one sentence with file, line and key."""
    model = text.model
    case = text.guarded(("case",), lambda: case_of_file(model.case, model.changes, text.folder))
    varied = varied_of_file(text, model.vary, case)
    spec = text.guarded(("points", "sampler"), lambda: sampler(model.points.sampler, ""))
    options = text.guarded(("points",), lambda: spec.read_options(dict(text.sampler_options)))
    if model.kind == "tolerance" and spec.word != "saltelli":
        raise text.located(
            ("points", "sampler"),
            "a study of kind 'tolerance' stands on the sampler saltelli; choose it",
        )
    for place, name in enumerate(model.outputs):
        if not is_defined(name):
            raise text.located(("outputs", place), no_quantity(name))
    if not model.outputs:
        raise text.located(
            ("outputs",), "names no quantity; name one or more of docs/quantities.md"
        )
    wanted = PointRequest(tuple(dict.fromkeys(model.outputs)), model.rest_model)
    for key, word in (
        ("rest_model", model.rest_model),
        *(("spring_models", one) for one in model.spring_models),
    ):
        if word:
            text.guarded((key,), lambda word=word: find("springs", word))
    runs = text.guarded(
        ("engine_speeds",),
        lambda: runs_of(
            model.engine_speeds, case, varied, wanted, model.spring_models, model.spring_sets
        ),
    )
    return StudyPlan(
        model.title or f"{case.name}: {spec.words}",
        model.kind,
        case,
        varied,
        spec,
        options,
        runs,
        wanted,
        model.description,
    )


def case_of_file(name: str, changes: Mapping[str, Any], folder: Path) -> Case:
    """The case of the library or beside the file in ``folder``, with its changes; an empty text
    removes a key.
    """
    path = folder / name
    made = {key: REMOVED if value == "" else value for key, value in changes.items()}
    return load_case(name if name in library_names() or not path.is_file() else path, made or None)


def varied_of_file(
    text: FileText[Any], models: Sequence[VaryModel], case: Case
) -> tuple[Varied, ...]:
    """What a file varies, each quantity once."""
    varied = tuple(
        text.guarded(("vary", place), lambda one=one: _varied(one, case))
        for place, one in enumerate(models)
    )
    names = [one.name for one in varied]
    if len(set(names)) < len(names):
        raise text.located(
            ("vary",),
            f"'{next(name for name in names if names.count(name) > 1)}' is varied twice; say it once",
        )
    return varied


def runs_of(
    engine_speeds: Any,
    case: Case,
    varied: Sequence[Varied],
    wanted: PointRequest,
    models: Sequence[str],
    sets: Sequence[str],
) -> tuple[Run, ...]:
    """Every engine speed with every model and set. Raises :class:`InputError` where a speed or a
    set is missing.
    """
    speeds: tuple[float | None, ...]
    if any(one.key == ENGINE_SPEED for one in varied) or not wanted.motion:
        if engine_speeds is not None and wanted.motion:
            raise InputError(
                "the engine speed is varied, so it is not given here as well; remove one"
            )
        speeds = (None,)
    else:
        speeds = (
            si_speeds(engine_speeds) if engine_speeds is not None else case.operation.engine_speeds
        )
        if not speeds:
            raise InputError(
                "the case names no engine speed, and the outputs need one; add engine_speeds = '6000 rpm'"
            )
    if sets and (case.train is None or any(one not in case.train.springs for one in sets)):
        raise InputError(
            f"case '{case.name}' has no spring set {', '.join(sets)[:80]}; leave spring_sets out or correct it"
        )
    runs = tuple(
        itertools.product(speeds, dict.fromkeys(models or ("",)), dict.fromkeys(sets or ("",)))
    )
    return runs


def _varied(one: VaryModel, case: Case) -> Varied:
    """A varied quantity with its distribution; units of its numbers must agree with each other and
    with the case.
    """
    from valvetrain.units import dimension_of

    texts = [
        str(raw)
        for raw in (one.low, one.high, one.mean, one.standard_deviation, one.median, one.tolerance)
        if raw is not None
    ]
    texts += [one.values] if isinstance(one.values, str) else [str(raw) for raw in one.values or ()]
    unit = one.unit or next((found for text in texts if (found := unit_of(text))), "")
    share = (
        one.way == "tolerance" and unit_of(str(one.tolerance)) == "%"
    )  # of what stands in the case
    unit = unit_in_case(case, one.key) if share and one.varied == "value" else "" if share else unit
    bare = Varied(one.key, unit, one.varied, label=one.label)
    dimension = dimension_of(unit) if unit else "ratio"
    if one.key == ENGINE_SPEED and (dimension != "angular speed" or one.varied != "value"):
        raise InputError(
            "is an engine speed, which is varied by its value in rpm; write such as low = '4000 rpm'",
            one.key,
        )

    def number(raw: Any) -> float:
        return parse_quantity(raw, dimension, one.key)

    distribution: Distribution
    if one.way == "values":
        distribution = Values(parse_quantities(one.values, dimension, one.key))
        if len(distribution.values) > MAX_POINTS:
            raise InputError("has too many values; give fewer", one.key)
    elif one.way == "uniform":
        distribution = Uniform(number(one.low), number(one.high))
    elif one.way == "normal":
        low, high = (
            -np.inf if one.low is None else number(one.low),
            np.inf if one.high is None else number(one.high),
        )
        distribution = Normal(number(one.mean), number(one.standard_deviation), low, high)
    elif one.way == "lognormal":
        assert one.factor is not None
        distribution = LogNormal(number(one.median), float(one.factor))
    else:
        middle = nominal(case, bare)
        reach = (
            abs(middle) * parse_quantity(one.tolerance, "ratio", one.key)
            if share
            else number(one.tolerance)
        )
        if share and not middle:
            raise InputError(
                "is zero in the case, and so is any share of it; give the tolerance with its unit",
                one.key,
            )
        if not reach > 0:
            raise InputError(
                "has a tolerance of zero or less; give how far it goes either way", one.key
            )
        low, high = middle - reach, middle + reach
        distribution = (
            Uniform(low, high)
            if one.shape == "uniform"
            else Normal(middle, reach / SIGMAS, low, high)
        )
    varied = Varied(one.key, unit, one.varied, distribution, one.label)
    _refuse_impossible(case, varied)
    return varied


def _refuse_impossible(case: Case, varied: Varied) -> None:
    """Raise :class:`InputError` for a quantity that no case can have at either end or in the
    middle: a slip of key or unit.
    """
    refusals = []
    for value in varied.distribution.at([0.02, 0.5, 0.98]).tolist():
        try:
            vary(case, {varied: value})
        except InputError as error:
            refusals.append(error)
    if len(refusals) == 3:
        raise refusals[1]
