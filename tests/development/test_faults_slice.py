"""A slice of ``make faults``: damaged cases, measurements and results end in an answer or one
sentence, and what does not is noticed.
"""

from __future__ import annotations

import pytest
from faults import inputs, questions, results
from faults.apart import FILES, asked_apart, chance_of, elsewhere, warm

from package_watch import callables, replaced
from valvetrain.errors import InputError
from valvetrain.solution import atomic, netcdf

SLICE = {"cases": 16, "runs": 2, "measurements": 4, "results": 10}
SEED = 20


@pytest.fixture(scope="module", autouse=True)
def loaded():
    """Forks of this process have what was loaded here."""
    warm()


@pytest.mark.slow  # every input is read and built, some are run
@pytest.mark.parametrize("kind", FILES)
def test_every_input_ends_in_an_answer(kind):
    answers = [asked_apart(kind, SEED, number) for number in range(SLICE[kind])]
    assert not [broken for _, broken in answers if broken]
    assert {word for word, _ in answers} <= {"answered", "refused", "failed"}


@pytest.mark.parametrize("kind", FILES)
def test_the_same_seed_makes_the_same_input(kind):
    make = FILES[kind][0]
    inputs_made = [make(chance_of(kind, SEED, number)) for number in (1, 1, 2)]
    assert inputs_made[0] == inputs_made[1] != inputs_made[2]


def test_most_mutants_differ_from_every_shipped_case():
    shipped = {inputs.case_text(tree) for tree in inputs.cases().values()}
    made = {inputs.case_mutant(chance_of("cases", SEED, number)) for number in range(40)}
    assert len(made - shipped) > 30


def test_the_questions_notice_what_they_should(monkeypatch):
    """A reader that takes damage for data, and a refusal of many lines."""
    whole = results.whole()["multi-mass-*.nc"]

    def ask(place):
        body = whole[:place] + bytes([whole[place] ^ 1]) + whole[place + 1 :]
        with elsewhere():
            return results.ask(b"multi-mass-*.nc damaged\n" + body)

    assert ask(5000) == "refused"
    for module in (netcdf, atomic):
        monkeypatch.setattr(module, "checked_content", lambda path: (path.read_bytes(), True))
    with elsewhere() as folder:
        (folder / "whole.nc").write_bytes(whole)
        force = netcdf.load_netcdf(folder / "whole.nc").channel("seat_force")
    # One bit of one number: damage of the structure may keep the library for ever.
    place = whole.find(force[len(force) // 2 :][:1].tobytes())
    assert place > 0
    with pytest.raises(questions.Finding):
        ask(place)
    error = InputError("one")
    error.args = ("one\nline and another",)
    with pytest.raises(questions.Finding):
        questions.refused(error)


def test_what_ends_or_never_ends_is_broken(monkeypatch):
    """A process that ends at an input, and an error that is no sentence."""

    def fails(content):
        raise KeyError("x")

    for question in (lambda content: 1 // len(content[:0]), fails, lambda content: __import__("os")._exit(3)):  # fmt: skip
        monkeypatch.setitem(FILES, "cases", (inputs.case_mutant, question))
        assert asked_apart("cases", SEED, 1)[1]


def test_the_package_is_left_as_it_was():
    """Tests of processes that ran after it in one worker failed."""
    before = callables()
    with elsewhere():
        assert (
            results.ask(b"modes-*.nc damaged\n" + results.whole()["modes-*.nc"][:3000]) == "refused"
        )
    assert not replaced(before) and not replaced({})
