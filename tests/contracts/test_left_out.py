"""What a caller leaves out adds nothing, and one word left out means one thing wherever it may be
left out.

The first two tables are the rule in words: they stand here, not in the package. The third holds
what physics or a reference gives.
"""

from __future__ import annotations

import ast
from collections import defaultdict
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

import valvetrain

SOURCE = Path(valvetrain.__file__).parent
#: Parts of a model, additions to a motion and marks of a result: without a word there are none.
NOTHING = """
derivative retainer_velocity damping damping_ratio mass_damping stiffness_damping friction friction_coefficient coefficient normal_force
force mass active_mass inactive_mass residual_mass holding_torque stem_damping lash offset tilt radius tip_radius follower_radius
valve_angle valve_inclination cam_angle cam_acceleration nose exchange dynamic_deflection ramp_length fullness smoothing noise band draw
precompression compression engine_speed wall_time wall_time_per_cycle own_time friction_loss pressed_interval last_step overflow dissipated
runs_count discard level threshold base y seed pairs time missed computed
first_frame claimed metres_per_pixel missing resolution phase told
fitted channel cam_speed shared gain bore
""".split()
#: What is done only when asked for.
OFF = """
implausible without_preload tied closed ring kept found widened gap main signed filled y_log turn read_fields axis fields energy
nodal_reactions record_springs record_contacts needs_rest searches processes open_low lowest_open
free_decay synthetic zero_phase keep_outliers periodic
""".split()
#: What is done unless it is refused, and factors that change nothing.
ON = """
pulls judged compared moves with_tangent page in_legend shaded legend worded seats quadratic needs_mass damped critical_speeds apart
spare
""".split()
ONE = """
weight closed_lower closed_upper drive_scale depth factor refinement end_refinement rotation drive_side records scale seeds
""".split()
#: One value everywhere: Hertz (1882) for points, steel (EN 13906-1), ends of a column held in
#: parallel planes, what docs state of flanks,
#: friction and steps.
EVERYWHERE: dict[str, float] = {
    "youngs_modulus": 206e9, "poisson_ratio": 0.3, "seating_coefficient": 0.5, "ramp_blend": 0.3, "ramp": 0.5, "friction_velocity": 0.01,
    "slip_rate": 0.01, "head_fraction": 0.5, "contact_stiffness": 2e10, "damping_time": 1e-6, "contact_damping_time": 1e-6,
    "float_lift": 50e-6, "bounce_height": 100e-6, "longest_period": 8, "alpha": -0.05, "masses_per_coil": 12, "elements": 5, "cells": 200,
    "on_force": 1.0, "rings": 1, "threads": 1, "reference_force": 500.0, "reference_velocity": 0.2, "card_lift": 0.012, "states": 0,
    "width": 0.012, "exponent": 1.5, "degree": 5, "relaxation_time": 4e-6, "largest_increment": 2e-3, "tolerance": 1e-6,
    "samples_across": 5, "picture_width": 800, "duration": 4.0, "strips": 5,
}  # fmt: skip
#: Place and word that means something else there.
APART = {
    ("contact/law.py", "exponent"): 1.0,
    ("contact/law.py", "restitution"): 1.0,
    ("contact/flores.py", "states"): 2,
    ("contact/lankarani_nikravesh.py", "states"): 2,
    ("mechanism/parts.py", "states"): {0, 1},
    ("report/chart.py", "width"): 1.7,
    ("report/svg_chart.py", "weight"): 400,
    ("solution/fidelity.py", "tolerance"): 0.05,
    ("cosserat/static.py", "tolerance"): 1e-5,
    ("cosserat/static.py", "turns"): False,
} | {  # draws of studies and searches
    (f"{file}.py", "seed"): 1
    for file in (
        "studies/points/samplers/contract",
        "studies/points/sensitivity",
        "studies/points/surrogate",
        "identification/ensemble",
        "studies/optimum/optimum_file",
        "identification/search",
        "identification/evolution",
        "identification/branches",
        "identification/nested",
    )
}


def left_out() -> Iterator[tuple[str, str, Any]]:
    """File, word and value of every parameter and field of the package that has a number or a truth
    value where it is left out.
    """
    for path in sorted(SOURCE.rglob("*.py")):
        file = str(path.relative_to(SOURCE))
        if file.startswith(("cli/", "validation/", "sources/")):
            continue  # options of the command have pages of their own; checks of the book state theirs
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            pairs: list[tuple[str, ast.expr | None]] = []
            if isinstance(node, ast.FunctionDef):
                behind = (
                    [*node.args.posonlyargs, *node.args.args][-len(node.args.defaults) :]
                    if node.args.defaults
                    else []
                )
                pairs += [
                    (one.arg, given) for one, given in zip(behind, node.args.defaults, strict=True)
                ]
                pairs += [
                    (one.arg, given)
                    for one, given in zip(node.args.kwonlyargs, node.args.kw_defaults, strict=True)
                ]
            elif isinstance(node, ast.ClassDef):
                fields = [
                    one
                    for one in node.body
                    if isinstance(one, ast.AnnAssign) and isinstance(one.target, ast.Name)
                ]
                pairs += [
                    (one.target.id, _given(one.value))
                    for one in fields
                    if isinstance(one.target, ast.Name)
                ]
            for word, given in pairs:
                try:
                    value = ast.literal_eval(given) if given is not None else None
                except ValueError:
                    continue
                if isinstance(value, (int, float)):
                    yield file, word, value


def _given(value: ast.expr | None) -> ast.expr | None:
    if isinstance(value, ast.Call):
        return next((one.value for one in value.keywords if one.arg == "default"), None)
    return value


FOUND: dict[str, list[tuple[str, Any]]] = defaultdict(list)
for _file, _word, _value in left_out():
    FOUND[_word].append((_file, _value))
RULE: dict[str, Any] = {
    **dict.fromkeys(NOTHING, 0), **dict.fromkeys(OFF, False), **dict.fromkeys(ON, True), **dict.fromkeys(ONE, 1), **EVERYWHERE,
}  # fmt: skip


def test_the_rule_speaks_of_most_of_what_can_be_left_out():
    assert set(RULE) <= set(FOUND), set(RULE) - set(FOUND)
    spoken = sum(len(FOUND[word]) for word in RULE)
    assert spoken > 0.65 * sum(map(len, FOUND.values())) > 300


@pytest.mark.parametrize("word", RULE)
def test_what_is_left_out_is_what_the_rule_says(word):
    for file, value in FOUND[word]:
        told = APART.get((file, word), RULE[word])
        assert value in told if isinstance(told, set) else value == told, (file, value)
