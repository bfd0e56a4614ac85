"""Curves over the cam angle: spring force, motion, rigid parts, contact forces and energy balance."""

from __future__ import annotations

import numpy as np

from valvetrain.quantities.forces import energy_balance
from valvetrain.report import theme
from valvetrain.report.chart import Chart, Line, Panel, Rule, thin
from valvetrain.report.page import Block, SectionSpec, figure_or_gap
from valvetrain.report.run_charts import (
    ANGLE_LABEL,
    STATIC_LABEL,
    angle_panels,
    by_speed,
    event_bands,
    line_styles,
    over_angle,
    panels_chart,
    runs_at,
    unit_of_channel,
)
from valvetrain.report.text import speed_text
from valvetrain.solution.result import Solution
from valvetrain.solution.study import Study

#: Channel -> (key, title, words of the axis).
FORCES = {
    "seat_force": ("force-seat", "Spring force on the cylinder head", "force on the cylinder head"),
    "retainer_force": ("force-retainer", "Spring force on the retainer", "force on the retainer"),
}


def force_blocks(study: Study) -> tuple[Block, ...]:
    """A figure per end of the spring, a panel per engine speed."""
    return tuple(
        block
        for channel, label in FORCES.items()
        for block in figure_or_gap(label[1], force_chart, study, channel)
    )


def force_chart(study: Study, channel: str) -> Chart | None:
    """One force channel by engine speed with the static force at the same lift; None where no run
    has it.
    """
    key, title, label = FORCES[channel]
    panels = []
    for engine_speed in study.engine_speeds:
        panels += angle_panels(
            study,
            runs_at(study, engine_speed),
            channel,
            label,
            speed_text(engine_speed),
            "static_retainer_force",
        )
    still = any(
        isinstance(layer, Line) and layer.name == STATIC_LABEL
        for panel in panels
        for layer in panel.layers
    )
    caption = "All springs together over the reported cam cycle, compressive positive."
    caption += " Dashed: what springs without inertia would give." if still else ""
    return panels_chart(key, title, caption, panels, 270)


FORCE_SPEC = SectionSpec("force", "Spring force", force_blocks)


#: Words of the axis -> channels, the first that a run has.
MOTIONS = {
    "valve lift": ("valve_lift",), "velocity, opening positive": ("valve_velocity", "retainer_velocity"),
    "acceleration, opening positive": ("valve_acceleration", "retainer_acceleration"),
}  # fmt: skip


def motion_blocks(study: Study) -> tuple[Block, ...]:
    """Three panels per engine speed; one line where all runs have the same prescribed motion."""

    def at(engine_speed: float, runs: list[Solution], key: str) -> tuple[Block, ...]:
        prescribed = all(run.provenance.system == "prescribed-spring" for run in runs)
        shown = runs[:1] if prescribed else runs
        title = (
            f"{'Prescribed motion' if prescribed else 'Valve motion'} at {speed_text(engine_speed)}"
        )
        panels = []
        for label, channels in MOTIONS.items():
            channel = next((one for one in channels if any(run.has(one) for run in shown)), "")
            panels += angle_panels(study, shown, channel, label) if channel else []
        caption = (
            "The prescribed motion of the retainer."
            if prescribed
            else "Motion over the steady cycle."
        )
        return figure_or_gap(title, panels_chart, key, title, caption, panels, 190)

    return by_speed(study, "motion", at)


MOTION_SPEC = SectionSpec("motion", "Valve motion", motion_blocks)


def kinematics_blocks(study: Study) -> tuple[Block, ...]:
    """Every channel ``rigid_...``, by engine speed."""

    def at(engine_speed: float, runs: list[Solution], key: str) -> tuple[Block, ...]:
        title = f"Rigid parts at {speed_text(engine_speed)}"
        return figure_or_gap(title, rigid_chart, study, runs, key, title)

    return by_speed(study, "kinematics", at)


#: Channels of rigid parts that sections of their own show.
_OWN_SECTIONS = ("rigid_spring_margin",)


def rigid_chart(study: Study, runs: list[Solution], key: str, title: str) -> Chart | None:
    """A panel per rigid channel; runs of one train share them, so one line represents all."""
    panels = []
    for name in dict.fromkeys(
        str(name)
        for run in runs
        for name in run.arrays.variables
        if str(name).startswith("rigid_") and name not in _OWN_SECTIONS
    ):
        run = next(run for run in runs if run.has(name))
        found, (unit, factor) = over_angle(run, name), unit_of_channel(run, name)
        if found is not None:
            caption = name.removeprefix("rigid_").replace("_", " ")
            line = Line(
                *thin(found[0], found[1] * factor), caption, theme.INK, 1.4, in_legend=False
            )
            label = f"{caption} ({unit})" if unit else caption
            panels.append(
                Panel(
                    ANGLE_LABEL,
                    label,
                    (line,),
                    bands=event_bands(study),
                    x_range=(0, 360),
                    x_step=30,
                )
            )
    return panels_chart(
        key,
        title,
        "Rigid parts, closed contacts, no surge: quasi-static values at this engine speed.",
        panels,
        190,
    )


