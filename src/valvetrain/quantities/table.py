"""The table of quantities: name, label, definition, unit, systems, topic and uses of every number
that no single published study owns.

Terminal, JSON, page, workbench and docs/quantities.md read it: a new quantity is one row here and
the function that computes it. Names are templates where they hold a place, a number or a spring
(see :class:`valvetrain.solution.definition.QuantityRow`).
"""

from __future__ import annotations

from functools import partial

from valvetrain.measured import cam_events
from valvetrain.solution.definition import TOPICS, QuantityRow, Sense, Systems, Use, row

TRAIN: Systems = ("train",)
#: A row of springs under prescribed motion, of trains, or of both.
spring, train, both = (
    partial(row, systems=systems) for systems in (("spring",), TRAIN, ("spring", "train"))
)
MORE: Sense = "larger is better"
LESS: Sense = "smaller is better"
FORCE, SURGE, CLASH, CONTACT, SCATTERING, CONTROL, STRESS = TOPICS
#: Shown wherever a number of a run is.
ALL: tuple[Use, ...] = ("brief", "sweep", "curve", "study")


def of_each(name: str) -> tuple[str, ...]:
    """``name`` and its names for the springs of a nested pair."""
    return name, f"outer_{name}", f"inner_{name}"


def with_angle(quantity: QuantityRow) -> tuple[QuantityRow, QuantityRow]:
    """A row and that of the cam angle of its value."""
    return quantity, row(
        f"{quantity.name}_cam_angle",
        f"{quantity.label}, cam angle",
        f"Cam angle of the {quantity.label}.",
        systems=quantity.systems,
    )


