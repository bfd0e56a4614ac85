"""
Internals: coils, contacts, modes
=================================

Every run keeps what happened inside the spring: where its coils were, how they touched, and the modes behind it.
"""

import valvetrain as vt

case = vt.Case("job-c")
run = case.run("6000 rpm", models="multi-mass")
moved, touched = run["axial_displacement"], run["coil_contact_force"]
middle = 1e3 * moved.isel(coil_number=moved.sizes["coil_number"] // 2)
print(f"the middle of the wire moves {float(middle.min()):.2f} to {float(middle.max()):.2f} mm")
print(f"coils press with up to {float(touched.max()):.0f} N")
modes = vt.springs.FiniteElementRod(case.parameters.springs[0].wire, "7 mm").modes(12)

# %%
# The axial modes of the wire.

modes
