"""Valve events and spring margin with known answers: see `known_quantities`."""

from __future__ import annotations

import math

import numpy as np

from synthetic_train import ANGLE, CAM_SPEED, COUNT, degrees, lift_of, rigid, train
from train_parts import direct
from valvetrain.cam.closed_form import Harmonic
from valvetrain.mechanism.build import build_mechanism
from valvetrain.parameters.train_parts import CamParameters
from valvetrain.quantities.cycle import Frame
from valvetrain.quantities.evaluate import evaluate
from valvetrain.quantities.forces import surge_engine_speeds
from valvetrain.quantities.valve_events import rigid_events
from valvetrain.solution.status import Event

DEG, THOU = np.pi / 180, 1.27e-3
RIGID_TOP = 9e-3  # largest lift of rigid parts where flex takes some of it


def events(
    subject: str, word: str, opens: float, closes: float, within: float
) -> dict[str, tuple[float, float]]:
    """The three numbers of a pair of crossings."""
    return {
        f"{subject}_{word}_opening_cam_angle": (opens, within),
        f"{subject}_{word}_closing_cam_angle": (closes, within),
        f"{subject}_{word}_open_crank_angle_range": (2 * (closes - opens), 4 * within),
    }


def valve_events():
    """A valve of 8 mm sin^2, off its seat from 91.5 to 268 degrees; torque of 3.4 J per turn; a
    margin least at 150 degrees.
    """
    velocity = np.where(degrees(90, 270), 8e-3 * np.sin(2 * ANGLE - np.pi) * CAM_SPEED, 0.0)
    told = {"largest_gap": 8e-3, "release_cam_angle": 91.5 * DEG}
    touch = Event("touch", 268 * DEG, 268 * DEG / CAM_SPEED, 0.0, 0.3, "m/s", "seat", told)
    made = train((touch,), statistics={"cycle_work_energy": 3.4}, valve_velocity=velocity)
    inertia = np.where(degrees(135, 225), -300.0, 200.0)
    table = rigid(
        spring_margin=np.where(degrees(149, 151), 77.0, 400.0),
        inertia_force=inertia,
        spring_force=500.0 + 1e4 * lift_of(ANGLE) * RIGID_TOP / 8e-3,
        valve_lift=lift_of(ANGLE) * RIGID_TOP / 8e-3,
    )
    found = evaluate(made, Frame(rigid=table)).quantities
    known = events("valve", "lash", 91.5 * DEG, 268 * DEG, 1e-9)
    for word, height in (("1_mm", 1e-3), ("50_thou", THOU)):
        away = math.asin(math.sqrt(height / 8e-3))
        known |= events("valve", word, np.pi / 2 + away, 1.5 * np.pi - away, 1e-7)
        higher = math.asin(math.sqrt(height / RIGID_TOP))
        known[f"valve_{word}_lost_crank_angle_range"] = (4 * (away - higher), 1e-6)
    assert len(ANGLE) == COUNT and lift_of(np.array(np.pi)) == 8e-3
    known |= {
        "minimum_spring_margin_force": 77.0,
        "minimum_spring_margin_ratio": 77 / 300 + 1,
        # 17 N more than a fifth of 300 N are left at 149 to 151 degrees, 61 degrees from the opening
        "open_spring_force": 500 + 1e4 * RIGID_TOP,
        "needed_closed_spring_force": 483.0,
        "needed_open_spring_force": 483 + 1e4 * RIGID_TOP,
        "needed_spring_rate": (1e4 - 17 / (RIGID_TOP * math.sin(61 * DEG) ** 2), 60.0),
        "mean_cam_torque": 3.4 / (2 * np.pi),
    }
    return found, known


def surge_speeds():
    """427.1 Hz met by cam orders 8 to 10 between 5000 and 6500 rpm: 120 f / n rpm."""
    found = surge_engine_speeds(427.1, 5000 * np.pi / 30, 6500 * np.pi / 30)
    assert len(found) == 3
    return found, {
        f"surge_order_{n}_engine_speed": 120 * 427.1 / n * np.pi / 30 for n in (8, 9, 10)
    }


def rigid_valve_events():
    """A bucket under a harmonic lift h / 2 (1 - cos(pi x)), 0.2 mm of lash: every height is one of
    the lobe that much higher.
    """
    top, flank, nose, lash = 8e-3, 62 * DEG, 3.0, 0.2e-3
    law = Harmonic(
        maximum_lift=top,
        opening_start=nose - flank,
        opening_end=nose,
        closing_start=nose,
        closing_end=nose + flank,
    )
    found = rigid_events(
        build_mechanism(direct(lash=lash, cam=CamParameters(0.030)), law).kinematics
    )
    known = {}
    for subject, more in (("lobe", 0.0), ("rigid_valve", lash)):
        for word, height in {"lash": 0.0, "1_mm": 1e-3, "50_thou": THOU}.items():
            if subject == "rigid_valve" or word != "lash":
                half = flank * (1 - math.acos(1 - 2 * (height + more) / top) / math.pi)
                known |= events(subject, word, nose - half, nose + half, 1e-9)
    return found, known
