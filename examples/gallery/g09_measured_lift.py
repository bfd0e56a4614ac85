"""
What is the acceleration behind a measured lift?
================================================

Second differences of a measured lift are mostly noise. The smoothing keeps the lift within the
noise of the stations, finds that noise
itself, and says how firm the acceleration is. Here the lift is made up, so that the truth is known.
"""

import numpy as np
import plotly.graph_objects as go

import valvetrain as vt

angle = np.radians(np.arange(90.0, 271.0))
share = np.clip(1 - ((angle - np.pi) / np.radians(60)) ** 2, 0, None)
measured = 9e-3 * share**3 + np.random.default_rng(1).normal(0, 3e-6, len(angle))

lift = vt.measured.smooth_lift(angle, measured)
print(f"noise of a station {1e6 * lift.noise:.1f} um (3.0 um were drawn)")
print(
    f"peak lift {1e3 * lift.lift(np.pi):.3f} mm, nose acceleration {1e3 * lift.lift(np.pi, 2):.1f} mm/rad2"
)

# %%
# The dots are second differences of the stations, as a spreadsheet makes them.

step = angle[1] - angle[0]
differences = np.diff(measured, 2) / step**2
fine = np.linspace(angle[0], angle[-1], 721)
figure = go.Figure()
figure.add_scatter(
    x=np.degrees(angle[1:-1]),
    y=1e3 * differences,
    mode="markers",
    name="second differences",
    marker={"color": "#7b8794"},
)
figure.add_scatter(
    x=np.degrees(fine), y=1e3 * lift.lift(fine, 2), name="smoothed", line={"color": "#1f5aa6"}
)
figure.update_layout(title="Acceleration of a measured lift")
figure.update_xaxes(title="cam angle (deg)")
figure.update_yaxes(title="acceleration (mm/rad2)")
