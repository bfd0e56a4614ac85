"""Pages that a build writes: each is written where its text changed only, so that a second build is short."""

from __future__ import annotations

from pathlib import Path


def keep(folder: Path, pages: dict[str, str]) -> None:
    """Write pages, and remove those of an earlier build that are none any more."""
    folder.mkdir(exist_ok=True)
    for old in folder.glob("*.rst"):
        if old.name not in pages:
            old.unlink()
    for name, text in pages.items():
        write_changed(folder / name, text)


def write_changed(path: Path, text: str) -> None:
    """Write a page where its text changed."""
    if not path.is_file() or path.read_text(encoding="utf-8") != text:
        path.write_text(text, encoding="utf-8")


def heading(text: str, line: str) -> str:
    """A heading of reStructuredText."""
    return f"{text}\n{line * len(text)}\n\n"
