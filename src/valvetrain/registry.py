"""One registry for everything that can be added: a name, and the module of its object.

What ships and what a user's package brings are listed alike, as ``"module:attribute"``; nothing is
imported before it is requested. A package adds, say, a spring model by the entry point
``[project.entry-points."valvetrain.springs"]`` of its own pyproject.toml.
"""

from __future__ import annotations

import difflib
import re
from collections.abc import Container
from functools import cache
from importlib import import_module, metadata
from typing import Any

from valvetrain.errors import InputError

#: Kind -> (entry-point group, what a member of it is called in a sentence).
KINDS: dict[str, tuple[str, str]] = {
    "springs": ("valvetrain.springs", "spring model"),
    "contacts": ("valvetrain.contacts", "contact law"),
    "coil_contacts": ("valvetrain.coil_contacts", "law of contact between coils"),
    "lifts": ("valvetrain.lifts", "lift law"),
    "mechanisms": ("valvetrain.mechanisms", "train kind"),
    "integrators": ("valvetrain.integrators", "integrator"),
    "sources": ("valvetrain.sources", "source study"),
    "quantities": ("valvetrain.quantities", "table of quantities"),
    "displays": ("valvetrain.displays", "display"),
    "files": ("valvetrain.files", "writer of a result"),
    "commands": ("valvetrain.commands", "command"),
    "lift_formats": ("valvetrain.lift_formats", "form of lift files"),
    "rig_formats": ("valvetrain.rig_formats", "form of recordings"),
    "samplers": ("valvetrain.samplers", "sampler"),
    "evaluators": ("valvetrain.evaluators", "evaluator of points"),
    "answers": ("valvetrain.answers", "answer of a result"),
    "rules": ("valvetrain.rules", "table of rules"),
    "other_rules": ("valvetrain.other_rules", "table of rules"),
    "tables": ("valvetrain.tables", "table of a page"),
    "figures": ("valvetrain.figures", "figure of a page"),
}  # fmt: skip

