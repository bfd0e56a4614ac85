"""
Which rate and which moving mass does a spring have?
====================================================

A load at the installed height tells the rate, the ringing of the struck spring tells rate over
mass. Together they tell both, and the
intervals say how well.
"""

import plotly.graph_objects as go

import valvetrain as vt


def spring(points):
    """Load at 7 mm of compression (N) and first surge frequency (Hz) for rates (N/m) and active
    masses (kg).
    """
    return [{"load": 7e-3 * rate, "surge": 0.5 * (rate / mass) ** 0.5} for rate, mass in points]


priors = {
    "rate": vt.explore.Prior("uniform", 20e3, 60e3),
    "mass": vt.explore.Prior("normal", centre=0.05, spread=0.01),
}
found = vt.identify(
    priors, [vt.explore.Datum("load", 280.0, 4.0), vt.explore.Datum("surge", 447.0, 5.0)], spring
)

print(f"rate {1e-3 * found.best['rate']:.1f} N/mm, mass {1e3 * found.best['mass']:.1f} g")

# %%
# Each dot is a pair that the measurements allow: a stiffer spring must be heavier to ring as it
# does.

figure = go.Figure(
    go.Scatter(
        x=1e-3 * found.values[:, 0], y=1e3 * found.values[:, 1], mode="markers", name="draws"
    )
)
figure.update_layout(title="What two measurements leave open", showlegend=False)
figure.update_xaxes(title="rate (N/mm)")
figure.update_yaxes(title="active mass (g)")
