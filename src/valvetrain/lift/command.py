"""``valvetrain lift``: measured lifts in, the law behind them with its uncertainty out."""

from __future__ import annotations

import shlex
from dataclasses import asdict, dataclass, replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

from valvetrain.cli.request import SavedLine, command_of
from valvetrain.errors import InputError
from valvetrain.runs.request_fields import (
    option,
    options_of,
    read_amounts,
    read_case,
    read_count,
    read_models,
    read_names,
    read_path,
    read_speeds,
    read_switch,
    read_text,
    read_within,
    read_words,
)
from valvetrain.runs.requests import Limited, Parallel

if TYPE_CHECKING:
    from valvetrain.lift.band import LiftBandStudy
    from valvetrain.lift.figures import LiftFigure, LobeResult
    from valvetrain.lift.rules import LiftFacts
    from valvetrain.measured.lift_file import LiftAnswers, MeasuredLift
    from valvetrain.parameters.case import Case
    from valvetrain.parameters.lift_law import LiftLawParameters

LENGTH, ANGLE = partial(read_within, "length", -1e3, 1e3), partial(read_within, "angle", -1e6, 1e6)
#: Fields that say what the tables hold, besides those of :class:`LiftAnswers`.
READS = ("exhaust", "lobe", "base_radius", "noise", "band")


@dataclass(frozen=True, kw_only=True)
class LiftRequest(Parallel, Limited):
    """The lobes of a table, a case or a cam card, and a case that takes the first of them."""

    command = "lift"

    file: Path | None = option(
        read_path,
        "Table of lifts or contour: text, s96, fractions, XLSX, DXF; read by content. Or a case.",
        metavar="[FILE]",
    )
    exhaust: Path | None = option(
        read_path, "Table of the exhaust lobe on the same zero: gives overlap.", "--exhaust", "FILE"
    )
    angle_of: str = option(
        read_text, "Whose angles the table holds.", "--angle-of", "cam|crank", default=""
    )
    lift_of: str = option(read_text, "Whose lift it is.", "--lift-of", "valve|tappet", default="")
    lift_unit: str = option(
        read_text, "Unit of the lifts, such as mm or inch.", "--lift-unit", "UNIT", default=""
    )
    angle_unit: str = option(
        read_text, "Unit of the angles (default: deg).", "--angle-unit", "deg|rad", default=""
    )
    columns: tuple[str, ...] = option(
        read_words,
        "What each column is: 'angle, lift, velocity' (or intake, exhaust, ignore).",
        "--columns",
        "WORDS",
        default=(),
    )
    zero: str = option(
        read_text,
        "Zero of the angle: as in the file (default) or at the nose.",
        "--zero",
        "file|nose",
        default="",
    )
    direction: str = option(
        read_text,
        "Whether the cam turned with rising angle (forward).",
        "--direction",
        "forward|reversed",
        default="",
    )
    lobe: str = option(
        read_text, "Which of the lobes or events of the table.", "--lobe", "NAME", default=""
    )
    events: str = option(
        read_text,
        "Of a cam card: 'IVO 5 before top, IVC 32.5 after bottom'.",
        "--events",
        "TEXT",
        default="",
    )
    top_dead_centre: float | None = option(
        ANGLE, "Cam angle of it on the page: gives IVO to EVC.", "--top-dead-centre", "ANGLE"
    )
    lobe_centre: float | None = option(
        ANGLE,
        "Crank angle of the lobe after (−: before) top dead centre.",
        "--lobe-centre",
        "ANGLE",
    )
    follower: str = option(
        read_text,
        "What the cam lifts: flat, 'roller 10 mm', 'dome 50 mm'.",
        "--follower",
        "TEXT",
        default="",
    )
    base_radius: float | None = option(
        LENGTH,
        "Radius of the base circle: gives the contour of the cam.",
        "--base-radius",
        "LENGTH",
    )
    mend: bool = option(
        read_switch, "Take out stations that stand out, such as dust.", "--mend", default=False
    )
    peak_lift: float | None = option(
        LENGTH, "Of a table of fractions: its largest lift.", "--peak-lift", "LENGTH"
    )
    duration: float | None = option(
        ANGLE, "Of a table of fractions: its length, in that angle.", "--duration", "ANGLE"
    )
    opening: float | None = option(
        ANGLE, "Of a table of fractions: where it begins.", "--opening", "ANGLE"
    )
    noise: float | None = option(
        LENGTH,
        "Standard deviation of a station, such as '3 um' (default: found).",
        "--noise",
        "LENGTH",
    )
    band: float | None = option(
        LENGTH, "How far the law may leave a station at most.", "--band", "LENGTH"
    )
    at: tuple[float, ...] = option(
        partial(read_amounts, "length"),
        "Further lift at which the duration is given: '0.2 inch'. Repeatable.",
        "--at",
        "LENGTH",
        default=(),
        repeatable=True,
    )
    case: Case | None = option(
        read_case,
        "Case whose lift it becomes: its forces and speeds with the band.",
        "--case",
        "CASE",
    )
    engine_speeds: tuple[float, ...] | None = option(
        read_speeds,
        "Crank speeds instead of the case's own, in rpm: '4200, 5600', '1000:9000:500' or '4000-8000'.",
        "--rpm",
        "SPEEDS",
    )
    search: tuple[float, ...] | None = option(
        read_speeds,
        "Range in which float and bounce are searched: '4000:9000:500 rpm'.",
        "--search",
        "SPEEDS",
    )
    draws: int = option(
        partial(read_count, 1, 10**6),
        "Lift laws drawn from the band, for forces and speeds.",
        "--draws",
        "N",
        default="16",
    )
    models: tuple[str, ...] = option(
        read_models,
        "Spring models, such as massless,multi-mass,wave-rod,finite-element; repeatable.",
        "--model",
        "MODELS",
        default=(),
        repeatable=True,
    )
    spring_sets: tuple[str, ...] = option(
        read_names,
        "Spring sets of a train, such as stock,performance; repeatable.",
        "--spring-set",
        "SETS",
        default=(),
        repeatable=True,
    )

    def __post_init__(self) -> None:
        """Raise :class:`InputError` for speeds without a case."""
        if self.case is None and (self.engine_speeds or self.search):
            raise InputError("speeds are run with a case; name it with --case", "case")

    @property
    def answers(self) -> LiftAnswers:
        """What the tables leave open."""
        from valvetrain.measured.lift_file import LiftAnswers

        return LiftAnswers(
            **{name: getattr(self, name) for name in LiftAnswers.__dataclass_fields__}
        )

    @property
    def stated(self) -> tuple[float | None, float | None]:
        """Noise of a station and largest distance of the law from one (m), where they are given."""
        return self.noise, self.band

    @property
    def again(self) -> str:
        """Words behind ``valvetrain lift`` that read the tables again."""
        words, asked = [str(self.file or "")], options_of(type(self))
        for name in (*self.answers.__dataclass_fields__, *READS):
            if value := getattr(self, name):
                words += [asked[name].flag, *([] if value is True else [self.typed[name]])]
        return shlex.join(words)


