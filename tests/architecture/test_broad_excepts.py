"""No handler of every error turns a failure into another number: each is here, with what it does
instead. A handler that ends in ``raise`` needs no entry.
"""

from __future__ import annotations

import ast
from pathlib import Path

SRC = Path(__file__).resolve().parents[2] / "src" / "valvetrain"
BROAD = {"Exception", "BaseException", "FAILURES"}
#: File and function -> what becomes of the failure.
KNOWN = {
    "cli/guard.py:GuardedGroup.main": "the command ends with code 1 and the sentence",
    "cli/outcome.py:_show": "the answer is not printed, which counts as a failure",
    "cli/progress.py:_compiled": "the kernel counts as not compiled: an estimate of time",
    "compiled.py:KernelCache.load_overload": "the kernel is compiled again",
    "explore/evaluate.py:evaluate": "a point with the status refused and no number",
    "explore/evaluate.py:bars_of": "no error bars of the point",
    "explore/observe.py:Observed.evaluate": "a point with the status refused and no number",
    "parameters/own_parts.py:_object": "a part that equals no other",
    "views/motion/scene.py:moving_picture": "a note that the run is not drawn",
    "views/study_files.py:_section": "a gap on the page, with the reason",
    "views/results.py:sentence_of": "no sentence",
    "views/results.py:html_for_notebook": "no display",
    "runs/spring_runs.py:solve_at_rest": "no number, the failure of the study",
    "runs/critical_ranges.py:variants_of": "a member of the range with its refusal and no speed",
    "runs/facts.py:_chain_of_wire": "no fact: the run is refused with the reason",
    "runs/own_error_bars.py:_way": "no further run",
    "runs/own_error_bars.py:_run_again": "no number of a further run",
    "runs/prepared.py:prepare": "a run with the status refused and no number",
    "runs/prepared.py:integrate_from": "a run with the status diverged and no number",
    "runs/refine.py:_run": "no number, a sentence among the failures",
    "runs/refine.py:refined": "no number, a sentence among the failures",
    "runs/refine_variants.py:prepare_variant": "no number, a sentence among the failures",
    "runs/refine_variants.py:variants_of": "no number, a sentence among the failures",
    "runs/run_up.py:member_revolutions": "a run with the status diverged and no number",
    "solution/status.py:PartialFailures.part": "a sentence among the failures",
    "springs/chain_from_rod.py:_reference": "the chain is refused with the reason",
    "springs/own_functions.py:Behaviour.entry": "Python runs the same function",
    "springs/own_kernels.py:plain_entry.entry": "a force that is no number: the run diverges",
    "workbench/jobs.py:Jobs._manage": "no job is started until the fault is gone, with one line in the log",
    "workbench/jobs.py:Jobs._follow": "the job is failed, with the reason",
    "workbench/live_worker.py:timed.answered": "a sentence in place of the curve, or of the speed",
}


def names(kind: ast.expr | None) -> set[str]:
    """Names of the errors of a handler; of a bare one every error."""
    if kind is None:
        return {"BaseException"}
    return {one.id for one in ast.walk(kind) if isinstance(one, ast.Name)}


def broad(tree: ast.AST, place: str) -> list[str]:
    """Places of the handlers of every error below a node."""
    found = []
    for node in ast.iter_child_nodes(tree):
        inner = place
        if isinstance(node, (ast.FunctionDef, ast.AsyncFunctionDef, ast.ClassDef)):
            inner = (
                f"{place.rstrip('.')}.{node.name}"
                if ":" in place and place[-1] != ":"
                else place + node.name
            )
        handler = isinstance(node, ast.ExceptHandler) and not isinstance(node.body[-1], ast.Raise)
        if handler and names(node.type) & BROAD:
            found.append(place)
        if isinstance(node, ast.Call) and ast.unparse(node.func).endswith("suppress"):
            found += [place] if any(names(one) & BROAD for one in node.args) else []
        found += broad(node, inner)
    return found


def test_every_handler_of_all_errors_is_known_and_does_not_give_another_number():
    found = [
        place
        for path in sorted(SRC.rglob("*.py"))
        for place in broad(
            ast.parse(path.read_text("utf-8")), f"{path.relative_to(SRC).as_posix()}:"
        )
    ]
    assert not set(found) - set(KNOWN)