#: Of a spring and its place before anything runs.
AT_REST: tuple[QuantityRow, ...] = (
    both("preload", "preload", "Static force at the installed precompression; in a train of all its springs, valve closed."),
    both("installed_rate", "installed rate", "Slope of the static curve at the installed precompression."),
    both("installed_nominal_shear_stress", "installed nominal shear stress",
        "Shear by EN 13906-1 under the preload, k 8 F D / (pi d^3) with k = (w + 0.5) / (w - 0.75), at the worst place of the "
        "wire."),
    both("installed_shear_stress", "installed shear stress",
        "Largest shear at the inner fibre along the wire under the preload, from its section loads."),
    both("installed_equivalent_stress", "installed equivalent stress",
        "Largest von Mises stress at the inner fibre along the wire under the preload."),
    both("installed_retainer_torque", "installed torque on the retainer",
        "Torque of the wire on the retainer about the axis, positive the way the wire rises; none where the retainer may turn."),
    both("installed_retainer_moment", "installed moment on the retainer",
        "Moment of the wire on the retainer across the axis, about the middle of its plane.", dimension="moment", shown_unit="N m"),
    both("installed_retainer_side_force", "installed side force on the retainer",
        "Force of the wire on the retainer across the axis."),
    both("installed_retainer_rotation_angle", "installed rotation of the retainer",
        "Angle by which a retainer that may turn has turned from the free state, positive the way the wire rises."),
    both("solid_force", "force at solid",
        "Force that closes the last coil, by torsion of the wire; rate times compression to solid of a cylindrical spring of even "
        "pitch."),
    both("solid_nominal_shear_stress", "nominal shear stress at solid",
        "Largest shear by EN 13906-1 along the wire with all coils closed, each turn under the force that closes it."),
    both("moving_retainer_mode_{n}_frequency", "mode {n} frequency, retainer moving",
        "Axial natural frequency {n} about the installed state, the retainer free along the axis with the mass attached to it."),
    both("installed_compression", "installed compression", "Compression from the free length to the installed height."),
    both("installed_height", "installed height", "Free length less the installed compression."),
    both("stiffness_change_compression", "compression at the change of stiffness",
        "Compression at which the stiffness of the static curve first changes."),
    both("coil_{m}_{n}_installed_gap", "installed gap of coils {m} and {n}",
        "Smallest gap between coils {m} and {n} at the installed precompression."),
    both("coil_bind_lift", "lift at coil bind", "Lift at which the coils of the installed spring are solid.", sense=MORE),
    both("buckling_compression", "compression at which it buckles",
        "Compression at which the spring buckles by the finite-element rod: its rate falls below half of that as wound, or its "
        "tangent loses a sign.", sense=MORE),
    both("buckling_height", "height at which it buckles", "Free length less the compression at which the spring buckles."),
    both("buckling_clearance", "clearance to buckling",
        "Compression left until the spring buckles at the largest lift; negative where it buckles at work.", sense=MORE),
    both("formula_buckling_compression", "compression at which it buckles, by formula",
        "Compression at which a cylindrical spring between parallel seats buckles by EN 13906-1 (Haringx).", sense=MORE),
    both("guide_contact_compression", "compression at which it meets its guide",
        "Compression at which the wire first touches the bore or rod that guides it, at rest."),
    both("guide_force", "force on its guide",
        "Sum of the normal forces between wire and guide at the end of the static curve, a little beyond the largest lift.",
        sense=LESS),
    both("surge_frequency", "surge frequency",
        "First axial natural frequency of the installed spring, both ends fixed.", topic=SURGE,
        uses=("sweep", "study", "case"), answered_as=of_each("surge_frequency")),
    both("mode_{n}_frequency", "mode {n} frequency",
        "Axial natural frequency {n} about the installed state, both ends fixed (found by force transmission)."),
    both("natural_{n}_frequency", "natural frequency {n}", "Natural frequency {n} in rising order, whatever its direction."),
    both("total_coil_count", "coils in all", "Turns of wire."),
    both("active_coil_count", "active coils", "Turns between the inactive ends that are not closed on a neighbour."),
    both("free_length", "free length", "Length between the seat planes unloaded."),
    both("solid_height", "solid height",
        "Length between the seat planes at coil bind: as stated, else under the force that closes the last coil, by the wire as a ring "
        "beam with end turns that keep their shape and coils that touch."),
    both("computed_solid_height", "solid height by the wire", "Solid height by the wire, where a card states another."),
    both("solid_compression", "compression to solid", "Free length less the solid height."),
    both("largest_pitch", "largest pitch",
        "Largest rise of the wire's axis per turn: of a spring given by its free length, the pitch between its ends.",
        dimension="length", shown_unit="mm"),
    both("wire_length", "wire length", "Length of the whole wire, tip to tip, the ground-off part included."),
    both("wire_mass", "wire mass", "Mass of the whole wire, tip to tip, the ground-off part included."),
    both("smallest_index_ratio", "smallest spring index", "Smallest mean coil diameter over wire diameter along the wire."),
    both("largest_index_ratio", "largest spring index", "Largest mean coil diameter over wire diameter along the wire."),
    both("largest_outer_diameter", "largest outer diameter", "Largest outer diameter of the coils, unloaded."),
    both("smallest_inner_diameter", "smallest inner diameter", "Smallest inner diameter of the coils, unloaded."),
    both("estimated_rate", "estimated rate",
        "Rate of the free state by torsion alone, 1/k = integral of 8 D^3 / (G d^4) over the active turns; G d^4 / (8 D^3 n) for a "
        "cylindrical spring."),
    both("estimated_surge_frequency", "estimated surge frequency",
        "0.5 sqrt(k / m) of the estimated rate and the mass of the active turns, both ends fixed."),
    both("surge_half_duration", "time in which surge halves",
        "Time in which free surge falls to half its height by the damping of the spring, without that of rubbing springs."),
    both("card_rate", "rate of the card", "Rate as the spring card has it."),
    both("card_preload", "preload of the card", "Preload as the spring card has it."),
    both("card_mass", "mass of the card", "Mass as the spring card has it."),
    both("card_installed_height", "installed height of the card", "Installed height as the spring card has it."),
    both("card_open_force", "open force of the card", "Force at the open lift as the spring card has it."),
    both("card_open_lift", "open lift of the card", "Lift at which the card's open force is given."),
    both("card_solid_height", "solid height of the card", "Solid height as the spring card has it."),
    both("card_surge_frequency", "surge frequency of the card", "0.5 sqrt(k / m) of the card's rate and mass, both ends fixed."),
    both("maximum_lift", "largest lift of the law", "Largest value of the lift law."),
    both("maximum_lift_cam_angle", "largest lift of the law, cam angle", "Cam angle of the largest value of the lift law."),
    train("rigid_maximum_valve_lift", "largest rigid valve lift", "Largest valve lift of rigid parts with all contacts closed."),
)  # fmt: skip

