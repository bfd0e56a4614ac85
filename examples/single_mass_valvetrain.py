"""A valvetrain in one file: one mass, a cam, a seat and a spring, in plain NumPy and SciPy.

The teaching twin of the assembled trains: the same equation, m a = F_cam - F_spring + F_seat + m g,
written out.
Run it to see lift, contact force and seating of two cam turns: python
examples/single_mass_valvetrain.py
"""

from __future__ import annotations

import numpy as np
from scipy.integrate import solve_ivp

MASS = 0.12  # kg: valve, retainer, tappet and a third of the spring
SPRING_RATE, PRELOAD = 30e3, 250.0  # N/m, N
CONTACT_STIFFNESS, CONTACT_DAMPING = 2e7, 300.0  # N/m, N s/m, cam and seat alike
LIFT, START, END = 8e-3, np.radians(40), np.radians(240)  # m, cam rad: lift = LIFT sin^4
LASH, GRAVITY = 0.1e-3, 9.80665  # m, m/s2 (the valve hangs down)
CAM_SPEED = 2500 * np.pi / 30  # rad/s


def cam_lift(cam_angle: float) -> tuple[float, float]:
    """Lift (m) and its derivative (m/rad) of the cam."""
    since = (cam_angle - START) % (2 * np.pi)
    if since >= END - START:
        return 0.0, 0.0
    rate = np.pi / (END - START)
    sine, cosine = np.sin(rate * since), np.cos(rate * since)
    return LIFT * sine**4, LIFT * 4 * rate * sine**3 * cosine


def contact(penetration: float, penetration_rate: float) -> float:
    """Force (N) of a contact that pushes but never pulls."""
    if penetration <= 0:
        return 0.0
    return max(0.0, CONTACT_STIFFNESS * penetration + CONTACT_DAMPING * penetration_rate)


def forces(
    cam_angle: float, valve_lift: float, valve_velocity: float
) -> tuple[float, float, float]:
    """Force (N) of cam, seat and spring on the valve, each positive in its own sense."""
    lift, slope = cam_lift(cam_angle)
    cam = contact(lift - LASH - valve_lift, slope * CAM_SPEED - valve_velocity)
    seat = contact(-valve_lift, -valve_velocity)
    return cam, seat, PRELOAD + SPRING_RATE * valve_lift


def motion(time: float, state: np.ndarray) -> list[float]:
    """Velocity and acceleration of the valve."""
    cam, seat, spring = forces(CAM_SPEED * time, *state)
    return [state[1], (cam + seat - spring) / MASS + GRAVITY]


def simulate(cycles: int = 2, samples: int = 1440) -> dict[str, np.ndarray]:
    """Last of ``cycles`` cam turns: cam_angle (rad), valve_lift (m), valve_velocity (m/s),
    cam_force and seat_force (N).
    """
    period = 2 * np.pi / CAM_SPEED
    rest = -(PRELOAD - MASS * GRAVITY) / (CONTACT_STIFFNESS + SPRING_RATE)
    times = (cycles - 1 + np.arange(samples) / samples) * period
    found = solve_ivp(
        motion,
        (0, cycles * period),
        [rest, 0.0],
        "RK45",
        times,
        rtol=1e-8,
        atol=1e-12,
        max_step=period / 4000,
    )
    pushed = np.array([forces(CAM_SPEED * t, *y) for t, y in zip(found.t, found.y.T, strict=True)])
    angle = np.arange(samples) * 2 * np.pi / samples
    return {
        "cam_angle": angle,
        "valve_lift": found.y[0],
        "valve_velocity": found.y[1],
        "cam_force": pushed[:, 0],
        "seat_force": pushed[:, 1],
    }


if __name__ == "__main__":
    run = simulate()
    print(f"peak lift        {run['valve_lift'].max() * 1e3:8.3f} mm")
    print(f"peak cam force   {run['cam_force'].max():8.1f} N")
    print(f"seat force       {run['seat_force'][0]:8.1f} N at rest")
