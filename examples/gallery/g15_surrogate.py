"""
What lies between the points that were run?
===========================================

A Gaussian process stands for the model after some runs of it. Its error is that of each point as the
others predict it. Here: the
largest force on the cam of a pushrod train over spring preload and valve mass.
"""

import numpy as np
import plotly.graph_objects as go

import valvetrain as vt

table = vt.study(
    """
kind = "surrogate"
title = "Force on the cam"
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
print(f"error {surrogate.error:.3g} N, {surrogate.share:.2g} of the scatter")

# %%
# The surrogate over the preload for three masses of the valve, 1 being the value of the case.

preload = np.linspace(0.9, 1.2, 61)
figure = go.Figure()
for mass in (0.8, 1.0, 1.2):
    force, _ = surrogate.predict(np.column_stack([preload, np.full_like(preload, mass)]))
    figure.add_scatter(x=preload, y=force, name=f"valve mass x {mass:g}")
figure.update_layout(title="Largest force on the cam at 5000 rpm")
figure.update_xaxes(title="spring preload over that of the case (1)")
figure.update_yaxes(title="largest force on the cam (N)")
