"""Studies with made-up numbers that can be told from each other: a spring of one's own with a
clash, a train, a sweep, a published case.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import xarray

from synthetic_spring import ENGINE_SPEED, bump
from valvetrain.solution.channels import spring_channels
from valvetrain.solution.critical import (
    CriticalSpeed,
    CriticalSpeeds,
    RangeMember,
    SpeedBracket,
)
from valvetrain.solution.modes import ModalResult
from valvetrain.solution.provenance import CaseRecord, Provenance, PublishedValue
from valvetrain.solution.result import Solution
from valvetrain.solution.static import SpringAtRest, StaticCurve, StaticStress
from valvetrain.solution.status import COMPLETED, Event, Status
from valvetrain.solution.study import LiftEvent, Study
from valvetrain.solution.uncertainty import Comparison, Finding

SPEED = ENGINE_SPEED
COILS = np.arange(0.0, 7.25, 0.5)
PAIRS = np.arange(1.0, 7.25, 0.5)
EVENT = LiftEvent(np.radians(127.0), np.radians(233.0))
CITED = ("A. Author: On made-up springs. Journal of Tests 1 (2020)",)


def clash(number: int) -> Event:
    """The clash of that number, each weaker than the one before."""
    details = {
        "upper_coil": 2.0,
        "lower_coil": 1.0,
        "peak_cam_angle": np.radians(250.0 + number),
        "impulse": 0.031 / number,
        "energy": 0.017 / number,
    }
    return Event(
        "clash",
        np.radians(249.0 + number),
        0.01 + number * 1e-4,
        2e-5,
        345.0 / number,
        "N",
        "",
        details,
    )


def rod_run(
    engine_speed: float = SPEED,
    samples: int = 720,
    status: Status = COMPLETED,
    label: str = "",
    bounces: int = 7,
) -> Solution:
    """Two turns of a spring with a clash at 250 degrees, four substeps a sample in its force."""
    angle = np.arange(2 * samples) * 2 * np.pi / samples
    degrees = np.degrees(angle) % 360
    lift = 9e-3 * bump(degrees, 180, 106)
    fine = np.degrees(angle[:, None] + np.arange(4) * np.pi / 2 / samples) % 360
    force = (
        300
        + 500 * bump(fine, 180, 106)
        + 400 * bump(fine, 250, 3)
        + 12 * np.sin(np.radians(13 * fine))
    )
    share = COILS / 7
    moved = (
        -lift[:, None] * share
        + 1e-4 * np.sin(np.pi * share) * np.sin(np.radians(13 * degrees))[:, None]
    )
    work = np.cumsum(np.gradient(lift)) * 300
    shear = (300e6 + 250e6 * bump(degrees, 180, 106))[:, None] * (1 - 0.02 * np.abs(COILS - 3.5))
    values = {
        "valve_lift": lift, "retainer_velocity": 100 * np.gradient(lift), "retainer_acceleration": 1e4 * np.gradient(np.gradient(lift)),
        "seat_force": force[:, 0], "retainer_force": force[:, 0] + 21.0, "static_retainer_force": 300 + 40e3 * lift,
        "axial_displacement": moved, "axial_velocity": 10 * moved, "axial_acceleration": 1e3 * moved,
        "axial_position": 6e-3 * COILS + moved,
        "coil_gap": 1e-3 - 1.1e-3 * bump(degrees, 250, 3)[:, None] * (PAIRS < 2.6),
        "coil_contact_force": 200 * bump(degrees, 250, 3)[:, None] * (PAIRS < 2.6), "kinetic_energy": 0 * lift,
        "elastic_energy": work, "work_done": 1.001 * work, "energy_dissipated": 0 * lift, "seat_force_fine": force,
        "inner_fibre_shear_stress": shear,
    }  # fmt: skip
    extra = {
        "seat_force_fine": (("subsample",), "N", "seat force between the samples"),
        "static_retainer_force": ((), "N", "static force at the same lift"),
        "inner_fibre_shear_stress": (("wire_point",), "Pa", "shear at the inner fibre"),
    }
    channels = spring_channels(
        angle / (engine_speed / 2), angle, values, coil_number=COILS, upper_coil=PAIRS, extra=extra
    )
    found = {
        "peak_spring_force": 811.0, "minimum_spring_force": 288.0, "peak_retainer_force": 832.0, "minimum_retainer_force": 309.0,
        "coil_bind_clearance": 1.25e-3, "surge_frequency": 631.0, "surge_cam_order": 13.52, "nearest_lift_harmonic_order": 14.0,
        "nearest_lift_harmonic_lift": 2.3e-6, "surge_amplitude_force": 47.0, "clash_count": float(bounces), "clash_energy": 0.044,
        "largest_clash_impulse": 0.031, "peak_shear_stress": 551e6, "minimum_shear_stress": 299e6,
    }  # fmt: skip
    origin = Provenance(
        "own-spring",
        "finite-element",
        engine_speed,
        "abc",
        "1.0",
        "3.12",
        {"numpy": "2.0"},
        {"elements_per_coil": 24},
        "",
        CITED,
        label,
        "",
        "prescribed-spring",
    )
    return Solution(
        channels,
        tuple(clash(number + 1) for number in range(bounces)),
        status,
        {"steps": 10},
        origin,
        found,
    )


def modal_run(engine_speed: float = SPEED, samples: int = 720) -> Solution:
    """The same without coils."""
    angle = np.arange(samples) * 2 * np.pi / samples
    force = 300 + 500 * bump(np.degrees(angle), 180, 106)
    values = {
        "valve_lift": 9e-3 * bump(np.degrees(angle), 180, 106),
        "seat_force": force,
        "retainer_force": force + 1,
    }
    channels = spring_channels(angle / (engine_speed / 2), angle, values)
    origin = Provenance("own-spring", "modal-varied", engine_speed, system="prescribed-spring")
    found = {
        "peak_spring_force": 800.0,
        "minimum_spring_force": 299.0,
        "open_nominal_shear_stress": 533e6,
        "closed_nominal_shear_stress": 201e6,
    }
    return Solution(channels, provenance=origin, quantities=found)


def at_rest() -> tuple[SpringAtRest, ...]:
    """Curve, modes and stress by the rod; a curve and modes 2 % softer by the multi-mass chain."""
    steps = np.linspace(0, 18e-3, 40)
    gap = (12e-3 - steps)[:, None] * np.ones(len(PAIRS))
    curve = StaticCurve(
        steps,
        41e3 * steps,
        np.full(40, 41e3),
        gap,
        0 * gap,
        PAIRS,
        np.ones((40, len(COILS))),
        COILS,
    )
    none = np.zeros((40, 0))
    other = StaticCurve(
        steps,
        0.98 * 41e3 * steps,
        np.full(40, 0.98 * 41e3),
        none,
        none,
        np.zeros(0),
        none,
        np.zeros(0),
    )
    shape = np.zeros((5, len(COILS), 3))
    for number, mode in enumerate((1, 2, 4), start=1):
        shape[mode, :, 2] = -np.sin(np.pi * number * COILS / 7)
    shape[1] /= np.abs(shape[1]).max()
    modes = ModalResult(
        7e-3,
        np.array([400, 631, 1120, 1300, 1639.0]),
        shape,
        COILS,
        np.array([0.01, 1, -0.7, 0.1, 0.5]),
        (1, 2, 4),
    )
    chain = ModalResult(
        7e-3,
        np.array([620.0, 1210.0]),
        np.zeros((2, 0, 3)),
        np.zeros(0),
        np.array([1.0, 0.8]),
        (0, 1),
    )
    stress = StaticStress(
        steps,
        COILS,
        41e9 * steps[:, None] * np.ones(len(COILS)),
        70e9 * steps[:, None] * np.ones(len(COILS)),
    )
    first = SpringAtRest(
        "spring", "finite-element", 7e-3, curve, modes, stress, {"elements per coil": 24}, 0.4
    )
    return first, SpringAtRest("spring", "multi-mass", 7e-3, other, chain)


def record(**more) -> CaseRecord:
    """A case of one's own."""
    made = CaseRecord(
        "own-spring",
        "Spring of my own",
        "A spring. It is made up.",
        citations=CITED,
        text='name = "own"\n',
        digest="0123456789abcdef",
    )
    return replace(made, **more)


