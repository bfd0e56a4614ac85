"""What ``valvetrain run`` was asked for."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from valvetrain.parameters.case import Case


@dataclass(frozen=True)
class RunRequest:
    """One run: the case with its changes, ``engine_speeds`` (rad/s of the crank; None: the case's own), names of spring models
    (empty: the study's own choice), number of ``workers``, folder for the results, and whether the report page is written."""

    case: Case
    engine_speeds: tuple[float, ...] | None
    spring_models: tuple[str, ...]
    workers: int
    output: Path
    report: bool = True
