"""Pictures of docs/how-to, drawn from runs of the package itself: ``python scripts/write_pages.py
how-to``.

Where the command of a guide has a figure that shows its answer, that figure is the picture.
"""

from __future__ import annotations

import re
from collections.abc import Callable
from pathlib import Path

import numpy as np
import plotly.graph_objects as go
from numpy.typing import NDArray
from plotly_pictures import Panel, curve, dots, drawn, save

import valvetrain as vt
from valvetrain.cam import build_lift_law
from valvetrain.parameters.case import Case
from valvetrain.quantities.cycle import reported_cycle
from valvetrain.solution.result import Solution
from valvetrain.views.style import BAD, LEAD, OTHER, SECOND

Array = NDArray[np.float64]
ROOT = Path(__file__).resolve().parents[1]
FOLDER, EXAMPLES = ROOT / "docs" / "pictures" / "how-to", ROOT / "examples" / "how-to"
TEMPLATES = ROOT / "src" / "valvetrain" / "templates"
RPM, ANGLE, SPEED = 30 / np.pi, "cam angle, deg", "engine speed, rpm"


def template(kind: str) -> Case:
    """The case that ``valvetrain new`` writes."""
    return vt.load_case(TEMPLATES / f"{kind}.toml")


def over_angle(run: Solution, channel: str, factor: float = 1.0) -> tuple[Array, Array]:
    """Cam angle (deg) and a channel times ``factor`` over the reported cycle."""
    cycle = reported_cycle(run)
    return np.degrees(cycle.cam_angle), cycle.channel(channel) * factor


def turn(y: str, *traces: go.Scatter, title: str = "", x_range: tuple[float, float] = (0, 360)) -> Panel:  # fmt: skip
    """A panel over the cam angle."""
    return Panel(ANGLE, y, traces, title, x_range=x_range)


def margin_over_speed() -> go.Figure:
    best = {
        "train.springs.stock.0.preload": "200 N",
        "train.springs.stock.0.open_load": "374.51 N",
    }
    curves = []
    for case, words, colour in (
        (vt.load_case("tdi-pushrod"), "196 N closed, 378 N open (the case)", LEAD),
        (vt.load_case("tdi-pushrod", best), "200 N closed, 375 N open (the search)", SECOND),
    ):
        swept = vt.sweep(case, "4000:8000:250 rpm", models=["multi-mass"], spring_sets=["stock"], critical_speeds=False)  # fmt: skip
        ratio = swept.series(swept.labels[0], "minimum_spring_margin_ratio")
        curves.append(curve(ratio.engine_speed, ratio, words, colour))
    rules = (("y", 1.2, "required: 1.2"), ("y", 1.0, "1: contact is lost"), ("x", 6500.0, "6500 rpm"))  # fmt: skip
    y = "least spring force over what slows the valve"
    return drawn("Spring margin over engine speed, rigid parts", [Panel(SPEED, y, curves, rules=rules)])  # fmt: skip


def loss_and_float() -> go.Figure:
    return vt.sweep(
        "tdi-pushrod", "6000:8000:100 rpm", models=["multi-mass"], spring_sets=["stock"]
    ).figure("speeds")


def surge_over_speed() -> go.Figure:
    swept = vt.sweep(template("spring"), "2000:7200:50 rpm", models=["reduced-rod"])
    surge = swept.series("reduced-rod", "surge_amplitude_force")
    frequency = swept.solutions[0].quantities["surge_frequency"]
    rules = [("x", 120 * frequency / order, str(order)) for order in range(10, 22)]
    panel = Panel(SPEED, "surge amplitude, N (0 to peak)", [curve(surge.engine_speed, surge)], "", rules, (2900, 7200), (0, 30))  # fmt: skip
    return drawn(f"Surge of the template spring ({frequency:.0f} Hz); dotted: cam orders that meet it", [panel])  # fmt: skip


def two_springs() -> go.Figure:
    thin_wire = {
        "spring.wire_diameter": "3.6 mm", "spring.mean_diameter": "22.3 mm", "spring.total_coils": 5.26, "spring.pitch.pitch": "12.75 mm",
    }  # fmt: skip
    wires = (
        (template("spring"), "wire 3.9 mm", LEAD), (vt.load_case(TEMPLATES / "spring.toml", thin_wire), "wire 3.6 mm", SECOND),
    )  # fmt: skip
    amplitude, stress = [], []
    for case, words, colour in wires:
        run = vt.simulate(case, "6500 rpm", models=["finite-element"]).solutions[0]
        shear = 1e-6 * reported_cycle(run).channel("inner_fibre_shear_stress")
        coil = run.arrays.along("inner_fibre_shear_stress")
        assert coil is not None
        inside = np.flatnonzero(np.ptp(shear, axis=0) > 0)
        amplitude.append(curve(coil[inside], np.ptp(shear[:, inside], axis=0) / 2, words, colour))
        worst = inside[int(np.argmax(np.max(shear[:, inside], axis=0)))]
        angle = np.degrees(reported_cycle(run).cam_angle)
        stress.append(curve(angle, shear[:, worst], words, colour))
    panels = [
        Panel("coil number from the seat", "stress amplitude, MPa", amplitude, "Along the wire"),
        turn("shear stress, MPa", *stress, title="At the worst place"),
    ]
    return drawn("Two springs of one rate, preload and outer diameter at 6500 rpm", panels)


