"""A lift law of another kind: values common to both kinds stay, and the last values of a kind return when
it is chosen again.
"""

from __future__ import annotations

import json
import re
import tomllib
from collections.abc import Callable, Iterator, Sequence
from contextlib import suppress
from pathlib import Path
from typing import Any

from valvetrain import registry
from valvetrain.errors import InputError
from valvetrain.parameters.annotations import split_notes
from valvetrain.parameters.changes import nearest
from valvetrain.parameters.toml_text import toml_text
from valvetrain.solution.atomic import write_text
from valvetrain.units.text import clipped
from valvetrain.workbench.edits import opened, saved
from valvetrain.workbench.side_files import names_in
from valvetrain.workbench.starts import assumed

#: File next to the case with the kinds that its lift law had; hidden, so that nothing
#: hands it out or takes it for an input.
STORE = ".lift-laws.json"
#: Larger ones are not read (bytes).
MAX_STORE_BYTES = 100_000_000
#: Values that the tables of lift laws begin with.
_LAW = {
    "maximum_lift": "9 mm", "opening_start": "115 deg", "opening_end": "180 deg", "closing_start": "180 deg", "closing_end": "245 deg",
}  # fmt: skip
_HEAD, _HEADER = "[lift_law]\n", re.compile(r"^\[lift_law\][ \t]*(#.*)?\n", re.MULTILINE)
_OF_FILES = {"lift_of": "valve", "angle_of": "cam", "angle_unit": "deg", "lift_unit": "mm"}


def kind_of(text: str) -> str:
    """Kind of the lift law of the case file ``text``; empty where it has none."""
    law = split_notes(tomllib.loads(text))[0].get("lift_law")
    return str(law.get("kind", "")) if isinstance(law, dict) else ""


def with_law(text: str, kind: str, files: Sequence[str]) -> str:
    """The case file ``text`` with a lift law of another ``kind``: what both kinds know stays, the
    rest is assumed to begin with.

    Notes on the whole law go, and what the zero of its angle means where its numbers do not stay.
    ``files``: names of the files next to the
    case, of which a law that reads one gets the first. Raises :class:`InputError` for an unknown
    kind, and for one that reads a file where
    there is none.
    """
    document = opened(text)
    if kind not in registry.names("lifts") or "lift_law" not in document:
        raise InputError(
            f"kind '{kind[:40]}' of a lift law is unknown; {nearest(kind, registry.names('lifts'))}",
            "lift_law.kind",
        )
    law, known = _in_one_table(document), registry.find("lifts", kind).table.model_fields
    for name in [name for name in law if name not in known]:
        del law[name]
    law["kind"] = kind
    reads = "file" in known and "file" not in law and "lifts" not in law
    if reads and not files:
        raise InputError(
            f"a lift law of kind '{kind}' reads a file; add it below 'Files of this case' first",
            "lift_law.kind",
        )
    begun = [
        name
        for name in (_OF_FILES if reads else _LAW)
        if name in known and name not in law and (reads or known[name].is_required())
    ]
    if "zero_of_angle" in law and (
        reads or begun or not set(law) - {"kind", "lift_of", "zero_of_angle"}
    ):
        del law["zero_of_angle"]
    if reads:
        law["file"] = files[0]
    for name in begun:
        law[name] = assumed((_OF_FILES | _LAW)[name])
    return saved(document)


def law_of(text: str) -> str:
    """The lift law of the case file ``text`` as a text of its own, with its comments where it
    is in one table.
    """
    tree = {"lift_law": tomllib.loads(text)["lift_law"]}
    found = ""
    with suppress(InputError, AttributeError, LookupError, TypeError, ValueError):
        law = opened(text)["lift_law"]
        table_text = law.as_string()
        found = (
            f"lift_law = {table_text}\n" if table_text.startswith("{") else f"{_HEAD}{table_text}"
        )
        if tomllib.loads(found) == tree:
            return found
    return toml_text(tree)


def with_law_of(text: str, law: str) -> str:
    """The case file ``text`` with the lift law of :func:`law_of` in place of its own.

    Raises :class:`InputError` for a case written in a way that does not take it.
    """
    due = tomllib.loads(text) | tomllib.loads(law)
    for put in (_spliced, _replaced):
        with suppress(ValueError, LookupError, TypeError, AttributeError):
            made = put(text, law)
            if tomllib.loads(made) == due:
                return made
    raise InputError(
        "this case is written in a way that takes no other lift law here; change it in the case file itself",
        "lift_law.kind",
    )


