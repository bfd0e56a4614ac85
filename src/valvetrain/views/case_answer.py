"""What ``check`` shows of a case: verdict, the values of its lift, springs and cam, and the spring force needed."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
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
from valvetrain.quantities.kinematics import RigidTable
from valvetrain.quantities.table import EVENT_LIFTS
from valvetrain.quantities.train_numbers import needed_force
from valvetrain.solution.definition import is_defined, label_of
from valvetrain.solution.static import RestPoint
from valvetrain.views.at_rest import TO_BIND, bind_line, wound_text
from valvetrain.views.motion.still import case_picture
from valvetrain.views.shown import ShownByRules
from valvetrain.views.style import (
    ANGLE,
    BAD,
    BEFORE,
    LEAD,
    OK,
    RIGID,
    SECOND,
    FigureSpec,
    line,
    panels,
    styled,
)
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
    rigid : its train with rigid parts at the highest speed in use; None without one
    words : units and language
    """

    rules = RULES

    checked: CaseFacts
    said: Sequence[tuple[str, str]] = ()
    loads: Loads = field(default_factory=dict)
    durations: Mapping[float, float] = field(default_factory=dict)
    law: LiftLaw | None = None
    rigid: RigidTable | None = None

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
        if self.rigid is not None:
            mass = self.rigid["reduced_mass"]
            least, most = (Amount("card_mass", float(one)) for one in (mass.min(), mass.max()))
            note = "at the valve, springs by a third"
            texts.append(("moving mass", self.words.span(least, most), note))
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
        written = self._open(lift for _, lift, _ in getattr(self.law, "checking_points", ()))
        if lobe and not written:
            above += f"; {lobe} of lobe lift"
        texts.append(("valve open", valve, above))
        texts += [("lobe open", angle, f"above {height}") for height, angle in written]
        return [self._line(*one) for one in texts if any(one[1])]

    def _line(self, label: str, cells: str | tuple[str, ...], note: str) -> Line:
        if isinstance(cells, str):
            cells = (*[""] * (len(self.headings) - 1), cells)
        if label in TO_BIND:
            return bind_line(label, cells, note, self.findings, self.words, self.facts.left)
        spare = self.facts.spare
        short = spare and spare.value < 0 and label.startswith("needed")
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
        """What the springs need together for inertia plus 20 % at the highest speed in use."""
        closed, full, rate = (self.facts.amount(name) for name in NEEDED)
        spare = self.facts.spare
        if closed is None or full is None or rate is None or spare is None:
            return "", "", ""
        top = speed_text(self.facts.parameters.operation.top_speed)
        note = f"{self.words.amount(spare)} to spare"
        if spare.value < 0:
            note = f"or {self.words.amount(rate)} at your seat load"
        return (
            f"needed at {top}",
            self.words.span(closed, full),
            f"seat to full lift, inertia plus 20 %; {note}",
        )

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
        rows += [(f"lobe open above {one}", angle) for one, angle in self._open(self.durations)]
        return TextTable("Numbers of springs, lift and cam", ("quantity", "value"), tuple(rows))

    def _open(self, heights: Iterable[float]) -> list[tuple[str, str]]:
        """Heights and crank angle above them, of those that the lift law reaches."""
        return [
            (
                f"{self.words.amount(Amount('maximum_lift', height))} of {self._whose()} lift",
                self.words.amount(
                    Amount("valve_50_thou_open_crank_angle_range", self.durations[height]), 4
                ),
            )
            for height in heights
            if height in self.durations
        ]

    def tables(self) -> Mapping[str, TextTable]:
        """The numbers, and what the case says as it was understood."""
        told = TextTable("As it was understood", ("", ""), tuple(self.said))
        return {"numbers": self._numbers(), "understood": told}

    def figures(self) -> Mapping[str, FigureSpec]:
        """Spring force available and needed, of a train with a highest speed."""
        if self.rigid is None:
            return {}
        title = f"Spring force available and needed at {speed_text(self.facts.parameters.operation.top_speed)}"
        hint = "rigid parts; where inertia presses the valve on the cam nothing is needed"
        return {"force": FigureSpec(title, hint, lambda _: self._force_figure())}

    def _force_figure(self) -> go.Figure | None:
        """Force (N) of the springs at rest over the cam angle (deg), what inertia needs, and 20 % more, with the least margin."""
        rigid = self.rigid
        if rigid is None:
            return None
        angle, have = np.degrees(rigid.cam_angle), rigid["spring_force"]
        inertia, asked = have - rigid["spring_margin"], needed_force(rigid)
        fig = panels((1.0,))
        fig.add_trace(line(angle, have, "available", LEAD))
        fig.add_trace(line(angle, np.maximum(asked, 0), "needed: inertia plus 20 %", SECOND))
        fig.add_trace(line(angle, np.maximum(inertia, 0), "inertia alone", RIGID, "dash"))
        slowed = (rigid["valve_lift"] > 0) & (rigid["inertia_force"] < 0)
        at = int(np.argmax(np.where(slowed, asked - have, -np.inf)))
        spare = float(have[at] - asked[at])
        colour, word = (BAD, "short") if spare < 0 else (OK, "to spare")
        text = f"{self.words.amount(Amount(NEEDED[1], abs(spare)))} {word}"
        margin = line(angle[[at, at]], [asked[at], have[at]], word, colour, text=["", text])
        fig.add_trace(margin.update(mode="lines+text", textposition="top center", showlegend=False))
        shown = angle[rigid["valve_lift"] > 0]
        return styled(fig, ANGLE, ("N",)).update_xaxes(
            range=[shown[0] - BEFORE, shown[-1] + BEFORE]
        )

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
        """Valve closed and at full lift, to scale, of a case without a figure."""
        try:
            return "" if self.rigid else case_picture(self.facts.parameters)
        except InputError:
            return ""
