"""The verdict of a result: one sentence for its page, its command, a notebook and Python."""

from __future__ import annotations

import math
import os

from valvetrain import registry
from valvetrain.solution.definition import label_cut_off
from valvetrain.solution.force_peak import bandwidth_of
from valvetrain.solution.partial_failures import TRACEBACK_VARIABLE

#: Key of a case whose value is the cut-off of the peaks of spring forces.
CUT_OFF_KEY = "operation.force_bandwidth"


def state_cut_off(result: object) -> None:
    """Let labels state the cut-off of the runs of a result, or of the case of its plan."""
    runs, plan = getattr(result, "solutions", ()), getattr(result, "plan", None)
    case = getattr(plan, "case", None)
    if runs:
        label_cut_off(bandwidth_of(runs[0].provenance))
    elif case is not None:
        varies = any(one.key == CUT_OFF_KEY for one in getattr(plan, "varied", ()))
        label_cut_off(math.nan if varies else case.operation.force_bandwidth)


def verdict_of(result: object) -> str:
    """The sentence of a result, by the function that the registry lists for its class (kind
    ``verdicts``); empty where none is listed or its numbers are missing.
    """
    state_cut_off(result)
    word = type(result).__name__
    if word not in registry.places("verdicts"):
        return ""
    try:
        sentence: str = registry.find("verdicts", word)(result)
    except Exception:  # a sentence must not cost the numbers it is about
        if os.environ.get(TRACEBACK_VARIABLE):
            raise
        return ""
    return sentence