#: Rows of a lift law's derivatives by the cam angle.
_slope = partial(both, dimension="cam velocity", shown_unit="mm/deg")
_bend = partial(both, dimension="cam acceleration", shown_unit="um/deg^2")
#: Of the cam, by its lift law and its contour, before anything runs.
CAM: tuple[QuantityRow, ...] = (
    both("cam_ramp_lift", "ramp of the lift law, height", "Lift at which the ramps of the lift law end."),
    _slope("cam_opening_ramp_velocity", "ramp velocity, opening",
        "Velocity of the lift law per cam angle where its opening ramp ends; of a law without ramps where the lash is taken up."),
    _slope("cam_closing_ramp_velocity", "ramp velocity, closing",
        "Velocity of the lift law per cam angle, downwards, where its closing ramp begins; of a law without ramps where the lash opens."),
    _slope("cam_opening_velocity", "largest velocity of the lift law, opening", "Largest velocity of the lift law per cam angle."),
    _slope("cam_closing_velocity", "largest velocity of the lift law, closing", "Largest downward velocity of the lift law per cam angle."),
    _bend("cam_largest_acceleration", "largest acceleration of the lift law", "Largest acceleration of the lift law per cam angle squared."),
    _bend("cam_smallest_acceleration", "smallest acceleration of the lift law",
        "Smallest acceleration of the lift law per cam angle squared, over the nose, negative."),
    train("cam_contact_offset", "contact from the cam's centre",
        "Largest distance of the contact on a flat face from the cam's centre along the face: the velocity of its lift per radian.",
        dimension="length", shown_unit="mm"),
    train("cam_contact_face_radius", "contact from the follower's axis",
        "Largest distance of the contact on the flat face of a sliding follower from its axis: the least radius of its face.",
        dimension="length", shown_unit="mm"),
    train("cam_least_radius", "least radius of curvature of the cam", "Least radius of curvature of the convex cam, mostly at the nose.",
        dimension="length", shown_unit="mm"),
    train("cam_hollow_radius", "least radius of the hollow flank",
        "Least radius of curvature of the cam's concave flanks: a grinding wheel must be smaller. None of a convex cam.",
        dimension="length", shown_unit="mm"),
)  # fmt: skip

