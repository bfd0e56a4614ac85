"""What the page of a case offers to run, and the words of the command line that a choice becomes.

Evidence: the readers of the command line and of study files take what is asked.
"""

from __future__ import annotations

import pytest

from valvetrain.cli.options import read_names
from valvetrain.errors import InputError
from valvetrain.explore.requests import Study
from valvetrain.parameters.loading import load_case
from valvetrain.runs.cost import Limits
from valvetrain.workbench.pages.orders import request_of
from valvetrain.workbench.requests import (
    check_request,
    command_arguments,
    study_text,
)

WISH = {"kind": "run", "models": ["massless"], "speeds": "2000 rpm"}
STUDY = WISH | {
    "kind": "study",
    "key": "train.lash",
    "low": "0.1 mm",
    "high": "0.2 mm",
    "points": 3,
    "output": "preload",
}


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
    assert {chosen for _, _, chosen in Study.read({"file": path}).plan.runs} == {"performance"}
    with pytest.raises(InputError, match="no spring set is chosen"):
        request_of("tdi-pushrod", STUDY | {"sets": []})
