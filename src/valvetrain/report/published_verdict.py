"""How the published values of a case compare: by role and kind of quantity, and the furthest by name;
what the case was fitted to, and why nothing was compared.
"""

from __future__ import annotations

import math
import statistics
from collections.abc import Sequence

from valvetrain.report.clauses import figure, joined
from valvetrain.report.text import percent, rpm, speed_text
from valvetrain.solution.comparison import Comparison
from valvetrain.solution.definition import label_of
from valvetrain.solution.provenance import CaseRecord
from valvetrain.solution.quantity import unit_of
from valvetrain.solution.study import Study

ROLES = ("calibration", "check", "prediction")
#: SI units -> kind of the quantities in them; all others are of the last kind.
KINDS = {"N": "forces", "m": "motion", "m/s": "motion", "m/s2": "motion", "rad": "angles"}
KIND_NAMES = ("forces", "motion", "angles", "others")
#: A value of a kind, as it is counted: singular and plural.
NOUNS = {
    "forces": ("force", "forces"),
    "motion": ("motion", "motions"),
    "angles": ("angle", "angles"),
}
#: How the first of these sentences begins.
COMPARED = "Compared with the source"
#: Values that are named as the furthest from the published ones.
NAMED = 3
#: Fitted values up to which each is named; the table of a case whose parts are named, not itself.
MAX_NAMES, SPRING = 3, "spring"


def kind_of(name: str) -> str:
    """Kind of a quantity among :data:`KIND_NAMES`.

    >>> kind_of("preload"), kind_of("stage_2_peak_cam_angle"), kind_of("mode_1_frequency")
    ('forces', 'angles', 'others')
    """
    return KINDS.get(unit_of(name), KIND_NAMES[-1])


def published_sentences(rows: Sequence[Comparison]) -> str:
    """How the published values of a case compare; empty without any that was computed.

    Roles and kinds are given apart, since a median over values that were fitted and values that were
    predicted describes neither. Values in doubt are left out; angles count in degrees, and the
    furthest of them is named apart, since no share of an angle compares with a share of a force.
    """
    sure = [row for row in rows if row.difference is not None and not row.doubt]
    angles = [row for row in sure if kind_of(row.quantity) == "angles"]
    shares = [row for row in sure if row not in angles and row.relative_difference is not None]
    if not shares and not angles:
        return ""
    if len(shares) + len(angles) == 1:
        (row,) = shares or angles
        return f"{COMPARED}: the published value of {label_of(row.quantity)} differs by {_median([row])}."
    compared = [*shares, *angles]
    texts = [f"{COMPARED}, median (count): {_count(rows, len(compared))}."]
    for role in dict.fromkeys((*ROLES, *(row.role for row in compared))):
        groups = [
            (kind, mine)
            for kind in KIND_NAMES
            if (mine := [r for r in compared if (r.role, kind_of(r.quantity)) == (role, kind)])
        ]
        sizes = {_median(mine) for _, mine in groups}
        if len(groups) > 1 and len(sizes) == 1:  # no kind differs from another
            groups = [("all", [row for _, mine in groups for row in mine])]
        cells = [f"{kind} {_median(mine)} ({len(mine)})" for kind, mine in groups]
        if cells:
            texts.append(f"{role.capitalize()}: {', '.join(cells)}.")
    worst = sorted(shares, key=lambda row: -abs(row.relative_difference or 0.0))
    named = worst[: min(NAMED, max(1, len(shares) - 1))]
    if angles:
        named.append(max(angles, key=lambda row: abs(row.difference or 0.0)))
    sets = ({row.engine_speed for row in compared} - {None}, {row.engine_speed for row in named})
    several = any(len(speeds) > 1 for speeds in sets)
    ends = [_named(row, several) for row in named]
    if angles:
        ends[-1] = f"{'and ' if shares else ''}of the angles {ends[-1]}"
    return " ".join([*texts, f"Furthest: {', '.join(ends)}."])