#: Of a run, in both systems.
RUNS: tuple[QuantityRow, ...] = (
    *with_angle(both("peak_spring_force", "peak spring force below 10 kHz",
        "Largest force of all springs on the cylinder head over the reported cycle after a zero-phase low pass, 6 dB down at the "
        "cut-off: 10 kHz, or what [operation] force_bandwidth says. A load cell under the spring shows it; nothing that nobody "
        "knows decides it, as contact constants decide the raw peak.", sense=LESS, topic=FORCE, uses=ALL)),
    *with_angle(both("raw_peak_spring_force", "raw peak spring force",
        "Largest force of all springs on the cylinder head at any instant of the reported cycle. Where coils clash it lasts some "
        "microseconds and rests on contact constants and mesh.", sense=LESS)),
    both("raw_peak_spring_force_duration", "raw peak spring force, duration",
        "Impulse of the raw peak above the force below the cut-off over its height above it: how long it lasts. Absent where it is "
        "less than 1 % higher.", shown_unit="us"),
    *with_angle(both("minimum_spring_force", "minimum spring force",
        "Smallest force of all springs on the cylinder head over the reported cycle.", sense=MORE, topic=FORCE, uses=ALL)),
    both("peak_retainer_force", "peak retainer force below 10 kHz",
        "Largest force of all springs on the retainer over the reported cycle below the cut-off of the peak spring force.",
        sense=LESS, topic=FORCE, uses=("curve", "study")),
    both("raw_peak_retainer_force", "raw peak retainer force",
        "Largest force of all springs on the retainer at any instant of the reported cycle.", sense=LESS),
    both("raw_peak_retainer_force_duration", "raw peak retainer force, duration",
        "How long the raw peak retainer force lasts, as that of the raw peak spring force.", shown_unit="us"),
    both("minimum_retainer_force", "minimum retainer force",
        "Smallest force of all springs on the retainer over the reported cycle.", sense=MORE, topic=FORCE, uses=("curve", "study")),
    both("coil_bind_clearance", "clearance to coil bind",
        "Length left until the coils are solid at the largest lift.", sense=MORE, topic=FORCE, uses=("sweep", "study", "case"),
        answered_as=of_each("coil_bind_clearance")),
    both("wound_least_clearance", "clearance to coil bind by wire and turns, least",
        "Length left at the largest lift until as many wires as turns lie on each other, of a card without a solid height.",
        sense=MORE, answered_as=of_each("wound_least_clearance")),
    both("wound_most_clearance", "clearance to coil bind by wire and turns, most",
        "The same with one wire less, as of ends ground to nothing.", sense=MORE, answered_as=of_each("wound_most_clearance")),
    both("peak_valve_lift", "peak valve lift", "Largest valve lift over the reported cycle."),
    both("peak_valve_acceleration", "peak valve acceleration",
        "Acceleration of the valve of largest size over the reported cycle."),
    both("surge_cam_order", "surge order", "Surge frequency over cam frequency.", topic=SURGE, uses=("study", "one speed")),
    both("nearest_lift_harmonic_order", "nearest lift harmonic",
        "Cam order of the lift's harmonic nearest to the surge frequency.", topic=SURGE, uses=("study", "one speed", "page")),
    both("nearest_lift_harmonic_lift", "nearest lift harmonic, amplitude",
        "Amplitude (0 to peak) of the lift's harmonic nearest to the surge frequency.", sense=LESS, shown_unit="um", topic=SURGE,
        uses=("study", "one speed", "page")),
    both("lift_harmonic_{n}_lift", "cam order {n} of the lift", "Amplitude (0 to peak) of cam order {n} of the lift of the spring.",
        sense=LESS, shown_unit="um"),
    both("surge_amplitude_force", "surge amplitude",
        "Largest amplitude (0 to peak), among the cam orders from half to one and a half times the surge order, of the spring "
        "force less its static value at the same lift. What surge takes off the force where contact opens is that of all orders at one cam "
        "angle, and need not be equal to it.", sense=LESS, topic=SURGE, uses=ALL, remark="0 to peak"),
    both("surge_amplitude_cam_order", "cam order of the surge amplitude",
        "Cam order whose amplitude is the surge amplitude; times the cam frequency it is the frequency at which the spring swings, "
        "which differs from that at rest where coils close or part. Absent of a surge "
        "below 0.2 % of the largest force.", topic=SURGE, uses=("study", "one speed")),
    train("surge_order_{n}_engine_speed", "surge at cam order {n}, engine speed",
        "Engine speed at which cam order {n} of the lift meets the surge frequency, among those run and a quarter beyond."),
    both("surge_order_{n}_force", "surge at cam order {n}",
        "Amplitude (0 to peak) of cam order {n} of the spring force less its static value at the same lift.", sense=LESS),
    both("clash_count", "coil contacts",
        "Times that coils meet over the reported cycle, clashes and coils that come to rest on each other as the spring closes, found on "
        "the integrator's own steps; pairs that always touch are left out, and one that parts for less than 1/200 of the first "
        "natural period of the spring (10 us at 500 Hz) only rings.",
        sense=LESS, topic=CLASH, uses=("brief", "sweep", "study")),
    both("peak_clash_force", "peak clash force",
        "Largest force between coils in a clash, of all places that it presses at one time.", sense=LESS),
    both("surge_clash_peak_force", "hardest clash under surge",
        "Largest force between coils in a clash under surge: coils that come to rest on each other as the spring closes are left out.",
        sense=LESS),
    both("clash_energy", "clash energy",
        "Sum over the clashes of the largest energy stored at one time in the contacts that a clash presses: integral of the "
        "elastic contact force over the overlap, damping left out.", sense=LESS, topic=CLASH, uses=ALL),
    both("largest_clash_energy", "largest clash energy",
        "Largest energy stored at one time in the contacts that one clash presses.", sense=LESS),
    both("largest_clash_impulse", "largest clash impulse",
        "Largest impulse that coils give each other within a fifth of the first natural period of the spring (0.4 ms at 500 Hz) beyond the "
        "force they hold before and after: the impact, without the load of coils that rest on each other.",
        sense=LESS, topic=CLASH, uses=("study", "page")),
    spring("main_clash_peak_force", "main clash",
        "Height of the main clash of coils 1 and 2: first spike of the force after the event that reaches 60 % of the highest (found "
        "below 16 times the surge frequency), as computed; absent where no coil meets another."),
    spring("main_clash_below_5_khz_peak_force", "main clash below 5 kHz", "Height of the main clash in a bandwidth of 5 kHz."),
    spring("main_clash_cam_angle", "main clash, cam angle",
        "Cam angle of the top of the main clash below 16 times the surge frequency."),
    spring("main_clash_impulse", "main clash, impulse",
        "Integral of the force above the base circle's mean over a sixteenth of the surge period (0.1 ms) either side of the main clash."),
    *with_angle(both("peak_shear_stress", "peak shear stress",
        "Largest shear stress at the inner fibre over wire and cycle, curvature and direct shear included.", sense=LESS,
        topic=STRESS, uses=("brief", "sweep", "curve", "stress"))),
    both("peak_shear_stress_coil_number", "peak shear stress, coil number",
        "Coil number, from 1 at the seat, of the peak shear stress.", uses=("stress",)),
    both("minimum_shear_stress", "minimum shear stress",
        "Smallest shear stress over the cycle at the inner fibre at the location of the peak shear stress.", topic=STRESS,
        uses=("sweep", "stress")),
    both("peak_equivalent_stress", "peak equivalent stress",
        "Largest von Mises stress at the inner fibre.", sense=LESS, uses=("stress",)),
    both("largest_amplitude_shear_stress", "largest stress amplitude",
        "Half the difference of largest and smallest shear stress over the cycle where that is largest along the wire.", sense=LESS,
        uses=("stress",)),
    both("largest_amplitude_mean_shear_stress", "mean stress at the largest amplitude",
        "Half the sum of largest and smallest shear stress at the point of the largest amplitude.", uses=("stress",)),
    both("largest_amplitude_coil_number", "largest stress amplitude, coil number", "Coil number of the largest stress amplitude."),
    both("open_nominal_shear_stress", "shear stress by EN 13906-1 at the largest lift",
        "Shear stress by EN 13906-1 with the Bergsträsser factor, at rest at the largest lift of the cycle, where wire and index make "
        "it largest; the load by torsion of the wire, as in the standard, no more "
        "than at solid. The standard is about loads at rest: what the wire bears in motion is the peak shear stress.",
        sense=LESS, topic=STRESS, uses=("sweep", "stress")),
    both("closed_nominal_shear_stress", "shear stress by EN 13906-1, valve closed",
        "Shear stress by EN 13906-1 with the Bergsträsser factor, at rest as installed, at the same place.", topic=STRESS,
        uses=("sweep", "stress")),
    both("open_uncorrected_shear_stress", "uncorrected shear stress at the largest lift",
        "Shear stress 8 F D / (pi d^3) at rest at the largest lift, at the worst place of the wire, without the factor for curvature and "
        "direct shear: what EN 13906-1 holds against the permitted shear stress.", sense=LESS, topic=STRESS, uses=("sweep", "stress")),
    both("wire_tensile_strength", "least tensile strength of the wire",
        "Least tensile strength of the named wire at its largest diameter; absent where the package has none (docs/limits.md).",
        dimension="pressure", shown_unit="MPa", uses=("stress",)),
    both("permitted_shear_stress", "permitted shear stress of the wire",
        "0.56 of the least tensile strength of the wire: the uncorrected stress that EN 13906-1 permits with the coils closed; no "
        "limit of fatigue.", topic=STRESS, uses=("sweep", "stress")),
    both("quasi_static_peak_shear_stress", "quasi-static peak shear stress",
        "Peak shear stress when the lift is followed along the static curve.", uses=("stress",)),
    both("quasi_static_amplitude_shear_stress", "quasi-static stress amplitude",
        "Largest stress amplitude when the lift is followed along the static curve.", uses=("stress",)),
    both("dynamic_to_static_stress_ratio", "dynamic over quasi-static stress",
        "Peak shear stress over its quasi-static value.", sense=LESS, uses=("stress",)),
    both("cycle_damper_energy", "energy lost in the damper",
        "Energy that the damping of the springs turns to heat over the reported cycle: that of the wire, and of coils in contact "
        "and rubbing springs where the model has it.", shown_unit="J", topic=SURGE, uses=("sweep", "curve", "study")),
    spring("energy_imbalance_ratio", "energy imbalance",
        "Largest difference of work done and energy stored or dissipated, over the span of the work done.", sense=LESS, physical=False),
    spring("dissipated_energy", "energy dissipated", "Energy turned to heat over the run.", shown_unit="J"),
    both("time_step_duration", "time step", "Step of the time integration.", shown_unit="us", physical=False),
    both("steps_per_cycle_count", "steps per cycle", "Steps of the time integration per cam revolution.", physical=False),
)  # fmt: skip