def own_study(solutions: tuple[Solution, ...] | None = None) -> Study:
    """A spring of one's own at two engine speeds by two models, as ``run`` or ``compare`` give it."""
    slow = 4200 * np.pi / 30
    runs = (
        (rod_run(slow, bounces=0), rod_run(), modal_run(slow), modal_run())
        if solutions is None
        else solutions
    )
    still = {"": {"preload": 287.0, "coil_bind_lift": 10.25e-3}}
    return Study(
        record(),
        "compare",
        runs,
        at_rest(),
        still,
        lift_event=EVENT,
        provenance=Provenance("own-spring", ""),
    )


def published_study() -> Study:
    """The beehive's words: published values, findings and notes beside the runs above."""
    published = (
        PublishedValue(
            "stage_2_peak_force",
            790.0,
            "N",
            "table 3",
            engine_speed=SPEED,
            model="solid finite elements",
            tolerance=20.0,
        ),
        PublishedValue(
            "stage_2_peak_cam_angle",
            3.1,
            "deg",
            "table 3",
            engine_speed=SPEED,
            model="solid finite elements",
        ),
        PublishedValue(
            "node_2_peak_velocity",
            3.3,
            "m/s",
            "figure 9",
            engine_speed=SPEED,
            model="engine head test",
        ),
    )
    rows = tuple(
        Comparison(
            "stage_2_peak_force",
            speed,
            "finite-element",
            origin,
            "N",
            790.0,
            790.0 * ratio,
            790.0 * (ratio - 1),
            role,
            20.0,
            "within",
            "gu2021, table 3",
        )
        for speed, origin, ratio, role in (
            (SPEED, "solid finite elements", 1.02, "prediction"),
            (SPEED, "engine head test", 0.93, "prediction"),
            (None, "analytical modal", 1.91, "calibration"),
        )
    )
    notes = (
        "The first note <for> readers.",
        "A second one. It goes on. And on. Up to five sentences.",
    )
    findings = (Finding("section 4", "Stage II has a valley", "valley of 412 N", "holds"),)
    return replace(
        own_study(),
        record=record(name="gu2021-beehive-blind", study="gu2021", published=published),
        comparisons=rows,
        findings=findings,
        notes=notes,
    )


