"""
Is the model as good as the test can tell?
==========================================

Fisher's test asks whether the difference between model and test is larger than the scatter of the
test explains. The measured cycles
here are a model with a little more damping and drawn scatter: the answer is known.
"""

import numpy as np
import plotly.graph_objects as go

import valvetrain as vt

angle = np.linspace(0.0, 2 * np.pi, 360, endpoint=False)
case = vt.load_case("job-t", {"spring.damping.stiffness_damping": "1.2e-5 s"})
truth = vt.simulate(case, "3000 rpm", models=["multi-mass"], workers=1).solutions[0]
force = np.interp(angle + truth.cam_angle[0], truth.cam_angle, truth.channel("seat_force"))
drawn = force + np.random.default_rng(1).normal(0.0, 5.0, (8, 360))
test = vt.measured.MeasuredCycles(
    "spring_force", "N", angle, drawn, cam_speed=truth.engine_speed / 2, synthetic=True
)

found = vt.compare_test.compare_with_test(
    "job-t", test, models=["multi-mass", "massless"], workers=1
)
for run in found.runs:
    print(f"{run.label}: F = {run.adequacy.ratio:.3g}, {run.adequacy.critical:.3g} allowed")

# %%
# The difference from the mean of the cycles.

figure = go.Figure()
for run in found.runs:
    figure.add_scatter(x=np.degrees(angle), y=run.curve - test.mean, name=run.label)
figure.update_layout(title="Model less test")
figure.update_xaxes(title="cam angle (deg)")
figure.update_yaxes(title="difference of force (N)")
