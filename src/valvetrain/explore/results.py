"""What studies, searches and identifications write: the JSON answer, tables and other files that each declares, and the page."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, fields, is_dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from valvetrain.explore.distributions import Values
from valvetrain.explore.space import Space, Varied
from valvetrain.findings.words import Words, digits_text
from valvetrain.parameters.summary import unit_text
from valvetrain.solution.atomic import write_text
from valvetrain.units import unit_factor
from valvetrain.units.reader import reader_factor, reader_unit
from valvetrain.views.shown import ShownByRules

if TYPE_CHECKING:
    import pandas


#: Rows that a JSON answer holds; a larger table is in its CSV file alone.
MAX_ROWS = 2000
#: Writes one file.
Write = Callable[[Path], Path]


@dataclass(frozen=True)
class ExploreAnswer(ShownByRules):
    """What is shown of a study, a search or an identification; ``folder``: where its files are, None before they are written."""

    result: Any
    folder: Path | None = None

    @property
    def stopped(self) -> bool:
        """Whether it was stopped before its end."""
        return False

    @property
    def text(self) -> str:
        """The case file."""
        case = self.result.plan.case
        return "" if case is None else case.text

    @property
    def failures(self) -> tuple[str, ...]:
        """What makes its command fail."""
        return ()

    def data(self) -> dict[str, Any]:
        """What the JSON answer holds besides the findings, SI."""
        return {}

    def files(self) -> Mapping[str, Write]:
        """The files besides the page by name."""
        return {}

    def write(self, folder: Path) -> list[Path]:
        """Write the files besides the page."""
        return [write(folder / name) for name, write in self.files().items()]


def fields_of(item: Any) -> Any:
    """A result as mappings and lists for JSON: a dataclass by its fields but those left out of its ``repr``, what has a
    ``to_dict`` by that.

    >>> fields_of(Path("a")), fields_of((1, {"b": None}))
    (PosixPath('a'), [1, {'b': None}])
    """
    if hasattr(item, "to_dict"):
        return fields_of(item.to_dict())
    if is_dataclass(item) and not isinstance(item, type):
        return {one.name: fields_of(getattr(item, one.name)) for one in fields(item) if one.repr}
    if isinstance(item, Mapping):
        return {key: fields_of(value) for key, value in item.items()}
    return [fields_of(one) for one in item] if isinstance(item, (tuple, list)) else item


def rows_of(frame: pandas.DataFrame) -> dict[str, Any]:
    """The rows of a frame, SI, and the units of its columns; a large table without its rows."""
    rows = frame.to_dict("records") if len(frame) <= MAX_ROWS else []
    return {"units": frame.attrs["units"], "rows": rows}


def varied_of(space: Space) -> list[dict[str, str]]:
    """What was varied, for JSON."""
    return [
        {
            "name": one.name,
            "key": ", ".join((one.key, *one.also)),
            "as": one.operation,
            "label": one.shown_name,
        }
        for one in space
    ]


def value_text(unit: str, *values: float, bar: float = 0.0, digits: int = 4) -> str:
    """A value or a range (SI) in ``unit``, or the reader's in its place, no finer than ``bar`` (SI).

    >>> value_text("mm", 4.1404e-3, 4.2612e-3, bar=3e-5)
    '4.14 to 4.26 mm'
    """
    factor = reader_factor(unit) / unit_factor(unit)
    texts = (digits_text(one * factor, bar * factor, digits) for one in values)
    return f"{' to '.join(texts)} {unit_text(reader_unit(unit))}".strip()


def range_text(one: Varied) -> str:
    """Over what a quantity is varied, in its unit; of a normal one what holds 95 % of it.

    >>> range_text(Varied("spring.wire_diameter", "mm", distribution=Values((3e-3, 4e-3))))
    '2 values, 3 to 4 mm'
    """
    kind = one.distribution
    if isinstance(kind, Values):
        return (
            f"{len(kind.values)} values, {value_text(one.unit, min(kind.values), max(kind.values))}"
        )
    low, high = kind.at([0, 1] if kind.flat else [0.025, 0.975]).tolist()
    return value_text(one.unit, low, high) + ("" if kind.flat else f", {kind.kind}")


def csv_writer(frame: pandas.DataFrame) -> Write:
    """Writes a frame with all digits, SI, the units in its head."""
    units = frame.attrs["units"]
    heads = {name: f"{name} [{unit or '1'}]" for name, unit in units.items()}
    text = frame.rename(columns=heads).to_csv(index=False, lineterminator="\n")
    return lambda path: write_text(path, text)


def answer_json(answer: ExploreAnswer) -> dict[str, Any]:
    """The JSON answer: what the result declares, and its findings in SI."""
    data = answer.data()  # first, for error bars decide some findings
    shown = replace(answer, words=Words(case=answer.words.case))
    return data | {"findings": [one.to_dict() for one in shown.findings]}
