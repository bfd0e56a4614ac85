"""
Which coils clash, when, and how hard?
======================================

A map of the force between neighbouring coils over the cam angle. Long bright rows are coils that
lie closed; short bright marks are
clashes. The events of the run list each clash with its place, its largest force and its impulse.
"""

import numpy as np
import plotly.graph_objects as go

import valvetrain as vt

run = vt.simulate("gu2021-beehive-blind", "8000 rpm", models=["multi-mass"], workers=1).solution(
    "multi-mass"
)

clashes = [event for event in run.events if event.kind == "clash"]
worst = max(clashes, key=lambda event: event.details["impulse"])
print(
    f"{len(clashes)} clashes; largest impulse {1e3 * worst.details['impulse']:.1f} N ms, {worst.where}"
)

# %%
# Channels are labelled arrays: the pairs of coils stand in a coordinate.

force = run.channels["coil_contact_force"]
coils = force.coords["upper_coil"].values
angle = np.degrees(run.cam_angle)
angle = angle - 360 * np.floor(angle[0] / 360)

figure = go.Figure(
    go.Heatmap(x=angle, y=coils, z=force.values.T, colorbar={"title": "force between coils (N)"})
)
figure.update_layout(title="Forces between coils at 8000 rpm")
figure.update_xaxes(title="cam angle (deg)")
figure.update_yaxes(title="coil number")
