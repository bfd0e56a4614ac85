"""
At which speed does the valve float, and what happens then?
===========================================================

Events of a pushrod train over engine speed: loss of contact at the cam, float, loft. Each has its
angle, its length and its
size.
"""

import numpy as np
import plotly.graph_objects as go

import valvetrain as vt

study = vt.sweep(
    "tdi-pushrod",
    "6000:8400:200 rpm",
    models=["massless"],
    spring_sets=["stock"],
    critical_speeds=False,
    workers=1,
)

figure = go.Figure()
for kind in ("loss-of-contact", "float", "loft"):
    speeds = [
        30 / np.pi * run.engine_speed
        for run in study.solutions
        for event in run.events
        if event.kind == kind
    ]
    angles = [
        np.degrees(event.cam_angle) % 360
        for run in study.solutions
        for event in run.events
        if event.kind == kind
    ]
    figure.add_scatter(x=speeds, y=angles, mode="markers", name=kind.replace("-", " "))
    print(f"{kind}: first seen at {min(speeds):.0f} rpm")

# %%
# Where in the turn of the cam each event begins.

figure.update_layout(title="Events of a pushrod train")
figure.update_xaxes(title="engine speed (rpm)")
figure.update_yaxes(title="cam angle (deg)")
