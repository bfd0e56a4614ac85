"""Pictures of docs/how-to, drawn from runs of the package itself: ``python scripts/write_pages.py
how-to``.
"""

from __future__ import annotations

import re
from collections.abc import Callable
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

import valvetrain as vt
from valvetrain.cam import build_lift_law
from valvetrain.parameters.case import Case
from valvetrain.quantities.cycle import reported_cycle
from valvetrain.report import theme
from valvetrain.report.chart import Band, Chart, Layer, Line, Marks, Panel, Rule, stems, thin
from valvetrain.report.svg_chart import svg
from valvetrain.solution.atomic import write_text
from valvetrain.solution.result import Solution

Array = NDArray[np.float64]
ROOT = Path(__file__).resolve().parents[1]
FOLDER, EXAMPLES = ROOT / "docs" / "pictures" / "how-to", ROOT / "examples" / "how-to"
TEMPLATES = ROOT / "src" / "valvetrain" / "templates"
RPM, ANGLE = 30 / np.pi, "cam angle (cam degrees)"
#: Points of a curve: enough for the width of a picture, spikes kept.
POINTS = 700
BLUE, ORANGE, GREEN, VIOLET, GREY = theme.SERIES[:5]


def template(kind: str) -> Case:
    """The case that ``valvetrain new`` writes."""
    return vt.load_case(TEMPLATES / f"{kind}.toml")


def line(
    x: Array, y: Array, name: str, colour: str, dash: str = "solid", width: float = 1.6
) -> Line:
    """A curve thinned to the width of a picture."""
    return Line(*thin(x, y, POINTS), name, colour, width, dash)


def single(x: Array, y: Array, width: float = 1.8) -> Line:
    """The only curve of a panel, which needs no key."""
    return Line(x, y, "", BLUE, width, in_legend=False)


def over_angle(run: Solution, channel: str, factor: float = 1.0) -> tuple[Array, Array]:
    """Cam angle (deg) and a channel times ``factor`` over the reported cycle."""
    cycle = reported_cycle(run)
    return np.degrees(cycle.cam_angle), cycle.channel(channel) * factor


def turn(
    y_label: str,
    *layers: Layer,
    title: str = "",
    rules: tuple[Rule, ...] = (),
    x_range: tuple[float, float] = (0, 360),
) -> Panel:
    """A panel over the cam angle."""
    return Panel(ANGLE, y_label, layers, title, (), rules, x_range, x_step=30)


def bars(x: Array, y: Array, name: str, colour: str, width: float = 7.0) -> Line:
    """Strokes from zero."""
    return Line(*stems(x, y), name, colour, width)


def margin_over_speed() -> tuple[str, tuple[Panel, ...]]:
    best = {
        "train.springs.stock.0.preload": "200 N",
        "train.springs.stock.0.open_load": "374.51 N",
    }
    layers = []
    for case, words, colour in (
        (vt.load_case("tdi-pushrod"), "196 N closed, 378 N open (the case)", BLUE),
        (vt.load_case("tdi-pushrod", best), "200 N closed, 375 N open (the search)", ORANGE),
    ):
        swept = vt.sweep(
            case,
            "4000:8000:250 rpm",
            spring_models=["multi-mass"],
            spring_set=["stock"],
            critical_speeds=False,
        )
        speeds, ratio = swept.series(swept.labels[0], "minimum_spring_margin_ratio")
        layers.append(Line(speeds * RPM, ratio, words, colour, 2.0))
    rules = (
        Rule("y", 1.2, "required: 1.2"),
        Rule("y", 1.0, "1: contact is lost"),
        Rule("x", 6500.0, "6500 rpm"),
    )
    panel = Panel(
        "engine speed (rpm)",
        "minimum spring force over what slows the valve (1)",
        tuple(layers),
        rules=rules,
    )
    return "Spring margin over engine speed, rigid parts", (panel,)


