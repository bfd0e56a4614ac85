"""Property: whatever an identification file says, reading it gives an identification or one
sentence with its place, nothing else.
"""

from __future__ import annotations

import copy
import json
import math
from pathlib import Path
from typing import Any

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from architecture.layout import ROOT
from study_parts import identification_plan
from valvetrain.errors import MAX_LOCATION_LENGTH, MAX_SENTENCE_LENGTH, InputError
from valvetrain.explore.distributions import Prior
from valvetrain.explore.requests import Identify
from valvetrain.parameters.toml_text import toml_text

PLAIN: dict[str, Any] = {
    "case": "job-t",
    "search": {"method": "nested"},
    "quantities": {
        "wire": {"key": "spring.wire_diameter", "prior": "normal", "mean": "4.0 mm", "standard_deviation": "0.1 mm", "low": "3.5 mm"},
        "damping": {"key": "spring.damping.stiffness_damping", "prior": "lognormal", "median": "12 us", "factor": 1.5},
        "pitch": {"key": "spring.pitch", "as": "factor", "prior": "uniform", "low": 0.9, "high": 1.1},
    },
    "measurements": {
        "seat": {"quantity": "preload", "value": "212 N", "scatter": "1 %"},
        "curve": {"compressions": "4, 8 mm", "forces": "120, 240 N", "scatter": "2 N"},
        "ringing": {"frequencies": "400, 800 Hz", "scatter": "5 Hz"},
        "peak": {"quantity": "peak_spring_force", "value": "548 N", "scatter": "5 N", "engine_speed": "3000 rpm",
                 "spring_model": "multi-mass"},
        "angle": {"quantity": "peak_spring_force_cam_angle", "value": "90 deg", "scatter": "1 deg", "engine_speed": "3000 rpm", "fit": False},
    },
    "predictions": {"rate": {"quantity": "installed_rate"}},
}  # fmt: skip


def read(tree: dict[str, Any]) -> Any:
    return identification_plan(toml_text(tree), "test", Path())


def test_the_plain_file_reads_as_it_is_meant() -> None:
    request = read(PLAIN)
    wire, damping, pitch = (one.prior for one in request.unknowns)
    assert wire == Prior("normal", 3.5e-3, centre=4e-3, spread=wire.spread)
    assert wire.spread == pytest.approx(1e-4)
    assert damping.spread == pytest.approx(math.log(1.5)) and (pitch.low, pitch.high) == (0.9, 1.1)
    assert request.unknowns[2].operation == "factor"
    data = {datum.key: datum for datum in request.data}
    assert data["preload"].scatter == pytest.approx(2.12)
    assert data["force at 8 mm"].value == 240.0 and data["mode_2_frequency"].value == 800.0
    assert data["3000 rpm, multi-mass: peak_spring_force"].value == 548.0
    assert not data["3000 rpm: peak_spring_force_cam_angle"].used


def test_tables_beside_the_file_are_read_with_their_units(tmp_path: Path) -> None:
    (tmp_path / "curve.csv").write_text("compression [inch],load [lbf]\n0.1,20\n0.2,40\n")
    tree = copy.deepcopy(PLAIN)
    tree["measurements"] = {"curve": {"file": "curve.csv", "scatter": "1 lbf"}}
    request = identification_plan(toml_text(tree), "test", tmp_path)
    assert [one.at for one in request.fitted.targets if one.kind == "force"] == pytest.approx(
        [2.54e-3, 5.08e-3]
    )
    assert [datum.value for datum in request.data] == pytest.approx([88.96443, 177.92886])
    (tmp_path / "curve.csv").write_text("compression,load\n1,20\n2,40\n")
    with pytest.raises(InputError, match="does not say the unit"):
        identification_plan(toml_text(tree), "test", tmp_path)


