"""Equations as MathML, which browsers set themselves: no script, no font and no request, and they follow the colours of the page."""

from __future__ import annotations

import re
from html import escape

from docutils import nodes
from docutils.utils.math import MathError, latex2mathml
from sphinx.util import logging

LOG = logging.getLogger(__name__)


#: What the converter does not take -> what it takes: bare digits in fractions, sizes of brackets, dots, an exponent without a base.
SAME = (
    (re.compile(r"\\([td]?frac)(\d)(\d)"), r"\\\1{\2}{\3}"),
    (re.compile(r"\\[bB]igg?[lrm]?(?![A-Za-z])\s*"), ""),
    (re.compile(r"\\dots(?![a-z])"), r"\\ldots"),
    (re.compile(r"^\s*\^"), r"\\,^"),
)


def mathml(latex: str, node: nodes.Node, block: bool) -> str:
    """One equation; what the converter does not know is a warning of the build and stays readable as it was written."""
    for pattern, instead in SAME:
        latex = pattern.sub(instead, latex)
    try:
        return latex2mathml.tex2mathml(latex, as_block=block)
    except (
        MathError,
        IndexError,
        AttributeError,
        KeyError,
        TypeError,
        ValueError,
    ) as error:  # its ways to say that it cannot
        LOG.warning("equation cannot be set: %s in %s", error, latex.strip(), location=node)
        return f"<code>{escape(latex)}</code>"


def inline(self, node: nodes.math) -> None:
    """An equation within a line."""
    self.body.append(f'<span class="math notranslate">{mathml(node.astext(), node, False)}</span>')
    raise nodes.SkipNode


def block(self, node: nodes.math_block) -> None:
    """An equation of its own, with its number where it has one."""
    name = f' id="{node["ids"][0]}"' if node.get("ids") else ""
    number = f'<span class="eqno">({node["number"]})</span>' if node.get("number") else ""
    self.body.append(
        f'<div class="math notranslate"{name}>{number}{mathml(node.astext(), node, True)}</div>\n'
    )
    raise nodes.SkipNode


def setup(app):
    """Register the way of setting equations."""
    app.add_html_math_renderer(
        "mathml", inline_renderers=(inline, None), block_renderers=(block, None)
    )
    app.config.html_math_renderer = "mathml"
    return {"parallel_read_safe": True, "parallel_write_safe": True}
