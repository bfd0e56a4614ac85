"""Every figure that any test makes: its panels have room, neither a slit nor a page."""

from __future__ import annotations

from functools import wraps
from typing import Any

from valvetrain.report.chart import Chart, row_weights

#: Pixels of a row of panels: least of a figure of one row (less where words stand along y), least
#: of several rows, most.
ONE_ROW, WORDS, SEVERAL, MOST = 230, 150, 205, 620
#: Pixels of a row that its axes and words take.
ROOM = 75
usual = Chart.__init__


@wraps(usual)
def watched(self: Chart, *given: Any, **more: Any) -> None:
    """``Chart(...)``, with its height looked at, a row of less weight counted as less; a figure of
    named rows needs 20 pixels for each.
    """
    usual(self, *given, **more)
    if not self.panels or self.key in ("", "a", "key"):  # figures of tests themselves
        return
    named = max(len(panel.y_tick_labels) for panel in self.panels)
    least = max(WORDS, 20 * named) if named else ONE_ROW if self.rows == 1 else SEVERAL
    most = max(MOST, 60 * named + 200)
    row = self.height / sum(row_weights(self, self.columns))
    assert least <= row <= most, f"figure '{self.key}' gives {row:.0f} pixels to a row of panels"
    for panel in self.panels:
        inside = panel.weight * (row - ROOM)
        assert inside >= 20 * len(panel.row_labels), f"rows of '{self.key}' overlap their names"


Chart.__init__ = watched  # type: ignore[method-assign]
