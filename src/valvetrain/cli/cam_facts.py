"""The cam in ``valvetrain check``: its table, and the sentence that ends the command."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import TYPE_CHECKING

from valvetrain.cli.case_facts import pushrod_doubt
from valvetrain.quantities.cam_shape import (
    cam_durations,
    cam_quantities,
    lash_lift,
)
from valvetrain.report.clauses import quantity_text
from valvetrain.report.text import number, quantity_label
from valvetrain.solution.definition import NESTED

if TYPE_CHECKING:
    from valvetrain.cam.contract import LiftLaw
    from valvetrain.parameters.case import Case
    from valvetrain.system.problem import Gear, Problem

#: Quantities of the cam in the order of its table, opening and closing in one row where they are alike.
ORDER = (
    ("cam_ramp_lift",), ("cam_opening_ramp_velocity", "cam_closing_ramp_velocity"), ("cam_opening_velocity", "cam_closing_velocity"),
    ("cam_largest_acceleration",), ("cam_smallest_acceleration",), ("cam_contact_offset",), ("cam_contact_face_radius",),
    ("cam_least_radius",), ("cam_hollow_radius",),
)  # fmt: skip


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


def cam_rows(
    quantities: Mapping[str, float], durations: Mapping[float, float]
) -> list[tuple[str, str, str]]:
    """(label, number, unit) of the cam's table."""
    from valvetrain.cli.outcome import shown_text

    rows = []
    # a face about its axis, which is above the cam's centre unless it is offset
    centred = quantities.get("cam_contact_face_radius") == quantities.get("cam_contact_offset")
    for names in ORDER:
        given = [name for name in names if name in quantities]
        if centred and names == ("cam_contact_offset",):
            continue
        shown = [shown_text(name, quantities[name], 4) for name in given]
        if len(shown) == 2 and shown[0] == shown[1]:
            rows.append((quantity_label(given[0]).removesuffix(", opening"), *shown[0]))
        else:
            rows += [(quantity_label(name), *text) for name, text in zip(given, shown, strict=True)]
    rows += [
        (f"Open above {_height(lift)}", number(math.degrees(angle)), "crank deg")
        for lift, angle in durations.items()
    ]
    return rows


def _height(lift: float) -> str:
    return f"{number(lift * 1e3)} mm ({lift / 25.4e-3:.3f} in)"  # cards of both kinds are at hand


def _unchecked(quantities: Mapping[str, float]) -> str:
    """The spring of a pair of which no solid height is known."""
    known = [one for one in NESTED if f"{one}_coil_bind_lift" in quantities]
    if len(known) != 1:
        return ""
    other = next(one for one in NESTED if one not in known)
    return (
        f" of the {known[0]} spring; the {other} one is not checked, for it states no solid height"
    )


def check_verdict(
    case: Case, problem: Problem | None, quantities: Mapping[str, float], cam: Mapping[str, float]
) -> str:
    """One sentence: whether the case runs, and what its cam and springs mean for the parts."""
    doubts, facts = [], []
    gear = gear_of(problem)
    if gear is not None and "cam_closing_ramp_velocity" in cam and (lash := lash_lift(gear)) > 0:
        ramp = cam.get("cam_ramp_lift", 0.0)
        speed = quantity_text("cam_closing_ramp_velocity", cam["cam_closing_ramp_velocity"])
        if lash <= ramp * (1 + 1e-9):
            facts.append(f"the lash opens on the ramp, at {speed}")
        elif ramp > 0:
            own = quantity_text("cam_ramp_lift", lash)
            doubts.append(
                f"the lash takes {own} of the lobe, above its ramp, so that the valve strikes its seat"
            )
        else:
            facts.append(f"the lash opens at {speed}, for the lift law states no ramp")
    face = None if gear is None else gear.parameters.follower.face_diameter
    if (away := cam.get("cam_contact_face_radius")) is not None:
        if face is None:
            facts.append(
                f"the follower's face needs a diameter of {quantity_text('cam_contact_face_radius', 2 * away)}"
            )
        else:
            left = quantity_text("cam_contact_face_radius", abs(face / 2 - away))
            inside = away <= face / 2
            (facts if inside else doubts).append(
                f"the contact stays {left} within the face" if inside else f"the contact runs {left} off the face, "
                f"which needs a diameter of {quantity_text('cam_contact_face_radius', 2 * away)}"
            )  # fmt: skip
    if (doubt := pushrod_doubt(case.train)) and problem is not None:
        doubts.append(doubt)
    if (radius := cam.get("cam_least_radius")) is not None:
        facts.append(f"the cam's least radius is {quantity_text('cam_least_radius', radius)}")
    lift = quantities.get("rigid_maximum_valve_lift", quantities.get("maximum_lift"))
    solid = [value for name, value in quantities.items() if name.endswith("coil_bind_lift")]
    if lift is not None and solid:
        facts.append(
            f"{quantity_text('coil_bind_clearance', min(solid) - lift)} are left to coil bind{_unchecked(quantities)}"
        )
    elif lift is not None and problem is not None:
        facts.append("coil bind is not checked, for no spring states a solid height")
    begun = "A lift law alone" if problem is None else "Ready to run"
    text = "; ".join((*doubts, *facts))
    if doubts:
        begun += ", but"
        return f"{begun} {text}."
    return f"{begun}: {text}." if text else f"{begun}."
