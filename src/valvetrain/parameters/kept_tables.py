"""Tables of lifts that were read: the same content is not read, nor smoothed, again."""

from __future__ import annotations

import hashlib
import threading
from collections import OrderedDict
from pathlib import Path

from valvetrain.errors import InputError
from valvetrain.parameters.bounded_file import bounded_bytes, named_file
from valvetrain.parameters.lift_law import LiftLawParameters
from valvetrain.parameters.schema_lift import LiftModel

#: Laws from files that are kept.
MOST_KEPT = 8
_Key = tuple[type[LiftModel], str, tuple[str, ...], bytes]
_kept: OrderedDict[_Key, LiftLawParameters] = OrderedDict()
_turn = threading.Lock()


def parameters_of(law: LiftModel, folder: Path) -> LiftLawParameters:
    """What the table of a ``law`` says, with the files that it names in ``folder``; one that was read from the same bytes before is kept.

    Raises what the table itself raises, which is never kept.
    """
    key = _key(law, folder)
    with _turn:
        if key is not None and key in _kept:
            _kept.move_to_end(key)
            return _kept[key]
    found = law.parameters(folder)
    if key is not None and key == _key(law, folder):  # the file stayed the same while it was read
        with _turn:
            _kept[key] = found
            while len(_kept) > MOST_KEPT:
                _kept.popitem(last=False)
    return found


def _key(law: LiftModel, folder: Path) -> _Key | None:
    """The words of a law and the content of its file; None where it names none, or none that can be read."""
    name = getattr(law, "file", None)
    ours = type(law).__module__.startswith("valvetrain.")  # a law of somebody else may read more than this file
    if not isinstance(name, str) or not ours:
        return None
    try:
        content = bounded_bytes(named_file(folder, name), "lift table")
    except (InputError, OSError, ValueError):
        return None
    return type(law), repr(law), tuple(sorted(law.model_fields_set)), hashlib.sha256(content).digest()
