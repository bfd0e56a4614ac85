"""Rules on measured lifts (L201 and up): whether their stations are good enough to simulate with, and what they give."""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial

import numpy as np

from valvetrain.findings.engine import Fields, Hit, Hits, Rule, Subject
from valvetrain.findings.words import Amount, Said, percent
from valvetrain.lift.band import CarriedSpread, LiftBandStudy
from valvetrain.lift.figures import COARSE, LiftFigure, LobeResult, overshoot
from valvetrain.measured.lift_smoothing import BAND
from valvetrain.solution.definition import label_of

#: Share of the acceleration from which its 95 % interval is a doubt, and share of its peak by which a column may differ.
LOOSE, AGREES = 0.2, 0.05
#: Largest acceleration of a lobe next to its lift over the square of half its width.
STEEP = 20.0
#: Peaks (m) of the lifts of engines, from model engines to large diesels; distance of two stations, next to the larger of
#: those beside it, that is a gap.
USUAL, GAP = (1.5e-3, 60e-3), 3.0
#: Question of a table -> what is assumed where it gives no answer.
ASSUMED = {
    "angle_unit": "angles in degrees", "zero": "zero of the angle as in the file", "direction": "a cam that turns with rising angle"
}  # fmt: skip
#: What a case with the lift is about, the first that it has.
IN_CASE = (
    "float_engine_speed", "minimum_open_cam_contact_force", "peak_cam_contact_force", "peak_spring_force"
)  # fmt: skip


@dataclass(frozen=True)
class LiftFacts(Subject):
    """Measured lifts as rules read them.

    Parameters
    ----------
    lobes : one, or intake and exhaust
    pair : what both lobes have together
    timing : events against dead centre, where they are known
    carried : a case with the first lobe, and what the noise does to it
    file : the law of the first lobe as part of a case file; of a case the whole of it
    onward : words behind ``valvetrain`` that go on with the lift; empty in a program
    """

    lobes: tuple[LobeResult, ...] = ()
    pair: tuple[LiftFigure, ...] = ()
    timing: tuple[LiftFigure, ...] = ()
    carried: LiftBandStudy | None = None
    file: str = ""
    onward: str = ""

    @property
    def case(self) -> str:
        """What a command takes for the case that has the lift."""
        return self.file

    @property
    def failures(self) -> tuple[str, ...]:
        """Sentences on runs of the case that failed."""
        study = self.carried
        return () if study is None else (*study.mean.failures, *study.failures)

    @property
    def worst(self) -> list[CarriedSpread]:
        """Of each quantity of :data:`IN_CASE` that the case has, its worst run."""
        rows = self.carried.spreads if self.carried is not None else ()
        runs = [[one for one in rows if one.quantity == name and one.value > 0] for name in IN_CASE]
        return [
            sorted(one, key=lambda run: run.value)[-one[0].quantity.startswith("peak")]
            for one in runs
            if one
        ]


def looseness(lobe: LobeResult) -> float:
    """The 95 % interval of the acceleration as a share of it: on the flanks or over the nose, the larger."""
    peaks = [one for one in lobe.figures if one.name.endswith("acceleration")]
    return max(BAND * one.spread / abs(one.value) for one in peaks)


def failed(facts: LiftFacts) -> Hits:
    """A run of the case with this lift failed."""
    for said in facts.failures[:1]:
        yield Hit(fields={"said": said})


def off(facts: LiftFacts) -> Hits:
    """A station is more than four standard deviations off the law."""
    for lobe in facts.lobes:
        if lobe.off.size:
            left = np.abs(lobe.smoothed.residuals)
            worst, count = int(np.argmax(left)), f"{lobe.off.size} of {left.size} stations"
            angle = Amount("station_cam_angle", float(lobe.smoothed.cam_angles[worst]))
            yield Hit(
                Amount("station_lift", float(left[worst])),
                fields={"count": count, "lobe": lobe.measured.name, "angle": angle},
            )


def misfit(facts: LiftFacts) -> Hits:
    """A column of velocity or acceleration is not the derivative of the lift."""
    for lobe in facts.lobes:
        for column, apart in lobe.measured.misfits.items():
            if apart > AGREES:
                yield Hit(fields={"column": column})


