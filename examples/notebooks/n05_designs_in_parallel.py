"""
Two hundred designs in parallel
===============================

Only the outputs that are named are computed. Points go to two processes here; results do not depend on their number.
"""

import valvetrain as vt

varied = {"spring.wire_diameter": vt.Uniform("3.8 mm", "4.2 mm"), "spring.pitch": vt.Uniform("7 mm", "8 mm")}  # fmt: skip
runs = {"engine_speeds": "4000 rpm", "models": "modal-uniform"}
table = vt.Case("job-t").study(varied, "peak_spring_force", count=200, workers=2, **runs)
force = table.to_xarray()["peak_spring_force"]
print(f"{len(table)} designs, {float(force.min()):.0f} to {float(force.max()):.0f} N")

# %%
# The spread of the outputs. ``table.to_pandas()`` has a row per design.

table
