"""Where commands and kinds of runs are added: one line each."""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

from valvetrain.errors import InputError

if TYPE_CHECKING:
    from valvetrain.cli.outcome import Outcome
    from valvetrain.cli.run_request import RunRequest
    from valvetrain.parameters.case import Case

#: Modules of this room that bring commands, in the order ``--help`` lists them. Each has ``register(app: typer.Typer) -> None`` and
#: imports nothing heavy before a command runs.
COMMAND_MODULES: tuple[str, ...] = (
    "run_command", "train_commands", "static_command", "modes_command", "refine_command", "library_commands",
)  # fmt: skip

#: What ``run`` does with a case: (field of the case that must be there, "module:function"), the first that fits counts.
#: The function takes a ``RunRequest`` and returns an ``Outcome``.
RUNNERS: tuple[tuple[str, str], ...] = (("train", "train_commands:run_train"), ("spring", "spring_run:run_spring"))


def register_all(app: Any) -> None:
    """Add every command of :data:`COMMAND_MODULES` to the typer application ``app``."""
    for name in COMMAND_MODULES:
        import_module(f"valvetrain.cli.{name}").register(app)


def run_case(request: RunRequest) -> Outcome:
    """Run a case by the first of :data:`RUNNERS` that fits. Raises :class:`InputError` for a case with nothing to run."""
    module, function = _runner(request.case).split(":")
    name = f"valvetrain.cli.{module}"
    try:
        found = import_module(name)
    except ModuleNotFoundError as error:
        if error.name != name:
            raise
        raise InputError(f"this version does not run what case '{request.case.name}' holds; run a case with a [spring] table") from None
    outcome: Outcome = getattr(found, function)(request)
    return outcome


def _runner(case: Case) -> str:
    for held, runner in RUNNERS:
        if getattr(case, held) is not None:
            return runner
    raise InputError(f"case '{case.name}' holds no spring and no train, so there is nothing to run; add a [spring] or [train] table")