def lift(request: LiftRequest, line: SavedLine, folder: Path) -> None:
    """Measured lift: figures of the lobe, lift to jerk with error bands, a lift law for a case,
    effect of the noise on forces and float.
    """
    from valvetrain.cli.outcome import deliver
    from valvetrain.cli.run_answer import SavedRequest, saved_result
    from valvetrain.lift.answer import LiftAnswer
    from valvetrain.lift.files import lift_case, lift_parameters, write_lift
    from valvetrain.lift.rules import LiftFacts
    from valvetrain.lift.shape import with_contour, write_contours
    from valvetrain.lift.timing import (
        cams_of,
        dead_centre_of,
        lift_of_case,
        read_off,
        typed_figures,
    )
    from valvetrain.measured.contours import Follower
    from valvetrain.measured.lift_file import chosen_lobe, read_lift
    from valvetrain.solution.atomic import write_text

    file, stated, top = request.file, request.stated, request.top_dead_centre
    is_case = file is not None and file.suffix == ".toml"
    tables = [path for path in (file, request.exhaust) if path is not None]
    named = [(path, read_lift(path, request.answers)) for path in tables[is_case:]]
    if is_case and file is not None:
        sampled, top_of_case = lift_of_case(file)
        top, named = top_of_case if top is None else top, [(file, (sampled,)), *named]
    cams = cams_of(request.events, file if is_case else None)
    if not (named or cams):
        raise InputError("a cam comes as a table of lifts, a case or --events; give one", "FILE")
    if request.lobe or request.case is not None or request.exhaust is not None:
        named = [(path, (chosen_lobe(lobes, request.lobe, path.name),)) for path, lobes in named]
    lobes, pair = _lobes(
        [lobe for _, some in named for lobe in some],
        request.exhaust is not None,
        stated,
        request.at,
    )
    follower = Follower.of(request.follower or "flat")
    lobes = [with_contour(lobe, request.base_radius, follower) for lobe in lobes]
    if not lobes and request.case is not None:
        raise InputError("a case takes a lift, not events alone; give a table of lifts", "case")
    if lobes and top is None and request.lobe_centre is not None:
        top = dead_centre_of(lobes[0], request.lobe_centre)
    timing = {event.name: event for event in typed_figures(cams)}
    if top is not None:
        timing |= {event.name: event for event in read_off(lobes, top)}
    carried = None
    if request.case is not None:
        carried = _carried(request, lift_parameters(lobes[0], *stated))
    case = lift_case(
        f"lift-{'events' if file is None else file.stem}", lobes[0] if lobes else None, *stated
    )
    template = "spring" if lobes and lobes[0].measured.lift_of == "valve" else "pushrod"
    onward = (
        f"run {shlex.quote(str(file))}"
        if is_case
        else f"lift {request.again} --case template:{template}"
    )
    facts = LiftFacts(tuple(lobes), pair, tuple(timing.values()), carried, onward=onward)
    name = "case" if carried is not None else lobes[0].measured.name if lobes else "events"

    def fill(folder: Path) -> list[Path]:
        files = [*write_lift(lobes, folder, *stated), *write_contours(lobes, folder)]
        if carried is not None:
            files.append(write_text(folder / "case.toml", carried.mean.record.text))
        return files

    def show(folder: Path) -> LiftAnswer:
        title = " and ".join(path.name for path in tables) or f"cam events, {request.events}"
        return LiftAnswer(replace(facts, file=str(folder / f"{name}.toml")), title)

    saved = SavedRequest("lift", case, line.output)
    deliver(
        saved_result(
            saved,
            case.text,
            _data(facts),
            show,
            fill,
            request.given,
            line.open_page,
            facts.failures,
        )
    )


