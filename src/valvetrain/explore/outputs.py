"""The outputs of an experiment: quantities at speeds and models, limit speeds, or a function."""

from __future__ import annotations

import itertools
import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, NamedTuple

from valvetrain.errors import InputError
from valvetrain.parameters.case import Case
from valvetrain.quantities.request import PointRequest, is_at_rest
from valvetrain.runs.cost import RunRequest, planned
from valvetrain.solution.critical import BOUNCE_HEIGHT, FLOAT_LIFT, KINDS
from valvetrain.solution.definition import (
    definition_of,
    is_defined,
    no_quantity,
    not_given,
    of_pair,
)
from valvetrain.solution.status import COMPLETED, Status
from valvetrain.springs.own_spring import model_names
from valvetrain.units import as_names, format_quantity, known_arguments, parse_quantity, si_speeds


class Run(NamedTuple):
    """Engine speed (rad/s of the crank; None at rest), spring model and spring set, empty for those of the case.

    >>> Run(100 * 3.141592653589793, "massless").label
    '3000 rpm, massless'
    """

    engine_speed: float | None = None
    spring_model: str = ""
    spring_set: str = ""

    @property
    def models(self) -> tuple[str, ...]:
        """The spring model, none where it is that of the case."""
        return tuple(filter(None, self[1:2]))

    @property
    def spring_sets(self) -> tuple[str, ...]:
        """The spring set, none where it is that of the case."""
        return tuple(filter(None, self[2:]))

    @property
    def label(self) -> str:
        """What it names, in words."""
        speed = "" if self.engine_speed is None else format_quantity(self.engine_speed, "rpm")
        return ", ".join(filter(None, (speed, *self[1:])))

    def request(self, case: Case) -> RunRequest:
        """The request of this run of a case."""
        speeds = None if self.engine_speed is None else (self.engine_speed,)
        return RunRequest("run", case, speeds, self.models, self.spring_sets, 1)


@dataclass(frozen=True, slots=True)
class Outcome:
    """Status of a point and its values (SI) by quantity; a failed point retains what it has."""

    status: Status = COMPLETED
    values: Mapping[str, float] = field(default_factory=dict)


@dataclass(frozen=True, slots=True)
class LimitSearch:
    """Keep ``quantity`` at or below (``upper``), or at or above, ``bound`` (SI), over
    ``engine_speeds`` (rad/s, rising).

    ``resolution`` (rad/s): width of the bracket at the end. ``share``: the bound is this share of
    what the case has at the lowest speed. ``kind``: a key of :data:`LIMITS`, or empty.
    """

    quantity: str
    upper: bool
    bound: float
    engine_speeds: tuple[float, ...]
    resolution: float
    share: float | None = None
    kind: str = ""

    @property
    def name(self) -> str:
        """Name of the limit speed as an output."""
        return LIMITS[self.kind][0] if self.kind else f"{self.quantity}_limit_speed"


#: Least force (N) of all contacts of a drive while the valve is open, of a point alone.
DRIVE_FORCE = "minimum_drive_contact_force"
#: Name of a limit -> name of its engine speed, the quantity that decides it, whether the bound is the most
#: that it may have, and the bound (SI): those of critical speeds, and the first clash.
LIMITS = {
    "contact-loss": (KINDS["contact-loss"], DRIVE_FORCE, False, 1e-9),
    "float": (KINDS["float"], "float_excess_lift", True, FLOAT_LIFT),
    "bounce": (KINDS["bounce"], "bounce_height", True, BOUNCE_HEIGHT),
    "clash": ("clash_engine_speed", "clash_count", True, 0.0),
}
_OF_CASE = re.compile(r"\s*(?:(\d+(?:\.\d+)?)\s*(?:x|\*|times)\s*(?:the\s+)?)?case\s*\Z")


def share_of_case(raw: Any) -> float | None:
    """The share of a bound written as ``"1.05 x case"``; None for a bound with a unit."""
    found = _OF_CASE.match(raw) if isinstance(raw, str) else None
    return None if found is None else float(found[1] or 1.0)


def limit_search(
    quantity: str = "",
    engine_speeds: Any = None,
    at_most: Any = None,
    at_least: Any = None,
    resolution: Any = "10 rpm",
    kind: str = "",
) -> LimitSearch:
    """The search for a limit speed, from the keys of its table in a file: ``kind`` of
    :data:`LIMITS`, or ``quantity`` and its bound.

    >>> found = limit_search(kind="float", engine_speeds="4000:8000:500 rpm")
    >>> found.name, found.quantity, found.bound
    ('float_engine_speed', 'float_excess_lift', 5e-05)
    """
    if kind:
        if kind not in LIMITS:
            raise InputError(
                f"'{kind[:40]}' is no kind of limit speed; use one of {', '.join(LIMITS)}"
            )
        if quantity or at_most is not None or at_least is not None:
            raise InputError("has a kind, which sets quantity and bound; leave those out")
        _, quantity, upper, bound = LIMITS[kind]
        share = None
    else:
        if not quantity:
            raise InputError(f"needs a kind ({', '.join(LIMITS)}), or a quantity and its bound")
        if not is_defined(quantity):
            raise InputError(no_quantity(quantity))
        if is_at_rest(quantity):
            raise InputError(
                f"'{quantity}' belongs to springs at rest, so it has no limit speed; choose another"
            )
        if (at_most is None) == (at_least is None):
            raise InputError("has one bound: give at_most or at_least")
        upper = at_most is not None
        raw = at_most if upper else at_least
        share = share_of_case(raw)
        bound = (
            float("nan")
            if share is not None
            else parse_quantity(raw, definition_of(quantity).dimension or "ratio")
        )
    if engine_speeds is None:
        raise InputError("is searched over engine speeds; give engine_speeds = '4000:9000:500 rpm'")
    speeds = tuple(sorted(si_speeds(engine_speeds)))
    if len(speeds) < 2:
        raise InputError("engine_speeds holds one speed; give a range such as '4000:9000:250 rpm'")
    width = parse_quantity(resolution, "angular speed")
    if not width > 0:
        raise InputError("the resolution is not positive; give such as '10 rpm'")
    return LimitSearch(quantity, upper, bound, speeds, width, share, kind)


