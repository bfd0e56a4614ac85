"""Papers to cite with the case and the methods of its runs."""

from __future__ import annotations

from valvetrain.report.page import Block, SectionSpec, text
from valvetrain.solution.study import Study


def blocks(study: Study) -> tuple[Block, ...]:
    """Each work once, those of the case first."""
    every = (*study.record.citations, *study.provenance.citations, *(one for run in study.solutions for one in run.cite()))
    return tuple(text(reference, "reference") for reference in dict.fromkeys(every))


SPEC = SectionSpec("references", "Papers to cite", blocks)
