"""The refinement study of any case: of a spring under prescribed motion, or of a train."""

from __future__ import annotations

from collections.abc import Sequence

from valvetrain.parameters.case import Case
from valvetrain.studies.engine import Progress
from valvetrain.studies.train_uncertainty import train_uncertainty
from valvetrain.studies.uncertainty import UncertaintyStudy, uncertainty_study


def refined(
    case: Case, engine_speeds: Sequence[float] | None = None, *, workers: int = 2, progress: Progress | None = None
) -> UncertaintyStudy:
    """Error bars of a case's headline numbers at ``engine_speeds`` (rad/s of the crank; None: the case's own).

    Raises :class:`InputError` for a case that cannot be refined.
    """
    study = uncertainty_study if case.train is None else train_uncertainty
    return study(case, engine_speeds, workers=workers, progress=progress)
