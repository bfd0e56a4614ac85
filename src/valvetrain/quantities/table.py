"""The one table of quantities: every number that belongs to no single paper, with what it means and
how it is shown.

Names are templates where a place, a number or a spring stands in them (see
:class:`valvetrain.solution.definition.QuantityRow`).
"""

from __future__ import annotations

from valvetrain.solution.definition import QuantityRow, Sense, Systems, row

BOTH: Systems = ("spring", "train")
SPRING: Systems = ("spring",)
TRAIN: Systems = ("train",)
MORE: Sense = "larger is better"
LESS: Sense = "smaller is better"


def with_angle(one: QuantityRow) -> tuple[QuantityRow, QuantityRow]:
    """A row, and the one of the cam angle at which its value stands."""
    return one, row(
        f"{one.name}_cam_angle",
        f"{one.label}, cam angle",
        f"Cam angle of the {one.label}.",
        systems=one.systems,
    )


#: Of a spring and its place before anything runs.
AT_REST: tuple[QuantityRow, ...] = (
    row("preload", "preload", "Static force at the installed precompression.", systems=BOTH),
    row("installed_rate", "installed rate", "Slope of the static curve at the installed precompression.", systems=BOTH),
    row("installed_nominal_shear_stress", "installed nominal shear stress",
        "Shear by EN 13906-1 under the preload, k 8 F D / (pi d^3) with k = (w + 0.5) / (w - 0.75), at the worst place of the wire.",
        systems=BOTH),
    row("installed_shear_stress", "installed shear stress",
        "Largest shear at the inner fibre along the wire under the preload, from its section loads.", systems=BOTH),
    row("installed_equivalent_stress", "installed equivalent stress",
        "Largest von Mises stress at the inner fibre along the wire under the preload.", systems=BOTH),
    row("installed_retainer_torque", "installed torque on the retainer",
        "Torque of the wire on the retainer about the axis, positive the way the wire rises; none where the retainer may turn.",
        systems=BOTH),
    row("installed_retainer_moment", "installed moment on the retainer",
        "Moment of the wire on the retainer across the axis, about the middle of its plane.", dimension="moment", shown_unit="N m",
        systems=BOTH),
    row("installed_retainer_side_force", "installed side force on the retainer", "Force of the wire on the retainer across the axis.",
        systems=BOTH),
    row("installed_retainer_rotation_angle", "installed rotation of the retainer",
        "Angle by which a retainer that may turn has turned from the free state, positive the way the wire rises.", systems=BOTH),
    row("solid_force", "force at solid",
        "Force that closes the last coil, by torsion of the wire; rate times compression to solid of a cylindrical spring of even pitch.",
        systems=BOTH),
    row("solid_nominal_shear_stress", "nominal shear stress at solid",
        "Largest shear by EN 13906-1 along the wire with all coils closed, each turn under the force that closes it.", systems=BOTH),
    row("moving_retainer_mode_{n}_frequency", "mode {n} frequency, retainer moving",
        "Axial natural frequency {n} about the installed state, the retainer free along the axis with the mass attached to it.",
        systems=BOTH),
    row("installed_compression", "installed compression", "Compression from the free length to the installed height.", systems=BOTH),
    row("installed_height", "installed height", "Free length less the installed compression.", systems=BOTH),
    row("stiffness_change_compression", "compression at the change of stiffness",
        "Compression at which the stiffness of the static curve first changes.", systems=BOTH),
    row("coil_{m}_{n}_installed_gap", "installed gap of coils {m} and {n}",
        "Smallest gap between coils {m} and {n} at the installed precompression.", systems=BOTH),
    row("coil_bind_clearance", "clearance to coil bind", "Length left until the coils are solid at the largest lift.", sense=MORE,
        systems=BOTH),
    row("coil_bind_lift", "lift at coil bind", "Lift at which the coils of the installed spring are solid.", sense=MORE, systems=BOTH),
    row("buckling_compression", "compression at which it buckles",
        "Compression at which the spring buckles by the finite-element rod: its rate falls below half of that as wound, or its tangent "
        "loses a sign.", sense=MORE, systems=BOTH),
    row("buckling_height", "height at which it buckles", "Free length less the compression at which the spring buckles.", systems=BOTH),
    row("buckling_clearance", "clearance to buckling",
        "Compression left until the spring buckles at the largest lift; negative where it buckles at work.", sense=MORE, systems=BOTH),
    row("formula_buckling_compression", "compression at which it buckles, by formula",
        "Compression at which a cylindrical spring between parallel seats buckles by EN 13906-1 (Haringx).", sense=MORE, systems=BOTH),
    row("guide_contact_compression", "compression at which it meets its guide",
        "Compression at which the wire first touches the bore or rod that guides it, at rest.", systems=BOTH),
    row("guide_force", "force on its guide",
        "Sum of the normal forces between wire and guide at the end of the static curve, a little beyond the largest lift.", sense=LESS,
        systems=BOTH),
    row("surge_frequency", "surge frequency", "First axial natural frequency of the installed spring, both ends fixed.", sense=MORE,
        systems=BOTH),
    row("mode_{n}_frequency", "mode {n} frequency",
        "Axial natural frequency {n} about the installed state, both ends fixed (found by force transmission).", systems=BOTH),
    row("natural_{n}_frequency", "natural frequency {n}", "Natural frequency {n} in rising order, whatever its direction.", systems=BOTH),
    row("total_coil_count", "coils in all", "Turns of wire.", systems=BOTH),
    row("active_coil_count", "active coils", "Turns between the inactive ends that do not lie closed on a neighbour.", systems=BOTH),
    row("free_length", "free length", "Length between the seat planes unloaded.", systems=BOTH),
    row("solid_height", "solid height", "Length between the seat planes with all coils closed.", systems=BOTH),
    row("solid_compression", "compression to solid", "Free length less the solid height.", systems=BOTH),
    row("largest_pitch", "largest pitch",
        "Largest rise of the wire's axis per turn: of a spring given by its free length, the pitch between its ends.", systems=BOTH,
        dimension="length", shown_unit="mm"),
    row("wire_length", "wire length", "Length of the whole wire, tip to tip, the ground-off part included.", systems=BOTH),
    row("wire_mass", "wire mass", "Mass of the whole wire, tip to tip, the ground-off part included.", systems=BOTH),
    row("smallest_index_ratio", "smallest spring index", "Smallest mean coil diameter over wire diameter along the wire.", systems=BOTH),
    row("largest_index_ratio", "largest spring index", "Largest mean coil diameter over wire diameter along the wire.", systems=BOTH),
    row("largest_outer_diameter", "largest outer diameter", "Largest outer diameter of the coils, unloaded.", systems=BOTH),
    row("smallest_inner_diameter", "smallest inner diameter", "Smallest inner diameter of the coils, unloaded.", systems=BOTH),
    row("estimated_rate", "estimated rate",
        "Rate of the free state by torsion alone, 1/k = integral of 8 D^3 / (G d^4) over the active turns; G d^4 / (8 D^3 n) for a "
        "cylindrical spring.", systems=BOTH),
    row("estimated_surge_frequency", "estimated surge frequency",
        "0.5 sqrt(k / m) of the estimated rate and the mass of the active turns, both ends fixed.", systems=BOTH),
    row("card_rate", "rate of the card", "Rate as the spring card has it.", systems=BOTH),
    row("card_preload", "preload of the card", "Preload as the spring card has it.", systems=BOTH),
    row("card_mass", "mass of the card", "Mass as the spring card has it.", systems=BOTH),
    row("card_installed_height", "installed height of the card", "Installed height as the spring card has it.", systems=BOTH),
    row("card_open_force", "open force of the card", "Force at the open lift as the spring card has it.", systems=BOTH),
    row("card_open_lift", "open lift of the card", "Lift at which the card's open force is given.", systems=BOTH),
    row("card_solid_height", "solid height of the card", "Solid height as the spring card has it.", systems=BOTH),
    row("card_surge_frequency", "surge frequency of the card", "0.5 sqrt(k / m) of the card's rate and mass, both ends fixed.",
        systems=BOTH),
    row("maximum_lift", "largest lift", "Largest value of the lift law.", systems=BOTH),
    row("maximum_lift_cam_angle", "largest lift, cam angle", "Cam angle of the largest value of the lift law.", systems=BOTH),
    row("rigid_maximum_valve_lift", "largest rigid valve lift", "Largest valve lift of rigid parts with all contacts closed.",
        systems=TRAIN),
    row("rigid_contact_loss_engine_speed", "loss of contact by rigid theory",
        "Engine speed at which a contact of the drive is first lost by rigid theory: springs at rest, weight, gas and inertia.",
        sense=MORE, systems=TRAIN),
    row("rigid_contact_loss_cam_angle", "loss of contact by rigid theory, cam angle",
        "Cam angle at which rigid theory first loses a contact.", systems=TRAIN),
)  # fmt: skip

