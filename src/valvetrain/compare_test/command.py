"""``valvetrain compare-test``: a case against measured cycles or values, and whether the model is
adequate.
"""

from __future__ import annotations

import shlex
from dataclasses import replace
from pathlib import Path

from valvetrain.cli.request import SavedLine, command_of
from valvetrain.compare_test.request import CompareTest
from valvetrain.runs.request_fields import options_of


def compare_test(request: CompareTest, line: SavedLine, folder: Path) -> None:
    """Whether a model agrees with a test within the scatter of the test, and where it is worst."""
    from valvetrain.cli.outcome import deliver
    from valvetrain.cli.progress import announce_runs, progress_bar
    from valvetrain.cli.run_answer import SavedRequest, saved_result
    from valvetrain.compare_test.answer import AgainstTestAnswer
    from valvetrain.compare_test.compare import against_test
    from valvetrain.compare_test.reader import read_test
    from valvetrain.compare_test.tables import compare_test_json, write_compare_test

    assert request.test is not None
    read = replace(request, test=read_test(request.test, request.quantity))
    announce_runs(request.case)
    with progress_bar(request.case.name) as report:
        result = against_test(read, report)
    asked = options_of(CompareTest)
    words = ["--test", str(request.test)]
    words += [
        part
        for name in ("quantity", "engine_speed", "bandwidth", "sensor", "shared", "fitted")
        if name in request.typed
        for part in (asked[name].flag, request.typed[name])
    ]
    words += [part for name in request.spring_sets for part in ("--spring-set", name)]
    failed = list(result.failures)
    data = {"command": request.command, "completed": not failed, "failures": failed}
    deliver(
        saved_result(
            SavedRequest(request.command, request.case, line.output, folder),
            result.study.record.text,
            data | compare_test_json(result),
            lambda _: AgainstTestAnswer(result, test=shlex.join(words)),
            lambda folder: write_compare_test(result, folder),
            {"test": str(request.test)},
            line.open_page,
            failed,
        )
    )


register = command_of(CompareTest, SavedLine, compare_test)
