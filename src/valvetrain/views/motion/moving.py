"""The runs of a study in motion."""

from __future__ import annotations

from valvetrain.findings.facts import Facts
from valvetrain.solution.study import Study
from valvetrain.views.figures import worst_run
from valvetrain.views.motion.parts import Moving
from valvetrain.views.motion.scene import moving_picture


def moving_of(study: Study, facts: Facts) -> Moving | None:
    """The moving picture of a study, the run that decides first; None where no run moves."""
    worst = worst_run(facts)
    moving = moving_picture(study, worst=worst)
    if moving is None or worst is None:
        return moving

    def order(place: int) -> tuple[bool, int, bool]:
        one = moving.variants[place]
        here = one.engine_speed == worst.engine_speed
        colours = sum(len(spring.colourings) for spring in one.springs)
        return not here, -colours, one.label != worst.label

    places = sorted(range(len(moving.variants)), key=order)
    return Moving(moving.title, tuple(moving.variants[k] for k in places), moving.notes)
