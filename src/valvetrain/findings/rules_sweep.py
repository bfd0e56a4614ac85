"""Rules over engine speed: up to where a train is controlled (W), and which of two springs keeps control longer (D)."""

from __future__ import annotations

import math

from valvetrain.findings.control import Loss
from valvetrain.findings.engine import Condition, Fields, Hit, Hits, Rule
from valvetrain.findings.facts import Facts
from valvetrain.findings.rules_spring import KNOWS_COILS
from valvetrain.findings.rules_train import CONTACT, cause, cause_text, landing, loss_of
from valvetrain.findings.words import RPM, Amount, Phrase, Said, about, joined, speed_text
from valvetrain.solution.critical import CriticalSpeed, SpeedBracket, places_text
from valvetrain.solution.result import Solution
from valvetrain.springs.spec import spring_model

#: Kind of critical speed -> what the valve does from there.
DOES = {"contact-loss": "loses the {place}", "float": "floats", "bounce": "bounces"}
#: Kind of critical speed -> the quantity that says how large the loss is.
SIZES = {"contact-loss": "loft_gap", "float": "float_excess_lift", "bounce": "bounce_height"}
#: Cause of the end of a range -> what is said of it.
ENDS = {"force": "a tenth of the force", "ends": "ends that would pull", "revolution": "scatter"}
SPEED = "contact_loss_engine_speed"
#: Share of a critical speed from which its range is named, and within which two springs are alike; share of a stress
#: amplitude from which one breaks first.
WIDE, ALIKE, WEAKER = 0.004, 0.01, 1.05
#: Stresses of springs -> shares of the least and the largest force that make them without a wire.
AMPLITUDE, STRESS = "largest_amplitude_shear_stress", "peak_shear_stress"
SHARES = {AMPLITUDE: (-0.5, 0.5), STRESS: (0.0, 1.0), "minimum_shear_stress": (1.0, 0.0)}
#: Forces over a cycle, and stress and force at full lift by which a stress follows from them.
RANGE_OF = (
    "minimum_spring_force",
    "peak_spring_force",
    "open_nominal_shear_stress",
    "open_spring_force",
)
SURGE = "surge_amplitude_force"


def does(row: CriticalSpeed) -> Phrase:
    """What the valve does from a critical speed."""
    place = "cam" if "cam" in row.places or not row.places else places_text(*row.places)
    return Phrase(DOES[row.kind], {"place": place})


def why(facts: Facts, loss: Loss) -> Said:
    """Why control is lost: by the search where it looked at that onset, else by the first run within; of a bounce how the
    valve lands in that run.
    """
    row = loss.row
    if row.cause and loss.at_onset:
        return cause_text(row.cause, row.surge_order)
    within = _within(facts, loss)
    if row.kind == "bounce":
        lands = ((landing(facts, run), speed_text(run.engine_speed)) for run in within)
        fields: Fields = next(({**told, "there": at} for told, at in lands if told), {})
        return Phrase("it lands at {velocity}[ on {part}] at {there}", fields) if fields else ""
    return next((cause(run, lost) for run in within if (lost := facts.losses(run))), "")


def _within(facts: Facts, loss: Loss) -> list[Solution]:
    """The runs of a label at speeds at which control is lost, the slowest first."""
    ends = [(one.lower_engine_speed, one.upper_engine_speed) for one in loss.ranges]
    runs = sorted((*facts.runs, *facts.beyond), key=lambda run: run.engine_speed)
    return [
        run
        for run in runs
        if run.label == loss.row.label and any(low <= run.engine_speed <= up for low, up in ends)
    ]


