"""The spring and its train in motion: one picture that plays, steps and jumps over the cam cycle."""

from __future__ import annotations

from valvetrain.report.motion.pack import motion_json
from valvetrain.report.motion.scene import moving_picture
from valvetrain.report.motion.still import still_svg
from valvetrain.report.page import Block, Motion, SectionSpec, gap
from valvetrain.solution.gaps import reason
from valvetrain.solution.study import Study


def blocks(study: Study) -> tuple[Block, ...]:
    """The picture of the runs that can be drawn; nothing where none moves, a sentence where it fails."""
    try:
        moving = moving_picture(study)
        if moving is None:
            return ()
        first = moving.variants[0]
        caption = (
            "The reported cam turn, slowed. Drag or use the arrow keys on the picture to turn it; space plays, arrow keys step by one cam "
            "degree, with shift by ten, page keys go from mark to mark. Triangles on the slider are peaks of the force, orange strokes "
            "clashes."
        )
        return (Motion("in-motion", moving.title, caption, motion_json(moving), still_svg(first)),)
    except Exception as error:  # one picture must not cost the page
        return (gap(f"The moving picture could not be drawn: {reason(error)}"),)


SPEC = SectionSpec("in-motion", "In motion", blocks)
