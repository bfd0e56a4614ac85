"""What each figure of a page has to carry, written down from the channels themselves: (title, x
axis, y axis, lines) per panel.

Runs of :func:`numbered` studies differ in every channel and number, so that no series can stand for
another.
"""

from __future__ import annotations

import re
from dataclasses import replace

import numpy as np
from scipy import signal

from synthetic_study import EVENT, own_study, published_study, sweep_study, train_study
from valvetrain.solution.result import Solution
from valvetrain.solution.study import Study

ANGLE = "cam angle (cam degrees)"
#: Words of a run's lines by its label.
NAMES = {
    "finite-element": "finite-element rod",
    "modal-varied": "modal model with varied stiffness",
}
Panels = list[tuple[str, str, str, dict[str, tuple[np.ndarray, np.ndarray]]]]


def numbered(study: Study) -> Study:
    """The study with every run's channels and numbers raised by a share of its own, and with
    energies that tell from each other.
    """
    runs = []
    for place, run in enumerate(study.solutions, start=1):
        share = 1 + place / 50
        raised = {
            name: (values.dims, share * values.values, values.attrs)
            for name, values in run.channels.data_vars.items()
        }
        channels = run.channels.assign(raised)
        if "kinetic_energy" in channels:
            work = channels["work_done"]
            channels = channels.assign(
                kinetic_energy=work.copy(data=0.11 * np.abs(work.values)),
                contact_energy=work.copy(data=0.03 * np.abs(work.values)),
                energy_dissipated=work.copy(data=np.linspace(0.2, 0.5, work.size) * share),
            )
        found = {
            name: value if name.endswith(("order", "count", "frequency")) else value * share
            for name, value in run.quantities.items()
        }
        runs.append(replace(run, channels=channels, quantities=found))
    return replace(study, solutions=tuple(runs))


STUDIES = {
    "own": lambda: numbered(own_study()), "published": lambda: numbered(published_study()), "train": lambda: numbered(train_study()),
    "sweep": lambda: numbered(sweep_study()),
}  # fmt: skip


def last_turn(run: Solution, channel: str) -> np.ndarray:
    """A channel over the last turn; runs are of one turn or two."""
    values = run.channel(channel)
    return values[len(values) - (360 if run.provenance.system == "train" else 720) :]


def turn(run: Solution) -> np.ndarray:
    count = 360 if run.provenance.system == "train" else 720
    return np.arange(count) * 360 / count


def at_speed(study: Study, place: int) -> list[Solution]:
    """The runs at the ``place``-th engine speed, from 1."""
    speed = sorted({round(run.engine_speed, 6) for run in study.solutions})[place - 1]
    return [run for run in study.solutions if round(run.engine_speed, 6) == speed]


def words(run: Solution) -> str:
    return NAMES.get(run.label, run.label)


def rpm(run: Solution) -> str:
    return f"{run.engine_speed * 30 / np.pi:.0f} rpm"


def lines(
    runs: list[Solution], channel: str, factor: float = 1.0
) -> dict[str, tuple[np.ndarray, np.ndarray]]:
    return {
        words(run): (turn(run), factor * last_turn(run, channel))
        for run in runs
        if run.has(channel)
    }


def force(study: Study, channel: str, axis: str) -> Panels:
    panels = []
    for place in range(1, 1 + len(study.engine_speeds)):
        runs = at_speed(study, place)
        first = next(run for run in runs if run.has("static_retainer_force"))
        rest = {"at rest, same lift": (turn(first), last_turn(first, "static_retainer_force"))}
        panels.append((rpm(runs[0]), ANGLE, axis, rest | lines(runs, channel)))
    return panels


