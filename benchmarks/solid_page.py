"""Writes docs/solid-reference.md from the saved results of solid_reference.py; the rod's numbers are
computed again.
"""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
from scipy.interpolate import CubicSpline

from benchmarks.solid_reference import (
    BEEHIVE_LEVELS,
    LARGE,
    LEVELS,
    SMALL,
    SPRINGS,
    STORE,
    STRESS_LEVELS,
    beehive,
    richardson,
    summary,
)
from valvetrain.cosserat.buffer import RodDynamics
from valvetrain.cosserat.mesh import mesh_spring
from valvetrain.cosserat.modes import natural_modes
from valvetrain.cosserat.state import free_state
from valvetrain.cosserat.static import RodStatics, compress
from valvetrain.cosserat.transient import simulate
from valvetrain.parameters.loading import load_case
from valvetrain.solution.atomic import write_text
from valvetrain.solution.netcdf import load_netcdf
from valvetrain.solution.result import Solution

HEAD = """# The rod against solid finite elements

The finite-element rod is a one-dimensional theory. These numbers come from three-dimensional elasticity instead: the wire of the same
`SpringDefinition`, meshed with hexahedra and solved by CalculiX 2.20 (`ccx`). They are kept in `tests/published/solid_reference.toml`,
so that the rod is checked against them in every test run without the solver.
`python -m benchmarks.solid_reference` computes them, `python -m benchmarks.solid_page` writes this page.

## Use

    from valvetrain.parameters.loading import load_case
    from valvetrain.continuum.mesh_file import write_mesh
    from validation.calculix.jobs import SolidSpring
    from valvetrain.continuum.mesh import MeshOptions

    spring = load_case("gu2021-beehive-blind").springs[0]
    model = SolidSpring(spring.wire, MeshOptions(24, 2, ends="bonded"))
    curve = model.static_curve(7e-3)            # StaticCurve, coils closing
    modes = model.modes(7e-3)                   # ModalResult about the compressed state
    write_mesh(model.mesh, "spring.vtu")        # needs meshio: pip install "valvetrain[mesh]"

This needs a clone, not only the package. Solids of the package itself are bricks of our own in motion
([theory](theory/solid-in-motion.md)), as in `valvetrain run --model solid`.

`validation.calculix.transient.run_transient` moves the retainer by a lift law in CalculiX, minutes per millisecond, and gives a
`Solution` (an independent check of motion; its first increments may carry a jolt, whose cause was not found).

Each run happens in a temporary folder within
`time_limit` seconds; a solver that gives up leaves what it reached and its own words in the status. Without `ccx` the error names the
command that installs it.

## Model

Swept O-grid over the round section, arcs along the circle, area equal to the circle's (`valvetrain.continuum.mesh`). Element
C3D20R (quadratic hexahedron, reduced integration). Steel with E 206 GPa, G 79.6 GPa, 7850 kg/m3. Uniform springs: wire 3.8 mm,
pitch 7 mm, both wire ends cut at right angles and clamped over the whole section, the upper one moved along the axis without turning;
large displacements. "Limit" is the Richardson limit of the three meshes, with the observed order p.

Choice of the element (five turns, D 22 mm; small compression and first frequency, differences from the limits):

| element | elements per coil | section cells | unknowns | force | first frequency | wall time |
|---|---|---|---|---|---|---|
| C3D20R | 12 | 5 | 4980 | -0.70 % | -0.13 % | 2 s |
| C3D20R | 24 | 12 | 22185 | -0.05 % | -0.01 % | 14 s |
| C3D20 | 24 | 12 | 22185 | -0.01 % | +0.01 % | 17 s |
| C3D8I | 24 | 12 | 6069 | +0.98 % | +1.07 % | 4 s |
| C3D8I | 48 | 20 | 17925 | -0.04 % | +0.13 % | 18 s |

The quadratic element with reduced integration gives the most for its cost. Wall times: one core of a shared server, all of one
deck (two static steps, 28 modes).
"""


def table(head: list[str], rows: list[list[str]]) -> str:
    lines = ["| " + " | ".join(head) + " |", "|" + "---|" * len(head)]
    return "\n".join(lines + ["| " + " | ".join(row) + " |" for row in rows]) + "\n"