def loss_and_float() -> tuple[str, tuple[Panel, ...]]:
    swept = vt.sweep(
        "tdi-pushrod",
        "6000:8000:50 rpm",
        spring_models=["multi-mass"],
        spring_set=["stock"],
        critical_speeds=False,
    )
    label, panels = swept.labels[0], []
    shown = (
        ("minimum_cam_contact_force", "minimum cam contact force (N)", 1.0), ("float_excess_lift", "lift above the rigid lift (µm)", 1e6),
        ("surge_amplitude_force", "surge amplitude, 0 to peak (N)", 1.0), ("seating_velocity", "seating velocity (m/s)", 1.0),
    )  # fmt: skip
    for name, words, factor in shown:
        speeds, values = swept.series(label, name)
        rules = (
            (Rule("x", 6866.0, "contact lost"), Rule("x", 7078.0, "float"))
            if name == shown[0][0]
            else ()
        )
        panels.append(
            Panel(
                "engine speed (rpm)", words, (single(speeds * RPM, values * factor),), rules=rules
            )
        )
    return "tdi-pushrod, stock springs: what happens beyond 6866 rpm", tuple(panels)


def surge_over_speed() -> tuple[str, tuple[Panel, ...]]:
    swept = vt.sweep(template("spring"), "2000:7200:50 rpm", spring_models=["reduced-rod"])
    speeds, surge = swept.series("reduced-rod", "surge_amplitude_force")
    frequency = swept.solutions[0].quantities["surge_frequency"]
    met = np.arange(10, 22)
    rules = tuple(Rule("x", 120 * frequency / order) for order in met)
    named = Marks(
        120 * frequency / met,
        np.full(len(met), 27.5),
        "",
        theme.MUTED,
        labels=tuple(map(str, met)),
        in_legend=False,
        size=0.1,
    )
    layers = (single(speeds * RPM, surge), named)
    panel = Panel(
        "engine speed (rpm)",
        "surge amplitude (N, 0 to peak)",
        layers,
        "",
        (),
        rules,
        (2900.0, 7200.0),
        (0.0, 30.0),
    )
    return f"Surge of the template spring ({frequency:.0f} Hz); dotted: cam orders that meet it", (
        panel,
    )


def two_springs() -> tuple[str, tuple[Panel, ...]]:
    thin_wire = {
        "spring.wire_diameter": "3.6 mm", "spring.mean_diameter": "22.3 mm", "spring.total_coils": 5.26, "spring.pitch.pitch": "12.75 mm",
    }  # fmt: skip
    wires = (
        (template("spring"), "wire 3.9 mm", BLUE), (vt.load_case(TEMPLATES / "spring.toml", thin_wire), "wire 3.6 mm", ORANGE),
    )  # fmt: skip
    amplitude: list[Layer] = []
    stress: list[Layer] = []
    for case, words, colour in wires:
        run = vt.simulate(case, "6500 rpm", spring_models=["finite-element"]).solutions[0]
        shear = 1e-6 * reported_cycle(run).channel("inner_fibre_shear_stress")
        coil = run.arrays.along("inner_fibre_shear_stress")
        assert coil is not None
        inside = np.flatnonzero(np.ptp(shear, axis=0) > 0)
        amplitude.append(line(coil[inside], np.ptp(shear[:, inside], axis=0) / 2, words, colour))
        worst = inside[int(np.argmax(np.max(shear[:, inside], axis=0)))]
        stress.append(
            line(np.degrees(reported_cycle(run).cam_angle), shear[:, worst], words, colour)
        )
    panels = (
        Panel(
            "coil number from the seat",
            "stress amplitude (MPa)",
            tuple(amplitude),
            "Along the wire",
        ),
        turn("shear stress (MPa)", *stress, title="At the worst place"),
    )
    return "Two springs of one rate, preload and outer diameter at 6500 rpm", panels


def over_clearance() -> tuple[str, tuple[Panel, ...]]:
    text = (EXAMPLES / "coil-bind-clearance.toml").read_text(encoding="utf-8")
    steps = ", ".join(f"{one:.12g}" for one in np.linspace(7, 12, 16))
    text = re.sub(r'values = "[^"]*"', f'values = "{steps} mm"', text)
    table = vt.study(text)
    clearance = 1e3 * table.column("coil_bind_clearance")
    shown = (
        ("clash_energy", "clash energy (mJ)", 1e3), ("surge_amplitude_force", "surge amplitude, 0 to peak (N)", 1.0),
        ("peak_spring_force", "peak spring force (N)", 1.0), ("largest_clash_impulse", "largest impulse of a clash (mN s)", 1e3),
    )  # fmt: skip
    panels = (
        Panel(
            "clearance to coil bind (mm)", words, (single(clearance, factor * table.column(name)),)
        )
        for name, words, factor in shown
    )
    return "Beehive spring at 8000 rpm, shimmed towards coil bind", tuple(panels)


