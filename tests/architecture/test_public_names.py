"""The names of ``import valvetrain`` all resolve, on first use."""

from __future__ import annotations

import importlib

import pytest

import valvetrain
from architecture.house import DATA_FLOW


def test_the_first_line_is_the_data_flow():
    assert (valvetrain.__doc__ or "").splitlines()[0] == DATA_FLOW


@pytest.mark.parametrize("name", valvetrain.__all__)
def test_every_public_name_resolves(name):
    assert getattr(valvetrain, name) is not None
    assert name in dir(valvetrain)


@pytest.mark.parametrize(("name", "home"), sorted(valvetrain._HOMES.items()))
def test_a_public_name_is_the_object_of_its_room(name, home):
    assert getattr(valvetrain, name) is getattr(importlib.import_module(f"valvetrain.{home}"), name)


def test_an_unknown_name_is_refused_with_a_sentence():
    with pytest.raises(AttributeError, match="no name 'SpringDefintion'"):
        _ = valvetrain.SpringDefintion
