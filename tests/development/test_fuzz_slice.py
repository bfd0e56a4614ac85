"""A slice of the fuzzer (``make fuzz``): seeded mutants of cases, runs of mutants and damaged files
end in an answer or one sentence.
"""

from __future__ import annotations

import os
import random
import subprocess
import sys

import pytest
from fuzz import files, runs, trees
from fuzz.questions import KINDS, Finding
from fuzz.worker import generator, write

from package_watch import callables, replaced

SLICE = {"cases": 80, "runs": 2, "files": 30}
SEED = 20


@pytest.mark.slow  # every input is read and built, some are run
@pytest.mark.parametrize("kind", sorted(KINDS))
def test_every_input_ends_in_an_answer(kind):
    make, ask = KINDS[kind]
    answers = [ask(make(generator(kind, SEED, number))) for number in range(SLICE[kind])]
    assert set(answers) <= {
        "accepted",
        "refused",
        "read",
        "completed",
        "failed in time",
        "too long",
    }
    assert len(set(answers)) > 1 or kind == "runs"


def test_time_used_is_that_of_one_thread():
    """Waiting threads of linear algebra made 32 s of a mutant (seed 90411, number 130) that takes 2."""
    free = {name: value for name, value in os.environ.items() if "NUM_THREADS" not in name}
    code = "import fuzz.worker, numpy, threadpoolctl as t; print(max(one['num_threads'] for one in t.threadpool_info()))"
    done = subprocess.run(
        [sys.executable, "-c", code], env=free, capture_output=True, text=True, check=True
    )
    assert done.stdout.strip() == "1"


@pytest.mark.parametrize("make", [trees.case_mutant, files.make], ids=["cases", "files"])
def test_the_same_seed_makes_the_same_input(make):
    assert make(random.Random("a 1")) == make(random.Random("a 1")) != make(random.Random("a 2"))


def test_most_mutants_differ_from_every_shipped_case():
    shipped = {text.encode() for text in trees.texts().values()}
    made = [trees.case_mutant(generator("cases", SEED, number)) for number in range(40)]
    assert len(set(made)) == len(made) and not shipped & set(made)


def test_the_questions_notice_what_they_should(monkeypatch, tmp_path):
    """A reader that fails with another error, one that takes damage for data, and a refusal of many
    lines are findings.
    """
    from valvetrain.errors import InputError
    from valvetrain.parameters import loading
    from valvetrain.solution import atomic as checksum
    from valvetrain.solution import netcdf

    def fails(*given, **named):
        raise KeyError("x")

    monkeypatch.setattr(loading, "parse_case", fails)
    with pytest.raises(KeyError):
        KINDS["cases"][1](b"x = 1")
    monkeypatch.undo()
    whole = files.whole()["solution.nc"]
    assert (
        KINDS["files"][1](
            b"solution.nc damaged\n" + whole[:5000] + bytes([whole[5000] ^ 1]) + whole[5001:]
        )
        == "refused"
    )
    monkeypatch.setattr(netcdf, "checked_content", lambda path: (path.read_bytes(), True))
    monkeypatch.setattr(checksum, "checked_content", lambda path: (path.read_bytes(), True))
    # One bit of one number: damage of the structure may keep the library for ever, unguarded as it is here.
    (tmp_path / "whole.nc").write_bytes(whole)
    force = netcdf.load_netcdf(tmp_path / "whole.nc").channel("seat_force")
    place = whole.find(force[len(force) // 2 :][:1].tobytes())
    assert place > 0
    with pytest.raises(Finding):
        KINDS["files"][1](
            b"solution.nc damaged\n"
            + whole[:place]
            + bytes([whole[place] ^ 1])
            + whole[place + 1 :]
        )
    error = InputError("one")
    error.args = ("one\nline and another",)
    with pytest.raises(Finding):
        from fuzz.questions import sentence

        sentence(error)


def test_the_fuzzer_leaves_the_package_as_it_was():
    """Where it replaced the process of a trial for good, tests of such processes that ran after it
    in one worker failed.
    """
    before = callables()
    assert files.ask(b"modes.nc damaged\n" + files.whole()["modes.nc"][:3000]) == "refused"
    assert not replaced(before) and not replaced({})


def test_a_finding_is_kept_with_what_reproduces_it(tmp_path):
    content = trees.case_mutant(generator("cases", SEED, 1))
    write(tmp_path, "cases", SEED, 1, content, "what was said")
    assert (tmp_path / f"cases-{SEED}-1.input").read_bytes() == content
    assert trees.case_mutant(generator("cases", SEED, 1)) == content


def test_runs_are_made_of_short_cases():
    assert {tree.get("operation", {}).get("cycles", 1) for tree in runs.short_cases().values()} == {
        1
    }