def over_clearance() -> go.Figure:
    text = (EXAMPLES / "coil-bind-clearance.toml").read_text(encoding="utf-8")
    steps = ", ".join(f"{one:.12g}" for one in np.linspace(7, 12, 16))
    table = vt.study(re.sub(r'values = "[^"]*"', f'values = "{steps} mm"', text))
    clearance = 1e3 * table.column("coil_bind_clearance")
    shown = (
        ("clash_energy", "clash energy, mJ", 1e3), ("surge_amplitude_force", "surge amplitude, N (0 to peak)", 1.0),
        ("peak_spring_force", "peak spring force, N", 1.0), ("largest_clash_impulse", "largest impulse of a clash, mN s", 1e3),
    )  # fmt: skip
    panels = [
        Panel("clearance to coil bind, mm", words, [curve(clearance, factor * table.column(name))])
        for name, words, factor in shown
    ]
    return drawn("Beehive spring at 8000 rpm, shimmed towards coil bind", panels)


def over_rubbing() -> go.Figure:
    table = vt.study(EXAMPLES / "rubbing.toml")
    press = table.column("train.rubbing.normal_force")
    panels = [
        Panel("normal force between the springs, N", words, [curve(press, table.column(name))])
        for name, words in (
            ("surge_amplitude_force", "surge amplitude, N (0 to peak)"),
            ("minimum_spring_force", "minimum spring force, N"),
        )
    ]
    return drawn("Nested springs of vaz-ohc at 4900 rpm, friction coefficient 0.12", panels)


def speed_bought() -> go.Figure:
    table = vt.study(EXAMPLES / "lighter-parts.toml")
    speed = table.column("contact_loss_engine_speed") * RPM
    rigid = table.column("rigid_contact_loss_engine_speed") * RPM
    words = (
        "retainer 10 g lighter", "titanium valve and retainer, 50 g", "tappet 25 g lighter", "thinner pushrod, 8 g lighter",
        "rocker 20 % less inertia", "beehive spring, 30 g lighter",
    )  # fmt: skip
    gain = speed[1:] - speed[0]
    names = [f"{word}: {one:+.0f}" for word, one in zip(words, gain, strict=True)]
    bars = go.Bar(x=gain, y=names, orientation="h", marker={"color": LEAD})
    of_rigid = dots(rigid[1:] - rigid[0], names, "rigid parts, contact loss", SECOND)
    figure = drawn(
        f"Contact-loss speed with flex and surge: {speed[0]:.0f} rpm as built",
        [Panel("engine speed gained, rpm", "", [bars, of_rigid])],
    )
    return figure.update_yaxes(autorange="reversed").update_layout(margin={"l": 270})


def lift_lost() -> go.Figure:
    less = []
    for run, colour in zip(vt.simulate(template("pushrod"), "3000, 6000 rpm").solutions, (LEAD, SECOND), strict=True):  # fmt: skip
        angle, moved = over_angle(run, "valve_lift", 1e3)
        rigid = over_angle(run, "rigid_valve_lift", 1e3)[1]
        less.append(curve(angle, moved - rigid, f"{run.engine_speed * RPM:.0f} rpm", colour))
    panel = turn("valve lift less rigid lift, mm", *less, x_range=(135.0, 330.0))
    return drawn("Pushrod of 5/16 in: lift lost to flex", [panel])


def flight() -> go.Figure:
    return vt.simulate(
        "tdi-pushrod", "8500 rpm", models=["wave-rod"], spring_sets=["stock"]
    ).figure("control")


def over_lash() -> go.Figure:
    table = vt.study(EXAMPLES / "lash-and-seating.toml")
    lash, speed = 1e3 * table.column("train.lash"), table.column("engine_speed") * RPM
    curves = []
    for wanted, colour in ((2000, OTHER), (3000, LEAD), (4000, SECOND)):
        rows = np.abs(speed - wanted) < 1
        velocity = table.column("seating_velocity")[rows]
        curves.append(curve(lash[rows], velocity, f"{wanted} rpm", colour))
    rules = [("x", 0.2, "height of the ramp")]
    return drawn("vaz-ohc: seating velocity over lash", [Panel("lash, mm", "seating velocity, m/s", curves, "", rules)])  # fmt: skip