def over_rubbing() -> tuple[str, tuple[Panel, ...]]:
    table = vt.study(EXAMPLES / "rubbing.toml")
    press = table.column("train.rubbing.normal_force")
    shown = (
        ("surge_amplitude_force", "surge amplitude, 0 to peak (N)"),
        ("minimum_spring_force", "minimum spring force (N)"),
    )
    panels = (
        Panel("normal force between the springs (N)", words, (single(press, table.column(name)),))
        for name, words in shown
    )
    return "Nested springs of vaz-ohc at 4900 rpm, friction coefficient 0.12", tuple(panels)


def speed_bought() -> tuple[str, tuple[Panel, ...]]:
    table = vt.study(EXAMPLES / "lighter-parts.toml")
    speed = table.column("contact_loss_engine_speed") * RPM
    rigid = table.column("rigid_contact_loss_engine_speed") * RPM
    words = (
        "retainer 10 g lighter", "titanium valve and retainer, 50 g", "tappet 25 g lighter", "thinner pushrod, 8 g lighter",
        "rocker 20 % less inertia", "beehive spring, 30 g lighter",
    )  # fmt: skip
    gain, place = speed[1:] - speed[0], np.arange(len(words), 0, -1.0)
    layers = [
        single(np.array([0.0, one]), np.array([where, where]), 12.0)
        for one, where in zip(gain, place, strict=True)
    ]
    labels = tuple(f"{one:+.0f}" for one in gain)
    marks = Marks(gain, place, "", BLUE, "diamond", labels, in_legend=False, size=0.1)
    of_rigid = Marks(
        rigid[1:] - rigid[0], place - 0.25, "rigid parts, contact loss", ORANGE, "diamond"
    )
    named = tuple((float(where), text) for where, text in zip(place, words, strict=True))
    ends = (min(0.0, float(gain.min()) - 60), float(gain.max()) * 1.15)
    panel = Panel(
        "engine speed gained (rpm)",
        "",
        (*layers, marks, of_rigid),
        y_tick_labels=named,
        y_range=(0.4, len(words) + 0.6),
        x_range=ends,
    )
    return f"Contact-loss speed with flex and surge: {speed[0]:.0f} rpm as built", (panel,)


def lift_lost() -> tuple[str, tuple[Panel, ...]]:
    runs = vt.simulate(template("pushrod"), "3000, 6000 rpm").solutions
    less: list[Layer] = []
    for run, colour in zip(runs, (BLUE, ORANGE), strict=True):
        angle, moved = over_angle(run, "valve_lift", 1e3)
        words = f"{run.engine_speed * RPM:.0f} rpm"
        less.append(line(angle, moved - over_angle(run, "rigid_valve_lift", 1e3)[1], words, colour))
    span = (135.0, 330.0)
    return "Pushrod of 5/16 in: lift lost to flex", (
        turn("valve lift less rigid lift (mm)", *less, x_range=span, rules=(Rule("y", 0.0),)),
    )


def flight() -> tuple[str, tuple[Panel, ...]]:
    case = vt.load_case("tdi-pushrod")
    run = vt.simulate(case, "8500 rpm", spring_models=["wave-rod"], spring_set=["stock"]).solutions[
        0
    ]
    angle, moved = over_angle(run, "valve_lift", 1e3)
    rigid = line(angle, over_angle(run, "rigid_valve_lift", 1e3)[1], "rigid parts", GREY, "dash")
    gaps = [
        line(*over_angle(run, f"{place}_gap", 1e3), words, colour)
        for place, words, colour in (("cam", "cam", ORANGE), ("valve_tip", "valve tip", GREEN))
    ]
    return "tdi-pushrod, stock springs, at 8500 rpm", (
        turn("valve lift (mm)", rigid, line(angle, moved, "valve", BLUE)),
        Panel(
            ANGLE,
            "gap while open (mm)",
            tuple(gaps),
            x_range=(0, 360),
            x_step=30,
            y_range=(0.0, 0.8),
        ),
    )


