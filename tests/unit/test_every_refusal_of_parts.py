"""Every alternative of what a part of the package refuses, entered alone: a part that is taken, and
one change that is not.

`test_each_part_is_taken_as_it_stands` is the other half: without the change nothing is refused.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import partial
from typing import Any

import numpy as np
import pytest
from validation.calculix.transient import TransientJob

import valvetrain as vt
from spring_shapes import cylindrical
from valvetrain.cam.arcs import Tangent, ThreeArc, half_event
from valvetrain.cam.cam_card import CamCard
from valvetrain.cam.closed_form import SinePower
from valvetrain.cam.measured import Measured
from valvetrain.cam.pieces import PeriodicPieces
from valvetrain.cam.polydyne import Polydyne
from valvetrain.cam.ramped import ramped
from valvetrain.cam.shaped import Shaped
from valvetrain.cam.spline import Spline, Stations
from valvetrain.contact.dissipative import damping_number, rebound
from valvetrain.continuum.mesh import MeshOptions
from valvetrain.integrate.contract import RunUp
from valvetrain.mechanism.contour import table_from_samples
from valvetrain.mechanism.parts import (
    AssembledMechanism,
    Coordinate,
    ElasticLink,
    Interaction,
    MaxwellLink,
)
from valvetrain.parameters import Constant, Material, PiecewiseLinear, SpringDefinition
from valvetrain.parameters.curves import Table
from valvetrain.parameters.installed_spring import CoilContact, DampingParameters, InstalledSpring
from valvetrain.parameters.train_parts import FollowerParameters, GasLoad
from valvetrain.parameters.winding import EndCoil
from valvetrain.quantities.signal import low_pass
from valvetrain.quantities.statics import buckling_compression
from valvetrain.runs.error_bars import observed_order
from valvetrain.springs.chain_layout import uniform_chain
from valvetrain.springs.massless import massless_table
from valvetrain.springs.nested import RadialRubbing

NAN = math.nan
SPRING = cylindrical("3.8 mm", "22 mm", "7 mm", total_coils=7)
LOBE = {"base_radius": 0.015, "nose_radius": 0.006, "maximum_lift": 0.009, "nose": 2.0}
TABLE = {"cam_angles": (0.5, 1.0, 1.5, 2.0, 2.5), "lifts": (0.0, 2e-3, 5e-3, 2e-3, 0.0)}
MEAN_OF_LIFT = {"maximum_lift": 0.01, "ramp_lift": 2e-4, "ramp_start": 0.3, "event_start": 0.7}
BODY, SEAT = (
    Coordinate("valve", 0.1),
    Interaction("seat", 0, ("valve", "", "", ""), (0.0, 1.0), ElasticLink(1e6)),
)
UNIFORM = vt.springs.EquivalentSpring(40e3, 300.0, 0.05)
GIVEN: dict[str, tuple[Callable[..., Any], dict[str, Any]]] = {
    "three-arc": (ThreeArc, LOBE | {"opening_start": 0.8}),
    "tangent": (Tangent, LOBE | {"follower_radius": 0.012}),
    "half event": (half_event, {"base_radius": 0.015, "nose_radius": 0.006, "maximum_lift": 0.009, "flank_radius": 0.06}),
    "cam card": (CamCard, {"maximum_lift": 0.009, "nose": 1.9, "duration": 2.0, "duration_lift": 1.27e-3}),
    "longer card": (CamCard, {"maximum_lift": 0.009, "nose": 1.9, "duration": 2.0, "duration_lift": 1.27e-3, "upper_duration": 1.28,
                              "upper_lift": 5e-3}),
    "measured": (Measured, {"cam_angles": tuple(np.linspace(0, 2, 41)), "lifts": tuple(5e-3 * np.sin(np.linspace(0, np.pi, 41)) ** 4)}),
    "pieces": (PeriodicPieces, {"breaks": np.array([0.0, 2 * np.pi]), "coefficients": np.zeros((1, 6))}),
    "polydyne": (Polydyne, {"maximum_lift": 0.01, "opening_start": 0.5, "closing_end": 2.5, "ramp_lift": 2e-4, "ramp_length": 0.3}),
    "ramped": (ramped, MEAN_OF_LIFT | {"event_end": 2.9, "ramp_end": 3.3}),
    "shaped": (Shaped, MEAN_OF_LIFT | {"nose": 1.8, "flank_shape": (1.0, 1.0, -1.0, -1.0, -1.0)}),
    "sine power": (SinePower, {"maximum_lift": 0.01, "opening_start": 0.5, "closing_end": 2.5}),
    "spline": (Spline, TABLE),
    "stations": (Stations, TABLE | {"velocities": (0.0, 5e-3, 0.0, -5e-3, 0.0), "accelerations": (0.0,) * 5}),
    "rebound": (rebound, {"damping_number": 0.1}),
    "damping number": (damping_number, {"restitution": 0.5}),
    "run-up": (lambda last_cam_speed, cam_acceleration: RunUp(last_cam_speed, cam_acceleration).duration(100.0),
               {"last_cam_speed": 200.0, "cam_acceleration": 50.0}),
    "contour": (table_from_samples, {"chi": np.linspace(0, 6, 50), "value": np.full(50, 0.02)}),
    "coordinate": (Coordinate, {"name": "valve", "mass": 0.1}),
    "link": (ElasticLink, {"stiffness": 1e6}),
    "Maxwell link": (MaxwellLink, {"stiffness": 0.0, "branch_stiffness": 1e6, "branch_damping": 10.0}),
    "mechanism": (AssembledMechanism, {"name": "one", "coordinates": (BODY,), "interactions": (SEAT,), "tables": {}, "valve": "valve",
                                       "retainer": "valve"}),
    "damping": (DampingParameters, {"ratio": 0.02, "ratio_frequency": 400.0}),
    "coil contact": (CoilContact, {}),
    "installed": (InstalledSpring, {"wire": SPRING}),
    "end": (EndCoil, {"kind": "closed"}),
    "gas": (GasLoad, {"cam_angles": (0.0, 1.0, 2.0, 3.0), "forces": (0.0, -100.0, -50.0, 0.0)}),
    "follower": (FollowerParameters, {"shape": "flat"}),
    "buckling": (buckling_compression, {"free_length": 0.08, "mean_diameter": 0.01}),
    "low pass": (low_pass, {"time": np.linspace(0, 1e-2, 101), "values": np.ones(101), "cutoff_frequency": 1000.0}),
    "chain": (uniform_chain, {"rate": 4e4, "mass": 0.05, "elements": 5}),
    "massless": (vt.springs.MasslessSpring, {"rate": 4e4, "preload": 300.0}),
    "massless table": (vt.springs.MasslessTable, {"displacements": (0.0, 0.01), "forces": (0.0, 300.0)}),
    "table of a wire": (massless_table, {"spring": SPRING, "precompression": 5e-3, "maximum_lift": 5e-3, "points": 5}),
    "modal-varied": (vt.springs.ModalVaried, {"natural_frequencies": (450.0, 900.0), "damping_ratio": 0.01, "compressions": (0.0, 0.02),
                                      "forces": (0.0, 800.0), "precompression": 5e-3}),
    "modal-uniform": (vt.springs.ModalUniform, {"spring": UNIFORM, "modes": 2, "natural_frequencies": (450.0, 900.0)}),
    "wave rod": (vt.springs.WaveRod, {"spring": UNIFORM}),
    "rod": (partial(vt.springs.FiniteElementRod, SPRING), {"precompression": 5e-3, "elements_per_coil": 6}),
    "multi-mass": (partial(vt.springs.MultiMassSpring.from_definition, SPRING), {"precompression": 5e-3}),
    "card of masses": (vt.springs.MultiMassSpring.from_card, {"rate": 4e4, "preload": 300.0, "mass": 0.05}),
    "rubbing": (RadialRubbing, {"coefficient": 0.1, "normal_force": 5.0}),
    "transient": (TransientJob, {"lift_law": None, "engine_speed": 100.0, "precompression": 5e-3, "first_angle": 0.0, "last_angle": 1.0}),
    "mesh": (MeshOptions, {}),
    "order": (observed_order, {"values": (1.0, 1.5, 1.6), "sizes": (4.0, 2.0, 1.0)}),
    "prior": (vt.explore.Prior, {"kind": "normal", "low": 1.0, "high": 3.0, "centre": 2.0, "spread": 0.5}),
    "material": (Material, {"name": "steel", "youngs_modulus": 206e9, "shear_modulus": 79e9, "density": 7850.0}),
    "definition": (SpringDefinition, {"wire_diameter": Constant(3.8e-3), "mean_diameter": Constant(22e-3), "pitch": SPRING.pitch,
                                         "total_coils": 7, "material": SPRING.material}),
    "curve": (PiecewiseLinear, {"coils": (0, 7), "values": (0.007, 0.008)}),
    "smooth curve": (Table, {"coils": (0, 7), "values": (0.007, 0.008)}),
}  # fmt: skip
#: Part, one change of it, words of the refusal.
REFUSED: list[tuple[str, dict[str, Any], str]] = [
    *(("three-arc", {name: value}, "must be positive") for name in ("base_radius", "nose_radius", "maximum_lift") for value in (0.0, -1.0)),
    ("three-arc", {"follower_radius": -1e-3}, "must be positive"),
    ("three-arc", {"nose_radius": 0.024}, "a circle and no lobe"),
    ("three-arc", {"opening_start": 2.0}, "less than half a cam revolution"),
    ("three-arc", {"opening_start": 2.0 - math.pi}, "less than half a cam revolution"),
    ("three-arc", {"opening_start": 1.5}, "no convex flank arc"),
    ("tangent", {"follower_radius": 0.0}, "needs a roller or dome"),
    ("tangent", {"nose_radius": 0.0151}, "smaller than base_radius"),
    ("half event", {"flank_radius": 0.015}, "cannot touch both"),
    ("half event", {"flank_radius": 0.5e-3}, "cannot touch both"),
    ("longer card", {"upper_duration": 2.1}, "must be longer and at a lower lift"),
    ("longer card", {"upper_lift": 1e-3}, "must be longer and at a lower lift"),
    ("cam card", {"duration_lift": -1e-3}, "must be below the lobe lift"),
    ("cam card", {"duration_lift": 9.5e-3}, "must be below the lobe lift"),
    ("cam card", {"duration": 0.0}, "must be below the lobe lift"),
    ("cam card", {"duration": 6.3}, "must be below the lobe lift"),
    ("cam card", {"ramp_lift": 0.0}, "ramp_lift must be between"),
    ("cam card", {"ramp_lift": 0.0091}, "ramp_lift must be between"),
    ("cam card", {"ramp_velocity": 0.0}, "ramp_velocity be positive"),
    ("cam card", {"ramp_blend": 0.0}, "ramp_lift must be between"),
    ("cam card", {"ramp_blend": 1.01}, "ramp_lift must be between"),
    ("cam card", {"duration_lift": 1e-5}, "still gathers velocity"),
    ("cam card", {"ramp_velocity": 3e-5}, "longer than a cam revolution"),
    ("measured", {"lifts": (0.0, 1e-3)}, "one lift per angle"),
    ("measured", {"draw": -1}, "draw is a whole number"),
    ("measured", {"draw": 10_001}, "draw is a whole number"),
    ("pieces", {"coefficients": np.zeros(6)}, "rising breaks"),
    ("pieces", {"coefficients": np.zeros((2, 6))}, "rising breaks"),
    ("pieces", {"breaks": np.array([2 * np.pi, 0.0])}, "rising breaks"),
    ("pieces", {"breaks": np.array([0.0, 6.0])}, "exactly one cam revolution"),
    ("polydyne", {"closing_end": 0.5}, "within one cam revolution"),
    ("polydyne", {"closing_end": 0.5 + 2 * math.pi - 0.5}, "ramps included"),
    ("polydyne", {"ramp_lift": -1e-4}, "a ramp needs"),
    ("polydyne", {"ramp_lift": 0.011}, "a ramp needs"),
    ("polydyne", {"ramp_lift": 0.0}, "a ramp needs"),
    ("polydyne", {"ramp_length": 0.0}, "a ramp needs"),
    ("polydyne", {"ramp_blend": 0.0}, "a ramp needs"),
    ("polydyne", {"ramp_blend": 1.1}, "a ramp needs"),
    ("polydyne", {"exponents": (2, 9, 18, 26, 34)}, "must be even"),
    ("polydyne", {"exponents": (2,)}, "at least two exponents"),
    ("ramped", {"ramp_start": 0.7}, "must rise"),
    ("ramped", {"event_start": 2.9}, "must rise"),
    ("ramped", {"event_end": 3.3}, "must rise"),
    ("ramped", {"ramp_lift": 0.0}, "ramp_lift be below"), ("ramped", {"ramp_lift": 0.01}, "ramp_lift be below"),
    ("ramped", {"ramp_blend": 0.0}, "correct them"), ("ramped", {"ramp_blend": 1.1}, "correct them"),
    ("shaped", {"ramp_start": 0.7}, "follow each other"), ("shaped", {"event_start": 1.8}, "follow each other"),
    ("shaped", {"ramp_start": 1.79 - math.pi}, "within half a cam revolution"),
    ("shaped", {"ramp_lift": 0.0}, "between zero and maximum_lift"), ("shaped", {"ramp_lift": 0.01}, "between zero and maximum_lift"),
    ("shaped", {"ramp_blend": 0.0}, "ramp_blend between 0 and 1"), ("shaped", {"ramp_blend": 1.0}, "ramp_blend between 0 and 1"),
    ("shaped", {"flank_shape": (1.0, 1.0, -1.0)}, "four values or more"),
    ("shaped", {"flank_shape": (-1.0, 1.0, -1.0, -1.0)}, "first positive"),
    ("shaped", {"flank_shape": (1.0, 1.0, 1.0, 1.0)}, "first positive"),
    ("shaped", {"flank_shape": (1.0, -1.0, 1.0, -1.0)}, "first positive"),
    ("shaped", {"flank_shape": (0.0, 0.0, -1.0, -1.0)}, "first positive"),
    ("shaped", {"maximum_lift": 4e-4}, "cannot reach maximum_lift"),
    ("shaped", {"event_end": 1.8}, "must follow the nose"), ("shaped", {"event_end": 4.9}, "must follow the nose within half"),
    ("shaped", {"event_end": 4.2}, "cannot close by event_end"),
    ("shaped", {"event_end": math.nextafter(1.8, 4.0)}, "cannot close by event_end"),
    ("shaped", {"event_end": 2.9, "flank_shape": (1.0, 0.8, 0.5, -1.0)}, "flank_shape needs a negative value before its last"),
    ("shaped", {"closing_flank_shape": (1.0, 0.8, 0.5, -1.0)}, "closing_flank_shape needs a negative value before"),
    ("shaped", {"closing_flank_shape": (1.0, 0.8, -1.0)}, "closing_flank_shape needs four values or more"),
    ("shaped", {"closing_flank_shape": (1.0, 0.8, -1.0, -1.0, math.nan)}, "closing_flank_shape needs four values or more"),
    ("shaped", {"closing_flank_shape": (1.0, -0.8, 1.0, -1.0)}, "closing_flank_shape needs four values or more"),
    ("shaped", {"event_end": 4.2, "closing_flank_shape": (1.0, 1.0, -1.0, -1.0, -1.0)}, "closing_flank_shape cannot close by event_end"),
    ("sine power", {"closing_end": 0.5}, "must follow opening_start"), ("sine power", {"closing_end": 7.0}, "must follow opening_start"),
    ("sine power", {"power": 1}, "power be 2 or more"),
    ("spline", {"lifts": (0.0, 0.0)}, "each with one lift"),
    ("spline", {"cam_angles": (0.5, 1.0, 1.5), "lifts": (0.0, 1e-3, 0.0)}, "four stations or more"),
    ("spline", {"cam_angles": (0.5, 1.0, 1.0, 2.0, 2.5)}, "must rise in angle"),
    ("spline", {"cam_angles": (0.5, 1.0, 1.5, 2.0, 7.0)}, "within one cam revolution"),
    ("spline", {"lifts": (1e-3, 2e-3, 5e-3, 2e-3, 0.0)}, "begin and end on the base circle"),
    ("spline", {"lifts": (0.0, 2e-3, 5e-3, 2e-3, 1e-3)}, "begin and end on the base circle"),
    *(("stations", {name: (first, 1e-3, 5e-3, 1e-3, last)}, "must rest on the base circle")
      for name in ("lifts", "velocities", "accelerations") for first, last in ((1e-3, 0.0), (0.0, 1e-3))),
    ("stations", {"cam_angles": (0.5, 1.0, 1.0, 2.0, 2.5)}, "must rise in angle"),
    ("stations", {"cam_angles": (0.5, 1.0, 1.5, 2.0, 7.0)}, "within one cam revolution"),
    ("rebound", {"damping_number": -0.1}, "zero or a positive"), ("rebound", {"damping_number": NAN}, "zero or a positive"),
    ("damping number", {"restitution": 0.0}, "above 0"), ("damping number", {"restitution": 1.01}, "at most 1"),
    ("run-up", {"cam_acceleration": -50.0}, "must lead"), ("run-up", {"cam_acceleration": math.inf}, "must lead"),
    ("run-up", {"last_cam_speed": -10.0, "cam_acceleration": -50.0}, "must lead"),
    ("contour", {"chi": np.append(np.linspace(0, 6, 49), 5.0)}, "folds back"), ("contour", {"chi": np.linspace(0, 6.3, 50)}, "folds back"),
    *(("coordinate", {"mass": value}, "must be positive") for value in (0.0, -0.1, NAN, math.inf)),
    ("coordinate", {"damping": -1.0}, "must not be negative"), ("coordinate", {"friction": -1.0}, "must not be negative"),
    ("coordinate", {"friction_velocity": 0.0}, "must be positive"),
    ("coordinate", {"mass": 0.0, "unit": "rad"}, "moment of inertia"),
    ("link", {"stiffness": 0.0}, "must be positive"), ("link", {"damping": -1.0}, "must not be negative"),
    *(("Maxwell link", {"stiffness": value}, "zero or positive") for value in (-1.0, math.inf)),
    *(("Maxwell link", {name: value}, "must be positive") for name in ("branch_stiffness", "branch_damping") for value in (0.0, math.inf)),
    ("mechanism", {"coordinates": (BODY, BODY)}, "names a coordinate twice"),
    ("mechanism", {"coordinates": (Coordinate("lever", 0.1),)}, "joins unknown coordinates"),
    ("mechanism", {"interactions": (Interaction("cam", 0, ("valve", "", "", ""), (), ElasticLink(1.0), "lift"),)}, "which is missing"),
    ("damping", {"ratio": 1.0}, "no light damping"), ("damping", {"ratio_frequency": 0.0}, "above zero"),
    ("damping", {"ratio": None, "ratio_frequency": None, "stiffness_share": 0.5}, "splits a damping ratio"),
    ("damping", {"stiffness_share": 1.1}, "between 0"), ("damping", {"stiffness_share": -0.1}, "at least zero"),
    ("damping", {"mass_damping": 1000.0}, "damps more than the ratio"), ("damping", {"stiffness_damping": 1e-3}, "damps more than"),
    ("damping", {"mass_damping": 10.0, "stiffness_damping": 1e-7}, "give the damping one way"),
    ("damping", {"mass_damping": 2 * 0.02 * 2 * math.pi * 400, "stiffness_damping": 0.0, "stiffness_share": 0.5}, "one way"),
    *(("coil contact", {name: value}, f"{name} of the coil contact")
      for name in ("stiffness", "damping_time")
      for value in (-1.0, math.inf)),
    ("installed", {"retainer_rotation": "loose"}, "loose"), ("installed", {"seats": "walls"}, "'planes' or 'clamps'"),
    ("installed", {"wire": None}, "give one of them"),
    ("end", {"inactive_coils": -0.1}, "at least zero"), ("end", {"inactive_coils": 3.1}, "at most 3"),
    ("end", {"ground_coils": -0.1}, "at least zero"), ("end", {"ground_coils": 3.1}, "at most 3"),
    ("gas", {"forces": (0.0, 1.0, 0.0)}, "as many forces"), ("gas", {"cam_angles": (0.0, 1.0), "forces": (0.0, 0.0)}, "at least three"),
    ("gas", {"cam_angles": (0.0, 1.0, 1.0, 2.0)}, "must increase"), ("gas", {"cam_angles": (0.0, 1.0, 2.0, 6.3)}, "less than one cam revolution"),
    ("follower", {"shape": "round"}, "is not among"), ("follower", {"shape": "roller"}, "needs a positive radius"),
    ("follower", {"shape": "domed"}, "needs a positive radius"), ("follower", {"radius": 0.01}, "has no radius"),
    ("follower", {"shape": "knife", "radius": 0.01}, "has no radius"),
    ("follower", {"tilt": 0.53}, "below 30 degrees"), ("follower", {"tilt": -0.53}, "below 30 degrees"),
    *(("follower", {name: value}, "at least zero" if value < 0 else "not a finite number")
      for name in ("mass", "damping", "friction") for value in (-1.0, math.inf)),
    ("buckling", {"free_length": -0.08}, "free_length"), ("buckling", {"free_length": 80.0}, "free_length"),
    ("buckling", {"mean_diameter": 0.0}, "mean_diameter"),
    *(("buckling", {"seating_coefficient": value}, "must be positive") for value in (0.0, math.inf)),
    ("low pass", {"time": np.linspace(0, 1, 2), "values": np.ones(2)}, "evenly spaced"),
    ("low pass", {"time": np.linspace(0, 0.1, 101) ** 2}, "evenly spaced"),
    ("low pass", {"cutoff_frequency": 5000.1}, "refine the output step"),
    ("chain", {"elements": 1}, "no inner mass"), ("chain", {"rate": 0.0}, "positive rate and mass"),
    ("chain", {"mass": 0.0}, "positive rate and mass"),
    ("massless", {"rate": 0.0}, "rate"),
    ("massless", {"rate": math.inf}, "not a finite number"),
    ("massless", {"preload": -1.0}, "preload"),
    ("massless", {"active_mass": -1.0}, "mass"), ("massless", {"inactive_mass": -1.0}, "mass"),
    ("massless table", {"forces": (0.0, 300.0, 500.0)}, "at least two points"),
    ("massless table", {"displacements": (0.0,), "forces": (0.0,)}, "at least two points"),
    ("massless table", {"displacements": (0.01, 0.0)}, "must rise"), ("massless table", {"forces": (300.0, 0.0)}, "must rise"),
    *(("massless table", {name: (0.0, math.inf)}, "not a finite number") for name in ("displacements", "forces")),
    *((part, {name: math.inf}, "not a finite number") for part, name in (("rod", "precompression"), ("wave rod", "friction"),
      ("multi-mass", "mass_damping"), ("modal-uniform", "mass_damping"), ("massless", "active_mass"))),
    ("table of a wire", {"maximum_lift": 0.0}, "a positive lift"), ("table of a wire", {"points": 2}, "3 points or more"),
    ("modal-varied", {"natural_frequencies": ()}, "positive, rising natural"),
    ("modal-varied", {"natural_frequencies": (-1.0, 900.0)}, "positive, rising natural"),
    ("modal-varied", {"natural_frequencies": (900.0, 450.0)}, "positive, rising natural"),
    ("modal-varied", {"forces": (0.0, 400.0, 800.0)}, "two or more points"),
    ("modal-varied", {"compressions": (0.0,), "forces": (0.0,)}, "two or more points"),
    ("modal-varied", {"compressions": (0.02, 0.0)}, "two or more points"),
    ("modal-varied", {"precompression": 0.0}, "needs a preloaded"),
    ("modal-uniform", {"natural_frequencies": (0.0, 900.0)}, "positive and rising"),
    ("modal-uniform", {"natural_frequencies": (900.0, 450.0)}, "positive and rising"),
    *(("modal-uniform", {name: -1.0}, "zero or a positive") for name in ("mass_damping", "stiffness_damping")),
    ("wave rod", {"friction": -1.0}, "friction"),
    ("rod", {"retainer_rotation": "loose"}, "loose"), ("rod", {"precompression": -1e-3}, "zero or a positive length"),
    ("multi-mass", {"masses_per_coil": 0}, "whole number"), ("multi-mass", {"masses_per_coil": 2.5}, "whole number"),
    *(("multi-mass", {name: -1.0}, "zero or a positive") for name in ("mass_damping", "stiffness_damping", "contact_damping_time")),
    ("card of masses", {"preload": -1.0}, "zero or a positive force"),
    *(("rubbing", {name: value}, "zero or a positive") for name in ("coefficient", "normal_force") for value in (-1.0, math.inf)),
    ("transient", {"engine_speed": 0.0}, "positive engine speed"), ("transient", {"last_angle": 0.0}, "last cam angle beyond"),
    ("transient", {"time_step": 0.0}, "time step"),
    ("mesh", {"elements_per_coil": 3}, "cannot follow a helix"),
    ("mesh", {"end_refinement": 0.99}, "would coarsen"),
    ("mesh", {"ends": "glued"}, "use sections, bonded or ground"), ("mesh", {"element_type": "C3D4"}, "is not supported"),
    ("order", {"sizes": (4.0, 1.0, 1.0)}, "coarse to fine"), ("order", {"sizes": (2.0, 2.0, 1.0)}, "coarse to fine"),
    ("prior", {"centre": 0.9}, "outside the bounds 1 to 3"), ("prior", {"centre": 3.1}, "outside the bounds 1 to 3"),
    ("prior", {"spread": 0.0}, "positive spread"), ("prior", {"centre": float("nan")}, "finite middle and a positive spread"),
    ("prior", {"kind": "flat"}, "use one of uniform"), ("prior", {"high": 1.0}, "is not below high"),
    ("prior", {"kind": "uniform", "high": float("inf")}, "two finite bounds"),
    ("prior", {"kind": "log-uniform", "low": 0.0}, "of positive values"),
    *(("material", {name: value}, f"{name} of the material")
      for name in ("youngs_modulus", "shear_modulus", "density") for value in (0.0, -1.0)),
    ("material", {"shear_modulus": 60e9}, "outside -1 to 0.5"),
    ("definition", {"total_coils": "seven"}, "total_coils .* is not a number"), ("definition", {"total_coils": math.inf}, "not a finite number"),
    ("definition", {"total_coils": 0.0}, "total_coils .* above zero"), ("definition", {"hand": "both"}, "hand .* 'right' or 'left'"),
    ("definition", {"material": "steel"}, "is not in the library"),
    *((part, change, words) for part in ("curve", "smooth curve") for change, words in (
        ({"values": (0.007, 0.008, 0.009)}, "one value per coil"), ({"coils": (0,), "values": (0.007,)}, "at least two knots"),
        ({"coils": (0, NAN)}, "not a finite number"), ({"coils": (7, 0)}, "must increase"))),
]  # fmt: skip


@pytest.mark.parametrize("name", GIVEN)
def test_each_part_is_taken_as_it_stands(name):
    make, values = GIVEN[name]
    make(**values)
    assert name in {part for part, _, _ in REFUSED}


@pytest.mark.parametrize(
    ("name", "change", "words"),
    REFUSED,
    ids=[f"{part} {change}"[:60] for part, change, _ in REFUSED],
)
def test_one_change_is_refused_with_a_sentence(name, change, words):
    make, values = GIVEN[name]
    with pytest.raises(vt.InputError, match=words) as refusal:
        make(**values | change)
    assert len(str(refusal.value)) > 20


#: Just within a bound: part and change that is taken.
TAKEN: list[tuple[str, dict[str, Any]]] = [
    ("three-arc", {"nose": 2.0, "opening_start": 0.9}), ("tangent", {"nose_radius": 0.0149}), ("cam card", {"ramp_blend": 1.0}),
    ("cam card", {"ramp_lift": 1e-5, "duration_lift": 1e-4, "duration": 2.4}), ("measured", {"draw": 10_000}), ("measured", {"draw": 1}),
    ("polydyne", {"ramp_blend": 1.0}), ("polydyne", {"ramp_lift": 0.0, "ramp_length": 0.0}), ("polydyne", {"exponents": (2, 4)}),
    ("ramped", {"ramp_blend": 1.0}), ("ramped", {"ramp_lift": 1e-6}), ("shaped", {"flank_shape": (0.0, 1.0, -1.0, 0.0)}),
    ("sine power", {"power": 2}), ("sine power", {"opening_start": 0.0, "closing_end": 2 * math.pi}),
    ("spline", {"cam_angles": (0.5, 1.0, 2.0, 2.5), "lifts": (0.0, 2e-3, 2e-3, 0.0)}),
    ("stations", {"cam_angles": (0.0, 1.0, 2.0, 3.0, 2 * math.pi)}), ("rebound", {"damping_number": 0.0}),
    ("damping number", {"restitution": 1.0}),
    ("run-up", {"last_cam_speed": 0.5, "cam_acceleration": -50.0}), ("coordinate", {"mass": 0.5}),
    ("coordinate", {"friction_velocity": 0.5}),
    ("link", {"stiffness": 0.5}), ("Maxwell link", {"branch_stiffness": 0.5, "branch_damping": 0.5}), ("damping", {"ratio": 0.999}),
    ("damping", {"ratio_frequency": 0.5}), ("damping", {"stiffness_share": 0.0}), ("damping", {"stiffness_share": 1.0}),
    ("coil contact", {"stiffness": 0.0, "damping_time": 0.0}), ("end", {"inactive_coils": 0.0, "ground_coils": 0.0}),
    ("end", {"inactive_coils": 3.0, "ground_coils": 3.0}), ("gas", {"cam_angles": (0.0, 1.0, 2.0), "forces": (0.0, -1.0, 0.0)}),
    ("gas", {"cam_angles": (0.0, 1.0, 2.0, 6.28)}), ("follower", {"tilt": 0.52}), ("follower", {"tilt": -0.52}),
    ("follower", {"mass": 0.0, "damping": 0.0, "friction": 0.0}), ("low pass", {"cutoff_frequency": 4999.0}), ("chain", {"elements": 2}),
    ("chain", {"rate": 0.5, "mass": 0.5}), ("massless", {"rate": 101.0, "preload": 0.0}), ("table of a wire", {"points": 3}),
    ("modal-varied", {"natural_frequencies": (0.5, 900.0)}), ("modal-uniform", {"natural_frequencies": (0.5, 900.0)}),
    ("modal-uniform", {"mass_damping": 0.0, "stiffness_damping": 0.0}), ("wave rod", {"friction": 0.0}), ("rod", {"precompression": 0.0}),
    ("multi-mass", {"masses_per_coil": 1}), ("card of masses", {"preload": 0.0}), ("rubbing", {"coefficient": 0.0, "normal_force": 0.0}),
    ("transient", {"engine_speed": 0.5, "last_angle": 0.5}), ("prior", {"centre": 1.0}), ("prior", {"centre": 3.0}),
    ("mesh", {"elements_per_coil": 4, "end_refinement": 1.0}),
    ("material", {"shear_modulus": 69e9}),
    ("mechanism", {"interactions": ()}),
]  # fmt: skip


@pytest.mark.parametrize(
    ("name", "change"), TAKEN, ids=[f"{part} {change}"[:60] for part, change in TAKEN]
)
def test_what_lies_within_a_bound_is_taken(name, change):
    make, values = GIVEN[name]
    make(**values | change)
