"""Columns of numbers in a text of any form: separators, quotes, decimal commas, thousands marks,
headings and their units.
"""

from __future__ import annotations

import codecs
import contextlib
import io
import re
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from valvetrain.arrays import Array
from valvetrain.errors import InputError
from valvetrain.parameters.bounded_file import bounded_bytes
from valvetrain.units import unit_factor

#: A number as tables write it, once its line is parted at every mark that may be between or
#: within numbers; a comma may be decimal or part thousands.
_NUMBER = re.compile(r"[-+]?(?:\d+\.?\d*|\.\d+)(?:[eEdD][-+]?\d+)?")
_STRONG = re.compile(r"[;\t|,]")
_MARKS = re.compile(r"[;\t|,\s\x01]+")
#: A cell in quotes, and what stands for the marks within it, the first for a comma.
_QUOTED, _INNER = re.compile(r'"([^"]*)"'), "\x01\x02\x03\x04"
_HIDE, _SHOW = str.maketrans(",;\t|", _INNER), str.maketrans(_INNER, ",;\t|")
#: A whole number parted in thousands.
_GROUPED = re.compile(r"[-+]?[1-9]\d{0,2}([.,])\d{3}(?:\1\d{3})*")
#: Blanks and apostrophes that part thousands; signs that look like a minus.
_THIN = re.compile(r"(?<=\d)[\u00a0\u202f\u2009'\u2019](?=\d{3}(?!\d))")
_GAP = re.compile(r"(?<=\d) (?=\d{3}(?!\d))")
_MINUS = str.maketrans("\u2212\u2013", "--")
#: Blanks in a row beyond these have no meaning; a heading longer than this names no columns.
_BLANKS, MAX_HEADING_LENGTH = re.compile(r"(\s{8})\s+"), 1000
#: Lines above the numbers among which the names of the columns are looked for.
HEADINGS = 100
#: Marks that begin a line of text.
COMMENTS = ("#", "%", "!", "//", "*", "'")
#: Most columns of a table of lifts; more is another kind of file.
MAX_COLUMNS = 12
#: Most lines of such a table; longer texts are refused before any line is read.
MAX_LINES = 50_000
#: Characters from which on a text is read by the form that its first ones show; most numbers of
#: one that is not alike throughout, which is read line by line.
LONG, MAX_UNLIKE_NUMBERS = 200_000, 20_000_000
#: Pattern that separates columns -> the delimiter that numpy reads by, where it can.
_DELIMITERS = {";": ";", r"\|": "|", "\t": "\t", r"\s+": None, ",": ",", r",\s+": ","}


@dataclass(frozen=True, eq=False)
class TextTable:
    """``rows`` (rows, columns) of numbers, the ``headings`` (lines of text before them) and names
    of columns with their units.

    ``names`` and ``units`` have one entry a column, empty where the headings give none.
    ``first_line``: number of the line the rows begin on, from 1.
    """

    rows: Array
    headings: tuple[str, ...]
    names: tuple[str, ...]
    units: tuple[str, ...]
    first_line: int

    def last_digit(self, column: int) -> float:
        """Value of the last digit that a column is written with; 0 of one with more than six decimals."""
        values = self.rows[:, column]
        for decimals in range(7):
            if np.allclose(values, np.round(values, decimals), rtol=0, atol=1e-9):
                return float(10.0**-decimals)
        return 0.0


def read_text_table(
    text: str,
    name: str,
    max_columns: int = MAX_COLUMNS,
    max_lines: int = MAX_LINES,
    gaps: bool = False,
) -> TextTable:
    """The table of numbers in ``text``; lines of text may precede it and, marked as comments, be in it.

    Semicolons, tabs, bars, commas or blanks part the columns; a decimal comma is read where
    something else does. ``name`` of the file is for messages. ``gaps``: an empty cell, or ``nan``,
    holds NaN. Raises :class:`InputError` naming the line that is not as long as the others or not
    numbers, and for a text of more than ``max_lines``.
    """
    count = text.rstrip("\n").count("\n") + 1
    if count > max_lines:
        raise InputError(
            f"{name} has {count} lines, more than {max_lines}; thin it out, or cut it to one cycle"
        )
    if len(text) > LONG:
        with contextlib.suppress(InputError, ValueError, KeyError):
            return _long_table(text, name, max_columns, gaps)
    return _table_by_lines(text, name, max_columns, gaps)[0]


