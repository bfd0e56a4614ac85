"""Rules on a valvetrain at given speeds: control of the valve (C), landing (V), lift (L), piston (P)."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

from valvetrain.findings.engine import Fields, Hit, Hits, Rule, above, below, per_run
from valvetrain.findings.facts import LOST, TURN, Facts, open_mask, over_turn
from valvetrain.findings.words import Amount, joined
from valvetrain.quantities.loss_cause import FLIGHT, float_and_losses, leading_loss
from valvetrain.solution.result import Solution
from valvetrain.solution.status import Cause, Event

#: Lift above the path of rigid parts that is float (m).
FLOAT = 50e-6
#: Shares of the cam force of rigid parts, and of the spring force at full lift, below which a cam force is little: the
#: second one of a valve that is lost to inertia, some 2.5 % of engine speed before.
BARELY, SCARCE = 0.2, 0.05
#: Angle (cam rad) about the middle of the nose that is called so without a side.
TOP = math.radians(10)
#: Said of a run that keeps contact by a little force, and of a loss that is no flight.
NEAR, LIMIT = "near its limit", "at its limit"
#: Seating velocity (m/s) to which one hydraulic engine was called smooth, and travel to the piston (m) that is close.
SMOOTH, NEAR_PISTON = 0.52, 1e-3
#: Why contact is lost: cause of an event -> what a verdict says.
CAUSES: dict[str, str] = {
    Cause.INERTIA: "the spring is too weak for the inertia",
    Cause.SURGE: "surge",
    Cause.VIBRATION: "the train flexes and rebounds",
}


def cause(run: Solution, events: Sequence[Event]) -> str:
    """Why contact is lost, by the loss of contact whose cause is that of all."""
    leading = leading_loss(events)
    code = "" if leading is None else str(leading.details.get("cause", ""))
    return cause_text(code, run.quantities.get("surge_amplitude_cam_order", 0.0))


def cause_text(code: str, order: float) -> str:
    """A cause as a verdict says it, surge with its cam order where that is known."""
    return (
        f"surge, cam order {order:.0f}" if code == Cause.SURGE and order else CAUSES.get(code, "")
    )


def loss_of(facts: Facts, run: Solution, events: Sequence[Event]) -> Hit | None:
    """The largest gap of a contact of the drive among ``events``, those at the cam before others."""
    if not events:
        return None
    cam = any(one.where == "cam" for one in events)
    events = [one for one in events if one.where == "cam"] if cam else events
    largest = events[0]
    places = list(dict.fromkeys(one.where.replace("_", " ") for one in events))
    landing = largest.details.get("landing_cam_angle")
    fields: Fields = {
        "gap": Amount("loft_gap", largest.size), "place": joined(places), "limit": LIMIT if largest.size <= FLIGHT else "",
        "angle": Amount("loft_cam_angle", largest.cam_angle % TURN), "cause": cause(run, events),
        "landing": "" if landing is None else Amount("loft_cam_angle", float(landing) % TURN),
        "part": "" if landing is None else lobe_part(facts, run, float(landing)),
    }  # fmt: skip
    lasts = "loft_duration" if cam else "loss_of_contact_duration"
    return Hit(facts.amount(run, lasts), run, 0.0, fields, largest.size)


def lobe_part(facts: Facts, run: Solution, cam_angle: float) -> str:
    """The part of the lobe under rigid parts at a cam angle (rad): a ramp, a flank, the nose or the base circle; of a run
    without them the closing ramp alone. Empty where neither is known.
    """

    def within(begin: str, end: str) -> bool:
        first, last = (facts.value(run, f"{one}_cam_angle") for one in (begin, end))
        return (cam_angle - first) % TURN <= (last - first) % TURN

    if within("closing_ramp_begin", "closing_ramp_end"):
        return "the closing ramp"
    if within("rigid_nose_begin", "rigid_nose_end"):
        begin, end = (facts.value(run, f"rigid_nose_{one}_cam_angle") for one in ("begin", "end"))
        past = (cam_angle - begin) % TURN - (end - begin) % TURN / 2
        side = "closing" if past > 0 else "opening"
        return f"the {side} side of the nose" if abs(past) > TOP else "the nose"
    if within("rigid_valve_lash_opening", "rigid_nose_begin"):
        return "the opening flank"
    if within("rigid_nose_end", "rigid_valve_lash_closing"):
        return "the closing flank"
    return "the base circle" if within("rigid_nose_end", "rigid_nose_begin") else ""


def hardest(facts: Facts, run: Solution) -> str:
    """Where on the cam its largest force acts: part of the lobe, or the blow that it is, and the cam angle (deg)."""
    angle = facts.value(run, "peak_cam_contact_force_cam_angle")
    if not math.isfinite(angle):
        return ""
    part = facts.struck(run) or lobe_part(facts, run, angle)
    part = part.removeprefix("the ").removesuffix(" flank").removesuffix(" of the nose")
    return f"{part} {math.degrees(angle):.0f}".strip()


@per_run
def blow(facts: Facts, run: Solution) -> Hit | None:
    """The largest force on the cam is the blow of a landing or of the lash, which contact constants decide."""
    return Hit(run=run, fields={"place": hardest(facts, run)}) if facts.struck(run) else None


@per_run
def flight(facts: Facts, run: Solution) -> Hit | None:
    """The longest flight off the cam, and whether the motion repeats."""
    losses = facts.losses(run)
    flights = [one for one in losses if one.where == "cam"]
    if not flights:
        return None
    longest = max(flights, key=lambda one: one.duration)
    turns = int(run.statistics.get("motion_period_count", 0))
    repeats = {0: "", 1: "in every cycle"}.get(turns, f"in every {turns} cycles")
    repeats = "not alike from cycle to cycle" if run.status.code == "not-converged" else repeats
    scatter = facts.amount(run, "cycle_scatter_loft_gap")
    landing, lasts = longest.details.get("landing_cam_angle"), longest.duration
    if landing is not None:
        # to where the cam is met again, which may be after the valve of rigid parts has closed
        lasts = (float(landing) - longest.cam_angle) % TURN / (run.engine_speed / 2)
    widest = losses[0]
    fields: Fields = {
        "gap": Amount("loft_gap", widest.size) if widest.where != "cam" else "",
        "place": widest.where.replace("_", " "),
        "repeats": repeats,
        "scatter": "" if repeats or scatter is None else scatter,
        "angle": Amount("loft_cam_angle", longest.cam_angle % TURN),
        "landing": "" if landing is None else Amount("loft_cam_angle", float(landing) % TURN),
    }
    return Hit(Amount("loft_duration", lasts), run, fields=fields)


def landing(facts: Facts, run: Solution) -> Fields:
    """Where and how fast the valve meets its seat, and on which part of a lobe whose ramp is known; empty where no such
    thing was found.
    """
    angle, ramp = (
        facts.amount(run, "seating_cam_angle"),
        facts.value(run, "closing_ramp_begin_cam_angle"),
    )
    velocity = facts.amount(run, "seating_velocity")
    if angle is None or velocity is None:
        return {}
    part = lobe_part(facts, run, angle.value)
    if not part and math.isfinite(ramp):
        before = (ramp - angle.value) % TURN < TURN / 4
        part = f"the {'closing flank' if before else 'base circle'}"
    return {"angle": angle, "velocity": velocity, "part": part}


@per_run
def lands(facts: Facts, run: Solution) -> Hit | None:
    """The part of the lobe on which the valve meets its seat, of a cam whose ramp is known."""
    fields = landing(facts, run)
    if not fields or not math.isfinite(facts.value(run, "closing_ramp_begin_cam_angle")):
        return None
    return Hit(facts.amount(run, "seating_cam_angle"), run, None, fields, run.engine_speed)


bounced = above("bounce_height", "permitted_bounce_height")


def bounces(facts: Facts) -> Hits:
    """The valve bounces off its seat by more than the limit of the case, else 0.1 mm."""
    for hit in bounced(facts):
        yield (
            hit
            if hit.run is None
            else replace(hit, fields={**hit.fields, **landing(facts, hit.run)})
        )


def bounces_most(facts: Facts) -> Hits:
    """It bounces by more than the limit, and by more than any contact of the drive opens."""
    gaps = [one.size for run in facts.runs for one in facts.losses(run)]
    for hit in bounces(facts):
        if hit.amount and hit.amount.value > max(gaps, default=0.0):
            yield hit


@per_run
def floats(facts: Facts, run: Solution) -> Hit | None:
    """The cam is left while the valve is open, and the valve flies above the path of rigid parts by 0.05 mm."""
    largest, around = float_and_losses(run)
    if largest is None or largest.size <= FLOAT or not facts.losses(run):
        return None
    begins = loss_of(facts, run, around)
    fields = {} if begins is None else begins.fields
    causes = {"cause": cause(run, [largest, *around])}
    return Hit(facts.amount(run, "float_excess_lift"), run, FLOAT, {**fields, **causes})


@per_run
def loses(facts: Facts, run: Solution) -> Hit | None:
    """A contact of the drive opens while the valve is open, but the valve follows its path."""
    return loss_of(facts, run, facts.losses(run))


def near_limit(facts: Facts, run: Solution) -> bool:
    """Whether a run leaves less on the cam than a fifth of the force of rigid parts or a twentieth of the spring force at full
    lift. Run and comparison both judge by it.
    """
    left, rigid = facts.value(run, CONTACT[0]), rigid_force(run)
    scarce = left < SCARCE * facts.value(run, "open_spring_force")
    return scarce or (rigid is not None and left < BARELY * rigid.value)


def _kept(facts: Facts, little: bool) -> Hits:
    for amount, run in facts.amounts(CONTACT[0]):
        if not facts.losses(run) and near_limit(facts, run) is little:
            fields: Fields = {
                "angle": facts.least_angle(run, "cam_contact_force") or "", "rigid": rigid_force(run) or "",
            }  # fmt: skip
            yield Hit(amount, run, 0.0, fields, -amount.value)


def rigid_force(run: Solution) -> Amount | None:
    """The least force of rigid parts on the cam while the valve is open; None without channels."""
    if not run.has("rigid_contact_force", "rigid_valve_lift"):
        return None
    force = over_turn(run, "rigid_contact_force")[open_mask(run)]
    return Amount(CONTACT[0], float(force.min()))


def kept(facts: Facts) -> Hits:
    """Runs that keep contact throughout."""
    return _kept(facts, little=False)


def barely(facts: Facts) -> Hits:
    """Runs that keep contact by little force."""
    return _kept(facts, little=True)


@per_run
def near_seat(facts: Facts, run: Solution) -> Hit | None:
    """Contacts that open near the seat alone: no control is lost."""
    every = [one for one in run.events if one.kind in LOST]
    if not every or facts.losses(run):
        return None
    largest = max(every, key=lambda one: one.size)
    return Hit(
        Amount("loft_gap", largest.size), run, fields={"place": largest.where.replace("_", " ")}
    )


@per_run
def flex(facts: Facts, run: Solution) -> Hit | None:
    """Flexing parts take more than 0.05 mm of lift or one crank degree of duration from the valve."""
    lost, shorter = (facts.amount(run, name) for name in FLEX)
    angle = shorter.value if shorter else 0.0
    if lost is None or lost.value <= 0 or not (lost.value > FLOAT or angle > math.radians(1)):
        return None
    return Hit(lost, run)


def needs(facts: Facts) -> Hits:
    """What seat load and open load, or which rate, gives the inertia force plus 20 % at the highest speed that decides."""
    for run in facts.runs[-1:]:
        names = {
            "closed": NEEDED[0],
            "open": NEEDED[1],
            "rate": NEEDED[2],
            "have": "preload",
            "full": "open_spring_force",
        }
        fields = {word: one for word, name in names.items() if (one := facts.amount(run, name))}
        if len(fields) == len(names):
            if (
                fields["closed"].value <= fields["have"].value
                and fields["open"].value <= fields["full"].value
            ):
                del fields["rate"]  # nothing more is needed
            yield Hit(fields["closed"], run, fields=fields)


CONTACT = ("minimum_cam_contact_force", "loss_of_contact_duration", "loft_gap")
SEAT = ("seating_velocity",)
FLEX = ("lift_loss_displacement", "valve_50_thou_lost_crank_angle_range")
PISTON = ("minimum_piston_clearance_gap",)
NEEDED = ("needed_closed_spring_force", "needed_open_spring_force", "needed_spring_rate")
SWEEP = "valvetrain sweep {case}"
LASH = "[valvetrain new {stem}-lash --kind lash --case {file} && valvetrain study {stem}-lash.toml]"
AGAIN = "[, {repeats}][, height within {scatter:2} from cycle to cycle]"

RULES = (
    Rule("P101", "decides", "the valve meets the piston[ {at}]", below(PISTON[0], 1e-9), PISTON,
         step="check timing and depth of the table 'piston'"),
    Rule("C101", "decides", "the valve floats: {value} above its path[ {at}]", floats,
         (*CONTACT, "float_excess_lift"), "[{cause}]", SWEEP, "[left at {angle}][, met again at {landing}][ on {part}]",
         "how-to/09-loft.md", unless=("U", "W10", "D10")),
    Rule("C105", "decides", "the valve bounces {value} off its seat[ {at}]", bounces_most, ("bounce_height",),
         "[it lands at {velocity}][ on {part}]", SWEEP, "bounces", "how-to/10-seating.md", unless=("U", "W10", "D10", "M1", "C101")),
    Rule("C102", "decides", "[{limit}: ]contact is lost at the {place}[, {gap} open][ for {value}][ {at}]", loses, CONTACT,
         "[{cause}]", SWEEP, "[opens at {angle}][, meets at {landing}][ on {part}]", "how-to/09-loft.md", unless=("U", "W10", "D10", "C101")),
    Rule("C103", "decides", f"{NEAR}: {{value}} left on the cam[ at {{angle}}][ {{at}}]", barely, CONTACT,
         "[rigid parts would leave {rigid}]", SWEEP, "[rigid parts {rigid}]", "how-to/09-loft.md", "warn", ("U", "W10", "D10", "M10", "C10")),
    Rule("C104", "decides", "in control: {value} left on the cam[ at {angle}][ {at}]", kept, CONTACT,
         "[rigid parts would leave {rigid}]", SWEEP, mark="ok", unless=("U", "W10", "D10", "M10", "C10")),
    Rule("C110", "warns", "the valve bounces {value} off its seat[ {at}]", bounces, ("bounce_height",),
         remark="bounces", guide="how-to/10-seating.md", unless=("C105",)),
    Rule("C111", "warns", "a contact opens by {value}[ {at}], above your limit of {limit}", above("loft_gap", "permitted_loft_gap"),
         ("loft_gap",), remark="above {limit}", guide="how-to/09-loft.md"),
    Rule("P102", "warns", "{value} left to the piston[ {at}]", below(PISTON[0], NEAR_PISTON), PISTON, remark="close",
         unless=("P101",)),
    Rule("V101", "warns", "the valve lands at {value}[ {at}], above your limit of {limit}",
         above("seating_velocity", "permitted_seating_velocity"), SEAT, remark="above {limit}",
         guide="how-to/10-seating.md"),
    Rule("C122", "notes", f"the longest flight lasts {{value}}[, from {{angle}}][ to {{landing}}][ {{at}}]{AGAIN}", flight, ("loft_gap",),
         remark=f"longest {{value}}[, {{angle..landing}}][, {{gap}} at the {{place}}]{AGAIN}", guide="how-to/09-loft.md"),
    Rule("C123", "notes", "the largest force on the cam is a blow ({place} cam deg), whose height contact constants decide", blow,
         ("peak_cam_contact_force_cam_angle",), remark="by contact constants", guide="uncertainty.md"),
    Rule("V103", "notes", "the valve meets its seat at {value}[ {at}], on {part}", lands, SEAT, remark="at {value}[ {at}], {part}", step=LASH,
         guide="how-to/10-seating.md"),
    Rule("L101", "notes", "flex takes {value} of lift[ {at}]", flex, FLEX,
         step="stiffer pushrod or rocker: valvetrain study --parts {case}", guide="how-to/08-flex.md"),
    Rule("V102", "notes", "the valve lands at {value}[ {at}]; one hydraulic engine was called smooth to {limit}",
         above("seating_velocity", SMOOTH), SEAT, step="set permitted_seating_velocity for a limit of your own",
         guide="limits.md", unless=("V101",)),
    Rule("C121", "notes", "inertia plus 20 % needs {closed} on the seat and {open} at full lift[ {at}]; you have {have} and {full}",
         needs, NEEDED, "[or {rate} at your seat load]", remark="[or {rate} from your seat load]",
         guide="how-to/01-spring-loads.md"),
    Rule("C120", "notes", "a contact opens by {value} at the {place} near the seat, which loses no control", near_seat,
         ("loss_of_contact_duration",), guide="how-to/09-loft.md", unless=("C101", "C102", "U101")),
)  # fmt: skip
