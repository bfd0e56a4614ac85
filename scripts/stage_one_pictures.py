"""The pictures of docs/decisions/0077-why-stage-one-is-small.md; stage_one.py draws them."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from stage_one import (
    CURVES,
    GROUPS,
    INSTALLED,
    SHIPPED,
    Change,
    ends,
    installed_at,
    moved,
    rates,
    read,
)
from stage_one_parts import (
    CASE,
    LAW,
    SPEEDS,
    WIRE,
    Scaled,
    linear_force,
    rod_of,
    tuned,
    vibration,
    with_clearance,
    with_coils,
)

import valvetrain as vt
from valvetrain.cosserat.modes import natural_modes
from valvetrain.quantities.cycle import reported_cycle
from valvetrain.report import theme
from valvetrain.report.chart import Chart, Layer, Line, Panel, Rule
from valvetrain.report.svg_chart import svg
from valvetrain.solution.atomic import write_text
from valvetrain.solution.result import Solution
from valvetrain.springs.finite_element import FiniteElementRod

Array = NDArray[np.float64]
PICTURES = Path(__file__).resolve().parents[1] / "docs" / "pictures"
BLUE, ORANGE, _, VIOLET, GREY = theme.SERIES[:5]


def draw() -> None:
    """Write all of them."""
    for chart in (trace_picture(), corner_picture(), energy_picture(), scan_picture()):
        write_text(PICTURES / f"{chart.key}.svg", svg(chart))


def over_stage_1(run_: Solution) -> tuple[Array, Array]:
    """Cam angle (deg) and seat force (N) of Stage I."""
    cycle = reported_cycle(run_)
    angle = np.degrees(cycle.cam_angle)
    return angle[angle <= 127], cycle.channel("seat_force")[angle <= 127]


def trace_picture() -> Chart:
    """Seat force of Stage I at the highest speed, from the linear spring to the rod."""
    rpm, spring = SPEEDS[-1], rod_of()
    modes = natural_modes(spring.statics, spring.installed.state, 24)
    angle, force = linear_force(
        modes.natural_frequency, modes.axial_transmission, modes.axial_stiffness, LAW, rpm
    )
    early = angle <= 127
    chain = vt.simulate(CASE, f"{rpm} rpm", spring_models=["multi-mass"]).solutions[0]
    layers = [
        Line(
            angle[early][::10],
            force[early][::10] + spring.installed.seat_force,
            "rod's own modes, linear",
            GREY,
            1.4,
            "dash",
        ),
        Line(*over_stage_1(chain), "chain: contact, no sway", VIOLET, 1.4),
        Line(*over_stage_1(moved(spring, rpm)), "rod", BLUE, 2.0),
        Line(
            *over_stage_1(moved(tuned(with_clearance(WIRE, 0.3e-3)), rpm)),
            "rod, clearance +0.3 mm",
            ORANGE,
            1.6,
        ),
    ]
    panel = Panel(
        "cam angle (cam degrees)",
        "seat force (N)",
        tuple(layers),
        f"{rpm} rpm",
        x_range=(0, 127),
        x_step=15,
    )
    return Chart(
        "stage-one-force",
        "Stage I of the beehive: the same lift, less and less of it left",
        "",
        (panel,),
        1,
        380,
    )


def corner_picture() -> Chart:
    """Tangent rate over the compression, and the force of Stage I that follows from where its
    corner lies.
    """
    static: list[Layer] = []
    moving: list[Layer] = []
    for words, more, colour in CURVES:
        spring = tuned(with_clearance(WIRE, 1e-3 * more)) if more else rod_of()
        static.append(Line(*rates(spring), words, colour, 1.8))
        moving.append(
            Line(*over_stage_1(moved(spring, SPEEDS[-1])), words, colour, 1.6, in_legend=False)
        )
    panels = (
        Panel(
            "compression (mm)",
            "tangent rate (N/mm)",
            tuple(static),
            "At rest",
            rules=(Rule("x", 7.0, "installed"),),
        ),
        Panel(
            "cam angle (cam degrees)",
            "seat force (N)",
            tuple(moving),
            f"Stage I, {SPEEDS[-1]} rpm",
            x_range=(0, 127),
            x_step=30,
        ),
    )
    return Chart(
        "stage-one-corner",
        "The corner of the force curve beside the installed height",
        "",
        panels,
        2,
        360,
    )


def energy_picture() -> Chart:
    """Where the energy of the closed valve stands, linear and in the rod."""
    panels, rpm = [], SPEEDS[-1]
    for words, law in (("linear theory", Scaled(LAW, 1e-3)), ("rod", LAW)):
        told, layers = vibration(rod_of(), rpm, law), []
        after = told.angle >= 271
        for (name, low, high), colour in zip(GROUPS, (BLUE, ORANGE, GREY), strict=True):
            series = np.array([told.share(at, low, high) for at in np.flatnonzero(after)])
            layers.append(
                Line(
                    told.angle[after][::2], series[::2], name, colour, 1.8, in_legend=words == "rod"
                )
            )
        panels.append(
            Panel(
                "cam angle (cam degrees)",
                "energy of the modes (mJ)",
                tuple(layers),
                words,
                x_range=(271, 450),
            )
        )
    return Chart(
        "stage-one-energy",
        f"Energy that vibrates with the valve closed, {rpm} rpm",
        "",
        tuple(panels),
        2,
        360,
    )


def over_compression() -> Panel:
    """First mode in Stage I over the compression at which the shipped wire is installed: rod and
    linear theory.
    """
    reach, rod, linear = np.array(INSTALLED), [], []
    for compression in INSTALLED:
        spring, told = installed_at(compression)
        linear.append(told)
        rod.append([read(moved(spring, rpm)).first_mode for rpm in SPEEDS])
    layers: list[Layer] = []
    for at, (rpm, colour) in enumerate(zip(SPEEDS, (GREY, ORANGE, BLUE), strict=True)):
        layers.append(Line(reach, np.array(rod)[:, at], f"{rpm} rpm", colour, 1.8))
    layers.append(
        Line(reach, np.array(linear)[:, -1], f"{SPEEDS[-1]} rpm, linear theory", BLUE, 1.4, "dash")
    )
    rules = (Rule("x", 7.0, "shipped"), Rule("x", 7.1, "corner"))
    return Panel(
        "compression as installed (mm)", "first mode in Stage I (N)", tuple(layers), rules=rules
    )


def scan_picture() -> Chart:
    """First mode's share of Stage I over clearance, coils and lower inactive turns."""
    shipped = [one.first_mode for one in SHIPPED.readings()[1]]
    clearances, coils = (
        np.round(np.arange(-0.3, 0.61, 0.1), 1),
        np.round(np.arange(6.5, 7.51, 0.1), 1),
    )
    scans: tuple[tuple[str, float, list[tuple[float, Callable[[], FiniteElementRod]]]], ...] = (
        (
            "clearance of coils 1, 2 more by (mm)",
            0.0,
            [(c, lambda c=c: tuned(with_clearance(WIRE, 1e-3 * c))) for c in clearances if c],
        ),
        (
            "total coils",
            7.0,
            [(n, lambda n=n: tuned(with_coils(WIRE, n))) for n in coils if n != 7],
        ),
        (
            "lower inactive turns",
            0.851,
            [(n, ends(n, None)) for n in (0.65, 0.7, 0.75, 0.8, 0.9, 0.95, 1.0)],
        ),
    )
    panels = [over_compression()]
    for label, own, places in scans:
        found = [
            (float(x), [one.first_mode for one in Change("", spring).readings()[1]])
            for x, spring in places
        ]
        found = sorted([*found, (own, shipped)])
        x, y = np.array([one[0] for one in found]), np.array([one[1] for one in found])
        layers: list[Layer] = [
            Line(x, y[:, at], f"{rpm} rpm", colour, 1.8, in_legend=False)
            for at, (rpm, colour) in enumerate(zip(SPEEDS, (GREY, ORANGE, BLUE), strict=True))
        ]
        panels.append(
            Panel(
                label,
                "first mode in Stage I (N)",
                tuple(layers),
                rules=(Rule("x", own, "shipped"),),
            )
        )
    return Chart(
        "stage-one-scans",
        "First mode in Stage I, peak to peak, over four levers",
        "",
        tuple(panels),
        2,
        620,
    )
