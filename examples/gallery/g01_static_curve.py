"""
How stiff is a spring, and where do its coils close?
====================================================

A spring of uneven pitch grows stiffer as it is compressed: its narrow coils close first, and a
closed coil no longer gives. The curve is
that of the beehive spring that ships with the package, by the chain of masses, from the free length
to a little beyond the largest lift.
"""

import valvetrain as vt

case = vt.load_case("gu2021-beehive-blind")
curve = vt.static_curve(case, models="multi-mass")

first, last = 1e-3 * curve.stiffness_at("9 mm"), 1e-3 * curve.stiffness_at("16 mm")
print(f"rate {first:.1f} N/mm at 9 mm of compression, {last:.1f} N/mm at 16 mm")

# %%
# Every result draws itself. The steps in the lower curve are coils that close.

figure = curve.plot()
