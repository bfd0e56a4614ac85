"""Display of results in a terminal or a notebook: units, short text, small tables, frames, quick plots; and results that
save themselves.
"""

from __future__ import annotations

import math
import os
from collections.abc import Hashable, Mapping, Sequence
from html import escape
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar, Protocol

from numpy.typing import ArrayLike

from valvetrain import registry
from valvetrain.errors import MissingExtraError
from valvetrain.registry import find

if TYPE_CHECKING:
    import pandas
    import xarray


#: SI unit -> shown unit and its factor; other units are shown as they are.
SHOWN_UNITS = {
    "m": ("mm", 1e3), "rad": ("deg", 180 / math.pi), "rad/s": ("rpm", 30 / math.pi), "N/m": ("N/mm", 1e-3), "Pa": ("MPa", 1e-6),
    "kg": ("g", 1e3), "J": ("mJ", 1e3), "N s": ("mN s", 1e3), "1": ("", 1.0),
}  # fmt: skip
MAX_ROWS = 30


class Figure(Protocol):
    """What ``.plot()`` returns: a plotly figure."""

    def show(self) -> None:
        """Open it in the browser or the notebook."""

    def write_html(self, file: str) -> None:
        """Write it as a page of its own."""

    def write_image(self, file: str, width: int) -> None:
        """Write it as SVG, PNG or PDF by the ending of ``file``, ``width`` in px."""

    def to_dict(self) -> dict[str, object]:
        """``data`` and ``layout`` as plain values."""


def value_text(value: float, unit: str, digits: int = 5) -> str:
    """An SI value in its shown unit, rounded to ``digits``; powers of ten from a million on.

    >>> value_text(0.007, "m"), value_text(1053.0, "N", 3), value_text(2.5e7, "N", 3)
    ('7 mm', '1050 N', '2.5e+07 N')
    """
    name, factor = SHOWN_UNITS.get(unit, (unit, 1.0))
    return f"{float(f'{value * factor:.{digits}g}'):g} {name}".strip()


def span(values: Sequence[float] | ArrayLike, unit: str) -> str:
    """Least and largest of SI values in their shown unit: ``"0 to 12 mm"``."""
    import numpy as np

    array = np.asarray(values, dtype=float)
    if not array.size or np.all(np.isnan(array)):
        return "none"
    name, factor = SHOWN_UNITS.get(unit, (unit, 1.0))
    low, high = np.nanmin(array) * factor + 0.0, np.nanmax(array) * factor + 0.0  # no "-0"
    return f"{low:.5g} to {high:.5g} {name}".strip()


def table(caption: str, head: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    """A small HTML table, escaped; rows beyond :data:`MAX_ROWS` are counted, not shown."""
    top = "".join(f"<th>{escape(word)}</th>" for word in head)
    body = "".join(
        "<tr>" + "".join(f"<td>{escape(cell)}</td>" for cell in row) + "</tr>"
        for row in rows[:MAX_ROWS]
    )
    more = (
        f"<tr><td colspan='{len(head)}'>and {len(rows) - MAX_ROWS} more</td></tr>"
        if len(rows) > MAX_ROWS
        else ""
    )
    title = escape(caption).replace("\n", "<br>")
    return (
        f"<div>{title}<table><thead><tr>{top}</tr></thead><tbody>{body}{more}</tbody></table></div>"
    )


def frame(
    columns: Mapping[str, ArrayLike], index: str = "", units: Mapping[str, str] | None = None
) -> pandas.DataFrame:
    """Columns as a pandas frame, ``index`` the column that numbers the rows, ``units`` in its
    ``attrs``.

    Raises :class:`MissingExtraError` where pandas is not installed.
    """
    try:
        import pandas
    except ImportError as error:
        raise MissingExtraError(
            "to_pandas() needs pandas, which is not installed; install it with 'pip install pandas'"
        ) from error
    made = pandas.DataFrame(dict(columns))
    made.attrs["units"] = dict(units or {})
    return made.set_index(index) if index else made


def frame_of(data: xarray.Dataset, dims: Sequence[Hashable] | None = None) -> pandas.DataFrame:
    """A Dataset as a frame with a row for each place along ``dims``, the units in its ``attrs``."""
    made = data.to_dataframe(dims).reset_index()
    made.attrs["units"] = {
        name: one.attrs["units"] for name, one in data.variables.items() if "units" in one.attrs
    }
    return made


class Shown:
    """A result that a notebook shows by its answer, which the registry lists by the name of its class (kind ``answers``)."""

    __slots__ = ()

    def _repr_html_(self) -> str:
        html: str = registry.find("displays", "html")(self)
        return html

    def plot(self) -> Figure:
        """The first figure of its page as a plotly figure.

        Raises :class:`InputError` where the result holds nothing to draw.
        """
        return self.figure()

    def figure(self, name: str = "") -> Figure:
        """A figure of its page by ``name``, such as ``force``, as a plotly figure; the first without one.

        Raises :class:`InputError` for a name that it has no data for, with the nearest.
        """
        made: Figure = registry.find("displays", "figure")(self, name)
        return made


def verdict_first(result: object, lines: Sequence[str]) -> str:
    """Text of a result: its verdict, then ``lines`` about it."""
    sentence: str = registry.find("displays", "verdict")(result)
    return "\n  ".join([sentence, *lines] if sentence else lines)


class Saveable(Shown):
    """A result with a table, a figure and a file of its own."""

    __slots__ = ()

    @property
    def verdict(self) -> str:
        """The result in one sentence, which opens its page and ends the answer of its command."""
        sentence: str = find("displays", "verdict")(self)
        return sentence

    def save(self, path: str | os.PathLike[str]) -> Path:
        """Write it to one NetCDF file (``.nc``), whole or not at all; :func:`valvetrain.load` reads
        an equal one. A solution may be a CSV file (``.csv``) as well.
        """
        written: Path = find("files", "result")(self, path)
        return written


class Reported(Saveable):
    """A result with a page; ``report_word``: what writes it, in the registry."""

    __slots__ = ()
    report_word: ClassVar[str] = "page"

    def report(self, folder: str | os.PathLike[str], **options: Any) -> Any:
        """Write its page and data files to ``folder``.

        Returns
        -------
        StudyFiles with the paths of page and data; raises :class:`InputError` for a folder that cannot
        be written
        """
        return find("files", self.report_word)(self, Path(folder), **options)
