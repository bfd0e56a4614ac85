"""What every page has: head, skip link, navigation, light and dark."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

from nicegui import ui
from nicegui.context import context

from valvetrain.workbench.pages.assets import address
from valvetrain.workbench.pages.elements import Theme, link, tag

#: Places of the navigation: words and address.
PLACES = (("Start", "/"), ("Runs", "/runs"), ("Compare", "/compare"))
# Light or dark is known before anything is drawn.
_HEAD = """
<meta name="description" content="Valve springs and valvetrains: cases, runs and results on this machine">
<script>
document.documentElement.lang = "en";
document.documentElement.dataset.workbench = "";
(function () {
  let kept = null;
  try { kept = localStorage.getItem("valvetrain-theme"); } catch (error) { kept = null; }
  const dark = kept ? kept === "dark" : window.matchMedia("(prefers-color-scheme: dark)").matches;
  document.documentElement.dataset.theme = dark ? "dark" : "light";
})();
</script>
"""
# What draws figures is large: it is asked for once the page stands.
_LATER = """<script>
window.valvetrainDrawing = new Promise(function (done) {
  window.addEventListener("load", function () {
    let left = 2;
    [%s].forEach(function (address) {
      const script = document.createElement("script");
      script.src = address;
      script.onload = function () { left -= 1; if (left === 0) { done(); } };
      document.head.append(script);
    });
  });
});
</script>"""


@contextmanager
def frame(title: str, here: str = "", figures: bool = True) -> Iterator[None]:
    """A page with ``title``; what is made inside stands in its main part. ``figures``: it draws some."""
    ui.page_title(f"{title} - valvetrain")
    drawing = _LATER % ", ".join(f'"{address(name)}"' for name in ("plotly.js", "motion.js"))
    scripts = f'<script defer src="{address("page.js")}"></script>{drawing}' if figures else ""
    styles = "".join(f'<link rel="stylesheet" href="{address(name)}">' for name in ("page.css", "workbench.css"))
    ui.add_head_html(_HEAD + styles + scripts)
    with context.client.layout:
        top = tag("header", classes="top")
    top.move(target_index=0)
    with top:
        link("valvetrain", "/", "brand")
        with tag("nav", aria_label="places"):
            for words, href in PLACES:
                link(words, href, aria_current="page" if href == here else None)
        Theme()
    with tag("div", classes="sheet") as sheet:
        yield
    ui.skip_link("Skip to the content", target=sheet)
