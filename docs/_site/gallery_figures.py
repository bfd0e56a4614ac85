"""Figures of the gallery: each example ends in a plotly figure named ``figure``.

It stands on the page as an SVG picture, which needs no script, and turns into the interactive one where scripts run: from one copy of
plotly.js that all pages share.
"""

from __future__ import annotations

import json
import re
import shutil
from pathlib import Path

from figure_svg import svg_of

from valvetrain.report.notebook import picture_of
from valvetrain.report.page import plotly_script


def scrape(block, block_vars, gallery_conf) -> str:
    """What a block leaves on the page: nothing, or its figure once, when it has its title (a figure drawn in
    one block and labelled in a later one stood without labels).
    """
    scope = block_vars["example_globals"]
    figure = scope.get("figure")
    if figure is None:
        keep_picture(scope.get("___"), block_vars)
        return ""
    if scope.get("_shown") is figure or not figure.layout.title.text:
        return ""
    scope["_shown"] = figure
    path = Path(next(block_vars["image_path_iterator"])).with_suffix(".svg")
    path.write_text(svg_of(figure), encoding="utf-8")
    name = path.name
    data = json.dumps(json.loads(figure.to_json()), separators=(",", ":")).replace("<", "\\u003c")
    words = figure.layout.title.text or "figure"
    lines = [
        f'<figure class="gallery-figure"><img src="../_images/{name}" alt="{words}">',
        f'<script type="application/json" class="figure-data">{data}</script></figure>',
    ]
    indented = "\n".join(f"    {line}" for line in lines)
    return f".. raw:: html\n\n{indented}\n\n"


def keep_picture(result, block_vars) -> None:
    """The picture of what the last line of a notebook's cell shows, for the gallery; the page has it in the result's own table."""
    found = re.search(r"<svg.*</svg>", picture_of(result), re.DOTALL)
    if found:
        path = Path(next(block_vars["image_path_iterator"])).with_suffix(".svg")
        path.write_text(found[0], encoding="utf-8")


def copy_script(app, error) -> None:
    """One plotly.js beside the other scripts of the site, and the pictures of the examples."""
    if error is None and app.builder.format == "html":
        static, images = Path(app.outdir) / "_static", Path(app.outdir) / "_images"
        target = static / "plotly.min.js"
        if not target.exists():
            target.write_text(plotly_script(), encoding="utf-8")
        images.mkdir(exist_ok=True)
        for picture in (Path(app.srcdir) / "gallery" / "images").glob("*.svg"):
            shutil.copyfile(picture, images / picture.name)


def setup(app):
    """Copy what the figures need when the build is done."""
    app.connect("build-finished", copy_script)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