def _spliced(text: str, law: str) -> str:
    """Line for line, where both laws are below a header of their own."""
    body, head = opened(text)["lift_law"].as_string(), _HEADER.search(text)
    if head is None or not text.startswith(body, head.end()) or not law.startswith(_HEAD):
        raise ValueError("is elsewhere")
    end = head.end() + len(body)
    return text[: head.end()] + law.removeprefix(_HEAD) + text[end:]


def _replaced(text: str, law: str) -> str:
    """As the writer of case files does."""
    document, table = opened(text), opened(law)["lift_law"]
    del document["lift_law"]
    document["lift_law"] = table
    return saved(document)


def _in_one_table(document: Any) -> Any:
    """The lift law of a ``document``, put into one table where its keys are scattered."""
    import tomlkit

    law = document["lift_law"]
    if (
        isinstance(law, (tomlkit.items.Table, tomlkit.items.InlineTable))
        and not getattr(law, "is_super_table", bool)()
    ):
        return law
    del document["lift_law"]
    document["lift_law"] = tomlkit.item(law.unwrap())
    return document["lift_law"]


class CachedLaws:
    """The last values of each kind of the lift law of a case, in a file next to it.

    Parameters
    ----------
    folder : folder of the case
    """

    def __init__(self, folder: Path) -> None:
        self._path = folder / STORE
        found: Any = None
        with suppress(OSError, ValueError, RecursionError):
            if not self._path.is_symlink() and self._path.stat().st_size <= MAX_STORE_BYTES:
                found = json.loads(self._path.read_text("utf-8"))
        read: dict[str, dict[str, str]] = {"told": {}, "begun": {}}
        for part, laws in read.items():
            given = found.get(part) if isinstance(found, dict) else None
            laws.update(
                {
                    str(kind): law
                    for kind, law in (given if isinstance(given, dict) else {}).items()
                    if isinstance(law, str)
                }
            )
        self._last_values, self._begun = read["told"], read["begun"]

    def changed(
        self, text: str, kind: str, files: Sequence[str], read: Callable[[str], object]
    ) -> str:
        """The case file ``text`` with a law of ``kind``: its last values, else what is made of
        ``text``.

        Of ``files`` the first that reads as one is named. ``read`` reads a case file, or raises
        :class:`InputError`.

        Raises :class:`InputError` where nothing reads.
        """
        refused = ""
        try:
            for made in self._texts(text, kind, files):
                try:
                    read(made)
                except InputError as error:
                    named = ", ".join(sorted(names_in(made)))
                    refused = (
                        f"'{clipped(named, 60)}': {error.reason}"
                        if named and named not in error.reason
                        else error.reason
                    )
                else:
                    return made
        except InputError as error:
            if not refused:
                raise
            raise InputError(
                f"the last values of kind '{kind}' are no longer readable ({refused}); {error.reason}",
                "lift_law.kind",
            ) from None
        reason = f"kind '{kind}' needs more than this lift law gives ({refused})"
        raise InputError(
            f"{reason}; write its table in the downloaded case, and open that", "lift_law.kind"
        )

    def _texts(self, text: str, kind: str, files: Sequence[str]) -> Iterator[str]:
        """Case files to try, the first that reads being the one."""
        law = self._last_values.get(kind)
        if law is not None and kind in registry.names("lifts"):
            with suppress(ValueError):
                if kind_of(law) == kind:
                    yield with_law_of(text, law)
        last = ""
        for name in files or [""]:
            made = with_law(text, kind, [name] if name else [])
            if made == last:
                return  # it reads no file
            yield (last := made)

    def keep(self, text: str, made: str) -> None:
        """Save the values of the law of the case file ``text`` before that of ``made`` takes its
        place, but where it was only begun.
        """
        reason, begun = law_of(text), law_of(made)
        if not _same(reason, self._begun.get(kind_of(text))):
            self._last_values[kind_of(text)] = reason
        if _same(begun, self._last_values.get(kind_of(made))):
            self._begun.pop(kind_of(made), None)
        else:
            self._begun[kind_of(made)] = begun
        write_text(
            self._path,
            json.dumps({"told": self._last_values, "begun": self._begun}, ensure_ascii=False),
        )


def _same(law: str, other: str | None) -> bool:
    """Whether two texts of :func:`law_of` are equal."""
    with suppress(ValueError):
        return other is not None and tomllib.loads(law) == tomllib.loads(other)
    return False