def range_of(row: CriticalSpeed) -> tuple[Fields, float]:
    """A range that is worth a word, with its causes, and its half width (rad/s); empty and 0 of a narrow one."""
    span = row.span
    if span is None or not row.causes:
        return {}, 0.0
    low, high = span.lower_engine_speed, span.upper_engine_speed
    if high - low <= WIDE * row.deciding_speed:
        return {}, 0.0
    width = high - low if math.isfinite(high) and low > 0 else 0.0
    begin = f"below {speed_text(row.first_engine_speed, '')}" if low <= 0 else about(low)
    end = about(high) if math.isfinite(high) else f"above {speed_text(row.last_engine_speed, '')}"
    models = [
        one.change
        for one in row.members
        if one.cause == "model" and one.engine_speed in (low, high)
    ]
    named = ENDS | {"model": ", ".join(models)}
    return {
        "range": f"{begin} to {end}",
        "over": ", ".join(named.get(one, one) for one in row.causes),
    }, width / 2


def rounded(row: CriticalSpeed, engine_speed: float, half: float) -> str:
    """A critical speed (rad/s) in rpm with no more digits than ``half`` its range (rad/s) supports, but off by no more than
    a tenth of that and never outside of the range.
    """
    speed, span = engine_speed / RPM, row.span
    for text in (about(engine_speed, half), about(engine_speed)):
        off = abs(float(text) - speed)
        if not half or span is None:
            return text
        low, high = math.floor(span.lower_engine_speed / RPM), span.upper_engine_speed / RPM
        if low <= float(text) <= high + 1 and off <= half / RPM / 10:
            return text
    return f"{speed:.0f}"


def _first(facts: Facts) -> Loss | None:
    """The loss that decides: the first one of the label that loses control first."""
    if not (facts.searched and facts.train):
        return None
    control = facts.control(facts.first_label)
    return next((one for one in control.losses if one.begin <= control.limit), None)


def _lost(facts: Facts, beyond: bool) -> Hits:
    loss = _first(facts)
    if loss is None or loss.begin <= 0 or (loss.begin >= facts.red_line) is not beyond:
        return
    row = loss.row
    spread, half = range_of(row)
    margin = abs(facts.red_line - loss.begin)
    angle = row.cam_angle if loss.at_onset else math.nan
    both = row.both_motions
    yield Hit(Amount(SPEED, loss.begin, half), None, facts.red_line if math.isfinite(margin) else None, {
        "does": does(row), "speed": f"about {rounded(row, loss.begin, half)} rpm", "cause": why(facts, loss),
        "short": f"{about(margin, half)} rpm" if math.isfinite(margin) else "", "round": rounded(row, loss.begin, half),
        "label": row.label if len(facts.lead_labels) > 1 else "", "falling": "" if both is None else f"{about(both[0])} rpm",
        "angle": Amount("loft_cam_angle", angle) if math.isfinite(angle) else "", **spread,
    })  # fmt: skip


def lost(facts: Facts) -> Hits:
    """Control is lost for good below the red line, or anywhere where none is stated."""
    return _lost(facts, beyond=False)


def lost_beyond(facts: Facts) -> Hits:
    """Control is lost, but beyond the red line."""
    return _lost(facts, beyond=True)


def never_held(facts: Facts) -> Hits:
    """Control is lost already at the lowest speed searched."""
    loss = _first(facts)
    if loss is not None and loss.begin <= 0:
        first = loss.row.first_engine_speed
        fields: Fields = {
            "does": does(loss.row),
            "speed": speed_text(first),
            "cause": why(facts, loss),
            "round": speed_text(first, ""),
        }
        yield Hit(Amount(SPEED, first), None, None, fields)


def unknown_from(facts: Facts) -> Hits:
    """Control is kept up to a speed, and of higher ones the runs say nothing: ends of the spring would pull."""
    if facts.searched and facts.train and math.isfinite(facts.control(facts.first_label).silent):
        control = facts.control(facts.first_label)
        speed, lost = control.silent, next(iter(control.losses), None)
        short = facts.red_line - speed
        fields: Fields = {
            "speed": f"about {about(speed)} rpm", "short": f"{about(short)} rpm" if 0 < short < math.inf else "",
            "label": facts.first_label if len(facts.lead_labels) > 1 else "",
            "does": "" if lost is None else does(lost.row), "lost": "" if lost is None else f"{about(lost.begin)} rpm",
            "cause": "" if lost is None else why(facts, lost),
        }  # fmt: skip
        yield Hit(Amount(SPEED, speed), None, None, fields)