def tappet_force() -> go.Figure:
    swept = vt.sweep(template("pushrod"), "4000:9000:250 rpm", critical_speeds=False)
    panels = []
    for name, words, factor in (
        ("minimum_cam_contact_force", "least force on the tappet while open, N", 1.0),
        ("loss_of_contact_duration", "time without contact, ms per cycle", 1e3),
    ):
        values = swept.series(swept.labels[0], name)
        panels.append(Panel(SPEED, words, [curve(values.engine_speed, values * factor)]))
    return drawn("Template pushrod train: when is the tappet unloaded?", panels)


def smoothed_lobe() -> go.Figure:
    lobe = vt.measured.read_lift(EXAMPLES / "lobe.csv")[0]
    smooth = vt.measured.smooth_lift(lobe.cam_angles, lobe.lifts)
    angle = np.radians(np.arange(65.0, 195.01, 0.5))
    to_degrees = 1e6 * np.radians(1.0) ** 2
    mean, spread = smooth.lift(angle, 2) * to_degrees, 1.96 * smooth.spread(angle, 2) * to_degrees
    raw = np.diff(lobe.lifts, 2) / np.radians(5.0) ** 2 * to_degrees
    curves = [
        curve(np.degrees(lobe.cam_angles[1:-1]), raw, "second difference of the stations", OTHER),
        curve(np.degrees(angle), mean, "law behind the stations", LEAD),
        curve(np.degrees(angle), mean - spread, "95 % band", SECOND, "dash"),
        curve(np.degrees(angle), mean + spread, "95 % band", SECOND, "dash"),
    ]
    panel = turn("acceleration, µm/deg²", *curves, x_range=(65.0, 195.0))
    return drawn("Acceleration of a measured lobe", [panel])


def reference_heights() -> go.Figure:
    case = template("pushrod")
    study = vt.simulate(case, "3000 rpm")
    run, cam = study.solutions[0], np.arange(0.0, 360.0, 0.5)
    lobe = curve(cam, 1e3 * build_lift_law(case.lift_law).lift(np.radians(cam)), "lobe")
    valve = curve(*over_angle(run, "rigid_valve_lift", 1e3), "valve, rigid parts", SECOND)
    known = dict(run.quantities).items() | {one for values in study.still.values() for one in values.items()}  # fmt: skip
    ends = [np.degrees(dict(known)[f"lobe_50_thou_{side}_cam_angle"]) for side in ("opening", "closing")]  # fmt: skip
    panel = Panel(ANGLE, "lift, mm", [lobe, valve], "", [("y", 1.27, "0.050 in")], (130.0, 340.0))
    figure = drawn("Lobe and valve lift of one cam, and the height at which duration counts", [panel])  # fmt: skip
    text = f"{np.diff(ends)[0]:.0f} cam deg = {2 * np.diff(ends)[0]:.0f} crank deg"
    return figure.add_vrect(*ends, fillcolor=LEAD, opacity=0.08, line_width=0, annotation_text=text)


def four_trains() -> go.Figure:
    kinds = {
        "direct": "bucket tappet", "finger": "finger follower", "rocker": "rocker over the cam", "pushrod": "pushrod",
    }  # fmt: skip
    panels = []
    for kind, words in kinds.items():
        run = vt.simulate(template(kind), "3000 rpm").solutions[0]
        force = curve(*over_angle(run, "cam_contact_force", 1e-3))
        panels.append(turn("cam contact force, kN", force, title=words))
    return drawn("The four templates at 3000 rpm", panels)


def damping_found() -> go.Figure:
    damping, rows = np.array([4.0, 6.0, 8.0, 10.0, 12.0, 14.0, 17.0, 20.0]), []
    for one in damping:
        case = vt.load_case("job-t", {"spring.damping.stiffness_damping": f"{one} us"})
        runs = vt.simulate(case, "6000, 8000 rpm", models=["reduced-rod"]).solutions
        rows.append([run.quantities["surge_amplitude_force"] for run in runs])
    panels = []
    for place, (speed, measured, reach) in enumerate(
        ((6000, 188.0, (120.0, 300.0)), (8000, 571.0, (410.0, 850.0)))
    ):
        rules = [("y", measured * 0.98, ""), ("y", measured * 1.02, "measured ± 2 %"), ("x", 12.0, "found: 12.0 µs")]  # fmt: skip
        model = [curve(damping, np.array(rows)[:, place])]
        panels.append(Panel("stiffness damping, µs", "surge amplitude, N (0 to peak)", model, f"{speed} rpm", rules, y_range=reach))  # fmt: skip
    return drawn("Which damping makes the surge that was recorded?", panels)


