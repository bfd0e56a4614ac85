"""Rules on a case before anything runs (Q): what its cam, follower, pushrod and springs fit, and what is in doubt."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

from valvetrain.findings.engine import SPRINGS, Hit, Hits, Rule, Subject
from valvetrain.findings.rules_source import LASH, RECUT
from valvetrain.findings.rules_spring import MAY, SOLID, STATE, WOUND
from valvetrain.findings.rules_train import NEEDED
from valvetrain.findings.words import Amount, joined, speed_text
from valvetrain.mechanism.pushrod import pushrod_length
from valvetrain.parameters.case import Case
from valvetrain.quantities.cam_shape import lash_lift
from valvetrain.solution.critical import NEAR_BIND
from valvetrain.system.problem import Gear

#: Stiffness over that of a tube of the same mass, above which no such tube is, since mass and length are rounded; below
#: half of it the value holds more than the tube.
ABOVE_TUBE, BELOW_TUBE = 1.05, 0.5
#: Lash (m) up to which heat may take it up.
SMALL_LASH = 0.1e-3
#: Share by which the length given may differ from that between the balls.
LENGTH_SHARE = 0.02


@dataclass(frozen=True)
class CaseFacts(Subject):
    """A case as rules read it.

    Parameters
    ----------
    parameters : the case
    values : quantities (SI) of its springs in use, its lift and its cam
    gear : its train; None of springs alone
    runs : whether it holds anything that can run
    name : what a command takes for it
    """

    parameters: Case
    values: Mapping[str, float]
    gear: Gear | None = None
    runs: bool = True
    name: str = ""

    @property
    def case(self) -> str:
        """What a command takes for this case."""
        return self.name or self.parameters.name

    def amount(self, name: str) -> Amount | None:
        """A quantity; None where the case does not give it."""
        value = self.values.get(name, math.nan)
        return Amount(name, value) if math.isfinite(value) else None

    @property
    def lift(self) -> float:
        """The largest lift (m) of the valve, or of the spring alone; NaN without one."""
        largest = self.values.get("maximum_lift", math.nan)
        return self.values.get("rigid_maximum_valve_lift", largest)

    @property
    def left(self) -> Amount | None:
        """What is least left to coil bind at full lift, of the springs in use; None where it is not known."""
        return self.amount("coil_bind_clearance")

    @property
    def spare(self) -> Amount | None:
        """By how much the springs are above the load that is :data:`NEEDED` at full lift; None where that is not known."""
        needed, have = self.amount(NEEDED[1]), self.amount("open_spring_force")
        return Amount(NEEDED[1], have.value - needed.value) if needed and have else None


def high_lash(facts: CaseFacts) -> Hits:
    """The lash takes more of the lobe than its ramp lifts."""
    lash, ramp = lash_lift(facts.gear), facts.values.get("cam_ramp_lift", 0.0)
    if "cam_closing_ramp_velocity" in facts.values and lash > ramp * (1 + 1e-9) > 0:
        yield Hit(Amount("cam_ramp_lift", lash), None, ramp)


def small_lash(facts: CaseFacts) -> Hits:
    """The train has a lash of at most a tenth of a millimetre, which a hot valve or block takes up."""
    lash = 0.0 if facts.parameters.train is None else facts.parameters.train.lash
    if 0 < lash <= SMALL_LASH:
        yield Hit(Amount("maximum_lift", lash))


def _face(facts: CaseFacts) -> tuple[float, float] | None:
    """Radius (m) to which the contact runs, and that of the face of a follower (NaN: not given)."""
    away = facts.values.get("cam_contact_face_radius")
    if facts.gear is None or away is None:
        return None
    given = facts.gear.parameters.follower.face_diameter
    return away, math.nan if given is None else given / 2


def off_face(facts: CaseFacts) -> Hits:
    """The contact of the cam runs off the follower's face."""
    found = _face(facts)
    if found is not None and found[0] > found[1]:
        needed = Amount("cam_contact_face_radius", 2 * found[0])
        yield Hit(Amount("cam_contact_face_radius", found[0] - found[1]), fields={"needed": needed})


