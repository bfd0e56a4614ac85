"""What the identifications of the beehive tell in words: sentences, searches and contradictions,
every number from what is kept.
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from typing import Any

from valvetrain.parameters.summary import number
from valvetrain.solution.definition import label_of, shown

#: The draws about the likeliest point of the joint study, the study of all data, and the case that
#: meets what the joint studies aim at.
BANDS, ANGLES, BEEHIVE_JOINT = (
    "joint, bands",
    "joint with angles",
    "[beehive-joint.toml](../examples/beehive-joint.toml)",
)
#: What the joint studies aim at: words, quantities, share of the published value.
TARGETS = (
    (
        "Stage II peaks",
        ("stage_2_peak_force", "stage_2_first_peak_force", "stage_2_second_peak_force"),
        0.05,
    ),
    ("spikes of Stage III", ("stage_3_every_instant_peak_force",), 0.2),
    ("displacements of node 2", ("node_2_maximum_displacement",), 0.1),
)
SPEED = re.compile(r"^(\d+) rpm, ")


def measured_of(answer: Mapping[str, Any]) -> dict[str, tuple[float, float]]:
    """Key -> published value and its scatter, SI."""
    return {
        one["key"]: (one["measured"]["value"], one["scatter"]["value"])
        for one in answer["measurements"]
    }


def words_of(key: str) -> str:
    """A measurement in words: ``4200 rpm: stage 2 peak force``."""
    speed = SPEED.match(key)
    return (f"{speed[1]} rpm: " if speed else "at rest: ") + label_of(key.rpartition(": ")[2])


def in_unit(name: str, value: float) -> str:
    told, unit = shown(name, value)
    return number(float(told), 4 if unit == "deg" else 3)


def sentences(kept: Mapping[str, Any]) -> tuple[str, ...]:
    """What the data tell and what not, in five sentences, every number and verdict from what is
    kept.
    """
    blind, joint = kept["blind"], kept[likeliest(kept)]
    ahead = [row for row in blind["measurements"] if not row["fitted"]]
    fitted = [row for row in kept[BANDS]["measurements"] if row["fitted"]]
    told = measured_of(joint)
    without = [
        row
        for name, one in kept.items()
        if name.startswith("without ")
        for row in one["measurements"]
        if row["key"].startswith(f"{name.removeprefix('without ')}, ") and row["key"] in told
    ]
    known = sorted(
        (name for name, share in blind["told"].items() if share > 0.5),
        key=lambda name: -blind["told"][name],
    )
    open_ = [name for name, share in blind["told"].items() if share < 0.1]
    short = unfinished(kept)
    return (
        f"From statics, modes and 4200 rpm alone {_inside(ahead)} of the {len(ahead)} values published at 5600 and 8000 rpm lie within "
        f"the central 95 % of the draws{_outside(ahead)}.",
        f"Those data determine {_named(known)} (more than half of the variance of the prior is gone) and say next to nothing of "
        f"{_named(open_)} (less than a tenth).",
        f"Fitted to all three speeds, the likeliest spring and lift have {_near(joint)}"
        f"{_all_at_once([kept['joint'], kept[BANDS]], BEEHIVE_JOINT)}; "
        f"{_inside(fitted)} of {len(fitted)} fitted values lie within the central 95 % of the draws about the likeliest{_outside(fitted)}.",
        _with_angles(kept),
        f"Each speed from the other two: {_inside(without)} of {len(without)} values lie within the central 95 %"
        + _outside(without)
        + (
            f". The searches {listed(short)} did not come to their end, so that their misses prove nothing."
            if short
            else "."
        ),
    )


def likeliest(kept: Mapping[str, Any]) -> str:
    """The joint study, or the walkers about its likeliest point where they came to a lesser misfit."""
    return min(("joint", BANDS), key=lambda name: float(kept[name]["misfit"]))


def _near(study: Mapping[str, Any]) -> str:
    """How near the likeliest point of a study comes to what the joint studies aim at."""
    rows = study["measurements"]
    return ", ".join(_met(rows, *target) for target in TARGETS) + _beside(rows)


def _with_angles(kept: Mapping[str, Any]) -> str:
    """What the study that fits angles and velocities too has of its aims, and what it misses that
    others meet, which see less.
    """
    study, heights = kept[ANGLES], kept[BANDS]
    only = {row["key"] for row in heights["measurements"] if not row["fitted"]}
    added = [row for row in study["measurements"] if row["fitted"] and row["key"] in only]
    near = [
        row
        for row in added
        if abs(row["computed"]["value"] - row["measured"]["value"]) <= 2 * row["scatter"]["value"]
    ]
    return (
        f"Fitted to {len(added)} more angles and velocities, the likeliest have {len(near)} of these within two scatters and "
        f"{_near(study)}{_all_at_once([study])}; {_contradictions(kept, [row for row in study['measurements'] if _apart(row) > 0])}."
    )


def _contradictions(kept: Mapping[str, Any], never: Sequence[Mapping[str, Any]]) -> str:
    """Of what the study of all data misses, what lies within reach of a search that sees less of
    them, or of none that was fitted to it.

    A search that is told as not at its end proves nothing.
    """
    if not never:
        return "the central 95 % of its draws come within two scatters of every published value: no contradiction is shown"
    missed = f"the central 95 % of its draws miss {listed([_missed(row) for row in never])} by more than two scatters"
    freed: dict[str, list[str]] = {}
    less = {"without the angles": kept[BANDS]} | {
        name: one
        for name, one in kept.items()
        if name.startswith("without ") and name not in unfinished(kept)
    }
    for row in never:
        meets = [
            name
            for name, one in less.items()
            if any(
                other["key"] == row["key"] and other["fitted"] and _apart(other) <= 0
                for other in one["measurements"]
            )
        ]
        freed.setdefault(listed(meets, "or") if meets else "", []).append(words_of(row["key"]))
    told = []
    for name, words in freed.items():
        verb, these = ("are", "them") if len(words) > 1 else ("is", "it")
        told.append(
            f"{listed(words)} {verb} within reach {name or f'of no search that was fitted to {these}'}"
        )
    return f"{missed}: {'; '.join(told)}"


def searches(kept: Mapping[str, Any]) -> str:
    """A row per search: its method, the points it computed, the misfit it ends at and what it says
    of itself.
    """
    lines = [
        "| study | method | points | least misfit | what the search says of itself |",
        "|---|---|---|---|---|",
    ]
    for name, one in kept.items():
        lines.append(
            f"| {name} | {one['method']} | {one['points']} | {one['misfit']:.1f} | {_said(kept, name)} |"
        )
    return "\n".join(lines)


def conflicts(kept: Mapping[str, Any]) -> str:
    """What the likeliest springs of both joint studies miss, what meeting it costs and what is
    missed instead.
    """
    lines = [
        "| study | missed by its likeliest spring and lift | by, in scatters | computed points that meet it | misfit of the "
        "likeliest of them, above the least | it misses instead |",
        "|---|---|---|---|---|---|",
    ]
    for name in (likeliest(kept), ANGLES):
        for row in kept[name]["conflicts"]:
            instead = [
                f"{words_of(one['key'])} ({one['scatters']:+.1f})" for one in row["missed_instead"]
            ]
            lines.append(
                f"| {name} | {words_of(row['key'])} | {row['scatters']:+.1f} | {row['points_that_meet_it']} | "
                + (
                    f"{row['cost']:.1f} | {listed(instead) if instead else 'nothing more'} |"
                    if row["points_that_meet_it"]
                    else "– | – |"
                )
            )
    return (
        "\n".join(lines)
        if len(lines) > 2
        else "The likeliest springs of both joint studies miss no value by more than two scatters."
    )


def unfinished(kept: Mapping[str, Any]) -> list[str]:
    """Searches that leave a speed out and end above the joint ones, which meet their data and more:
    they have not come to their end.
    """
    return [
        name
        for name, one in kept.items()
        if name.startswith("without ") and _ends_above(one, kept[likeliest(kept)])
    ]


def _ends_above(one: Mapping[str, Any], other: Mapping[str, Any]) -> bool:
    """Whether a search ends above ``other``, of the same quantities."""
    return bool(
        one["quantities"].keys() == other["quantities"].keys() and one["misfit"] > other["misfit"]
    )


def _said(kept: Mapping[str, Any], name: str) -> str:
    """Warnings of a search, those of single quantities and of combinations counted."""
    warnings = kept[name]["warnings"]
    hardly, apart = (
        sum(words in one for one in warnings) for words in ("hardly tell", "cannot tell")
    )
    own = [one for one in warnings if "hardly tell" not in one and "cannot tell" not in one]
    best = likeliest(kept)
    if name in unfinished(kept):
        own += [
            f"not at its end: the joint study meets these data and more at {kept[best]['misfit']:.1f}"
        ]
    if name == "joint" and _ends_above(kept[name], kept[best]):
        own += [f"not at its end: the walkers of its bands come to {kept[best]['misfit']:.1f}"]
    own += (
        [f"{hardly} {'quantity is' if hardly == 1 else 'quantities are'} hardly told"]
        if hardly
        else []
    )
    own += (
        [f"{apart} {'combination is' if apart == 1 else 'combinations are'} not told apart"]
        if apart
        else []
    )
    return "; ".join(own) or "nothing"


def _inside(rows: Sequence[Mapping[str, Any]]) -> int:
    return sum(
        row["low"]["value"] <= row["measured"]["value"] <= row["high"]["value"] for row in rows
    )


def _outside(rows: Sequence[Mapping[str, Any]]) -> str:
    """Values outside their interval by speed, in words: their numbers stand in the table."""
    found: dict[str, list[str]] = {}
    for row in rows:
        if not row["low"]["value"] <= row["measured"]["value"] <= row["high"]["value"]:
            speed, _, words = words_of(row["key"]).partition(": ")
            found.setdefault(speed, []).append(words)
    told = [
        f"{speed if speed == 'at rest' else f'at {speed}'} {listed(words)}"
        for speed, words in found.items()
    ]
    return f"; outside: {'; '.join(told)}" if found else ""


def _missed(row: Mapping[str, Any]) -> str:
    name = row["key"].rpartition(": ")[2]
    low, high = (in_unit(name, row[end]["value"]) for end in ("low", "high"))
    return f"{words_of(row['key'])} ({low} to {high}, published {in_unit(name, row['measured']['value'])} {shown(name, 1.0)[1]})"


def _apart(row: Mapping[str, Any]) -> float:
    """By how much the interval misses the published value and two of its scatters."""
    value, room = row["measured"]["value"], 2 * row["scatter"]["value"]
    return float(max(row["low"]["value"] - (value + room), value - room - row["high"]["value"]))


def _met(rows: Sequence[Mapping[str, Any]], words: str, names: Sequence[str], share: float) -> str:
    here = _aimed_at(rows, names)
    return f"{len(here) - len(_far(here, share))} of {len(here)} {words} within {100 * share:.0f} %"


def _beside(rows: Sequence[Mapping[str, Any]]) -> str:
    """What the likeliest spring and lift have of each value that lies outside its target."""
    far = [row for _, names, share in TARGETS for row in _far(_aimed_at(rows, names), share)]
    told = []
    for row in far:
        name = row["key"].rpartition(": ")[2]
        computed, published = (
            in_unit(name, row[which]["value"]) for which in ("computed", "measured")
        )
        told.append(
            f"{words_of(row['key'])} ({computed}, published {published} {shown(name, 1.0)[1]})"
        )
    return f"; outside: {listed(told)}" if told else ""


def _all_at_once(studies: Sequence[Mapping[str, Any]], case: str = "") -> str:
    """Whether computed points of the studies have all of it at once; ``case``: link to the case
    that is the first one's.
    """
    told, points, met = (
        studies[0]["targets"],
        *(sum(one["targets"][name] for one in studies) for name in ("points", "meet_all")),
    )
    search = "search" if len(studies) == 1 else "searches"
    if not met:
        return f"; none of the {points} springs that the {search} computed has all {told['aims']} at once"
    have = f"; {met} of the {points} springs that the {search} computed {'has' if met == 1 else 'have'} all {told['aims']} at once"
    if not told["meet_all"]:
        return have
    above = told["inside"]["misfit"] - min(one["misfit"] for one in studies)
    return f"{have}, the one farthest inside them{case and f' ({case})'} at a misfit {above:.1f} above the least"


def _aimed_at(rows: Sequence[Mapping[str, Any]], names: Sequence[str]) -> list[Mapping[str, Any]]:
    return [row for row in rows if row["key"].rpartition(": ")[2] in names]


def _far(rows: Sequence[Mapping[str, Any]], share: float) -> list[Mapping[str, Any]]:
    return [
        row for row in rows if abs(row["computed"]["value"] / row["measured"]["value"] - 1) > share
    ]


def _named(names: Sequence[str]) -> str:
    return listed([name.replace("_", " ") for name in names]) if names else "none of the quantities"


def listed(words: Sequence[str], last: str = "and") -> str:
    return f" {last} ".join([", ".join(words[:-1]), words[-1]]) if len(words) > 1 else words[0]