#: Of a run, in both systems.
RUNS: tuple[QuantityRow, ...] = (
    *with_angle(row("peak_spring_force", "peak spring force",
                    "Largest force of all springs on the cylinder head over the reported cycle.", sense=LESS, systems=BOTH)),
    *with_angle(row("minimum_spring_force", "least spring force",
                    "Smallest force of all springs on the cylinder head over the reported cycle.", sense=MORE, systems=BOTH)),
    row("below_{k}_khz_peak_spring_force", "peak spring force below {k} kHz",
        "Largest spring force in a bandwidth of {k} kHz, as an amplifier of a force transducer passes it.", sense=LESS, systems=BOTH),
    row("peak_retainer_force", "peak retainer force", "Largest force of all springs on the retainer over the reported cycle.", sense=LESS,
        systems=BOTH),
    row("minimum_retainer_force", "least retainer force", "Smallest force of all springs on the retainer over the reported cycle.",
        sense=MORE, systems=BOTH),
    row("peak_valve_lift", "peak valve lift", "Largest valve lift over the reported cycle.", systems=BOTH),
    row("peak_valve_acceleration", "peak valve acceleration", "Acceleration of the valve of largest size over the reported cycle.",
        systems=BOTH),
    row("surge_cam_order", "surge order", "Surge frequency over cam frequency.", systems=BOTH),
    row("nearest_lift_harmonic_order", "nearest lift harmonic", "Cam order of the lift's harmonic nearest to the surge frequency.",
        systems=BOTH),
    row("nearest_lift_harmonic_lift", "nearest lift harmonic, amplitude",
        "Amplitude (0 to peak) of the lift's harmonic nearest to the surge frequency.", sense=LESS, shown_unit="um", systems=BOTH),
    row("surge_amplitude_force", "surge amplitude",
        "Largest amplitude (0 to peak), among the cam orders from half to one and a half times the surge order, of the spring force less "
        "its static value at the same lift.", sense=LESS, systems=BOTH),
    row("surge_order_{n}_engine_speed", "surge at cam order {n}, engine speed",
        "Engine speed at which cam order {n} of the lift meets the surge frequency, among those run and a quarter beyond.",
        systems=TRAIN),
    row("surge_order_{n}_force", "surge at cam order {n}",
        "Amplitude (0 to peak) of cam order {n} of the spring force less its static value at the same lift.", sense=LESS, systems=BOTH),
    row("clash_count", "coil clashes", "Clashes of coils over the reported cycle, found on the integrator's own steps; pairs that always "
        "touch are left out, and one that parts for less than 10 us only rings.", sense=LESS, systems=BOTH),
    row("peak_clash_force", "peak clash force", "Largest force between coils in a clash, of all places that it presses at one time.",
        sense=LESS, systems=BOTH),
    row("clash_energy", "clash energy",
        "Sum over the clashes of the largest energy stored at one time in the contacts that a clash presses: integral of the elastic "
        "contact force over the overlap, damping left out.", sense=LESS, systems=BOTH),
    row("largest_clash_energy", "largest clash energy", "Largest energy stored at one time in the contacts that one clash presses.",
        sense=LESS, systems=BOTH),
    row("largest_clash_impulse", "largest clash impulse",
        "Largest impulse that coils give each other within 0.3 ms beyond the force they hold before and after: the blow, without the load "
        "of coils that rest on each other.", sense=LESS, systems=BOTH),
    *with_angle(row("peak_shear_stress", "peak shear stress",
                    "Largest shear stress at the inner fibre over wire and cycle, curvature and direct shear included.", sense=LESS,
                    systems=BOTH)),
    row("peak_shear_stress_coil_number", "peak shear stress, coil number", "Coil number, from 1 at the seat, of the peak shear stress.",
        systems=BOTH),
    row("minimum_shear_stress", "least shear stress",
        "Smallest shear stress over the cycle at the inner fibre where the peak shear stress stands.", systems=BOTH),
    row("peak_equivalent_stress", "peak equivalent stress", "Largest von Mises stress at the inner fibre.", sense=LESS, systems=BOTH),
    row("largest_amplitude_shear_stress", "largest stress amplitude",
        "Half the difference of largest and least shear stress over the cycle where that is largest along the wire.", sense=LESS,
        systems=BOTH),
    row("largest_amplitude_mean_shear_stress", "mean stress at the largest amplitude",
        "Half the sum of largest and least shear stress at the point of the largest amplitude.", systems=BOTH),
    row("largest_amplitude_coil_number", "largest stress amplitude, coil number", "Coil number of the largest stress amplitude.",
        systems=BOTH),
    row("nominal_peak_shear_stress", "peak shear stress by EN 13906-1",
        "Shear stress of the peak spring force by EN 13906-1 with the Bergsträsser factor, where wire and index make it largest.",
        sense=LESS, systems=BOTH),
    row("nominal_minimum_shear_stress", "least shear stress by EN 13906-1",
        "Shear stress of the least spring force by EN 13906-1 with the Bergsträsser factor, at the same place.", systems=BOTH),
    row("quasi_static_peak_shear_stress", "quasi-static peak shear stress",
        "Peak shear stress when the lift is followed along the static curve.", systems=BOTH),
    row("quasi_static_amplitude_shear_stress", "quasi-static stress amplitude",
        "Largest stress amplitude when the lift is followed along the static curve.", systems=BOTH),
    row("dynamic_to_static_stress_ratio", "dynamic over quasi-static stress", "Peak shear stress over its quasi-static value.", sense=LESS,
        systems=BOTH),
    row("energy_imbalance_ratio", "energy imbalance",
        "Largest difference of work done and energy stored or dissipated, over the span of the work done.", sense=LESS, systems=SPRING),
    row("dissipated_energy", "energy dissipated", "Energy turned to heat over the run.", shown_unit="J", systems=SPRING),
    row("time_step_duration", "time step", "Step of the time integration.", shown_unit="us", systems=BOTH),
    row("steps_per_cycle_count", "steps per cycle", "Steps of the time integration per cam turn.", systems=BOTH),
)  # fmt: skip

