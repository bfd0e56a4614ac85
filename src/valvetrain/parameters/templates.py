"""Templates of ``valvetrain new``: commented case files by kind."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from valvetrain.errors import InputError
from valvetrain.parameters.changes import nearest
from valvetrain.parameters.train_names import TITLES, answer, meant_kind

TEMPLATES = Path(__file__).parent.parent / "templates"


#: Kind -> what it is, in the order of the help.
KINDS = {"spring": "a spring alone"} | TITLES


#: Kind -> whose lift its cam card gives.
CARDS = {"direct": "tappet", "finger": "valve", "rocker": "valve"}


TRAINS = (*CARDS, "pushrod")
SPRING = "train.springs.card.0"


@dataclass(frozen=True)
class Question:
    """A value of a card: its ``key`` in the case, what ``follows`` its option, what it means, its ``default`` where the
    template has none, and the kinds of train that have it.
    """

    key: str
    follows: str
    meaning: str
    default: str = ""
    kinds: tuple[str, ...] = TRAINS

    @property
    def path(self) -> tuple[str | int, ...]:
        """Keys and places that lead to it."""
        return tuple(int(part) if part.isdecimal() else part for part in self.key.split("."))


_PUSHROD, _LEVER = ("pushrod",), ("finger", "rocker", "pushrod")
#: Answer -> its question, in the order in which a person has them.
QUESTIONS: dict[str, Question] = {
    "seat_load": Question(f"{SPRING}.preload", "FORCE", "spring force with the valve closed"),
    "height": Question(f"{SPRING}.installed_height", "LENGTH", "height of the spring with the valve closed"),
    "rate": Question(f"{SPRING}.rate", "RATE", "spring rate; or open load and open height"),
    "open_load": Question(f"{SPRING}.open_load", "FORCE", "spring force at the open height"),
    "open_height": Question(f"{SPRING}.open_height", "LENGTH", "height of the spring at the open load"),
    "coil_bind": Question(f"{SPRING}.solid_height", "LENGTH", "height at which the coils close"),
    "wire": Question(f"{SPRING}.wire_diameter", "LENGTH", "wire diameter, for the moving mass of the spring"),
    "outer_diameter": Question(f"{SPRING}.outer_diameter", "LENGTH", "outer diameter of the spring, for its moving mass"),
    "spring_mass": Question(f"{SPRING}.mass", "MASS", "of the turns that move, in place of the wire: a whole spring on the scale "
                            "times (turns - 2) / turns", "50 g"),
    "lift": Question("lift_law.valve_lift", "LENGTH", "valve lift at zero lash", "0.565 in"),
    "duration": Question("lift_law.duration", "ANGLE", "crank degrees above the checking lift"),
    "checking_lift": Question("lift_law.duration_lift", "LENGTH", "lift at which the duration is given: 0.050 in or 1 mm, of the "
                              "tappet, or of the valve with a finger or rocker on the cam", "0.050 in"),
    "advertised": Question("lift_law.advertised_duration", "ANGLE", "advertised duration in crank degrees"),
    "advertised_lift": Question("lift_law.advertised_lift", "LENGTH", "lift of the tappet at which it is advertised; of cams with lash "
                                "often 0.020 in", "0.006 in"),
    "lobe_centre": Question("lift_law.lobe_centre", "ANGLE", "of an intake lobe, crank degrees after top dead centre"),
    "ratio": Question("lift_law.rocker_ratio", "RATIO", "arm of the valve over that of cam or pushrod", kinds=_LEVER),
    "lash": Question("lift_law.lash", "LENGTH", "lash at the valve; 0 with hydraulic lifters"),
    "valve_mass": Question("train.valve.mass", "MASS", "valve, retainer and locks: '110 g + 25 g + 10 g'"),
    "lifter_mass": Question("train.follower.mass", "MASS", "lifter, or bucket with shim", kinds=("direct", "pushrod")),
    "pushrod_length": Question("train.pushrod.length", "LENGTH", "pushrod, between its balls", kinds=_PUSHROD),
    "pushrod_diameter": Question("train.pushrod.outer_diameter", "LENGTH", "outer diameter of the pushrod", kinds=_PUSHROD),
    "pushrod_wall": Question("train.pushrod.wall_thickness", "LENGTH", "wall of the pushrod", kinds=_PUSHROD),
    "pushrod_mass": Question("train.pushrod.mass", "MASS", "pushrod as weighed; without it that of its tube", kinds=_PUSHROD),
    "rocker_mass": Question("train.lever.mass", "MASS", "rocker or finger as weighed; without its inertia that of a uniform bar",
                            kinds=_LEVER),
    "rocker_inertia": Question("train.lever.inertia", "INERTIA", "rocker or finger about its pivot: '30 kg mm^2'", kinds=_LEVER),
    "rocker_stiffness": Question("train.lever.stiffness", "STIFFNESS", "force per bend at the valve tip: '40 kN/mm'; none: rigid, which "
                                 "loses no lift", kinds=_LEVER),
    "red_line": Question("operation.red_line", "SPEED", "highest engine speed in use"),
}  # fmt: skip


def flag(name: str) -> str:
    """The option of an answer."""
    return f"--{name.replace('_', '-')}"


def engine_names() -> tuple[str, ...]:
    """Names of the engines whose numbers have sources (docs/engines.md)."""
    return tuple(sorted(path.stem for path in (TEMPLATES / "engines").glob("*.toml")))


def engine_text(name: str) -> str:
    """The commented case of an engine of :func:`engine_names`, with ``NAME.toml`` for its file.

    Raises :class:`InputError` for an unknown one.

    >>> "[lift_law]" in engine_text("ls-beehive")
    True
    """
    if name not in engine_names():
        raise InputError(f"there is no engine '{name[:40]}'; {nearest(name, engine_names())}", "--like")  # fmt: skip
    return (TEMPLATES / "engines" / f"{name}.toml").read_text(encoding="utf-8")


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
