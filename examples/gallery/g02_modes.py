"""
At which frequencies does a spring surge?
=========================================

Coils that swing along the spring while both ends stand still: that is surge. A uniform spring of
rate k and active mass m does so first at
sqrt(k / m) / 2. The rod finds the modes of the real wire, whatever its shape.
"""

import math

import valvetrain as vt

spring = vt.parameters.SpringDefinition(
    wire_diameter="4 mm",
    mean_diameter="24 mm",
    pitch="7.5 mm",
    total_coils=6,
    material="OTEVA 90 SC",
    ends="open",
    name="textbook spring",
)
rod = vt.springs.FiniteElementRod(spring, "7 mm", elements_per_coil=12)
modes = rod.modes(12)

wire = spring.material
rate = wire.shear_modulus * 4e-3**4 / (8 * 24e-3**3 * 6)
mass = wire.density * math.pi * 4e-3**2 / 4 * math.pi * 24e-3 * 6
print(
    f"first surge frequency: rod {modes.axial_frequencies[0]:.0f} Hz, formula of the uniform spring {math.sqrt(rate / mass) / 2:.0f} Hz"
)

# %%
# The axial modes over the coils. Their frequencies are close to multiples of the first.

figure = modes.plot()