def rod_of(name: str) -> tuple[np.ndarray, dict[str, np.ndarray]]:
    """Forces at both compressions and frequencies of the clamped rod, 36 elements per coil."""
    mesh = mesh_spring(SPRINGS[name], 36)
    nowhere = np.full(mesh.vertices, np.inf)
    statics = RodStatics(replace(mesh, lower_seat_limit=-nowhere, upper_seat_limit=nowhere))
    results = compress(statics, [SMALL, LARGE])
    states = {"free": free_state(mesh), "loaded": results[-1].state}
    return np.array([r.retainer_force for r in results]), {
        k: natural_modes(statics, v, 14).natural_frequency for k, v in states.items()
    }


def uniform_section(name: str) -> str:
    data, spring = summary(name), SPRINGS[name]
    rod_force, rod_frequency = rod_of(name)
    found = data["found"]
    text = f"\n### {spring.name}, D/d = {float(spring.index(0.0)):.2f}\n\n"
    rows = [
        [
            item["level"],
            f"{LEVELS[item['level']][0]}",
            str(item["elements"]),
            str(item["unknowns"]),
            f"{item['force_small']:.5f}",
            f"{item['force_large']:.4f}",
            f"{item['frequencies_free'][0]:.3f}",
            f"{item['wall_time']:.0f} s",
        ]
        for item in found
    ]
    small, large, first = data["force_small"], data["force_large"], data["free"][0]
    if len(found) == 3:
        rows.append(
            ["limit", "", "", "", f"{small[0]:.5f}", f"{large[0]:.4f}", f"{first[0]:.3f}", ""]
        )
        rows.append(
            [
                "p",
                "",
                "",
                "",
                *(f"{v[2]:.2f}" if v[2] == v[2] else "-" for v in (small, large, first)),
                "",
            ]
        )
    difference = 100 * (rod_force / [small[0], large[0]] - 1)
    first_difference = 100 * (rod_frequency["free"][0] / first[0] - 1)
    rows.append(
        [
            "rod",
            "36",
            "",
            "",
            *(f"{v:+.3f} %" for v in difference),
            f"{first_difference:+.2f} %",
            "",
        ]
    )
    head = ["mesh", "per coil", "elements", "unknowns", f"force at {SMALL * 1e3:g} mm (N)"]
    head += [f"at {LARGE * 1e3:g} mm (N)", "mode 1, free (Hz)", "wall time"]
    text += table(head, rows) + "\n"
    rows = []
    for mode in range(len(data["free"])):
        cells = [str(mode + 1)]
        for state in ("free", "loaded"):
            value = data[state][mode][0]
            mark = " *" if mode + 1 in data[f"axial_{state}"] else ""
            cells += [
                f"{value:.2f}{mark}",
                f"{100 * (rod_frequency[state][mode] / value - 1):+.2f} %",
            ]
        rows.append(cells)
    return text + table(["mode", "free (Hz)", "rod", f"at {LARGE * 1e3:g} mm (Hz)", "rod"], rows)


def stress_section() -> str:
    found = [
        json.loads((STORE / f"stress-index-6-{level}.json").read_text()) for level in STRESS_LEVELS
    ]
    rows = [
        [
            item["level"],
            str(item["unknowns"]),
            f"{item['inner_factor']:.4f}",
            f"{item['outer_factor']:.4f}",
            f"{item['wall_time']:.0f} s",
        ]
        for item in found
    ]
    limits = [
        richardson([item[key] for item in found], (1 / 2, 1 / 4, 1 / 6))
        for key in ("inner_factor", "outer_factor")
    ]
    rows.append(["limit", "", *(f"{v[0]:.3f} +- {v[1]:.3f}" for v in limits), ""])
    w = 6.0
    closed = [
        ["Goehner", f"{1 + 5 / (4 * w) + 7 / (8 * w**2) + 1 / w**3:.4f}"], ["Bergstraesser (EN 13906-1)", f"{(w + 0.5) / (w - 0.75):.4f}"],
        ["Wahl", f"{(4 * w - 1) / (4 * w - 4) + 0.615 / w:.4f}"],
    ]  # fmt: skip
    return (
        "\n## Stress at the inner fibre\n\nThree turns at D/d = 6 under 0.1 mm (5.94 N): shear on the inner and outer fibre over\n"
        "16 T / (pi d^3), T the torsional moment left in the wire by the printed reactions, mean over the middle turn; nodal stress\n"
        "extrapolated by the solver, which converges slowly (order 1.8) and from above.\n\n"
        + table(["mesh", "unknowns", "inner", "outer", "wall time"], rows)
        + "\n"
        + table(["closed form at index 6", "factor"], closed)
        + "\nGoehner and Bergstraesser lie within the mesh uncertainty of the limit; Wahl is 1.8 % above it.\n"
    )


