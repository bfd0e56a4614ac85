"""Tables and sentences of docs/beehive.md from runs, and what the blind spring computes of the values that
the calibrated one was fitted to.

    python -m beehive_study.page              writes them between their marks (two minutes)
"""

from __future__ import annotations

import math
import re
import statistics
import sys
from dataclasses import dataclass
from functools import cache
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

import valvetrain as vt
from beehive_study.modal import forces_of_equation_5
from valvetrain.cam.contract import build_lift_law
from valvetrain.parameters.loading import load_case
from valvetrain.quantities.cycle import reported_cycle
from valvetrain.solution.definition import definition_of
from valvetrain.solution.quantity import Quantity, same_speed
from valvetrain.solution.study import Study
from valvetrain.solution.uncertainty import Comparison, SampleRange
from valvetrain.sources.contract import GU2021

Array = NDArray[np.float64]
ROOT = Path(__file__).resolve().parents[3]
PAGE = ROOT / "docs" / "beehive.md"
STORED = ROOT / "src" / "valvetrain" / "parameters" / "library" / "gu2021-beehive.blind"
CASE, BLIND = "gu2021-beehive", "gu2021-beehive-blind"
ROD, EQUATIONS = "finite-element", "equations 2 and 5"
RPM = math.pi / 30
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


def value_of(study: Study, aim: Aim, case: str = CASE) -> float | None:
    """The number of an aim in its unit, of a run of ``case``; None where the run has none."""
    if aim.model == EQUATIONS:
        names = [(rpm, name) for rpm, name, *_ in MODAL_PEAKS]
        return modal_peaks(case)[names.index((aim.rpm, aim.quantity))]
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


#: Peaks of the source's modal model: engine speed, name of the aim, and where ours is looked for (deg).
MODAL_PEAKS = (
    (4200, "stage_2", 140, 225), (5600, "stage_2", 140, 225), (5600, "stage_3", 232, 262),
    (8000, "stage_2_first", 150, 178), (8000, "stage_2_second", 178, 225), (8000, "stage_3", 245, 300),
)  # fmt: skip


@cache
def modal_peaks(source: str) -> tuple[float, ...]:
    """Force (N) of :data:`MODAL_PEAKS` by equations 2 and 5 on the lift and the static curve of a case;
    the largest value where there is no maximum.
    """
    case = load_case(source)
    curve = vt.static_curve(case)
    assert case.lift_law is not None
    lift = build_lift_law(case.lift_law).lift
    angle = np.arange(720) * DEG / 2
    found = []
    for rpm, _, low, high in MODAL_PEAKS:
        force = forces_of_equation_5(
            lift(angle), rpm * RPM / 2, curve.compression, curve.force, 7 * MM, True
        )
        inside = (angle >= low * DEG) & (angle <= high * DEG)
        inner = (force > np.roll(force, 1)) & (force >= np.roll(force, -1)) & inside
        pick = inner if np.any(inner) else inside
        top = int(np.argmax(np.where(pick, force, -np.inf)))
        found.append(float(force[top]))
    return tuple(found)


def phases_of(study: Study, aim: Aim) -> Array | None:
    """The number of an aim once for each phase of the samples, in its unit; None where it is no sample."""
    found = (
        GU2021.by_phase(study).get(Quantity(aim.quantity, aim.rpm * RPM, ROD)) if aim.rpm else None
    )
    return None if found is None or aim.model == EQUATIONS else FACTORS[aim.unit] * found


def met_at_every_phase(study: Study, aim: Aim) -> bool:
    read = phases_of(study, aim)
    return aim.met(value_of(study, aim)) if read is None else all(map(aim.met, read.tolist()))