#: Kind -> word -> place. The order is the order of tables and menus.
BUILT_IN: dict[str, dict[str, str]] = {kind: {} for kind in KINDS}
BUILT_IN["commands"] = {
    "run": "valvetrain.cli.run:register_run",
    "compare": "valvetrain.cli.run:register_compare",
    "sweep": "valvetrain.cli.run:register_sweep",
    "compare-springs": "valvetrain.cli.compare_springs:register",
    "study": "valvetrain.explore.command:register",
    "optimise": "valvetrain.explore.command:register_optimise",
    "run-up": "valvetrain.cli.run:register_run_up",
    "branches": "valvetrain.cli.branches:register",
    "static": "valvetrain.cli.static:register",
    "modes": "valvetrain.cli.static:register_modes",
    "refine": "valvetrain.cli.refine:register_refine",
    "runs": "valvetrain.cli.runs:register_runs",
    "compare-runs": "valvetrain.cli.runs:register_compare_runs",
    "compare-test": "valvetrain.compare_test.command:register",
    "lift": "valvetrain.lift.command:register",
    "identify": "valvetrain.explore.command:register_identify",
    "spring-card": "valvetrain.spring_card.command:register",
    "scan": "valvetrain.scan.command:register",
    "film": "valvetrain.film.command:register",
    "rig": "valvetrain.rig.command:register",
    "new": "valvetrain.explore.new_command:register_new",
    "cases": "valvetrain.cli.cases:register_cases",
    "check": "valvetrain.cli.cases:register_check",
    "findings": "valvetrain.cli.definitions:register_findings",
    "quantities": "valvetrain.cli.definitions:register_quantities",
    "serve": "valvetrain.workbench.command:register",
}
BUILT_IN["springs"] = {
    "massless": "valvetrain.springs.massless:SPEC",
    "multi-mass": "valvetrain.springs.multi_mass:SPEC",
    "modal-uniform": "valvetrain.springs.modal_uniform:SPEC",
    "modal-varied": "valvetrain.springs.modal_varied:SPEC",
    "wave-rod": "valvetrain.springs.wave_rod:SPEC",
    "wave-rod-clash": "valvetrain.springs.wave_rod_clash:SPEC",
    "reduced-rod": "valvetrain.springs.reduced_rod:SPEC",
    "finite-element": "valvetrain.springs.finite_element:SPEC",
    "solid": "valvetrain.springs.solid.spec:SPEC",
}
#: Class of a result -> what is shown of it, made from the result alone.
BUILT_IN["answers"] = {
    "Study": "valvetrain.views.answer:Answer",
    "ScannedSpring": "valvetrain.scan.answer:ScanAnswer",
    "ScanComparison": "valvetrain.scan.answer:answer_of_comparison",
    "CoilMotion": "valvetrain.film.answer:FilmAnswer",
    "FilmedModel": "valvetrain.film.answer:answer_of_model",
    "Solution": "valvetrain.views.results:answer_of_run",
    "UncertaintyStudy": "valvetrain.views.refinement:RefineAnswer",
    "StaticCurve": "valvetrain.views.data:static_curve",
    "ModalResult": "valvetrain.views.data:modes",
    "TrainModes": "valvetrain.views.data:train_modes",
    "CriticalSpeeds": "valvetrain.views.data:critical_speeds",
    "Branches": "valvetrain.views.branches:BranchesAnswer",
    "PartRanking": "valvetrain.views.parts:PartsAnswer",
    "MeasuredCycles": "valvetrain.views.data:measured_cycles",
    "ModelAgainstTest": "valvetrain.compare_test.answer:AgainstTestAnswer",
    "RigResult": "valvetrain.rig.answer:RigAnswer",
    "Identified": "valvetrain.explore.identification_answer:IdentificationAnswer",
    "Optimum": "valvetrain.explore.optimum_answer:OptimumAnswer",
    "StudyTable": "valvetrain.explore.study_answer:StudyAnswer",
    "MeasuredLift": "valvetrain.lift.answer:answer_of_stations",
    "SmoothedLift": "valvetrain.lift.answer:answer_of_law",
    "LiftBandStudy": "valvetrain.lift.answer:answer_of_band",
    "SpringFit": "valvetrain.spring_card.answer:answer_of_spring",
    "TesterFit": "valvetrain.spring_card.answer:answer_of_spring",
}
#: What shows results and the progress of a call, loaded on first use.
BUILT_IN["displays"] = {
    "verdict": "valvetrain.views.results:sentence_of",
    "html": "valvetrain.views.results:html_for_notebook",
    "figure": "valvetrain.views.results:figure_for_user",
    "progress": "valvetrain.cli.progress:session_bar",
}
#: Kind of result -> what writes the files of its ``save()`` (any result) or ``report()``.
BUILT_IN["files"] = {
    "result": "valvetrain.solution.netcdf:save_result",
    "page": "valvetrain.views.results:report_result",
    "study": "valvetrain.views.results:write_study",
}
BUILT_IN["integrators"] = {
    "train-leapfrog": "valvetrain.integrate.train_leapfrog:SPEC",  # before those that a train never needs, so that they are not loaded
    "harmonic": "valvetrain.integrate.harmonic:SPEC",
    "rod-leapfrog": "valvetrain.integrate.rod_leapfrog:SPEC",
    "solid-leapfrog": "valvetrain.integrate.solid_leapfrog:SPEC",
    "solid-in-train": "valvetrain.integrate.solid_in_train:SPEC",
    "leapfrog": "valvetrain.integrate.leapfrog:SPEC",
}
BUILT_IN["quantities"] = {
    "general": "valvetrain.quantities.table:ROWS",
    "gu2021": "valvetrain.sources.rows:GU2021",
    "multibody4b17": "valvetrain.sources.rows:MULTIBODY4B17",
}
BUILT_IN["lifts"] = {
    "zero": "valvetrain.cam.closed_form:ZERO_SPEC",
    "spline": "valvetrain.cam.spline:SPLINE_SPEC",
    "table": "valvetrain.cam.spline:SPLINE_SPEC",
    "measured": "valvetrain.cam.measured:SPEC",
    "stations": "valvetrain.cam.spline:STATIONS_SPEC",
    "polynomial": "valvetrain.cam.closed_form:POLYNOMIAL_SPEC",
    "polydyne": "valvetrain.cam.polydyne:SPEC",
    "cycloidal": "valvetrain.cam.closed_form:CYCLOIDAL_SPEC",
    "modified-sine": "valvetrain.cam.closed_form:MODIFIED_SINE_SPEC",
    "harmonic": "valvetrain.cam.closed_form:HARMONIC_SPEC",
    "sine-power": "valvetrain.cam.closed_form:SINE_POWER_SPEC",
    "ramped": "valvetrain.cam.ramped:SPEC",
    "shaped": "valvetrain.cam.shaped:SPEC",
    "cam-card": "valvetrain.cam.cam_card:SPEC",
    "modified-trapezoid": "valvetrain.cam.modified_trapezoid:SPEC",
    "three-arc": "valvetrain.cam.arcs:THREE_ARC_SPEC",
    "tangent": "valvetrain.cam.arcs:TANGENT_SPEC",
}
#: In the order in which a content is tried; the last takes any text.
BUILT_IN["lift_formats"] = {
    "workbook": "valvetrain.measured.lift_formats:WORKBOOK_SPEC",
    "drawing": "valvetrain.measured.drawing:DRAWING_SPEC",
    "s96": "valvetrain.measured.lift_formats:S96_SPEC",
    "fractions": "valvetrain.measured.lift_formats:FRACTIONS_SPEC",
    "columns": "valvetrain.measured.lift_formats:COLUMNS_SPEC",
}
#: Likewise, of recordings of test rigs.
BUILT_IN["rig_formats"] = {
    "mdf": "valvetrain.rig.logger_formats:MDF4_SPEC",
    "tdms": "valvetrain.rig.logger_formats:TDMS_SPEC",
    "mat": "valvetrain.rig.array_formats:MAT5_SPEC",
    "hdf5": "valvetrain.rig.array_formats:HDF5_SPEC",
    "uff58": "valvetrain.rig.logger_formats:UFF58_SPEC",
    "text": "valvetrain.rig.array_formats:TEXT_SPEC",
}
BUILT_IN["contacts"] = {
    "linear": "valvetrain.contact.elastic:LINEAR_SPEC",
    "hertz-point": "valvetrain.contact.elastic:HERTZ_POINT_SPEC",
    "hertz-line": "valvetrain.contact.elastic:HERTZ_LINE_SPEC",
    "hunt-crossley": "valvetrain.contact.dissipative:HUNT_CROSSLEY_SPEC",
    "lankarani-nikravesh": "valvetrain.contact.dissipative:LANKARANI_NIKRAVESH_SPEC",
    "flores": "valvetrain.contact.dissipative:FLORES_SPEC",
    "impact": "valvetrain.contact.impact:SPEC",
    "impact-as-printed": "valvetrain.contact.impact:AS_PRINTED",
}
BUILT_IN["coil_contacts"] = {
    "linear": "valvetrain.coil_contact.law:LINEAR_SPEC",
}
BUILT_IN["mechanisms"] = {
    "direct": "valvetrain.mechanism.direct:SPEC",
    "finger": "valvetrain.mechanism.lever:FINGER",
    "rocker": "valvetrain.mechanism.lever:ROCKER",
    "pushrod": "valvetrain.mechanism.pushrod:SPEC",
}
BUILT_IN["samplers"] = {
    "grid": "valvetrain.explore.samplers:GRID_SPEC",
    "list": "valvetrain.explore.samplers:LISTED_SPEC",
    "latin-hypercube": "valvetrain.explore.samplers:LATIN_HYPERCUBE_SPEC",
    "sobol": "valvetrain.explore.samplers:SOBOL_SPEC",
    "monte-carlo": "valvetrain.explore.samplers:MONTE_CARLO_SPEC",
    "saltelli": "valvetrain.explore.samplers:SALTELLI_SPEC",
    "posterior": "valvetrain.explore.identified:POSTERIOR_SPEC",
}
BUILT_IN["sources"] = {
    key: f"valvetrain.sources.contract:{key.upper()}"
    for key in ("gu2021", "vasilyev2016", "multibody4b17")
}
#: Tables of rules by importance, figures of a study's page and its folded tables, each in their order. What stands before
#: the stroke is the kind of studies (:attr:`valvetrain.findings.facts.Facts.kinds`) that one speaks of; others are not loaded.
BUILT_IN["rules"] = {
    "first": "valvetrain.findings.rules_study:FIRST",
    "run-up/run-up": "valvetrain.findings.rules_study:RUN_UP",
    "train/models": "valvetrain.findings.rules_study:MODELS",
    "compare/peaks": "valvetrain.findings.rules_study:PEAKS",
    "static/static": "valvetrain.findings.rules_rest:STATIC",
    "modes/modes": "valvetrain.findings.rules_rest:MODES",
    "searched/speeds": "valvetrain.findings.rules_sweep:RULES",
    "sweep/measured": "valvetrain.findings.rules_measured:RULES",
    "train/train": "valvetrain.findings.rules_train:RULES",
    "spring/spring": "valvetrain.findings.rules_spring:ALONE",
    "train/strikes": "valvetrain.findings.rules_spring:OF_TRAIN",
    "springs": "valvetrain.findings.rules_spring:RULES",
    "ends": "valvetrain.findings.rules_study:ENDS",
    "train/others": "valvetrain.findings.rules_study:OTHERS",
    "spring/others": "valvetrain.findings.rules_study:SPREAD",
    "last": "valvetrain.findings.rules_study:LAST",
    "assumed": "valvetrain.findings.rules_source:ASSUMED",
    "published/published": "valvetrain.findings.rules_source:PUBLISHED",
}
#: Tables of rules on other results than studies; the answer of each judges by its own.
BUILT_IN["other_rules"] = {
    "case": "valvetrain.findings.rules_case:RULES",
    "branches": "valvetrain.findings.rules_branches:RULES",
    "parts": "valvetrain.findings.rules_parts:RULES",
    "scan": "valvetrain.scan.rules:RULES",
    "film": "valvetrain.film.rules:RULES",
    "refine": "valvetrain.findings.rules_refine:RULES",
    "compare-test": "valvetrain.compare_test.rules:RULES",
    "rig": "valvetrain.rig.rules:RULES",
    "identification": "valvetrain.explore.identification_rules:RULES",
    "optimise": "valvetrain.explore.optimum_rules:RULES",
    "study": "valvetrain.explore.study_rules:RULES",
    "lift": "valvetrain.lift.rules:RULES",
    "spring-card": "valvetrain.spring_card.rules:RULES",
    "saved": "valvetrain.findings.rules_saved:RULES",
}
BUILT_IN["figures"] = {
    "run-up/run-up": "valvetrain.views.figures:RUN_UP",
    "searched/speeds": "valvetrain.views.over_speed:SPEEDS_FIGURE",
    "sweeps/spin": "valvetrain.views.over_speed:SPIN",
    "sweeps/forces": "valvetrain.views.over_speed:FORCES",
    "sweeps/stress": "valvetrain.views.over_speed:STRESSES",
    "compare/models": "valvetrain.views.side_by_side:MODELS",
    "train/control": "valvetrain.views.figures:CONTROL",
    "force": "valvetrain.views.figures:FORCE",
    "train/lift": "valvetrain.views.figures:LIFT",
    "train/contacts": "valvetrain.views.figures:CONTACTS",
    "train/piston": "valvetrain.views.figures:PISTON",
    "coils": "valvetrain.views.figures_of_springs:COILS",
    "orders": "valvetrain.views.figures_of_springs:ORDERS_OF_SURGE",
    "sweeps/order-map": "valvetrain.views.over_speed:ORDER_MAP",
    "strength": "valvetrain.views.figures_of_springs:STRENGTH",
    "modes/surge-orders": "valvetrain.views.figures_of_springs:SURGE_ORDERS",
    "modes/mode-shapes": "valvetrain.views.figures_of_springs:MODE_SHAPES",
    "rest": "valvetrain.views.figures_of_springs:STATIC_CURVES",
}
BUILT_IN["tables"] = {
    "findings": "valvetrain.views.tables:findings",
    "numbers": "valvetrain.views.tables:numbers",
    "published/published": "valvetrain.views.side_by_side:published",
    "published/source": "valvetrain.views.tables:source",
    "events": "valvetrain.views.tables:events",
    "searched/critical": "valvetrain.views.tables:critical",
    "models": "valvetrain.views.tables:models",
    "error-bars": "valvetrain.views.tables:error_bars",
    "at-rest": "valvetrain.views.tables:rest",
    "static/requested": "valvetrain.views.at_rest:requested_table",
    "modes/modes": "valvetrain.views.at_rest:modes_table",
    "modes/train-modes": "valvetrain.views.at_rest:train_table",
}

