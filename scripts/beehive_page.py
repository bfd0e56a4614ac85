"""Tables of docs/beehive.md from runs: what the calibrated spring meets, next to the blind one, second and
settled revolution, the modal model, the sequel's sweep.

    python scripts/beehive_page.py            writes the tables between their marks (two minutes)
"""

from __future__ import annotations

import math
import sys
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from pathlib import Path

import numpy as np
from beehive_sentences import peak_text, place_text, spike_text, write_elsewhere
from numpy.typing import NDArray

import valvetrain as vt
from valvetrain.cam.build import build_lift_law
from valvetrain.parameters.case import Case
from valvetrain.parameters.loading import load_case
from valvetrain.solution.quantity import Quantity
from valvetrain.solution.study import Study
from valvetrain.sources.gu2021_modal import forces_of_equation_5

Array = NDArray[np.float64]
ROOT = Path(__file__).resolve().parents[1]
PAGE = ROOT / "docs" / "beehive.md"
CASE, BLIND = "gu2021-beehive", "gu2021-beehive-blind"
ROD, EQUATIONS = "finite-element", "equations 2 and 5"
RPM = math.pi / 30
SPEEDS = (4200, 5600, 8000)
DEG, MM, US = math.pi / 180, 1e-3, 1e-6


@dataclass(frozen=True)
class Aim:
    """One criterion: ``low`` to ``high`` (in the unit shown) of a number of a run, ``rpm`` 0 at rest."""

    group: str
    what: str
    rpm: int
    quantity: str
    source: str
    low: float
    high: float
    unit: str = "N"
    model: str = ROD

    def met(self, value: float | None) -> bool:
        return value is not None and self.low <= value <= self.high


def _about(group: str, what: str, rpm: int, quantity: str, value: float, share: float, unit: str = "N",
           model: str = ROD) -> Aim:  # fmt: skip
    ends = sorted((value * (1 - share), value * (1 + share)))
    return Aim(group, what, rpm, quantity, f"{value:g}", ends[0], ends[1], unit, model)


def _stage_2(what: str, rpm: int, quantity: str, solid: float, test: float) -> Aim:
    """Within 5 % of the source's finite elements, or between them and its test."""
    low, high = min(0.95 * solid, test), max(1.05 * solid, test)
    return Aim("Stage II", what, rpm, quantity, f"{solid:g} / {test:g}", low, high)


def _angle(what: str, rpm: int, quantity: str, value: float, model: str = ROD) -> Aim:
    return Aim("angles", what, rpm, quantity, f"{value:g}", value - 3, value + 3, "deg", model)


def _duration(rpm: int, source: str, begin: float, end: float) -> Aim:
    """Within a factor of two of the time from one angle (deg) to the other; the printed times are whole
    numbers of a rounded step.
    """
    lasts, room = (end - begin) / (3e-6 * rpm), 1 + 1e-9
    return Aim("durations", "contact to contact", rpm, "coil_1_2_bounce_duration", source,
               lasts / 2 / room, lasts * 2 * room, "us")  # fmt: skip


def _modal(rpm: int, quantity: str, what: str, value: float) -> Aim:
    """By the source's equations on our lift, since they know no contact."""
    return _about("modal model", what, rpm, quantity, value, 0.03, model=EQUATIONS)


#: What the calibrated spring is to meet.
AIMS: tuple[Aim, ...] = (
    _about("rest", "preload", 0, "preload", 289, 0.01),
    _about("rest", "mode 1", 0, "mode_1_frequency", 630, 0.01, "Hz"),
    _about("rest", "mode 2", 0, "mode_2_frequency", 1120, 0.03, "Hz"),
    _about("rest", "mode 3", 0, "mode_3_frequency", 1639, 0.03, "Hz"),
    Aim("rest", "change of slope", 0, "stiffness_change_compression", "about 5", 4.5, 5.5, "mm"),
    _stage_2("peak", 4200, "stage_2_peak_force", 818, 806),
    _stage_2("peak", 5600, "stage_2_peak_force", 896, 845),
    _stage_2("first peak", 8000, "stage_2_first_peak_force", 940, 895),
    _stage_2("valley", 8000, "stage_2_valley_force", 580, 581),
    _stage_2("second peak", 8000, "stage_2_second_peak_force", 1200, 1051),
    _about("spikes", "Stage III", 4200, "stage_3_peak_force", 315, 0.2),
    _about("spikes", "Stage III", 5600, "stage_3_peak_force", 620, 0.2),
    _about("spikes", "Stage III", 8000, "stage_3_peak_force", 1430, 0.2),
    _duration(5600, "327", 240.0, 245.5),
    _duration(8000, "83", 253.5, 255.5),
    _about("node 2", "displacement", 5600, "node_2_maximum_displacement", 0.28, 0.15, "mm"),
    _about("node 2", "displacement", 8000, "node_2_maximum_displacement", 0.68, 0.15, "mm"),
    _about("node 2", "velocity", 5600, "node_2_stage_3_minimum_velocity", -1.352, 0.15, "m/s"),
    _about("node 2", "velocity", 8000, "node_2_stage_3_minimum_velocity", -2.685, 0.15, "m/s"),
    _angle("Stage II", 4200, "stage_2_peak_cam_angle", 183),
    _angle("Stage II", 5600, "stage_2_peak_cam_angle", 175),
    _angle("spike", 5600, "stage_3_peak_cam_angle", 240),
    _angle("first peak", 8000, "stage_2_first_peak_cam_angle", 160),
    _angle("valley", 8000, "stage_2_valley_cam_angle", 172),
    _angle("second peak", 8000, "stage_2_second_peak_cam_angle", 186.5),
    _angle("spike", 8000, "stage_3_peak_cam_angle", 254.5),
    _angle("node 2 highest", 8000, "node_2_maximum_displacement_cam_angle", 243),
    _modal(4200, "stage_2", "Stage II", 814), _modal(5600, "stage_2", "Stage II", 865),
    _modal(5600, "stage_3", "Stage III", 380), _modal(8000, "stage_2_first", "first peak", 880),
    _modal(8000, "stage_2_second", "second peak", 778), _modal(8000, "stage_3", "Stage III", 360),
)  # fmt: skip
FACTORS = {"N": 1.0, "Hz": 1.0, "deg": 1 / DEG, "mm": 1 / MM, "us": 1 / US, "m/s": 1.0}


