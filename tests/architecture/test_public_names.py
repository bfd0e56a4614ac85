"""The names of ``import valvetrain`` all resolve on first use, a type checker sees them, and each
has an example.
"""

from __future__ import annotations

import ast
import doctest
import importlib
import inspect

import pytest
from api_pages import HOMES, object_of

import valvetrain
from architecture.layout import PACKAGE

TOP = [path for path in HOMES if path.count(".") == 1]


def test_the_top_has_few_names():
    assert len(valvetrain.__all__) <= 45
    assert set(TOP) <= {f"valvetrain.{name}" for name in valvetrain.__all__}


@pytest.mark.parametrize("path", HOMES)
def test_a_public_name_is_the_object_of_its_module(path):
    module, _, name = path.rpartition(".")
    assert object_of(path) is getattr(importlib.import_module(HOMES[path]), name)
    assert name in dir(importlib.import_module(module))


@pytest.mark.parametrize(
    ("name", "near"), [("simulat", "simulate"), ("SpringDefintion", "parameters.SpringDefinition")]
)
def test_an_unknown_name_is_answered_with_the_nearest(name, near):
    with pytest.raises(AttributeError, match=f"no name '{name}'; did you mean {near}?"):
        getattr(valvetrain, name)


def typed(node: ast.stmt) -> bool:
    """A class, a function whose arguments and answer are annotated, or an annotated value."""
    if isinstance(node, ast.FunctionDef):
        given = node.args.posonlyargs + node.args.args + node.args.kwonlyargs
        return node.returns is not None and all(argument.annotation for argument in given)
    return isinstance(node, ast.ClassDef | ast.AnnAssign)


def test_a_type_checker_sees_every_public_name():
    """Each stub gives a name on under that name, from the module that defines it with its type, and a
    misspelt one is not let through; ``make lint`` checks the types themselves.
    """
    for stub in PACKAGE.rglob("__init__.pyi"):
        for node in ast.parse(stub.read_text(encoding="utf-8")).body:
            if isinstance(node, ast.ImportFrom):
                assert all(name.asname == name.name for name in node.names), ast.unparse(node)
            else:
                assert isinstance(node, ast.AnnAssign), (stub, ast.unparse(node))
    for path, home in HOMES.items():
        name = path.rpartition(".")[2]
        place = PACKAGE.parent.joinpath(*home.split("."))
        file = place / "__init__.py" if place.is_dir() else place.with_suffix(".py")
        body = ast.parse(file.read_text(encoding="utf-8")).body
        defined = [node for node in body if name in (getattr(node, "name", ""), *targets(node))]
        assert defined and all(map(typed, defined)), (path, home)


def targets(node: ast.stmt) -> list[str]:
    """Names that a statement assigns to."""
    places = [node.target] if isinstance(node, ast.AnnAssign) else getattr(node, "targets", ())
    return [place.id for place in places if isinstance(place, ast.Name)]


def examples() -> list[doctest.DocTest]:
    """The examples in the docstrings of all public names and their methods."""
    finder = doctest.DocTestFinder(exclude_empty=True)
    found = []
    for name, home in HOMES.items():
        module = importlib.import_module(home)
        found += [
            test for test in finder.find(object_of(name), name, module=module) if test.examples
        ]
    return found


FUNCTIONS = [name for name in HOMES if inspect.isfunction(object_of(name))]


def test_public_names_carry_an_example():
    assert not set(HOMES) - {example.name for example in examples()}


@pytest.mark.parametrize("name", FUNCTIONS)
def test_a_public_function_tells_its_arguments_its_errors_and_an_example(name):
    function = object_of(name)
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
