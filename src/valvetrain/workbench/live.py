"""The fast chain while a slider moves: a worker process that holds the case built and answers with one force curve."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from types import MappingProxyType

_NOTHING: Mapping[str, str] = MappingProxyType({})


@dataclass(frozen=True, slots=True)
class LiveResult:
    """One curve.

    Parameters
    ----------
    angle_deg : cam angles (cam degrees)
    force_N : spring force on the retainer, of all springs together (N)
    lift_mm : valve lift (mm)
    seconds : time it took in the worker (s)
    sentence : what went wrong, empty where nothing did; the lists are then empty
    quantities : name -> (value, unit shown) of a few numbers, such as the largest force
    """

    angle_deg: tuple[float, ...] = ()
    force_N: tuple[float, ...] = ()  # noqa: N815
    lift_mm: tuple[float, ...] = ()
    seconds: float = 0.0
    sentence: str = ""
    quantities: Mapping[str, tuple[float, str]] = field(default_factory=dict)


class LiveChain:
    """A case in a worker process of its own; use it as a context, or call :meth:`close`.

    Parameters
    ----------
    case_text : the case (TOML)
    spring_model : ``multi-mass`` or ``massless``; empty: the fastest that moves
    engine_speed : crank speed, such as ``"5600 rpm"``; empty: the highest of the case
    folder : where files that the case names lie
    """

    def __init__(self, case_text: str, spring_model: str = "", engine_speed: str = "", folder: Path = Path()) -> None:
        self.case_text, self.spring_model, self.engine_speed, self.folder = case_text, spring_model, engine_speed, folder

    def curve(self, changes: Mapping[str, str] = _NOTHING, engine_speed: str = "") -> LiveResult:
        """The curve of the case with ``changes`` (key path -> text, as ``--set`` takes them); a refusal is its ``sentence``.

        Blocks for tens of milliseconds; a page calls it in a thread. Of calls that wait, only the last is answered by a curve, the
        others with an empty one.
        """
        raise NotImplementedError

    def rod(self, changes: Mapping[str, str] = _NOTHING, engine_speed: str = "") -> LiveResult:
        """The curve by the geometrically exact rod, seconds; :meth:`cancel` ends it, and a new call ends one that runs."""
        raise NotImplementedError

    def cancel(self) -> None:
        """End a rod that runs; its call returns with a sentence."""

    def close(self) -> None:
        """End the worker."""

    def __enter__(self) -> LiveChain:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()
