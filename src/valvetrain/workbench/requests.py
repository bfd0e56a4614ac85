"""What a job computes: a request of a case, stored as a page sent it, and the command line that computes it; no part of it
reaches a shell.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import partial

from pydantic import TypeAdapter

from valvetrain.errors import InputError
from valvetrain.parameters.case import Case
from valvetrain.parameters.changes import nearest
from valvetrain.parameters.toml_text import toml_text
from valvetrain.runs.cost import Cost, Limits, cost_text, refuse_cost
from valvetrain.runs.request_fields import Option, option, options_of, read_count, read_text
from valvetrain.runs.requests import (
    March,
    Modes,
    Refine,
    Request,
    Run,
    RunUp,
    SpeedRequest,
    SpringRequest,
    Static,
    SteadyRequest,
    Sweep,
)
from valvetrain.units.text import clipped
from valvetrain.workbench.edits import refuse_foreign_files

#: Longest text of one field (characters).
MAX_LENGTH = 2000


@dataclass(frozen=True, kw_only=True)
class QuantityStudy(SpringRequest, SteadyRequest):
    """A case over one of its quantities, with one result: what a study file says in its simplest form."""

    command = "study"

    quantity: str = option(read_text, "Quantity that is varied.", metavar="KEY.PATH", default="")
    lowest: str = option(read_text, "First value, with its unit.", metavar="VALUE", default="")
    highest: str = option(read_text, "Last value, with its unit.", metavar="VALUE", default="")
    points: int = option(partial(read_count, 2, 200), "Number of values.", metavar="N", default="9")
    result: str = option(read_text, "Quantity of the answer.", metavar="NAME", default="preload")

    def __post_init__(self) -> None:
        """Raise :class:`InputError` without a quantity."""
        if not self.quantity:
            raise InputError("no quantity to vary is chosen; choose one", "quantity")

    def file_text(self, case_file: str) -> str:
        """The study file (TOML) of the case in ``case_file``."""
        ends = {"low": self.lowest.strip(), "high": self.highest.strip()}
        label = self.quantity.rpartition(".")[2].replace("_", " ")
        study = {
            "case": case_file,
            "engine_speeds": self.typed.get("engine_speeds", ""),
            "spring_sets": list(self.spring_sets),
            "spring_models": list(self.models),
            "outputs": [self.result],
            "points": {"sampler": "grid", "levels": self.points},
            "vary": [
                {
                    "key": self.quantity,
                    "label": label,
                    **{
                        end: float(text) if re.fullmatch(r"[-+]?\d+(\.\d+)?", text) else text
                        for end, text in ends.items()
                        if text
                    },
                }
            ],
        }
        return toml_text({name: value for name, value in study.items() if value})


#: What a job may compute, by the name of its command.
REQUESTS: Mapping[str, type[Request]] = {
    model.command: model
    for model in (Run, Sweep, March, QuantityStudy, RunUp, Static, Modes, Refine)
}
#: Fields that the server sets, or that a page has no field for.
SET_HERE = ("case", "workers", "limit")


@dataclass(frozen=True)
class JobRequest:
    """A request as a page sends it and the database stores it.

    Parameters
    ----------
    kind : a command of :data:`REQUESTS`
    case : id of the case; it is read when the job is submitted
    given : name of a field -> what was typed, ticked or chosen; the others have their defaults
    """

    kind: str
    case: str
    given: Mapping[str, str | bool | list[str]] = field(default_factory=dict)

    @property
    def fields(self) -> dict[str, Option]:
        """The fields that a page may give. Raises :class:`InputError` for an unknown kind."""
        if self.kind not in REQUESTS:
            kind = clipped(self.kind, 20)
            raise InputError(
                f"'{kind}' is no kind of job; {nearest(kind, tuple(REQUESTS))}", "kind"
            )
        return fields_of(REQUESTS[self.kind])

    def read(self, case: Case) -> Request:
        """The request of a ``case``. Raises :class:`InputError` for what the command would refuse, and what it
        must never be shown.
        """
        fields = self.fields
        for name, value in self.given.items():
            if name not in fields:
                raise InputError(f"'{clipped(name, 40)}' is no field of a {self.kind}", "job")
            if value == []:
                raise InputError(f"no {name.replace('_', ' ')} are chosen; tick one or more", name)
            if isinstance(value, str) and len(value) > MAX_LENGTH:
                raise InputError(f"more than {MAX_LENGTH} characters; give a range", name)
        request = REQUESTS[self.kind].read({**self.given, "case": case})
        for word in getattr(request, "spring_sets", ()):
            if case.train is None or word not in case.train.springs:
                raise InputError(
                    f"'{clipped(word, 40)}' is no spring set of this case; choose one of its own",
                    "spring_sets",
                )
        if isinstance(request, QuantityStudy):
            refuse_foreign_files(case.text, {request.quantity: request.lowest})
        return request

    def command_line(self, file: str, workers: int, limits: Limits, folder: str) -> list[str]:
        """Words of the command line; ``file``: the case, or the study file, whose points and answer go to ``folder``."""
        words = [
            self.kind,
            "--json",
            f"--limit={limits.seconds:.0f} s",
            f"--limit={limits.bytes / 1e6:.0f} MB",
        ]
        if "workers" in options_of(REQUESTS[self.kind]):
            words.append(f"--workers={workers}")
        if self.kind == QuantityStudy.command:
            return [*words, f"--output={folder}", "--", file]
        for name, value in self.given.items():
            flag, _, opposite = self.fields[name].flag.partition("/")
            if isinstance(value, bool):
                words += filter(None, [flag if value else opposite])
            else:
                texts = [value] if isinstance(value, str) else value
                words += [f"{flag}={text}" for text in texts]
        return [*words, "--", file]

    def cost_text(self, case: Case, limits: Limits) -> str:
        """What the request will cost, ``"about 12 s and 35 MB"``; empty where only its job can say. Raises
        :class:`InputError` where it is refused or beyond the ``limits``.
        """
        request = self.read(case)
        if isinstance(request, QuantityStudy):
            return ""
        if isinstance(request, SpeedRequest):
            request = request.with_speeds()
        cost: Cost = request.cost()  # type: ignore[attr-defined]
        refuse_cost(cost, limits, "valvetrain serve --limit ")
        return cost_text(cost)


#: The request as text of the database, and back.
STORED = TypeAdapter(JobRequest)


def fields_of(model: type[Request]) -> dict[str, Option]:
    """The fields of a request that a page may give."""
    fields = options_of(model).items()
    return {name: one for name, one in fields if (one.flag or one.metavar) and name not in SET_HERE}