REFUSED = [
    (("predictions", "rate", "quantity"), "strength"),
    (("predictions", "rate", "value"), "3 N/mm"),
    (("case",), "job-tt"),
    (("case",), None),
    (("metod",), "nested"),
    (("search", "method"), "nestd"),
    (("search", "seed"), -1),
    (("search", "lanes"), 1.5),
    (("evaluator",), "gu2020"),
    (("options",), {"elements_per_coil": 12}),
    (("quantities",), {}),
    (("quantities", "wire", "key"), None),
    (("quantities", "wire", "prior"), "gaussian"),
    (("quantities", "wire", "as"), "ratio"),
    (("quantities", "wire", "mean"), None),
    (("quantities", "wire", "standard_deviation"), "0.1 N"),
    (("quantities", "wire", "standard_deviation"), "0 mm"),
    (("quantities", "wire", "low"), "5 mm"),
    (("quantities", "pitch", "low"), "1 mm"),
    (("quantities", "damping", "factor"), 0.5),
    (("quantities", "wire", "center"), 1),
    (("measurements",), {}),
    (("measurements", "seat", "quantity"), None),
    (("measurements", "seat", "quantity"), "strength"),
    (("measurements", "seat", "value"), "212 mm"),
    (("measurements", "seat", "scatter"), None),
    (("measurements", "seat", "scatter"), "0 %"),
    (("measurements", "curve", "forces"), "120 N"),
    (("measurements", "curve", "compressions"), "4, 4 mm"),
    (("measurements", "peak", "quantity"), "preloads"),
    (("measurements", "peak", "engine_speed"), "-3 rpm"),
    (("measurements", "angle", "fit"), "no"),
    (("measurements", "ringing", "first_mode"), 0),
    (("measurements", "seating"), {"event": "seating", "cam_angle": "180 deg", "scatter": "1 deg"}),
]


@pytest.mark.parametrize(
    ("path", "value"),
    REFUSED,
    ids=lambda one: ".".join(one) if isinstance(one, tuple) else None,
)
def test_what_is_wrong_is_refused_in_one_sentence_with_its_place(
    path: tuple[str, ...], value: Any
) -> None:
    tree = copy.deepcopy(PLAIN)
    holder = tree
    for key in path[:-1]:
        holder = holder[key]
    if value is None:
        del holder[path[-1]]
    else:
        holder[path[-1]] = value
    with pytest.raises(InputError) as found:
        read(tree)
    place = "vary" if path == ("quantities",) else ".".join(path[:2])
    assert found.value.where.startswith("test") and place in found.value.where, found.value
    assert "\n" not in str(found.value)


_LEAVES = st.one_of(
    st.none(),
    st.booleans(),
    st.integers(-(2**40), 2**40),
    st.floats(),
    st.text(max_size=12),
    st.sampled_from(
        ["1 mm", "-3 N", "2 %", "1e400 N", "nan", "4, 8 mm", "4200 rpm", "uniform", "../x", ""]
    ),
    st.lists(st.integers(0, 3), max_size=3),
    st.dictionaries(st.sampled_from(["a", "key", "prior", "file"]), st.integers(), max_size=2),
)


def places(tree: dict[str, Any], path: tuple[str, ...] = ()) -> list[tuple[str, ...]]:
    return [
        found
        for key, value in tree.items()
        for found in [
            (*path, key),
            *(places(value, (*path, key)) if isinstance(value, dict) else []),
        ]
    ]


@settings(max_examples=150, deadline=None, suppress_health_check=[HealthCheck.too_slow])
@given(
    path=st.sampled_from(places(PLAIN)),
    value=_LEAVES,
    name=st.sampled_from(["", "low", "extra", "file", "engine_speed"]),
)
def test_any_value_at_any_place_is_read_or_refused_in_one_sentence(
    path: tuple[str, ...], value: Any, name: str
) -> None:
    tree = copy.deepcopy(PLAIN)
    holder = tree
    for key in path[:-1]:
        holder = holder[key]
    if value is None:
        del holder[path[-1]]
    else:
        holder[name or path[-1]] = value
    try:
        request = read(tree)
    except InputError as error:
        assert (
            str(error).isprintable()
            and len(str(error)) <= MAX_SENTENCE_LENGTH + MAX_LOCATION_LENGTH + 2
        )
    else:
        assert request.unknowns and request.data


@settings(max_examples=60, deadline=None)
@given(
    text=st.one_of(
        st.text(max_size=200),
        st.binary(max_size=200).map(lambda content: content.decode("latin-1")),
    )
)
def test_any_text_is_read_or_refused(text: str) -> None:
    with pytest.raises(InputError):
        identification_plan(text, "test", Path())


@pytest.mark.parametrize(
    "name", sorted(path.name for path in (ROOT / "examples").glob("identify-*.toml"))
)
def test_the_examples_read(name: str) -> None:
    request = Identify.read({"file": ROOT / "examples" / name}).plan
    assert request.unknowns and all(one.prior.source or one.prior.flat for one in request.unknowns)
    assert json.dumps(request.title)