def spikes() -> go.Figure:
    models = ["reduced-rod", "finite-element"]
    study = vt.simulate("gu2021-beehive-blind", "8000 rpm", models=models)
    panels = []
    for run in study.solutions:
        angle, force = over_angle(run, "seat_force")
        clashes = [event for event in run.events if event.kind == "clash"]
        hardest = sorted(clashes, key=lambda event: -event.size)[:6]
        at = np.array([np.degrees(float(one.details["peak_cam_angle"])) % 360 for one in hardest])
        tops = np.array([np.max(force[np.abs(angle - one) < 2.5]) for one in at])
        marks = dots(at, tops, "six clashes of largest force", BAD)
        panels.append(turn("seat force, N", curve(angle, force), marks, title=run.model))
    return drawn("Beehive spring at 8000 rpm: spikes of force and the clashes behind them", panels)


def stress_range() -> go.Figure:
    run = vt.simulate(template("spring"), "6000 rpm", models=["finite-element"]).solutions[0]
    shear = 1e-6 * reported_cycle(run).channel("inner_fibre_shear_stress")
    coil = run.arrays.along("inner_fibre_shear_stress")
    assert coil is not None
    inside = np.ptp(shear, axis=0) > 0
    most, least = np.max(shear[:, inside], axis=0), np.min(shear[:, inside], axis=0)
    curves = [
        curve(coil[inside], most, "largest", BAD), curve(coil[inside], (most + least) / 2, "mean", OTHER, "dash"),
        curve(coil[inside], least, "least", LEAD),
    ]  # fmt: skip
    panel = Panel("coil number from the seat", "shear stress at the inner fibre, MPa", curves)
    return drawn("Template spring at 6000 rpm: stress range along the wire", [panel])


def cam_torque() -> go.Figure:
    case = vt.load_case("tdi-pushrod", {"train.contacts.cam.friction_coefficient": "0.06"})
    sets = ["stock", "performance"]
    study = vt.simulate(case, "4000 rpm", models=["multi-mass"], spring_sets=sets)
    curves = [
        curve(*over_angle(run, "cam_torque"), run.spring_set, colour)
        for run, colour in zip(study.solutions, (LEAD, SECOND), strict=True)
    ]
    return drawn("tdi-pushrod at 4000 rpm: torque on the cam", [turn("cam torque, N m", *curves)])


def energy() -> go.Figure:
    run = vt.simulate("job-c", models=["finite-element"]).solutions[0]
    angle = np.degrees(run.cam_angle)
    names = ("kinetic_energy", "elastic_energy", "contact_energy", "work_done", "energy_dissipated")
    parts = {name: run.channel(name) - run.channel(name)[0] for name in names}
    stored = parts["kinetic_energy"] + parts["elastic_energy"] + parts["contact_energy"]
    missing = stored + parts["energy_dissipated"] - parts["work_done"]
    curves = [
        curve(angle, 1e3 * parts["work_done"], "work of the retainer", OTHER, "dash"), curve(angle, 1e3 * stored, "stored", LEAD),
        curve(angle, 1e3 * parts["energy_dissipated"], "dissipated", SECOND),
    ]  # fmt: skip
    words = "cam angle from the start, deg"
    panels = [
        Panel(words, "energy, mJ", curves),
        Panel(words, "stored + dissipated − work, µJ", [curve(angle, 1e6 * missing, "", BAD)]),
    ]
    return drawn("job-c at 8000 rpm: where the energy goes", panels)


def orders() -> go.Figure:
    panels = []
    for run in vt.simulate(template("pushrod"), "3000, 6000 rpm").solutions:
        sizes = [run.quantities[f"surge_order_{order}_force"] for order in range(1, 31)]
        place, hertz = run.quantities["surge_cam_order"], run.engine_speed / (4 * np.pi)
        title = f"{run.engine_speed * RPM:.0f} rpm: order 1 is {hertz:.0f} Hz"
        bars = go.Bar(x=list(range(1, 31)), y=sizes, marker={"color": LEAD})
        rules = [("x", place, f"surge {place * hertz:.0f} Hz")]
        panels.append(Panel("cam order", "dynamic spring force, N (0 to peak)", [bars], title, rules))  # fmt: skip
    return drawn("One frequency, two cam orders", panels)


PICTURES: dict[str, tuple[str, Callable[[], go.Figure]]] = {
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
    save(draw(), FOLDER / f"{number}-{name}.svg")


def write_all() -> None:
    """Draws all pictures."""
    for number in PICTURES:
        write(number)
