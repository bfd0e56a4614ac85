"""A still picture of a case to scale, from its parts alone: nothing is run, parts are placed as in slow
motion.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from valvetrain.parameters.case import Case
from valvetrain.quantities.cycle import Cycle
from valvetrain.solution.channels import ChannelArrays, Variable
from valvetrain.solution.provenance import Provenance
from valvetrain.solution.result import Solution
from valvetrain.system.build import build
from valvetrain.system.problem import Member
from valvetrain.views.motion.parts import Variant
from valvetrain.views.motion.project import MARGIN, Flat, flat_shapes
from valvetrain.views.motion.springs import draw_spring
from valvetrain.views.motion.train import draw_train

#: Cam angles (one revolution) at which the parts are drawn, and the model, which is not evaluated.
ANGLES, MODEL = 180, "massless"
#: Space between two drawings as a share of their height.
GAP_SHARE = 0.12


def case_picture(case: Case, closed_alone: bool = False) -> str:
    """The train or spring of ``case`` as an SVG document to scale: valve closed and, unless
    ``closed_alone``, at full lift to the same scale next to it where the case has a lift law.

    Empty where it has neither a train nor a spring whose wire can be drawn. Raises
    :class:`InputError` where the case cannot be built.
    """
    if case.train is None and not case.springs:
        return ""
    variant = _variant(build(case, spring_models=(MODEL,)).members[0])
    if variant is None:
        return ""
    lift = variant.valve_lift
    closed, full = int(np.argmin(lift)), int(np.argmax(lift))
    frames = (closed,) if closed_alone or lift[full] <= lift[closed] else (closed, full)
    return _svg([flat_shapes(variant, frame) for frame in frames])


def _svg(drawings: Sequence[Sequence[Flat]]) -> str:
    """Drawings side by side to one scale, in mm."""
    every = np.concatenate([one.points for shapes in drawings for one in shapes])
    (left, low), (right, high) = every.min(axis=0) - MARGIN, every.max(axis=0) + MARGIN
    width, lines = right - left + GAP_SHARE * (high - low), []
    for place, shapes in enumerate(drawings):
        for one in shapes:
            x = 1e3 * (one.points[:, 0] - left + place * width)
            y = 1e3 * (high - one.points[:, 1])
            path = "M" + "L".join(f"{a:.2f} {b:.2f}" for a, b in zip(x, y, strict=True))
            colour = "#" + "".join(f"{part:02x}" for part in one.colour)
            lines.append(f'<path d="{path}Z" fill="{colour}" stroke="{colour}"/>')
    across = (len(drawings) - 1) * width + right - left
    size = f"0 0 {1e3 * across:.2f} {1e3 * (high - low):.2f}"
    return f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="{size}" stroke-width=".15">{"".join(lines)}</svg>'


def _variant(member: Member) -> Variant | None:
    """The parts over one cam revolution, as rigid parts move."""
    angle = np.arange(ANGLES) * 2 * np.pi / ANGLES
    lift = np.asarray(member.valve_lift.lift(angle), dtype=float)
    channels = ChannelArrays(
        {"valve_lift": Variable(("sample",), lift, {"units": "m", "long_name": "valve lift"})},
        {
            "time": Variable(("sample",), angle, {"units": "s", "long_name": "time"}),
            "cam_angle": Variable(("sample",), angle, {"units": "rad", "long_name": "cam angle"}),
        },
    )
    names = tuple(spring.name for spring in member.springs)
    run = Solution(channels, provenance=Provenance("", MODEL, springs=names))
    cycle, sample = Cycle(run, slice(None), angle, angle, True), np.arange(ANGLES)
    train = None if member.gear is None else draw_train(member, cycle, sample)
    travel = lift if train is None else train.travel
    springs = []
    for spring in member.springs:
        drawn, _ = draw_spring(spring, spring.name, cycle, sample, travel, None)
        if drawn is not None and train is not None:
            height = float(drawn.retainer[0] + travel[0])
            drawn = replace(drawn, seat=train.seat_of(height), direction=train.axis)
        springs += [] if drawn is None else [drawn]
    if train is None and not springs:
        return None
    bodies = () if train is None else train.bodies
    return Variant("", "", 0.0, sample, angle, lift, tuple(springs), bodies)