#: Of one steady cycle of a train. "Open" means that the rigid lift is above a tenth of its maximum.
TRAINS: tuple[QuantityRow, ...] = (
    row("peak_{place}_contact_force", "peak {place} contact force",
        "Largest force of the {place} contact over every step, impacts at seating and at taking up the lash included.", sense=LESS,
        systems=TRAIN),
    row("peak_open_{place}_contact_force", "peak {place} contact force while open",
        "Largest sampled force of the {place} contact while the valve is open.", sense=LESS, systems=TRAIN),
    row("minimum_{place}_contact_force", "least {place} contact force while open",
        "Smallest sampled force of the {place} contact while the valve is open.", sense=MORE, systems=TRAIN),
    row("nose_cam_contact_force", "cam contact force at the nose", "Cam contact force at the largest rigid lift.", systems=TRAIN),
    row("peak_support_force", "peak support force", "Largest force of the elastic support, either sign.", systems=TRAIN),
    row("peak_stem_force", "peak stem force", "Largest force of the elastic valve stem, either sign.", systems=TRAIN),
    row("peak_pushrod_bar_force", "peak pushrod force", "Largest force of the elastic pushrod, either sign.", systems=TRAIN),
    row("peak_lever_bending_force", "peak bending moment of the lever",
        "Largest torque about the pivot that bends the elastic lever, either sign.", dimension="moment", shown_unit="N m", systems=TRAIN),
    row("peak_cam_torque", "peak cam torque", "Largest torque that drives the cam.", systems=TRAIN),
    row("minimum_cam_torque", "least cam torque", "Smallest torque that drives the cam, negative where the springs drive it.",
        systems=TRAIN),
    row("mean_cam_torque", "mean cam torque", "Work of the cam per cycle over the angle of a turn: what contacts, links and springs lose.",
        sense=LESS, systems=TRAIN),
    row("mean_cam_power", "mean cam power", "Work of the cam per cycle over the time of the cycle.", sense=LESS, systems=TRAIN),
    row("minimum_spring_margin_force", "least spring margin",
        "Smallest surplus at the valve, by rigid theory, of the springs at rest over inertia, weight and gas where the valve is slowed.",
        sense=MORE, systems=TRAIN),
    row("minimum_spring_margin_ratio", "least spring margin, ratio",
        "Spring force less weight and gas over the inertia force where the valve is slowed, by rigid theory, where that is least; 1 where "
        "contact is lost.", sense=MORE, systems=TRAIN),
    row("peak_rigid_valve_lift", "peak rigid valve lift", "Largest valve lift of rigid parts.", systems=TRAIN),
    row("lift_loss_displacement", "lift lost", "Largest rigid lift less the largest computed one.", sense=LESS, systems=TRAIN),
    row("valve_open_duration", "time open", "Time per cycle in which the valve stands off its seat.", systems=TRAIN),
    row("seating_velocity", "seating velocity", "Velocity of the first touch of the seat.", sense=LESS, systems=TRAIN),
    row("seating_cam_angle", "seating, cam angle", "Cam angle of the first touch of the seat.", systems=TRAIN),
    row("bounce_count", "bounces", "Bounces after the first touch of the seat.", sense=LESS, systems=TRAIN),
    row("bounce_height", "bounce height", "Height of the highest bounce.", sense=LESS, systems=TRAIN),
    row("loft_gap", "loft", "Largest gap at the cam while the rigid valve is open.", sense=LESS, systems=TRAIN),
    row("loft_count", "losses of contact", "Times the cam contact opens while the rigid valve is open.", sense=LESS, systems=TRAIN),
    row("loft_duration", "time of loft", "Time in all in which the cam contact is open while the rigid valve is open.", sense=LESS,
        systems=TRAIN),
    row("loss_of_contact_duration", "time without contact",
        "Time in all in which any contact of the drive carries no force while the rigid valve is open.", sense=LESS, systems=TRAIN),
    row("float_excess_lift", "lift above the rigid one", "Largest lift above the rigid one over the nose with the train open.", sense=LESS,
        systems=TRAIN),
    row("float_duration", "time of float", "Time in all in which the lift is above the rigid one over the nose with the train open.",
        sense=LESS, systems=TRAIN),
    row("peak_lever_speed", "peak lever rotation speed", "Largest turning speed of lever or rocker.", shown_unit="deg/s", systems=TRAIN),
    row("peak_lever_speed_valve_lift", "valve lift at the peak lever rotation speed", "Valve lift where lever or rocker turns fastest.",
        systems=TRAIN),
    row("minimum_piston_clearance_gap", "least clearance to the piston", "Least distance of piston and valve along the cylinder.",
        sense=MORE, systems=TRAIN),
    row("cycle_work_energy", "work of the cam", "Work of the cam per cycle.", shown_unit="J", systems=TRAIN),
    row("cycle_dissipated_energy", "energy lost in contacts, links and guides",
        "Energy that contacts, links and guides turn to heat per cycle.", shown_unit="J", systems=TRAIN),
    row("spring_dissipated_energy", "energy lost in the springs", "Energy that the springs take per cycle.", shown_unit="J",
        systems=TRAIN),
    row("contact_friction_dissipated_energy", "energy lost to friction in the contacts",
        "Share of friction in the contacts in the energy lost in contacts, links and guides.", shown_unit="J", systems=TRAIN),
    row("steady_cycles_count", "cycles until settled", "Cycles run to the steady state.", systems=TRAIN),
    row("steady_residual_ratio", "last change per cycle", "Relative change of the state over the last cycle.", sense=LESS, systems=TRAIN),
    row("steady_tolerance_ratio", "change accepted as settled", "Relative change per cycle that counts as settled.", systems=TRAIN),
    row("motion_period_count", "cycles per repetition", "Period of the motion in cycles; 0 where none was found.", systems=TRAIN),
)  # fmt: skip

