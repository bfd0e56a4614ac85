"""
How do direct, finger, rocker and pushrod trains differ?
========================================================

The four templates of ``valvetrain new``, each run as it stands at 5000 rpm. The more parts stand
between cam and valve, the more they
bend: the valve lags behind the lift that rigid parts would give it.
"""

from importlib import resources

import numpy as np
import plotly.graph_objects as go

import valvetrain as vt

figure = go.Figure()
for kind in ("direct", "finger", "rocker", "pushrod"):
    case = vt.load_case(resources.files("valvetrain").joinpath("templates", f"{kind}.toml"))
    run = vt.simulate(case, "5000 rpm", models=["modal-uniform"], workers=1).solutions[0]
    difference = run.channel("valve_lift") - run.channel("rigid_valve_lift")
    angle = np.degrees(run.cam_angle - run.cam_angle[0])
    figure.add_scatter(x=angle, y=1e3 * difference, name=kind)
    print(
        f"{kind:8s} valve lags by up to {-1e3 * difference.min():.3f} mm, lands at {run.quantities['seating_velocity']:.2f} m/s"
    )

# %%
# The difference from the lift of rigid parts.

figure.update_layout(title="Valve lift less lift of rigid parts, 5000 rpm")
figure.update_xaxes(title="cam angle (deg)")
figure.update_yaxes(title="difference of lift (mm)")
