"""
An own lift law and an own spring in one script
===============================================

The lift is a function of the cam angle in radians and gives metres. It becomes a table of the case, so the case has a file, runs
in workers and is compared by several models.
"""

import numpy as np

import valvetrain as vt

lift = lambda cam_angle: 10e-3 * max(0.0, 1 - ((cam_angle - np.pi) / 1.1) ** 2) ** 4
spring = vt.Spring(wire_diameter="4 mm", mean_diameter="24 mm", total_coils=7.5, pitch="7.6 mm",
                   material="EN 10270-2 VDSiCr", installed_height="42 mm")  # fmt: skip
case = vt.Case(spring=spring, lift_law=lift, name="own")
both = case.compare("6000 rpm", ["massless", "modal-uniform"])
for run in both.solutions:
    print(f"{run.label:13s} {run.quantities['peak_spring_force']:.0f} N")

# %%
# Both models over the cam angle: the difference is surge.

both