def over_lash() -> tuple[str, tuple[Panel, ...]]:
    table = vt.study(EXAMPLES / "lash-and-seating.toml")
    lash, speed, velocity = (
        1e3 * table.column("train.lash"),
        table.column("engine_speed") * RPM,
        table.column("seating_velocity"),
    )
    layers = []
    for wanted, colour in zip((2000, 3000, 4000), (GREY, BLUE, ORANGE), strict=True):
        rows = np.abs(speed - wanted) < 1
        layers.append(Line(lash[rows], velocity[rows], f"{wanted} rpm", colour, 2.0))
    panel = Panel(
        "lash (mm)",
        "seating velocity (m/s)",
        tuple(layers),
        rules=(Rule("x", 0.2, "height of the ramp"),),
    )
    return "vaz-ohc: seating velocity over lash", (panel,)


def tappet_force() -> tuple[str, tuple[Panel, ...]]:
    swept = vt.sweep(template("pushrod"), "4000:9000:250 rpm", critical_speeds=False)
    panels = []
    for name, words, factor in (
        ("minimum_cam_contact_force", "least force on the tappet while open (N)", 1.0),
        ("loss_of_contact_duration", "time without contact (ms per cycle)", 1e3),
    ):
        speeds, values = swept.series(swept.labels[0], name)
        panels.append(Panel("engine speed (rpm)", words, (single(speeds * RPM, values * factor),)))
    return "Template pushrod train: when is the tappet unloaded?", tuple(panels)


def smoothed_lobe() -> tuple[str, tuple[Panel, ...]]:
    lobe = vt.measured.read_lift(EXAMPLES / "lobe.csv")[0]
    smooth = vt.measured.smooth_lift(lobe.cam_angles, lobe.lifts)
    angle = np.radians(np.arange(115.0, 245.01, 0.5))
    to_degrees = 1e6 * np.radians(1.0) ** 2
    mean, spread = smooth.lift(angle, 2) * to_degrees, 1.96 * smooth.spread(angle, 2) * to_degrees
    raw = np.diff(lobe.lifts, 2) / np.radians(1.0) ** 2 * to_degrees
    inside = (lobe.cam_angles[1:-1] > angle[0]) & (lobe.cam_angles[1:-1] < angle[-1])
    layers = (
        line(np.degrees(lobe.cam_angles[1:-1][inside]), raw[inside], "second difference of the stations", GREY, width=1.0),
        line(np.degrees(angle), mean, "law behind the stations", BLUE, width=2.0),
        line(np.degrees(angle), mean - spread, "95 % band", ORANGE, "dash", 1.2),
        line(np.degrees(angle), mean + spread, "95 % band", ORANGE, "dash", 1.2),
    )  # fmt: skip
    return "Acceleration of a measured lobe", (
        turn("acceleration (µm/deg²)", *layers, x_range=(115.0, 245.0)),
    )


def reference_heights() -> tuple[str, tuple[Panel, ...]]:
    case = template("pushrod")
    run = vt.simulate(case, "3000 rpm").solutions[0]
    law, angle = build_lift_law(case.lift_law), np.radians(np.arange(0.0, 360.0, 0.5))
    cam = np.degrees(angle)
    lobe = line(cam, 1e3 * law.lift(angle), "lobe", BLUE)
    valve = line(*over_angle(run, "rigid_valve_lift", 1e3), "valve, rigid parts", ORANGE)
    ends = [
        np.degrees(run_quantity(run, f"lobe_50_thou_{side}_cam_angle"))
        for side in ("opening", "closing")
    ]
    band = Band(
        ends[0],
        ends[1],
        f"{ends[1] - ends[0]:.0f} cam deg = {2 * (ends[1] - ends[0]):.0f} crank deg",
    )
    rules = (Rule("y", 1.27, "0.050 in"),)
    return "Lobe and valve lift of one cam, and the height at which duration counts", (
        Panel(ANGLE, "lift (mm)", (lobe, valve), "", (band,), rules, (130.0, 340.0), x_step=30),
    )


