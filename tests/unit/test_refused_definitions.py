"""What a study or optimisation file cannot say: each slip is refused in one line at its key."""

from __future__ import annotations

from pathlib import Path

import pytest

import valvetrain as vt
from unit.test_optimum_refusals import FILE, plan_of
from valvetrain.explore.files import FileText
from valvetrain.explore.study import StudyModel, read_plan

OBJECTIVE = FILE[FILE.index("[[objective]]") : FILE.index("[[constraint]]")]
LIMIT = """[[objective]]
limit_speed = { quantity = "clash_energy", at_most = "5 mJ", engine_speeds = "5000:9000:500 rpm" }
direction = "maximise"
"""
TOLERANCES = Path(__file__).parents[2] / "examples" / "studies" / "beehive-tolerances.toml"


def study_of(text: str):
    return read_plan(FileText(text, "study.toml", Path(), StudyModel))


#: Kind of file -> its reader, and a text that it takes.
TAKEN = {
    "search": (plan_of, FILE),
    "limit": (plan_of, FILE.replace(OBJECTIVE, LIMIT)),
    "study": (study_of, TOLERANCES.read_text(encoding="utf-8")),
}
CASE, KEY = 'case = "gu2021-beehive-blind"', 'key = "spring.wire_diameter"'
RANGE, TOLERANCE = 'low = "3.5 mm"\nhigh = "4.1 mm"', 'tolerance = "0.02 mm"'
#: Kind of file, what is replaced, by what, and the key that is refused.
REFUSED = [
    ("search", 'direction = "minimise"', "", "objective.0.direction"),
    ("search", 'direction = "minimise"', 'direction = "down"', "objective.0.direction"),
    ("search", 'quantity = "peak_spring_force"', 'quantity = "peak_force"', "objective.0.quantity"),
    ("search", 'quantity = "peak_spring_force"', "", "objective.0"),
    ("search", OBJECTIVE, OBJECTIVE * 2, "objective"),
    ("search", 'at_least = "1.0 x case"', "", "constraint.0"),
    ("search", 'at_least = "1.0 x case"', 'at_least = "200 mm"', "constraint.0.at_least"),
    ("search", 'at_least = "1.0 x case"', "at_least = 200", "constraint.0.at_least"),
    ("search", 'at_least = "1.0 x case"', 'at_least = "1.0 x csae"', "constraint.0.at_least"),
    ("search", '"preload"', '"preload"\nengine_speeds = "8000 rpm"', "constraint.0.engine_speeds"),
    ("search", RANGE, 'mean = "3.8 mm"\nstandard_deviation = "0.1 mm"', "vary.0"),
    ("search", KEY, 'key = "engine_speed"', "vary.0"),
    ("search", f"{KEY}\n{RANGE}", 'key = "engine_speed"\nlow = "3000 rpm"\nhigh = "4000 rpm"', "vary.0.key"),
    ("search", "trials = 8", "trials = 0", "search.trials"),
    ("search", "trials = 8", "trials = 8\nmethod = 'cma-es'", "search.method"),
    ("search", "trials = 8", "trials = 8\nmethod = 'nsga2'\nper_round = 2", "search.per_round"),
    ("search", "trials = 8", "trials = 8\nlocal = 1.5", "search.local"),
    ("search", CASE, f"{CASE}\nconfirm = ['wave-rods']", "confirm.0"),
    ("search", "[search]", "confirm = 3\n[search]", "vary.0.confirm"),
    ("search", CASE, f'{CASE}\nspring_sets = ["stock"]', "spring_sets"),
    ("search", CASE, f'{CASE}\nspring_models = "chain"', "spring_models.0"),
    ("search", CASE, 'case = "gu2021-behive"', "case"),
    ("search", CASE, f"{CASE}\nconfirm = 3", "confirm"),
    ("search", CASE, f"{CASE}\nobjectives = 3", "objectives"),
    ("limit", 'at_most = "5 mJ", ', "", "objective.0.limit_speed"),
    ("limit", 'at_most = "5 mJ"', 'at_most = "5 mJ", at_least = "1 mJ"', "objective.0.limit_speed"),
    ("limit", 'at_most = "5 mJ"', 'at_most = "5 mm"', "objective.0.limit_speed"),
    ("limit", "clash_energy", "preload", "objective.0.limit_speed"),
    ("limit", "clash_energy", "clash_energie", "objective.0.limit_speed"),
    ("limit", "5000:9000:500 rpm", "5000 rpm", "objective.0.limit_speed"),
    ("limit", "500 rpm\"", '500 rpm", resolution = "0 rpm"', "objective.0.limit_speed"),
    ("limit", '"maximise"', '"maximise"\nengine_speeds = "4000 rpm"', "objective.0.engine_speeds"),
    ("limit", '"maximise"', '"maximise"\nquantity = "clash_count"', "objective.0"),
    ("study", 'sampler = "saltelli"', 'sampler = "saltely"', "points.sampler"),
    ("study", 'outputs = ["peak_spring_force"', 'outputs = ["peak_spring_forc"', "outputs"),
    ("study", CASE, 'case = "gu2021-beehiv"', "case"),
    ("study", TOLERANCE, 'tolerance = "0.02 N"', "vary.0"),
    ("study", TOLERANCE, f'{TOLERANCE}\nlow = "1 mm"\nvalues = "1 mm"', "vary.0"),
    ("study", TOLERANCE, "", "vary.0"),
    ("study", TOLERANCE, f'{TOLERANCE}\nlow = "1 mm"', "vary.0.low"),
    ("study", TOLERANCE, f'{TOLERANCE}\nfactor = 2', "vary.0.factor"),
    ("study", TOLERANCE, 'values = "3.8, 3.9 mm"\nhigh = "4 mm"', "vary.0.high"),
    ("search", RANGE, f'{RANGE}\nshape = "uniform"', "vary.0.shape"),
    ("study", TOLERANCE, 'tolerence = "0.02 mm"', "vary.0.tolerence"),
    ("study", KEY, 'key = "spring.wire_diametre"', "vary.0"),
    ("study", 'key = "spring.precompression"', KEY, "vary"),
    ("study", "count = 640", "cuont = 640", "points"),
    ("study", 'as = "factor"', 'as = "times"', "vary.2.as"),
    ("study", 'engine_speeds = "8000 rpm"', 'engine_speeds = "8000 mm"', "engine_speeds"),
    ("study", '["multi-mass"]', '["multimass"]', "spring_models.0"),
]  # fmt: skip


@pytest.mark.parametrize(("kind", "old", "new", "key"), REFUSED)
def test_a_slip_is_refused_at_its_key(kind, old, new, key):
    read, text = TAKEN[kind]
    assert old in text
    with pytest.raises(vt.InputError) as refused:
        read(text.replace(old, new, 1))
    assert refused.value.where.split(", ")[-1] == key and "\n" not in str(refused.value)
