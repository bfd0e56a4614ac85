"""Sessions that somebody watches, a prompt or a notebook: whether this is one, and what is said
there of compilation.
"""

from __future__ import annotations

import os
import shlex
import sys
import threading
from contextvars import ContextVar
from functools import cache
from multiprocessing import parent_process

#: Names the open file (its number) of a calling program that receives the progress; ``off`` silences
#: prompts and notebooks.
PROGRESS_VARIABLE = "VALVETRAIN_PROGRESS"
COMPILING = "compiling kernels, once, about {:.0f} s"
#: Kernel that is compiled first of those that one kind of work needs -> seconds of all of them, on
#: one core.
COMPILE_SECONDS = {
    "stretch_terms": 4.0, "advance_chain": 5.0, "integrate_in_time": 12.0, "advance_train": 16.0,
}  # fmt: skip
#: The case with its changes as the command line has it; empty in a program.
_CASE: ContextVar[str] = ContextVar("case_of_the_command", default="")


def call_case(arguments: list[str]) -> None:
    """Remember how the command line names its case, so that a next step can be copied."""
    _CASE.set(shlex.join(arguments))


def called_case() -> str:
    """How the command line names its case, with its changes; empty in a program.

    >>> called_case()
    ''
    """
    return _CASE.get()


def interactive() -> bool:
    """Whether this process is a Python prompt or the kernel of a notebook, both of which set
    ``sys.ps1``; no script, test, command or worker does.
    """
    return (
        hasattr(sys, "ps1")
        and os.environ.get(PROGRESS_VARIABLE) != "off"
        and parent_process() is None
    )


def on_main_thread() -> bool:
    """Whether this is the thread that runs what is typed, the only one that draws progress."""
    return threading.current_thread() is threading.main_thread()


@cache
def announce_compilation(kernel: str) -> None:
    """One line in an interactive session before a kernel that takes long is compiled."""
    if kernel in COMPILE_SECONDS and interactive():
        sentence = COMPILING.format(COMPILE_SECONDS[kernel])
        print(f"valvetrain: {sentence}", file=sys.stderr, flush=True)