def run_quantity(run: Solution, name: str) -> float:
    """A number of a run, or of its train before it runs (SI)."""
    if name in run.quantities:
        return run.quantities[name]
    study = vt.simulate(template("pushrod"), "3000 rpm")
    return next(values[name] for values in study.still.values() if name in values)


def four_trains() -> tuple[str, tuple[Panel, ...]]:
    kinds, panels = (
        {
            "direct": "bucket tappet",
            "finger": "finger follower",
            "rocker": "rocker over the cam",
            "pushrod": "pushrod",
        },
        [],
    )
    for kind, words in kinds.items():
        run = vt.simulate(template(kind), "3000 rpm").solutions[0]
        panels.append(
            turn(
                "cam contact force (kN)",
                line(*over_angle(run, "cam_contact_force", 1e-3), "", BLUE),
                title=words,
            )
        )
    return "The four templates at 3000 rpm", tuple(panels)


def damping_found() -> tuple[str, tuple[Panel, ...]]:
    damping, rows = np.array([4.0, 6.0, 8.0, 10.0, 12.0, 14.0, 17.0, 20.0]), []
    for one in damping:
        case = vt.load_case("job-t", {"spring.damping.stiffness_damping": f"{one} us"})
        runs = vt.simulate(case, "6000, 8000 rpm", spring_models=["reduced-rod"]).solutions
        rows.append([run.quantities["surge_amplitude_force"] for run in runs])
    panels = []
    for place, (speed, measured, span) in enumerate(
        ((6000, 188.0, (120.0, 300.0)), (8000, 571.0, (410.0, 850.0)))
    ):
        layers = (
            Line(damping, np.array(rows)[:, place], "model", BLUE, 2.0, in_legend=place == 0),
        )
        rules = (
            Rule("y", measured * 0.98),
            Rule("y", measured * 1.02, "measured ± 2 %"),
            Rule("x", 12.0, "found: 12.0 µs"),
        )
        panels.append(
            Panel(
                "stiffness damping (µs)",
                "surge amplitude, 0 to peak (N)",
                layers,
                f"{speed} rpm",
                (),
                rules,
                y_range=span,
            )
        )
    return "Which damping makes the surge that was recorded?", tuple(panels)


def spikes() -> tuple[str, tuple[Panel, ...]]:
    study = vt.simulate(
        "gu2021-beehive-blind", "8000 rpm", spring_models=["reduced-rod", "finite-element"]
    )
    panels = []
    for run in study.solutions:
        angle, force = over_angle(run, "seat_force")
        hardest = sorted(
            (event for event in run.events if event.kind == "clash"), key=lambda event: -event.size
        )[:6]
        at = np.array(
            [np.degrees(float(event.details["peak_cam_angle"])) % 360 for event in hardest]
        )
        tops = np.array([np.max(force[np.abs(angle - one) < 2.5]) for one in at])
        marks = Marks(
            at,
            tops,
            "six clashes of largest force",
            theme.ALERT,
            "circle",
            in_legend=run is study.solutions[0],
        )
        layers = (line(angle, force, "", theme.model_colour(run.model), width=1.2), marks)
        panels.append(turn("seat force (N)", *layers, title=theme.model_label(run.model)))
    return "Beehive spring at 8000 rpm: spikes of force and the clashes behind them", tuple(panels)


def stress_range() -> tuple[str, tuple[Panel, ...]]:
    run = vt.simulate(template("spring"), "6000 rpm", spring_models=["finite-element"]).solutions[0]
    shear = 1e-6 * reported_cycle(run).channel("inner_fibre_shear_stress")
    coil = run.arrays.along("inner_fibre_shear_stress")
    assert coil is not None
    inside = np.ptp(shear, axis=0) > 0
    most, least = np.max(shear[:, inside], axis=0), np.min(shear[:, inside], axis=0)
    layers = [
        Line(coil[inside], most, "largest", theme.ALERT, 1.8), Line(coil[inside], (most + least) / 2, "mean", GREY, 1.4, "dash"),
        Line(coil[inside], least, "least", BLUE, 1.8),
    ]  # fmt: skip
    panel = Panel(
        "coil number from the seat", "shear stress at the inner fibre (MPa)", tuple(layers)
    )
    return "Template spring at 6000 rpm: stress range along the wire", (panel,)