def aims_table(study: Study, blind: Study) -> str:
    """How many values are met, and a row per value of the rod: the source, ours in the median with the range
    over the phases, met or not, and the blind spring.
    """
    lines = ["| value | source | calibrated (phases) | met | blind |", "|---" * 5 + "|"]
    met = [aim.met(value_of(study, aim)) for aim in AIMS]
    always = sum(met_at_every_phase(study, aim) for aim in AIMS)
    for aim, yes in zip(AIMS, met, strict=True):
        if aim.model == EQUATIONS:
            continue
        value, other, read = (
            value_of(study, aim),
            value_of(blind, aim, BLIND),
            phases_of(study, aim),
        )
        where = f", {aim.rpm} rpm" if aim.rpm else ""
        ends = [] if read is None else [shown(end, aim.unit) for end in (read.min(), read.max())]
        over = f" ({'–'.join(ends)})" if len(set(ends)) > 1 else ""
        lines.append(
            f"| {aim.group}: {aim.what}{where} | {aim.source} {aim.unit} | {shown(value, aim.unit)}{over} | "
            f"{'yes' if yes else 'no'} | {shown(other, aim.unit)} |"
        )
    modal = [yes for aim, yes in zip(AIMS, met, strict=True) if aim.model == EQUATIONS]
    count = (
        f"{sum(met)} of {len(AIMS)} values are met in the median over the phases, {always} of them at every phase. "
        f"Of these, {sum(modal)} of {len(modal)} are heights of the source's modal model, by its equations on our lift; the others:"
    )
    return "\n".join([count, "", *lines])


def spike_text(study: Study) -> str:
    """The spike at 8000 rpm: its range over the phases, and which stage holds the peak of the cycle."""
    (row,) = (r for r in study.comparisons if (r.quantity, r.origin, round((r.engine_speed or 0) / RPM))
              == ("stage_3_peak_force", "solid finite elements", 8000))  # fmt: skip
    run, read = study.solution(ROD, 8000 * RPM), row.samples
    assert read is not None
    places = GU2021.by_phase(study)[Quantity("stage_3_peak_cam_angle", 8000 * RPM, ROD)] / DEG
    early = float(np.mean(places < 251.0))
    angle, force = GU2021.reader(reported_cycle(run), None, None).sampled(["seat_force"])
    at = np.argmax(force, axis=1)
    event = study.lift_event
    assert event is not None
    late = float(np.mean(angle[np.arange(len(at)), at] >= event.end))
    q = run.quantities
    return (
        f"The source prints a spike of 1430 N at 8000 rpm. Samples of the calibrated spring show {read.low:.0f} to {read.high:.0f} N over "
        f"{read.phases} phases, {row.computed:.0f} N in the median, and 1430 N or more at {100 * read.share:.0f} % of them. At "
        f"{100 * early:.0f} % of the phases the collision at 248 degrees is the highest, at the others that at 254. Stage III holds the largest "
        f"sample of the cycle at {100 * late:.0f} % of the phases (Stage II has {q['stage_2_peak_force']:.0f} N in the median), so the source's "
        "finding that it holds the peak is not reproduced."
    )


#: Kind of a printed value -> dimensions of its quantities.
KINDS = {
    "forces": ("force",),
    "motion": ("length", "velocity", "acceleration"),
    "angles": ("angle",),
}


def unused_text(study: Study) -> str:
    """How far the printed values are off that were not used in the fit, by kind."""
    rows = [row for row in study.comparisons if row.role == "check" and row.difference is not None]
    parts = []
    for kind, dimensions in KINDS.items():
        mine = [
            row
            for row in rows
            if definition_of(row.quantity).dimension in dimensions and row.published
        ]
        if kind == "angles":
            text = f"{statistics.median(abs(r.difference or 0) for r in mine) / DEG:.0f} degrees"
        else:
            text = f"{100 * statistics.median(map(_off, mine)):.0f} %"
        parts.append(f"{kind} {text} ({len(mine)})")
    used = sum(row.role == "calibration" for row in study.comparisons)
    return (
        f"The fit used {used} of the {len(study.comparisons)} printed values. Of the others, {len(rows)} were computed; in the median they are "
        f"off by: {', '.join(parts)}."
    )


def _off(row: Comparison) -> float:
    return abs(row.relative_difference or 0.0)


