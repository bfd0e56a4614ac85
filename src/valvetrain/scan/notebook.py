"""What a notebook shows first of a design compared with a scan."""

from __future__ import annotations

from valvetrain.report.page import Block, Cell, Grid, figure_or_gap
from valvetrain.scan.compare import ScanComparison
from valvetrain.scan.page import compared_rows, force_chart


def scan_comparison_blocks(found: ScanComparison) -> tuple[Block, ...]:
    """Numbers of both, and their force over height."""
    heads = ("quantity", "run", "design", "scan", "", "scan/design")
    rows = tuple((tuple(map(Cell, row)), ()) for row in compared_rows(found))
    return Grid(heads, rows), *figure_or_gap("force", force_chart, found)
