"""The uncertainty that ships with a library case: written once by a script, read by every report of that case."""

from __future__ import annotations

import math
import tomllib
from importlib import resources

from valvetrain.cam.build import build_lift_law
from valvetrain.parameters.case import Case
from valvetrain.solution.definition import shown
from valvetrain.studies.uncertainty import Uncertainty, UncertaintyStudy

_STILL = "statics"
#: Values of the case agree with those of the file when they differ by less than this share.
SAME = 1e-4


def load_uncertainty(case: Case) -> tuple[Uncertainty, ...]:
    """Rows that ship with a library case; empty when there is none or the case is not the one that was refined."""
    file = resources.files("valvetrain") / "parameters" / "library" / f"{case.name}.uncertainty"
    if case.spring is None or case.lift_law is None or not file.is_file():
        return ()
    held = tomllib.loads(file.read_text(encoding="utf-8")).get("refined", {})
    here = fingerprint(case)
    if held.keys() != here.keys() or not all(math.isclose(held[name], value, rel_tol=SAME, abs_tol=1e-12) for name, value in here.items()):
        return ()
    return shipped_rows(case.name)


def shipped_rows(name: str) -> tuple[Uncertainty, ...]:
    """Rows that ship with the library case of that name, whether or not it was changed since; empty without a file."""
    file = resources.files("valvetrain") / "parameters" / "library" / f"{name}.uncertainty"
    content = tomllib.loads(file.read_text(encoding="utf-8")) if file.is_file() else {}
    tables = {label: table for label, table in content.items() if label not in ("refined", "meshes")}
    return tuple(_row(quantity, label, numbers) for label, table in tables.items() for quantity, numbers in table.items())


def meshes_of(case: Case) -> tuple[int, ...]:
    """Elements per coil of the meshes behind :func:`load_uncertainty`; empty without a file."""
    return shipped_meshes(case.name)


def shipped_meshes(name: str) -> tuple[int, ...]:
    """The same by the name of the library case."""
    file = resources.files("valvetrain") / "parameters" / "library" / f"{name}.uncertainty"
    return tuple(tomllib.loads(file.read_text(encoding="utf-8"))["meshes"]["elements_per_coil"]) if file.is_file() else ()


def fingerprint(case: Case) -> dict[str, float]:
    """Numbers (SI) that tell whether a case is still the one that was refined: spring, lift, damping and constants of the rod."""
    spring, law = case.require_spring(), build_lift_law(case.lift_law)
    places = [spring.total_coils * share for share in (0.2, 0.4, 0.6, 0.8)]
    found = {f"wire_axis_height_{n}": float(spring.axial_position(coil)) for n, coil in enumerate(places, start=1)}
    found |= {f"mean_diameter_{n}": float(spring.mean_diameter.value(coil)) for n, coil in enumerate(places, start=1)}
    found |= {f"lift_at_{angle}_deg": float(law.lift(math.radians(angle))) for angle in (130, 150, 165, 180)}
    return found | {
        "wire_diameter": float(spring.wire_diameter.value(0.0)), "lower_inactive_coils": spring.free_coils[0],
        "upper_inactive_coils": spring.total_coils - spring.free_coils[1], "precompression": case.installation.precompression,
        "mass_damping": case.damping.mass_damping, "stiffness_damping": case.damping.stiffness_damping,
        "elements_per_coil": float(case.rod.elements_per_coil), "contact_stiffness": case.rod.contact_stiffness,
        "contact_damping_time": case.rod.contact_damping_time, "cycles": float(case.operation.cycles),
        "curvature_correction": float(case.rod.curvature_correction),
    }  # fmt: skip


def uncertainty_text(study: UncertaintyStudy) -> str:
    """The file's content."""
    meshes = ", ".join(map(str, study.elements_per_coil))
    lines = [
        f"# Uncertainty of the headline numbers of {study.case.name}; written by scripts/write_uncertainty.py. SI units.",
        "# value, numerical uncertainty, observed order (nan: not monotonic), extrapolated value, part of the step,",
        "# least and largest over contact stiffness x 0.35 to x 2.5, least and largest over contact damping x 0 to x 2.", "", "[refined]",
        *(f"{name} = {value!r}" for name, value in fingerprint(study.case).items()), "", "[meshes]", f"elements_per_coil = [{meshes}]",
    ]  # fmt: skip
    for speed in dict.fromkeys(row.engine_speed for row in study.rows):
        lines += ["", f'["{_STILL if speed is None else _rpm(speed)}"]']
        here = [row for row in study.rows if row.engine_speed == speed]
        lines += [f"{row.quantity} = [{', '.join(f'{number:.7g}' for number in _numbers(row))}]" for row in here]
    return "\n".join(lines) + "\n"


def uncertainty_sentences(rows: tuple[Uncertainty, ...], meshes: tuple[int, ...]) -> tuple[str, ...]:
    """What a reader of the main job should know: how firm the main clash of each speed is, numerically and by its contact constants."""
    sentences = []
    for speed in dict.fromkeys(row.engine_speed for row in rows):
        here = {row.quantity: row for row in rows if row.engine_speed == speed}
        if speed is None or "main_clash_below_10_khz_peak_force" not in here:
            continue
        parts = [
            f"{words} {_with_unit(here[name].value, name)} ± {_with_unit(here[name].numerical, name, 2)}"
            for name, words in (
                ("main_clash_below_10_khz_peak_force", "height below 10 kHz"), ("main_clash_below_20_khz_peak_force", "below 20 kHz"),
                ("main_clash_peak_force", "raw"), ("main_clash_cam_angle", "at"), ("main_clash_impulse", "impulse"),
            ) if name in here
        ]  # fmt: skip
        raw, slow = here["main_clash_peak_force"].contact_stiffness, here["main_clash_below_10_khz_peak_force"].contact_stiffness
        sentences.append(
            f"{_rpm(speed)}, main clash of coils 1 and 2, numerical uncertainty from {', '.join(map(str, meshes))} elements per coil: "
            f"{'; '.join(parts)}. Contact stiffness from 0.35 to 2.5 times the case's moves the height from "
            f"{slow[0]:.4g} to {slow[1]:.4g} N below 10 kHz and from {raw[0]:.4g} to {raw[1]:.4g} N raw."
        )
    return tuple(sentences)


def _row(name: str, label: str, numbers: list[float]) -> Uncertainty:
    speed = None if label == _STILL else float(label.split()[0]) * math.pi / 30
    value, numerical, order, extrapolated, step, *ranges = map(float, numbers)
    stiffness, damping = (ranges[0], ranges[1]), (ranges[2], ranges[3])
    return Uncertainty(name, speed, value, numerical, None if math.isnan(order) else order, extrapolated, step, stiffness, damping)


def _numbers(row: Uncertainty) -> tuple[float, ...]:
    order = math.nan if row.observed_order is None else row.observed_order
    return (row.value, row.numerical, order, row.extrapolated, row.step_part, *row.contact_stiffness, *row.contact_damping)


def _rpm(engine_speed: float) -> str:
    return f"{engine_speed * 30 / math.pi:g} rpm"


def _with_unit(value: float, name: str, digits: int = 4) -> str:
    number, word = shown(name, value)
    return f"{number:.{digits}g} {word}"
