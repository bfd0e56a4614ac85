"""The first file of a study, a search or an identification of a case of one's own: it asks what people ask first, of the quantities
that the case has.
"""

from __future__ import annotations

import warnings

from valvetrain.errors import InputError
from valvetrain.explore.case_paths import unit_in_case, vary
from valvetrain.explore.samplers import ENOUGH_ROWS
from valvetrain.explore.space import Varied
from valvetrain.findings.facts import Facts
from valvetrain.parameters.case import Case
from valvetrain.parameters.toml_text import inline
from valvetrain.runs.api import simulate
from valvetrain.runs.static_study import curve_by_model
from valvetrain.units import to_unit
from valvetrain.units.reader import system_of

#: What people change, by its key in a table of the springs or at the top of the case.
OF_SPRING = {
    "preload": "seat load",
    "open_load": "open load",
    "rate": "rate",
    "wire_diameter": "wire",
    "mean_diameter": "mean coil diameter",
    "outer_diameter": "outer diameter",
    "total_coils": "turns",
    "precompression": "installed compression",
}
OF_TRAIN = {
    "train.valve.mass": "valve mass",
    "train.follower.mass": "follower mass",
    "train.lever.inertia": "rocker inertia",
    "train.pushrod.mass": "pushrod mass",
    "train.pushrod.outer_diameter": "pushrod",
    "train.pushrod.stiffness": "pushrod stiffness",
    "train.lever.stiffness": "rocker stiffness",
}
#: Engine speeds of a study of lash, as shares of the highest one in use.
SHARES = (0.6, 0.8, 1.0)
#: Lashes that are tried, over that of the case or (m) a usual one; step down to a speed at which no contact is lost.
LASHES, USUAL_LASH, SLOWER = (0.25, 0.5, 0.75, 1.0, 1.25, 1.5), 2e-4, 0.9
_MOTION = {True: ("minimum_cam_contact_force", "seating_velocity"), False: ("peak_spring_force",)}


def levers(case: Case) -> dict[str, str]:
    """What people change in a case: key -> what it is called, those that the case has as one
    number that may be a tenth larger.

    >>> import valvetrain as vt
    >>> list(levers(vt.load_case("job-c")))[:2]
    ['spring.wire_diameter', 'spring.mean_diameter']
    """
    table = f"train.springs.{case.train.spring_set}.0" if case.train else "spring"
    keys = {f"{table}.{key}": label for key, label in OF_SPRING.items()}
    return {key: label for key, label in (keys | OF_TRAIN).items() if _moves(case, key)}


def _moves(case: Case, key: str) -> bool:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        try:
            vary(case, {Varied(key, "", "factor"): 1.1})
        except InputError:
            return False
    return True


def request_text(kind: str, case: Case, name: str) -> str:
    """The file of a ``study``, ``lash``, ``optimise`` or ``identify`` about a case that it calls ``name``,
    with ``NAME.toml`` for its own name.

    Raises :class:`InputError` where the case has no lift, no train, no damping or nothing that may be varied.
    """
    texts = {"study": _study, "lash": _lash, "optimise": _search, "identify": _identification}
    return texts[kind](case, inline(name))


def _top(case: Case) -> float:
    """The highest engine speed of a case, in rpm."""
    top = case.operation.top_speed
    if case.lift_law is None or not top:
        raise InputError(
            "the case has no lift or no engine speed, so nothing moves; add [lift_law] and operation.engine_speeds",
            "--case",
        )
    return to_unit(top, "rpm")


def _varied(keys: dict[str, str], low: float, high: float) -> str:
    return "".join(
        f"""
[[vary]]
key = {inline(key)}
as = "factor" # of the case
low = {low}
high = {high}
label = {inline(label)}
"""
        for key, label in keys.items()
    )


def _study(case: Case, name: str) -> str:
    keys = levers(case)
    outputs = inline(list(_MOTION[case.train is not None]))
    return f"""# What decides? Each quantity from 0.9 to 1.1 of its value in the case; the answer ranks them.
#
#     valvetrain study NAME.toml

case = {name}
engine_speeds = "{_top(case):.6g} rpm"
outputs = {outputs} # valvetrain quantities lists all
points = {{ sampler = "saltelli", count = {ENOUGH_ROWS * (len(keys) + 2)}, seed = 1 }} # more for finer ranks
{_varied(keys, 0.9, 1.1)}"""


