"""The events of a cam against dead centre, as cam cards print them: IVO, IVC, EVO and EVC."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping
from dataclasses import dataclass

from valvetrain.errors import InputError

TURN = 2 * math.pi
#: Event -> the crank angle (rad) of the dead centre next to it and its word, and whether the trade counts it before.
EVENTS = {
    "IVO": (0.0, "top", True), "IVC": (math.pi, "bottom", False), "EVO": (-math.pi, "bottom", True), "EVC": (0.0, "top", False)
}  # fmt: skip
#: Key of a case file -> the event.
KEYS = {
    "intake_opens": "IVO", "intake_closes": "IVC", "exhaust_opens": "EVO", "exhaust_closes": "EVC"
}  # fmt: skip
_ANGLE = re.compile(
    r"(\d+(?:\.\d*)?)\s*(?:deg\w*|°)?\s*(before|after|[ba])\s*(top|bottom|[tb])\s*(?:dead cent(?:re|er)|dc)?",
    re.IGNORECASE,
)


@dataclass(frozen=True, slots=True)
class CamEvents:
    """Where a cam opens and closes its valve: crank angles (rad) from top dead centre of gas exchange.

    >>> cam = CamEvents.of({"IVO": "5 after top", "IVC": "32.5 after bottom"}, "intake")
    >>> round(math.degrees(cam.duration), 6), round(math.degrees(cam.centre), 6)
    (207.5, 108.75)
    """

    valve: str
    opens: float
    closes: float

    @classmethod
    def of(cls, texts: Mapping[str, str], valve: str) -> CamEvents:
        """The events of the ``intake`` or ``exhaust`` valve among ``texts``, such as ``{"IVO": "5 deg before top"}``.

        Raises :class:`InputError` for an event that is missing, an angle of unknown side, and a valve that closes first.
        """
        first, last = (valve[0].upper() + end for end in ("VO", "VC"))
        angles = {one: _angle(one, texts[one]) for one in (first, last) if one in texts}
        if missing := next((event for event in (first, last) if event not in angles), ""):
            raise InputError(
                f'{first} and {last} go together; add {_key(missing)} = "{_example(missing)}"'
            )
        opens, closes = angles[first], angles[last]
        if not 0 < closes - opens < TURN:
            raise InputError(
                f"{_key(first)} and {_key(last)} are {math.degrees(closes - opens):g} crank degrees apart; check before, after, top and bottom"
            )
        return cls(valve, opens, closes)

    @property
    def duration(self) -> float:
        """Crank angle (rad) from opening to closing."""
        return self.closes - self.opens

    @property
    def centre(self) -> float:
        """Crank angle (rad) from top dead centre to the middle of the event: before it of the exhaust, after it of the intake."""
        middle = (self.opens + self.closes) / 2
        return -middle if self.valve == "exhaust" else middle


def against_dead_centre(opens: float, closes: float) -> dict[str, float]:
    """Event -> its angle (rad) as the trade counts it, of crank angles (rad) after top dead centre of gas exchange.

    IVO counts before top, IVC after bottom, EVO before bottom and EVC after top; the valve whose middle comes
    before top dead centre is the exhaust.

    >>> {event: round(math.degrees(angle), 1) for event, angle in against_dead_centre(0.1, 3.7).items()}
    {'IVO': -5.7, 'IVC': 32.0}
    """
    turns = 2 * TURN * round((opens + closes) / 4 / TURN)
    valve = "I" if opens + closes >= 2 * turns else "E"
    return {
        event: (-1 if EVENTS[event][2] else 1) * (angle - turns - EVENTS[event][0])
        for event, angle in ((f"{valve}VO", opens), (f"{valve}VC", closes))
    }


def side_of(event: str, crank_angle: float) -> str:
    """On which side of which dead centre a ``crank_angle`` (rad) of :func:`against_dead_centre` is: ``after top``."""
    _, dead, before = EVENTS[event]
    return f"{'before' if before == (crank_angle >= 0) else 'after'} {dead}"


def events_in(text: str) -> dict[str, str]:
    """Event -> text of its angle, of a list such as ``IVO 5 ATDC, IVC 32.5 ABDC``. Raises :class:`InputError`."""
    parts = [part.strip() for part in re.split("[,;]", text) if part.strip()]
    found = {part[:3].upper(): part[3:].strip(" =:") for part in parts}
    if not found or found.keys() - EVENTS.keys() or len(found) < len(parts):
        raise InputError(
            "events are IVO, IVC, EVO and EVC, each once: 'IVO 5 before top, IVC 32.5 after bottom'; correct the list",
            "events",
        )
    return found


def _key(event: str) -> str:
    return next(key for key, word in KEYS.items() if word == event)


def _example(event: str) -> str:
    return f"5 deg {'before' if EVENTS[event][2] else 'after'} {EVENTS[event][1]}"


def _angle(event: str, text: str) -> float:
    found = _ANGLE.fullmatch(text.strip())
    if found is None or not float(found[1]) <= 180:
        raise InputError(
            f"{event} '{text[:40]}' is no angle up to 180 degrees before or after a dead centre; write {_key(event)} = \"{_example(event)}\", "
            "or before and after, top and bottom, as it is",
            _key(event),
        )
    dead = 0.0 if found[3][0].lower() == "t" else math.pi * (1 if event[0] == "I" else -1)
    side = -1 if found[2][0].lower() == "b" else 1
    return dead + side * math.radians(float(found[1]))