def coils(study: Study, place: str, number: str, spring: str) -> Panels:
    run = at_speed(study, int(place))[int(number) - 1]
    nested = run.provenance.system == "train"
    channel, axis = (
        ("axial_position", "height of the wire above its seat (mm)")
        if not nested
        else (f"{spring}_axial_displacement", "displacement from installed (mm)")
    )
    coil = np.arange(4.0) if nested else np.arange(0.0, 7.25, 0.5)
    values = 1e3 * last_turn(run, channel)
    return [
        (
            "",
            ANGLE,
            axis,
            {f"coil number {one:.3g}": (turn(run), values[:, n]) for n, one in enumerate(coil)},
        )
    ]


def clash(study: Study, place: str, number: str, spring: str) -> Panels:
    run = at_speed(study, int(place))[int(number) - 1]
    return [
        (
            "",
            ANGLE,
            "coil number of the upper coil",
            {"contact force": (turn(run), last_turn(run, "coil_contact_force").T)},
        )
    ]


def motion(study: Study, place: str) -> Panels:
    runs = at_speed(study, int(place))
    valve = "valve" if runs[0].provenance.system == "train" else "retainer"
    shown = runs if valve == "valve" else runs[:1]
    return [
        ("", ANGLE, "valve lift (mm)", lines(shown, "valve_lift", 1e3)),
        ("", ANGLE, "velocity, opening positive (m/s)", lines(shown, f"{valve}_velocity")),
        ("", ANGLE, "acceleration, opening positive (m/s²)", lines(shown, f"{valve}_acceleration")),
    ]


def static(study: Study) -> Panels:
    rod, chain = (one.curve for one in study.rest)
    x, axis = 1e3 * rod.compression, "compression from the free length (mm)"
    return [
        (
            "Force",
            axis,
            "force (N)",
            {"finite-element rod": (x, rod.force), "multi-mass chain": (x, chain.force)},
        ),
        (
            "Stiffness",
            axis,
            "tangent stiffness (N/mm)",
            {
                "finite-element rod": (x, rod.stiffness / 1e3),
                "multi-mass chain": (x, chain.stiffness / 1e3),
            },
        ),
        (
            "Difference in force",
            axis,
            "from the finite-element rod (%)",
            {"multi-mass chain": (x, np.where(x > 0, -2.0, np.nan))},
        ),
    ]


def modes(study: Study) -> Panels:
    coil = np.arange(0.0, 7.25, 0.5)
    shapes = {}
    for number, waves in enumerate(
        (1, 2, 3), start=1
    ):  # the drawn half waves, turned so that the largest is +1
        wave = np.sin(np.pi * waves * coil / 7)
        top = wave[np.argmax(np.abs(wave))]
        shapes[f"mode {number}"] = (coil, wave / top)
    force = "force carried, largest 1"
    return [
        (
            "Axial shapes, finite-element rod",
            "coil number (turns from the lower end)",
            "axial part, largest 1",
            shapes,
        ),
        (
            "Modes, finite-element rod",
            "natural frequency (Hz)",
            force,
            {
                "other mode": (np.array([400, 1300.0]), np.array([0.01, 0.1])),
                "axial mode": (np.array([631, 1120, 1639.0]), np.array([1, 0.7, 0.5])),
            },
        ),
    ]


def orders(study: Study) -> Panels:
    panels = []
    for place in range(1, 1 + len(study.engine_speeds)):
        drawn = {}
        runs = [run for run in at_speed(study, place) if run.has("static_retainer_force")]
        for number, run in enumerate(runs):
            named = [
                value
                for name, value in run.quantities.items()
                if name.startswith("surge_order_") and name.endswith("_force")
            ]
            if named:
                sizes = np.array(named)
            else:  # amplitudes by projection on sine and cosine, order by order
                angle, dynamic = (
                    np.radians(turn(run)),
                    last_turn(run, "retainer_force") - last_turn(run, "static_retainer_force"),
                )
                sizes = np.array(
                    [2 * abs(np.mean(dynamic * np.exp(-1j * n * angle))) for n in range(1, 41)]
                )
            order = np.arange(1.0, len(sizes) + 1) + 0.7 * ((number + 0.5) / len(runs) - 0.5)
            gap, base = np.full(len(sizes), np.nan), np.zeros(len(sizes))
            drawn[words(run)] = (
                np.stack([order, order, gap], axis=1).ravel(),
                np.stack([base, sizes, gap], axis=1).ravel(),
            )
        panels.append(
            (
                rpm(runs[0]),
                "cam order (oscillations per cam revolution)",
                "dynamic spring force (N, 0 to peak)",
                drawn,
            )
        )
    return panels