#: Lifts at which valve events are told -> words.
EVENT_LIFTS = {"lash": "at lash", "1_mm": "at 1 mm", "50_thou": "at 0.050 in"}
#: What opens -> words, and the lifts of its events.
OPENERS = {
    "lobe": ("lobe", ("1_mm", "50_thou"), "of the lobe by its lift law"),
    "rigid_valve": ("rigid valve", tuple(EVENT_LIFTS), "of the valve with rigid parts"),
    "valve": ("valve", tuple(EVENT_LIFTS), "of the valve in the run"),
}  # fmt: skip


def event_rows() -> tuple[QuantityRow, ...]:
    """Opening, closing and duration of everything that opens, at every lift at which it is told."""
    rows = []
    for word, (label, lifts, whose) in OPENERS.items():
        for lift in lifts:
            where = EVENT_LIFTS[lift]
            what = (
                "the seat is left and first touched again"
                if lift == "lash"
                else f"the lift passes {where.removeprefix('at ')}"
            )
            for end in ("opening", "closing"):
                told = f"Cam angle of the {end} {whose}: where {what}."
                rows.append(
                    row(
                        f"{word}_{lift}_{end}_cam_angle",
                        f"{label} {end} {where}, cam angle",
                        told,
                        systems=TRAIN,
                    )
                )
            told = f"Crank angle from opening to closing {whose}, {where}."
            rows.append(
                row(
                    f"{word}_{lift}_open_crank_angle_range",
                    f"{label} open {where}",
                    told,
                    systems=TRAIN,
                )
            )
    return tuple(rows)