def loose(facts: LiftFacts, coarse: bool) -> Hits:
    """Noise, or stations that are ``coarse``, leave more than a fifth of the acceleration open."""
    for lobe in facts.lobes:
        spacing = float(np.median(np.diff(lobe.smoothed.cam_angles)))
        share = looseness(lobe)
        if share > LOOSE and (spacing > COARSE) == coarse:
            # what stations leave open between them goes with the square root of their spacing
            finer = np.radians(
                max(0.5, np.floor(2 * np.degrees(spacing) * (LOOSE / share) ** 2) / 2)
            )
            yield Hit(
                Amount("station_noise_lift", lobe.smoothed.noise),
                fields={
                    "share": percent(share), "lobe": lobe.measured.name, "spacing": Amount("station_cam_angle", spacing),
                    "finer": Amount("station_cam_angle", float(finer))
                }
            )  # fmt: skip


def dusty(facts: LiftFacts, mended: bool) -> Hits:
    """Stations stand out of a smooth lift on one side, or were taken out (``mended``)."""
    for table in (lobe.measured for lobe in facts.lobes):
        if table.dust and table.mended == mended:
            worst = max(table.dust, key=lambda bump: bump.height)
            angle = Amount("station_cam_angle", (worst.first + worst.last) / 2)
            fields: dict[str, Said] = {
                "count": str(len(table.dust)), "lobe": table.name, "angle": angle
            }  # fmt: skip
            yield Hit(Amount("station_lift", worst.height), fields=fields)


def steep(facts: LiftFacts) -> Hits:
    """The acceleration is many times what a lobe of that lift and width has."""
    for lobe in facts.lobes:
        law, figures = lobe.smoothed, lobe.values
        grid = np.linspace(*law.event, 1001)
        high = grid[law.lift(grid) > 0.01 * figures["peak_lift"]]
        usual = figures["peak_lift"] / (float(np.ptp(high)) / 2) ** 2
        worst = max(figures["largest_acceleration"], -figures["nose_acceleration"])
        if worst > STEEP * usual:
            yield Hit(
                fields={"lobe": lobe.measured.name, "times": f"{worst / usual:.0f}"}, severity=worst
            )


def unusual(facts: LiftFacts) -> Hits:
    """The peak of a lift is none of an engine's, as where its unit is another."""
    for lobe in facts.lobes:
        peak = lobe.values["peak_lift"]
        if not USUAL[0] <= peak <= USUAL[1]:
            yield Hit(Amount("peak_lift", peak), fields={"lobe": lobe.measured.name})


def gaps(facts: LiftFacts) -> Hits:
    """Stations are missing within the lobe, beyond those that were taken out."""
    for lobe in facts.lobes:
        angles = lobe.smoothed.cam_angles
        apart = np.diff(angles)
        beside = np.maximum(apart[:-2], apart[2:])
        wide = np.flatnonzero(apart[1:-1] > GAP * beside) + 1
        if wide.size and not lobe.measured.mended:
            worst = int(wide[np.argmax(apart[wide])])
            angle = Amount("station_cam_angle", float(angles[worst : worst + 2].mean()))
            width = Amount("station_cam_angle", float(apart[worst]))
            yield Hit(width, fields={"lobe": lobe.measured.name, "angle": angle})


def jumps(facts: LiftFacts) -> Hits:
    """The acceleration jumps, and a smooth lift through the stations overshoots there."""
    for lobe in facts.lobes:
        for place, beyond in (overshoot(lobe.smoothed, sign) for sign in (1, -1)):
            if beyond:
                angle = Amount("station_cam_angle", place)
                fields: dict[str, Said] = {"lobe": lobe.measured.name, "angle": angle}
                yield Hit(fields=fields | {"onward": facts.onward}, severity=beyond)


