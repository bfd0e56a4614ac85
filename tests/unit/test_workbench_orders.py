"""What the page of a case offers to run, and the words of the command line that a choice becomes.

Evidence: the readers of the command line and of study files take what is asked.
"""

from __future__ import annotations

import numpy as np
import pytest

from valvetrain.cli.options import read_names
from valvetrain.errors import InputError
from valvetrain.explore.study import read_plan, read_study_file
from valvetrain.parameters.loading import load_case, parse_case
from valvetrain.runs.cost import Cost, Limits
from valvetrain.runs.request_cost import RunRequest, request_cost
from valvetrain.workbench.pages.orders import choices_for, request_of, sets_for
from valvetrain.workbench.requests import (
    JobRequest,
    check_request,
    command_arguments,
    cost_of,
    study_text,
)
from workbench_parts import SMALL

WISH = {"kind": "run", "models": ["massless"], "speeds": "2000 rpm"}
STUDY = WISH | {
    "kind": "study",
    "key": "train.lash",
    "low": "0.1 mm",
    "high": "0.2 mm",
    "points": 3,
    "output": "preload",
}


def ticked(offered):
    return [one["word"] for one in offered if one["chosen"]]


def test_spring_sets_are_offered_where_a_train_has_several_and_the_last_choice_is_kept():
    train = load_case("tdi-pushrod")
    assert (
        [one["word"] for one in choices_for(train, (), {})["sets"]]
        == list(train.train.springs)
        == ["stock", "performance"]
    )
    assert ticked(sets_for(train)) == ["stock"], "the train's own"
    assert ticked(sets_for(train, '["performance"]')) == ["performance"]
    for kept in ('["gone"]', "stock", "[", "null", '{"stock": 1}', "[" * 100_000):
        assert ticked(sets_for(train, kept)) == ["stock"]
    assert choices_for(parse_case(SMALL), (), {})["sets"] == sets_for(load_case("job-t")) == []


@pytest.mark.parametrize("kind", ["run", "sweep"])
def test_chosen_sets_reach_the_command_line(kind):
    train = load_case("tdi-pushrod")
    request = request_of("tdi-pushrod", WISH | {"kind": kind, "sets": ["stock", "performance"]})
    check_request(request, train)
    words = command_arguments(request, "case.toml", 1, Limits(1.0, 1e6), "")
    told = [word.partition("=")[2] for word in words if word.startswith("--spring-set=")]
    assert read_names(told) == ("stock", "performance")
    assert not [
        word
        for word in command_arguments(
            request_of("c", WISH | {"sets": None}), "f", 1, Limits(1.0, 1e6), ""
        )
        if "spring-set" in word
    ]
    with pytest.raises(InputError, match="no spring set is chosen"):
        request_of("tdi-pushrod", WISH | {"kind": kind, "sets": []})
    with pytest.raises(InputError, match="no spring set of this case"):
        check_request(request_of("tdi-pushrod", WISH | {"kind": kind, "sets": ["--json"]}), train)


def test_chosen_sets_reach_the_study_file(tmp_path):
    request = request_of("tdi-pushrod", STUDY | {"sets": ["performance"]})
    check_request(request, load_case("tdi-pushrod"))
    path = tmp_path / "study.toml"
    path.write_text(study_text(request, "tdi-pushrod"), encoding="utf-8")
    assert 'spring_sets = ["performance"]' in path.read_text("utf-8")
    assert {chosen for _, _, chosen in read_plan(read_study_file(path)).runs} == {"performance"}
    with pytest.raises(InputError, match="no spring set is chosen"):
        request_of("tdi-pushrod", STUDY | {"sets": []})


@pytest.mark.parametrize(
    ("kind", "speeds", "count"),
    [("run", "", None), ("run", "2000, 3000 rpm", 2), ("sweep", "", 81)],
)
def test_a_job_costs_its_speeds_and_searches(kind, speeds, count):
    """A run without speeds by those of its case; a sweep without speeds by 1000 to 9000 rpm in
    hundreds; only a sweep searches.
    """
    case = load_case("job-t")
    lowest, highest = (1000.0, 9000.0) if count == 81 else (2000.0, 3000.0)
    rpm = None if count is None else np.linspace(lowest, highest, count)
    engine_speeds = None if rpm is None else tuple(rpm * 2.0 * np.pi / 60.0)
    asked = RunRequest(kind, case, engine_speeds, ("massless",), (), 3)
    expected = request_cost(asked, kind == "run", kind == "sweep")
    cost = cost_of(JobRequest(kind, "one", ("massless",), speeds), case, 3)
    assert cost.seconds == pytest.approx(expected.seconds)
    assert cost.bytes == pytest.approx(expected.bytes)


def test_a_study_counts_its_own_cost():
    assert cost_of(JobRequest("study", "one"), load_case("job-t"), 3) == Cost()
