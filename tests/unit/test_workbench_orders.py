"""What the page of a case offers to run, and the words of the command line that a choice becomes.

Evidence: the readers of the command line and of study files take what is asked.
"""

from __future__ import annotations

import pytest
from pydantic import ValidationError

from valvetrain.explore.requests import Study
from valvetrain.parameters.loading import load_case
from valvetrain.runs.cost import Limits
from valvetrain.workbench.pages.orders import KINDS, orders_for
from valvetrain.workbench.requests import REQUESTS, STORED, JobRequest

QUANTITY = {
    "key": "train.lash", "label": "Train: Lash", "unit": "mm", "value": 0.15, "low": 0.1, "high": 0.2,
}  # fmt: skip


def test_every_kind_of_job_is_offered_and_what_it_begins_with_is_a_request():
    train = load_case("tdi-pushrod")
    offered = orders_for(train, [QUANTITY])
    assert {one["kind"] for one in offered["kinds"]} == set(KINDS) == set(REQUESTS)
    for kind, given in offered["given"].items():
        typed = {name: value for name, value in given.items() if value != ""}
        more = {"quantity": "train.lash"} if kind == "study" else {}
        request = JobRequest(kind, "tdi-pushrod", typed | more).read(train)
        assert request.command == kind
        assert getattr(request, "spring_sets", ("stock",)) == ("stock",)


def test_a_choice_of_an_earlier_job_is_offered_again():
    earlier = [JobRequest("run", "c", {"spring_sets": [name]}) for name in ("performance", "stock")]
    given = orders_for(load_case("tdi-pushrod"), [], earlier)["given"]
    assert given["run"]["spring_sets"] == ["performance"]


def test_every_field_reaches_the_command_line():
    given = {
        "spring_sets": ["stock", "performance"],
        "resolution": "5 rpm",
        "ranges": False,
        "implausible": True,
    }
    words = JobRequest("sweep", "c", given).command_line("case.toml", 1, Limits(1.0, 1e6), "")
    assert words[5:] == [
        "--spring-set=stock", "--spring-set=performance", "--resolution=5 rpm", "--no-ranges", "--implausible", "--", "case.toml",
    ]  # fmt: skip


def test_a_quantity_of_the_form_reaches_the_study_file(tmp_path):
    train = load_case("tdi-pushrod")
    fields = {one["kind"]: one["fields"] for one in orders_for(train, [QUANTITY])["kinds"]}["study"]
    (_, varied) = next(one["choices"] for one in fields if one["name"] == "quantity")
    assert varied["sets"] == {"lowest": "0.12 mm", "highest": "0.18 mm"}
    given = {
        "quantity": "train.lash",
        **varied["sets"],
        "points": "3",
        "spring_sets": ["performance"],
    }
    request = JobRequest("study", "tdi-pushrod", given).read(train)
    path = tmp_path / "study.toml"
    path.write_text(request.file_text("tdi-pushrod"), encoding="utf-8")
    plan = Study.read({"file": path}).plan
    assert {chosen for _, _, chosen in plan.runs} == {"performance"}


@pytest.mark.parametrize(
    "given", [{"models": 64}, {"models": {"a": "b"}}, "models", [["models", 1]]]
)
def test_what_no_page_sends_is_never_stored(given):
    """It would be read back when its job is due, and no other job would start."""
    with pytest.raises(ValidationError):
        STORED.validate_python({"kind": "run", "case": "c", "given": given})
