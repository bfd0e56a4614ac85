"""docs/quantities.md, written from the tables of quantities."""

from __future__ import annotations

from collections.abc import Sequence
from importlib import import_module
from inspect import getdoc

from valvetrain.quantities.table import AT_REST, RUNS, SWEEP, TRAINS
from valvetrain.registry import BUILT_IN
from valvetrain.solution.definition import QuantityRow, tables

_HEAD = """\
# Named quantities

<!-- Written from the tables of quantities: python scripts/write_quantities.py -->

One name per number, the same in a case's `published` list, in results, in `--json` and in the report. A computed value is found by
name, engine speed (rad/s of the crank; none for what belongs to no run) and label of the run.

All values are SI inside and in JSON; tables show the unit given here. Angles are cam angles, engine speed is crank speed. Forces are
compressive positive and taken over the reported cycle. Motion along the spring is positive from seat to retainer; coil numbers count
from 1 at the seat. In a name, `{n}` and other single letters stand for a number, longer words in braces for a place, a link or a spring.
Quantities of one spring of a nested pair carry its name in front: `outer_coil_bind_clearance`.

A name that stands in no table has the dimension of its last word (`_force`, `_cam_angle`, `_displacement`, ...). A package adds a
table of its own by the entry-point group `valvetrain.quantities`.
"""

_GROUPS: tuple[tuple[str, str, tuple[QuantityRow, ...]], ...] = (
    ("At rest", "Of springs and lift before anything runs; estimates hold for the free state.", AT_REST),
    ("Runs", "Of a run, for a spring under prescribed motion and for springs in a train.", RUNS),
    ("Trains", 'Of one steady cycle of a train. "Open" means that the rigid lift is above a tenth of its maximum.', TRAINS),
    ("Sweeps", "Of a sweep over engine speeds.", SWEEP),
)
_SYSTEMS = {("spring", "train"): "both", ("spring",): "spring", ("train",): "train"}

_JSON = """\
## Keys of `--json`

One object per command, the same shape for all; a command leaves out what it does not compute. A number stands as
`{"value": ..., "unit": ...}`, SI except the engine speed (rpm of the crank); what could not be computed is null. `quantities` is an
object from the names above to such numbers.

| key | content |
|---|---|
| `command`, `case`, `title` | what was asked |
| `completed` | true when nothing failed |
| `quantities` | what belongs to no run |
| `runs` | per run `label`, `spring_model`, `spring_set`, `engine_speed`, `status`, `quantities`, `events` |
| `status` | `code` (`completed`, `not-converged`, `diverged`, `solid`, `interrupted`); unless completed also `message`, `time`, `where`, `remedy` |
| `events` | per event `kind`, `cam_angle`, `time`, `duration`, `size`, `where`, `details` |
| `comparisons` | per published value `quantity`, `engine_speed`, `model`, `published_by`, `role`, `published`, `computed`, `difference`, `tolerance`, `verdict`, `source` |
| `findings`, `notes` | findings of the source beside what was computed; sentences on where a prediction misses |
| `cite` | references behind the results |
| `folder`, `files`, `page` | where the results were written |
| `static_curve` | of `static`: `compression`, `force`, `stiffness`, each with `values` and `unit`; `largest_compression` beside it |
| `modes` | of `modes`: per mode `mode`, `natural_frequency`, `axial_transmission_ratio`, `axial`; `compression` beside it |
| `spring_model`, `elements_per_coil` | of `static` and `modes`: what computed it |
| `holds`, `facts` | of `check`: tables of the case; what it says, in words |
| `cases` | of `cases`: per case `name`, `title`, `holds`, `sources`; with a name, `text` of the file instead |
| `uncertainties` | of `refine`: per number `quantity`, `engine_speed`, `value`, `numerical_uncertainty`, `observed_order` (null: not monotonic), `extrapolated`, `step_part`, and `contact_stiffness`, `contact_damping` each with `least` and `largest` |
"""  # noqa: E501  a row of a table is one line


def quantities_page() -> str:
    """The whole page: general quantities by group, those of each published study, and the keys of ``--json``."""
    parts = [_HEAD, *(f"## {title}\n\n{lead}\n\n{_table(rows)}" for title, lead, rows in _GROUPS)]
    parts += [_study(word, place) for word, place in BUILT_IN["quantities"].items() if word != "general"]
    return "\n".join([*parts, _JSON])


def _study(word: str, place: str) -> str:
    """Section of one published study, led by what the module of its rows says at its top."""
    lead = getdoc(import_module(place.partition(":")[0])) or ""
    return f"## Of the study {word}\n\n{lead}\n\n{_table(tables()[word])}"


def _table(rows: Sequence[QuantityRow]) -> str:
    lines = ["| quantity | in words | shown in | of | definition |", "|---|---|---|---|---|"]
    for one in rows:
        better = f" ({one.sense})" if one.sense else ""
        lines.append(f"| `{one.name}` | {one.label} | {one.shown_unit or '1'} | {_SYSTEMS[one.systems]} | {one.definition}{better} |")
    return "\n".join(lines) + "\n"
