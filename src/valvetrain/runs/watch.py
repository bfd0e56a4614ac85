"""Progress of long calls at a prompt and in the cells of a notebook, unless the caller gives its own."""

from __future__ import annotations

import inspect
from collections.abc import Callable
from functools import wraps
from typing import Any, ParamSpec, TypeVar

from valvetrain import registry
from valvetrain.session import interactive, on_main_thread

P = ParamSpec("P")
Result = TypeVar("Result")
#: Titles of the calls whose progress is shown: one at a time, the outermost.
_SHOWN: list[str] = []


def shows_progress(
    title: str, counted: bool = False
) -> Callable[[Callable[P, Result]], Callable[P, Result]]:
    """Decorator: the argument ``progress`` of a function, where it is None, is a bar in an
    interactive session.

    Parameters
    ----------
    title : what the call does, in a word
    counted : its ``progress`` is called with a count and a total, not with a share and a text
    """

    def decorate(function: Callable[P, Result]) -> Callable[P, Result]:
        signature = inspect.signature(function)
        run: Any = function  # whose arguments are bound again

        @wraps(function)
        def call(*arguments: P.args, **options: P.kwargs) -> Result:
            if _SHOWN or not (interactive() and on_main_thread()):
                return function(*arguments, **options)
            given = signature.bind(*arguments, **options)
            if given.arguments.get("progress") is not None:
                return function(*arguments, **options)
            case = getattr(next(iter(given.arguments.values()), None), "case", None)
            kernels = ("train",) if getattr(case, "train", None) else ("statics",)
            _SHOWN.append(title)
            try:
                with registry.find("displays", "progress")(title, kernels) as report:
                    if report is not None:
                        given.arguments["progress"] = _counting(report) if counted else report
                    result: Result = run(*given.args, **given.kwargs)
                    return result
            finally:
                _SHOWN.clear()

        return call

    return decorate


def _counting(report: Callable[[float, str], None]) -> Callable[[int, int], None]:
    return lambda done, total: report(done / max(total, 1), f"{done} of {total}")