def stress(study: Study, place: str, number: str, spring: str) -> Panels:
    run = at_speed(study, int(place))[int(number) - 1]
    coil, shear = np.arange(0.0, 7.25, 0.5), 1e-6 * last_turn(run, "inner_fibre_shear_stress")
    still = 41e3 * (
        7e-3 + last_turn(run, "valve_lift")
    )  # MPa, the same at every coil, the curve ends at 18 mm
    still = np.minimum(still, 41e3 * 18e-3)
    rest = "static curve at the same lift"
    return [
        (
            "Along the wire",
            "coil number from the seat",
            "shear stress (MPa)",
            {
                rest: (coil, np.full(15, still.max())),
                "largest": (coil, shear.max(axis=0)),
                "minimum": (coil, shear.min(axis=0)),
            },
        ),
        (
            "At coil number 3.5",
            ANGLE,
            "shear stress (MPa)",
            {rest: (turn(run), still), "largest": (turn(run), shear[:, 7])},
        ),
    ]


def energy(study: Study, place: str, number: str) -> Panels:
    run = at_speed(study, int(place))[int(number) - 1]
    x, axis = np.degrees(run.cam_angle), "cam angle from the start (cam degrees)"
    kinetic, elastic, contact, work, heat = (
        1e3 * run.channel(name)
        for name in (
            "kinetic_energy",
            "elastic_energy",
            "contact_energy",
            "work_done",
            "energy_dissipated",
        )
    )
    stored, work, heat = (
        kinetic + elastic + contact - (kinetic + elastic + contact)[0],
        work - work[0],
        heat - heat[0],
    )
    parts = {
        "work done": (x, work),
        "stored": (x, stored),
        "kinetic": (x, kinetic),
        "dissipated": (x, heat),
    }
    missing = "stored + dissipated − work"
    return [
        ("Energies", axis, "energy (mJ)", parts),
        ("Imbalance", axis, f"{missing} (mJ)", {missing: (x, stored + heat - work)}),
    ]


def contacts(study: Study, place: str) -> Panels:
    runs = at_speed(study, int(place))
    rigid = {"rigid parts": (turn(runs[0]), last_turn(runs[0], "rigid_contact_force"))}
    return [
        ("", ANGLE, "cam contact force (N)", rigid | lines(runs, "cam_contact_force")),
        ("", ANGLE, "valve tip contact force (N)", lines(runs, "valve_tip_contact_force")),
        ("", ANGLE, "seat contact force (N)", lines(runs, "seat_contact_force")),
        ("", ANGLE, "support force (N)", lines(runs, "support_force")),
    ]


def torque(study: Study, place: str) -> Panels:
    runs = at_speed(study, int(place))
    return [
        ("", ANGLE, "cam torque (N m)", lines(runs, "cam_torque")),
        ("", ANGLE, "lever speed (deg/s)", lines(runs, "lever_speed", 180 / np.pi)),
    ]


def margin(study: Study, place: str) -> Panels:
    run = at_speed(study, 1)[int(place) - 1]  # a figure per label
    opened = last_turn(run, "rigid_valve_lift") > 0
    surplus = np.where(opened, last_turn(run, "rigid_spring_margin"), np.nan)
    still = last_turn(run, "static_retainer_force")
    speed = f"{run.engine_speed * 30 / np.pi:g} rpm"
    carried = {"spring force at rest": (turn(run), still), speed: (turn(run), surplus)}
    return [("", ANGLE, "spring margin (N)", carried)]


