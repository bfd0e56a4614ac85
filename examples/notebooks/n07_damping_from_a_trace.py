"""
Fit damping to a trace
======================

A recorded force is a trace over the cam angle; here a run with a damping of 8 us and noise of 5 N stands for it. Scipy finds
the damping with which the model comes closest.
"""

import numpy as np
from scipy.optimize import minimize_scalar

import valvetrain as vt

case, key = vt.Case("job-t"), "spring.damping.stiffness_damping"
trace = lambda damping: case.set({key: damping}).run("6000 rpm", models="modal-uniform")
measured = trace(8e-6)["seat_force"].values + np.random.default_rng(1).normal(0, 5.0, 720)
misfit = lambda damping: float(np.std(trace(damping)["seat_force"].values - measured))
found = minimize_scalar(misfit, bounds=(1e-6, 3e-5), method="bounded", options={"xatol": 1e-7})
print(f"damping {1e6 * found.x:.2f} us, {found.fun:.1f} N left over")

# %%
# The trace of the found damping.

trace(found.x)
