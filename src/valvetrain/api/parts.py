"""A spring, a train and a lift made in Python: tables with the keys of a case file."""

from __future__ import annotations

import copy
import math
from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from valvetrain.errors import InputError
from valvetrain.parameters.own_parts import own_name
from valvetrain.units import Given, plain_value
from valvetrain.units.text import clipped

if TYPE_CHECKING:
    from valvetrain.parameters.case import Case as Parameters
    from valvetrain.parameters.installed_spring import InstalledSpring
    from valvetrain.solution.modes import SpringModes
    from valvetrain.solution.result import Solution
    from valvetrain.solution.static import StaticCurve
    from valvetrain.springs.contract import SpringModel

TURN = 2 * math.pi
#: Cam angle between the stations of a lift given as a function (rad).
LIFT_STEP = math.radians(0.25)
Lift = Callable[[float], float] | Mapping[str, Any] | Sequence[Any]


def as_table(value: Any, path: Sequence[str] = ()) -> Any:
    """A value of Python as the tree of a case file holds it: numbers are SI, quantities of a units
    library become text, arrays lists, springs and trains their tables, contact laws their names.
    ``path``: its keys.
    """
    if isinstance(value, (Spring, Train)):
        return copy.deepcopy(value.table)
    if tuple(path) == ("lift_law",):
        return lift_table(value)
    value = plain_value(value)
    if isinstance(value, Mapping):
        return {str(key): as_table(item, (*path, str(key))) for key, item in value.items()}
    if isinstance(value, (list, tuple)):
        return [as_table(item, (*path, "")) for item in value]
    if isinstance(value, (bool, str, int, float)):
        return value
    if path[-1:] == ("law",):
        return own_name(value)
    if path[-1:] == ("contact",) or path[-2:-1] == ("contacts",):
        return {"law": own_name(value)}
    raise InputError(
        f"{clipped(repr(value))} is no value of a case; give text with a unit, an SI number, a list or a table"
    )


def lift_table(law: Lift) -> dict[str, Any]:
    """The ``[lift_law]`` table of a lift: such a table, a function of the cam angle (rad) that
    gives the lift (m), or two rows of cam angles (rad) and lifts (m).

    A function is taken at every quarter of a degree of its event; a spline of degree 5 goes
    through these stations and gives the derivatives.
    """
    if isinstance(law, Mapping):
        return {str(key): as_table(item, ("lift_law", str(key))) for key, item in law.items()}
    if callable(law):
        angles, lifts = _stations(law)
    else:
        try:
            angles, lifts = (np.asarray(row, dtype=float) for row in law)
        except (TypeError, ValueError):
            raise InputError(
                "a lift is a table, a function of the cam angle, or cam angles (rad) and lifts (m)",
                "lift_law",
            ) from None
    return {
        "kind": "spline",
        "cam_angles": as_table(angles),
        "lifts": as_table(lifts),
    }


def _stations(function: Callable[[float], float]) -> tuple[np.ndarray, np.ndarray]:
    """Stations over the event of a lift function, from where it leaves zero to where it meets it."""

    def lift(angle: float) -> float:
        return float(function(angle % TURN))

    grid = np.arange(0.0, TURN, LIFT_STEP)
    try:
        lifts = np.array([lift(angle) for angle in grid])
    except (TypeError, ValueError) as error:
        raise InputError(
            f"the lift function fails ({error}); it takes a cam angle (rad) and gives a lift (m)",
            "lift_law",
        ) from error
    if not np.all(np.isfinite(lifts)) or lifts.min() < -1e-9 or not lifts.max() > 0:
        raise InputError(
            "the lift function gives no finite lift of zero or more that rises somewhere; correct it",
            "lift_law",
        )
    if lifts.max() > 0.1:
        raise InputError(
            f"the lift function gives up to {lifts.max():.4g} m; it takes radians and gives metres",
            "lift_law",
        )
    closed = lifts <= 1e-12 * lifts.max()
    if not closed.any():
        raise InputError(
            "the lift function never gives zero; a valve is closed somewhere in the revolution",
            "lift_law",
        )
    # From the end of the longest closed stretch, once around, to its beginning: all that opens.
    count, (opened,) = len(grid), np.nonzero(~closed)
    gaps = np.diff(np.append(opened, opened[0] + count))
    after = (int(np.argmax(gaps)) + 1) % len(opened)
    first = int(opened[after])
    last = int(opened[after - 1]) + (count if opened[after - 1] < first else 0)
    start, end = (first - 1) * LIFT_STEP, (last + 1) * LIFT_STEP
    begin = _edge(lift, start, start + LIFT_STEP)
    finish = _edge(lift, end, end - LIFT_STEP)
    count = max(math.ceil((finish - begin) / LIFT_STEP), 8)
    angles = np.linspace(begin, finish, count + 1)
    values = np.array([max(lift(angle), 0.0) for angle in angles])
    values[[0, -1]] = 0.0
    return angles, values


