"""The page of a study: one HTML file, the verdict first, everything else folded; plotly.js and data are packed."""

from __future__ import annotations

import base64
import gzip
import json
import re
from collections.abc import Mapping
from functools import cache
from importlib import resources
from typing import Any

import jinja2
import plotly.graph_objects as go

from valvetrain.errors import InputError
from valvetrain.report.motion.parts import Moving
from valvetrain.report.motion.project import motion_data
from valvetrain.report.motion.scene import moving_picture
from valvetrain.report.page import motion_script
from valvetrain.solution.partial_failures import PartialFailures
from valvetrain.views.answer import Answer, Shown
from valvetrain.views.figures import figure_specs, worst_run
from valvetrain.views.style import in_reader_units
from valvetrain.views.table import TextTable
from valvetrain.views.tables import how_computed, tables_of
from valvetrain.views.terminal import SIGN

#: Left margin (px) of a figure on a narrow page, at most: of numbers, and of names.
NARROW_NUMBERS, NARROW_NAMES = 48, 150
#: How the packed data of a page begin, by which a page of this kind is known.
_PACKED = re.compile(r'<script type="application/gzip" id="data">([^<]*)</script>')
HINT = (
    "Drag the picture or use the arrow keys to turn it. Space plays, arrow keys step by one cam degree, page keys go "
    "from mark to mark. The picture records itself to a film."
)


def page_of(answer: Answer, gaps: PartialFailures | None = None) -> str:
    """The whole answer in one HTML file that needs no network.

    Parameters
    ----------
    answer : on a study, in the units of the reader
    gaps : takes a sentence for each figure or picture that cannot be drawn

    Returns
    -------
    The text of the page
    """
    missing = PartialFailures() if gaps is None else gaps
    drawn = {
        name: (spec.title, spec.hint, figure_content(fig))
        for name, spec in figure_specs().items()
        if (fig := missing.part(f"figure '{spec.title}'", None, spec.make, answer.facts))
        is not None
    }
    moving = missing.part("moving picture", None, _moving, answer)
    computed = list(how_computed(answer)), answer.study.record.text
    return rendered(answer, drawn, tables_of(answer), computed, missing, moving=moving)


#: Title, hint and content of a figure.
Drawn = tuple[str, str, dict[str, Any]]


def rendered(
    answer: Shown, drawn: Mapping[str, Drawn], tables: Mapping[str, TextTable], computed: tuple[list[str], str],
    gaps: PartialFailures, moving: Moving | None = None, picture: str = "",
) -> str:  # fmt: skip
    """The page of anything that is shown: figures by name, tables, how it was computed with the case as text, parts
    that are missing, and a moving picture or a still one as SVG.
    """
    data: dict[str, Any] = {f"data-{name}": one for name, (_, _, one) in drawn.items()}
    if moving is not None:
        data["motion-in-motion"] = motion_data(moving)
    names = list(drawn)
    several = len(answer.headings) > 1
    aside = bool(answer.bullets or answer.paper or answer.rests_on or gaps.sentences)
    return _template().render(
        answer=answer, fact=answer.headline[0], several=several, aside=aside, sign=SIGN, figures=drawn, first=names[:1], others=names[1:],
        moving=moving, hint=HINT, tables=tables, computed=computed[0], gaps=gaps.sentences, picture=picture,
        style=static("page.css") + static("parts.css"), script=static("page.js"), plotly=packed_plotly(),
        mover=motion_script() if moving is not None else "", data=packed(json.dumps(data, separators=(",", ":")).encode()),
        text=computed[1],
    )  # fmt: skip


def figure_content(fig: go.Figure) -> dict[str, Any]:
    """A figure in the units of the reader as plain values, with its layout on a narrow page."""
    content: dict[str, Any] = json.loads(in_reader_units(fig).to_json())
    margin = content["layout"]["margin"]
    left = NARROW_NAMES if margin["l"] > 2 * NARROW_NUMBERS else NARROW_NUMBERS
    narrow = {"margin": margin | {"l": min(left, margin["l"])}, "dragmode": False}
    content["narrow"] = content["layout"] | narrow
    return content


def _moving(answer: Answer) -> Moving | None:
    """The moving picture, the run that decides first; None where no run moves."""
    worst = worst_run(answer.facts)
    moving = moving_picture(answer.study, worst=worst)
    if moving is None or worst is None:
        return moving

    def order(place: int) -> tuple[bool, int, bool]:
        one = moving.variants[place]
        here = one.engine_speed == worst.engine_speed
        colours = sum(len(spring.colourings) for spring in one.springs)
        return not here, -colours, one.label != worst.label

    places = sorted(range(len(moving.variants)), key=order)
    return Moving(moving.title, tuple(moving.variants[k] for k in places), moving.notes)


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
