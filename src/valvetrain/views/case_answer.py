"""What ``check`` shows of a case: verdict, the values of its lift, springs and cam, and a picture to scale."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
import plotly.graph_objects as go

from valvetrain.cam.contract import LiftLaw
from valvetrain.errors import InputError
from valvetrain.findings.engine import Mark
from valvetrain.findings.rules_case import RULES, CaseFacts
from valvetrain.findings.rules_train import NEEDED
from valvetrain.findings.springs_at_rest import TOGETHER
from valvetrain.findings.words import Amount, speed_text
from valvetrain.quantities.cam_shape import lash_lift
from valvetrain.quantities.table import EVENT_LIFTS
from valvetrain.solution.definition import is_defined, label_of
from valvetrain.solution.static import RestPoint
from valvetrain.views.at_rest import TO_BIND, bind_line, wound_text
from valvetrain.views.motion.still import case_picture
from valvetrain.views.shown import ShownByRules
from valvetrain.views.style import ANGLE, LEAD, SECOND, FigureSpec, line, panels, styled
from valvetrain.views.table import Line, TextTable

#: Spring -> its states closed and at full lift, or why it has none.
Loads = Mapping[str, "tuple[RestPoint, RestPoint] | str"]


@dataclass(frozen=True)
class CaseAnswer(ShownByRules):
    """A checked case.

    Parameters
    ----------
    checked : the case as rules read it
    said : subject and text of what the case says, as it was understood
    loads : of the springs in use
    durations : lift (m) -> crank angle (rad) above it
    law : its lift law; None without one
    words : units and language
    """

    rules = RULES

    checked: CaseFacts
    said: Sequence[tuple[str, str]] = ()
    loads: Loads = field(default_factory=dict)
    durations: Mapping[float, float] = field(default_factory=dict)
    law: LiftLaw | None = None

    @property
    def facts(self) -> CaseFacts:
        """The case as rules read it."""
        return self.checked

    @property
    def title(self) -> str:
        """Name and title of the case, with its red line."""
        case = self.facts.parameters
        red = case.operation.red_line
        line = "" if red is None else f" (red line {speed_text(red, '')})"
        return f"{': '.join(filter(None, (case.name, case.title)))}{line}"

    @property
    def headings(self) -> list[str]:
        """The springs in use and both together, where there are several."""
        return [*self.loads, TOGETHER] if len(self.loads) > 1 else [""]

    @cached_property
    def lines(self) -> list[Line]:
        """Lift, lash, loads, coil bind, cam and engine speeds."""
        amounts = {name: self._text(name) for name in self.facts.values}
        case, texts = self.facts.parameters, list[tuple[str, str | tuple[str, ...], str]]()
        valve = amounts.get("rigid_maximum_valve_lift", "")
        law = amounts.get("maximum_lift", "")
        gear = self.facts.gear
        driven = gear is not None and gear.mechanism.kinematics.law_of == "drive"
        note = f"the {'lobe' if driven else 'law'} lifts {law}" if valve and valve != law else ""
        texts.append(("valve lift" if valve else "lift", valve or law, note))
        if case.train is not None and case.train.lash:
            texts.append(
                (
                    "lash",
                    self.words.amount(Amount("maximum_lift", case.train.lash)),
                    ", ".join(
                        (*(one.remark for one in self.findings.by("Q117")), self._ramp_left())
                    ),
                )
            )
        for label, place in (("closed", 0), ("full lift", 1)):
            texts.append((label, self._loads(place), ""))
        texts.append(("rate", self._rates(), "closed to full lift"))
        texts.append(self._needed())
        left = self.facts.left
        texts.append(("coil bind", "" if left is None else f"{self.words.amount(left)} left", "at full lift"))  # fmt: skip
        by_turns = wound_text(self.facts.amount, self.words)
        texts.append(("by wire and turns", by_turns, "to coil bind at full lift"))
        pressed = (one.remark for one in self.findings.by("Q118"))
        texts.append(
            ("least radius", amounts.get("cam_least_radius", ""), next(pressed, "of the cam"))
        )
        ramp = [amounts.get(name, "") for name in ("cam_ramp_lift", "cam_closing_ramp_velocity")]
        texts.append(("ramp", " at ".join(filter(None, ramp)), "closing"))
        height = "50_thou" if self.words.units == "imperial" else "1_mm"
        valve, lobe = (
            amounts.get(f"{what}_{height}_open_crank_angle_range", "")
            for what in ("rigid_valve", "lobe")
        )
        above = f"above {EVENT_LIFTS[height].removeprefix('at ')} of valve lift, rigid"
        texts.append(("valve open", valve, f"{above}; {lobe} of lobe lift" if lobe else above))
        speeds = case.operation.engine_speeds
        reach = [speed_text(one) for one in (speeds[:1] if len(speeds) == 1 else (min(speeds, default=0), max(speeds, default=0)))]  # fmt: skip
        texts.append(("engine speed", " to ".join(reach) if speeds else "", ""))
        return [self._line(*one) for one in texts if any(one[1])]

    def _line(self, label: str, cells: str | tuple[str, ...], note: str) -> Line:
        if isinstance(cells, str):
            cells = (*[""] * (len(self.headings) - 1), cells)
        if label in TO_BIND:
            return bind_line(label, cells, note, self.findings, self.words, self.facts.left)
        short = self.facts.short and label.startswith("needed")
        sharp = label == "least radius" and self.findings.by("Q118")
        mark: Mark = "warn" if short or sharp else ""
        return Line(label, cells, mark, note)

    def _ramp_left(self) -> str:
        """Up to which lash, about, the valve meets its seat on the closing ramp."""
        case, of_lobe = self.facts.parameters, lash_lift(self.facts.gear)
        ramp = self.facts.values.get("cam_ramp_lift", 0.0)
        if case.train is None or not ramp or not of_lobe:
            return ""
        most = Amount("cam_ramp_lift", case.train.lash * ramp / of_lobe)
        return f"on the ramp up to about {self.words.amount(most, 2)}"

    def _text(self, name: str) -> str:
        amount = self.facts.amount(name)
        return "" if amount is None or not is_defined(name) else self.words.amount(amount, 4)

    def _needed(self) -> tuple[str, str, str]:
        """What the springs would need together for a fifth above the inertia force at the highest speed in use."""
        needed = [self.facts.amount(name) for name in NEEDED]
        if not all(needed):
            return "", "", ""
        closed, full, rate = (one for one in needed if one)
        top = speed_text(self.facts.parameters.operation.top_speed)
        note = "seat to full lift, a fifth above inertia"
        if rate.value > 0:
            note += f"; or {self.words.amount(rate)} at your seat load"
        return f"needed at {top}", self.words.span(closed, full), note

    def _loads(self, place: int) -> tuple[str, ...]:
        return self._each("preload", lambda one: (one[place].force,))

    def _rates(self) -> tuple[str, ...]:
        return self._each("installed_rate", lambda one: (one[0].stiffness, one[1].stiffness))

    def _each(
        self, name: str, read: Callable[[tuple[RestPoint, RestPoint]], tuple[float, ...]]
    ) -> tuple[str, ...]:
        """What is read of every spring in use, closed and at full lift, and of all together where there are several."""
        found = [() if isinstance(one, str) else read(one) for one in self.loads.values()]
        if len(found) > 1:
            found.append(tuple(map(sum, zip(*found, strict=True))) if all(found) else ())
        spans = ([Amount(name, one) for one in values] for values in found)
        return tuple(self.words.span(one[0], one[-1]) if one else "" for one in spans)

    def _numbers(self) -> TextTable:
        """Every named quantity of springs, lift and cam, and the open times."""
        rows = [(label_of(name), text) for name in self.facts.values if (text := self._text(name))]
        rows += [
            (
                f"open above {self.words.amount(Amount('maximum_lift', height))}",
                self.words.amount(Amount("valve_50_thou_open_crank_angle_range", angle), 4),
            )
            for height, angle in self.durations.items()
        ]
        return TextTable("Numbers of springs, lift and cam", ("quantity", "value"), tuple(rows))

    def tables(self) -> Mapping[str, TextTable]:
        """The numbers, and what the case says as it was understood."""
        told = TextTable("As it was understood", ("", ""), tuple(self.said))
        return {"numbers": self._numbers(), "understood": told}

    def figures(self) -> Mapping[str, FigureSpec]:
        """The lift law."""
        return {"law": FigureSpec("Lift law", "", lambda _: self._law_figure())}

    def _law_figure(self) -> go.Figure | None:
        """Lift (mm) and acceleration (mm/rad²) of the law over the cam angle (deg)."""
        if self.law is None:
            return None
        angle = np.linspace(0, math.tau, 1441)
        lift, bend = 1e3 * self.law.lift(angle), 1e3 * self.law.lift(angle, 2)
        fig = panels((0.6, 0.4))
        fig.add_trace(line(np.degrees(angle), lift, "lift of the law", LEAD), 1, 1)
        fig.add_trace(line(np.degrees(angle), bend, "acceleration", SECOND), 2, 1)
        return styled(fig, ANGLE, (f"{self._whose()} lift, mm", "mm/rad²"), 380)

    def _whose(self) -> str:
        law = self.facts.parameters.lift_law
        return "" if law is None else law.lift_of

    def computed(self) -> Iterator[str]:
        """What the case says about itself."""
        if self.facts.parameters.description:
            yield self.facts.parameters.description

    @property
    def text(self) -> str:
        """The case file."""
        return self.facts.parameters.text

    def picture(self) -> str:
        """Valve closed and at full lift, to scale."""
        try:
            return case_picture(self.facts.parameters)
        except InputError:
            return ""