def pressure(study: Study, place: str) -> Panels:
    runs = at_speed(study, int(place))
    rigid = {"rigid parts": (turn(runs[0]), 1e-6 * last_turn(runs[0], "rigid_hertz_pressure"))}
    carried = rigid | lines(runs, "cam_contact_pressure", 1e-6)
    return [("", ANGLE, "contact pressure (MPa)", carried)]


def piston(study: Study, place: str) -> Panels:
    """From 90 crank degrees before top dead centre to 90 after it."""
    carried = {}
    for run in at_speed(study, int(place)):
        crank = np.degrees(last_turn(run, "crank_angle"))
        near = np.abs(crank) <= 90
        carried[words(run)] = (crank[near], 1e3 * last_turn(run, "piston_clearance")[near])
    return [("", "crank angle from top dead centre (crank degrees)", "clearance (mm)", carried)]


def rigid(study: Study, place: str) -> Panels:
    run = at_speed(study, int(place))[0]
    rows = (
        ("valve lift", "mm", "rigid_valve_lift", 1e3),
        ("contact force", "N", "rigid_contact_force", 1.0),
        ("hertz pressure", "MPa", "rigid_hertz_pressure", 1e-6),
    )
    return [
        ("", ANGLE, f"{name} ({unit})", {name: (turn(run), factor * last_turn(run, channel))})
        for name, unit, channel, factor in rows
    ]


def sweep(study: Study, place: str | None) -> Panels:
    """The first figure has the forces, the others surge, clash and what happens at the seat."""
    shown = {
        None: (("peak_spring_force", "peak spring force below 10 kHz (N)", 1), ("minimum_spring_force", "minimum spring force (N)", 1)),
        "-1": (("surge_amplitude_force", "surge amplitude, 0 to peak (N)", 1),),
        "-2": (("clash_energy", "clash energy (mJ)", 1e3),),
        "-3": (("seating_velocity", "seating velocity (m/s)", 1), ("lift_loss_displacement", "lift lost (mm)", 1e3)),
    }[place]  # fmt: skip
    panels = []
    for name, label, factor in shown:
        drawn = {}
        for whose in study.labels:
            runs = sorted(
                (run for run in study.solutions if run.label == whose),
                key=lambda run: run.engine_speed,
            )
            x = np.array([run.engine_speed * 30 / np.pi for run in runs])
            y = factor * np.array([run.quantities[name] for run in runs])
            drawn |= {whose: (x, y), f"{whose}, not settled": (x[-1:], y[-1:])}
        panels.append(("", "engine speed (rpm)", label, drawn))
    return panels


def order_map(study: Study, place: str) -> Panels:
    label = study.labels[int(place) - 1]
    runs = sorted(
        (run for run in study.solutions if run.label == label), key=lambda run: run.engine_speed
    )
    x = np.array([run.engine_speed * 30 / np.pi for run in runs])
    sizes = np.array(
        [[run.quantities[f"surge_order_{n}_force"] for run in runs] for n in range(1, 25)]
    )
    fine = np.linspace(x[0], x[-1], 200)

    def ridge(frequency: float) -> tuple[np.ndarray, np.ndarray]:
        order = frequency * 120 / fine  # oscillations per cam turn: two crank turns
        return fine[order <= 24.5], order[order <= 24.5]

    surge = runs[-1].quantities["surge_frequency"]
    drawn = {f"{value} Hz": ridge(value) for value in range(200, 1600, 200)}
    return [
        (
            "",
            "engine speed (rpm)",
            "cam order",
            {"surge amplitude, 0 to peak": (x, sizes)} | drawn | {"surge": ridge(surge)},
        )
    ]