def beehive_section() -> str:
    found = [json.loads(path.read_text()) for path in sorted(STORE.glob("beehive-?.json"))]
    best = found[-1]
    statics = RodStatics(mesh_spring(beehive(), 24))
    results = compress(statics, best["compression"][1:])
    rod = natural_modes(statics, results[-1].state, 14)
    text = (
        "\n## Beehive, coil 2 coming to rest on coil 1\n\nWire 3.867 mm, mean diameter 22.47 mm to coil 4 and then linear to 17.31 mm at\n"
        "coil 7, rise per turn less wire diameter 0, 0, 1.017, 2.032, 5.488, 5.488, 1.351 mm at coils 0, 0.875, 1.125, 2, 3, 6, 7; end\n"
        "turns inactive over 0.78 and 0.83; face-to-face penalty contact of all coils (5e4 MPa/mm) and seat planes. A fixed spring of the\n"
        "kind of `gu2021-beehive-blind`, not the case itself.\n\n"
    )
    rows = [
        [
            item["level"],
            "{} x {}, {}".format(*BEEHIVE_LEVELS[item["level"]]),
            str(item["unknowns"]),
            f"{item['force'][-1]:.2f}",
            *(f"{item['frequencies'][i]:.1f}" for i in item["axial"][:3]),
            f"{item['wall_time']:.0f} s",
        ]
        for item in found
    ]
    axial = rod.axial_modes(3)
    rows.append(
        [
            "rod",
            "24",
            "",
            f"{results[-1].retainer_force:.2f}",
            *(f"{rod.natural_frequency[i]:.1f}" for i in axial),
            "",
        ]
    )
    head = [
        "mesh",
        "per coil x core, rings",
        "unknowns",
        "force at 7 mm (N)",
        "axial 1 (Hz)",
        "axial 2",
        "axial 3",
        "wall time",
    ]
    text += table(head, rows) + "\n"
    contact = np.sum(best["coil_contact_force"], axis=1)
    finer = STORE / "partial-beehive-3.json"
    if finer.exists():
        item = json.loads(finer.read_text())
        at, force = item["compression"][-1], item["force"][-1]
        text += (
            f"A finer mesh ({item['unknowns']} unknowns), stopped for its time at {at * 1e3:.2f} mm, has {force:.2f} N there; mesh "
            f"{best['level']} {np.interp(at, best['compression'], best['force']):.2f} N.\n\n"
        )
    gap = [
        100 * (result.retainer_force / force - 1)
        for result, force in zip(results, best["force"][1:], strict=True)
    ]
    rows = [
        [
            f"{best['compression'][i] * 1e3:.2f}",
            f"{best['force'][i]:.2f}",
            f"{gap[i - 1]:+.2f} %",
            f"{best['stiffness'][i] / 1e3:.2f}",
            f"{contact[i]:.1f}",
        ]
        for i in range(2, len(best["force"]), 2)
    ]
    text += table(
        ["compression (mm)", "force (N)", "rod", "stiffness (N/mm)", "coil contact (N)"], rows
    )
    pairs = [
        f"{100 * (rod.natural_frequency[i] / best['frequencies'][i] - 1):+.2f}"
        for i in range(min(14, len(best["frequencies"])))
    ]
    return (
        text
        + f"\nRod against solid, modes 1 to {len(pairs)} at 7 mm, per cent: {', '.join(pairs)}.\n"
    )


def ends_section() -> str:
    paths = [STORE / f"ends-{name}.json" for name in ("held", "ground")]
    if not all(path.exists() for path in paths):
        return ""
    held, ground = (json.loads(path.read_text()) for path in paths)
    force = [np.interp(5e-3, item["compression"], item["force"]) for item in (held, ground)]
    bonded, share = held["unknowns"], 100 * (force[1] / force[0] - 1)
    return (
        "\n## Bonded or ground end turns\n\nSix turns, one closed and ground turn at either end (three quarters of it inactive),\n"
        f"D 22 mm, pitch 7 mm, at 5 mm: {force[0]:.2f} N with every node of the inactive turns bonded ({bonded} unknowns),\n"
        f"{force[1]:.2f} N ({share:+.2f} %) with ground end turns bonded at the ground face only ({ground['unknowns']} unknowns). "
        "Holding the turns is the\nsimplification that the rod makes too.\n"
    )


