"""Sentences on the facts of a study: the one place where a fact becomes text."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence

from valvetrain.report.text import rpm
from valvetrain.solution.critical import places_text
from valvetrain.solution.definition import label_of, shown
from valvetrain.solution.facts import Fact
from valvetrain.solution.study import Study
from valvetrain.solution.uncertainty import ErrorBars

#: What all facts of one code say together.
Text = Callable[[Sequence[Fact]], Sequence[str]]


def study_notes(study: Study) -> tuple[str, ...]:
    """Sentences on the facts of a study, the remarks of its source, and those on its error bars."""
    return (*fact_notes(study.facts), *study.notes, *error_bar_notes(study.error_bars))


def fact_notes(facts: Sequence[Fact]) -> tuple[str, ...]:
    """A sentence, or more, on the facts of each code."""
    groups: dict[str, list[Fact]] = {}
    for one in facts:
        groups.setdefault(one.code, []).append(one)
    return tuple(text for code, found in groups.items() for text in TEXTS[code](found))


def error_bar_notes(bars: ErrorBars) -> tuple[str, ...]:
    """Sentences on runs without error bars, and on models that further runs contradict."""
    found = []
    if undivided := dict.fromkeys(one.label for one in bars.missing if one.reason == "no-division"):
        found.append(
            f"No error bars: none by {', '.join(undivided)}, whose spring has no division."
        )
    without = [
        f"{one.label} at {rpm(one.engine_speed):.6g} rpm"
        for one in bars.missing
        if one.reason != "no-division"
    ]
    if without:
        more = f" and {len(without) - 3} more" if len(without) > 3 else ""
        found.append(
            f"No error bar of {', '.join(without[:3])}{more}: that run or its repeat did not settle."
        )
    return (*found, *fact_notes(bars.facts))


def _springs(facts: Sequence[Fact]) -> str:
    return " and ".join(dict.fromkeys(repr(one.fields["spring"]) for one in facts))


def _runs(facts: Sequence[Fact]) -> str:
    """Labels and speeds of runs, each once."""
    return ", ".join(dict.fromkeys(_run(one) for one in facts))


def _run(fact: Fact) -> str:
    return f"{fact.fields['label']} at {_rpm(fact)} rpm"


def _rpm(fact: Fact, name: str = "engine_speed") -> str:
    return f"{rpm(float(fact.fields[name])):.6g}"


def _share(value: float) -> str:
    return f"{100 * abs(value):.2g} %"


def _each(template: Callable[[Fact], str]) -> Text:
    return lambda facts: [template(one) for one in facts]


def _whole(template: Callable[[Sequence[Fact]], str]) -> Text:
    return lambda facts: [template(facts)]


def _no_damping(facts: Sequence[Fact]) -> str:
    springs, its = ("springs", "their") if len(facts) > 1 else ("spring", "its")
    return (
        f"The case gives {springs} {_springs(facts)} no damping, so that surge lives on from cycle to cycle: give {its} "
        "damping, such as 'damping = { ratio = 0.016, ratio_frequency = \"600 Hz\" }' at the first surge frequency (0.016: the beehive of "
        "gu2021)."
    )


def _contacts(fact: Fact) -> str:
    places = places_text(str(fact.fields["places"]))
    first, _, last = places.rpartition(", ")
    listed = f"{first} and {last}" if first else last
    return (
        f"Contact stiffness at {listed}: default steel values (Hertz, restitution {fact.fields['restitution']:g}); your file gives none. "
        "Camshaft and pivots are rigid unless the case says otherwise."
    )


def _split(fact: Fact) -> str:
    shares = "; ".join(
        f"{name} {float(fact.fields[f'{name}_rate']) / 1e3:.4g} N/mm, {float(fact.fields[f'{name}_preload']):.4g} N, "
        f"free length {float(fact.fields[f'{name}_free_length']) * 1e3:.4g} mm"
        for name in ("outer", "inner")
    )
    return (
        f"Total loads parted by {fact.fields['rates_by']}, {fact.fields['preloads_by']}: {shares}."
    )


def _chain(fact: Fact) -> str:
    second = float(fact.fields["second_frequency_error"])
    high = f", second frequency {_share(second)} off" if math.isfinite(second) else ""
    return (
        f"Chain of '{fact.fields['spring']}': rate and first frequency ({fact.fields['surge_frequency']:.0f} Hz) of its rod, force at rest "
        f"within {_share(float(fact.fields['force_error']))}{high}; surge and clash are estimates (right: {fact.fields['better']})."
    )


def _card(facts: Sequence[Fact]) -> str:
    return (
        f"{'Springs' if len(facts) > 1 else 'Spring'} {_springs(facts)} known by card alone: no clash of coils, no stress, no mass of end "
        "turns on the retainer; 'valvetrain spring-card' makes the wire."
    )


def _buckles(fact: Fact) -> str:
    limit, opened = (
        f"{float(fact.fields[name]) * 1e3:.4g} mm" for name in ("compression", "open_compression")
    )
    return (
        f"Spring '{fact.fields['spring']}' buckles at {limit} compression by the formula of EN 13906-1, before the {opened} at full lift: "
        "guide it, or make it shorter or wider; 'valvetrain static' finds the place by finite elements."
    )


def _follows(fact: Fact) -> str:
    turns = (
        "" if fact.fields["repeats"] else ", one of its turns over and over, which are not alike"
    )
    return (
        f"{_run(fact)}, one way: train and valve move as with {fact.fields['driver']}{turns}; the solid's force on the retainer differs "
        f"from that one's by {fact.fields['force_difference']:.3g} N root mean square, which is what the train does not feel."
    )


def _spike(facts: Sequence[Fact]) -> str:
    heights = "; ".join(
        f"at {_rpm(one)} rpm {one.fields['raw_force']:.0f} N raw, {one.fields['force_below_5_khz']:.0f} N below 5 kHz"
        for one in facts
    )
    return (
        f"Largest clash spike by the solid: {heights}. The raw height of a clash spike rests on mesh, contact constants "
        "and sampling; compare heights below 5 kHz."
    )


def _above_solid(facts: Sequence[Fact]) -> list[str]:
    springs: dict[str, list[str]] = {}
    for one in facts:
        stress = float(one.fields["stress"])
        told = f", {stress / 1e6:.4g} MPa in its wire" if math.isfinite(stress) else ""
        solid = f"'{one.fields['spring']}' solid at {one.fields['solid_force']:.4g} N (all coils closed, at rest)"
        springs.setdefault(solid, []).append(f"{_run(one)} {one.fields['force']:.4g} N{told}")
    return [
        f"Spring {spring}; peaks are above that, for coils strike one another: {', '.join(runs)}. What is above goes from coil to coil and "
        "does not twist the wire."
        for spring, runs in springs.items()
    ]


def _above_strength(facts: Sequence[Fact]) -> str:
    broken = ", ".join(f"{_run(one)} {float(one.fields['stress']) / 1e6:.4g} MPa" for one in facts)
    return f"No spring wire bears the shear stress of {broken} (above its tensile strength): the numbers there hold for no real spring."


def _between(facts: Sequence[Fact]) -> list[str]:
    speeds: dict[str, list[str]] = {}
    for one in facts:
        text = f"{rpm(float(one.fields['engine_speed'])):.0f}"
        speeds.setdefault(str(one.fields["label"]), []).append(text)
    return [
        f"{label}, runs between the speeds of the sweep, where a cam order meets the first surge frequency of the spring: "
        f"{', '.join(some)} rpm."
        for label, some in speeds.items()
    ]


def _worse(fact: Fact) -> str:
    name = str(fact.fields["quantity"])
    one, other = (
        f"{float(shown(name, float(fact.fields[f'{end}value']))[0]):.4g} {shown(name, 1.0)[1]} at "
        f"{rpm(float(fact.fields[f'{end}engine_speed'])):.0f} rpm"
        for end in ("", "next_")
    )
    return f"{fact.fields['label']}, between the speeds of the sweep: {label_of(name)} {one} ({other})."


def _spread(facts: Sequence[Fact]) -> list[str]:
    speeds: dict[str, list[str]] = {}
    for one in facts:
        name = str(one.fields["quantity"])
        low, high = (
            f"{float(shown(name, float(one.fields[end]))[0]):.3g}" for end in ("low", "high")
        )
        text = f"{label_of(name)} {low} to {high} {shown(name, 1.0)[1]}"
        speeds.setdefault(_rpm(one), []).append(text)
    return [
        f"{speed} rpm, what the calibration data leave open (5 to 95 %): {'; '.join(some)}."
        for speed, some in speeds.items()
    ]


def _too_hard(facts: Sequence[Fact]) -> str:
    far = ", ".join(
        f"{_rpm(one)} rpm (peak {_share(float(one.fields['peak_share']))}, minimum {_share(float(one.fields['minimum_share']))})"
        for one in facts
    )
    return f"Coils clash or swing too hard for reduced-rod at {far}: take finite-element there."


def _run_up(fact: Fact) -> str:
    first, last = _rpm(fact, "first_engine_speed"), _rpm(fact, "last_engine_speed")
    return f"Run-up from {first} to {last} rpm in {fact.fields['duration']:.6g} s, one value per cam revolution."


TEXTS: dict[str, Text] = {
    "assumed-wire": _whole(lambda _: "The finite-element spring of a card is a wire made up for it: rate, preload and mass are the card's, "
        "five active coils with wide gaps are assumed. Its clashes and stresses are not those of the real spring."),
    "default-contacts": _each(_contacts),
    "no-damping": _whole(_no_damping),
    "assumed-ramp": _each(lambda one: f"Ramp of the cam assumed: {math.radians(float(one.fields['velocity'])) * 1e3:.4g} mm per cam degree, "
        "for your card gives none; the seating velocity follows from it (ramp_velocity, ramp_lift)."),
    "split-loads": _each(_split),
    "unused-damping": _whole(lambda facts: f"The damping of {_springs(facts)} has no effect in a spring without inner motion."),
    "not-the-default": _each(lambda one: f"Runs by {one.fields['model']}, not by the default reduced-rod: {one.fields['reason']}."),
    "chain-of-wire": _each(_chain),
    "buckles": _each(_buckles),
    "unknown-solid-height": _each(lambda one: f"Coil bind of spring '{one.fields['spring']}' is not checked: its card gives no solid height; "
        "the clearance is that of the other spring."),
    "card-alone": _whole(_card),
    "ends-pull": _whole(lambda facts: f"The ends of the spring would pull: {_runs(facts)}. Its modes are those of fixed ends, so it shows no "
        "force there but does not lift, and what follows is not right: take wave-rod, multi-mass or finite-element."),
    "ends-bonded": _whole(lambda facts: f"The ends of the spring would lift: {_runs(facts)}. The inactive turns of a solid are bonded to seat "
        "and retainer, so it pulls there; where the ends are not bonded in truth, take finite-element."),
    "follows-a-train": _each(_follows),
    "spike": _whole(_spike),
    "above-solid": _above_solid,
    "above-strength": _whole(_above_strength),
    "between-speeds": _between,
    "worse-between": _each(_worse),
    "calibration-spread": _spread,
    "too-hard": _whole(_too_hard),
    "run-up": _each(_run_up),
}  # fmt: skip