def ratios(study: Study) -> Panels:
    marks = {
        "EX, published": ([0.93], [0]),
        "FE, published": ([1.02], [1]),
        "AN, published, beyond": ([1.5], [2]),
    }
    rows = sorted(range(3), key=lambda row: {0: 1, 1: 0, 2: 2}[row])
    spans = (
        np.array([[1 - 20 / 790, 1 + 20 / 790, np.nan]] * 3).ravel(),
        np.repeat(np.arange(3.0), 3),
    )
    assert rows == [1, 0, 2]
    points = {name: (np.array(x), np.array(y, dtype=float)) for name, (x, y) in marks.items()}
    return [
        (
            "",
            "computed / given value (ratio)",
            "one row per value",
            {"stated tolerance": spans} | points,
        )
    ]


def stages(study: Study, place: str) -> Panels:
    runs = at_speed(study, int(place))
    marks = (
        {"FE, published": (np.array([np.degrees(3.1)]), np.array([790.0]))} if place == "2" else {}
    )
    return [("", ANGLE, "force on the lower seat (N)", lines(runs, "seat_force") | marks)]


def fine(run: Solution) -> tuple[np.ndarray, np.ndarray, float]:
    """Cam angle (deg of the last turn), all force samples and their time step; four substeps a
    sample where a run has them.
    """
    force = (
        run.channel("seat_force_fine")[:-1].ravel()
        if run.has("seat_force_fine")
        else run.channel("seat_force")
    )
    parts = 4 if run.has("seat_force_fine") else 1
    degrees = np.arange(len(force)) * 0.5 / parts - (360 if parts == 4 else 0)
    return degrees, force, np.radians(0.5 / parts) / (run.engine_speed / 2)


def spikes(study: Study, place: str) -> Panels:
    drawn = {}
    for run in at_speed(study, int(place)):
        degrees, force, step = fine(run)
        near = (degrees >= np.degrees(EVENT.end) - 8 - 1e-9) & (
            degrees <= np.degrees(EVENT.end) + 87 + 1e-9
        )
        drawn[words(run)] = (degrees[near], force[near])
        if run.has("coil_contact_force"):
            smooth = signal.sosfiltfilt(signal.butter(4, 2 * 10e3 * step, output="sos"), force)
            drawn[f"{words(run)}, below 10 kHz"] = (degrees[near], smooth[near])
    marks = (
        {"FE, published": (np.array([np.degrees(3.1)]), np.array([790.0]))} if place == "2" else {}
    )
    return [("", ANGLE, "force on the lower seat (N)", drawn | marks)]


def nodes(study: Study, place: str, number: str) -> Panels:
    run = at_speed(study, int(place))[int(number) - 1]
    rows = (
        ("displacement (mm)", "axial_displacement", 1e3),
        ("velocity (m/s)", "axial_velocity", 1.0),
        ("acceleration (km/s²)", "axial_acceleration", 1e-3),
    )
    panels = []
    for label, channel, factor in rows:
        one, two = (factor * last_turn(run, channel)[:, coil] for coil in (2, 4))
        if channel == "axial_displacement":  # coil 2 counts from where it touches coil 1
            two = factor * last_turn(run, "coil_gap")[:, 2]
        panels.append(
            (
                "",
                ANGLE,
                label,
                {
                    "node 1 (end of coil 1)": (turn(run), one),
                    "node 2 (end of coil 2)": (turn(run), two),
                },
            )
        )
    return panels


#: Key of a figure -> what it carries.
def opening(study: Study) -> Panels:
    """Of a spring the force at the speed where most is worst, of a train lift and cam force, of a
    sweep the forces and the regimes of the run with critical speeds.
    """
    if study.over_speed:
        return [forces_over_speed(study), regimes(study)]
    runs = at_speed(study, len(study.engine_speeds))
    if runs[0].provenance.system != "train":
        return [("", *panel[1:]) for panel in force(study, "seat_force", "spring force (N)")[:1]]
    panels = []
    for axis, channel, rigid, factor in (
        ("valve lift (mm)", "valve_lift", "rigid_valve_lift", 1e3),
        ("cam contact force (N)", "cam_contact_force", "rigid_contact_force", 1.0),
    ):
        still = {"rigid parts": (turn(runs[0]), factor * last_turn(runs[0], rigid))}
        panels.append(("", ANGLE, axis, still | lines(runs, channel, factor)))
    return panels


