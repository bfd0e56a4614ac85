"""Words of a form where a typed table has none: labels, and what a value means."""

from __future__ import annotations

#: Last word of a key -> label, where the key's own words are not those of the field.
LABELS = {
    "youngs_modulus": "Young's modulus", "poisson_ratio": "Poisson's ratio", "lift_of": "lift of", "zero_of_angle": "zero of the cam angle",
    "kind": "kind", "law": "contact law", "ends": "both ends",
}  # fmt: skip

#: Last word of a key -> what it means, where the table that reads it does not say.
HELP = {
    "title": "one line above results", "description": "what the case is, on top of its page",
    "wire_diameter": "diameter of the wire; over the coils where it changes", "mean_diameter": "diameter of the helix of the wire's axis",
    "outer_diameter": "over the coils, in place of the mean diameter", "pitch": "rise of the wire's axis per turn",
    "height": "height of the wire's axis over the coil number, in place of the pitch", "total_coils": "all turns, tip to tip",
    "material": "name of a wire, or a table of its moduli and density", "lower_end": "end at the cylinder head",
    "upper_end": "end at the retainer",
    "installed_height": "seat to retainer with the valve closed", "name": "word for the spring",
    "preload": "force with the valve closed", "rate": "force per compression", "open_load": "force at the open valve",
    "open_lift": "lift between the two loads", "engine_speeds": "speeds of the crank, twice those of the cam: '4200, 5600 rpm'",
    "cam_speeds": "speeds of the cam, in place of those of the crank", "kind": "which law or train",
    "maximum_lift": "largest lift", "opening_start": "where the lift begins", "opening_end": "where the largest lift is reached",
    "closing_start": "where it is left", "closing_end": "where the valve is closed", "cam_angles": "angles of the stations",
    "lifts": "lifts at the stations", "file": "table beside the case", "base_radius": "radius of the base circle",
    "pivot": "point the lever turns about, from the cam centre", "drive_arm": "pivot to the point that the cam or pushrod moves",
    "inertia": "moment of inertia about the pivot", "mass": "that moves", "stiffness": "force per way",
    "law": "how a contact presses", "radius": "of the crank", "rod_length": "of the connecting rod",
    "clearance": "piston to cylinder head at top dead centre", "top_dead_centre": "cam angle of it",
    "forces": "gas force on the valve head",
    "label": "word for the variant",
}  # fmt: skip