def _long_table(text: str, name: str, max_columns: int, gaps: bool) -> TextTable:
    """The table of a long text by the form of its first lines. Raises an error where the rest has another."""
    first = text[: text.index("\n", LONG // 2) + 1]
    head, separator = _table_by_lines(first, name, max_columns, gaps)
    delimiter = _DELIMITERS[separator]
    body: Array = np.loadtxt(
        io.StringIO(text if delimiter == "," else text.replace(",", ".")),
        delimiter=delimiter,
        comments=list(COMMENTS),
        skiprows=head.first_line - 1,
        ndmin=2,
        converters=(lambda cell: float(cell.strip() or "nan")) if gaps else None,
    )
    unknown = np.isinf(body) if gaps else ~np.isfinite(body)
    if unknown.any() or not np.array_equal(body[: len(head.rows)], head.rows, equal_nan=True):
        raise ValueError(name)
    return replace(head, rows=body)


def _table_by_lines(text: str, name: str, max_columns: int, gaps: bool) -> tuple[TextTable, str]:
    """The table, and the pattern that separates its columns."""
    headings: list[str] = []
    lines: list[tuple[int, str]] = []
    every = text.splitlines()
    for number, line in enumerate(every, start=1):
        content = _plain(line, gaps)
        if not content.strip():
            continue
        if not _is_row(content, gaps) or content.lstrip().startswith(COMMENTS):
            if lines and not line.strip().startswith(COMMENTS):
                raise InputError(
                    f"line {number} of {name} is no row of numbers: '{content[:40]}'; correct it or mark it with #"
                )
            headings.append(content.strip().lstrip("#%!/*'\" ").rstrip("'\""))
            continue
        lines.append((number, content if gaps else content.strip(",;| \t")))
    if not lines:
        raise InputError(
            f"{name} holds no row of numbers; export the table as text with one station a line"
        )
    separator = column_separator([content for _, content in lines])
    width = len(re.split(separator, lines[0][1]))
    if len(lines) * width > MAX_UNLIKE_NUMBERS:
        raise InputError(
            f"{name} holds more than {MAX_UNLIKE_NUMBERS} numbers in rows that are not alike; correct those that differ, or cut it"
        )
    rows = [re.split(separator, content) for _, content in lines]
    for (number, _), row in zip(lines, rows, strict=True):
        if len(row) != width:
            raise InputError(
                f"line {number} of {name} has {len(row)} numbers, the first row {width}; make the rows alike"
            )
    if width > max_columns:
        what = "a table of lifts" if max_columns == MAX_COLUMNS else "a table of channels"
        raise InputError(f"{name} has {width} columns; {what} has at most {max_columns}")
    if gaps:
        rows = [[cell.strip() or "nan" for cell in row] for row in rows]
    values = _values(rows, [number for number, _ in lines], name)
    beyond = np.isinf(values).any(axis=1)
    if beyond.any():
        raise InputError(
            f"{name} holds a number beyond all bounds in line {lines[int(np.argmax(beyond))][0]}"
        )
    return TextTable(values, tuple(headings), *_columns(headings, width), lines[0][0]), separator


def comments_in(text: str) -> dict[str, list[str]]:
    """Values by key, in small letters, of the lines ``# key: value``."""
    values: dict[str, list[str]] = {}
    for line in text.splitlines():
        if line.lstrip().startswith("#"):
            key, _, value = line.strip().lstrip("# ").partition(":")
            values.setdefault(key.strip().lower().replace("_", " "), []).append(value.strip())
    return values


def rows_of_words(text: str) -> list[tuple[int, list[str]]]:
    """Line number and cells of each line that is no comment; the strongest mark of the first parts them."""
    lines = [
        (number, _plain(line, gaps=True))
        for number, line in enumerate(text.splitlines(), start=1)
        if line.strip() and not line.lstrip().startswith("#")
    ]
    mark = next((mark for mark in ";\t|," if lines and mark in lines[0][1]), ",")
    return [
        (number, [cell.strip().translate(_SHOW) for cell in line.split(mark)])
        for number, line in lines
    ]


def _plain(line: str, gaps: bool) -> str:
    """The line without quotes; a mark within a quoted cell is no separator, tabs at the ends may be."""
    content = line.strip(" " if gaps else None).translate(_MINUS)
    if '"' in content:
        content = _QUOTED.sub(lambda cell: cell[1].strip().translate(_HIDE), content)
    return _BLANKS.sub(r"\1", _THIN.sub("", content))


def _is_row(line: str, gaps: bool) -> bool:
    """Whether a line holds numbers and marks alone; in one pass, whatever it holds."""
    parts = [part for part in _MARKS.split(line) if part and not (gaps and part.lower() == "nan")]
    return (bool(parts) or gaps) and all(map(_NUMBER.fullmatch, parts))


def column_separator(lines: list[str]) -> str:
    """Pattern that separates the columns: the strongest mark that is in most lines; a comma is decimal
    where another one is.
    """
    sample = lines[:200]
    for pattern, mark in (
        (";", ";"),
        ("\t", "\t"),
        (r"\|", r"\|"),
        (r",\s", r",\s+"),
        (r"[\d.,]\s+[-+.,\d]", r"\s+"),
    ):
        if 2 * sum(re.search(pattern, line) is not None for line in sample) > len(sample):
            return mark
    alone = all(
        line.count(",") <= 1 and "." not in line for line in sample
    )  # decimal commas of one column
    if any("," in line for line in sample) and not (
        alone and any("," not in line for line in sample)
    ):
        return ","
    return r"[;\t|]"


def _values(rows: list[list[str]], numbers: list[int], name: str) -> Array:
    """The numbers in cells, once it is clear which mark is decimal and which parts thousands."""
    cells = [[_GAP.sub("", cell.strip()).translate(_SHOW) for cell in row] for row in rows]
    every = [cell for row in cells for cell in row]
    thousands = ""
    for mark, other in (",.", ".,"):
        marked = [cell for cell in every if mark in cell]
        both = [cell for cell in marked if other in cell]
        if thousands or not all(cell in both or _GROUPED.fullmatch(cell) for cell in marked):
            continue
        if both and all(cell.rindex(mark) < cell.index(other) for cell in both):
            thousands = mark
        elif marked and not both:
            apart = any(other in cell for cell in every) or _smoother(cells, mark)
            thousands = mark if apart else thousands
    values = []
    for number, row in zip(numbers, cells, strict=True):
        try:
            values.append([number_of(cell.replace(thousands, "")) for cell in row])
        except ValueError as error:
            raise InputError(
                f"line {number} of {name} is not separated as the others are: '{' '.join(row)[:40]}'; make the rows alike"
            ) from error
    return np.array(values)


def number_of(cell: str) -> float:
    """A number with a decimal point or comma. Raises ValueError for another text."""
    return float(cell.replace(",", ".").replace("D", "e").replace("d", "e"))


def _smoother(cells: list[list[str]], mark: str) -> bool:
    """Whether the columns change more evenly with ``mark`` parting thousands than as a decimal."""

    def jump(column: list[str]) -> float:
        values = np.array(list(map(number_of, column)))
        return float(np.max(np.abs(np.diff(values)), initial=0.0) / (np.ptp(values) or 1.0))

    columns = [
        [*column] for column in zip(*cells, strict=True) if any(mark in cell for cell in column)
    ]
    return all(
        jump([cell.replace(mark, "") for cell in column]) < 0.75 * jump(column)
        for column in columns
    )


def _columns(headings: list[str], width: int) -> tuple[tuple[str, ...], tuple[str, ...]]:
    """Names and units of the columns from the last heading that has as many parts; a row of units
    may follow the names.
    """
    for place in range(len(headings) - 1, max(-1, len(headings) - 1 - HEADINGS), -1):
        parts = (
            _parts(headings[place], width) if len(headings[place]) <= MAX_HEADING_LENGTH else None
        )
        if parts is None:
            continue
        names, units = zip(*map(name_and_unit, parts), strict=True)
        alike = place > 0 and bool(_STRONG.search(headings[place - 1])) == bool(
            _STRONG.search(headings[place])
        )
        above = _parts(headings[place - 1], width) if alike else None
        known = sum(map(_is_unit, parts))  # an unknown unit makes the others no names
        if above is not None and 2 * known >= width and known > sum(map(_is_unit, above)):
            return tuple(above), tuple(part.strip("[]() ") for part in parts)
        return tuple(names), tuple(units)
    return ("",) * width, ("",) * width


def _parts(heading: str, width: int) -> list[str] | None:
    # a unit in brackets belongs to the word before it
    for pattern in (r"[;\t|]", r",", r"\s{2,}", r"\s+(?![\[(])", r"\s+"):
        parts = [part.strip().translate(_SHOW) for part in re.split(pattern, heading.strip())]
        if len(parts) == width and all(parts):
            return parts
    return None


def name_and_unit(part: str) -> tuple[str, str]:
    """Name and unit of a heading such as ``lift [mm]``, ``lift in mm``, ``lift / mm`` or ``lift mm``."""
    found = re.fullmatch(r"(.*?)\s*(?:[\[(]\s*([^\])]*?)\s*[\])]|\bin\s+(\S+)|/\s*(\S+))\s*", part)
    if found is not None:
        return found[1].strip(), (found[2] or found[3] or found[4] or "").strip()
    last = part.lower().split()[1:][-1:]
    return part, "".join(
        word for word in last if len(word) > 1 and word != "in" and word in UNIT_NAMES
    )


def _is_unit(part: str) -> bool:
    word = part.strip("[]() ")
    if word.lower() in UNIT_NAMES or word in _OTHER_UNITS:
        return True
    with contextlib.suppress(InputError):
        return len(word) > 1 and unit_factor(word) > 0
    return False


#: Units as headings write them -> how this package writes them.
UNIT_NAMES = {
    "deg": "deg", "degree": "deg", "degrees": "deg", "°": "deg", "grad": "deg", "degca": "deg", "deg ca": "deg", "°ca": "deg",
    "°cam": "deg", "degcam": "deg", "deg cam": "deg", "°crank": "deg", "deg crank": "deg", "°kw": "deg", "°nw": "deg", "rad": "rad",
    "mm": "mm", "in": "inch", "inch": "inch", "inches": "inch", '"': "inch", "thou": "thou", "mil": "thou", "m": "m", "cm": "cm",
    "um": "um", "µm": "um", "μm": "um", "micron": "um", "zoll": "inch", "in.": "inch", "pouce": "inch", "pouces": "inch", "pollici": "inch",
    "pulgadas": "inch", "degre": "deg", "degré": "deg", "degrés": "deg", "grados": "deg", "gradi": "deg", "mm/deg": "mm/deg", "in/deg": "inch/deg",
    "thous": "thou"
}  # fmt: skip
#: Further units of recordings: of one letter, or unknown to the package.
_OTHER_UNITS = {
    "s", "N", "g", "V", "A", "K", "C", "F", "1", "-", "mV", "mV/V", "mA", "°C", "degC", "°F", "degF", "Nm", "N·m", "ft-lb", "ustrain",
    "Hz", "m/s2", "mm/s2", "%"
}  # fmt: skip


#: Byte marks at the beginning of a text -> its coding; the longer one first.
_MARKS_content = (
    (codecs.BOM_UTF8, "utf-8-sig"),
    (codecs.BOM_UTF16_LE, "utf-16"),
    (codecs.BOM_UTF16_BE, "utf-16"),
)


def read_content(path: Path, max_bytes: int, noun: str) -> bytes:
    """Content of a regular file of at most ``most_bytes``; ``noun`` says what was looked for.

    Raises :class:`InputError` for a missing, empty, larger or special file (a device, a pipe).
    """
    shown = path.name[:80] or str(path)[:80]
    try:
        content = bounded_bytes(path, noun, max_bytes)
    except InputError as error:
        raise InputError(f"{noun} '{shown}' {error.reason}") from None
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", "") or "the name is no file name"
        raise InputError(
            f"{noun} '{shown}' cannot be read: {reason.lower()}; check the name and the folder"
        ) from error
    if not content.strip():
        raise InputError(f"'{shown}' is empty; export the {noun} again")
    return content


def text_of(content: bytes, name: str) -> str:
    """The text in ``content``: UTF-8 or 16 by its mark, else UTF-8, else Windows' western coding.
    Raises :class:`InputError` for bytes.
    """
    marked = [coding for mark, coding in _MARKS_content if content.startswith(mark)]
    for coding in marked or ("utf-8", "cp1252") * (b"\0" not in content):
        with contextlib.suppress(UnicodeDecodeError):
            return content.decode(coding)
    raise InputError(
        f"'{name[:80]}' is no text; export the table as text (CSV) or as a workbook (XLSX)"
    )
