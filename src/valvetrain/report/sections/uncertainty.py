"""Numerical uncertainty of the headline numbers, where it ships with the case and these are the numbers it was found for."""

from __future__ import annotations

from valvetrain.report.page import Block, Details, SectionSpec, text
from valvetrain.report.uncertainty_section import firmness, lead, uncertainty_grid
from valvetrain.solution.study import Study
from valvetrain.studies.uncertainty_file import fresh_uncertainty, load_uncertainty, meshes_of

#: Rows of a table beyond which it is folded, so that the figures below stay near.
ONE_SCREEN = 30


def blocks(study: Study) -> tuple[Block, ...]:
    """Nothing for a case that was changed, one of one's own, or numbers that another version or other engine speeds gave."""
    rows, fresh = load_uncertainty(study.record), fresh_uncertainty(study)
    if not fresh:
        return ()
    left = f"{len(rows) - len(fresh)} stored rows are left out: this run computes other values or other speeds."
    notes = (text(left, "note"),) if len(fresh) < len(rows) else ()
    grid: Block = uncertainty_grid(fresh)
    if len(fresh) > ONE_SCREEN:
        grid = Details(f"All {len(fresh)} numbers with their error bars", (grid,))
    return (text(firmness(fresh)), grid, text(lead(meshes_of(study.record)), "quiet"), *notes)


SPEC = SectionSpec("uncertainty", "Numbers with error bars", blocks)
