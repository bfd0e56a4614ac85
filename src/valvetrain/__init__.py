"""case file -> parameters -> Problem -> System -> integrate -> Solution -> quantities -> findings -> views

Dynamics of valve springs and valvetrains. ``docs/architecture.md`` follows a run along this line, file by file: the command
through ``cli/main.py`` and ``cli/run.py``, the study in ``runs/run.py``, its page in ``views``.

Public names are in ``__init__.pyi`` of this package and of its folders; each loads its module on first use, so that
``import valvetrain`` costs next to nothing.
"""

from __future__ import annotations

from valvetrain.lazy import module_of, public_names

__version__ = "0.1.0"

_public, __dir__, __all__ = public_names(__name__, __file__)


def __getattr__(name: str) -> object:
    if name in __all__:
        return globals().setdefault(name, _public(name))
    return module_of(__name__, name, __file__)
