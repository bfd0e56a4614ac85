"""What a live chain answers."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field


@dataclass(frozen=True, slots=True)
class LiveResult:
    """One curve.

    Parameters
    ----------
    angle_deg : cam angles (cam degrees)
    force_N : spring force on the retainer, of all springs together (N)
    seconds : time it took in the worker (s)
    sentence : what went wrong, or is to be said of the curve; empty where there is nothing
    quantities : words -> (value, unit shown) of a few numbers, such as the largest force
    engine_speed : crank speed (rpm)
    skipped : no curve was computed, for a newer one was requested meanwhile
    model : name of the spring model
    """

    angle_deg: tuple[float, ...] = ()
    force_N: tuple[float, ...] = ()
    seconds: float = 0.0
    sentence: str = ""
    quantities: Mapping[str, tuple[float, str]] = field(default_factory=dict)
    engine_speed: float = 0.0
    skipped: bool = False
    model: str = ""