KINEMATICS_SPEC = SectionSpec("kinematics", "Rigid parts", kinematics_blocks)


#: Forces of the springs and of rigid parts, which have their own sections; single springs bear a
#: name in front.
_OTHERS = (
    "seat_force",
    "retainer_force",
    "normal_force",
    "shear_force",
    "coil_contact_force",
    "rigid_contact_force",
    "contact_force",
)


def force_channels(runs: list[Solution]) -> list[str]:
    """Channels of contact and link forces that the runs have: contacts first."""
    names = dict.fromkeys(
        str(name)
        for run in runs
        for name, one in run.arrays.variables.items()
        if len(one.dims) == 1
    )
    springs = {f"{spring}_{other}" for run in runs for spring in run.springs for other in _OTHERS}
    forces = [
        name
        for name in names
        if name.endswith("_force") and name not in (*_OTHERS, *springs, "static_retainer_force")
    ]
    return sorted(forces, key=lambda name: not name.endswith("_contact_force"))


def train_blocks(study: Study) -> tuple[Block, ...]:
    """Contact and link forces, then torque and lever speed, by engine speed."""

    def panels_of(runs: list[Solution], channels: list[str]) -> list[Panel]:
        found = []
        for name in channels:
            rigid = (
                ("rigid_contact_force", "rigid parts") if name == "cam_contact_force" else ("", "")
            )
            found += angle_panels(
                study, runs, name, name.replace("_", " "), still=rigid[0], static_label=rigid[1]
            )
        return found

    def at(engine_speed: float, runs: list[Solution], key: str) -> tuple[Block, ...]:
        speed = speed_text(engine_speed)
        rest = [
            name for name in ("cam_torque", "lever_speed") if any(run.has(name) for run in runs)
        ]
        titles = (f"Contact and link forces at {speed}", f"Cam torque at {speed}")
        captions = (
            "Force of every contact and elastic link over the steady cycle; dashed: the cam contact force of rigid parts.",
            "Torque that drives the cam, turning speed of the lever.",
        )
        found: tuple[Block, ...] = ()
        for place, names in enumerate((force_channels(runs), rest)):
            panels = panels_of(runs, names)
            found += figure_or_gap(
                titles[place],
                panels_chart,
                f"{key}-{place + 1}",
                titles[place],
                captions[place],
                panels,
                210,
            )
        return found

    return by_speed(study, "train", at)


TRAIN_SPEC = SectionSpec("train", "Contacts and cam torque", train_blocks)


def energy_blocks(study: Study) -> tuple[Block, ...]:
    """A figure per run with energies."""
    known = line_styles(study)

    def at(engine_speed: float, runs: list[Solution], key: str) -> tuple[Block, ...]:
        found: tuple[Block, ...] = ()
        for number, run in enumerate(runs, start=1):
            title = f"Energy balance: {known[run.label].label}, {speed_text(engine_speed)}"
            found += figure_or_gap(title, energy_chart, run, f"{key}-{number}", title)
        return found

    return by_speed(study, "energy", at)


def energy_chart(run: Solution, key: str, title: str) -> Chart | None:
    """Work done, stored and dissipated energy and the imbalance over the whole run in mJ; None for
    a run without energies.
    """
    balance = energy_balance(run)
    if balance is None:
        return None
    angle = np.degrees(balance.cam_angle)
    parts = {
        "work done": balance.work,
        "stored": balance.stored,
        "kinetic": balance.kinetic,
        "dissipated": balance.dissipated,
    }
    lines = tuple(
        Line(
            *thin(angle, values * 1e3),
            name,
            colour,
            dash="dash" if name == "work done" else "solid",
        )
        for (name, values), colour in zip(parts.items(), theme.SERIES, strict=False)
    )
    missing = Line(
        *thin(angle, balance.imbalance * 1e3),
        "stored + dissipated − work",
        theme.ALERT,
        in_legend=False,
    )
    span = 1e3 * (balance.scale or 1.0)
    bound = 1.25 * max(0.01 * span, 1e3 * float(np.max(np.abs(balance.imbalance))))
    limits = tuple(
        Rule("y", sign * 0.01 * span, "1 % of the work done" if sign > 0 else "")
        for sign in (1, -1)
    )
    x_label = "cam angle from the start (cam degrees)"
    panels = (
        Panel(x_label, "energy (mJ)", lines, "Energies"),
        Panel(
            x_label,
            "stored + dissipated − work (mJ)",
            (missing,),
            "Imbalance",
            rules=limits,
            y_range=(-bound, bound),
        ),
    )
    return Chart(
        key,
        title,
        "From the first sample on. Work is done on the spring by the retainer.",
        panels,
        2,
        330,
    )


ENERGY_SPEC = SectionSpec("energy", "Energy balance", energy_blocks)
