"""
How much of a force spike does a gauge see?
===========================================

Clashing coils make spikes shorter than a millisecond. A gauge with a low-pass of 1 kHz records them
late and too small. A model must be
looked at through the same gauge before the two are compared.
"""

import numpy as np
import plotly.graph_objects as go

import valvetrain as vt

run = vt.simulate("gu2021-beehive-blind", "8000 rpm", models=["multi-mass"], workers=1).solution(
    "multi-mass"
)
force, time = run.channel("seat_force"), run.time
recorded = vt.measured.Sensor(bandwidth="1 kHz").response(time, force)

turn = (time - time[0]) / (time[-1] - time[0]) * 360
spikes = slice(*np.searchsorted(turn, [230, 360]))
print(
    f"largest spike after closing {force[spikes].max():.0f} N, recorded {recorded[spikes].max():.0f} N"
)

# %%
# The true force and the recorded one over the turn.

figure = go.Figure()
figure.add_scatter(x=turn, y=force, name="true", line={"color": "#a9cbe6"})
figure.add_scatter(x=turn, y=recorded, name="by a gauge of 1 kHz", line={"color": "#a33b53"})
figure.update_layout(title="Seat force of the beehive spring at 8000 rpm")
figure.update_xaxes(title="cam angle from the begin of the cycle (deg)")
figure.update_yaxes(title="seat force (N)")
