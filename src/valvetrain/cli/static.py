"""``valvetrain static`` and ``modes``: springs at rest, and their natural frequencies."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from valvetrain.cli.request import StudyLine, command_of
from valvetrain.cli.run_answer import answer_study
from valvetrain.runs.cost import FEWER_AT_REST
from valvetrain.runs.requests import Modes, Static, Watch

if TYPE_CHECKING:
    from valvetrain.solution.study import Study


def static(request: Static, line: StudyLine, folder: Path) -> None:
    """Force, stiffness and stress over compression, coils closing, of every spring of a case, and
    at heights and loads requested.
    """
    from valvetrain.runs.static_study import static_study

    answer_study(request, line, folder, static_study, request.cost(), ("statics",), FEWER_AT_REST)


register = command_of(Static, StudyLine, static)


def modes(request: Modes, line: StudyLine, folder: Path) -> None:
    """Natural frequencies of springs, both ends fixed or one with a mass; of a train also with its
    springs, as one.
    """
    from valvetrain.runs.static_study import static_study
    from valvetrain.runs.train_runs import train_modes

    def compute(request: Modes, watch: Watch) -> Study:
        case, models, sets = request.case, request.models, request.spring_sets
        study = static_study(request, watch)
        if case.train is None or request.compression is not None:
            return study
        lowest = (one.lowest(request.count) for one in train_modes(case, models, spring_sets=sets))
        return replace(study, train_modes=tuple(lowest))

    answer_study(request, line, folder, compute, request.cost(), ("statics",), FEWER_AT_REST)


register_modes = command_of(Modes, StudyLine, modes)
