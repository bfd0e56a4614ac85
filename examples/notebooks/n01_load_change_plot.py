"""
Load, change, run, plot
=======================

A case of the library is loaded, one value is changed by its key path, and the spring runs at one
engine speed. The case itself stays as it was.
"""

import valvetrain as vt

case = vt.Case("job-t").set({"spring.wire_diameter": "3.9 mm"})
run = case.run("6000 rpm", models="modal-uniform")
force = run["seat_force"]
print(f"seat force {float(force.min()):.0f} to {float(force.max()):.0f} {force.units}")

# %%
# A result shows its numbers and its first figure. ``run.plot()`` gives the figure by plotly,
# ``force.plot()`` one channel by matplotlib.

run