def _held(facts: Facts, whole: bool) -> Hits:
    if facts.searched and facts.train and not math.isfinite(facts.control(facts.first_label).limit):
        last = max(one.last_engine_speed for one in facts.study.critical_speeds)
        red = facts.study.record.red_line or last
        if (round((red - last) / RPM) <= 0) is not whole:
            return
        kept = facts.amounts(CONTACT[0])
        least, run = min(kept, key=lambda pair: pair[0].value, default=("", None))
        first = min(one.first_engine_speed for one in facts.study.critical_speeds)
        fields: Fields = {
            "speed": speed_text(last), "round": speed_text(last, ""), "least": least, "short": speed_text(red - last),
            "reach": f"{speed_text(first, '')}-{speed_text(red)}",
        }  # fmt: skip
        yield Hit(Amount(SPEED, last), run, None, fields)


def held(facts: Facts) -> Hits:
    """Nothing is lost up to the highest speed searched, the red line where one is stated."""
    return _held(facts, whole=True)


def held_to_its_end(facts: Facts) -> Hits:
    """Nothing is lost up to the highest speed searched, which lies below the red line."""
    return _held(facts, whole=False)


def islands(facts: Facts) -> Hits:
    """Short ranges of lost contact below the loss that stays, which an engine passes at once."""
    for label in facts.lead_labels if facts.searched else ():
        control = facts.control(label)
        if control.contact is not None and control.islands:
            whole = Loss(control.contact, control.islands)
            fields: Fields = {
                "does": does(control.contact), "spans": joined([_span(one) for one in control.islands]),
                "cause": why(facts, whole), "label": label if len(facts.lead_labels) > 1 else "",
            }  # fmt: skip
            yield Hit(Amount(SPEED, whole.begin), None, None, fields, -whole.begin)


def _span(one: SpeedBracket) -> str:
    low, high = (
        speed_text(speed, "") for speed in (one.lower_engine_speed, one.upper_engine_speed)
    )
    return low if low == high else f"{low} to {high}"


def lost_over_speed(kind: str) -> Condition:
    """A condition on one kind of loss: the speeds that hold it, why, and angle and size of the largest one there."""

    def hits(facts: Facts) -> Hits:
        label = facts.first_label if facts.searched else ""
        losses = [one for one in facts.control(label).losses if one.row.kind == kind]
        for loss in losses[:1]:
            runs = _within(facts, loss)
            pairs = [pair for pair in facts.amounts(SIZES[kind], runs) if pair[0].value > 0]
            size, run = max(pairs, key=lambda pair: pair[0].value, default=("", None))
            yield Hit(Amount(SPEED, loss.begin), None, None, {
                "does": does(loss.row), "cause": why(facts, loss), "size": size, "angle": _angle(facts, loss, run),
                "there": "" if run is None else speed_text(run.engine_speed),
                "ranges": joined([_from(one, loss.row) for one in loss.ranges[:3]]),
            })  # fmt: skip

    hits.__doc__ = f"The speeds at which the valve {DOES[kind].format(place='cam')}, and why."
    return hits


def _angle(facts: Facts, loss: Loss, run: Solution | None) -> Said:
    """Cam angle at which contact first opens, else that of the run with the largest loss; empty where it is not known."""
    first = loss.row.cam_angle
    if loss.at_onset and math.isfinite(first):
        return Amount("loft_cam_angle", first)
    if run is None or loss.row.kind == "bounce":
        return ""
    largest = loss_of(facts, run, facts.losses(run))
    return "" if largest is None else largest.fields["angle"]


def _from(one: SpeedBracket, row: CriticalSpeed) -> str:
    low = max(one.lower_engine_speed, row.first_engine_speed)
    ends = one.upper_engine_speed < row.last_engine_speed
    return f"{about(low)}{f' to {about(one.upper_engine_speed)}' if ends else ''}"


