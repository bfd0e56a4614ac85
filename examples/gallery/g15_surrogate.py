"""
What lies between the points that were run?
===========================================

A Gaussian process of scikit-learn stands for the model after some runs of it. Its error is that of points which it
has not seen. Here: the
largest force on the cam of a pushrod train over spring preload and valve mass.
"""

import numpy as np
import plotly.graph_objects as go
from sklearn.gaussian_process import GaussianProcessRegressor
from sklearn.gaussian_process.kernels import RBF
from sklearn.model_selection import cross_val_predict
from sklearn.pipeline import make_pipeline
from sklearn.preprocessing import StandardScaler

import valvetrain as vt

table = vt.study(
    """
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
force = table.column("peak_cam_contact_force")
process = GaussianProcessRegressor(RBF([1.0, 1.0]), normalize_y=True)
surrogate = make_pipeline(StandardScaler(), process)
missed = cross_val_predict(surrogate, table.inputs, force, cv=8) - force
print(f"error below {0.01 if np.std(missed) < 0.01 * np.std(force) else 1:g} of the scatter")
surrogate.fit(table.inputs, force)

# %%
# The surrogate over the preload for three masses of the valve, 1 being the value of the case.

preload = np.linspace(0.9, 1.2, 61)
figure = go.Figure()
for mass in (0.8, 1.0, 1.2):
    between = surrogate.predict(np.column_stack([preload, np.full_like(preload, mass)]))
    figure.add_scatter(x=preload, y=between, name=f"valve mass x {mass:g}")
figure.update_layout(title="Largest force on the cam at 5000 rpm")
figure.update_xaxes(title="spring preload over that of the case (1)")
figure.update_yaxes(title="largest force on the cam (N)")
