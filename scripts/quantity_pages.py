"""docs/quantities.md and docs/plausible.md, written from the tables of quantities and of plausible values."""

from __future__ import annotations

import math
from collections.abc import Sequence

from valvetrain.quantities.plausible import TABLES
from valvetrain.quantities.table import AT_REST, CAM, EVENTS, RUNS, SCATTER, SWEEP, TRAINS
from valvetrain.registry import BUILT_IN, find
from valvetrain.solution.definition import QuantityRow, tables

_HEAD = """\
# Named quantities

<!-- Written from the tables of quantities: python scripts/write_pages.py quantities -->

One name per number, the same in a case's `published` list, in results, in `--json` and in the report. A computed value is found by
name, engine speed (rad/s of the crank; none for what belongs to no run) and label of the run.

All values are SI inside and in JSON; tables show the unit given here. Angles are cam angles, engine speed is crank speed. Forces are
compressive positive and taken over the reported cycle. Motion along the spring is positive from seat to retainer; coil numbers count
from 1 at the seat. In a name, `{n}` and other single letters represent a number, longer words in braces for a place, a link or a spring.
Quantities of one spring of a nested pair carry its name in front: `outer_coil_bind_clearance`;
loads, rates and masses of both together: `pair_card_preload`.

A name that is in no table has the dimension of its last word (`_force`, `_cam_angle`, `_displacement`, ...). A package adds a
table of its own by the entry-point group `valvetrain.quantities`.
"""

_GROUPS: tuple[tuple[str, str, tuple[QuantityRow, ...]], ...] = (
    (
        "At rest",
        "Of springs and lift before anything runs; estimates hold for the free state.",
        AT_REST,
    ),
    (
        "Cam",
        "Of the lift law and the cam's contour before anything runs, as `valvetrain check` lists them.",
        CAM,
    ),
    ("Runs", "Of a run, for a spring under prescribed motion and for springs in a train.", RUNS),
    (
        "Trains",
        'Of one steady cycle of a train. "Open" means that the rigid lift is above a tenth of its maximum.',
        TRAINS,
    ),
    (
        "Valve events",
        "Of a train: opening and closing, in cam angle, and the crank angle between them.",
        EVENTS,
    ),
    ("Scatter of a train", "Of a train whose motion does not repeat: over 8 cycles.", SCATTER),
    ("Loss of control", "Of a sweep over engine speeds, and by rigid theory.", SWEEP),
)
_SYSTEMS = {("spring", "train"): "both", ("spring",): "spring", ("train",): "train"}