def value_of(study: Study, aim: Aim, case: str | Case = CASE) -> float | None:
    """The number of an aim in its unit, of a run of ``case``; None where the run has none."""
    if aim.model == EQUATIONS:
        names = [(rpm, name) for rpm, name, *_ in MODAL_PEAKS]
        return modal_peaks(case, True)[names.index((aim.rpm, aim.quantity))][0]
    if not aim.rpm:
        found = study.quantities.get(Quantity(aim.quantity))
    else:
        found = study.solution(aim.model, aim.rpm * RPM).quantities.get(aim.quantity)
    return None if found is None else FACTORS[aim.unit] * float(found)


def shown(value: float | None, unit: str) -> str:
    if value is None:
        return "none"
    digits = {"N": 0, "Hz": 0, "deg": 1, "mm": 2, "us": 0, "m/s": 2}[unit]
    return f"{value:.{digits}f}"


def aims_table(study: Study, blind: Study) -> str:
    """A row per aim: the source, ours, met or not, and the blind spring beside it."""
    head = "| aim | source | aimed at | calibrated | met | blind |"
    lines = [head, "|---" * 6 + "|"]
    met: dict[str, list[bool]] = {}
    for aim in AIMS:
        value, other = value_of(study, aim), value_of(blind, aim, BLIND)
        met.setdefault(aim.group, []).append(aim.met(value))
        where = f", {aim.rpm} rpm" if aim.rpm else ""
        ends = f"{shown(aim.low, aim.unit)} to {shown(aim.high, aim.unit)}"
        lines.append(
            f"| {aim.group}: {aim.what}{where} | {aim.source} {aim.unit} | {ends} | "
            f"{shown(value, aim.unit)} | {'yes' if aim.met(value) else 'no'} | {shown(other, aim.unit)} |"
        )
    counts = ", ".join(f"{group} {sum(one)} of {len(one)}" for group, one in met.items())
    total = sum(map(sum, met.values()))
    return "\n".join([f"{total} of {len(AIMS)} aims are met: {counts}.", "", *lines])


def misses(read: Array) -> Array:
    """Half widths by which readings (spring, aim) lie outside the ends of their aims, 0 inside, infinite
    where a spring has none.

    >>> misses(np.array([(one.low + one.high) / 2 for one in AIMS]))[:2].tolist()
    [0.0, 0.0]
    """
    low, high = (np.array([getattr(one, end) for one in AIMS]) for end in ("low", "high"))
    beyond: Array = np.maximum(np.maximum(low - read, read - high), 0.0) / ((high - low) / 2)
    return np.where(np.isnan(beyond), np.inf, beyond)


#: Quantities whose second and settled revolution stand side by side.
REPEATED = (
    ("Stage I range (N)", "stage_1_force_range"), ("Stage II peak (N)", "stage_2_peak_force"),
    ("Stage III spike, median of samples (N)", "stage_3_peak_force"),
)  # fmt: skip
SETTLED = 8


def revolutions_table(second: Mapping[int, Mapping[str, float]], settled: Mapping[int, Mapping[str, float]]) -> str:  # fmt: skip
    lines = ["| | " + " | ".join(f"{rpm} rpm" for rpm in SPEEDS) + " |", "|---|---|---|---|"]
    for label, name in REPEATED:
        cells = [f"{second[rpm][name]:.0f} / {settled[rpm][name]:.0f}" for rpm in SPEEDS]
        lines.append(f"| {label} | {' | '.join(cells)} |")
    return "\n".join(lines)


