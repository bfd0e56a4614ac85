"""
How much does damping calm the surge?
=====================================

At a speed where a harmonic of the lift meets the surge frequency, damping alone limits how far the
spring swings up. Away from it, damping
hardly matters.
"""

import numpy as np
import plotly.graph_objects as go

import valvetrain as vt

ratios = np.array([0.005, 0.01, 0.02, 0.04, 0.08])
figure = go.Figure()
for speed in ("4530 rpm", "4730 rpm"):
    force = []
    for ratio in ratios:
        case = vt.load_case(
            "job-t",
            {
                "spring.damping": {"ratio": float(ratio), "ratio_frequency": "400 Hz"},
                "operation.cycles": 8,
            },
        )
        run = vt.simulate(case, speed, models=["modal-uniform"], workers=1).solutions[0]
        force.append(run.quantities["peak_spring_force"])
    print(
        f"{speed}: peak force {force[0]:.0f} N at 0.5 % of critical damping, {force[-1]:.0f} N at 8 %"
    )
    figure.add_scatter(x=100 * ratios, y=force, mode="lines+markers", name=speed)

# %%
# Largest spring force of the eighth turn of the cam.

figure.update_layout(title="Peak force over damping")
figure.update_xaxes(title="share of critical damping at 400 Hz (%)")
figure.update_yaxes(title="largest spring force (N)")
