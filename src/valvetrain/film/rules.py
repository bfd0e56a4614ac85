"""Rules on the film of a spring (Y201 to Y233): what is doubtful in it, how far a model is from it, and what moves."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import partial

import numpy as np

from valvetrain.film.cycles import TURN
from valvetrain.film.model import FilmedModel
from valvetrain.film.result import CoilMotion
from valvetrain.film.surge import BAND, SurgeLine
from valvetrain.findings.engine import Hit, Hits, Rule, Subject
from valvetrain.findings.words import Amount, digits_text

#: Share of the frames from which a coil counts as lost, and frames per cycle of the surge that are too few.
LOST, FEW = 0.1, 2.5
#: Share of the largest peak from which a coil counts as moving, and of its own peak up to which a model follows it.
MOVING, FOLLOWS = 0.05, 0.1
#: Shares and standard deviations within which a given speed and a measured one agree.
SHARE, AGREES = 1e-3, 3.0


@dataclass(frozen=True)
class FilmFacts(Subject):
    """A film as rules read it, with the run that is compared with it where there is one; ``folder`` of its files."""

    motion: CoilMotion
    model: FilmedModel | None = None
    folder: str = "."

    @property
    def case(self) -> str:
        """The case of the compared run."""
        return "" if self.model is None else self.model.case

    @property
    def lines(self) -> tuple[SurgeLine, ...]:
        """Surge lines of the film by frequency."""
        return () if self.motion.surge is None else self.motion.surge.lines


def shared_errors(facts: FilmFacts) -> str:
    """Measuring error that all turns of a film share, as compare-test takes it: an offset by the place of a coil and by
    surge lines of which frames are too few, the scale, and the shift of a zero that the lift alone gives.
    """
    motion, model = facts.motion, facts.model
    place = float(np.nanmedian(motion.spread)) * motion.metres_per_pixel
    lost = (
        line.amplitude
        for line in facts.lines
        if line.natural_frequency * FEW > motion.seen.frame_rate
    )
    amounts = {
        "mm": 1e3 * math.hypot(place, *lost), "%": 100 * motion.scale_spread / motion.metres_per_pixel,
        "deg": math.degrees(abs(model.shift)) if model else 0.0,
    }  # fmt: skip
    return ", ".join(f"{value:.2g} {unit}" for unit, value in amounts.items() if value > 0)


def displacement(value: float, bar: float = 0.0) -> Amount:
    """A displacement (m) of a coil, in the units that a lift is read in."""
    return Amount("maximum_lift", value, bar)


def frequency(line: SurgeLine | None) -> Amount | str:
    """Frequency of a surge line with its interval of 95 %; empty of none."""
    return "" if line is None else Amount("surge_frequency", line.natural_frequency, BAND * line.frequency_spread)  # fmt: skip


def ratio(line: SurgeLine | None) -> str:
    """Damping ratio of a surge line, with the digits of its interval; empty of none."""
    return "" if line is None else digits_text(line.damping_ratio, BAND * line.damping_spread, 4)


def nearest(model: FilmedModel | None, line: SurgeLine | None) -> SurgeLine | None:
    """The surge line of a run that is nearest to one of the film; None where none is within a tenth."""
    lines = () if model is None or model.surge is None or line is None else model.surge.lines
    away = {
        abs(other.natural_frequency / line.natural_frequency - 1): other for other in lines if line
    }
    return away[min(away)] if away and min(away) < 0.1 else None


def rpm(cam_speed: float) -> str:
    """A cam speed (rad/s) as text."""
    return f"{digits_text(cam_speed * 60 / TURN, 0, 5)} rpm"


def lost(facts: FilmFacts) -> Hits:
    """A coil is not followed in a tenth of the frames or more."""
    for coil, share in enumerate(np.mean(np.isnan(facts.motion.places), axis=0), 1):
        if share > LOST:
            yield Hit(fields={"coil": f"{coil}", "share": f"{100 * share:.0f} %"}, severity=share)


def mirrored(facts: FilmFacts, strongest: bool) -> Hits:
    """Fewer than 2.5 frames show a cycle of the ``strongest`` surge line, or of another."""
    rate, largest = facts.motion.seen.frame_rate, max((line.amplitude for line in facts.lines), default=0.0)  # fmt: skip
    for line in facts.lines:
        if line.natural_frequency * FEW > rate and (line.amplitude == largest) is strongest:
            other = Amount("surge_frequency", rate - line.natural_frequency)
            yield Hit(Amount("surge_frequency", line.natural_frequency), fields={"other": other})


def apart(facts: FilmFacts) -> Hits:
    """How far the compared run is from each moving coil (root mean square over the turn), in shares of its peak."""
    model, first = facts.model, facts.lines[0] if facts.lines else None
    if model is not None:
        for coil in np.flatnonzero(model.peaks > MOVING * model.peaks.max()):
            yield Hit(displacement(model.apart[coil]), fields={
                "coil": f"{coil + 1}", "peak": displacement(model.peaks[coil]), "model": model.model, "filmed": frequency(first),
                "modelled": frequency(nearest(model, first)), "file": f"{facts.folder}/displacement-coil-{coil + 1}.csv",
                "shared": shared_errors(facts)
            }, severity=float(model.apart[coil] / model.peaks[coil]))  # fmt: skip


def far(facts: FilmFacts) -> Hits:
    """A compared run is further from a moving coil than a tenth of its peak (root mean square over the turn)."""
    return (hit for hit in apart(facts) if hit.severity > FOLLOWS)


def moves(facts: FilmFacts) -> Hits:
    """The film of a turning cam: the coil with the largest peak."""
    motion, first = facts.motion, facts.lines[0] if facts.lines else None
    for top in motion.peaks:
        yield Hit(displacement(top.mean, BAND * top.spread), fields={
            "coil": f"{top.coil}", "count": f"{motion.coils}", "speed": rpm(motion.cycles[0].cam_speed), "surge": frequency(first),
            "ratio": ratio(first)
        })  # fmt: skip


def rings(facts: FilmFacts) -> Hits:
    """The film of a free decay: its lowest surge line."""
    for line in facts.lines[:1] if facts.motion.phase is None else ():
        yield Hit(Amount("surge_frequency", line.natural_frequency, BAND * line.frequency_spread), fields={"ratio": ratio(line)})  # fmt: skip


def no_surge(facts: FilmFacts) -> Hits:
    """No surge line is found with the valve closed or in the decay."""
    if not facts.lines:
        yield Hit()


def disagrees(facts: FilmFacts) -> Hits:
    """The speed that was given is not the one that marker or lift show."""
    phase = facts.motion.phase
    if phase is not None and phase.given_speed:
        off = abs(phase.given_speed - phase.cam_speed)
        if off > max(AGREES * phase.spread, SHARE * phase.cam_speed):
            yield Hit(fields={"by": phase.by, "speed": rpm(phase.cam_speed), "given": rpm(phase.given_speed)})  # fmt: skip


def few_turns(facts: FilmFacts) -> Hits:
    """The film shows fewer than two cam revolutions."""
    phase = facts.motion.phase
    turns = math.inf if phase is None else float(np.ptp(phase.cam_angle)) / TURN
    if turns < 2:
        unseen = "a peak outside them is not seen" if turns < 1 else ""
        yield Hit(fields={"turns": digits_text(turns, 0, 3), "unseen": unseen})


def no_zero(facts: FilmFacts) -> Hits:
    """Nothing tells where the cam angle is zero."""
    if facts.motion.phase is not None and facts.motion.phase.zero_by == "nobody":
        yield Hit()


def cut(facts: FilmFacts) -> Hits:
    """The file claims more frames than it holds."""
    seen = facts.motion.seen
    if seen.missing:
        read = len(seen.picture)
        yield Hit(fields={"read": f"{read}", "claimed": f"{read + seen.missing}"})


AGAINST = "valvetrain compare-test {case} --test {file} --model {model}[ --shared '{shared}']"
RULES = (
    Rule("Y201", "decides", "coil {coil} is lost in {share} of the frames", lost, (), "its highlight leaves the line or runs into another",
         "set --line and --coils, or light one glare line on each coil", mark="warn", guide="film.md"),
    Rule("Y202", "decides", "too few frames: the surge line at {value:4} may be one of {other:4}", partial(mirrored, strongest=True), (),
         "fewer than 2.5 frames show a cycle of it", "film at a higher frame rate", mark="warn", guide="film.md"),
    Rule("Y221", "decides", "the model does not follow the film: coil {coil} is off by {value:2} of {peak:3}", far, (),
         "[surge at {modelled:4}, filmed at {filmed:4}]", AGAINST, mark="warn"),
    Rule("Y222", "decides", "the model follows the film: coil {coil} is furthest off, {value:2} of {peak:3}", apart, (),
         "[surge at {modelled:4}, filmed at {filmed:4}]", AGAINST, mark="ok", unless=("Y221",)),
    Rule("Y231", "decides", "coil {coil} of {count} moves most, {value:4}, at {speed} of the cam", moves, (),
         "[surge at {surge:4}, damping ratio {ratio}]", "add `--case CASE` to lay a model over the film", mark="ok", unless=("Y22",)),
    Rule("Y232", "decides", "surge at {value:5}, damping ratio {ratio}", rings, (), "",
         "valvetrain run job-t --set springs.0.damping.ratio={ratio} --set 'springs.0.damping.ratio_frequency={value:5}'", mark="ok"),
    Rule("Y233", "decides", "no surge is found in the decay or with the valve closed", no_surge, (), "too few frames, or nothing rings",
         "film longer", mark="warn"),
    Rule("Y210", "warns", "the film is cut short: {read} of {claimed} frames could be read", cut, (),
         "what follows is of these frames alone", "export or copy the film again"),
    Rule("Y211", "warns", "the {by} shows {speed} of the cam, {given} was given: check the frame rate", disagrees),
    Rule("Y212", "warns", "the film shows {turns} cam revolutions, so peaks have no scatter[; {unseen}]", few_turns),
    Rule("Y214", "warns", "the weaker surge line at {value:4} may be one of {other:4}: too few frames show a cycle of it",
         partial(mirrored, strongest=False)),
    Rule("Y213", "warns", "the zero of the cam angle is not known: give --marker-angle, --first-angle or a lift", no_zero)
)  # fmt: skip
