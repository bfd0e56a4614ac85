"""Figures of the gallery: each example ends in a plotly figure named ``figure``.

It stands on the page as an SVG picture, which needs no script, and turns into the interactive one where scripts run: from one copy of
plotly.js that all pages share.
"""

from __future__ import annotations

import json
import shutil
from contextlib import suppress
from importlib import resources
from pathlib import Path

from valvetrain.errors import InputError
from valvetrain.solution.display import Shown

#: Width of a picture (px).
WIDTH = 900


def scrape(block, block_vars, gallery_conf) -> str:
    """What a block leaves on the page: nothing, or its figure once, when its axes have titles (a figure drawn in
    one block and labelled in a later one stood without labels).
    """
    scope = block_vars["example_globals"]
    figure = scope.get("figure")
    if figure is None:
        keep_picture(scope.get("___"), block_vars)
        return ""
    titled = any(axis.title.text for axis in figure.select_xaxes())
    if scope.get("_shown") is figure or not titled:
        return ""
    scope["_shown"] = figure
    path = Path(next(block_vars["image_path_iterator"])).with_suffix(".svg")
    figure.write_image(path, width=WIDTH)
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
    """The first figure of the result that the last line of a notebook's cell shows, for the gallery."""
    if not isinstance(result, Shown):
        return
    with suppress(InputError):  # of a result that holds nothing to draw
        figure = result.plot()
        path = Path(next(block_vars["image_path_iterator"])).with_suffix(".svg")
        figure.write_image(path, width=WIDTH)


def copy_script(app, error) -> None:
    """One plotly.js beside the other scripts of the site, and the pictures of the examples."""
    if error is None and app.builder.format == "html":
        static, images = Path(app.outdir) / "_static", Path(app.outdir) / "_images"
        target = static / "plotly.min.js"
        if not target.exists():
            shutil.copyfile(resources.files("plotly") / "package_data" / "plotly.min.js", target)
        images.mkdir(exist_ok=True)
        for picture in (Path(app.srcdir) / "gallery" / "images").glob("*.svg"):
            shutil.copyfile(picture, images / picture.name)


def setup(app):
    """Copy what the figures need when the build is done."""
    app.connect("build-finished", copy_script)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
