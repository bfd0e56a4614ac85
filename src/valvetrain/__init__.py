"""case file -> parameters -> Problem -> System -> integrate -> Solution -> quantities -> report

Dynamics of valve springs and valvetrains. Public names are in ``__init__.pyi`` of this package and
of its folders; each loads its module on first use, so that ``import valvetrain`` costs next to nothing.
"""

from __future__ import annotations

from valvetrain.lazy import name_of_earlier_release, public_names

__version__ = "0.1.0"

_public, __dir__, __all__ = public_names(__name__, __file__)

#: Names of an earlier release under another name now; those that only moved to a folder are found there.
_RENAMED = {
    "seen_by_sensor": "rig.sensor_response",
    "card_of_table": "spring_card.card_from_table",
    "build": "system.build.build",
    "bibtex": "citations.bibtex",
}


def __getattr__(name: str) -> object:
    if name in __all__:
        return globals().setdefault(name, _public(name))
    return name_of_earlier_release(__name__, name, __file__, _RENAMED)
