"""
A spring from nothing
=====================

Sizes with units make a spring; the keys are those of a case file. It is pressed, its natural
frequencies are found, and it runs under the lift of a library case.
"""

import valvetrain as vt

spring = vt.Spring(wire_diameter="4 mm", mean_diameter="24 mm", total_coils=7.5, pitch="7.6 mm",
                   material="EN 10270-2 VDSiCr", installed_height="42 mm")  # fmt: skip
curve = spring.static()
print(f"{curve.force_at('10 mm'):.0f} N at 10 mm, first mode {spring.frequencies()[0]:.0f} Hz")
run = spring.run("7000 rpm", vt.Case("job-t").tree["lift_law"], models="multi-mass")
print(f"seat force {run['seat_force'].min():.0f} to {run['seat_force'].max():.0f} N")

# %%
# The curve from the free state until coils close.

curve