def by_others(facts: Facts) -> Hits:
    """To which speed other models that were requested keep control; a model that knows no surge has no vote on it."""
    said = list[Phrase]()
    models = {run.label: run.model for run in facts.others if facts.searched}
    for label, model in models.items():
        end = facts.control(label).limit
        note = "" if spring_model(model).damped else ", without a vote: it knows no surge"
        said.append(
            Phrase(
                "{model} keeps control {end}{note}",
                {"model": model, "end": reached(end), "note": note},
            )
        )
    said += [
        Phrase("{model} cannot run: {why}", {"model": one.change, "why": one.refusal})
        for label in facts.lead_labels if (row := facts.control(label).contact) for one in row.members
        if facts.searched and one.cause == "model" and one.refusal
    ]  # fmt: skip
    if said:
        yield Hit(Amount(SPEED, len(said)), None, None, {"said": tuple(said)})


def two_motions(facts: Facts) -> Hits:
    """Between two speeds control is kept as the speed rises, and not regained as it falls."""
    for row in facts.study.critical_speeds if facts.searched else ():
        if row.label in facts.lead_labels and row.both_motions is not None:
            low, high = row.both_motions
            march = f"{about(0.99 * low)}:{about(1.01 * high)}:10 rpm"
            fields: Fields = {"low": about(low), "high": about(high), "march": march}
            yield Hit(Amount(SPEED, high - low), None, None, fields)


def silent(facts: Facts) -> Hits:
    """The ends of the spring would pull, in a model that cannot lift them: such runs do not show whether control is lost."""
    for row in facts.study.critical_speeds if facts.searched else ():
        if row.label in facts.lead_labels and row.pulled:
            fields: Fields = {"spans": joined([_span(one) for one in row.pulled[:3]])}
            yield Hit(Amount(SPEED, row.pulled[0].lower_engine_speed), None, None, fields)


def unlike(facts: Facts) -> Hits:
    """Spring sets of one sweep that lose control at different speeds."""
    labels = facts.lead_labels if facts.searched else ()
    ends = sorted(((facts.control(one).limit, one) for one in labels), reverse=True)
    if len(ends) > 1:
        said = tuple(
            Phrase("{label} keeps control {reached}", {"label": one, "reached": reached(end)})
            for end, one in ends
        )
        yield Hit(Amount(SPEED, len(ends)), None, None, {"said": said})


# -- two springs in one engine ---------------------------------------------------------------------


def pair(facts: Facts) -> list[tuple[str, float]]:
    """Names of the two springs and to which speed (rad/s) each keeps control, the better first; none of another study."""
    labels = facts.study.labels
    if facts.study.command != "compare-springs" or len(labels) != 2 or not facts.searched:
        return []
    names = {run.label: run.spring_set or run.label for run in facts.study.solutions}
    ends = [(names[label], facts.control(label).limit) for label in labels]
    return sorted(ends, key=lambda one: -one[1])


def gains(facts: Facts) -> list[float]:
    """Engine speed (rad/s) by which the better of two springs keeps control longer: as computed, then with one thing changed
    for both (model, damping, step, mesh), and between the ends of their ranges where a motion does not repeat; empty where
    one of them keeps control up to the last speed.
    """
    losses = [facts.control(label).losses[:1] for label in facts.study.labels]
    if not all(losses):
        return []
    low, high = sorted((loss for (loss,) in losses), key=lambda one: one.begin)
    found, rows = [high.begin - low.begin], (low.row, high.row)
    changed = {(one.cause, one.change): one.engine_speed for one in low.row.members}
    for one in high.row.members:
        other = changed.get((one.cause, one.change), math.nan)
        if 0 < one.engine_speed < math.inf and 0 < other < math.inf and one.change:
            found.append(one.engine_speed - other)
    if any(one.onset == "non-repeating" for one in rows) and low.row.span and high.row.span:
        first, last = low.row.span, high.row.span
        found += [
            last.lower_engine_speed - first.upper_engine_speed,
            last.upper_engine_speed - first.lower_engine_speed,
        ]
    return found


