"""Writes tests/net/numbers.csv: every quantity of a dozen cases with its tolerance.

A change of the source must leave these numbers in place. Where one moves for a reason, run this script,
read the list of old and new numbers that it prints, and give the reason in the commit.

Use: python scripts/write_net.py             compute all, print what moved, write the file
     python scripts/write_net.py vaz-ohc     the jobs of one case alone; the other rows stay
"""

from __future__ import annotations

import csv
import math
import sys
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple

import valvetrain as vt
from valvetrain.solution.quantity import unit_of

ROOT = Path(__file__).resolve().parents[1]
FOLDER = ROOT / "tests" / "net"
NUMBERS = FOLDER / "numbers.csv"
HEAD = ("case", "engine_speed_rpm", "model", "spring_set", "quantity", "value", "unit", "kind", "tolerance")  # fmt: skip


class Key(NamedTuple):
    """What a number belongs to; ``engine_speed`` is a text in rpm. Speed and model are empty for a case at rest."""

    case: str
    engine_speed: str
    model: str
    spring_set: str
    quantity: str

    def __str__(self) -> str:
        return ", ".join(filter(None, self))


@dataclass(frozen=True)
class Entry:
    """A stored number (SI) with its unit, the kind of its tolerance, and the tolerance; NaN: not compared."""

    value: float
    unit: str
    kind: str
    tolerance: float


@dataclass(frozen=True)
class Job:
    """Runs of one case: a library case, a template, or a file in tests/net. Without speeds the case at rest alone.

    ``sweep``: its critical speeds between the first and the last speed. ``rest``: with its quantities at rest.
    """

    case: str
    models: tuple[str, ...] = ()
    speed: str = ""
    spring_set: str = ""
    sweep: bool = False
    rest: bool = True

    def __str__(self) -> str:
        return " ".join(filter(None, (self.case, *self.models, self.speed, self.spring_set)))


#: Motions that settle, or that end before rounding grows: two processors agree on all of them to 2 parts in 10^4.
JOBS = (
    Job("clamped-helix"),
    Job("uniform-spring"),
    Job("gu2021-beehive", ("finite-element",), "4200"),
    Job("gu2021-beehive", ("finite-element",), "8000", rest=False),
    Job("gu2021-beehive", ("modal-varied", "wave-rod-clash"), "8000", rest=False),
    Job("gu2021-beehive-blind", ("modal-varied",), "5600"),
    Job("job-c", ("multi-mass", "modal-uniform"), "8000"),
    Job("job-t", ("massless", "reduced-rod"), "8000"),
    Job("tdi-pushrod", ("modal-uniform", "wave-rod"), "4000"),
    Job("tdi-pushrod", ("massless",), "6800:7600:200", "stock", sweep=True),
    Job("vaz-ohc", ("modal-uniform", "wave-rod-clash"), "4136"),
    Job("template spring", ("multi-mass", "wave-rod"), "6000"),
    Job("template direct", ("multi-mass",), "3000"),
    Job("template finger", ("modal-varied",), "5500"),
    Job("template rocker", ("wave-rod-clash",), "5500"),
    Job("template pushrod", ("modal-uniform",), "6000"),
    Job("template pushrod", ("massless",), "5000:8000:1000", sweep=True),
    Job("ls-v8.toml", ("modal-uniform",), "6600", "mydual"),
    Job("ls-v8.toml", ("reduced-rod",), "6600", "wire"),
    Job("ls-v8.toml", ("multi-mass",), "6600", "dual"),
)

#: How well a run is resolved, not what it says.
OF_NUMERICS = (
    "energy_imbalance_ratio", "steady_residual_ratio", "steady_tolerance_ratio", "steady_cycles_count", "steps_per_cycle_count",
)  # fmt: skip
#: Words of quantities that an impact decides, of coils or at the seat.
OF_IMPACTS = ("clash", "raw_peak", "bounce", "seat_contact", "peak_valve_acceleration")
#: Relative tolerances; the last one is that of an impact without an error bar.
AT_REST, SETTLED, IMPACT = 1e-6, 1e-3, 0.05
#: Sizes that count as zero, by unit; 1e-9 of any other.
FLOORS = {"N": 1e-3, "Pa": 1.0, "Hz": 1e-6, "rad/s": 1e-6, "m/s2": 1e-3, "N/m": 1e-3, "W": 1e-3, "J": 1e-6, "N s": 1e-6}  # fmt: skip
#: Of the angles of extremes: a thousandth of a turn of the cam. Of critical speeds: what their search resolves.
ANGLE, CRITICAL = 2e-3 * math.pi, 10 * math.pi / 30


def path_of(case: str) -> str:
    """Argument of the package for the case of a job."""
    if case.startswith("template "):
        return str(Path(vt.__file__).parent / "templates" / f"{case.split()[1]}.toml")
    return str(FOLDER / case) if case.endswith(".toml") else case