def cam_torque() -> tuple[str, tuple[Panel, ...]]:
    case = vt.load_case("tdi-pushrod", {"train.contacts.cam.friction_coefficient": "0.06"})
    study = vt.simulate(
        case, "4000 rpm", spring_models=["multi-mass"], spring_set=["stock", "performance"]
    )
    pairs = zip(study.solutions, (BLUE, ORANGE), strict=True)
    layers = [line(*over_angle(run, "cam_torque"), run.spring_set, colour) for run, colour in pairs]
    return "tdi-pushrod at 4000 rpm: torque on the cam", (
        turn("cam torque (N m)", *layers, rules=(Rule("y", 0.0),)),
    )


def energy() -> tuple[str, tuple[Panel, ...]]:
    run = vt.simulate("job-c", spring_models=["finite-element"]).solutions[0]
    angle = np.degrees(run.cam_angle)
    parts = {
        name: run.channel(name)
        for name in (
            "kinetic_energy",
            "elastic_energy",
            "contact_energy",
            "work_done",
            "energy_dissipated",
        )
    }
    parts = {name: values - values[0] for name, values in parts.items()}
    stored = parts["kinetic_energy"] + parts["elastic_energy"] + parts["contact_energy"]
    layers = (
        line(angle, 1e3 * parts["work_done"], "work of the retainer", GREY, "dash"), line(angle, 1e3 * stored, "stored", BLUE),
        line(angle, 1e3 * parts["energy_dissipated"], "dissipated", ORANGE),
    )  # fmt: skip
    missing = line(
        angle, 1e6 * (stored + parts["energy_dissipated"] - parts["work_done"]), "", theme.ALERT
    )
    words = "cam angle from the start (cam degrees)"
    return "job-c at 8000 rpm: where the energy goes", (
        Panel(words, "energy (mJ)", layers),
        Panel(words, "stored + dissipated − work (µJ)", (missing,)),
    )


def orders() -> tuple[str, tuple[Panel, ...]]:
    panels = []
    for run in vt.simulate(template("pushrod"), "3000, 6000 rpm").solutions:
        sizes = np.array([run.quantities[f"surge_order_{order}_force"] for order in range(1, 31)])
        place, hertz = run.quantities["surge_cam_order"], run.engine_speed / (4 * np.pi)
        rules = (Rule("x", place, f"surge {place * hertz:.0f} Hz"),)
        title = f"{run.engine_speed * RPM:.0f} rpm: order 1 is {hertz:.0f} Hz"
        layer = bars(np.arange(1.0, 31.0), sizes, "", BLUE)
        panels.append(
            Panel(
                "cam order",
                "dynamic spring force (N, 0 to peak)",
                (layer,),
                title,
                (),
                rules,
                (0.0, 31.0),
            )
        )
    return "One frequency, two cam orders", tuple(panels)


PICTURES: dict[str, tuple[str, Callable[[], tuple[str, tuple[Panel, ...]]]]] = {
    "01": ("spring-margin", margin_over_speed), "02": ("loss-and-float", loss_and_float), "03": ("surge-over-speed", surge_over_speed),
    "04": ("two-springs", two_springs), "05": ("clearance", over_clearance), "06": ("rubbing", over_rubbing),
    "07": ("lighter-parts", speed_bought), "08": ("lift-lost", lift_lost), "09": ("flight", flight), "10": ("lash", over_lash),
    "11": ("tappet-force", tappet_force), "12": ("measured-lobe", smoothed_lobe), "13": ("reference-heights", reference_heights),
    "14": ("four-trains", four_trains), "15": ("damping", damping_found), "16": ("spikes", spikes), "17": ("stress-range", stress_range),
    "18": ("cam-torque", cam_torque), "19": ("energy", energy), "20": ("orders", orders),
}  # fmt: skip


def write(number: str) -> None:
    """Draws the picture of this number."""
    name, draw = PICTURES[number]
    title, panels = draw()
    columns = 1 if len(panels) == 1 else 2
    height = 300 * -(-len(panels) // columns) + 60
    write_text(
        FOLDER / f"{number}-{name}.svg",
        svg(Chart(f"how-to-{number}", title, "", panels, columns, height)),
    )


def write_all() -> None:
    """Draws all pictures."""
    for number in PICTURES:
        write(number)
