"""Results that save themselves, and those that write a page."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any, ClassVar

from valvetrain.registry import find
from valvetrain.solution.display import Shown


class Saveable(Shown):
    """A result with a table, a figure and a file of its own."""

    __slots__ = ()

    @property
    def verdict(self) -> str:
        """The result in one sentence, which opens its page and ends the answer of its command."""
        sentence: str = find("displays", "verdict")(self)
        return sentence

    def save(self, path: str | os.PathLike[str]) -> Path:
        """Write it to one NetCDF file (``.nc``), whole or not at all; :func:`valvetrain.load` reads
        an equal one. A solution may be a CSV file (``.csv``) as well.
        """
        written: Path = find("files", "result")(self, path)
        return written


class Reported(Saveable):
    """A result with a page, which is registered under ``report_word``."""

    __slots__ = ()
    report_word: ClassVar[str]

    def report(self, folder: str | os.PathLike[str], **options: Any) -> Any:
        """Write its page and data files to ``folder``.

        Returns
        -------
        StudyFiles with the paths of page and data; raises :class:`InputError` for a folder that cannot
        be written
        """
        return find("files", self.report_word)(self, Path(folder), **options)
