"""``valvetrain compare-springs``: two springs side by side in one engine."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path, PurePath
from typing import Any

from valvetrain.cli.options import choose_case, name_case
from valvetrain.cli.request import MotionLine, RequestOf, command_of
from valvetrain.cli.run import KERNELS
from valvetrain.cli.run_answer import answer_study
from valvetrain.errors import InputError
from valvetrain.runs.request_fields import option, read_text
from valvetrain.runs.requests import CompareSprings


@dataclass(frozen=True, kw_only=True)
class PairLine(MotionLine):
    """The command line of a comparison: two cases with springs, and the engine in which both run."""

    first: str = option(read_text, "Case with a spring, or an engine.", metavar="CASE")
    second: str = option(read_text, "Case with the other spring, or an engine.", metavar="CASE")
    train: str = option(
        read_text,
        "Engine in which both run (default: that of a case of the two that has one).",
        "--train",
        "CASE",
        default="",
    )

    def request(self, model: type[RequestOf], given: Mapping[str, Any]) -> tuple[RequestOf, Path]:
        """The request of the engine."""
        names = (self.train,) if self.train else (self.first, self.second)
        for name in names:
            if self.train or choose_case(name).train is not None:
                request = super().request(model, {**given, "case": name})
                kept = {"--train": self.train, "--rpm": given["engine_speeds"]}
                more = (part for name, text in kept.items() if text for part in (name, text))
                name_case(self.first, self.settings, (self.second, *more))
                return request
        raise InputError(
            "neither case has a train that moves the springs; give the engine with --train CASE",
            "--train",
        )


def compare_springs(request: CompareSprings, line: PairLine, folder: Path) -> None:
    """Compare two springs in one engine over its speed: surge, clash, stress, float, side by side.

    A spring is a case with \\[spring], as spring-card writes it, or an engine, of which the set in
    use is taken; --set changes the engine.
    """
    from valvetrain.runs.compare_springs import paired
    from valvetrain.runs.run import sweep_study

    pair = choose_case(line.first), choose_case(line.second)
    stems = PurePath(line.first).stem, PurePath(line.second).stem
    request = paired(request, *pair, stems).with_speeds()
    answer_study(request, line, folder, sweep_study, request.cost(), KERNELS)


register = command_of(
    CompareSprings, PairLine, compare_springs, case=None, spring_sets=None, compute=None
)
