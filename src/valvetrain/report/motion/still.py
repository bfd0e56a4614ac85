"""One moment as an SVG picture: what a page shows before its script runs, or where it cannot."""

from __future__ import annotations

import numpy as np

from valvetrain.report.motion.marks import still_frame
from valvetrain.report.motion.parts import Variant
from valvetrain.report.motion.project import flat_shapes

#: Height (px) of the picture, and room (m) around it.
HEIGHT, MARGIN = 420, 1e-3


def still_svg(variant: Variant, frame: int | None = None, key: str = "") -> str:
    """An SVG element of one frame (that of the largest force by default), in mm, coloured by ``key`` (the first colouring by default)."""
    place = still_frame(variant) if frame is None else frame
    shapes = flat_shapes(variant, place, key, 3)
    every = np.concatenate([one.points for one in shapes])
    (left, low), (right, high) = every.min(axis=0) - MARGIN, every.max(axis=0) + MARGIN
    lines = []
    for one in shapes:
        x, y = 1e3 * (one.points[:, 0] - left), 1e3 * (high - one.points[:, 1])
        path = "M" + "L".join(f"{a:.2f} {b:.2f}" for a, b in zip(x, y, strict=True))
        colour = "#" + "".join(f"{part:02x}" for part in one.colour)
        lines.append(f'<path d="{path}Z" fill="{colour}" stroke="{colour}"/>')
    words = f"{variant.words} at cam angle {np.degrees(variant.cam_angle[place]):.1f} degrees"
    size = f"0 0 {1e3 * (right - left):.2f} {1e3 * (high - low):.2f}"
    return f'<svg viewBox="{size}" height="{HEIGHT}" role="img" aria-label="{_escaped(words)}" stroke-width=".15">{"".join(lines)}</svg>'


def _escaped(words: str) -> str:
    from html import escape

    return escape(words, quote=True)
