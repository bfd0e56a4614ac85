"""Names that come from a browser, and places inside the workspace: nothing that a request names leads out of it."""

from __future__ import annotations

import os
import re
from pathlib import Path

from valvetrain.errors import InputError
from valvetrain.studies.run_store import safe_name
from valvetrain.units.text import clipped

#: Longest name of a case or a file (characters).
LONGEST = 60
_NAME = re.compile(r"[^\W_][\w.+-]*")


def case_name(name: str) -> str:
    """The name of a case as its folder bears it, from what somebody typed or uploaded: ``"My spring.toml"`` becomes ``"My-spring"``.

    Raises :class:`InputError` for a name without letters or digits, or a longer one than :data:`LONGEST`.

    >>> case_name("My spring.toml")
    'My-spring'
    """
    stem = name.strip().removesuffix(".toml")
    if not re.search(r"[^\W_]", stem):
        raise InputError("a case needs a name with a letter or a digit; give one such as my-spring", "name")
    if len(stem) > LONGEST:
        raise InputError(f"'{clipped(stem)}' has {len(stem)} characters; use at most {LONGEST}", "name")
    made = safe_name(stem).lstrip("_+")
    return checked_name(made)


def checked_name(name: str) -> str:
    """``name`` where a file or folder of the workspace may bear it: letters, digits, ``.``, ``+``, ``_`` and ``-``, none of them leading.

    Raises :class:`InputError` for anything else: separators, ``..``, hidden files, zero bytes, reserved words.

    >>> checked_name("spring-2.toml")
    'spring-2.toml'
    """
    plain = isinstance(name, str) and len(name.encode("utf-8", "replace")) <= 200 and _NAME.fullmatch(name) is not None
    if not plain or ".." in name or name.endswith(".") or name.split(".")[0].upper() in _RESERVED:
        raise InputError(f"'{clipped(str(name), 40)}' is no name of a file here; use letters, digits, '-', '_' and '.'", "name")
    return name


def inside(root: Path, *parts: str) -> Path:
    """The path ``root/parts...``, each part a :func:`checked_name` and nothing on the way a link.

    Raises :class:`InputError` otherwise, whether or not it exists.
    """
    place = root
    for part in parts:
        place = place / checked_name(part)
        if place.is_symlink():
            raise InputError(f"'{clipped(part, 40)}' is a link, and links are not followed; put the file itself there", "name")
    if os.path.commonpath((place.resolve(), root.resolve())) != str(root.resolve()):
        raise InputError("this name leads out of the workspace; give another", "name")
    return place


#: Names that some systems keep for devices.
_RESERVED = {"CON", "PRN", "AUX", "NUL", *(f"{device}{n}" for device in ("COM", "LPT") for n in range(1, 10))}
