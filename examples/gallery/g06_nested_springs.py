"""
What does each of two nested springs carry?
===========================================

The finger follower engine of the library has two springs, one inside the other. Each has its own
preload, its own rate and its own surge
frequency. Frequencies that differ keep the two from swinging up at the same engine speed.
"""

import numpy as np
import plotly.graph_objects as go

import valvetrain as vt

(run,) = vt.simulate("vaz-ohc", models=["multi-mass"], spring_sets=["nested"], workers=1).solutions

for spring in run.springs:
    print(
        f"{spring:5s} spring: first surge frequency {run.quantities[f'{spring}_surge_frequency']:.0f} Hz"
    )

# %%
# Channels of one spring of a pair carry its name in front.

figure = go.Figure()
for spring in run.springs:
    force = run.channel(run.channel_of(spring, "retainer_force"))
    figure.add_scatter(
        x=np.degrees(run.cam_angle - run.cam_angle[0]), y=force, name=f"{spring} spring"
    )
figure.update_layout(title="Force of two nested springs, 4136 rpm")
figure.update_xaxes(title="cam angle (deg)")
figure.update_yaxes(title="force on the retainer (N)")
