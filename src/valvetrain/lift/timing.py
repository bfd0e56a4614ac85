"""Events against dead centre: of cams whose events were typed in, and read off a lift whose timing is known."""

from __future__ import annotations

import tomllib
from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np

from valvetrain.cam.contract import build_lift_law
from valvetrain.errors import InputError
from valvetrain.lift.figures import CARD, LiftFigure, LobeResult, height_key, height_text
from valvetrain.measured.cam_events import KEYS, CamEvents, against_dead_centre, events_in
from valvetrain.measured.lift_file import MeasuredLift
from valvetrain.parameters.loading import load_case


def cams_of(text: str, file: Path | None) -> tuple[CamEvents, ...]:
    """The cams whose events a ``text`` such as ``IVO 5 ATDC, IVC 32.5 ABDC`` or the lift law of a case ``file`` says."""
    events = events_in(text) if text else {}
    if file is not None:
        table = tomllib.loads(file.read_text()).get("lift_law", {})
        events |= {event: table[key] for key, event in KEYS.items() if key in table}
    valves = [one for one in ("intake", "exhaust") if one[0].upper() in {word[0] for word in events}]  # fmt: skip
    return tuple(CamEvents.of(events, valve) for valve in valves)


def lift_of_case(file: Path) -> tuple[MeasuredLift, float | None]:
    """The lift law of a case as stations at whole cam degrees, and its cam angle (rad) of top dead centre.

    Raises :class:`InputError` for a case without a lift law.
    """
    case = load_case(str(file))
    if case.lift_law is None:
        raise InputError(
            f"'{file.name}' holds no lift law; add a [lift_law] table, or give a table of lifts"
        )
    angles = np.radians(np.arange(361.0))
    lifts = build_lift_law(case.lift_law).lift(angles)
    top = case.lift_law.top_dead_centre
    if case.train is not None and case.train.crank is not None and top is None:
        top = case.train.crank.top_dead_centre
    return MeasuredLift("lift", angles, lifts, case.lift_law.lift_of, "case"), top


def typed_figures(cams: Sequence[CamEvents]) -> tuple[LiftFigure, ...]:
    """Duration and lobe centre of each cam (crank rad) at 0.050 in; lobe separation (cam rad) and overlap of two."""
    at, figures = height_text(CARD), []
    for cam in cams:
        side = "before" if cam.valve == "exhaust" else "after"
        figures += [
            LiftFigure(f"event_duration_{cam.valve}", f"{cam.valve} duration at {at}", cam.duration, 0.0, "deg"),
            LiftFigure(f"event_centre_{cam.valve}", f"{cam.valve} lobe centre {side} top dead centre", cam.centre, 0.0, "deg"),
        ]  # fmt: skip
        for event, angle in against_dead_centre(cam.opens, cam.closes).items():
            name = f"{event.lower()}_at_{height_key(at)}"
            figures.append(LiftFigure(name, f"{event} at {at}", angle, 0.0, "deg"))
    if len(cams) == 2:
        intake, exhaust = cams
        apart, lap = (intake.centre + exhaust.centre) / 2, exhaust.closes - intake.opens
        figures.append(LiftFigure("lobe_separation", "lobe separation", apart, 0.0, "deg"))
        figures.append(LiftFigure(f"overlap_at_{height_key(at)}", f"overlap at {at}", lap, 0.0, "deg"))  # fmt: skip
    return tuple(figures)


def read_off(lobes: Sequence[LobeResult], dead_centre: float) -> tuple[LiftFigure, ...]:
    """Events of ``lobes`` against dead centre at every height of their durations; ``dead_centre``: the cam angle
    (rad) of top dead centre of gas exchange.
    """
    found = []
    for lobe in lobes:
        figures: Mapping[str, LiftFigure] = {one.name: one for one in lobe.figures}
        for name in figures:
            if name.startswith("opening_at_"):
                key = name.removeprefix("opening_at_")
                ends = [figures[f"{end}_at_{key}"] for end in ("opening", "closing")]
                angles = against_dead_centre(*(2 * (one.value - dead_centre) for one in ends))
                found += [
                    LiftFigure(f"{event.lower()}_at_{key}", f"{event} {end.label[8:]}", angle, 2 * end.spread, "deg")
                    for (event, angle), end in zip(angles.items(), ends, strict=True)
                ]  # fmt: skip
    return tuple(found)


def dead_centre_of(lobe: LobeResult, lobe_centre: float) -> float:
    """Cam angle (rad) of top dead centre, of a lobe whose middle at 0.050 in is ``lobe_centre`` (crank rad) after it."""
    if (centre := lobe.values.get("lobe_centre")) is None:
        raise InputError("a lobe below 0.050 in has no lobe centre; give --top-dead-centre", "--lobe-centre")  # fmt: skip
    return centre - lobe_centre / 2
