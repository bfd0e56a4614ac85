"""What a case says of its lift law; `valvetrain.cam.build_lift_law` turns it into a law that can be
evaluated.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from typing import Any, Literal


class FrozenMapping(Mapping[str, Any]):
    """A small read-only mapping that can be hashed, compared and sent to another process."""

    __slots__ = ("_items",)

    def __init__(self, *args: Any, **kwargs: Any) -> None:
        self._items = dict(*args, **kwargs)

    def __getitem__(self, key: str) -> Any:
        return self._items[key]

    def __iter__(self) -> Iterator[str]:
        return iter(self._items)

    def __len__(self) -> int:
        return len(self._items)

    def __hash__(self) -> int:
        return hash(frozenset(self._items.items()))

    def __repr__(self) -> str:
        return f"FrozenMapping({self._items!r})"


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