#: Kind -> what makes its object from a part given in Python (:mod:`valvetrain.parameters.own_parts`).
MAKERS = {
    "springs": "valvetrain.springs.own_spring:spec_of",
    "contacts": "valvetrain.contact.function_law:spec_of",
    "coil_contacts": "valvetrain.coil_contact.function_law:spec_of",
}
#: Name -> function, class or instance that this process was given.
OWN: dict[str, Any] = {}
#: Such a name: that of the part and eight digits of its content.
OWN_NAME = re.compile(r"(.+)-[0-9a-f]{8}")


def plain_name(word: str) -> str:
    """The name of a part given in Python without the digits of its content; any other as it is."""
    found = OWN_NAME.fullmatch(word) if word in OWN else None
    return found[1] if found else word


@cache
def places(kind: str) -> dict[str, str]:
    """Word -> ``"module:attribute"`` of every member of ``kind``: those that ship, then those of
    installed packages by name.

    Raises :class:`InputError` when a package gives a word that is taken, for a silent replacement
    would change numbers.
    """
    found = dict(BUILT_IN[kind])
    group, noun = KINDS[kind]
    for point in sorted(metadata.entry_points(group=group), key=lambda point: point.name):
        if found.setdefault(point.name, point.value) != point.value:
            raise InputError(
                f"an installed package brings a {noun} '{point.name}' ({point.value}), a name that is taken; rename it there"
            )
    return found


