"""Springs at rest kept as a run is: its folder with data files, page and inputs."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from datetime import UTC, datetime
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from valvetrain.cli.study_command import Kept, keep_run

if TYPE_CHECKING:
    from valvetrain.cli.outcome import Outcome
    from valvetrain.parameters.case import Case
    from valvetrain.solution.study import Study

KeepOption = Annotated[
    bool,
    typer.Option(
        "--keep", help="Keep the answer as runs are kept: data files, report page and inputs."
    ),
]


def kept(
    outcome: Outcome, study: Study, case: Case, folder: Path, choices: Mapping[str, Any]
) -> Outcome:
    """The outcome with its ``study`` written to a new folder of kept runs; ``folder``: where the
    case's file lies, ``choices``: what was
    asked besides."""
    from valvetrain.cli.progress import busy
    from valvetrain.report.study import write_parts
    from valvetrain.solution.gaps import Gaps

    gaps, data = Gaps(), dict(outcome.data)
    pages: list[Path] = []

    def write(target: Path) -> list[Path]:
        files = write_parts(study, target)
        pages.extend([files.page] if files.page else [])
        for sentence in files.gaps:
            gaps.add(sentence)
        told = tuple(dict.fromkeys((*outcome.failures, *gaps.sentences)))
        data.update(completed=not told, failures=list(told))
        return [*files.data, *pages]

    asked = {**choices, "spring_models": list(dict.fromkeys(one.model for one in study.rest))}
    request = Kept(study.command, case, None, datetime.now(UTC).replace(microsecond=0), folder)
    with busy("writing files"):
        home, files = keep_run(
            request, study.record.text, asked, data, write, study.provenance, gaps=gaps
        )
    told = tuple(dict.fromkeys((*outcome.failures, *gaps.sentences)))
    data.update(
        folder=str(home),
        files=files,
        page=str(pages[0]) if pages else None,
        completed=not told,
        failures=list(told),
    )

    def show(console: Any) -> None:
        outcome.show(console)
        console.print(f"\nkept in {home}", soft_wrap=True)

    return replace(outcome, data=data, show=show, failures=told)
