"""Figures of a study: each a short function that gives a plotly figure, which a user may restyle.

Numbers are in SI units but lengths in mm and angles in deg; a function gives None where its data are missing.
"""

from __future__ import annotations

import math

import numpy as np
import plotly.graph_objects as go

from valvetrain.arrays import Array
from valvetrain.findings.facts import TURN, Facts, over_turn
from valvetrain.findings.rules_train import hardest
from valvetrain.findings.words import RPM, Words, speed_text
from valvetrain.solution.result import Solution
from valvetrain.solution.study import Study
from valvetrain.views.style import (
    BAD,
    LEAD,
    OK,
    OTHER,
    RIGID,
    SECOND,
    SPEEDS,
    FigureSpec,
    angle_title,
    degrees,
    line,
    panels,
    red_line,
    styled,
    window,
)

#: Height of a word, as a share of the panel.
WORD = 0.09
#: Share of a peak by which a panel of forces reaches above it.
ROOM = 1.25
#: Share by which a peak of all steps is above that of the samples drawn where it is written next to them.
BETWEEN = 0.02
#: Room (deg) behind the last blow.
AFTER = 6.0


def worst_run(facts: Facts) -> Solution | None:
    """The run with channels that decides: the one with the largest loss, else with the least force left, else the fastest."""

    def gravity(run: Solution) -> tuple[float, float, float]:
        numbers = run.quantities
        lost = numbers.get("float_excess_lift", 0.0) + numbers.get("loft_gap", 0.0)
        return lost, -numbers.get("minimum_cam_contact_force", 0.0), run.engine_speed

    return max((run for run in facts.runs if run.has("valve_lift")), key=gravity, default=None)


def running_up(facts: Facts) -> go.Figure | None:
    """Least force on the cam and largest gap of every revolution of a run-up over engine speed."""
    runs = (*facts.runs, *facts.beyond)
    if not runs:
        return None
    fig = panels((0.6, 0.4))
    labels = list(dict.fromkeys(run.label for run in runs))
    for label, colour in zip(labels, SPEEDS * len(labels), strict=False):
        mine = [run for run in runs if run.label == label]
        at = [run.engine_speed / RPM for run in mine]
        for row, name, size in ((1, "minimum_cam_contact_force", 1), (2, "loft_gap", 1e3)):
            values = [size * run.quantities.get(name, math.nan) for run in mine]
            one = line(at, values, label, colour, legendgroup=label, showlegend=row == 1)
            fig.add_trace(one, row, 1)
    red_line(fig, facts.red_line / RPM)
    styled(fig, "engine speed, rpm", ("least force on the cam, N", "off the cam, mm"), 430)
    return fig.update_xaxes(tickformat="d")


def control(facts: Facts) -> go.Figure | None:
    """Force on the cam, and lift above that of rigid parts, of the run that decides; red where contact is lost."""
    run = worst_run(facts)
    if run is None or not run.has("cam_contact_force", "rigid_valve_lift", "rigid_contact_force"):
        return None
    angle = degrees(run)
    rigid, force = over_turn(run, "rigid_contact_force"), over_turn(run, "cam_contact_force")
    top = ROOM * max(float(np.percentile(force, 99.5)), float(rigid.max()))
    fig = panels((0.6, 0.4))
    fig.add_trace(line(angle, rigid, "rigid parts", RIGID, "dash"), 1, 1)
    for one in (*facts.runs, *facts.others):
        alike = one.engine_speed == run.engine_speed and one is not run
        if alike and one.has("cam_contact_force"):
            other = over_turn(one, "cam_contact_force")
            more = line(degrees(one), other, one.label, OTHER, "dot", visible="legendonly")
            fig.add_trace(more, 1, 1)
    fig.add_trace(line(angle, force, f"on the cam, {run.label}", LEAD), 1, 1)
    peak = facts.amount(run, "peak_cam_contact_force")
    if peak is not None and peak.value > min(top, (1 + BETWEEN) * force.max()):
        most = f"most {Words(brief=True).amount(peak)}, " if peak.resolved else ""
        at, text = angle[int(np.argmax(force))], f"{most}{hardest(facts, run)}°"
        fig.add_annotation(  # below the words of a loss and of a landing
            x=at, y=1 - 2 * WORD, yref="y domain", text=text, showarrow=False, xanchor="right", font={"size": 11, "color": LEAD}, row=1, col=1,
        )  # fmt: skip
    least = facts.least_angle(run, "cam_contact_force")
    low = facts.amount(run, "minimum_cam_contact_force")
    if least is not None and low is not None and not facts.losses(run):
        text = f"least {Words(brief=True).amount(low)}"
        fig.add_trace(go.Scatter(
            x=[math.degrees(least.value)], y=[low.value], mode="markers+text", text=[text], name="least",
            textposition="top center", showlegend=False, textfont={"color": BAD}, marker={"color": BAD, "size": 8},
            hoverinfo="skip",
        ), 1, 1)  # fmt: skip
    excess = 1e3 * (over_turn(run, "valve_lift") - over_turn(run, "rigid_valve_lift"))
    fill = {"fill": "tozeroy", "fillcolor": "rgba(224,123,40,.12)"}
    fig.add_trace(line(angle, excess, "lift above rigid parts", SECOND, **fill), 2, 1)
    _mark_losses(fig, run, facts)
    styled(fig, angle_title(facts, run), ("N", "mm"), 430)
    fig.update_yaxes(range=[-0.04 * top, top], row=1, col=1)
    return fig.update_xaxes(range=window(run))