#: Peaks of the source's modal model: engine speed, name of the aim, its words, force (N), cam angle
#: (deg), and where ours is looked for (deg).
MODAL_PEAKS = (
    (4200, "stage_2", "II", 814, 183, 140, 225), (5600, "stage_2", "II", 865, 175, 140, 225),
    (5600, "stage_3", "III", 380, 240, 232, 262), (8000, "stage_2_first", "II, first", 880, 170, 150, 178),
    (8000, "stage_2_second", "II, second", 778, 203, 178, 225), (8000, "stage_3", "III", 360, 270, 245, 300),
)  # fmt: skip


@cache
def modal_peaks(source: str | Case, following: bool) -> tuple[tuple[float, float], ...]:
    """Force (N) and cam angle (deg) of :data:`MODAL_PEAKS` by equations 2 and 5 on the lift and the
    static curve of a case; the largest value where there is no maximum.
    """
    case = source if isinstance(source, Case) else load_case(source)
    curve = vt.static_curve(case)
    assert case.lift_law is not None
    lift = build_lift_law(case.lift_law).lift
    angle = np.arange(720) * DEG / 2
    found = []
    for rpm, _, _, _, _, low, high in MODAL_PEAKS:
        force = forces_of_equation_5(
            lift(angle), rpm * RPM / 2, curve.compression, curve.force, 7 * MM, following
        )
        inside = (angle >= low * DEG) & (angle <= high * DEG)
        inner = (force > np.roll(force, 1)) & (force >= np.roll(force, -1)) & inside
        pick = inner if np.any(inner) else inside
        top = int(np.argmax(np.where(pick, force, -np.inf)))
        found.append((float(force[top]), float(angle[top] / DEG)))
    return tuple(found)


def modal_table() -> str:
    """Those peaks beside the source's, with frequencies fixed and following the root of k(x)."""
    lines = ["| peak | source | frequencies follow k(x) | frequencies fixed |", "|---|---|---|---|"]
    ours = zip(MODAL_PEAKS, modal_peaks(CASE, True), modal_peaks(CASE, False), strict=True)
    for (rpm, _, words, force, place, _, _), *both in ours:
        cells = [f"{height:.0f} N at {at:.1f}" for height, at in both]
        lines.append(f"| {rpm} rpm, {words} | {force} N at {place} | {' | '.join(cells)} |")
    return "\n".join(lines)


SWEEP = tuple(range(6500, 13001, 500))


def sweep_table() -> str:
    """Largest force of the calibrated spring over engine speed; runs that diverged count as such."""
    cells = []
    for rpm in SWEEP:
        run = vt.simulate(CASE, f"{rpm} rpm", spring_models=[ROD], workers=1).solutions[0]
        read = run.quantities.get("peak_spring_force")
        told = f"{read:.0f}" if run.status.completed and read is not None else run.status.code
        cells.append((rpm, told))
    head = "| engine speed, rpm | " + " | ".join(str(rpm) for rpm, _ in cells) + " |"
    return "\n".join([head, "|---" * (len(cells) + 1) + "|", "| largest force, N | " + " | ".join(told for _, told in cells) + " |"])  # fmt: skip


def misses_of(study: Study, case: str | Case = CASE) -> Array:
    """Half widths by which the spring of a study lies outside the ends of each aim."""
    read = [value_of(study, aim, case) for aim in AIMS]
    return misses(np.array([math.nan if one is None else one for one in read]))


def between(text: str, mark: str, table: str) -> str:
    begin, end = f"<!-- {mark} -->\n", f"<!-- end of {mark} -->"
    before, _, after = text.partition(begin)
    return f"{before}{begin}{table}\n{end}{after.partition(end)[2]}"


def main() -> None:
    study, blind = (vt.simulate(one, workers=1) for one in (CASE, BLIND))
    later = vt.simulate(
        vt.load_case(CASE, {"operation.cycles": SETTLED}), spring_models=[ROD], workers=1
    )
    both = [
        {rpm: one.solution(one.labels[0] if one is later else ROD, rpm * RPM).quantities for rpm in SPEEDS}
        for one in (study, later)
    ]  # fmt: skip
    tables = {
        "aims": aims_table(study, blind),
        "revolutions": revolutions_table(*both),
        "modal model": modal_table(),
        "sweep": sweep_table(),
        "spike": spike_text(study),
        "places": place_text(study),
        "peak": peak_text(both[0][8000], both[1][8000]),
    }
    text = PAGE.read_text(encoding="utf-8")
    for mark, table in tables.items():
        text = between(text, mark, table)
    PAGE.write_text(text, encoding="utf-8")
    write_elsewhere(ROOT, *(one.solution(ROD, 8000 * RPM).quantities for one in (study, blind)))
    sys.stdout.write(f"wrote {PAGE.name}\n")


if __name__ == "__main__":
    main()
