"""``check`` builds all that ``run`` builds: it passes where, and only where, a run gets as far as
time integration or statics.
"""

from __future__ import annotations

import pytest

import valvetrain as vt
from valvetrain.cli.cases import put_together
from valvetrain.errors import InputError
from valvetrain.parameters.loading import library_names, load_case
from valvetrain.runs.api import simulate

FINITE = "spring.options.finite-element"
#: Case, what is changed in it, and a word of the refusal (empty where nothing is wrong).
MUTANTS = [
    *((name, {}, "") for name in library_names()),
    ("job-t", {f"{FINITE}.elements_per_coil": 4}, "8 or more"),
    ("job-t", {f"{FINITE}.elements_per_coil": 400}, "exceed"),
    ("job-t", {f"{FINITE}.elements_per_coil": 8}, ""),
    ("uniform-spring", {f"{FINITE}.elements_per_coil": 4}, "8 or more"),
    ("uniform-spring", {"operation.engine_speeds": "4000 rpm"}, "no lift law"),
    ("job-t", {"sources": ["nobody1999"]}, ""),
    ("job-t", {"lift_law.maximum_lift": "40 mm"}, "solid"),
    ("job-t", {"spring.precompression": "40 mm"}, "solid"),
    ("job-t", {"spring.material": {"density": "-1 kg/m^3", "name": "OTEVA 90 SC"}}, "density"),
    ("job-t", {"lift_law.maximum_lift": "1e300 m"}, ""),
    ("tdi-pushrod", {"train.lash": "120 mm"}, "lash"),
    ("tdi-pushrod", {"train.spring_model": "nobody"}, "unknown"),
    ("tdi-pushrod", {"train.lever.drive_arm": "1e200 m"}, ""),
    ("tdi-pushrod", {"train.cam.base_radius": "1 mm"}, ""),
    ("tdi-pushrod", {"train.contacts.cam.contact_stiffness": "1e300 N/mm"}, ""),
]


class ReachedError(BaseException):
    """The run has everything built."""


def reached(*given, **named):
    """Stands in the place of what takes time."""
    raise ReachedError


def meshed(rod, *given, **named):
    """As :func:`reached`, of a static curve, whose first point needs the mesh."""
    assert rod.mesh.elements
    raise ReachedError


def outcome(function, *given, **named) -> str:
    """The sentence of a refusal, empty where there was none."""
    try:
        function(*given, **named)
    except InputError as error:
        return str(error)
    except ReachedError:
        return ""
    return ""


@pytest.mark.parametrize(
    ("name", "changes", "words"),
    MUTANTS,
    ids=lambda part: part if isinstance(part, str) else "-".join(part),
)
def test_check_refuses_what_run_refuses(name, changes, words, monkeypatch):
    checked = outcome(lambda: put_together(load_case(name, changes), ()))
    monkeypatch.setattr("valvetrain.runs.prepared.run_to_orbit", reached)
    monkeypatch.setattr("valvetrain.runs.statics.curve_over", meshed)
    ran = outcome(lambda: refused_by_all(load_case(name, changes)))
    assert bool(checked) == bool(ran), (checked, ran)
    assert words in checked and checked.isprintable() and len(checked) < 800
    assert bool(words) <= bool(checked)


def refused_by_all(case) -> None:
    """Run; a study none of whose members could be integrated counts as refused."""
    study = simulate(case, workers=1)
    if study.solutions and all(run.status.code == "refused" for run in study.solutions):
        raise InputError(study.solutions[0].status.message)


def hexadecimal(digits: int) -> str:
    return f"[spring]\nwire_diameter = 0x{'f' * digits}\ntotal_coils = 5\n"


@pytest.mark.parametrize("digits", [17, 300, 4300, 6000])
def test_whole_numbers_of_more_than_64_bits_are_refused_in_a_sentence(digits, tmp_path):
    path = tmp_path / "case.toml"
    path.write_text(hexadecimal(digits), encoding="utf-8")
    with pytest.raises(InputError, match=r"spring\.wire_diameter.*64 bits"):
        load_case(path)


@pytest.mark.parametrize(
    "changes",
    [
        {"spring.wire_diameter": "1e1000 mm"},
        {"spring.wire_diameter": 10**5000},
        {"spring.total_coils": "1e-300"},
        {"spring.mean_diameter": "1e-300 mm"},
        {"lift_law.power": 10**400},
        {"spring.contact.stiffness": "1e308 N/mm/mm"},
    ],
    ids=lambda changes: next(iter(changes)),
)
def test_numbers_beyond_all_measure_end_in_a_sentence_or_are_used(changes):
    said = outcome(lambda: put_together(load_case("job-t", changes), ()))
    assert said.isprintable() and len(said) < 800


def test_a_refusal_is_one_printable_line_whatever_was_written():
    error = InputError("a\nb\x1b[2J" + "x" * 5000, "where\u202e" + "y" * 5000)
    assert str(error).isprintable() and len(str(error)) < 1100
    assert error.reason.startswith("a b?[2Jx")


def test_check_and_run_up_refuse_the_nonsense_that_run_refuses(tmp_path):
    """A follower whose guide rubs with 1e9 N: refused by each of them, and passed where asked."""
    changes = {"train.valve.friction": "1e9 N"}
    case = load_case("tdi-pushrod", changes)
    for ask in (
        lambda: put_together(case, ()),
        lambda: vt.run_up(case, 200.0, 260.0, 0.2),
        lambda: simulate(case, workers=1),
    ):
        with pytest.raises(InputError, match=r"train\.valve\.friction"):
            ask()
    assert put_together(case, (), implausible=True) is not None


@pytest.mark.parametrize("model", ["solid", "nosuch"])
def test_what_a_spring_model_that_is_asked_for_refuses_is_told(model):
    """Solids need a wire, and what is no model is none, whatever the case's own models are."""
    case = load_case("tdi-pushrod" if model == "solid" else "job-t")
    assert put_together(case, ()) is not None and put_together(case, ("massless",)) is not None
    with pytest.raises(
        InputError, match="need its wire" if model == "solid" else "'nosuch' is unknown"
    ) as refused:
        put_together(case, (model,))
    assert refused.value.where == "models"