def gain_text(found: list[float]) -> str:
    """``97 to 243 rpm``: the least and the largest gain (rad/s) of :func:`gains`; empty for none."""
    ends = [round(end / RPM) for end in (min(found), max(found))] if found else []
    text = " to ".join(f"{end:d} rpm" for end in dict.fromkeys(ends))
    return text.replace(" rpm to", " to").replace("-", "−")


def _both_keep(facts: Facts) -> str:
    """The highest speed in use at which both of two springs keep the cam, as text; empty for none."""
    left: dict[float, list[float]] = {}
    for force, run in facts.amounts(CONTACT[0]):
        left.setdefault(round(run.engine_speed, 6), []).append(force.value)
    both = [at for at, forces in left.items() if len(forces) > 1 and min(forces) > 0]
    return speed_text(max(both)) if both else ""


def _ranked(facts: Facts, clear: bool) -> Hits:
    """Where a pair is clear or is not: the better of two springs first, to which speed each keeps control, which breaks
    first, and a model that gives a second opinion. Clear is a gain above a hundredth of the speed with every model and
    damping tried.
    """
    found = pair(facts)
    if not found:
        return
    (better, high), (other, low) = found
    more = gains(facts)
    if (min([high - low, *more]) > ALIKE * low) != clear:
        return
    stress = sorted(largest_stress(facts, AMPLITUDE).items(), key=lambda one: one[1].value)
    weaker = len(stress) == 2 and stress[1][1].value > WEAKER * stress[0][1].value
    yield Hit(Amount(SPEED, min(low, 1e9)), None, facts.study.record.red_line, {
        "gain": gain_text(more), "better": better, "other": other, "high": reached(high), "low": reached(low),
        **({"weak": stress[1][0], "stress": stress[1][1], "less": stress[0][1]} if weaker else {}),
        "model": "multi-mass" if facts.runs[0].model in KNOWS_COILS else "wave-rod",
        "there": _both_keep(facts),
    })  # fmt: skip


def longer(facts: Facts) -> Hits:
    """One of two springs keeps control longer by more than a hundredth of the speed, with every model and damping tried."""
    return _ranked(facts, clear=True)


def alike(facts: Facts) -> Hits:
    """Two springs lose control within a hundredth of the speed, or neither does, or model or damping decides which."""
    return _ranked(facts, clear=False)


def reached(end: float) -> str:
    """``to 6730 rpm``: up to which engine speed (rad/s) control is kept."""
    return f"to {about(end)} rpm" if 0 < end < math.inf else "at no speed searched" if end <= 0 else "at every speed searched"  # fmt: skip


def most_surge(facts: Facts) -> dict[str, tuple[float, float]]:
    """Name of either spring of a pair -> largest surge (N), and its engine speed (rad/s), of all speeds in use that were
    run, those of the search among them.
    """
    found: dict[str, list[tuple[float, float]]] = {}
    for run in facts.runs if pair(facts) else ():
        sizes = found.setdefault(run.spring_set, [])
        if not sizes:
            sizes += [
                (size, at)
                for at, _, size in facts.curve(run.label)
                if at <= facts.in_use and size >= 0
            ]
        if (size := run.quantities.get(SURGE, math.nan)) >= 0:
            sizes.append((size, run.engine_speed))
    return {name: max(sizes) for name, sizes in found.items() if sizes}


def stress_of(facts: Facts, run: Solution, name: str) -> float:
    """A stress (Pa) of a run along its wire, else by the force on its seat and the stress for each newton at full lift; NaN
    of springs by card.
    """
    along, (of_least, of_most) = facts.value(run, name), SHARES[name]
    low, high, stress, force = (facts.value(run, one) for one in RANGE_OF)
    return along if along > 0 else (of_least * low + of_most * high) * stress / force