#: Of one steady cycle of a train. "Open" means that the rigid lift is above a tenth of its maximum.
TRAINS: tuple[QuantityRow, ...] = (
    train("peak_{place}_contact_force", "peak {place} contact force",
        "Largest force of the {place} contact over every step, impacts at seating and at taking up the lash included.", sense=LESS),
    train("peak_cam_contact_force_cam_angle", "peak cam contact force, cam angle",
        "Cam angle of the peak cam contact force, of all steps."),
    train("peak_open_{place}_contact_force", "peak {place} contact force while open",
        "Largest sampled force of the {place} contact while the valve is open.", sense=LESS),
    train("minimum_{place}_contact_force", "minimum {place} contact force while open",
        "Smallest sampled force of the {place} contact while the valve is open.", sense=MORE, uses=("curve",),
        answered_as=("minimum_cam_contact_force",)),
    train("peak_cam_contact_pressure", "peak contact pressure of the cam",
        "Largest Hertz pressure of cam and follower at the samples of the cycle, as a line contact over the width of the cam.",
        dimension="pressure", shown_unit="MPa", sense=LESS),
    train("nose_cam_contact_force", "cam contact force at the nose", "Cam contact force at the largest rigid lift."),
    train("peak_support_force", "peak support force", "Largest force of the elastic support, either sign."),
    train("peak_stem_force", "peak stem force", "Largest force of the elastic valve stem, either sign."),
    train("peak_pushrod_bar_force", "peak pushrod force", "Largest force of the elastic pushrod, either sign."),
    train("peak_lever_bending_moment", "peak bending moment of the lever",
        "Largest torque about the pivot that bends the elastic lever, either sign."),
    train("peak_cam_torque", "peak cam torque", "Largest torque that drives the cam."),
    train("minimum_cam_torque", "minimum cam torque", "Smallest torque that drives the cam, negative where the springs drive it."),
    train("mean_cam_torque", "mean cam torque",
        "Work of the cam per cycle over the angle of a turn: what contacts, links and springs lose.", sense=LESS),
    train("mean_cam_power", "mean cam power", "Work of the cam per cycle over the time of the cycle.", sense=LESS),
    train("minimum_spring_margin_force", "minimum spring margin",
        "Smallest surplus at the valve, by rigid theory, of the springs at rest over inertia, weight and gas where the valve is "
        "slowed; the springs' own mass counts with its Rayleigh share, a third, whatever model runs.", sense=MORE),
    train("minimum_spring_margin_ratio", "minimum spring margin, ratio",
        "Spring force less weight and gas over the inertia force where the valve is slowed, by rigid theory, where that is least; "
        "1 at the float speed of rigid parts where the cam loses contact first.", sense=MORE),
    train("open_spring_force", "spring load at full lift", "Force of all springs at rest at the largest rigid lift."),
    train("needed_closed_spring_force", "seat load needed", "Force of all springs with the valve closed with which they "
        "balance weight, gas and the inertia force plus 20 % at the valve, by rigid theory, at their own rate."),
    train("needed_open_spring_force", "load at full lift needed",
        "Force of all springs at full lift with the seat load needed, at the least rate where that is none."),
    train("needed_spring_rate", "rate needed", "Rate that gives the same at the seat load as it is, where that is enough at zero lift.",
        dimension="stiffness", shown_unit="N/mm"),
    train("{spring}_mean_peak_section_displacement", "mean peak motion of the coils ({spring})",
        "Mean along the spring ({spring}) of each section's largest displacement over the cycle.", sense=LESS),
    train("peak_rigid_valve_lift", "peak rigid valve lift", "Largest valve lift of rigid parts."),
    train("valve_open_duration", "time open", "Time per cycle in which the valve is off its seat."),
    train("seating_velocity", "seating velocity", "Velocity of the first touch of the seat.", sense=LESS, topic=CONTACT, uses=ALL),
    train("permitted_seating_velocity", "permitted seating velocity",
        "Limit of the seating velocity that the case sets, in [train.valve]; absent where it sets none (docs/limits.md)."),
    train("seating_cam_angle", "seating, cam angle", "Cam angle of the first touch of the seat."),
    train("bounce_height", "bounce height", "Height of the highest bounce.", sense=LESS, topic=CONTACT, uses=("curve", "study")),
    train("bounce_count", "bounces",
        "Bounces after the first touch of the seat, however low; the bounce speed and verdicts count those above 0.1 mm.",
        sense=LESS, topic=CONTACT, uses=("brief", "sweep", "study")),
    train("loft_gap", "loft",
        "Largest gap at the cam while the rigid valve is open by more than a tenth of its lift.", sense=LESS, topic=CONTACT, uses=("curve", "study")),
    train("loft_count", "losses of contact", "Lofts while the rigid valve is open by more than a tenth of its lift.", sense=LESS),
    train("loft_duration", "time of loft",
        "Time in all of the lofts while the rigid valve is open by more than a tenth of its lift.", sense=LESS),
    train("loss_of_contact_duration", "time without contact",
        "Time in all without contact in the drive while the rigid valve is open by more than a tenth of its lift.", sense=LESS, topic=CONTACT,
        uses=("brief", "study")),
    train("float_excess_lift", "lift above the rigid lift",
        "Largest lift above the rigid lift over the nose, off the cam.", sense=LESS, uses=("curve",)),
    train("float_duration", "time of float",
        "Time in all in which the lift is above the rigid lift over the nose, off the cam.", sense=LESS),
    train("lift_loss_displacement", "lift lost",
        "Largest rigid lift less the largest computed one.", sense=LESS, topic=CONTACT, uses=("sweep", "curve", "study")),
    train("peak_lever_speed", "peak lever rotation speed", "Largest turning speed of lever or rocker.", shown_unit="deg/s"),
    train("peak_lever_speed_valve_lift", "valve lift at the peak lever rotation speed",
        "Valve lift where lever or rocker turns fastest."),
    train("minimum_piston_clearance_gap", "minimum clearance to the piston",
        "Minimum distance of piston and valve along the cylinder.", sense=MORE),
    train("cycle_work_energy", "work of the cam", "Work of the cam per cycle.", shown_unit="J"),
    train("cycle_dissipated_energy", "energy lost in contacts, links and guides",
        "Energy that contacts, links and guides turn to heat per cycle.", shown_unit="J"),
    train("spring_dissipated_energy", "energy lost in the springs", "Energy that the springs take per cycle.", shown_unit="J"),
    train("driver_difference_force", "retainer force of the solid less that of its driver",
        "Root mean square over a turn of the force of solid springs on the retainer less that of the springs that the train ran with.",
        sense=LESS),
    train("contact_friction_dissipated_energy", "energy lost to friction in the contacts",
        "Share of friction in the contacts in the energy lost in contacts, links and guides.", shown_unit="J"),
    train("steady_cycles_count", "cycles until settled", "Cycles run to the steady state.", physical=False),
    train("steady_residual_ratio", "last change per cycle", "Relative change of the state over the last cycle.", sense=LESS),
    train("steady_tolerance_ratio", "change accepted as settled", "Relative change per cycle that counts as settled."),
    train("motion_period_count", "cycles per repetition", "Period of the motion in cycles; 0 where none was found."),
)  # fmt: skip

