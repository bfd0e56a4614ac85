"""What is asked of the package with one input of each kind. An answer is a word; anything raised is
a finding.
"""

from __future__ import annotations

import contextlib
import io
import os
import random
import tempfile
from collections.abc import Callable
from pathlib import Path

from fuzz import files, runs, trees
from valvetrain.errors import InputError

#: A sentence of a refusal is no longer than this.
MAX_SENTENCE_LENGTH = 900


class Finding(Exception):
    """Something came back that is neither an answer nor one readable sentence."""


def sentence(error: InputError) -> str:
    """``refused``; raises :class:`Finding` where the refusal is no single printable line of
    reasonable length.
    """
    words = str(error)
    if not words or len(words) > MAX_SENTENCE_LENGTH:
        raise Finding(f"a sentence of {len(words)} characters: {words[:200]!r}")
    if not words.isprintable():
        raise Finding(f"a sentence that is no printable line: {words[:300]!r}")
    return "refused"


def case(content: bytes) -> str:
    """Read and build everything that ``run`` builds, as ``valvetrain check`` does."""
    from valvetrain.cli.case_facts import case_facts, case_quantities
    from valvetrain.cli.cases import put_together
    from valvetrain.parameters.loading import parse_case, read_case

    try:
        text = content.decode("utf-8")
    except UnicodeDecodeError:
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder, "case.toml")
            path.write_bytes(content)
            try:
                read_case(path)
            except InputError as error:
                return sentence(error)
        raise Finding("a file that is no text was read as a case") from None
    try:
        chosen = parse_case(text, where="case.toml")
        problem = put_together(chosen, ())
        case_facts(chosen)
        case_quantities(chosen, problem)
    except InputError as error:
        return sentence(error)
    return "accepted"


def command(*words: str) -> tuple[int, str]:
    """Exit code of a command, in this process, and what it said on both streams; an error that is
    no sentence is raised.
    """
    from valvetrain.cli.main import app
    from valvetrain.solution.partial_failures import TRACEBACK_VARIABLE

    said, before = io.StringIO(), os.environ.get(TRACEBACK_VARIABLE)
    os.environ[TRACEBACK_VARIABLE] = "1"
    try:
        with contextlib.redirect_stdout(said), contextlib.redirect_stderr(said):
            code = app(list(words), standalone_mode=False)
    finally:  # what runs after this in the same process must not inherit it
        os.environ.pop(TRACEBACK_VARIABLE) if before is None else os.environ.update(
            {TRACEBACK_VARIABLE: before}
        )
    if "\x1b" in said.getvalue():
        raise Finding(f"a control sequence reaches the terminal: {said.getvalue()[:300]!r}")
    return (code if isinstance(code, int) else 0), said.getvalue()


#: Kind -> (makes an input, asks about it).
KINDS: dict[str, tuple[Callable[[random.Random], bytes], Callable[[bytes], str]]] = {
    "cases": (trees.case_mutant, case), "runs": (runs.make, runs.ask), "files": (files.make, files.ask),
}  # fmt: skip
