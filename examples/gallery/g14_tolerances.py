"""
Which tolerance makes the force scatter?
========================================

The wire and the installed height of a spring scatter. Sobol indices tell which of them makes the
largest force scatter: the total share of
a tolerance is the part of the variance that would go with it.
"""

import plotly.graph_objects as go

import valvetrain as vt

table = vt.study(
    """
title = "Tolerances of a spring"
case = "job-t"
engine_speeds = "3000 rpm"
spring_models = ["massless"]
outputs = ["peak_spring_force"]
points = { sampler = "saltelli", count = 32, seed = 1 }

[[vary]]
key = "spring.wire_diameter"
tolerance = "0.03 mm"
label = "wire diameter"

[[vary]]
key = "spring.precompression"
tolerance = "0.05 mm"
label = "installed compression"
""",
    workers=1,
)
(indices,) = table.sensitivities
print(table.verdict)

# %%
# Total shares with their 95 % intervals.

names = [one.shown_name for one in table.plan.varied]
figure = go.Figure(
    go.Bar(
        x=names, y=indices.total, error_y={"array": indices.total_interval[:, 1] - indices.total}
    )
)
figure.update_layout(title="What makes the peak force scatter", showlegend=False)
figure.update_xaxes(title="tolerance of")
figure.update_yaxes(title="share of the variance (1)")
