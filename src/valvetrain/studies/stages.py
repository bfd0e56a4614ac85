"""The stages of a refinement, each a set of independent runs, and what is left of them when it is
stopped.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from valvetrain.studies.engine import map_points
from valvetrain.studies.stopping import PointsStopped, RefinementStopped

if TYPE_CHECKING:
    from valvetrain.studies.error_bars import UncertaintyStudy


class Stages:
    """Independent runs of several stages; once one of them is stopped, what it has is handed back
    and no other begins.
    """

    def __init__(self) -> None:
        self.stopped = False

    def map(self, *given: Any, **options: Any) -> dict[int, Any]:
        """:func:`valvetrain.studies.engine.map_points`, its results by place."""
        if self.stopped:
            return {}
        try:
            return dict(enumerate(map_points(*given, **options)))
        except PointsStopped as cut:
            self.stopped = True
            return cut.results

    def closed(self, study: UncertaintyStudy) -> UncertaintyStudy:
        """The study. Raises :class:`RefinementStopped` with it where a stage was stopped."""
        if self.stopped:
            raise RefinementStopped(study)
        return study
