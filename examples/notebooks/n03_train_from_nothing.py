"""
A train from nothing
====================

A bucket tappet of five parts and two contact laws. Each part is the table of a case file, so
``case.save("mine.toml")`` writes the file that the command line runs.
"""

import valvetrain as vt

stiff = {"law": "linear", "contact_stiffness": "120 kN/mm", "damping": "600 N s/m"}
spring = vt.Spring(preload="280 N", rate="42 N/mm", mass="55 g", installed_height="36 mm")
train = vt.Train("direct", springs=spring, cam={"base_radius": "18 mm", "width": "14 mm"}, follower={"shape": "flat", "mass": "45 g"},
                 valve={"mass": "95 g"}, lash="0.1 mm", contacts={"cam": stiff, "valve_tip": stiff, "seat": stiff})  # fmt: skip
law = {"kind": "polynomial", "lift_of": "tappet", "exponents": "3-4-5", "maximum_lift": "8 mm", "opening_start": "100 deg",
       "opening_end": "180 deg", "closing_start": "180 deg", "closing_end": "260 deg"}  # fmt: skip
case = vt.Case(train=train, lift_law=law, name="mine")
run = case.run("5500 rpm", models="modal-uniform")

# %%
# Forces of the springs and the lift of the valve.

run
