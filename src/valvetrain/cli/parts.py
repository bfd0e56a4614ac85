"""``valvetrain study --parts``: the parts of a case by the engine speed of control that each gains."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from valvetrain.cli.options import choose_case, folder_of, name_case, take_folder
from valvetrain.cli.request import CommandLine, RequestOf
from valvetrain.errors import InputError
from valvetrain.runs.request_fields import option, read_names, read_path, read_switch
from valvetrain.runs.requests import Parts, Watch


@dataclass(frozen=True, kw_only=True)
class PartsLine(CommandLine):
    """The command line of ``study``, whose file is a case with ``--parts``."""

    parts: bool = option(
        read_switch,
        "FILE is a case: rank its parts by the engine speed of control that each gains.",
        "--parts",
        default=False,
    )
    settings: tuple[str, ...] = option(
        lambda given, _: tuple(given),
        "With --parts: change a value of the case, written as in its file. Repeatable.",
        "--set",
        "KEY.PATH=VALUE",
        default=(),
        repeatable=True,
    )
    spring_sets: tuple[str, ...] = option(
        read_names,
        "With --parts: spring set of the train.",
        "--spring-set",
        "SET",
        default=(),
        repeatable=True,
    )
    output: Path | None = option(
        read_path,
        "Folder of points and results; points that it holds are not computed again (default: runs/study/FILE).",
        "--output",
        "FOLDER",
    )

    def request(self, model: type[RequestOf], given: Mapping[str, Any]) -> tuple[RequestOf, Path]:
        """The study of a file or, with ``--parts``, the ranking of a case."""
        if not self.parts:
            if self.settings or self.spring_sets:
                raise InputError(
                    "a study file says itself what changes; give --set and --spring-set with --parts",
                    "--set" if self.settings else "--spring-set",
                )
            return super().request(model, {**given, "output": self.output})
        if given["dask"]:
            raise InputError("parts are ranked on this machine; leave --dask out", "--dask")
        name = given["file"]
        name_case(
            name,
            self.settings,
            [part for one in self.spring_sets for part in ("--spring-set", one)],
        )
        take_folder(self.output)
        asked = {
            "case": choose_case(name, self.settings),
            "spring_sets": self.spring_sets or None,
            "workers": given["workers"],
            "limit": given["limit"],
        }
        request: Any = Parts.read(asked, flags=True).with_speeds()
        return request, folder_of(name)


def answer_parts(request: Parts, line: PartsLine, folder: Path) -> None:
    """Rank the parts of a case, save the ranking and print its answer."""
    from valvetrain.cli.outcome import deliver
    from valvetrain.cli.progress import announce_compilation, progress_bar
    from valvetrain.cli.run_answer import SavedRequest, saved_result
    from valvetrain.runs.cost import refuse_cost
    from valvetrain.runs.part_ranking import rank_parts
    from valvetrain.views.parts import PartsAnswer

    refuse_cost(request.cost(), request.limit)
    announce_compilation("statics", "transient", "train")
    with progress_bar(request.case.name) as report:
        ranking = rank_parts(request, Watch(report))
    table = ranking.to_pandas()
    data = {
        "command": request.command, "case": request.case.name, "engine_speed": ranking.engine_speed, "seat_load": ranking.seat_load,
        "parts": {"units": table.attrs["units"], "rows": table.to_dict("records")},
    }  # fmt: skip
    deliver(
        saved_result(
            SavedRequest(request.command, request.case, line.output, folder),
            ranking.text,
            data,
            lambda _: PartsAnswer(ranking),
            lambda path: [ranking.save(path / "parts.nc")],
            {"parts": True},
            line.open_page,
        )
    )
