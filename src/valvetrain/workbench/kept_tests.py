"""Files of tests that were laid over a kept run: they stay in its folder, beside its results and never among them, and go with it."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from valvetrain.errors import InputError
from valvetrain.solution.atomic import write_bytes
from valvetrain.studies.run_store import refuse_living, safe_name
from valvetrain.units.text import clipped
from valvetrain.workbench.kept import TESTS, Run
from valvetrain.workbench.names import checked_name, inside

#: Bounds of the tests of one run: files, and bytes together.
MOST_TESTS, MOST_TESTS_BYTES = 5, 25_000_000


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
    found = [
        KeptTest(path.name, path.stat().st_size, path.stat().st_mtime_ns, path)
        for path in folder.iterdir()
        if path.is_file() and not path.is_symlink() and not path.name.startswith(".")
    ]
    return sorted(found, key=lambda one: (-one.changed, one.name))


def kept_test(run: Run, name: str) -> KeptTest:
    """The test of that name. Raises :class:`InputError` where there is none."""
    checked_name(name)
    for one in kept_tests(run):
        if one.name == name:
            return one
    raise InputError(f"there is no test '{clipped(name, 60)}' over this run; it may have been removed", "test")


def keep_test(run: Run, name: str, content: bytes) -> KeptTest:
    """Keep the file of a test with a run, in place of one of the same name.

    Parameters
    ----------
    run : the run
    name : name of the file; what no file here may be called is left out of it
    content : its bytes

    Raises
    ------
    InputError : beyond the bounds, or for a run that goes on
    """
    stem = Path(safe_name(Path(name).name.lstrip("_.+- ")))
    ours = checked_name(f"{stem.stem[:50]}{stem.suffix[:10]}")
    others = [one for one in kept_tests(run) if one.name != ours]
    if len(others) >= MOST_TESTS or sum(one.size for one in others) + len(content) > MOST_TESTS_BYTES:
        most = f"{MOST_TESTS} tests of {MOST_TESTS_BYTES / 1e6:.0f} MB"
        raise InputError(f"with a run are kept at most {most}; remove one that is laid over it", clipped(name, 60))
    refuse_living(run.folder)
    write_bytes(inside(run.folder, TESTS, ours), content)
    return kept_test(run, ours)


def remove_test(run: Run, name: str) -> None:
    """Remove a test that was laid over a run. Raises :class:`InputError` where there is none."""
    kept_test(run, name).path.unlink(missing_ok=True)
    if not any((run.folder / TESTS).iterdir()):
        (run.folder / TESTS).rmdir()
