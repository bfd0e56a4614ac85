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
#: Comments of a template at which its lift law, the speeds, the contacts and the end begin.
_LAW, _SPEEDS, _CONTACTS = "# The lift of", "# Speeds of the crank", "# Contacts. Other laws"
_STEEL = """# Contacts between steel parts of typical size, or a table for each place; friction alone: {place}.friction_coefficient = 0.06.
[train.contacts]
others = "steel"

"""


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
    kind = template_kind(kind)
    text = _text(kind)
    if not cards or kind == "spring":
        return text
    if kind == "pushrod":  # which is by cards already
        return text.replace(
            "# Another set, known", f"{_text('cards/dual').lstrip()}\n# Another set, known", 1
        )
    head, rest = text.split(_LAW, 1)
    middle = rest[rest.index(_SPEEDS) :].split(_CONTACTS, 1)[0]
    # The card gives the lash, and the springs are those of the cards.
    lines = [line for line in middle.splitlines(True) if not line.startswith("lash =")]
    middle = "".join(lines).replace('spring_set = "stock"', 'spring_set = "card"')
    place = "valve_tip" if 'shape = "roller"' in middle else "cam"  # a roller rolls
    steel = _STEEL.replace("{place}", place)
    return f"{head}{_text(f'cards/{CARDS[kind]}')}{middle}{steel}{_text('cards/springs')}"


def _text(name: str) -> str:
    return (TEMPLATES / f"{name}.toml").read_text(encoding="utf-8")
