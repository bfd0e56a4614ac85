"""Columns of angle and lift in a text of any form, whatever its name ends in."""

from __future__ import annotations

import io
import re

import numpy as np

from valvetrain.measurements.content import text_of
from valvetrain.measurements.lift_formats.contract import LiftColumns, LiftFormat, LiftTable
from valvetrain.measurements.text_table import UNIT_WORDS, TextTable, read_text_table

#: Words of a heading -> what the column is; the first that fits.
_MEANINGS = (
    (r"acc|beschl|mm/deg2|mm/deg\^2", "acceleration"), (r"vel|geschw|speed|mm/deg|in/deg", "velocity"),
    (r"intake|inlet|einlass", "intake"),
    (r"exhaust|auslass|outlet", "exhaust"), (r"lift|hub|displacement|rise", "lift"),
    (r"angle|deg|winkel|theta|crank|cam|°|rotation", "angle"),
)  # fmt: skip


def recognise(content: bytes, name: str) -> bool:
    """Whether it is text at all."""
    return b"\0" not in content or content[:2] in (b"\xff\xfe", b"\xfe\xff")


def read(content: bytes, name: str) -> LiftColumns:
    """The columns of a text, with what its headings say of them."""
    return from_table(read_text_table(text_of(content, name), name), "columns")


def from_table(table: TextTable, form: str) -> LiftColumns:
    """Columns with the meaning that headings give them, and what the headings say of crank, cam, valve and tappet."""
    columns = tuple(_meaning(name) for name in table.names)
    units = tuple(_unit(unit) for unit in table.units)
    whole = "angle" in columns and set(columns) & {"lift", "intake", "exhaust"} and len(set(columns)) == len(columns)
    if table.rows.shape[1] == 2 and not whole:
        columns, units = ("angle", "lift"), tuple(unit if unit in fits else "" for unit, fits in zip(units, _FITTING, strict=True))
    said: dict[str, str] = {}
    words = " ".join((*table.names, *table.units, *table.headings)).lower()
    for question, choices in (("angle_of", ("crank", "cam")), ("lift_of", ("valve", "tappet"))):
        found = [word for word in choices if re.search(_CHOICES[word], words)]
        if len(found) == 1:
            said[question] = found[0]
    return LiftColumns(form, table.rows, columns, units, said, table.headings)


#: Units that an angle and a lift can have.
_FITTING = (("deg", "rad"), ("mm", "inch", "thou", "m", "cm", "um"))
#: Words of headings by which a question is answered; where both answers occur the heading does not tell.
_CHOICES = {
    "crank": r"\bcrank\b|°\s*kw\b|\bkw\b|degca\b|\bca\b|crankshaft",
    "cam": r"\bcam(shaft)?\s*(angle|deg|rotation|°)|°\s*nw\b|\bnw\b|°\s*cam\b|deg\s*cam",
    "valve": r"\bvalve\s*lift", "tappet": r"\b(tappet|lobe|cam|follower|lifter)\s*lift",
}  # fmt: skip


def _meaning(name: str) -> str:
    return next((word for pattern, word in _MEANINGS if re.search(pattern, name.lower())), "") if name else ""


def _unit(unit: str) -> str:
    return UNIT_WORDS.get(unit.lower().strip(), "")


def write(table: LiftTable) -> bytes:
    """Comma-separated text that says all it means: cam degrees and mm."""
    out = io.StringIO()
    out.write(f"# {table.lift_of} lift over the cam angle; zero of the angle: {table.zero}\n")
    out.write(",".join(["cam angle [deg]", *(f"{_lobe(name)}{table.lift_of} lift [mm]" for name in table.names)]) + "\n")
    rows = np.column_stack([np.degrees(table.cam_angles), 1e3 * table.lifts])
    out.writelines(",".join(f"{value:.6f}" for value in row) + "\n" for row in rows)
    return out.getvalue().encode()


def _lobe(name: str) -> str:
    return f"{name} " if name in ("intake", "exhaust") else ""


SPEC = LiftFormat("columns of a text", recognise, read, write)