def _count(rows: Sequence[Comparison], compared: int) -> str:
    """``110 of 120 values, 9 not computed, 1 is zero``."""
    doubtful = sum(bool(row.doubt) for row in rows)
    missing = sum(row.difference is None for row in rows if not row.doubt)
    zero = len(rows) - doubtful - missing - compared
    left = {
        "not computed": missing,
        "is zero" if zero == 1 else "are zero": zero,
        "in doubt": doubtful,
    }
    whole = f"{compared} of {len(rows)}" if compared < len(rows) else f"{compared}"
    why = (f"{count} {text}" for text, count in left.items() if count)
    return ", ".join([f"{whole} values", *why])


def _median(rows: Sequence[Comparison]) -> str:
    """The median size of the differences of one kind, with its unit."""
    if kind_of(rows[0].quantity) == "angles":
        off = statistics.median(abs(math.degrees(row.difference or 0.0)) for row in rows)
        return f"{figure(off)} deg"
    return share(statistics.median(abs(row.relative_difference or 0.0) for row in rows))


def _named(row: Comparison, with_speed: bool) -> str:
    known = with_speed and row.engine_speed is not None
    where = f" at {speed_text(row.engine_speed or 0.0)}" if known else ""
    if kind_of(row.quantity) == "angles":
        degrees = math.degrees(row.difference or 0.0)
        by = f"{'+' if degrees > 0 else ''}{figure(degrees)} deg".replace("-", "−")
    else:
        by = percent(row.relative_difference or 0.0)
    return f"{label_of(row.quantity)}{where} {by}"


def share(value: float) -> str:
    """A positive share in per cent."""
    return "less than 0.1 %" if 0 <= value < 5e-4 else percent(value).lstrip("+")


def calibration_sentence(record: CaseRecord) -> str:
    """What of a case was fitted to published values, and to which; empty of a case without identified
    values, and of a changed one.

    >>> calibration_sentence(CaseRecord("own"))
    ''
    """
    fitted = [value for value in record.published if value.role == "calibration"]
    parts = _identified(record)
    if not fitted or not parts or record.changed:
        return ""
    names = list(dict.fromkeys(label_of(value.quantity) for value in fitted))
    if len(names) > MAX_NAMES:
        counts = {
            kind: sum(kind_of(value.quantity) == kind for value in fitted) for kind in KIND_NAMES
        }
        names = [
            f"{count} {NOUNS.get(kind, ('other', kind))[count > 1]}"
            for kind, count in counts.items()
            if count
        ]
    whole = f"{len(fitted)} of its {len(record.published)} published values"
    verb = "were" if len(parts) > 1 else "was"
    return f"calibrated: {joined(parts)} {verb} fitted to {whole} ({', '.join(names)})"


def _identified(record: CaseRecord) -> list[str]:
    """What of a case was identified: parts of its spring, and other tables."""
    found: dict[str, None] = {}
    for value in record.values:
        if value.status == "identified":
            table, _, key = value.path.partition(".")
            found[key.partition(".")[0] if table == SPRING and key else table] = None
    return [name.replace("_", " ") for name in found]


def not_compared_sentence(study: Study) -> str:
    """Why a study has no comparison with published values; empty where it has one."""
    record, ran = study.record, study.engine_speeds
    if study.comparisons:
        return ""
    given = sorted({v.engine_speed for v in record.published if v.engine_speed is not None})
    if not record.study and not record.published:
        why = "the case gives none and names no published study"
    elif record.changed:
        keys, verb = (
            joined([f"'{key}'" for key in record.changed]),
            "was" if len(record.changed) == 1 else "were",
        )
        why = f"{keys} {verb} changed, and published values are of the case without changes"
    elif study.command == "sweep":
        why = "a sweep over engine speed is not compared; 'valvetrain run' is"
    elif (
        given and ran and not all(any(math.isclose(s, g, rel_tol=1e-6) for g in given) for s in ran)
    ):
        speeds = joined([f"{rpm(speed):.6g}" for speed in given])
        why = f"those of the case are of {speeds} rpm; leave the engine speed out, or give one of these"
    else:
        why = "no run gave a quantity that is published"
    return f"No published value is compared: {why}."
