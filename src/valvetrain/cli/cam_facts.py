"""The cam in ``valvetrain check``: its numbers."""

from __future__ import annotations

from typing import TYPE_CHECKING

from valvetrain.quantities.cam_shape import cam_durations, cam_quantities

if TYPE_CHECKING:
    from valvetrain.cam.contract import LiftLaw
    from valvetrain.parameters.case import Case
    from valvetrain.system.problem import Gear, Problem


def gear_of(problem: Problem | None) -> Gear | None:
    """The train of a problem; None of springs alone."""
    members = () if problem is None else problem.members
    return next((one.gear for one in members if one.gear is not None), None)


def cam_facts(case: Case, problem: Problem | None) -> tuple[dict[str, float], dict[float, float]]:
    """Named quantities (SI) of the cam and its durations: lift (m) -> crank angle (rad); both empty for a
    case without a lift law.
    """
    if case.lift_law is None:
        return {}, {}
    from valvetrain.system.build import lift_law_of

    gear = gear_of(problem)
    law = lift_law_of(case) if gear is None else gear.mechanism.kinematics.law
    points = (lift for _, lift, _ in getattr(law, "checking_points", ()))
    return cam_quantities(law, gear, _ramp(case, law)), cam_durations(law, points)


def _ramp(case: Case, law: LiftLaw) -> float:
    """Lift (m) at which the ramps of a law end, as built or as its table gives it; 0 where it has none."""
    given = getattr(law, "ramp_lift", 0.0) or getattr(case.lift_law, "values", {}).get("ramp_lift")
    return float(given or 0.0)