def train_run(
    engine_speed: float = SPEED, label: str = "stock, multi-mass", spring_set: str = "stock"
) -> Solution:
    """One cycle of a train with a nested pair: every channel has a number of its own."""
    angle = np.arange(360) * 2 * np.pi / 360
    degrees = np.degrees(angle)
    lift = 9e-3 * bump(degrees, 180, 106)
    speed = 100 * np.gradient(lift)
    one = {
        "valve_lift": (lift, "m"), "valve_velocity": (speed, "m/s"), "valve_acceleration": (100 * np.gradient(speed), "m/s2"),
        "seat_force": (301 + 40e3 * lift, "N"), "retainer_force": (302 + 40e3 * lift, "N"),
        "static_retainer_force": (303 + 40e3 * lift, "N"), "rigid_valve_lift": (1.01 * lift, "m"),
        "rigid_contact_force": (705 + 1e4 * lift, "N"), "rigid_hertz_pressure": (6.6e8 + 0 * lift, "Pa"),
        "cam_contact_force": (704 + 1e4 * lift, "N"), "valve_tip_contact_force": (605 + 1e4 * lift, "N"),
        "seat_contact_force": (506 - 5e4 * lift, "N"), "support_force": (-407 + 0 * lift, "N"),
        "cam_torque": (8.0 * np.sin(2 * angle), "N m"), "lever_speed": (20.0 * np.cos(angle), "rad/s"),
        "rigid_spring_force": (299 + 41e3 * lift, "N"),
        "rigid_spring_margin": (250 + 30e3 * lift, "N"), "cam_contact_pressure": (6.5e8 + 1e10 * lift, "Pa"),
        "crank_angle": (2 * (np.mod(angle - 3 + np.pi, 2 * np.pi) - np.pi), "rad"),
        "piston_clearance": (3e-3 - 0.2 * lift, "m"), "outer_retainer_force": (202 + 30e3 * lift, "N"),
        "inner_retainer_force": (100 + 10e3 * lift, "N"),
    }  # fmt: skip
    places = np.arange(4.0)
    moved = lift[:, None] * (places / 3)
    variables = {
        name: (("sample",), values, {"units": unit, "long_name": name})
        for name, (values, unit) in one.items()
    }
    for spring, size in (("outer", 1.0), ("inner", 0.5)):
        words = {"units": "m", "long_name": f"{spring} displacement"}
        variables[f"{spring}_axial_displacement"] = (
            ("sample", f"{spring}_wire_point"),
            size * moved,
            words,
        )
    coords = {
        "time": (("sample",), angle / (engine_speed / 2), {"units": "s", "long_name": "time"}),
        "cam_angle": (("sample",), angle, {"units": "rad", "long_name": "cam angle"}),
    } | {
        f"{spring}_coil_number": (
            (f"{spring}_wire_point",),
            places,
            {"units": "1", "long_name": "share"},
        )
        for spring in ("outer", "inner")
    }
    found = {
        "peak_retainer_force": 662.0, "minimum_retainer_force": 302.0, "outer_coil_bind_clearance": 2.1e-3, "seating_velocity": 0.37,
        "bounce_height": 1.1e-5, "bounce_count": 2.0, "loft_gap": 4e-5, "loss_of_contact_duration": 3e-4, "clash_count": 0.0,
        **{f"surge_order_{n}_force": 30.0 / n for n in range(1, 25)}, "surge_frequency": 560.0,
    }  # fmt: skip
    seating = Event(
        "seating", np.radians(236.0), 0.01, 1e-4, 0.37, "m/s", "seat", {"cause": "end of the ramp"}
    )
    origin = Provenance(
        "own-train",
        "multi-mass",
        engine_speed,
        label=label,
        spring_set=spring_set,
        system="train",
        springs=("outer", "inner"),
        citations=CITED,
    )
    return Solution(
        xarray.Dataset(variables, coords), (seating,), COMPLETED, {"steps": 720}, origin, found
    )


