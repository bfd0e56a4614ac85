"""The one page of every study: sections that ask what its solutions have."""

from __future__ import annotations

from dataclasses import replace

from valvetrain.registry import find, words
from valvetrain.report.figures.common import looks, told_by_source
from valvetrain.report.page import Block, Details, Figure, Page, Section, SectionSpec, Tabs, gap, prose, sentences
from valvetrain.report.words import rpm
from valvetrain.solution.gaps import Gaps, reason
from valvetrain.solution.study import Study

#: Command -> word above the title.
_KICKERS = {"run": "Run", "compare": "Comparison of models", "sweep": "Sweep over engine speed", "run-up": "Run-up"}
#: Sentences of a case's description that stand on top of its page.
_LEAD_SENTENCES = 2
_MOST_SPEEDS = 6


def study_page(study: Study) -> Page:
    """The whole page of a study, whatever was studied; a section without blocks is left out, one that fails is named in its place.

    Parameters
    ----------
    study : what ``simulate``, ``compare`` or ``sweep`` gave

    Returns
    -------
    Page with title, facts and sections, which :func:`write_study` writes as HTML

    Raises
    ------
    InputError : a section added by another package that cannot be loaded

    Examples
    --------
    >>> import valvetrain as vt
    >>> page = vt.study_page(vt.simulate("job-t", "2000 rpm", spring_models=["massless"]))
    >>> len(page.sections) > 3
    True
    """
    sections = tuple(section for word in words("sections") if (section := _section(find("sections", word), study)) is not None)
    record, gaps = study.record, Gaps()
    by_source = gaps.part("what the source tells of the case", False, told_by_source, study)
    told = sentences(record.description) if by_source else []
    facts = gaps.part("facts below the title", (), _facts, study)
    lead, more = " ".join(told[:_LEAD_SENTENCES]), tuple(told[_LEAD_SENTENCES:])
    if more and sections:
        about = Section("about", "About the case", prose((" ".join(told),), "The whole description"))
        sections = (*sections[:-1], about, sections[-1])
    zero = f" Zero of the cam angle: {record.zero_of_angle}." if record.zero_of_angle else ""
    footer = "Cam angles are cam degrees, engine speed is that of the crank." + zero + " Compressive forces and opening lift are positive."
    if gaps.sentences:
        sections = (Section("missing", "What is missing", tuple(gap(words) for words in gaps.sentences)), *sections)
    return _unique_keys(Page(record.title or record.name, _KICKERS.get(study.command, study.command), lead, facts, sections, footer))


def _section(spec: SectionSpec, study: Study) -> Section | None:
    try:
        blocks = spec.blocks(study)
    except Exception as error:  # one section must not cost the page
        blocks = (gap(f"The section '{spec.title}' could not be drawn: {reason(error)}"),)
    return Section(spec.key, spec.title, blocks) if blocks else None


def _facts(study: Study) -> tuple[tuple[str, str], ...]:
    speeds, known = study.engine_speeds, looks(study)
    names = [look.words for look in known.values()]
    mark = "; " if any("," in name for name in names) else ", "
    listed = ", ".join(f"{rpm(speed):.10g}" for speed in speeds)
    if len(speeds) > _MOST_SPEEDS:
        listed = f"{len(speeds)} from {rpm(speeds[0]):.10g} to {rpm(speeds[-1]):.10g}"
    ended = sum(run.status.completed for run in study.solutions)
    word = "turns of a run-up" if study.command == "run-up" else "settled" if study.command == "sweep" else "completed"
    facts = {
        "case": study.record.name, "engine speed": f"{listed} rpm" if speeds else "",
        "springs by": mark.join(names), "changed": ", ".join(study.record.changed),
        "runs": f"{ended} of {len(study.solutions)} {word}" if study.solutions else "none run",
    }  # fmt: skip
    return tuple((name, value) for name, value in facts.items() if value)


def _unique_keys(page: Page) -> Page:
    """Keys of charts and sections name elements and files, so each stands once."""
    seen: set[str] = set()

    def unique(key: str) -> str:
        free = next(name for n in range(1, len(seen) + 2) if (name := key if n == 1 else f"{key}-{n}") not in seen)
        seen.add(free)
        return free

    def renamed(blocks: tuple[Block, ...]) -> tuple[Block, ...]:
        found: list[Block] = []
        for block in blocks:
            if isinstance(block, Figure):
                block = Figure(replace(block.chart, key=unique(block.chart.key)))
            elif isinstance(block, Tabs):
                block = Tabs(tuple((label, renamed(inner)) for label, inner in block.items), block.key)
            elif isinstance(block, Details):
                block = Details(block.summary, renamed(block.blocks))
            found.append(block)
        return tuple(found)

    taken: set[str] = set()
    sections = []
    for section in page.sections:
        key = next(name for n in range(1, len(taken) + 2) if (name := section.key if n == 1 else f"{section.key}-{n}") not in taken)
        taken.add(key)
        sections.append(Section(key, section.title, renamed(section.blocks)))
    return replace(page, sections=tuple(sections))