#: Opening and closing of lobe and valve.
EVENTS: tuple[QuantityRow, ...] = event_rows()

#: Numbers of a train whose scatter from cycle to cycle is told where its motion does not repeat ->
#: plain words.
SCATTERED = {
    "valve_lift": "the valve lift at one cam angle", "peak_valve_lift": "the peak valve lift", "peak_spring_force": "the peak spring force",
    "minimum_spring_force": "the least spring force", "peak_retainer_force": "the peak retainer force",
    "minimum_retainer_force": "the least retainer force", "peak_{place}_contact_force": "the peak {place} contact force",
    "loft_gap": "the loft", "seating_velocity": "the seating velocity", "bounce_count": "the bounces", "bounce_height": "the bounce height",
    "cycle_work_energy": "the work of the cam",
}  # fmt: skip
SCATTER: tuple[QuantityRow, ...] = tuple(
    row(
        f"cycle_scatter_{name}",
        f"scatter of {words}",
        f"Largest less least value of {words} over 8 cycles of a motion that does not repeat; absent where it does.",
        sense=LESS,
        systems=TRAIN,
        shown_unit="J" if name.endswith("energy") else None,
    )
    for name, words in SCATTERED.items()
)

#: Of a sweep over engine speeds.
SWEEP: tuple[QuantityRow, ...] = (
    row("contact_loss_engine_speed", "loss of contact from",
        "Lowest engine speed found at which a contact of the drive opens while the valve is open by more than a tenth of its lift; "
        "upper end of a bracket of 10 rpm, every speed from rest.", sense=MORE, systems=TRAIN),
    row("float_engine_speed", "float from",
        "Lowest engine speed found at which the valve runs above its rigid lift by more than a limit (50 µm) with a contact of the drive "
        "open; upper end of a bracket of 10 rpm, every speed from rest.", sense=MORE, systems=TRAIN),
    row("bounce_engine_speed", "bounce from",
        "Lowest engine speed found at which the valve leaves its seat again by more than a limit (0.1 mm); upper end of a bracket of "
        "10 rpm, every speed from rest.", sense=MORE, systems=TRAIN),
)  # fmt: skip

ROWS: tuple[QuantityRow, ...] = (*AT_REST, *RUNS, *TRAINS, *EVENTS, *SCATTER, *SWEEP)