def _edge(lift: Callable[[float], float], closed: float, opened: float) -> float:
    """The cam angle at which a lift leaves zero, by bisection."""
    if lift(opened) <= 0:
        return opened
    for _ in range(50):
        middle = 0.5 * (closed + opened)
        closed, opened = (closed, middle) if lift(middle) > 0 else (middle, opened)
    return closed


def one_run(case: Parameters, engine_speed: Any, models: Any, **options: Any) -> Solution:
    """The only run of a request. Raises :class:`InputError` where there are several."""
    from valvetrain.runs.api import simulate

    found = simulate(case, engine_speed, models, **options)
    if len(found.solutions) != 1:
        runs = ", ".join(found.labels)
        raise InputError(
            f"these are {len(found.solutions)} runs ({runs}, {len(found.engine_speeds)} engine speeds); name one speed and one model, or use "
            "compare or sweep",
            case.name,
        )
    run = found.solutions[0]
    if options.get("outputs"):  # those that belong to no run are read from it as well
        still = {key: one for values in found.still.values() for key, one in values.items()}
        run = run.with_found(run.events, {**still, **run.quantities})
    return run


class Spring:
    """A valve spring as installed, by its wire or by its card, with the keys of ``[spring]`` in a
    case file (docs/case-files.md).

    Parameters
    ----------
    table : keys of the spring: text with a unit, an SI number, a pint quantity; a table is a dict

    Raises
    ------
    InputError : a key that a spring does not have, with the nearest one; what contradicts itself

    Examples
    --------
    >>> import valvetrain as vt
    >>> spring = vt.Spring(
    ...     wire_diameter="3.8 mm", mean_diameter=0.022, total_coils=7, pitch="7 mm",
    ...     material="EN 10270-2 VDSiCr", installed_height="36 mm"
    ... )
    >>> round(spring.static().force_at("5 mm"))
    188
    """

    def __init__(self, **table: Any) -> None:
        self.table: dict[str, Any] = as_table(table)
        from valvetrain.parameters.loading import case_of_tree

        self._case = case_of_tree({"spring": self.table}, "spring", where="vt.Spring")

    @property
    def parameters(self) -> InstalledSpring:
        """The frozen spring in SI."""
        return self._case.springs[0]

    def static(self, largest_compression: Given | None = None, **options: Any) -> StaticCurve:
        """Force over compression from the free state; options as for
        :func:`valvetrain.static_curve`.
        """
        from valvetrain.runs.api import static_curve

        return static_curve(self.parameters, largest_compression, **options)

    def frequencies(self, models: Any = "", count: int = 12) -> np.ndarray:
        """Surge frequencies (Hz) as installed, both ends fixed, by the spring model ``models``; by default by
        finite elements of a wire, of a card by the card.

        Those of finite elements that are clearly surge, ascending, ``count`` at most: higher ones
        couple with sway and twist, so the series ends (:meth:`modes` names every mode).
        """
        from valvetrain.runs.statics import axial_frequencies
        from valvetrain.springs.finite_element import FiniteElementRod

        built = self._built(models)
        if isinstance(built, FiniteElementRod):
            return self.modes(max(2 * count, 24)).surge_frequencies[:count]
        return axial_frequencies(built, count)

    def modes(self, count: int = 24) -> SpringModes:
        """Natural modes by finite elements as installed, both ends fixed: frequency, kind, axial share.

        Parameters
        ----------
        count : modes, the lowest first

        Returns
        -------
        SpringModes: ``natural_frequency`` (Hz), ``kinds`` (surge, lateral, coupled), ``axial_share``
        of the kinetic energy

        Raises
        ------
        InputError : a spring known by its card, a count below one

        Examples
        --------
        >>> import valvetrain as vt
        >>> spring = vt.Spring(
        ...     wire_diameter="4 mm", mean_diameter="24 mm", total_coils=7.5, pitch="7.6 mm",
        ...     material="EN 10270-2 VDSiCr", installed_height="42 mm"
        ... )
        >>> spring.modes(5)
        SpringModes: 5 modes
          422.24 Hz, surge, 91% axial
          463.04 Hz, lateral, 5% axial
          519.26 Hz, lateral, 12% axial
          530.45 Hz, lateral, 8% axial
          821.2 Hz, surge, 87% axial
        """
        from valvetrain.springs.finite_element import FiniteElementRod, spring_modes

        if self.parameters.wire is None:
            raise InputError(
                "modes by finite elements need the wire of a spring; give it, or use frequencies(models)",
                "modes",
            )
        if not (isinstance(count, (int, np.integer)) and count >= 1):
            raise InputError(
                f"modes are counted from one; count is {clipped(repr(count))}", "count"
            )
        built = self._built("finite-element")
        assert isinstance(built, FiniteElementRod)
        return spring_modes(built, int(count))

    def _built(self, models: Any) -> SpringModel:
        from valvetrain.springs.own_spring import model_name
        from valvetrain.springs.spec import spring_model
        from valvetrain.system.build import default_model

        spec = spring_model(model_name(models or default_model(self.parameters)), "models")
        if reason := spec.why_not(self.parameters):
            raise InputError(reason, "models")
        return spec.build(self.parameters, None)

    def run(self, engine_speed: Any, lift_law: Lift, models: Any = "", **options: Any) -> Solution:
        """The spring under a lift of its retainer, by the spring model ``models`` (default: as for
        :meth:`frequencies`); ``lift_law`` and options as for :class:`valvetrain.Case` and its ``run``.
        """
        from valvetrain.parameters.loading import case_of_tree
        from valvetrain.system.build import default_model

        models = models or default_model(self.parameters)
        tree = {"spring": self.table, "lift_law": lift_table(lift_law)}
        return one_run(
            case_of_tree(tree, "spring", where="vt.Spring"), engine_speed, models, **options
        )

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Spring) and self.parameters == other.parameters

    __hash__ = None  # type: ignore[assignment]

    def __repr__(self) -> str:
        keys = ", ".join(f"{key}={value!r}" for key, value in self.table.items())
        return f"Spring({keys})"


class Train:
    """A valvetrain with the keys of ``[train]`` in a case file.

    Parameters
    ----------
    kind : name of the kind of train, such as ``"direct"``, ``"finger"``, ``"pushrod"``
    springs : one spring, several that are nested (outer first), or a dict of such sets by name
    table : keys of the train: dicts of ``cam``, ``valve`` and other parts, ``lash`` and so on

    Examples
    --------
    >>> import valvetrain as vt
    >>> train = vt.Train(**vt.Case("tdi-pushrod").tree["train"])
    >>> train.table["kind"]
    'pushrod'
    """

    def __init__(
        self,
        kind: str,
        *,
        springs: Spring | Sequence[Spring] | Mapping[str, Any],
        **table: Any,
    ) -> None:
        sets = springs if isinstance(springs, Mapping) else {"main": springs}
        self.table: dict[str, Any] = {
            "kind": kind,
            **as_table(table),
            "springs": {
                name: [
                    as_table(one) for one in (item if isinstance(item, (list, tuple)) else [item])
                ]
                for name, item in sets.items()
            },
        }

    def __repr__(self) -> str:
        return f"Train({self.table['kind']!r}, {', '.join(key for key in self.table if key != 'kind')})"
