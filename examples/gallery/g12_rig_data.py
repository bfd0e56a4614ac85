"""
What did the rig measure, cycle by cycle?
=========================================

A logger writes force over time. Cut into turns of the cam and laid over the cam angle, the cycles
can be compared with each other: their
mean is what a model may be held against, their scatter is how well it can be known. The recording
is made up.
"""

import tempfile
from pathlib import Path

import numpy as np
import plotly.graph_objects as go

import valvetrain as vt

time = np.arange(0, 0.52, 1e-4)
turn = 25 * time + 0.003 * np.sin(2 * np.pi * 25 * time)
force = 500 + 200 * np.cos(2 * np.pi * turn) + 15 * np.sin(2 * np.pi * 11 * turn)
force += np.random.default_rng(2).normal(0, 6, len(time))

with tempfile.TemporaryDirectory() as folder:
    file = Path(folder, "recording.txt")
    rows = [
        f"{one:.4f}; {360 * (place % 1):.3f}; {load:.2f}"
        for one, place, load in zip(time, turn, force, strict=True)
    ]
    file.write_text("\n".join(["time [s]; cam angle [deg]; spring force [N]", *rows]))
    found = vt.rig.rig_cycles(file, vt.rig.RigAnswers(angle_of="cam", band="2 kHz"))

cycles = found.cycles[0]
scatter = cycles.values.std(axis=0, ddof=1)
print(
    f"{len(cycles.values)} cycles, mean peak {cycles.mean.max():.0f} N, scatter of a cycle {scatter.mean():.1f} N"
)

# %%
# All cycles lie over each other; the dark line is their mean.

angle = np.degrees(cycles.cam_angle)
figure = go.Figure()
for number, values in enumerate(cycles.values):
    figure.add_scatter(
        x=angle,
        y=values,
        line={"color": "#a9cbe6", "width": 0.8},
        name="cycles",
        showlegend=number == 0,
    )
figure.add_scatter(x=angle, y=cycles.mean, line={"color": "#12294f"}, name="mean")
figure.update_layout(title="Spring force of a rig over the cam angle")
figure.update_xaxes(title="cam angle (deg)")
figure.update_yaxes(title="spring force (N)")
