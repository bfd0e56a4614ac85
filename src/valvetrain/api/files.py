"""What was saved read again, two of a kind compared, and a function of many designs."""

from __future__ import annotations

import os
import pickle
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Any, TypeVar

from valvetrain.api.case import Case
from valvetrain.errors import InputError, MissingExtraError
from valvetrain.runs.stopping import shows_progress
from valvetrain.solution.result import Solution

Result = TypeVar("Result")


def load(path: str | os.PathLike[str]) -> Any:
    """What :func:`save` wrote: a case (``.toml``) or a result (``.nc``).

    Parameters
    ----------
    path : of the file

    Returns
    -------
    Case, or the result: equal to what was saved, arrays and numbers to the bit

    Raises
    ------
    InputError : another kind of file, or one that cannot be read

    Examples
    --------
    >>> import valvetrain as vt
    >>> path = vt.Case("job-t").save("mine.toml")
    >>> vt.load(path) == vt.Case("job-t")
    True
    """
    from valvetrain.solution.netcdf import load_result

    readers: dict[str, Callable[[Any], Any]] = {".toml": Case, ".nc": load_result}
    target = Path(path)
    if target.suffix not in readers:
        raise InputError(
            f"files of '{target.suffix or target.name}' are not read; give one that ends in {', '.join(readers)}"
        )
    return readers[target.suffix](target)


def save(item: Any, path: str | os.PathLike[str]) -> Path:
    """Write a case (``.toml``) or any result (``.nc``; a solution ``.csv`` as well), whole or not at
    all.

    A result is one NetCDF file whatever it holds, a study with its failed runs, critical speeds and
    static curves too, so that no part can be lost or be of another run; a tuple, list or dict of
    results is one as well. The page and the tables of a study are written by its ``report``.

    Parameters
    ----------
    item : Case; Solution, Study, StudyTable, Optimum, Identified and every other result
    path : of the file

    Returns
    -------
    Path of the file

    Raises
    ------
    InputError : a file of another kind; what no file holds, such as a function of your own

    Examples
    --------
    >>> import valvetrain as vt
    >>> study = vt.Case("job-t").compare("2000 rpm", ["massless", "wave-rod"])
    >>> again = vt.load(vt.save(study, "both.nc"))
    >>> all(run.identical(other) for run, other in zip(again.solutions, study.solutions))
    True
    """
    from valvetrain.solution.netcdf import save_result

    target = Path(path)
    if isinstance(item, Case):
        if target.suffix != ".toml":
            raise InputError("a case is saved to a file that ends in .toml")
        return item.save(target)
    return save_result(item, target)


def diff(first: Any, second: Any) -> dict[str, tuple[Any, Any]]:
    """What differs between two cases (by key path) or two solutions (by quantity).

    Parameters
    ----------
    first, second : two cases, or two solutions

    Returns
    -------
    dict of name -> (value in first, value in second), SI

    Raises
    ------
    InputError : two things of different kinds

    Examples
    --------
    >>> import valvetrain as vt
    >>> case = vt.Case("job-t")
    >>> vt.diff(case, case.set({"operation.cycles": 4}))
    {'operation.cycles': (2, 4)}
    """
    if isinstance(first, Case) and isinstance(second, Case):
        return first.diff(second)
    if isinstance(first, Solution) and isinstance(second, Solution):
        one, other = first.quantities, second.quantities
        return {
            name: (one.get(name), other.get(name))
            for name in dict.fromkeys([*one, *other])
            if one.get(name) != other.get(name)
        }
    raise InputError("two cases or two solutions are compared; give two of a kind")


@shows_progress("map", counted=True)
def map(
    function: Callable[[Any], Result],
    designs: Iterable[Any],
    workers: int | None = None,
    progress: Callable[[int, int], None] | None = None,
) -> tuple[Result, ...]:
    """A function of every design, in their order, over processes; functions of a notebook's cell
    too.

    Parameters
    ----------
    function : of one design; what it uses travels with it
    designs : what the function takes, one after the other
    workers : processes; None for one per core, 1 for this process
    progress : called as ``progress(done, total)`` after each design

    Returns
    -------
    tuple of the results, one per design

    Raises
    ------
    InputError : a function or result that cannot be sent to another process; what the function raises;
        RunFailedError where the worker of a design is killed again and again

    Examples
    --------
    >>> import valvetrain as vt
    >>> vt.map(lambda rate: 2 * rate, [1.0, 2.0], workers=1)
    (2.0, 4.0)
    """
    from valvetrain.runs.workers import map_points

    sent = function if workers == 1 else _Sent(function)
    return map_points(_of_design, sent, tuple(designs), workers, processes=True, tell=progress)


def _of_design(function: Callable[[Any], Result], design: Any) -> Result:
    return function(design)


class _Sent:
    """A function that is sent to other processes by its content, not by its name."""

    def __init__(self, function: Callable[[Any], Any]) -> None:
        try:
            from cloudpickle import dumps
        except ImportError:
            if getattr(function, "__module__", "__main__") == "__main__":
                raise MissingExtraError(
                    "a function of a notebook needs cloudpickle to run in other processes; install it with pip install "
                    "'valvetrain[studies]', put the function into a module, or take workers=1"
                ) from None
            dumps = pickle.dumps
        try:
            self.content: bytes = dumps(function)
        except Exception as error:
            raise InputError(
                f"the function cannot be sent to other processes ({error}); leave out what it holds open, or take workers=1"
            ) from error

    def __call__(self, design: Any) -> Any:
        if "function" not in self.__dict__:
            self.function = pickle.loads(self.content)
        return self.function(design)

    def __getstate__(self) -> dict[str, bytes]:
        return {"content": self.content}
