"""Which of two springs is stressed more, by stress amplitude and peak against what its wire is
permitted, and why: stress per force, swing of the force, surge and clash.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from valvetrain.report.clauses import Runs, Worst, joined, quantity_text
from valvetrain.solution.result import Solution
from valvetrain.units.reader import reader_factor, reader_unit

#: Share below which two numbers count as equal.
ALIKE = 0.01
#: Share below which two stresses do not show which wire breaks first: EN 10270-2 lets the strength of one
#: wire size differ by more.
SIGNIFICANT = 0.05
#: Least surge (N) and clash energy (J) that are a reason.
LEAST_SURGE, LEAST_CLASH = 1.0, 1e-5
PEAK, MINIMUM = "open_nominal_shear_stress", "closed_nominal_shear_stress"
OWN_PEAK, OWN_AMPLITUDE = "peak_shear_stress", "largest_amplitude_shear_stress"
UNCORRECTED, PERMITTED = "open_uncorrected_shear_stress", "permitted_shear_stress"


@dataclass(frozen=True)
class WireStress:
    """Stress of the wire of a spring (SI) where it is worst: ``amplitude``, half of largest less least
    of a ``run``, and ``peak``, of the wire in motion where the model computes it, else at rest between
    closed and largest lift; ``uncorrected`` one at rest and what of it is ``permitted``; ``swing`` of the
    force (N) in that run and ``per_force`` (Pa/N); NaN for unknown.
    """

    amplitude: float
    peak: float
    uncorrected: float
    permitted: float
    swing: float
    per_force: float
    run: Solution

    @property
    def use(self) -> float:
        """Peak over what is permitted, as a measure of the strength of the wire; the peak itself where
        that is unknown.
        """
        return self.peak / self.permitted if math.isfinite(self.permitted) else self.peak

    @property
    def share(self) -> float:
        """Uncorrected peak over what is permitted."""
        return self.uncorrected / self.permitted


def wire_stress(runs: Runs) -> WireStress | None:
    """The stress of the wire over the runs; of a pair of springs that of the one with the
    larger amplitude, None without a wire.
    """
    found = [
        one for name in ("", "outer_", "inner_") if (one := _of_spring(runs, name)) is not None
    ]
    return max(found, key=lambda one: one.amplitude, default=None)


def _of_spring(runs: Runs, name: str) -> WireStress | None:
    peak = runs.worst(f"{name}{OWN_PEAK}", False) or runs.worst(f"{name}{PEAK}", False)
    if peak is None:
        return None

    def amplitude(run: Solution) -> float:
        own = runs.value(run, name + OWN_AMPLITUDE)
        at_rest = [runs.value(run, name + one) for one in (PEAK, MINIMUM)]
        return own if math.isfinite(own) else (at_rest[0] - at_rest[1]) / 2

    known = [run for run in runs.solutions if math.isfinite(amplitude(run))]
    worst = max(known, key=amplitude, default=peak.run or runs.solutions[0])
    force, least = (
        runs.value(worst, f"{name}{one}") for one in ("peak_spring_force", "minimum_spring_force")
    )
    factor, preload = (
        runs.value(worst, name + one) for one in ("installed_nominal_shear_stress", "preload")
    )
    per_force = factor / preload if preload else math.nan
    plain, permitted = (
        runs.value(peak.run or runs.solutions[0], name + one) for one in (UNCORRECTED, PERMITTED)
    )
    swing = force - least
    return WireStress(amplitude(worst), peak.value, plain, permitted, swing, per_force, worst)


def stress_clause(names: list[str], pair: list[Runs]) -> tuple[str, str]:
    """Which spring is stressed more, and why; both empty where a wire is unknown.

    Two springs of one wire break by amplitude and peak; where these name different springs, the one
    that alone passes the static limit of its wire is named, else both are. Differences below
    :data:`SIGNIFICANT` or inside the error bars do not count.
    """
    first, second = (wire_stress(runs) for runs in pair)
    if first is None or second is None:
        return "", ""
    both = (first, second)
    swing = _larger(first.amplitude, second.amplitude, _bar(pair, both))
    comparable = math.isfinite(first.permitted) == math.isfinite(second.permitted)
    uses = [one.use if comparable else one.peak for one in both]
    peak = _larger(uses[0], uses[1], SIGNIFICANT)
    passed = [one.share > 1 for one in both]
    if swing is None and peak is None:
        numbers = f"({(_amplitude(*both) + _peak(*both)).removeprefix(', ')})"
        if sum(passed) == 1:
            return f"{names[passed.index(True)]} alone passes the static limit of its wire, though stressed hardly more {numbers}", ""  # fmt: skip
        return f"stress does not show which breaks first {numbers}", ""
    place = peak if swing is None else swing
    assert place is not None
    more, less = both[place], both[1 - place]
    if swing is not None and peak not in (None, swing):
        ends = f"{names[swing]} has the larger stress amplitude ({_amplitude(more, less)[10:]})"
        other = f"{names[1 - swing]} the larger peak stress ({_peak(less, more)[7:]})"
        if sum(passed) == 1:
            return f"{names[passed.index(True)]} alone passes the static limit of its wire: {ends}, {other}", ""  # fmt: skip
        return f"{ends}, {other}: the fatigue chart of the wire decides which breaks first", ""
    parts = [_amplitude(more, less), _peak(more, less)[2:]]
    if swing is None and parts[0]:  # alike, so that it is no reason
        parts = [parts[1], f"amplitude of both {quantity_text(PEAK, more.amplitude)}"]
    numbers = ", ".join(filter(None, parts))
    why = _reasons((more, less), (pair[place], pair[1 - place]))
    said = f"{names[place]} is stressed more, so of equal wires it breaks first ({numbers})"
    return said, f"why {names[place]} is stressed more: {why}" if why else ""


def _bar(pair: list[Runs], both: tuple[WireStress, WireStress]) -> float:
    """Share by which two amplitudes have to differ: :data:`SIGNIFICANT`, or their error bars together."""
    bars = [
        sum(
            runs.bar(Worst(name, runs.value(one.run, name), one.run), 0.0)
            for name in (OWN_AMPLITUDE,)
        )
        for runs, one in zip(pair, both, strict=True)
    ]
    largest = max(one.amplitude for one in both)
    return max(SIGNIFICANT, sum(bars) / largest) if largest > 0 else SIGNIFICANT


def _larger(first: float, second: float, least: float = ALIKE) -> int | None:
    """Which of two is larger by more than a share ``least``; None where they are alike or one is unknown."""
    if not abs(first - second) > least * max(abs(first), abs(second)):
        return None
    return 0 if first > second else 1


def _amplitude(one: WireStress, other: WireStress) -> str:
    if not (math.isfinite(one.amplitude) and math.isfinite(other.amplitude)):
        return ""
    return f"amplitude {_against(one.amplitude, other.amplitude)}"


def _peak(one: WireStress, other: WireStress) -> str:
    """``, peak 858 MPa against 821 MPa, 66 % against 63 % of the static limit``; of one known share
    that alone.
    """
    shares = [f"{100 * part.share:.0f} %" for part in (one, other) if math.isfinite(part.share)]
    if len(shares) == 1:
        values = [quantity_text(PEAK, part.peak) for part in (one, other)]
        place = 0 if math.isfinite(one.share) else 1
        values[place] += f" ({shares[0]} of its static limit)"
        return f", peak {values[0]} against {values[1]}"
    limit = f", {' against '.join(shares)} of the static limit" if shares else ""
    return f", peak {_against(one.peak, other.peak)}{limit}"


def _against(first: float, second: float, name: str = PEAK) -> str:
    return f"{quantity_text(name, first)} against {quantity_text(name, second)}"


def _reasons(stress: tuple[WireStress, WireStress], pair: tuple[Runs, Runs]) -> str:
    """``its force swings more (497 N against 460 N, surge there 76 N against 59 N)``; empty for none."""
    more, less = stress
    found = []
    if _larger(more.per_force, less.per_force) == 0:
        factor = 1e-6 * reader_factor("MPa") / reader_factor("N")
        values = [f"{factor * one.per_force:.3g}" for one in stress]
        unit = f"{reader_unit('MPa')}/{reader_unit('N')}"
        found.append(
            f"its wire bears more stress per force ({values[0]} against {values[1]} {unit})"
        )
    if _larger(more.swing, less.swing) == 0:
        force = _against(more.swing, less.swing, "peak_spring_force")
        found.append(f"its force swings more ({force}{_waves(stress, pair)})")
    return joined(found) if found else ""


def _waves(stress: tuple[WireStress, WireStress], pair: tuple[Runs, Runs]) -> str:
    """Surge and clash of the runs of both swings, where they are more in the larger."""
    text = ""
    for name, noun, least in (
        ("surge_amplitude_force", "surge", LEAST_SURGE),
        ("clash_energy", "clash energy", LEAST_CLASH),
    ):
        ours, theirs = (
            Worst(name, runs.value(one.run, name), one.run)
            for runs, one in zip(pair, stress, strict=True)
        )
        larger = _larger(ours.value, theirs.value) == 0 and ours.value - theirs.value > least
        if larger and _resolved(pair, (ours, theirs)):
            texts = [runs.text(one) for runs, one in zip(pair, (ours, theirs), strict=True)]
            text += f", {noun} there {texts[0]} against {texts[1]}"
    return text


def _resolved(pair: tuple[Runs, Runs], found: tuple[Worst, Worst]) -> bool:
    """Whether both are above their error bars."""
    return all(runs.bar(one) <= abs(one.value) for runs, one in zip(pair, found, strict=True))