register = command_of(LiftRequest, SavedLine, lift)


def _lobes(
    found: list[MeasuredLift],
    of_two_files: bool,
    stated: tuple[float | None, float | None],
    heights: tuple[float, ...],
) -> tuple[list[LobeResult], tuple[LiftFigure, ...]]:
    """Every lobe smoothed with the ``stated`` noise and band (m) and measured out; of intake and exhaust
    what both have together. ``heights``: lifts (m) of durations.
    """
    from valvetrain.lift.figures import LobeResult, lift_figures, pair_figures
    from valvetrain.measured.lift_smoothing import smooth_lift

    if of_two_files:
        found = [replace(found[0], name="intake"), replace(found[1], name="exhaust")]
    results = []
    for lobe in found:
        smoothed = smooth_lift(lobe.cam_angles, lobe.lifts, *stated)
        results.append(LobeResult(lobe, smoothed, lift_figures(smoothed, heights)))
    known = {one.measured.name: one.smoothed for one in results}
    both = {"intake", "exhaust"} <= set(known)
    return results, pair_figures(known["intake"], known["exhaust"], heights) if both else ()


def _carried(request: LiftRequest, law: LiftLawParameters) -> LiftBandStudy:
    """Forces and critical speeds of a case with this ``law``, over the laws that its stations allow."""
    from valvetrain.cli.progress import announce_compilation, progress_bar
    from valvetrain.lift.band import FEWER_LAWS, band_cost, lift_band_study
    from valvetrain.lift.files import case_with
    from valvetrain.runs.cost import RunRequest, refuse_cost

    case, draws = request.case, request.draws
    assert case is not None
    if case.lift_law is not None and case.lift_law.lift_of != law.lift_of:
        raise InputError(
            f"case '{case.name}' is driven by the lift of the {case.lift_law.lift_of}, the table holds the {law.lift_of}'s; "
            "give a table of the other or another case",
            "case",
        )
    carried = case_with(case, law)
    options = request.engine_speeds, request.models, request.spring_sets, request.worker_count
    cost = band_cost(RunRequest("run", carried, *options), draws, request.search)
    refuse_cost(cost, request.limit, fewer=FEWER_LAWS)
    announce_compilation("train")
    with progress_bar(f"{case.name} with {draws} laws") as report:
        return lift_band_study(
            carried,
            request.engine_speeds,
            draws=draws,
            search=request.search,
            models=request.models,
            spring_sets=request.spring_sets,
            workers=request.worker_count,
            progress=report,
            limit=request.limit,
        )


def _data(facts: LiftFacts) -> dict[str, Any]:
    """The JSON answer, SI."""
    from valvetrain.measured.json import json_estimate, json_fields

    carried = facts.carried

    def figures(found: tuple[LiftFigure, ...]) -> dict[str, Any]:
        return {one.name: json_estimate((one.value, one.spread)) for one in found}

    data: dict[str, Any] = {
        "command": "lift", "case": "", "completed": not facts.failures
    }  # fmt: skip
    data["lobes"] = [
        {
            **json_fields(one.measured, "name form lift_of zero notes changes mended"),
            "answers": {answer.question: {"answer": answer.answer, "by": answer.by} for answer in one.measured.answers},
            "dust": [asdict(bump) for bump in one.measured.dust], "noise": one.smoothed.noise, "figures": figures(one.figures)
        }
        for one in facts.lobes
    ]  # fmt: skip
    if facts.pair:
        data["both_lobes"] = figures(facts.pair)
    if facts.timing:
        data["timing"] = figures(facts.timing)
    if carried is not None:
        data["carried"] = [
            {
                "quantity": one.quantity, "label": one.label, "engine_speed": one.engine_speed, "value": one.value,
                "standard_deviation": one.spread, "laws": one.draws
            }
            for one in carried.spreads
        ]  # fmt: skip
    return data