def undercut(facts: LiftFacts) -> Hits:
    """The follower undercuts the cam, or a flat face would need a hollow."""
    for lobe in facts.lobes:
        if lobe.contour is not None and lobe.contour.undercut:
            figures = lobe.values
            place = int(np.argmin(lobe.contour.curvature_radii))
            angle = Amount(
                "station_cam_angle", float(lobe.contour.polar_angles[place] % (2 * np.pi))
            )
            fields: dict[str, Said] = {"lobe": lobe.measured.name, "angle": angle}
            if "largest_roller" in figures:
                fields["largest"] = Amount("lift", figures["largest_roller"])
            yield Hit(Amount("lift", figures["base_radius"]), fields=fields)


def carried(facts: LiftFacts) -> Hits:
    """A case has the lift, and its float speed or a force is known."""
    for one in facts.worst[:1]:
        noise = BAND * one.spread
        fields: Fields = {"name": label_of(one.quantity), "spread": Amount(one.quantity, noise)}
        yield Hit(Amount(one.quantity, one.value, noise), fields=fields)


def good(facts: LiftFacts) -> Hits:
    """The stations determine the lift, or both lifts."""
    for lobe in facts.lobes[:1]:
        durations = [one for one in lobe.figures if one.name.startswith(("peak", "duration"))]
        first, *more = (facts.pair or durations)[:2]
        share = percent(max(map(looseness, facts.lobes)))
        fields: dict[str, Said] = {"first": first.label, "share": share, "onward": facts.onward}
        fields |= {"second": more[0].label, "more": more[0].amount} if more else {}
        yield Hit(first.amount, fields=fields)


def timed(facts: LiftFacts) -> Hits:
    """The events of a cam were typed in, without a lift."""
    if not facts.lobes and facts.carried is None:
        both = [one for one in facts.timing if one.name.startswith(("lobe_sep", "overlap"))]
        first, second = (both or [one for one in facts.timing if one.name.startswith("event_")])[:2]
        intake = [one.value for one in facts.timing if one.name.endswith("_intake")]
        flags = zip(("--duration", "--lobe-centre"), np.degrees(intake), strict=False)
        fields: dict[str, Said] = {"first": first.label, "second": second.label, "more": second.amount}  # fmt: skip
        fields["intake"] = " ".join(f"{flag} '{angle:.5g} deg'" for flag, angle in flags)
        yield Hit(first.amount, fields=fields)


def widened(facts: LiftFacts) -> Hits:
    """The requested band is tighter than the noise."""
    if any(lobe.smoothed.widened for lobe in facts.lobes):
        yield Hit()


def base(facts: LiftFacts) -> Hits:
    """The base circle of the table was not at zero, or it scatters."""
    for law in (lobe.smoothed for lobe in facts.lobes):
        if law.base or law.runout:
            scatter = Amount("station_lift", law.runout)
            yield Hit(Amount("station_lift", law.base), fields={"scatter": scatter})


def unused(facts: LiftFacts) -> Hits:
    """The table holds columns besides angle and lift."""
    for table in (lobe.measured for lobe in facts.lobes):
        fits = [f"{name} fits within {percent(apart)}" for name, apart in table.misfits.items()]
        if said := [*fits, *table.notes]:
            yield Hit(fields={"said": said})


def changed(facts: LiftFacts) -> Hits:
    """The table was turned to make a lift of it."""
    for table in (lobe.measured for lobe in facts.lobes[:1]):
        if table.changes:
            yield Hit(fields={"said": list(table.changes)})


def events(facts: LiftFacts) -> Hits:
    """The table holds more than one lift."""
    names = [lobe.measured.name for lobe in facts.lobes]
    if any("-" in name for name in names):
        yield Hit(fields={"names": names})


def assumed(facts: LiftFacts) -> Hits:
    """The table leaves something open that was assumed."""
    for table in (lobe.measured for lobe in facts.lobes[:1]):
        if said := [ASSUMED[one.question] for one in table.answers if one.by == "assumed"]:
            yield Hit(fields={"said": said})


