"""
What lies between the points that were run?
===========================================

A Gaussian process stands for the model after some runs of it. Its error is told on points that were kept out of the fit. Here: the
seating velocity of a pushrod train over spring preload and valve mass.
"""

import numpy as np
import plotly.graph_objects as go

import valvetrain as vt

table = vt.study(
    """
kind = "surrogate"
title = "Landing of the valve"
case = "tdi-pushrod"
engine_speeds = "5000 rpm"
spring_models = ["massless"]
spring_sets = ["stock"]
outputs = ["peak_cam_contact_force"]
points = { sampler = "sobol", count = 16 }

[[vary]]
key = "train.springs.stock.0.preload"
as = "factor"
low = 0.9
high = 1.2
label = "spring preload"

[[vary]]
key = "train.valve.mass"
as = "factor"
low = 0.8
high = 1.2
label = "valve mass"
""",
    workers=1,
)
surrogate = table.surrogates[0]
print(surrogate.sentence)

# %%
# The surrogate over both quantities, 1 being the value of the case.

preload, mass = np.linspace(0.9, 1.2, 25), np.linspace(0.8, 1.2, 25)
points = np.array([(one, other) for other in mass for one in preload])
force, _ = surrogate.predict(points)

figure = go.Figure(go.Heatmap(x=preload, y=mass, z=force.reshape(25, 25), colorbar={"title": "largest cam force (N)"}))
figure.update_layout(title="Largest force on the cam at 5000 rpm")
figure.update_xaxes(title="spring preload over that of the case (1)")
figure.update_yaxes(title="valve mass over that of the case (1)")