#: Lifts at which valve events are given -> label.
EVENT_LIFTS = {"lash": "at lash", "1_mm": "at 1 mm", "50_thou": "at 0.050 in"}
#: What opens -> label, the lifts of its events, and whose they are.
OPENERS = {
    "lobe": ("lobe", ("1_mm", "50_thou"), "of the lobe by its lift law"),
    "rigid_valve": ("rigid valve", tuple(EVENT_LIFTS), "of the valve with rigid parts"),
    "valve": ("valve", tuple(EVENT_LIFTS), "of the valve in the run"),
}  # fmt: skip


def event_rows() -> tuple[QuantityRow, ...]:
    """Opening, closing and duration of everything that opens, at every lift of its events."""
    rows = []
    for name, (label, lifts, whose) in OPENERS.items():
        for lift in lifts:
            at, where = EVENT_LIFTS[lift], "the seat is left and first touched again"
            if lift != "lash":
                where = f"the lift passes {at.removeprefix('at ')}"
            rows += [
                train(f"{name}_{lift}_{end}_cam_angle", f"{label} {end} {at}, cam angle", f"Cam angle of the {end} {whose}: where {where}.")
                for end in ("opening", "closing")
            ]  # fmt: skip
            words = f"Crank angle from opening to closing {whose}, {at}."
            rows.append(train(f"{name}_{lift}_open_crank_angle_range", f"{label} open {at}", words))
    rows += [
        train(f"valve_{lift}_lost_crank_angle_range", f"duration lost {EVENT_LIFTS[lift]}",
            f"Crank angle that the valve of the run is open for less than with rigid parts, {EVENT_LIFTS[lift]}.", sense=LESS)
        for lift in ("1_mm", "50_thou")
    ]  # fmt: skip
    rows += [
        train(f"{event.lower()}_{lift}_crank_angle", f"{event} {at}, {side} {dead} dead centre",
            f"Crank angle {side} {dead} dead centre of gas exchange at which the valve of the run "
            f"{'opens' if counts_before else 'closes'} {at}; negative on the other side, absent where no timing is given.")
        for lift, at in EVENT_LIFTS.items()
        for event, (_, dead, counts_before) in cam_events.EVENTS.items()
        for side in ("before" if counts_before else "after",)
    ]  # fmt: skip
    return tuple(rows)  # fmt: skip