def _mark_losses(fig: go.Figure, run: Solution, facts: Facts) -> None:
    """Where contact is lost, and where the valve lands."""
    for loss in facts.losses(run)[:6]:
        turned = loss.duration * run.engine_speed / 2
        begin, end = (math.degrees(one) % 360 for one in (loss.cam_angle, loss.cam_angle + turned))
        if end > begin:
            fig.add_vrect(begin, end, fillcolor=BAD, opacity=0.12, line_width=0)
    landings = [e for e in run.events if e.kind == "seating" and e.details.get("touch") == 1]
    marks = [(one.cam_angle, "leaves", BAD) for one in facts.losses(run)[:1]]
    marks += [(one.cam_angle, "lands", OK) for one in landings[:1]]
    low, high = window(run)
    for place, (at, word, colour) in enumerate(marks):
        angle = math.degrees(at) % 360
        side = 1 if angle < (low + 2 * high) / 3 else -1
        fig.add_vline(angle, line={"color": colour, "width": 1, "dash": "dot"})
        fig.add_annotation(
            x=angle, y=1 - WORD * place, yref="y domain", text=f"{word} {angle:.0f}°", showarrow=False,
            xanchor="left" if side > 0 else "right", xshift=3 * side, font={"size": 11, "color": colour}, row=1, col=1,
        )  # fmt: skip


def force(facts: Facts) -> go.Figure | None:
    """Spring force on the retainer at every speed below 10 kHz, with the blows of coils in a panel below."""
    runs = [run for run in facts.runs if run.has("retainer_force", "valve_lift")][-len(SPEEDS) :]
    if not runs:
        return None
    hits = {id(run): _hardest(facts, run) for run in runs if not facts.train}
    struck = any(hits.values())
    fig = panels((0.68, 0.32) if struck else (1.0,))
    last = runs[-1]
    if (still := _static(facts.study, last)) is not None:
        fig.add_trace(line(degrees(last), still, "at rest", RIGID, "dash"), 1, 1)
    for spring in last.springs:  # of a nested pair
        if last.has(channel := f"{spring}_retainer_force"):
            name = f"{spring}, {speed_text(last.engine_speed)}"
            fig.add_trace(line(degrees(last), over_turn(last, channel), name, OTHER, "dot"), 1, 1)
    several = len({run.engine_speed for run in runs}) > 1
    for run, colour in zip(runs, SPEEDS, strict=False):
        name = run.label if facts.several else speed_text(run.engine_speed)
        name = f"{name}, {speed_text(run.engine_speed)}" if facts.several and several else name
        values = over_turn(run, "retainer_force")
        fig.add_trace(line(degrees(run), values, name, colour, legendgroup=name), 1, 1)
        if found := hits.get(id(run)):
            at = [math.degrees(angle) for angle, _, _ in found]
            sizes = [4 + 22 * min(1.0, size / 1000) ** 0.5 for _, _, size in found]
            fig.add_trace(go.Scatter(
                x=at, y=[pair for _, pair, _ in found], mode="markers", name=name, legendgroup=name, showlegend=False,
                text=[f"{size:.0f} N" for _, _, size in found], hovertemplate="%{text}, coils %{y}",
                marker={"size": sizes, "color": colour, "opacity": 0.55},
            ), 2, 1)  # fmt: skip
    styled(
        fig,
        angle_title(facts, last),
        ("on the retainer, N", "coils") if struck else ("on the retainer, N",),
        430,
    )
    if struck:
        fig.update_yaxes(type="category", categoryorder="category ascending", row=2, col=1)
    low, high = window(last)
    struck_at = [math.degrees(angle) for some in hits.values() for angle, _, _ in some]
    return fig.update_xaxes(range=(low, max([high, *(at + AFTER for at in struck_at)])))


