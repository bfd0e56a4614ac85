"""Line styles of the labels of a study."""

from __future__ import annotations

from dataclasses import dataclass

from valvetrain.report import theme
from valvetrain.solution.result import Solution
from valvetrain.solution.study import Study

ANGLE_LABEL = "cam angle (cam degrees)"


@dataclass(frozen=True, slots=True)
class LineStyle:
    """Colour, dash and label of the lines of one label of a study."""

    colour: str
    dash: str
    label: str


def line_styles(study: Study) -> dict[str, LineStyle]:
    """Label -> line style: colour by model where each label has a colour of its own, else by label;
    dash by spring set.
    """
    first = {
        label: next(run for run in study.solutions if run.label == label) for label in study.labels
    }
    sets = list(dict.fromkeys(run.spring_set for run in first.values()))
    dashes = ("solid", "dashdot", "dot")
    found = {
        label: LineStyle(
            theme.model_colour(run.model),
            dashes[sets.index(run.spring_set) % 3],
            _label(label, run),
        )
        for label, run in first.items()
    }
    if (
        study.command != "compare-springs"
        and len({look.colour for look in found.values()}) == len(found)
        and (len(found) > 1 or (all((label == run.model for label, run in first.items()))))
    ):
        return found
    plain = study.command == "compare-springs"
    return {
        label: LineStyle(
            theme.SERIES[n % len(theme.SERIES)],
            "solid" if plain else found[label].dash,
            _label(label, run),
        )
        for n, (label, run) in enumerate(first.items())
    }


def _label(label: str, run: Solution) -> str:
    return theme.model_label(label) if label == run.model else label