RULES = (
    Rule("L201", "decides", "the case did not run with this lift: {said}", failed),
    Rule("L205", "decides", "{count} bumps in the {lobe} are no lift", partial(dusty, mended=False), ("station_lift",),
         "the highest at {angle:4}, by {value:2}",
         "clean the probe and measure again, or repeat this command with --mend", "bumps, the highest at {angle:4}",
         "measured-lifts.md", "warn"),
    Rule("L213", "decides", "the {lobe} lifts {value:3} at most, as no engine does", unusual, ("peak_lift",), "the unit of the lifts may be another",
         "correct the heading, or repeat this command with --lift-unit", mark="warn"),
    Rule("L214", "decides", "no station of the {lobe} for {value:3}, near {angle:4}", gaps, ("station_cam_angle",),
         "what the lift does there is a guess", "measure there too, then repeat this command", mark="warn", unless=("L205",)),
    Rule("L202", "decides", "a smooth {lobe} misses {count}", off, ("station_lift",), "most at {angle:4}, by {value}",
         "correct these stations in the table, then repeat this command", "most at {angle:4}", "measured-lifts.md", "warn", ("L205",)),
    Rule("L203", "decides", "the column of {column} is not the derivative of the lift", misfit, (),
         "the unit, the zero or the direction may be wrong", "correct the table or --columns, then repeat this command", mark="warn"),
    Rule("L208", "decides", "the acceleration of the {lobe} jumps, so its largest value is not resolved", jumps, (),
         "it jumps near {angle:4}, as on a cam made of arcs", "[valvetrain {onward}]", mark="warn", unless=("L205",)),
    Rule("L204", "decides", "too much noise in the {lobe}: {share} of the acceleration is open", partial(loose, coarse=False),
         ("station_noise_lift",),
         "{value:2} of noise with stations {spacing} apart", "measure again: average several turns, or reduce the noise of the probe",
         "{share} of the acceleration is open", "measured-lifts.md", "warn", ("L205", "L208")),
    Rule("L206", "decides", "the stations of the {lobe} are too far apart: {share} of the acceleration is open", partial(loose, coarse=True),
         ("station_noise_lift",), "they are {spacing} apart", "measure again with stations {finer} apart or closer",
         "{share} of the acceleration is open", "measured-lifts.md", "warn", ("L205", "L208")),
    Rule("L207", "decides", "no lobe accelerates as the {lobe} does: {times} times lift over the square of half its width", steep, (),
         "stations that are off make such accelerations", "correct the table, then repeat this command", mark="warn", unless=("L205",)),
    Rule("L209", "decides", "this follower undercuts the cam of the {lobe} on a base circle of {value}", undercut, (),
         "it does so near {angle:4} of the contour[; a roller may have up to {largest:3}]",
         "enlarge the base circle, or take a smaller roller", mark="warn", unless=("L205",)),
    Rule("L210", "decides", "{name} is {value:4} in the case", carried, IN_CASE, "[the noise of the lift moves it by ± {spread:2}]",
         "[valvetrain run {case}]", mark=""),
    Rule("L211", "decides", "good enough to simulate, {first} {value:4}[, {second} {more:3}]", good, (),
         "its acceleration is known within {share}", "[valvetrain {onward}]",
         mark="ok", unless=("L20", "L210", "L213", "L214")),
    Rule("L212", "decides", "{first} {value:4}, {second} {more:4}", timed, (), "of the events as they were typed in",
         "[valvetrain new my-engine --kind pushrod {intake}]", mark="ok"),
    Rule("L220", "warns", "the requested band is tighter than the noise", widened, (),
         "the lift follows the stations more closely than they deserve"),
    Rule("L230", "notes", "the base circle was at {value:2} and is now zero[; it scatters by {scatter:2}]", base),
    Rule("L231", "notes", "columns that are not used: {said}", unused, unless=("L203",)),
    Rule("L232", "notes", "assumed: {said}", assumed, remark="{said}"),
    Rule("L233", "notes", "as read: {said}", changed),
    Rule("L234", "notes", "{count} bumps were taken out of the {lobe}", partial(dusty, mended=True), (), "the highest at {angle:4}, by {value:2}"),
    Rule("L235", "notes", "the table holds {names}, one event each", events, (), "--lobe chooses one of them")
)  # fmt: skip