def _hardest(facts: Facts, run: Solution) -> list[tuple[float, str, float]]:
    """Cam angle (rad), pair of coils and force (N) of the hardest blows of a run."""
    found = []
    events = facts.strikes(run)
    for one in events[:60]:
        if one.size > 0.04 * events[0].size:
            pair = "–".join(f"{float(one.details[key]):g}" for key in ("lower_coil", "upper_coil"))
            angle = float(one.details.get("peak_cam_angle", one.cam_angle)) % TURN
            found.append((angle, pair, one.size))
    return found


def _static(study: Study, run: Solution) -> Array | None:
    """Force (N) of a spring without inertia at the lift of every sample; None where no curve gives it."""
    if run.has("static_retainer_force"):
        return over_turn(run, "static_retainer_force")
    slow = study.at_rest(run.model) or study.at_rest()
    if slow is None or slow.curve is None or len(run.springs) > 1:
        return None
    lift = over_turn(run, "valve_lift")
    return np.interp(slow.precompression + lift, slow.curve.compression, slow.curve.force)


def lift(facts: Facts) -> go.Figure | None:
    """Valve lift of the run that decides next to that of rigid parts, with velocity and acceleration."""
    run = worst_run(facts)
    if run is None:
        return None
    angle = degrees(run)
    below = [name for name in ("valve_velocity", "valve_acceleration") if run.has(name)]
    if not below:
        return None
    fig = panels((0.5, *[0.5 / len(below)] * len(below)))
    if run.has("rigid_valve_lift"):
        rigid = 1e3 * over_turn(run, "rigid_valve_lift")
        fig.add_trace(line(angle, rigid, "lift of rigid parts", RIGID, "dash"), 1, 1)
    fig.add_trace(line(angle, 1e3 * over_turn(run, "valve_lift"), "lift of the valve", LEAD), 1, 1)
    for row, (name, colour) in enumerate(zip(below, ("#7a3fa0", SECOND), strict=False), 2):
        fig.add_trace(line(angle, over_turn(run, name), name.replace("_", " "), colour), row, 1)
    units = {"valve_velocity": "m/s", "valve_acceleration": "m/s²"}
    styled(fig, angle_title(facts, run), ("mm", *(units[name] for name in below)), 460)
    return fig.update_xaxes(range=window(run))


def contacts(facts: Facts) -> go.Figure | None:
    """Force in every contact of the train, and the torque that drives the cam, over the cam angle, of the run that decides."""
    run = worst_run(facts)
    ends = "_contact_force"
    places = [] if run is None else [n for n in run.arrays.variables if n.endswith(ends)]
    places = [name for name in places if not name.startswith(("rigid", "coil"))]
    if run is None or len(places) < 2 or not run.has("cam_torque"):
        return None
    fig = panels((0.6, 0.4))
    for name, colour in zip(places, SPEEDS, strict=False):
        word = name.removesuffix(ends).replace("_", " ")
        fig.add_trace(line(degrees(run), over_turn(run, name), word, colour), 1, 1)
    torque = line(degrees(run), over_turn(run, "cam_torque"), "cam torque", OTHER)
    fig.add_trace(torque, 2, 1)
    styled(fig, angle_title(facts, run), ("N", "torque, N m"), 430)
    return fig.update_xaxes(range=window(run))


def piston(facts: Facts) -> go.Figure | None:
    """Clearance (mm) of valve and piston over the cam angle, of every run that has it."""
    runs = [run for run in facts.runs if run.has("piston_clearance", "valve_lift")]
    if not runs:
        return None
    fig, last = go.Figure(), runs[-1]
    for run, colour in zip(runs, SPEEDS, strict=False):
        values = 1e3 * over_turn(run, "piston_clearance")
        fig.add_trace(line(degrees(run), values, facts.at(run) or run.label, colour))
    return styled(fig, angle_title(facts, last), ("clearance, mm",)).update_xaxes(
        range=window(last)
    )


RUN_UP = FigureSpec("Where control is lost", "one point a cam revolution", running_up)
CONTROL = FigureSpec(
    "Force on the cam, and the valve off its path",
    "dashed: rigid parts with springs at rest; red: contact lost",
    control,
)
FORCE = FigureSpec(
    "Spring force over the cam angle",
    "below 10 kHz; dots: the hardest blows of coils, sized by force",
    force,
)
LIFT = FigureSpec("Lift, velocity and acceleration", "of the run that decides", lift)
CONTACTS = FigureSpec(
    "Forces in the contacts, and cam torque",
    "of the run that decides; the spring drives the cam where the torque is below zero",
    contacts,
)
PISTON = FigureSpec("Clearance to the piston", "", piston)
