"""What tests of the beehive's written page share."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path

from architecture.layout import ROOT


def assert_written_anew(
    main: Callable[[Sequence[str], Path], None], folder: Path, kept: Path, page: Path, picture: Path
) -> None:
    """Written anew into ``folder`` from the ``kept`` numbers alone, page and picture (below docs)
    are those of the repository.
    """
    docs = ROOT / "docs"
    for name in (kept, page):
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        (folder / name).write_text((docs / name).read_text(encoding="utf-8"), encoding="utf-8")
    (folder / picture).parent.mkdir(exist_ok=True)
    main([], folder)
    for name in (page, picture):
        assert (folder / name).read_text(encoding="utf-8") == (docs / name).read_text(
            encoding="utf-8"
        )