def train_study() -> Study:
    """A train with two spring sets at one engine speed."""
    runs = (train_run(), train_run(label="race, multi-mass", spring_set="race"))
    return Study(
        record(name="own-train", title="Train of my own"),
        "run",
        runs,
        still={"": {"rigid_contact_loss_engine_speed": 700.0}},
        lift_event=EVENT,
    )


def sweep_study(speeds: int = 12) -> Study:
    """Reduced runs of two labels whose surge passes order 8 on the way; the last speed of each does
    not settle.
    """
    runs = []
    for label, stiff in (("stock", 1.0), ("<race & co>", 1.2)):
        for number, engine_speed in enumerate(np.linspace(2000, 8000, speeds) * np.pi / 30):
            order = 560 * stiff * 4 * np.pi / engine_speed
            sizes = {
                f"surge_order_{n}_force": 5 + 60 / (1 + (n - order) ** 2) for n in range(1, 25)
            }
            found = sizes | {
                "peak_spring_force": 600 + 20.0 * number * stiff,
                "minimum_spring_force": 280 - 9.0 * number,
                "clash_energy": 1e-3 * number * stiff,
                "surge_amplitude_force": max(sizes.values()),
                "seating_velocity": 0.2 + 0.02 * number,
                "lift_loss_displacement": 1e-5 * number,
                "surge_frequency": 560 * stiff,
            }
            status = (
                Status("not-converged", "the motion did not repeat")
                if number == speeds - 1
                else COMPLETED
            )
            whole = replace(train_run(engine_speed, label, ""), status=status, quantities=found)
            runs.append(whole.reduced())
    return Study(
        record(name="own-train", title="Train of my own"),
        "sweep",
        tuple(runs),
        still={"stock": {"float_engine_speed": 701.0}},
        lift_event=EVENT,
        critical_speeds=critical_speeds(),
    )


def critical_speeds() -> CriticalSpeeds:
    """Answers for ``stock`` alone: contact is lost and regained, and again; float with a
    hysteresis and its ranges; no bounce.
    """

    first, last = 2000 * np.pi / 30, 8000 * np.pi / 30
    ranges = SpeedBracket(650.0, 680.0), SpeedBracket(690.0, last)
    return CriticalSpeeds(
        (
            CriticalSpeed("stock", "contact-loss", 0.0, first, last, ranges, ("cam",), 0, 31),
            CriticalSpeed(
                "stock",
                "float",
                5e-5,
                first,
                last,
                (SpeedBracket(700.4, last),),
                ("valve",),
                0,
                23,
                (
                    RangeMember("mesh", "×1.5", 700.1),
                    RangeMember("model", "multi-mass", 680.0),
                    RangeMember("damping", "×1.5", 720.0),
                ),
                onset="sharp",
                falling_engine_speed=680.0,
            ),
            CriticalSpeed("stock", "bounce", 1e-4, first, last),
        )
    )
