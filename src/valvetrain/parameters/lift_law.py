"""What a case says of its lift law; `valvetrain.cam.build_lift_law` turns it into a law that can be
evaluated.
"""

from __future__ import annotations

import math
import re
from collections.abc import Mapping
from dataclasses import dataclass, field
from itertools import pairwise
from pathlib import Path
from typing import Annotated, Any, ClassVar, Literal

from pydantic import Field, PlainValidator

from valvetrain import registry
from valvetrain.errors import FrozenMapping
from valvetrain.parameters.changes import nearest
from valvetrain.parameters.schema_types import Line, StrictModel, guarded, problem, validate_as


@dataclass(frozen=True)
class LiftLawParameters:
    """Kind of a lift law and its numbers.

    ``kind``: spline, polynomial, polydyne, cycloidal, modified-sine, modified-trapezoid, harmonic,
    sine-power, ramped, shaped,
    cam-card, three-arc, tangent, stations or zero.
    ``values``: the keyword arguments of that law's class in `valvetrain.cam`, SI (m, cam rad).
    ``lift_of``: where the lift is measured, at the tappet (cam) or the valve.
    ``zero_of_angle``: what the zero of the cam angle means, printed on every plot.
    ``top_dead_centre``: cam angle (rad) of top dead centre of gas exchange, where the law says it.
    """

    kind: str
    values: Mapping[str, Any] = field(default_factory=FrozenMapping)
    lift_of: Literal["valve", "tappet"] = "valve"
    zero_of_angle: str = ""
    top_dead_centre: float | None = None

    def __post_init__(self) -> None:
        object.__setattr__(self, "values", FrozenMapping(self.values))

    @property
    def zero(self) -> str:
        """What the zero of the cam angle means: what the case says of it, else where top dead centre is; empty if unknown."""
        dead = self.top_dead_centre
        told = "" if dead is None else f"{math.degrees(dead):.4g} cam deg before top dead centre"
        return self.zero_of_angle or told

    def replace(self, **changes: Any) -> LiftLawParameters:
        """A copy with fields changed; a name that is no field is looked up among ``values``."""
        own = {name: changes.pop(name, getattr(self, name)) for name in self.__dataclass_fields__}
        return LiftLawParameters(**own | {"values": {**own["values"], **changes}})


TURN = 2 * math.pi


def _read_exponents(raw: Any) -> tuple[int, ...]:
    """``"3-4-5"`` or ``[3, 4, 5]``."""
    if isinstance(raw, str) and re.fullmatch(r"\d{1,3}(-\d{1,3})*", raw):
        raw = [int(part) for part in raw.split("-")]
    if not isinstance(raw, list) or not all(
        isinstance(item, int) and not isinstance(item, bool) and 1 <= item <= 200 for item in raw
    ):
        raise problem("exponents are whole numbers from 1 to 200, written as '3-4-5'")
    if raw != sorted(set(raw)) or not 2 <= len(raw) <= 12:
        raise problem("give 2 to 12 exponents in rising order, each once, as in '3-4-5'")
    return tuple(raw)


Exponents = Annotated[tuple[int, ...], PlainValidator(_read_exponents)]


class LiftModel(StrictModel):
    """What every law may say."""

    law: ClassVar[str] = ""
    kind: str
    lift_of: Literal["valve", "tappet"] = Field(
        default="valve", description="lift measured at the valve or the tappet"
    )
    zero_of_angle: Line = Field(default="", description="what the zero of the cam angle means")

    def parameters(self, folder: Path) -> LiftLawParameters:
        """What the case stores of this table; ``folder`` is where relative file names start."""
        return LiftLawParameters(
            self.law or self.kind,
            self.values(folder),
            self.lift_of,
            self.zero_of_angle,
            getattr(self, "dead_centre", None),  # of a law that says it
        )

    def values(self, folder: Path) -> dict[str, Any]:
        """Keyword arguments of the law's class; raises a located problem when the table contradicts
        itself.
        """
        own = {name: value for name, value in self if name not in LiftModel.model_fields}
        self.in_order(*(name for name in own if name.endswith(("_start", "_end"))))
        return own

    def in_order(self, *names: str) -> None:
        """Refuse events that do not follow each other within one revolution."""
        for first, second in pairwise(names):
            early, late = getattr(self, first), getattr(self, second)
            # A dwell may have no length; a flank may not.
            if late < early or (
                late == early and (first, second) != ("opening_end", "closing_start")
            ):
                raise problem(
                    f"{second} ({math.degrees(late):g} deg) must come after {first} ({math.degrees(early):g} deg); put the events in order",
                    (second,),
                )
        if names and getattr(self, names[-1]) - getattr(self, names[0]) > TURN + 1e-9:
            raise problem(
                f"the event from {names[0]} to {names[-1]} is longer than one cam revolution; shorten it",
                (names[-1],),
            )


def check_angles(cam_angles: tuple[float, ...], path: tuple[str, ...]) -> None:
    """Refuse stations that do not increase, are too few or span more than one revolution."""
    if len(cam_angles) < 4:
        raise problem(f"a lift table needs at least four stations; it has {len(cam_angles)}", path)
    for early, late in pairwise(cam_angles):
        if late - early < 1e-6:
            raise problem(
                f"the angles must increase; {math.degrees(late):g} deg follows {math.degrees(early):g} deg",
                path,
            )
    if cam_angles[-1] - cam_angles[0] > TURN + 1e-9:
        raise problem(
            "the lift table spans more than one cam revolution; cut it (or say angle_of = 'crank')",
            path,
        )


def read_lift_model(raw: Any) -> LiftModel:
    """Choose the table by ``kind`` from the registry, which loads that law alone, and validate
    against it.
    """
    if not isinstance(raw, dict) or not isinstance(raw.get("kind"), str):
        raise problem(f"a lift law needs its kind, one of {', '.join(registry.names('lifts'))}")
    kind = raw["kind"]
    if kind not in registry.names("lifts"):
        raise problem(
            f"kind '{kind[:40]}' of a lift law is unknown; {nearest(kind, registry.names('lifts'))}",
            ("kind",),
        )
    table: LiftModel = validate_as(guarded(registry.find, "lifts", kind).table, raw)
    return table


LiftField = Annotated[LiftModel, PlainValidator(read_lift_model)]