#: Opening and closing of lobe and valve.
EVENTS: tuple[QuantityRow, ...] = event_rows()

#: Numbers of a train whose scatter from cycle to cycle is given where its motion does not repeat -> label.
SCATTERED = {
    "valve_lift": "the valve lift at one cam angle", "peak_valve_lift": "the peak valve lift", "peak_spring_force": "the peak spring force",
    "raw_peak_spring_force": "the raw peak spring force", "raw_peak_retainer_force": "the raw peak retainer force",
    "minimum_spring_force": "the minimum spring force", "peak_retainer_force": "the peak retainer force",
    "minimum_retainer_force": "the minimum retainer force", "peak_{place}_contact_force": "the peak {place} contact force",
    "seating_velocity": "the seating velocity", "bounce_height": "the bounce height", "bounce_count": "the bounces", "loft_gap": "the loft",
    "cycle_work_energy": "the work of the cam", "peak_valve_acceleration": "the peak valve acceleration",
    "nose_cam_contact_force": "the cam force at the nose",
    "minimum_{place}_contact_force": "the minimum {place} contact force while open",
}  # fmt: skip
_NO_ANSWER = (
    "peak_valve_acceleration",
    "nose_cam_contact_force",
    "minimum_{place}_contact_force",
    "peak_valve_lift",
    "raw_peak_spring_force",
    "peak_retainer_force",
    "raw_peak_retainer_force",
    "minimum_retainer_force",
    "cycle_work_energy",
)
SCATTER: tuple[QuantityRow, ...] = tuple(
    row(
        f"cycle_scatter_{name}",
        f"scatter of {label}",
        f"Largest less smallest value of {label} over 8 cycles of a motion that does not repeat; absent where it does.",
        sense=LESS,
        systems=TRAIN,
        shown_unit="J" if name.endswith("energy") else None,
        topic="" if name in _NO_ANSWER else SCATTERING,
        answered_as=tuple(
            f"cycle_scatter_{name.format(place=place)}" for place in ("cam", "seat") if "{" in name
        ),
    )
    for name, label in SCATTERED.items()
)

