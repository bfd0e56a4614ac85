"""
At which engine speeds does the spring resonate?
================================================

The lift holds harmonics of the cam speed. Where one of them meets the surge frequency the spring
swings up. The map shows the amplitude
of the seat force by frequency over engine speed: rays are harmonics of the lift, and they light up
where they cross the level line of the
surge frequency.
"""

import numpy as np
import plotly.graph_objects as go

import valvetrain as vt

case = vt.load_case("job-t", {"operation.cycles": 8})
study = vt.sweep(case, "3400:5000:100 rpm", models=["modal-uniform"], whole=True, workers=1)

# %%
# One turn of the cam is one period, so that line n of the spectrum is harmonic n of the cam.

speeds = np.array([run.engine_speed for run in study.solutions]) * 30 / np.pi
frequency = np.arange(0.0, 701.0, 5.0)
amplitudes = []
for run in study.solutions:
    force = run.channel("seat_force")[:-1]
    lines = 2 * np.abs(np.fft.rfft(force)) / len(force)
    place = np.arange(len(lines)) * run.engine_speed / (4 * np.pi)
    amplitudes.append(np.interp(frequency, place[1:], lines[1:]))
amplitudes = np.array(amplitudes)

surge = study.quantities["mode_1_frequency"]
near = np.abs(frequency - surge) < 30
worst = int(np.argmax(amplitudes[:, near].max(axis=1)))
order = round(frequency[near][np.argmax(amplitudes[worst, near])] / (speeds[worst] / 120))
print(
    f"most surge at {speeds[worst]:.0f} rpm: harmonic {order} of the cam is {order * speeds[worst] / 120:.0f} Hz there"
)
print(f"first surge frequency of the installed spring by the rod: {surge:.0f} Hz")

# %%
# Low frequencies hold the large first harmonics of the lift itself; the map leaves them out.

shown = frequency >= 250
figure = go.Figure(
    go.Heatmap(
        x=speeds, y=frequency[shown], z=amplitudes[:, shown].T, colorbar={"title": "amplitude (N)"}
    )
)
figure.update_layout(title="Seat force by frequency over engine speed")
figure.update_xaxes(title="engine speed (rpm)")
figure.update_yaxes(title="frequency (Hz)")