_JSON = """\
## Keys of `--json`

One object per command, the same shape for all; a command leaves out what it does not compute. A number is written as
`{"value": ..., "unit": ...}`, SI except the engine speed (rpm of the crank); what could not be computed is null. `quantities` is an
object from the names above to such numbers.

| key | content |
|---|---|
| `command`, `case`, `title`, `digest` | the request; the fingerprint of the resolved case file |
| `changed` | key paths set from outside the file |
| `completed`, `failures` | true when nothing failed; a sentence per part that did, numbers that could not be found and files that could not be written among them |
| `quantities`, `quantities_by_label` | what belongs to no run; the same by label, such as what a sweep found |
| `critical_speeds` | of a sweep of a train: a row per label and `kind` (`contact-loss`, `float`, `bounce`) with its `limit`, the speeds `searched`, `engine_speed` (null for never) with its one `range` (an end beyond the speeds searched is null), what its ends come from (`range_causes`) and each of its `members` with its `cause` (`model`, `damping`, `step`, `mesh`, `force`, `revolution`, `ends`), `change`, own speed and, where it cannot run, `refusal`, its kind `onset` (`sharp`, `graze`, `non-repeating`), ranges of speeds at which the ends of the spring would pull, `pulled`, and all of it as `text`, all `ranges` of lost control as the speed rises (an end beyond the speeds searched is null), how many of the first are short ones that an engine passes at once (`short_count`), below which speed control returns as the speed falls where that differs by more than such a range (`falling_engine_speed`), and short ranges in single revolutions, `passed` |
| `springs_at_rest` | per spring and model `spring`, `model`, `precompression`, and what was found of `static_curve` and `modes` |
| `static_curve` | `status`; `compression`, `force`, `stiffness`, each with `values` and `unit` |
| `modes` | `status`, `compression`, and per mode `mode`, `natural_frequency`, `axial_transmission_ratio`, `axial` (number among the axial modes, or null) |
| `train_modes` | of `modes` of a train: per variant and `state` (`closed`, `full_lift`) `label`, `cam_angle`, `valve_lift`, `closed` and `open` contacts, and per mode `natural_frequency`, `shape` by body, `energy_share` by body and spring |
| `runs` | per run `label`, `model`, `spring_set`, `engine_speed`, `status`, `quantities`, `clash_count`, `events`, `options`, `statistics`, `passed_limits` where a result passes one of [the limits](limits.md) (by quantity `value`, `unit`, `reason`), and `gaps` where a number of it could not be found |
| `status` | `code` (`completed`, `not-converged`, `diverged`, `out-of-range`, `coil-bind`, `solid`, `buckled`, `refused`, `interrupted`, `worker-lost`); `message` where there is one; unless completed also `time`, `where`, `remedy` |
| `events` | per event `kind`, `cam_angle`, `time`, `duration`, `size`, `where`, `details`; of a clash `lower_coil`, `upper_coil`, `impulse`, `energy`, `peak_cam_angle` |
| `options`, `statistics` | of a run: options of its model, and step, counts, residuals; numbers as value and unit, unit `1` for counts and shares |
| `comparisons` | per published value `quantity`, `engine_speed`, `model`, `published_by`, `role`, `used_for`, `doubt`, `reading`, `published`, `computed`, `difference`, `tolerance`, `blind` (by the case that was not fitted to it), `verdict`, `source`, `samples` (where the source stored samples: `low`, `high`, `share_at_or_above` the published value, number of `phases`) |
| `findings` | what the runs show, the verdict first: `code`, `level`, `text`, `reason`, `step`, `quantity`, `value`, `limit`, `label`, `engine_speed`, and the `fields` of its text; `valvetrain findings CODE` explains one. Commands other than `run` and `run-up`: findings of the source |
| `source_findings` | findings of the source next to what was computed (`run`, `run-up`) |
| `rests_on` | what the numbers rest on: per fact its `code`, and its values by name |
| `notes` | remarks of the source |
| `cite` | references behind the results |
| `created_at`, `command_line`, `versions`, `choices` | of a saved run: when, by what, with which packages; engine speeds, models and sets that were run |
| `folder`, `files`, `page` | where the results were written |
| `holds`, `facts`, `durations` | of `check`: tables of the case; what it says, in words; crank angle above every lift that matters, per row `lift`, `crank_angle` |
| `cases` | of `cases`: per case `name`, `title`, `holds`, `sources`; with a name, `text` of the file instead |
| `uncertainties` | error bars, stored or computed: per number `quantity`, `label` of the run, `engine_speed`, `value`, `numerical_uncertainty`, `resolved` (false: the bar is larger than the value), `observed_order` (null: not monotonic), `extrapolated`, `step_part`, `range` (null: not computed) with `low`, `high` and the constants that move it (`by`), and `rests_on_contact_constants` |
| `without_error_bars` | completed runs that have none: `label`, `engine_speed`, `code` (`no-division`, `not-repeated`) |
| `inputs`, `results` | of `compare-runs`, with the folders `a` and `b`: per input `key`, `a`, `b`; per number `quantity`, `run`, `a`, `b`, `difference`, and `bar`, the sum of both error bars (null: none is stored); `failed` of each |
| `runs` | of the command `runs`: per saved run `created_at`, `case`, `digest`, `asked`, `spring_models`, `engine_speeds`, `completed`, `state`, `headline`, `verdict` (its first finding, where one was stored), `folder`; `unfinished` runs with `state`, `finished_runs`, `command_line` |
| `error` | in place of all of these: `message`, `where`, `code` (the exit code) |
"""  # noqa: E501  a row of a table is one line


def quantities_page() -> str:
    """The whole page: general quantities by group, those of each published study, and the keys of
    ``--json``.
    """
    parts = [_HEAD, *(f"## {title}\n\n{lead}\n\n{_table(rows)}" for title, lead, rows in _GROUPS)]
    parts += [_study(word) for word in BUILT_IN["quantities"] if word != "general"]
    return "\n".join([*parts, _JSON])


def _study(word: str) -> str:
    """Section of one published study, led by its description."""
    lead = find("sources", word).description.strip()
    return f"## Of the study {word}\n\n{lead}\n\n{_table(tables()[word])}"


def _table(rows: Sequence[QuantityRow]) -> str:
    lines = ["| quantity | in words | shown in | of | definition |", "|---|---|---|---|---|"]
    for one in rows:
        better = f" ({one.sense})" if one.sense else ""
        lines.append(
            f"| `{one.name}` | {one.label} | {one.shown_unit or '1'} | {_SYSTEMS[one.systems]} | {one.definition}{better} |"
        )
    return "\n".join(lines) + "\n"


def plausible_page() -> str:
    """The text of docs/plausible.md: every range with its reason."""
    lines = [
        "# Plausible values\n",
        "Equations have solutions for numbers that no valvetrain has. Beyond these ranges a request is refused before it is run,",
        "and a run, or a static curve, that reaches one ends with the status `diverged`, with its numbers. `--implausible`, or",
        "`implausible=True` in Python, accepts all of them; `scripts/write_pages.py plausible` writes this page.\n",
        "| | quantity | minimum | maximum | reason |",
        "|---|---|---|---|---|",
    ]
    for kind, ranges in TABLES.items():
        for one in ranges:
            low, high = (
                ("" if math.isinf(value) else f"{value / one.scale:g} {one.unit}".strip())
                for value in (one.low, one.high)
            )
            names = ", ".join(
                f"`{head}`" if head == tail else f"`{head}*{tail}`" for head, tail in one.names
            )
            shown = f" ({names})" if kind == "of a run" else ""
            lines.append(f"| {kind} | {one.label}{shown} | {low} | {high} | {one.reason} |")
    lines += [
        "",
        "Numbers of a case lie within the ranges of its tables; no option accepts others. An unusual value that has its unit (a rate of",
        "1 N/m, an engine speed above 30 000 rpm) is taken as written, with a warning; a bare number of Python there is refused as a slip.",
        "",
    ]
    return "\n".join(lines)