def compute(job: Job, bars: bool = False) -> dict[Key, Entry]:
    """All numbers of a job; with ``bars`` the tolerances of impacts are error bars, which need further runs."""
    arguments: dict[str, Any] = {"models": list(job.models)}
    if job.spring_set:
        arguments["spring_sets"] = job.spring_set
    if job.sweep:
        found = vt.critical_speeds(path_of(job.case), f"{job.speed} rpm", **arguments, ranges=False)
        return {
            Key(job.case, "", row.label, job.spring_set, f"{row.kind} speed"): Entry(
                row.deciding_speed if not row.found else row.engine_speed,
                "rad/s",
                "critical speed",
                CRITICAL,
            )
            for row in found.rows
        }
    if job.speed:
        arguments["engine_speeds"] = f"{job.speed} rpm"
    study = vt.simulate(path_of(job.case), **arguments, compute="error_bars" if bars else ())
    numbers: dict[Key, Entry] = {}
    for label, values in study.still.items() if job.rest else ():
        for name, value in values.items():
            numbers[Key(job.case, "", "", label, name)] = _entry(name, value, "at rest", None)
    bar_of = {
        (bar.label, bar.quantity): bar.numerical for bar in (study.error_bars.rows if bars else ())
    }
    for run in study.solutions:
        assert run.status.completed, f"{job}: {run.status.sentence()}"
        for name, value in run.quantities.items():
            if name not in OF_NUMERICS:
                key = Key(job.case, job.speed, run.model, run.spring_set, name)
                impact = any(word in name for word in OF_IMPACTS)
                kind = "impact" if impact else "settled"
                numbers[key] = _entry(name, value, kind, bar_of.get((run.label, name)))
    return numbers


def _entry(name: str, value: float, kind: str, bar: float | None) -> Entry:
    """A number with the tolerance of its kind."""
    unit = unit_of(name)
    share = {"at rest": AT_REST, "settled": SETTLED, "impact": IMPACT}[kind]
    tolerance = share * abs(value) + FLOORS.get(unit, 1e-9)
    if kind == "settled" and name.endswith("_cam_angle"):
        kind, tolerance = "angle", ANGLE
    elif kind == "impact" and name.endswith("_count"):
        tolerance = 1.0 + share * abs(value)
    elif kind == "impact" and name.endswith("_cam_angle"):
        tolerance = ANGLE if bar is None else max(bar, ANGLE)
    elif kind == "impact" and bar is not None:
        tolerance = max(bar, SETTLED * abs(value))
        if tolerance > abs(value):
            kind, tolerance = "not resolved", math.nan
    return Entry(float(value), unit, kind, float(tolerance))


def read(path: Path = NUMBERS) -> dict[Key, Entry]:
    """The stored numbers."""
    with path.open(encoding="utf-8", newline="") as stream:
        return {
            Key(*row[:5]): Entry(float(row[5]), row[6], row[7], float(row[8]))
            for row in list(csv.reader(stream))[1:]
        }


def write(numbers: Mapping[Key, Entry], path: Path = NUMBERS) -> None:
    """Stores numbers, a row each."""
    with path.open("w", encoding="utf-8", newline="") as stream:
        table = csv.writer(stream, lineterminator="\n")
        table.writerow(HEAD)
        for key, entry in numbers.items():
            table.writerow([*key, f"{entry.value:.9g}", entry.unit, entry.kind, f"{entry.tolerance:.2g}"])  # fmt: skip


def moved(old: Mapping[Key, Entry], new: Mapping[Key, Entry]) -> list[str]:
    """A line for each number that is new, gone, or further from the stored one than its tolerance."""
    lines = [f"{key}: gone, was {old[key].value:.6g}" for key in old if key not in new]
    for key, entry in new.items():
        if (was := old.get(key)) is None:
            lines.append(f"{key}: new, {entry.value:.6g} {entry.unit}")
        elif not _same(was, entry.value):
            lines.append(
                f"{key}: {was.value:.9g} -> {entry.value:.9g} {was.unit} ({was.kind}, tolerance {was.tolerance:.2g})"
            )
    return lines


def _same(stored: Entry, value: float) -> bool:
    if math.isnan(stored.tolerance) or stored.value == value:
        return True
    if not math.isfinite(stored.value):
        return repr(stored.value) == repr(value)
    return abs(value - stored.value) <= stored.tolerance


def belongs(key: Key, job: Job) -> bool:
    """Whether a stored number is one that a job computes."""
    if key.case != job.case or (job.spring_set and key.spring_set not in (job.spring_set, "")):
        return False
    if job.sweep:
        return key.quantity.endswith(" speed")
    if not key.model:
        return job.rest
    return key.engine_speed == job.speed and key.model in job.models


def stored(job: Job, numbers: Mapping[Key, Entry]) -> dict[Key, Entry]:
    """The stored numbers of a job."""
    return {key: entry for key, entry in numbers.items() if belongs(key, job)}


def main(cases: Iterable[str]) -> None:
    """Computes the jobs of some cases, or all, prints what moved, and writes the file."""
    cases, old = set(cases), read() if NUMBERS.is_file() else {}
    new: dict[Key, Entry] = {}
    for job in JOBS:
        if cases and job.case not in cases:
            new |= stored(job, old)
            continue
        numbers = compute(job, bars=True)
        print(f"{job}: {len(numbers)} numbers", flush=True)
        for line in moved(stored(job, old), numbers):
            print(f"  {line}")
        new |= numbers
    write(new)
    print(f"{len(new)} numbers written to {NUMBERS.relative_to(ROOT)}")


if __name__ == "__main__":
    main(sys.argv[1:])