def largest_stress(facts: Facts, name: str) -> dict[str, Amount]:
    """Name of either spring of a pair -> a stress, the largest of its runs."""
    found: dict[str, Amount] = {}
    for run in facts.runs if pair(facts) else ():
        size = stress_of(facts, run, name)
        if size > (found[run.spring_set].value if run.spring_set in found else 0.0):
            found[run.spring_set] = Amount(name, size)
    return found


LOSS = "{does} at {speed}[, {short} short of the red line][, by falling speed from {falling} on][ ({label})]"
RANGE = "[onset {range} rpm by {over}]"
WHY = "[{cause}][, at {angle}][, up to {size} at {there}]"
#: Rules on what is lost over speed: code -> kind of critical speed.
LOST_AT = {"W121": "contact-loss", "W122": "float", "W123": "bounce"}
COMPARE = "[valvetrain compare {case} --rpm '{round} rpm']"
PARTS = "valvetrain study --parts {case}"
GAIN = "[{weak} breaks first: shear amplitude {stress} against {less}]"
SECOND = "valvetrain sweep {case} --model {model}"
DROPS, TWO = "how-to/02-power-drops.md", "how-to/04-two-springs.md"

RULES = (
    Rule("D101", "decides", "{better} keeps control[ {gain}] longer: {high}, {other} {low}", longer, (), GAIN, SECOND, mark="", guide=TWO),
    Rule("D102", "decides", "no clear difference in control: {better} {high}, {other} {low}", alike, (), GAIN, SECOND, mark="", guide=TWO),
    Rule("W104", "decides", "not in control: {does} already at {speed}", never_held, CONTACT, "[{cause}]", COMPARE,
         guide="how-to/09-loft.md", unless=("D10",)),
    Rule("W101", "decides", LOSS, lost, CONTACT, "[{cause}][, at {angle}]", PARTS, RANGE, DROPS, unless=("D10",)),
    Rule("W102", "decides", "in control to {speed}, {short} above the red line[ ({label})]", lost_beyond, CONTACT,
         "then it {does}[, {cause}][, at {angle}]", PARTS, RANGE, DROPS, "ok", ("D10",)),
    Rule("W103", "decides", "in control up to {speed}, the highest searched", held, CONTACT,
         "[{least} left on the cam][ {at}]", COMPARE, mark="ok", unless=("D10",)),
    Rule("W105", "decides", "in control to {speed}, where the search ends, {short} below the red line", held_to_its_end, CONTACT,
         "[{least} left on the cam][ {at}]", "valvetrain sweep {case} --rpm '{reach}'", mark="", unless=("D10",)),
    Rule("W106", "decides", "in control to {speed}[, {short} short of the red line][ ({label})]", unknown_from,
         CONTACT, "then not known[; {does} from {lost} on[, {cause}]]", "valvetrain sweep {case} --model wave-rod", mark="warn", unless=("D10",)),
    Rule("W110", "warns", "{does} at {spans} rpm as well, a short range[ ({label})]", islands, CONTACT, "[{cause}]",
         guide="how-to/03-resonance.md"),
    Rule("W114", "warns", "nothing is known of control at {spans} rpm: the spring's ends would lift", silent,
         ("minimum_spring_force",), step="valvetrain sweep {case} --model wave-rod", remark="ends would lift"),
    *(Rule(code, "notes", "{does} from {ranges} rpm", lost_over_speed(kind), reason=WHY, remark="from {ranges} rpm" + WHY.replace("[{", "[: {", 1),
           guide=DROPS, unless=("D10",)) for code, kind in LOST_AT.items()),
    Rule("W115", "notes", "other models: {said}", by_others),
    Rule("W112", "notes", "from {low} to {high} rpm both motions exist: rising speed keeps control, falling speed does not regain it",
         two_motions, step="valvetrain branches {case} --rpm '{march}'", remark="rising speed keeps control, falling speed does not regain it"),
    Rule("W113", "notes", "{said}", unlike, unless=("D10",)),
)  # fmt: skip