def ride_section() -> str:
    if not (STORE / "ride.nc").exists():
        return ""
    solid = load_netcdf(STORE / "ride.nc")
    data = solid.statistics
    text = (
        "\n## Transient\n\nThe beehive on the lift law of `gu2021-beehive-blind` at 8000 rpm from 85 cam degrees, coarse mesh of "
        f"{data['elements']} elements\n({data['unknowns']} unknowns), increments of 40 us, mass damping only, contact 1e4 MPa/mm: "
        f"{1e3 * solid.time[-1]:.2f} ms in {data['wall_time']:.0f} s on one core.\nEnd of the run: {solid.status.sentence()}.\n\n"
    )
    rod_retainer, rod_seat = rod_motion(solid)
    retainer, seat, degrees = (
        solid.channel("retainer_force"),
        solid.channel("seat_force"),
        np.degrees(solid.cam_angle),
    )
    rows = [
        [
            f"{degrees[i]:.1f}",
            f"{retainer[i]:.0f}",
            f"{rod_retainer[i]:.0f}",
            f"{seat[i]:.0f}",
            f"{rod_seat[i]:.0f}",
        ]
        for i in range(0, len(degrees), 10)
    ]
    text += table(
        ["cam angle (deg)", "retainer force, solid (N)", "rod", "seat force, solid (N)", "rod"],
        rows,
    )
    rms = [
        np.sqrt(np.mean((one - two)[2:-2] ** 2))
        for one, two in ((retainer, rod_retainer), (seat, rod_seat))
    ]
    return (
        text
        + f"\nRoot mean square of the difference: {rms[0]:.1f} N at the retainer, {rms[1]:.1f} N at the seat.\n"
    )


def rod_motion(solid: Solution) -> tuple[np.ndarray, np.ndarray]:
    """Retainer and seat force of the rod on the lift that ``solid`` followed, means over its
    increments.
    """
    time = solid.time
    lift = CubicSpline(time, solid.channel("valve_lift"))
    damping = load_case("gu2021-beehive-blind").springs[0].damping.mass_damping
    mesh = mesh_spring(beehive(), 24)
    start = compress(RodStatics(mesh), [LARGE])[-1].state
    run = simulate(
        mesh,
        start,
        lambda t: LARGE + lift(np.minimum(t, time[-1])),
        4e-5,
        round(time[-1] / 4e-5) + 2,
        RodDynamics(mass_damping=damping, stiffness_damping=0.0),
    )
    width = max(1, round(4e-5 / (run.dense_time[1] - run.dense_time[0])))
    window, count = (
        np.ones(width),
        np.convolve(np.ones(len(run.dense_time)), np.ones(width), mode="same"),
    )
    mean = [
        np.convolve(force, window, mode="same") / count
        for force in (run.dense_retainer_force, run.dense_seat_force)
    ]
    return np.interp(time, run.dense_time, mean[0]), np.interp(time, run.dense_time, mean[1])


LIMITS = """
## Limits of the solid model

- Clamping a whole section suppresses its warping and contraction, which the rod does not know; at five turns this and the rod's own
  end conditions agree to 0.02 % in force.
- Transient: mass-proportional damping only. Stiffness-proportional damping b of CalculiX 2.20 acts as if the prescribed retainer stood
  still: three turns pulled evenly at 0.05 m/s to 1.5 mm, where the damping of the moving wire should leave the middle of the wire where
  it is and raise the seat force by the share b v / u, have both lowered by that share (b = 1 ms: middle -3.4 %, seat -3.5 %, share 3.3 %;
  b = 2 ms: -6.6 %, -6.7 %, share 6.7 %), and the printed retainer force is two orders of magnitude too large. It is therefore not offered.
- In a transient with contact the printed reaction of the inactive turns chatters after the preload; the seat force is taken from the
  retainer's and the axial momentum of the wire.
- In modes with closed coils the printed reaction of the inactive turns is not usable; the seat's share is taken from the axial momentum.
- A spring with `ground` ends needs turns that are closed at the tip; grinding that would leave less than a tenth of the wire is refused.
"""


if __name__ == "__main__":
    sections = [HEAD, "\n## Uniform springs\n\nAxial modes carry a star.\n"]
    sections += [uniform_section(name) for name in SPRINGS if (STORE / f"{name}-2.json").exists()]
    sections += [stress_section(), beehive_section(), ends_section(), ride_section(), LIMITS]
    write_text(Path("docs/solid-reference.md"), "".join(sections))