def face_needed(facts: CaseFacts) -> Hits:
    """The case states no face diameter of its follower."""
    found = _face(facts)
    if found is not None and math.isnan(found[1]):
        yield Hit(Amount("cam_contact_face_radius", 2 * found[0]))


def rod_length(facts: CaseFacts) -> Hits:
    """The length of the pushrod is not that between its balls."""
    train = facts.parameters.train
    rod = None if train is None else train.pushrod
    if train is None or rod is None or rod.length is None:
        return
    between = pushrod_length(train)
    if abs(rod.length / between - 1) > LENGTH_SHARE:
        yield Hit(Amount("free_length", rod.length), fields={
            "between": Amount("free_length", between), "apart": Amount("free_length", abs(rod.length - between)),
            "way": "away from" if rod.length > between else "towards",
        })  # fmt: skip


def odd_tube(facts: CaseFacts) -> Hits:
    """A pushrod stiffer than a tube of its mass and length, E m / (density L2) whatever its diameters, or less than half as
    stiff, as if more than the tube gave way.
    """
    train = facts.parameters.train
    rod = None if train is None else train.pushrod
    if train is None or rod is None or rod.stiffness is None or any(rod_length(facts)):
        return
    tube = rod.youngs_modulus * rod.mass / (rod.density * pushrod_length(train) ** 2)
    if rod.stiffness > ABOVE_TUBE * tube or rod.stiffness < BELOW_TUBE * tube:
        yield Hit(Amount("installed_rate", rod.stiffness), None, tube)


def short(facts: CaseFacts) -> Hits:
    """The springs are below inertia plus 20 % at the highest speed in use."""
    if facts.spare and facts.spare.value < 0:
        words = dict(zip(("closed", "full", "rate"), map(facts.amount, NEEDED), strict=True))
        speed = speed_text(facts.parameters.operation.top_speed)
        yield Hit(
            Amount(NEEDED[1], -facts.spare.value),
            fields={"speed": speed} | {key: one or "" for key, one in words.items()},
        )


def _ready(facts: CaseFacts, near: bool) -> Hits:
    if facts.runs and (facts.left is not None and facts.left.value < NEAR_BIND) is near:
        moves = facts.parameters.lift_law is not None
        speeds = facts.parameters.operation.engine_speeds
        step = "run" if moves and speeds else "sweep" if moves else "static"
        yield Hit(facts.left, fields={
            "next": step, "left": facts.left or "", "spare": facts.spare or "",
            "speed": speed_text(facts.parameters.operation.top_speed),
        })  # fmt: skip


def ready(facts: CaseFacts) -> Hits:
    """Everything that a run builds could be built, and nothing is in doubt."""
    return _ready(facts, near=False)


def ready_but_near(facts: CaseFacts) -> Hits:
    """Everything that a run builds could be built, and the springs come within a millimetre of coil bind."""
    return _ready(facts, near=True)


def sharp(facts: CaseFacts) -> Hits:
    """The cam has a radius of less than :data:`SHARP`, which is pressed hard."""
    radius = facts.amount("cam_least_radius")
    if radius is not None and radius.value < SHARP:
        yield Hit(radius)


def law_alone(facts: CaseFacts) -> Hits:
    """A lift law without a spring or a train."""
    if not facts.runs:
        yield Hit(fields={"kind": facts.parameters.lift_law.kind if facts.parameters.lift_law else ""})  # fmt: skip


def unchecked(facts: CaseFacts) -> Hits:
    """A spring in use of which neither a solid height is known, nor wire and turns."""
    springs = facts.parameters.springs
    if facts.parameters.train is not None:
        springs = facts.parameters.train.spring_parts()
    unknown = [one.name for one in springs if not one.clearances(0.0)]
    if unknown and math.isfinite(facts.lift) and facts.runs:
        yield Hit(fields={"spring": joined(unknown) if len(springs) > 1 else "the spring"})


