"""What rules and views read of a study: the runs that decide, numbers with their error bars, events, places.

No sentence is made here, and nothing is computed that a study does not hold.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Sequence
from functools import cached_property

import numpy as np

from valvetrain.arrays import Array, Flags
from valvetrain.findings.control import Control, control_of
from valvetrain.findings.words import Amount, joined, speed_text
from valvetrain.mechanism.rigid import OPEN_SHARE
from valvetrain.quantities.cycle import reported_cycle
from valvetrain.solution.critical import BOUNCE_HEIGHT
from valvetrain.solution.result import Solution
from valvetrain.solution.status import Cause, Event
from valvetrain.solution.study import SWEEPS, Study
from valvetrain.solution.uncertainty import OF_CONTACT
from valvetrain.system.contract import TRAIN

#: Spring models by how much of the wire they know, the least first; of those that know the same, the last is the one
#: that a run takes, so that run, sweep and comparison judge by one model.
TRUST = (
    "massless", "multi-mass", "wave-rod", "modal-uniform", "modal-varied", "wave-rod-clash", "reduced-rod",
    "finite-element", "solid",
)  # fmt: skip
#: Ends of runs whose numbers count: the motion ended, or does not repeat.
JUDGED = ("completed", "not-converged")
#: A number of runs that a negative value of has no meaning: a valve that flies loses no lift.
LOSSES = ("lift_loss_displacement", "valve_50_thou_lost_crank_angle_range")
#: What decides blows and raw peaks, of which no error bar tells.
CONSTANTS = "contact constants"
LOST = ("loft", "loss-of-contact")
#: Ranges of engine speed that a sentence names.
SPANS = 3
TURN = 2 * math.pi
#: Cam angle (rad) over which :meth:`Facts.motion` looks ahead, and share of the lift below which a valve is shut.
AHEAD, SHUT = 0.02, 0.003
#: Cam angle (rad) before and after a blow in which a force is its own.
BLOW = (math.radians(0.5), math.radians(3))


class Facts:
    """A study as rules read it.

    Parameters
    ----------
    study : what ``simulate``, ``sweep``, ``compare``, ``compare_springs`` or ``run_up`` gave

    Attributes
    ----------
    runs : those that decide, by engine speed: of each spring set the model that knows most of its wire; over engine
        speed those in use, up to the red line, else to where control ends
    beyond : of the same models those at higher speeds
    others : runs by other models, which findings name and never judge by
    ended : runs that did not end well
    """

    def __init__(self, study: Study) -> None:
        self.study = study
        every = (*study.solutions, *study.between)
        judged = [run for run in every if run.status.code in JUDGED]
        best: dict[str, int] = {}
        for run in judged:
            best[run.spring_set] = max(best.get(run.spring_set, 0), trust(run))
        lead = [run for run in judged if trust(run) == best[run.spring_set]]
        lead.sort(key=lambda run: run.engine_speed)
        self.run_up = study.command == "run-up"
        self.sweep = study.command in SWEEPS
        self.lead_labels = tuple(dict.fromkeys(run.label for run in lead))
        in_use = [run for run in lead if run.engine_speed <= self.in_use * (1 + 1e-9)]
        self.runs = tuple(in_use or lead)
        self.beyond = tuple(run for run in lead if run not in self.runs)
        self.others = tuple(run for run in judged if run not in lead)
        self.ended = tuple(run for run in every if run.status.code not in JUDGED)
        self.train = any(run.provenance.system == TRAIN for run in every)

    @cached_property
    def kinds(self) -> tuple[str, ...]:
        """What this study is, by which the registry lists rules, figures and tables: its command; ``train`` or ``spring``;
        ``sweeps`` (runs at steady speeds), ``searched`` and ``published`` where it is.
        """
        study = self.study
        also = {"sweeps": self.sweep, "searched": self.searched, "published": bool(study.comparisons)}  # fmt: skip
        kind = "train" if self.train else "spring"
        return (study.command, kind, *(name for name, holds in also.items() if holds))

    # -- numbers -----------------------------------------------------------------------------------

    def value(self, run: Solution, name: str) -> float:
        """A quantity (SI) of a run, or of what belongs to no run; NaN where neither has it."""
        if name in run.quantities:
            value = float(run.quantities[name])
            return max(0.0, value) if name in LOSSES else value
        still = self.study.still
        places = (still.get(key, {}) for key in (run.label, run.spring_set, run.model, ""))
        limits = {"permitted_bounce_height": BOUNCE_HEIGHT, **dict(self.study.record.limits)}
        return next((float(one[name]) for one in (*places, limits) if name in one), math.nan)

    def amount(self, run: Solution, name: str) -> Amount | None:
        """The same with its error bar; None where there is no such number."""
        value = self.value(run, name)
        if not math.isfinite(value):
            return None
        row = self.study.error_bars.of(name, run.label, run.engine_speed)
        bar, ends = (0.0, None) if row is None else (row.numerical, row.contact_range)
        if ends is not None:
            return Amount(name, value, max(bar, value - ends.low, ends.high - value))
        blow = OF_CONTACT.search(name) or (name == "peak_cam_contact_force" and self.struck(run))
        return Amount(name, value, bar, CONSTANTS if value != 0 and blow else "")

    def struck(self, run: Solution) -> str:
        """The blow that the largest force on the cam is: of a ``landing`` after a flight, or of the ``lash`` that is taken
        up; empty for none.
        """
        angle, (before, after) = self.value(run, "peak_cam_contact_force_cam_angle"), BLOW
        ends = [one.details.get("landing_cam_angle") for one in run.events if one.kind == "loft"]
        if any(
            (angle - float(one) + before) % TURN <= before + after
            for one in ends
            if one is not None
        ):
            return "landing"
        opens = self.value(run, "rigid_valve_lash_opening_cam_angle")
        return "lash" if (angle - opens + after) % TURN <= 2 * after else ""

    def amounts(
        self, name: str, runs: Iterable[Solution] | None = None
    ) -> Iterator[tuple[Amount, Solution]]:
        """A quantity of all runs that have it; by default of those that decide."""
        for run in self.runs if runs is None else runs:
            if (one := self.amount(run, name)) is not None:
                yield one, run

    def of_label(self, label: str) -> list[Solution]:
        """Runs of a label by engine speed, those of other models too."""
        every = (*self.runs, *self.beyond, *self.others)
        return sorted(
            (run for run in every if run.label == label), key=lambda run: run.engine_speed
        )

    # -- events ------------------------------------------------------------------------------------

    def losses(self, run: Solution) -> list[Event]:
        """Losses of contact of the drive that count, the largest gap first."""
        found = (one for one in run.events if one.kind in LOST and one.counts)
        return sorted(found, key=lambda one: -one.size)

    def strikes(self, run: Solution) -> list[Event]:
        """Blows of coils, the hardest first; coils that come to rest on each other strike no blow."""
        found = (one for one in run.events if one.kind == "clash" and not rests(one))
        return sorted(found, key=lambda one: -one.size)

    def motion(self, run: Solution, cam_angle: float) -> str:
        """Code of what the valve does at a cam angle (rad): ``closes``, ``opens`` or ``shut``; empty without its lift."""
        if not run.has("valve_lift"):
            return ""
        lift, angles = over_turn(run, "valve_lift"), reported_cycle(run).cam_angle
        here, later = np.interp([cam_angle, cam_angle + AHEAD], angles, lift, period=TURN)
        if max(here, later) < SHUT * lift.max():
            return "shut"
        return "closes" if later < here else "opens"

    def least_angle(self, run: Solution, channel: str) -> Amount | None:
        """Cam angle at which a channel is least while the valve is open; None without channels."""
        if not run.has(channel, "valve_lift"):
            return None
        values = np.where(open_mask(run), over_turn(run, channel), np.inf)
        angle = float(reported_cycle(run).cam_angle[int(np.argmin(values))])
        return Amount("loft_cam_angle", angle)

    def nose(self, run: Solution) -> Amount:
        """Cam angle at which rigid parts lift the valve most."""
        lift = over_turn(run, "rigid_valve_lift" if run.has("rigid_valve_lift") else "valve_lift")
        angle = float(reported_cycle(run).cam_angle[int(np.argmax(lift))])
        return Amount("loft_cam_angle", angle % TURN)

    # -- places ------------------------------------------------------------------------------------

    @cached_property
    def speeds(self) -> tuple[float, ...]:
        """Engine speeds (rad/s) of the runs that decide."""
        return tuple(sorted({run.engine_speed for run in self.runs}))

    @cached_property
    def models(self) -> tuple[Solution, ...]:
        """A run of every spring model at the highest speed that decides, the most trusted first; none of several spring
        sets, of runs over engine speed, or by one model alone.
        """
        if (
            len({run.spring_set for run in self.runs}) != 1
            or self.several
            or self.run_up
            or self.sweep
        ):
            return ()
        here = (
            run
            for run in (*self.runs, *self.others)
            if math.isclose(run.engine_speed, self.speeds[-1], rel_tol=1e-6)
        )
        found: dict[str, Solution] = {}
        for run in here:
            found.setdefault(run.model, run)
        return tuple(sorted(found.values(), key=lambda run: -trust(run))) if len(found) > 1 else ()

    # -- control over engine speed -----------------------------------------------------------------

    @cached_property
    def searched(self) -> bool:
        """Whether a search over engine speed looked for where control is lost."""
        return self.sweep and bool(len(self.study.critical_speeds))

    def control(self, label: str) -> Control:
        """What a search found of a label."""
        return control_of(self.study, label)

    def curve(self, label: str) -> tuple[tuple[float, float, float], ...]:
        """Engine speed (rad/s), least cam force (N) and surge (N) of all runs of a label, those of the search among them."""
        return next(
            (row.curve for row in self.study.critical_speeds if row.label == label and row.curve),
            (),
        )

    @cached_property
    def first_label(self) -> str:
        """The label that loses control first, of those that decide; the first one where none does."""
        return min(self.lead_labels, key=lambda label: self.control(label).limit, default="")

    @property
    def in_use(self) -> float:
        """Engine speed (rad/s) up to which runs count: over engine speed the red line, else where control ends."""
        if not (self.run_up or self.sweep):
            return math.inf
        if self.study.record.red_line is not None or not self.searched:
            return self.red_line
        return self.control(self.first_label).limit

    # -- text of places ----------------------------------------------------------------------------

    @property
    def several(self) -> bool:
        """Whether the runs that decide differ in more than their engine speed."""
        return len({run.label for run in self.runs}) > 1

    def at(self, run: Solution) -> str:
        """``at 8000 rpm`` where several speeds were run, with the label where several variants were."""
        speed = f"at {speed_text(run.engine_speed)}" if len(self.speeds) > 1 else ""
        return f"{speed} ({run.label})".strip() if self.several else speed

    def where(self, runs: Sequence[Solution]) -> str:
        """``from 5600 rpm up``, ``at every speed``, ``at 4000 and 7000 to 7200 rpm``; empty where one speed was run."""
        hit = tuple(sorted({run.engine_speed for run in runs}))
        if len(self.speeds) < 2 or not hit:
            return ""
        if len(hit) == len(self.speeds):
            return "at every speed"
        if hit == self.speeds[-len(hit) :] and len(hit) > 1:
            return f"from {speed_text(hit[0])} up"
        spans = list[list[float]]()
        for before, speed in zip((math.nan, *self.speeds), self.speeds, strict=False):
            if speed in hit and before in hit:
                spans[-1].append(speed)
            elif speed in hit:
                spans.append([speed])
        if len(spans) > SPANS:
            return f"at {len(hit)} of {len(self.speeds)} speeds from {speed_text(hit[0])} up"
        ends = (dict.fromkeys(speed_text(one, "") for one in (span[0], span[-1])) for span in spans)
        return f"at {joined([' to '.join(one) for one in ends])} rpm"

    @property
    def red_line(self) -> float:
        """The highest engine speed in use (rad/s); infinite where the case states none."""
        return self.study.record.red_line or math.inf

    @property
    def case(self) -> str:
        """What a command takes for this case: the name of its file, or of its library case."""
        from valvetrain.parameters.loading import library_names

        name = self.study.record.name
        return name if name in library_names() else f"{name}.toml"

    @property
    def verb(self) -> str:
        """The command on two springs, whose case no other command takes."""
        return "compare-springs" if self.study.command == "compare-springs" else ""

    @property
    def labels(self) -> str:
        """The labels of the runs that decide, as text."""
        return joined(list(dict.fromkeys(run.label for run in self.runs)))


def trust(run: Solution) -> int:
    """Place of a run's spring model in :data:`TRUST`; 0 for a model that is not in it."""
    return TRUST.index(run.model) if run.model in TRUST else 0


def open_mask(run: Solution) -> Flags:
    """Samples (sample,) of a cycle in which the rigid valve is open by more than a tenth of its lift."""
    name = "rigid_valve_lift" if run.has("rigid_valve_lift") else "valve_lift"
    lift = over_turn(run, name)
    return np.asarray(lift > OPEN_SHARE * lift.max())


def over_turn(run: Solution, name: str) -> Array:
    """A channel (sample, ...) over the reported cam revolution, without labels, which cost time to load."""
    return np.asarray(reported_cycle(run).channel(name))


def rests(event: Event) -> bool:
    """Whether a clash is of coils that come to rest on each other as the spring closes."""
    return event.details.get("cause") == Cause.COILS_REST
