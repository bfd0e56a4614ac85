"""The names of ``import valvetrain`` all resolve on first use, a type checker sees them, and each
has an example.
"""

from __future__ import annotations

import ast
import doctest
import importlib
import inspect
import os
import re
import subprocess
import sys

import pytest

import valvetrain
from architecture.layout import DATA_FLOW, PACKAGE, ROOT, tree_of


def test_the_first_line_is_the_data_flow():
    assert (valvetrain.__doc__ or "").splitlines()[0] == DATA_FLOW


@pytest.mark.parametrize("name", valvetrain.__all__)
def test_every_public_name_resolves(name):
    assert getattr(valvetrain, name) is not None
    assert name in dir(valvetrain)


@pytest.mark.parametrize(("name", "home"), sorted(valvetrain._HOMES.items()))
def test_a_public_name_is_the_object_of_its_module(name, home):
    assert getattr(valvetrain, name) is getattr(importlib.import_module(f"valvetrain.{home}"), name)


def test_an_unknown_name_is_refused_with_a_sentence():
    with pytest.raises(AttributeError, match="no name 'SpringDefintion'"):
        _ = valvetrain.SpringDefintion


def test_the_block_for_type_checkers_lists_the_same_names():
    """Every line of the lazy table stands under TYPE_CHECKING too, and nothing else does."""
    blocks = [node for node in tree_of(PACKAGE / "__init__.py").body if isinstance(node, ast.If)]
    imports = [node for block in blocks for node in block.body if isinstance(node, ast.ImportFrom)]
    seen = {
        alias.name: (node.module or "").removeprefix("valvetrain.")
        for node in imports
        for alias in node.names
    }
    assert seen == valvetrain._HOMES
    assert all(alias.asname == alias.name for node in imports for alias in node.names), (
        "only 'import x as x' is a public name"
    )


def test_a_type_checker_sees_every_public_name(tmp_path):
    """mypy knows the type of each name, and that a misspelt one does not exist."""
    names = [name for name in valvetrain.__all__ if name != "__version__"]
    lines = [
        "import valvetrain as vt",
        *(f"reveal_type(vt.{name})" for name in names),
        "vt.load_cse",
    ]
    (tmp_path / "snippet.py").write_text("\n".join(lines), encoding="utf-8")
    # from the root, as `make lint` runs it, whose cache then serves here
    command = [
        sys.executable,
        "-m",
        "mypy",
        "--config-file",
        "pyproject.toml",
        str(tmp_path / "snippet.py"),
    ]
    found = subprocess.run(
        command,
        capture_output=True,
        text=True,
        cwd=ROOT,
        env={**os.environ, "MYPYPATH": str(PACKAGE.parent)},
    )
    types = re.findall(r'note: Revealed type is "(.*)"', found.stdout)
    assert len(types) == len(names), found.stdout + found.stderr
    assert not [
        name
        for name, seen in zip(names, types, strict=True)
        if seen in ("Any", "object", "builtins.object")
    ]
    assert 'Module has no attribute "load_cse"' in found.stdout
    assert found.stdout.count(" error: ") == 1, found.stdout


def examples() -> list[doctest.DocTest]:
    """The examples in the docstrings of all public names and their methods."""
    finder = doctest.DocTestFinder(exclude_empty=True)
    found = []
    for name in valvetrain.__all__[1:]:
        home = importlib.import_module(f"valvetrain.{valvetrain._HOMES[name]}")
        found += [
            test
            for test in finder.find(getattr(valvetrain, name), name, module=home)
            if test.examples
        ]
    return found


FUNCTIONS = [name for name in valvetrain._HOMES if inspect.isfunction(getattr(valvetrain, name))]


def test_public_names_carry_an_example():
    assert not set(valvetrain._HOMES) - {example.name for example in examples()}


@pytest.mark.parametrize("name", FUNCTIONS)
def test_a_public_function_tells_its_arguments_its_errors_and_an_example(name):
    function = getattr(valvetrain, name)
    text = inspect.getdoc(function) or ""
    arguments, _, _ = text.partition("Parameters\n----------\n")[2].partition("\n\n")
    told = {
        word.strip()
        for line in arguments.splitlines()
        if not line.startswith(" ")
        for word in line.partition(" : ")[0].split(",")
    }
    assert told == set(inspect.signature(function).parameters), (
        "every argument stands on a line 'name : what it is, its unit and shape'"
    )
    assert "Raises\n------\n" in text or "Raises nothing" in text
    assert name in {example.name for example in examples()}, "an example is missing"
