"""
How stiff is a spring, and where do its coils close?
====================================================

A spring with a progressive pitch is soft first: the narrow coils close one after the other, and each closed coil leaves a stiffer spring.
"""

import valvetrain as vt

spring = vt.cylindrical("3.8 mm", "22 mm", "7 mm", total_coils=7)
curve = vt.static_curve(spring, "14 mm", spring_model="multi-mass")
print(f"{curve.force_at('10 mm'):.0f} N at 10 mm, rate {1e-3 * curve.stiffness_at('10 mm'):.1f} N/mm")

figure = curve.plot()