class Task(NamedTuple):
    """What is computed of a point in one go: the quantities of a ``request`` in a ``run``, or with a ``limit`` the search for that
    limit speed by the model and set of the run.
    """

    run: Run
    request: PointRequest
    limit: LimitSearch | None = None

    def gives(self, run: Run) -> bool:
        """Whether its numbers are those of a run: a limit speed is that of a run at any speed."""
        return run == self.run if self.limit is None else run[1:] == self.run[1:]


@dataclass(frozen=True, init=False)
class Outputs:
    """What an experiment computes at every point.

    ``quantities``: names (docs/quantities.md) or numbers that the function gives. ``engine_speeds``
    (text such as ``"4000, 6000 rpm"`` or rad/s; None: the case's own), ``spring_models`` and
    ``spring_set`` (``spring_sets`` as an attribute): a run of each combination. ``rest_model``: spring model of static quantities.
    ``limit_speeds``: tables as in a file, such as ``{"kind": "float", "engine_speeds":
    "4000:9000:500 rpm"}`` or ``{"quantity": "clash_energy", "at_most": "1 mJ", "engine_speeds": ...}``.
    ``function``: computed instead of a case: takes the varied quantities by name and returns a
    mapping of numbers by name, or a number where there is one output.

    >>> import valvetrain as vt
    >>> vt.Outputs(["peak_spring_force"], engine_speeds="4000 rpm", spring_models=["massless"]).quantities
    ('peak_spring_force',)
    """

    quantities: tuple[str, ...]
    engine_speeds: tuple[float, ...] | None
    spring_models: tuple[str, ...]
    spring_sets: tuple[str, ...]
    rest_model: str
    limit_speeds: tuple[LimitSearch, ...]
    function: Callable[..., Any] | None

    @known_arguments
    def __init__(
        self,
        quantities: Sequence[str] | str = (),
        *,
        engine_speeds: Any = None,
        spring_models: Any = (),
        spring_set: Sequence[str] | str = (),
        rest_model: str = "",
        limit_speeds: Iterable[Mapping[str, Any] | LimitSearch] = (),
        function: Callable[..., Any] | None = None,
    ) -> None:
        names, models, sets = map(as_names, (quantities, model_names(spring_models), spring_set))
        limits = tuple(
            one if isinstance(one, LimitSearch) else limit_search(**one) for one in limit_speeds
        )
        if not names and not limits:
            raise InputError("name one output or more")
        for name in names if function is None else ():
            if not is_defined(name):
                raise InputError(no_quantity(name))
            if kind := next((kind for kind, (speed, *_) in LIMITS.items() if speed == name), ""):
                raise InputError(
                    f"'{name}' is searched over engine speeds; request a limit_speed with kind = '{kind}' and "
                    "engine_speeds = '4000:9000:500 rpm'"
                )
        speeds = engine_speeds
        if speeds is not None and not (
            isinstance(speeds, tuple) and all(isinstance(one, float) for one in speeds)
        ):
            speeds = si_speeds(speeds)
        vars(self).update(
            quantities=names, engine_speeds=speeds, spring_models=models, spring_sets=sets, rest_model=rest_model,
            limit_speeds=limits, function=function,
        )  # fmt: skip

    @property
    def request(self) -> PointRequest:
        """The request of one run."""
        return PointRequest(self.quantities, self.rest_model)

    def runs(self, case: Case | None, speed_is_varied: bool) -> tuple[Run, ...]:
        """Every engine speed with every model and set. Raises :class:`InputError` where a speed or
        a set is missing.
        """
        if case is None:
            return (Run(),)
        speeds: tuple[float | None, ...] = (None,)
        moving = bool(self.quantities) and self.request.motion
        if speed_is_varied and self.engine_speeds is not None and moving:
            raise InputError(
                "the engine speed is varied, so it is not given here as well; remove one"
            )
        if moving and not speed_is_varied:
            speeds = (
                case.operation.engine_speeds if self.engine_speeds is None else self.engine_speeds
            )
            if not speeds:
                raise InputError(
                    "the case names no engine speed, and the outputs need one; add engine_speeds = '6000 rpm'"
                )
        if self.spring_sets:
            refuse_sets(case, self.spring_sets)
        named = self.spring_models or ("",), self.spring_sets or ("",)
        return tuple(itertools.starmap(Run, itertools.product(speeds, *named)))


def missing_text(name: str, case: Case | None, runs: Sequence[Run]) -> str:
    """Why the ``runs`` of a case do not give a quantity."""
    pair = case is not None and any(len(planned(one.request(case))[0][1]) > 1 for one in runs)
    return not_given(name, of_pair(name) if pair else ())


def refuse_sets(case: Case, sets: Iterable[str]) -> None:
    """Raise :class:`InputError` for spring sets that the case does not have."""
    if case.train is None or any(one not in case.train.springs for one in sets):
        raise InputError(
            f"case '{case.name}' has no spring set {', '.join(sets)[:80]}; leave spring_sets out or correct it"
        )
