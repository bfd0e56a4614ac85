"""
What is the least spring load that keeps the cam in contact?
============================================================

A stronger spring keeps the train together and wears the cam. The search lowers the load of the open
spring as long as the spring force
stays 1.2 times what the slowed train needs.
"""

import numpy as np
import plotly.graph_objects as go

import valvetrain as vt

found = vt.optimise(
    """
case = "tdi-pushrod"
engine_speeds = "6500 rpm"
spring_models = ["massless"]
spring_sets = ["stock"]
objective = [{ quantity = "card_open_force", direction = "minimise" }]
constraint = [{ quantity = "minimum_spring_margin_ratio", at_least = 1.2 }, { quantity = "card_rate", at_least = "10 N/mm" }]
search = { trials = 30, seed = 1 }

[[vary]]
key = "train.springs.stock.0.preload"
low = "120 N"
high = "200 N"

[[vary]]
key = "train.springs.stock.0.open_load"
low = "250 N"
high = "600 N"
""",
    workers=1,
)
best = found.best.trial
print(
    f"least open load {best.objectives[0]:.0f} N with {best.values[0]:.0f} N of preload; the case has {found.case.objectives[0]:.0f} N"
)

# %%
# All trials: open load over preload.

inputs = np.array([trial.values for trial in found.trials])
figure = go.Figure(go.Scatter(x=inputs[:, 0], y=inputs[:, 1], mode="markers", name="trials"))
figure.add_scatter(
    x=[best.values[0]],
    y=[best.values[1]],
    mode="markers",
    name="best",
    marker={"color": "#a33b53", "symbol": "diamond", "size": 12},
)
figure.update_layout(title="Trials of the search")
figure.update_xaxes(title="preload (N)")
figure.update_yaxes(title="open load (N)")