#: Engine speeds at which control is lost, of a sweep and by rigid theory.
SWEEP: tuple[QuantityRow, ...] = (
    train("contact_loss_engine_speed", "contact-loss speed",
        "Lowest engine speed found at which a contact of the drive opens while the valve is open by more than a tenth of its lift, "
        "every speed from rest; the nominal value, which moves smoothly with the inputs.", sense=MORE, topic=CONTROL, uses=("sweep",)),
    train("float_engine_speed", "float speed",
        "Lowest engine speed found at which the valve runs above its rigid lift by more than a limit (50 µm) with a contact of the "
        "drive open, every speed from rest; the nominal value.", sense=MORE, topic=CONTROL, uses=("sweep",)),
    train("bounce_engine_speed", "bounce speed",
        "Lowest engine speed found at which the valve leaves its seat again by more than a limit (0.1 mm), every speed "
        "from rest; the nominal value.", sense=MORE, topic=CONTROL, uses=("sweep",)),
    train("rigid_contact_loss_engine_speed", "contact-loss speed, rigid parts",
        "Engine speed at which a contact of the drive is first lost by rigid theory: springs at rest, weight, gas and inertia, no surge or flex.",
        sense=MORE, topic=CONTROL, uses=("sweep", "case")),
    train("rigid_contact_loss_cam_angle", "contact-loss speed, rigid parts, cam angle",
        "Cam angle at which rigid theory first loses a contact."),
    train("rigid_nose_begin_cam_angle", "begin of the nose", "Cam angle from which the valve of rigid parts is slowed over the nose."),
    train("rigid_nose_end_cam_angle", "end of the nose", "Cam angle up to which the valve of rigid parts is slowed over the nose."),
    train("closing_ramp_begin_cam_angle", "begin of the closing ramp", "Cam angle at which the closing lift law comes down to its ramp."),
    train("closing_ramp_end_cam_angle", "end of the closing ramp", "Cam angle at which the closing lift law comes to rest."),
)  # fmt: skip

ROWS: tuple[QuantityRow, ...] = (*AT_REST, *CAM, *RUNS, *TRAINS, *EVENTS, *SCATTER, *SWEEP)