def _lash(case: Case, name: str) -> str:
    """Where and how fast the valve lands, over lash and engine speeds at which it follows its cam: after a flight it lands anywhere."""
    if case.train is None:
        raise InputError("a spring alone has no lash; give the case of an engine", "--case")
    in_use = top = _top(case)
    while top > SHARES[0] * SLOWER * in_use and _loses_contact(case, top):
        top *= SLOWER
    kept = f"; up to {top:.0f} rpm the valve follows its cam" if top < in_use else ""
    speeds = ", ".join(f"{share * top:.0f}" for share in SHARES)
    unit = "in" if system_of(case.text) == "imperial" else "mm"
    usual = to_unit(case.train.lash or USUAL_LASH, unit)
    lashes = ", ".join(f"{share * usual:.4g}" for share in LASHES)
    return f"""# Where does the valve land, and how fast, over lash? The worst of the engine speeds counts{kept}.
#
#     valvetrain study NAME.toml

case = {name}
outputs = ["seating_velocity", "seating_cam_angle", "bounce_height"]
points = {{ sampler = "grid" }}

[[vary]]
key = "engine_speed"
values = "{speeds} rpm"

[[vary]]
key = "train.lash"
values = "{lashes} {unit}"
label = "lash"
"""


def _loses_contact(case: Case, speed_in_rpm: float) -> bool:
    facts = Facts(simulate(case, f"{speed_in_rpm:.0f} rpm"))
    return not facts.runs or any(facts.losses(run) for run in facts.runs)


def _search(case: Case, name: str) -> str:
    """The lightest load on the cam that keeps control; of a spring alone the least peak force."""
    names = tuple(OF_SPRING.values())
    keys = {key: label for key, label in levers(case).items() if label in names}
    spring = (case.train.spring_parts() if case.train else case.springs)[0]
    force, bound = "peak_spring_force", 'preload"\nat_least = "1.0 x case"'
    if case.train:
        force = "peak_cam_contact_force"
        bound = 'minimum_cam_contact_force"\nat_least = "50 N" # what is to stay on the cam'
    if spring.solid_height is not None:
        bound += '\n\n[[constraint]]\nquantity = "coil_bind_clearance"\nat_least = "1 mm"'
    return f"""# The best spring within bounds: the least peak force that keeps what is asked.
#
#     valvetrain optimise NAME.toml

case = {name}
engine_speeds = "{_top(case):.6g} rpm"
search = {{ trials = 60 }}

[[objective]]
quantity = "{force}"
direction = "minimise"

[[constraint]]
quantity = "{bound}
{_varied(dict(list(keys.items())[:3]), 0.8, 1.25)}"""


def _damping(case: Case, name: str, table: str) -> str:
    """The damping of a spring by its card from surge on a rig; the values of the case stand in their place."""
    keys = (f"{table}.damping.{one}" for one in ("ratio", "stiffness_damping", "mass_damping"))
    key = next((one for one in keys if _moves(case, one)), None)
    if key is None:
        raise InputError(
            "its spring has neither a wire nor damping to find; give it damping", "--case"
        )
    top = _top(case)
    study = simulate(case, [f"{share * top:.0f} rpm" for share in SHARES[1:]])
    measured = "".join(
        f"""
[measurements.surge_at_{to_unit(run.engine_speed, "rpm"):.0f}]
quantity = "surge_amplitude_force"
value = "{run.quantities["surge_amplitude_force"]:.4g} N"
scatter = "5 %"
engine_speed = "{to_unit(run.engine_speed, "rpm"):.0f} rpm"
"""
        for run in study.solutions
    )
    return f"""# Damping of a spring from its surge on a rig: 'valvetrain rig' reads the amplitudes from a recording.
#
#     valvetrain identify NAME.toml

case = {name}
search = {{ draws = 30 }}

[quantities.damping]
key = {inline(key)}
as = "factor" # of the case
prior = "log-uniform"
low = 0.25
high = 4.0

# The amplitudes are those of the case: put yours, their scatter and their speeds in their place.
{measured}"""


def _identification(case: Case, name: str) -> str:
    spring = (case.train.spring_parts() if case.train else case.springs)[0]
    table = f"train.springs.{case.train.spring_set}.0" if case.train else "spring"
    if spring.wire is None:
        return _damping(case, name, table)
    curve = curve_by_model(spring, "wave-rod", 0.0, None, 8)
    places = (1e3 * (spring.wire.free_length - at) for at in curve.compression[3:])
    heights, forces = (", ".join(f"{at:.4g}" for at in row) for row in (places, curve.force[3:]))
    text = f"""# Wire and turns of a spring from the loads of a tester.
#
#     valvetrain identify NAME.toml

case = {name}

# The loads are those of the case: put yours, and their scatter, in their place.
[measurements.loads]
heights = "{heights} mm"
forces = "{forces} N"
scatter = "1 %"
spring_model = "wave-rod"
"""
    wire = spring.wire
    for key, value in (
        ("wire_diameter", wire.wire_diameter.value(0.0)),
        ("total_coils", wire.total_coils),
    ):
        if not _moves(case, f"{table}.{key}"):
            continue
        unit = unit_in_case(case, f"{table}.{key}")
        low, high = (
            inline(f"{1e3 * share * value:.4g} mm") if unit else f"{share * value:.4g}"
            for share in (0.95, 1.05)
        )
        text += f"""
[quantities.{key}]
key = "{table}.{key}"
prior = "uniform"
low = {low}
high = {high}
"""
    return text
