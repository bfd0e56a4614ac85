"""Names of any kind: files beside a case, tests over a run, cases and what a job writes of them;
none takes the place of another.

Evidence: what stands on disk afterwards, drawn names and bytes, the contract of HTTP.
"""

from __future__ import annotations

import pytest

from valvetrain.workbench import saved_runs as saved_tests
from valvetrain.workbench.saved_runs import keep_test, remove_test, saved_name
from valvetrain.workbench.store import checked_name
from valvetrain.workbench.workspace import Workspace
from workbench_parts import kept


@pytest.fixture
def workspace(tmp_path):
    return Workspace(tmp_path / "bench")


def test_two_tests_never_take_the_place_of_each_other(workspace):
    """Their names differ beyond what a name here may hold, or in what is left out of it."""
    stem = "2027-03-14-head3-beehive-production-batch-A-cycles-at"
    pairs = [
        (f"{stem}-5600-rpm.csv", f"{stem}-5800-rpm.csv"),
        ("a b.csv", "a(b.csv"),
        ("a..b.csv", "a.b.csv"),
        ("-a.csv", "a.csv"),
        ("a.csv\u0301", "a.csv"),
        ("a." + "x" * 20, "a." + "x" * 21),
        ("\u00e9.csv", "e\u0301.csv"),
    ]
    run = workspace.run(kept(workspace))
    for one, other in pairs:
        names = [keep_test(run, one, b"1").name, keep_test(run, other, b"22").name]
        assert (
            len({checked_name(name) for name in names}) == 2
            and len(saved_tests.saved_tests(run)) == 2
        )
        assert (
            keep_test(run, one, b"333").name == names[0] and len(saved_tests.saved_tests(run)) == 2
        )
        assert {test.size for test in saved_tests.saved_tests(run)} == {2, 3}
        for name in names:
            remove_test(run, name)
    assert saved_name("cycles-2.nc") == "cycles-2.nc" and saved_name(
        f"{stem}-5600-rpm.csv"
    ).endswith(".csv")