def forces_over_speed(study: Study) -> tuple:
    found = {}
    for label in study.labels:
        runs = study.runs(label)
        x = np.array([run.engine_speed * 30 / np.pi for run in runs])
        restless = np.array([run.status.code != "completed" for run in runs])
        for name in ("peak_spring_force", "minimum_spring_force"):
            y = np.array([run.quantities[name] for run in runs])
            curve = label if name.startswith("peak") else f"{label}, {name.replace('_', ' ')}"
            found[curve] = (x, y)
            found[f"{curve}, not settled"] = (x[restless], y[restless])
    return ("", "engine speed (rpm)", "spring force: peak, dashed the minimum (N)", found)


def regimes(study: Study) -> tuple:
    """Rows from the top: controlled, contact loss, float, bounce; thin the range of an onset."""
    last = study.engine_speeds[-1] * 30 / np.pi
    first = study.engine_speeds[0] * 30 / np.pi
    rows = {row.kind: row for row in study.critical_speeds}
    contact, over = (rows[kind].engine_speed * 30 / np.pi for kind in ("contact-loss", "float"))
    gap = np.nan
    found = {
        "controlled": [(first, contact)],
        "contact loss": [
            (contact, rows["contact-loss"].ends.from_rest.lower_engine_speed * 30 / np.pi),
            *(
                (one.lower_engine_speed * 30 / np.pi, one.upper_engine_speed * 30 / np.pi)
                for one in rows["contact-loss"].again
            ),
        ],
        "float": [(over, last)],
    }
    height = {"controlled": 3.0, "contact loss": 2.0, "float": 1.0}
    bars = {}
    for name, spans in found.items():
        x = np.array([value for low, high in spans for value in (low, high, gap)])
        bars[name] = (x, np.where(np.isnan(x), gap, height[name]))
    low, high = (
        min(max(getattr(rows["float"].span, end) * 30 / np.pi, first), last)
        for end in ("lower_engine_speed", "upper_engine_speed")
    )
    bars["float, range"] = (np.array([low, high]), np.full(2, 1.0))
    return ("", "engine speed (rpm)", "", bars)


FIGURES = {
    r"opening": opening,
    r"force-seat": lambda study: force(study, "seat_force", "force on the cylinder head (N)"),
    r"force-retainer": lambda study: force(study, "retainer_force", "force on the retainer (N)"),
    r"coil-coils-(\d)-(\d)-(\w+)": coils, r"clash-coils-(\d)-(\d)-(\w+)": clash, r"motion-(\d)": motion, r"static-1": static,
    r"modes-1": modes, r"orders": orders, r"stress-(\d)-(\d)-(\w+)": stress, r"energy-(\d)-(\d)": energy, r"train-(\d)-1": contacts,
    r"train-(\d)-2": torque, r"spring-margin-(\d)": margin, r"cam-pressure-(\d)": pressure, r"piston-(\d)": piston,
    r"kinematics-(\d)": rigid, r"sweep(-\d)?": sweep, r"order-map-(\d)": order_map, r"ratios": ratios,
    r"gu2021-(\d)-force": stages, r"gu2021-(\d)-spikes": spikes, r"gu2021-(\d)-nodes-(\d)": nodes,
}  # fmt: skip


def expected(study: Study, key: str) -> Panels | None:
    """What the figure of that key carries; None for a key that nobody wrote down."""
    for pattern, carried in FIGURES.items():
        if found := re.fullmatch(pattern, key):
            return carried(study, *found.groups())
    return None
