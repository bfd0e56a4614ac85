"""The page of a result: one HTML file, the verdict first, everything else folded; plotly.js and data are packed."""

from __future__ import annotations

import base64
import gzip
import io
import json
import re
import zlib
from collections.abc import Mapping
from dataclasses import asdict, dataclass
from functools import cache
from importlib import resources
from typing import TYPE_CHECKING, Any

import plotly.graph_objects as go

from valvetrain.errors import InputError
from valvetrain.solution.status import PartialFailures
from valvetrain.views.motion.project import motion_data
from valvetrain.views.shown import Shown
from valvetrain.views.style import in_reader_units
from valvetrain.views.terminal import SIGN

if TYPE_CHECKING:
    import jinja2

#: Left margin (px) of a figure on a narrow page, at most: of numbers, and of names.
NARROW_NUMBERS, NARROW_NAMES = 48, 150
#: Texts and data of a page as it packs them, by which a page of this kind is known.
_PACKED = re.compile(r'<script type="application/gzip" id="(answer|data)">([^<]*)</script>')
#: Bytes to which the texts, or the data, of a page are unpacked at most.
MOST = 50_000_000
HINT = (
    "Drag the picture or use the arrow keys to turn it. Space plays, arrow keys step by one cam degree, page keys go "
    "from mark to mark. The picture records itself to a film."
)


@dataclass(frozen=True)
class Content:
    """An answer as plain values: its ``texts`` by the names of :class:`Shown`, and the ``data`` of its figures and of its
    moving picture, which a browser draws.
    """

    texts: dict[str, Any]
    data: dict[str, Any]


def content_of(answer: Shown, missing: PartialFailures) -> Content:
    """The whole answer as plain values; ``missing`` takes a sentence for each figure or picture that cannot be drawn."""
    data: dict[str, Any] = {}
    figures: dict[str, Any] = {}
    for name, spec in answer.figures().items():
        fig = missing.part(f"figure '{spec.title}'", None, spec.make, answer.facts)
        if fig is not None:
            data[f"data-{name}"] = drawn = figure_content(fig)
            height = drawn["layout"]["height"]
            figures[name] = {"title": spec.title, "hint": spec.hint, "height": height}
    moving = missing.part("moving picture", None, answer.moving)
    if moving is not None:
        data["motion-in-motion"] = motion_data(moving)
    verdict = answer.verdict
    texts = {
        "title": answer.title, "fact": answer.headline[0], "next_step": answer.next_step, "headings": answer.headings,
        "verdict": verdict and {name: getattr(verdict, name) for name in ("code", "mark", "text", "reason")},
        "lines": [asdict(one) for one in answer.lines],
        "bullets": [{"mark": one.mark, "text": str(one)} for one in answer.bullets],
        "models": answer.models and asdict(answer.models), "paper": answer.paper and asdict(answer.paper),
        "rests_on": answer.rests_on, "figures": figures, "moving": "" if moving is None else moving.title,
        "tables": {key: asdict(one) for key, one in answer.tables().items() if one.rows},
        "computed": list(answer.computed()), "text": answer.text, "gaps": list(missing.sentences),
    }  # fmt: skip
    return Content(texts, data)


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
    picture = missing.part("picture", "", answer.picture)
    content = content_of(answer, missing)
    # plotly.js as its Python package brings it: 2 MB packed in place of 4.8
    plotly = resources.files("plotly").joinpath("package_data", "plotly.min.js").read_bytes()
    return _template("page.html.j2").render(
        answer=content.texts, whole=True, prefix="", picture=picture, sign=SIGN, hint=HINT,
        style=static("page.css") + static("parts.css"), script=static("page.js"), plotly=packed(plotly),
        mover=motion_script() if content.texts["moving"] else "", texts=packed(content.texts), data=packed(content.data),
    )  # fmt: skip


def part_of(texts: Mapping[str, Any], prefix: str = "") -> str:
    """The texts of an answer as HTML for another page, which draws its data by ``valvetrainFigures`` of page.js.

    ``prefix``: begins each id, where the page shows several answers.
    """
    return _template("answer.html.j2").render(
        answer=texts, whole=False, prefix=prefix, picture="", sign=SIGN, hint=HINT
    )


def figure_content(fig: go.Figure) -> dict[str, Any]:
    """A figure in the units of the reader as plain values, with its layout on a narrow page."""
    content: dict[str, Any] = json.loads(in_reader_units(fig).to_json())
    margin = content["layout"]["margin"]
    left = NARROW_NAMES if margin["l"] > 2 * NARROW_NUMBERS else NARROW_NUMBERS
    narrow = {"margin": margin | {"l": min(left, margin["l"])}, "dragmode": False}
    content["narrow"] = content["layout"] | narrow
    return content


@cache
def _template(name: str) -> jinja2.Template:
    import jinja2

    environment = jinja2.Environment(
        loader=jinja2.FunctionLoader(static), autoescape=True, trim_blocks=True, lstrip_blocks=True,
        undefined=jinja2.StrictUndefined,
    )  # fmt: skip
    return environment.get_template(name)


def static(name: str) -> str:
    """A style, script or template of the page."""
    folder = resources.files("valvetrain.views").joinpath("static")
    return folder.joinpath(name).read_text(encoding="utf-8")


@cache
def motion_script() -> str:
    """Classic script of scene.js, film.js and motion.js that sets ``valvetrainMotion.mount(element, data)``; safe inside
    a script element.
    """
    parts = "\n".join(static(name) for name in ("scene.js", "film.js", "motion.js"))
    return f'(function(){{"use strict";\n{parts}\n}})();'.replace("</script", "<\\/script")


def packed(content: Any) -> str:
    """Plain values, or bytes, as text that a browser unpacks by itself (``DecompressionStream``)."""
    if not isinstance(content, bytes):
        content = json.dumps(content, separators=(",", ":")).encode()
    return base64.b64encode(gzip.compress(content, 9, mtime=0)).decode()


@cache
def packed_parts(page: str) -> dict[str, str]:
    """``answer`` and ``data`` of a page as it packs them; nothing of a page of another kind."""
    return dict(_PACKED.findall(page))


def unpacked(text: str) -> Any:
    """What :func:`packed` packed. Raises :class:`InputError` for text that is damaged or too large."""
    try:
        with gzip.GzipFile(fileobj=io.BytesIO(base64.b64decode(text))) as file:
            content = file.read(MOST)
        return json.loads(content)
    except (OSError, ValueError, EOFError, RecursionError, zlib.error) as error:
        raise InputError("the data of this page are damaged; run it again", "page") from error


def data_of(page: str) -> dict[str, Any] | None:
    """The data of a page: name -> figure or motion; None for a page of another kind.

    Raises :class:`InputError` for data that are damaged.
    """
    found = packed_parts(page).get("data")
    content: dict[str, Any] | None = None if found is None else unpacked(found)
    return content