def wound(facts: CaseFacts) -> Hits:
    """Wire and turns of a card may leave less than a millimetre to coil bind."""
    least = facts.amount(WOUND[0])
    if least is not None and least.value < NEAR_BIND:
        yield Hit(least)


def recut(facts: CaseFacts) -> Hits:
    """The lash by which a cam is cut was changed, and with it the cam."""
    if LASH in facts.parameters.changed:
        yield Hit()


def other_height(facts: CaseFacts) -> Hits:
    """A stated solid height is more than 1 % off that of the wire."""
    for one in SPRINGS:
        computed = facts.amount(f"{one}computed_solid_height")
        if computed is not None:
            stated = Amount("solid_height", facts.values[f"{one}solid_height"])
            yield Hit(computed, fields={"stated": stated, "spring": one.rstrip("_")})


BIND = ("coil_bind_clearance",)
ABOVE = "springs {spare} above inertia plus 20 % at {speed}"
#: Radius (m) below which a cam is called sharp.
SHARP = 2e-3
RULES = (
    Rule("Q111", "decides", "the lash takes {value} of the lobe, above its ramp of {limit}", high_lash,
         ("cam_ramp_lift",), "the valve strikes its seat", "make the ramp higher or the lash smaller", mark="warn"),
    Rule("Q112", "decides", "the contact runs {value} off the follower's face", off_face, ("cam_contact_face_radius",),
         "the face needs a diameter of {needed}", mark="warn"),
    Rule("Q113", "decides", "the pushrod is {value:4} long and its balls are {between:4} apart", rod_length, (),
         "about right with pivot {apart} {way} the cam", "check pivot, drive_arm, drive_angle and lower_end", mark="warn"),
    Rule("Q114", "warns", "the pushrod's {value} do not fit the {limit} of a tube of its mass and length", odd_tube,
         (), "mass and stiffness count as the case has them"),
    Rule("Q117", "warns", "a lash of {value} may be gone when hot: the valve hangs open then", small_lash,
         remark="may be gone when hot: the valve hangs open then"),
    Rule("Q116", "decides", "the springs are {value} short at {speed}", short, NEEDED,
         "inertia plus 20 % needs {closed} closed and {full} at full lift, or {rate}", "valvetrain sweep {case}", mark="warn"),
    Rule("Q101", "decides", "ready to run", ready, BIND, f"[{ABOVE}][, {{left}} left to coil bind]",
         "valvetrain {next} {case}", mark="ok", unless=("Q111", "Q112", "Q113", "Q116")),
    Rule("Q103", "decides", "ready to run, with only {left} left to coil bind", ready_but_near, BIND, f"[{ABOVE}]",
         "valvetrain {next} {case}", mark="warn", guide="how-to/05-coil-bind.md", unless=("Q111", "Q112", "Q113", "Q116")),
    Rule("Q102", "decides", "a {kind} lift law alone", law_alone, (), "nothing to run without a spring or a train",
         mark=""),
    Rule("Q118", "warns", "the cam's least radius is {value}: so sharp a nose is pressed hard", sharp, ("cam_least_radius",),
         step="set train.cam.base_radius larger", remark="of the cam: sharp, pressed hard"),
    Rule("Q120", "notes", "coil bind of {spring} is not checked: no solid height is known", unchecked, BIND,
         remark="not known of {spring}"),
    Rule("Q124", "warns", SOLID, wound, WOUND, step=STATE, remark=MAY, guide="how-to/05-coil-bind.md"),
    Rule("Q122", "warns", RECUT, recut, step="set train.lash"),
    Rule("Q123", "warns", "solid at {stated:4} is stated, and the wire binds at {value:4}[, {spring} spring]", other_height, BIND,
         "the stated height counts", remark="wire binds at {value:4}", guide="how-to/05-coil-bind.md"),
    Rule("Q121", "notes", "the follower's face needs a diameter of {value}", face_needed, ("cam_contact_face_radius",)),
)  # fmt: skip
