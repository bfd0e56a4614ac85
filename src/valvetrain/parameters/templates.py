"""Templates of ``valvetrain new``: commented case files by kind."""

from __future__ import annotations

from pathlib import Path

from valvetrain.errors import InputError
from valvetrain.parameters.train_names import TITLES, answer, meant_kind

TEMPLATES = Path(__file__).parent.parent / "templates"


#: Kind -> what it is, in the order of the help.
KINDS = {"spring": "a spring alone"} | TITLES


#: Kind -> whose lift its cam card gives.
CARDS = {"direct": "tappet", "finger": "valve", "rocker": "valve"}


def template_kind(name: str) -> str:
    """The kind of template that ``name`` means, a key of :data:`KINDS` or what users call it.

    Raises :class:`InputError` for an unknown one.

    >>> template_kind("bucket")
    'direct'
    """
    if (kind := meant_kind(name, tuple(KINDS))) is None:
        raise InputError(
            f"there is no template of the kind '{name[:40]}'; {answer(name, tuple(KINDS))}",
            "--kind",
        )
    return kind


def template_text(kind: str, cards: bool = False) -> str:
    """The commented case of ``kind`` (a key of :data:`KINDS`), with ``NAME.toml`` for its
    file; a name in use such as "bucket" is understood; with ``cards`` its cam and springs by their cards, a dual spring among them.

    Raises :class:`InputError` for an unknown kind.

    >>> "[spring]" in template_text("spring")
    True
    """
    name = template_kind(kind)
    return (TEMPLATES / f"{'cards/' if cards and name != 'spring' else ''}{name}.toml").read_text(
        encoding="utf-8"
    )
