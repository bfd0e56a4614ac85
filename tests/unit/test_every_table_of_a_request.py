"""Unit: in every table of the file of an identification a key that nobody knows is refused by its
place; without it the file is read.
"""

from __future__ import annotations

import pytest

from valvetrain.errors import InputError
from valvetrain.explore.identification_file import parse_request

TEXT = """
case = "job-t"
title = "Own"
description = "words"
[search]
method = "least-squares"
[quantities.wire]
key = "spring.wire_diameter"
prior = "normal"
mean = "4 mm"
standard_deviation = "0.1 mm"
[measurements.tester]
quantity = "preload"
value = "300 N"
scatter = "2 N"
[predictions.peak]
quantity = "peak_spring_force"
engine_speed = "3000 rpm"
"""
TABLES = ("search", "quantities.wire", "measurements.tester", "predictions.peak")


def test_the_file_without_it_is_read(tmp_path):
    request = parse_request(TEXT, "own", tmp_path)
    assert request.title == "Own" and [one.name for one in request.unknowns] == ["wire"]


@pytest.mark.parametrize("key", ["scater", "x", "wire_diameter"])
@pytest.mark.parametrize("table", ["", *TABLES])
def test_a_key_that_nobody_knows_is_refused_where_it_stands(table, key, tmp_path):
    text = (
        TEXT.replace(f"[{table}]\n", f"[{table}]\n{key} = 3\n") if table else f"{key} = 3\n{TEXT}"
    )
    with pytest.raises(InputError, match=key) as refused:
        parse_request(text, "own", tmp_path)
    assert refused.value.where == table


@pytest.mark.parametrize("table", ["nothing", "quantity", "sets"])
def test_a_table_that_nobody_knows_is_refused(table, tmp_path):
    with pytest.raises(InputError, match=table):
        parse_request(f"{TEXT}[{table}]\nkey = 3\n", "own", tmp_path)
