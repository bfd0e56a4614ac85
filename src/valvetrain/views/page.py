"""The page of a result: one HTML file, the verdict first, everything else folded; plotly.js and data are packed."""

from __future__ import annotations

import base64
import gzip
import json
import re
from dataclasses import dataclass
from functools import cache
from importlib import resources
from typing import Any

import jinja2
import plotly.graph_objects as go

from valvetrain.errors import InputError
from valvetrain.report.motion.project import motion_data
from valvetrain.report.page import motion_script
from valvetrain.solution.partial_failures import PartialFailures
from valvetrain.views.shown import Shown
from valvetrain.views.style import in_reader_units
from valvetrain.views.terminal import SIGN

#: Left margin (px) of a figure on a narrow page, at most: of numbers, and of names.
NARROW_NUMBERS, NARROW_NAMES = 48, 150
#: How the packed data of a page begin, by which a page of this kind is known.
_PACKED = re.compile(r'<script type="application/gzip" id="data">([^<]*)</script>')
HINT = (
    "Drag the picture or use the arrow keys to turn it. Space plays, arrow keys step by one cam degree, page keys go "
    "from mark to mark. The picture records itself to a film."
)


@dataclass(frozen=True)
class Drawn:
    """A figure of a page: its title, a hint on what it shows, and its content as plain values."""

    title: str
    hint: str
    content: dict[str, Any]


def page_of(answer: Shown, gaps: PartialFailures | None = None) -> str:
    """The whole answer in one HTML file that needs no network.

    Parameters
    ----------
    answer : on any result, in the units of the reader
    gaps : takes a sentence for each figure or picture that cannot be drawn

    Returns
    -------
    The text of the page
    """
    missing = PartialFailures() if gaps is None else gaps
    figures = {
        name: Drawn(spec.title, spec.hint, figure_content(fig))
        for name, spec in answer.figures().items()
        if (fig := missing.part(f"figure '{spec.title}'", None, spec.make, answer.facts))
        is not None
    }
    moving = missing.part("moving picture", None, answer.moving)
    data: dict[str, Any] = {f"data-{name}": one.content for name, one in figures.items()}
    if moving is not None:
        data["motion-in-motion"] = motion_data(moving)
    names = list(figures)
    aside = bool(answer.bullets or answer.paper or answer.rests_on or missing.sentences)
    return _template().render(
        answer=answer, fact=answer.headline[0], several=len(answer.headings) > 1, aside=aside, sign=SIGN, figures=figures,
        first=names[:1], others=names[1:], moving=moving, hint=HINT, gaps=missing.sentences,
        tables={key: one for key, one in answer.tables().items() if one.rows}, picture=missing.part("picture", "", answer.picture),
        style=static("page.css") + static("parts.css"), script=static("page.js"), plotly=packed_plotly(),
        mover=motion_script() if moving is not None else "", data=packed(json.dumps(data, separators=(",", ":")).encode()),
    )  # fmt: skip


def figure_content(fig: go.Figure) -> dict[str, Any]:
    """A figure in the units of the reader as plain values, with its layout on a narrow page."""
    content: dict[str, Any] = json.loads(in_reader_units(fig).to_json())
    margin = content["layout"]["margin"]
    left = NARROW_NAMES if margin["l"] > 2 * NARROW_NUMBERS else NARROW_NUMBERS
    narrow = {"margin": margin | {"l": min(left, margin["l"])}, "dragmode": False}
    content["narrow"] = content["layout"] | narrow
    return content


@cache
def _template() -> jinja2.Template:
    environment = jinja2.Environment(
        loader=jinja2.FunctionLoader(static), autoescape=True, trim_blocks=True, lstrip_blocks=True,
        undefined=jinja2.StrictUndefined,
    )  # fmt: skip
    return environment.get_template("page.html.j2")


def static(name: str) -> str:
    """A style, script or template of the page."""
    folder = resources.files("valvetrain.views").joinpath("static")
    return folder.joinpath(name).read_text(encoding="utf-8")


def packed(content: bytes) -> str:
    """Bytes as text that a browser unpacks by itself (``DecompressionStream``)."""
    return base64.b64encode(gzip.compress(content, 9, mtime=0)).decode()


@cache
def packed_plotly() -> str:
    """plotly.js as its Python package brings it, packed: 2 MB in place of 4.8."""
    return packed(resources.files("plotly").joinpath("package_data", "plotly.min.js").read_bytes())


def data_of(page: str) -> dict[str, Any] | None:
    """The packed data of a page: name -> figure or motion; None for a page of another kind.

    Raises :class:`InputError` for data that are damaged.
    """
    found = _PACKED.search(page)
    if found is None:
        return None
    try:
        content: dict[str, Any] = json.loads(gzip.decompress(base64.b64decode(found[1])))
    except (OSError, ValueError, EOFError) as error:
        raise InputError("the data of this page are damaged; run it again", "page") from error
    return content