#: Engine speeds (rpm) of the comparison with the sequel.
SWEEP = (6000, 6800, 7000, 7200, 7400, 8000, 8400, 10000, 13000)


def sweep_table() -> str:
    """Largest half-degree sample of the cycle over engine speed: least, median, largest over the phases."""
    rows: dict[str, list[str]] = {"median, N": [], "over the phases, N": []}
    for rpm in SWEEP:
        run = vt.simulate(CASE, f"{rpm} rpm", models=[ROD], workers=1).solutions[0]
        _, force = GU2021.reader(reported_cycle(run), None, None).sampled(["seat_force"])
        top = force.max(axis=1)
        rows["median, N"].append(f"{np.median(top):.0f}")
        rows["over the phases, N"].append(f"{top.min():.0f}–{top.max():.0f}")
    head = "| engine speed, rpm | " + " | ".join(map(str, SWEEP)) + " |"
    lines = [f"| {name} | {' | '.join(cells)} |" for name, cells in rows.items()]
    return "\n".join([head, "|---" * (len(SWEEP) + 1) + "|", *lines])


def blind_file(blind: Study) -> str:
    """Content of the file next to the calibrated case: what the blind spring computes of each printed value."""
    lines = [
        f"# What {BLIND} computes of the values that {CASE} was fitted to or checked with; SI units, written by",
        "# python -m beehive_study.page.", "", "[case]", f'digest = "{load_case(CASE).record().digest}"',
        f'blind = "{load_case(BLIND).record().digest}"',
    ]  # fmt: skip
    heads: dict[str, dict[str, float]] = {}
    for row in blind.comparisons:
        if row.computed is not None:
            speed = "statics" if row.engine_speed is None else f"{row.engine_speed / RPM:.0f} rpm"
            heads.setdefault(f"{speed}, {row.origin}", {})[row.quantity] = row.computed
    for head, values in heads.items():
        lines += ["", f'["{head}"]', *(f"{name} = {value:.5g}" for name, value in values.items())]
    return "\n".join(lines) + "\n"


def spike_samples(study: Study) -> SampleRange:
    """What the source could have read of the clash spike at 8000 rpm, over the phases of its samples."""
    return next(
        row.samples
        for row in study.comparisons
        if row.samples is not None
        and (row.quantity, row.model) == ("stage_3_peak_force", ROD)
        and same_speed(row.engine_speed, 8000 * RPM)
    )


def readme_row(study: Study, blind: Study) -> str:
    """The range of the spike of both springs in the words of the README."""
    texts = []
    for name, one in (("calibrated", study), ("blind prediction", blind)):
        spike = spike_samples(one)
        texts.append(f"{name} {spike.low:.0f} to {spike.high:.0f} N")
    return ", ".join(texts)


def between(text: str, mark: str, table: str) -> str:
    begin, end = f"<!-- {mark} -->\n", f"<!-- end of {mark} -->"
    before, _, after = text.partition(begin)
    return f"{before}{begin}{table}\n{end}{after.partition(end)[2]}"


def main() -> None:
    study, blind = (vt.simulate(one, workers=1) for one in (CASE, BLIND))
    tables = {
        "values": aims_table(study, blind), "spike": spike_text(study), "unused": unused_text(study), "sweep": sweep_table(),
    }  # fmt: skip
    text = PAGE.read_text(encoding="utf-8")
    for mark, table in tables.items():
        text = between(text, mark, table)
    PAGE.write_text(text, encoding="utf-8")
    STORED.write_text(blind_file(blind), encoding="utf-8")
    readme = (ROOT / "README.md").read_text(encoding="utf-8")
    words = r"calibrated [\d to]+ N, blind prediction [\d to]+ N"
    readme, count = re.subn(words, readme_row(study, blind), readme)
    assert count == 1, "the README has its row of the beehive once"
    (ROOT / "README.md").write_text(readme, encoding="utf-8")
    sys.stdout.write(f"wrote {PAGE.name}\n")


if __name__ == "__main__":
    main()
