"""Files of tests that were laid over a kept run: they stay in its folder, beside its results and never among them, and go with it."""

from __future__ import annotations

import hashlib
import re
import threading
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path

from valvetrain.errors import InputError
from valvetrain.solution.atomic import write_bytes
from valvetrain.studies.run_store import refuse_living, safe_name
from valvetrain.units.text import clipped
from valvetrain.workbench.disk import writing
from valvetrain.workbench.kept import TESTS, Run
from valvetrain.workbench.names import checked_name, inside

#: Bounds of the tests of one run: files, and bytes together.
MOST_TESTS, MOST_TESTS_BYTES = 5, 25_000_000
#: Longest stem of the name of a kept test, and longest ending (characters).
_STEM, _ENDING = 50, 10
#: What is checked still holds when it is written: one change of the kept tests at a time.
_turn = threading.RLock()


@dataclass(frozen=True, slots=True)
class KeptTest:
    """A file of a test that was laid over a run.

    Parameters
    ----------
    name : its name
    size : bytes
    changed : time at which it was kept (ns since the epoch)
    path : where it is
    """

    name: str
    size: int
    changed: int
    path: Path


def kept_tests(run: Run) -> list[KeptTest]:
    """Tests laid over a run, the newest first."""
    folder = run.folder / TESTS
    if folder.is_symlink() or not folder.is_dir():
        return []
    found = []
    with suppress(OSError):  # its last test was removed meanwhile
        for path in folder.iterdir():
            if path.is_file() and not path.is_symlink() and not path.name.startswith("."):
                with suppress(OSError):
                    told = path.stat()
                    found.append(KeptTest(path.name, told.st_size, told.st_mtime_ns, path))
    return sorted(found, key=lambda one: (-one.changed, one.name))


def kept_test(run: Run, name: str) -> KeptTest:
    """The test of that name. Raises :class:`InputError` where there is none."""
    checked_name(name)
    for one in kept_tests(run):
        if one.name == name:
            return one
    raise _gone(name)


def read_test(run: Run, name: str) -> tuple[KeptTest, bytes]:
    """The test of that name with its content. Raises :class:`InputError` where there is none, or none any more."""
    with _turn:
        found = kept_test(run, name)
        try:
            return found, found.path.read_bytes()
        except OSError:
            raise _gone(name) from None


def kept_name(sent: str) -> str:
    """The name under which a test that was sent as ``sent`` is kept: that name where a file here may bear it, else one of its own.

    Raises :class:`InputError` for a name of which nothing can be made.

    >>> kept_name("cycles-2.csv"), kept_name("My cycles, no 2.csv")
    ('cycles-2.csv', 'My-cycles-no-2-ef6dc0ac.csv')
    """
    sent = Path(sent).name
    ending = Path(sent).suffix
    stem = safe_name(sent.removesuffix(ending).lstrip("_.+- "))
    ending = "".join(char for char in ending if char.isalnum() or char in "._-")[:_ENDING].rstrip(".")
    if len(stem) > _STEM or f"{stem}{ending}" != sent or ".." in sent:
        digest = hashlib.sha256(sent.encode("utf-8", "replace")).hexdigest()[:8]
        stem = f"{re.sub(r'[.]{2,}', '.', stem)[: _STEM - 9].rstrip('.-')}-{digest}"
    return checked_name(f"{stem}{ending}")


def keep_test(run: Run, name: str, content: bytes) -> KeptTest:
    """Keep the file of a test with a run, in place of one that was sent under the same name.

    Parameters
    ----------
    run : the run
    name : name of the file; :func:`kept_name` tells under which it is kept
    content : its bytes

    Raises
    ------
    InputError : beyond the bounds, for a run that goes on, and where it cannot be written
    """
    ours = kept_name(name)
    with _turn:
        others = [one for one in kept_tests(run) if one.name != ours]
        if len(others) >= MOST_TESTS or sum(one.size for one in others) + len(content) > MOST_TESTS_BYTES:
            most = f"{MOST_TESTS} tests of {MOST_TESTS_BYTES / 1e6:.0f} MB"
            raise InputError(f"with a run are kept at most {most}; remove one that is laid over it", clipped(name, 60))
        refuse_living(run.folder)
        with writing("this test", clipped(name, 60)):
            write_bytes(inside(run.folder, TESTS, ours), content)
        return kept_test(run, ours)


def remove_test(run: Run, name: str) -> None:
    """Remove a test that was laid over a run. Raises :class:`InputError` where there is none."""
    with _turn:
        kept_test(run, name).path.unlink(missing_ok=True)
        with suppress(OSError):  # where others are left
            (run.folder / TESTS).rmdir()


def _gone(name: str) -> InputError:
    return InputError(f"there is no test '{clipped(name, 60)}' over this run; it may have been removed", "test")