def names(kind: str) -> tuple[str, ...]:
    """The names of ``kind``, in order."""
    return tuple(places(kind))


def members(kind: str, scopes: Container[str] | None = None) -> list[tuple[str, Any]]:
    """Names and objects of ``kind``: of those with a scope before a stroke the ones of the ``scopes`` (None: of all)."""
    found = []
    for word in places(kind):
        scope, _, name = word.rpartition("/")
        if not scope or scopes is None or scope in scopes:
            found.append((name, find(kind, word)))
    return found


def find(kind: str, word: str, where: str = "") -> Any:
    """The object behind ``word``. Raises :class:`InputError` for an unknown word (with the nearest
    ones) or one that cannot be loaded.
    """
    known, noun = places(kind), KINDS[kind][1]
    if not isinstance(word, str):
        raise InputError(
            f"{noun} '{str(word)[:40]}' is no word; use one of {', '.join(known)}", where
        )
    if word in OWN and kind in MAKERS:
        return _made(kind, word)
    if word not in known:
        if kind in MAKERS and OWN_NAME.fullmatch(word):
            raise InputError(
                f"{noun} '{word[:60]}' is a part given in Python, which no file holds; give the function or class again",
                where,
            )
        near = difflib.get_close_matches(word[:60], known, n=2, cutoff=0.5)
        near = [name for name in known if word.lower() in name.split("-")] or near
        if not known:
            raise InputError(
                f"{noun} '{word[:40]}' is unknown; install the package that brings it", where
            )
        hint = f"did you mean {' or '.join(near)}?" if near else f"use one of {', '.join(known)}"
        raise InputError(f"{noun} '{word[:40]}' is unknown; {hint}", where)
    module, _, attribute = known[word].partition(":")
    try:
        return getattr(import_module(module), attribute)
    except (ImportError, AttributeError) as error:
        raise InputError(
            f"{noun} '{word}' cannot be loaded from {known[word]} ({error}); repair or remove the package"
        ) from error


@cache
def _made(kind: str, word: str) -> Any:
    module, _, attribute = MAKERS[kind].partition(":")
    return getattr(import_module(module), attribute)(word, OWN[word])
