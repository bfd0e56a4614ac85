"""The faults: small changes of a source file that a person could make and that change what it does.

Each is found on the syntax tree and made in the text, so that all other lines stay as they are.
What cannot be seen in a result is no
site: docstrings, annotations, names of types, decorators, imports, words of errors, help texts, and
arguments that only steer Python
(`SILENT`).
"""

from __future__ import annotations

import ast
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path

from mutants.words import SILENT, SWAPPED_CALLS, UNITS, vocabulary

OPERATORS: dict[type, tuple[str, str]] = {
    ast.Add: ("+", "-"), ast.Sub: ("-", "+"), ast.Mult: ("*", "/"), ast.Div: ("/", "*"), ast.Pow: ("**", "*"), ast.BitOr: ("|", "&"),
}  # fmt: skip
#: Turned round, not moved to their edge: `<` for `<=` of floats changes nothing that can be met.
COMPARISONS: dict[type, tuple[str, str]] = {
    ast.Lt: ("<", ">"), ast.Gt: (">", "<"), ast.LtE: ("<=", ">="), ast.GtE: (">=", "<="), ast.Eq: ("==", "!="), ast.NotEq: ("!=", "=="),
    ast.In: ("in", "not in"), ast.NotIn: ("not in", "in"), ast.Is: ("is", "is not"), ast.IsNot: ("is not", "is"),
}  # fmt: skip
SCALES = (1e3, 1e-3, 1e6, 1e-6, 1e9, 1000, 1e2, 100)
#: Whole numbers from here on are counts of samples and bounds: one more or less of them is met by
#: nothing.
LARGE_COUNT = 1000


@dataclass(frozen=True)
class Fault:
    """One change: the characters ``start`` to ``end`` of a file become ``text``."""

    file: str
    line: int
    start: int
    end: int
    text: str
    kind: str


class Source:
    """A file, its tree, and places in its text."""

    def __init__(self, root: Path, file: str) -> None:
        self.file, self.text = file, (root / file).read_text(encoding="utf-8")
        self.tree = ast.parse(self.text)
        self.starts = [0]
        for line in self.text.splitlines(keepends=True):
            self.starts.append(self.starts[-1] + len(line))
        self.lines = self.text.splitlines()

    def place(self, line: int, column: int) -> int:
        """Place in the text of a line and a column in bytes, as the tree counts them."""
        return self.starts[line - 1] + len(self.lines[line - 1].encode()[:column].decode())

    def span(self, node: ast.AST) -> tuple[int, int]:
        return self.place(node.lineno, node.col_offset), self.place(  # type: ignore[attr-defined]
            node.end_lineno,  # type: ignore[attr-defined]
            node.end_col_offset,  # type: ignore[attr-defined]
        )

    def of(self, node: ast.AST) -> str:
        first, last = self.span(node)
        return self.text[first:last]

    def fault(self, node: ast.AST, text: str, kind: str) -> Fault:
        first, last = self.span(node)
        return Fault(self.file, self.text.count("\n", 0, first) + 1, first, last, text, kind)

    def between(
        self, left: ast.AST, right: ast.AST, old: str, new: str, kind: str
    ) -> Iterator[Fault]:
        """Swap of the operator that stands between two operands."""
        first, last = self.span(left)[1], self.span(right)[0]
        if (at := self.text[first:last].find(old)) >= 0:
            place = first + at
            yield Fault(
                self.file, self.text.count("\n", 0, place) + 1, place, place + len(old), new, kind
            )


def seen(node: ast.AST) -> Iterator[ast.AST]:
    """The node and all below it whose change could be seen."""
    if isinstance(node, (ast.Import, ast.ImportFrom, ast.JoinedStr, ast.Assert, ast.Raise)):
        return
    if isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant):
        return
    if isinstance(node, ast.If) and "TYPE_CHECKING" in ast.dump(node.test):
        return
    if isinstance(node, ast.ClassDef) and any("Protocol" in ast.dump(base) for base in node.bases):
        return
    if isinstance(node, (ast.Assign, ast.AnnAssign)) and "__all__" in ast.dump(node):
        return
    if (
        isinstance(node, ast.Assign)
        and isinstance(node.targets[0], ast.Name)
        and _names_types(node)
    ):
        return
    yield node
    if isinstance(node, ast.Dict):
        for key, value in zip(node.keys, node.values, strict=True):
            if not (isinstance(key, ast.Constant) and key.value in SILENT):
                yield from seen(value)
                yield from () if key is None else seen(key)
        return
    hidden = {"annotation", "returns", "decorator_list", "bases", "type_params"}
    for field, value in ast.iter_fields(node):
        for child in value if isinstance(value, list) else [value]:
            silent = isinstance(child, ast.keyword) and child.arg in SILENT
            if (
                isinstance(child, ast.AST)
                and field not in hidden
                and not silent
                and not _speaks_only(child)
            ):
                yield from seen(child)


def _names_types(node: ast.Assign) -> bool:
    """Whether an assignment gives a name to a type: ``Rest = Mapping[str, float]``."""
    target = node.targets[0]
    named = isinstance(target, ast.Name) and target.id[:1].isupper() and not target.id.isupper()
    return named and isinstance(node.value, (ast.Subscript, ast.BinOp))


def _speaks_only(node: ast.AST) -> bool:
    """Whether a call only makes an error or says something while the work goes on."""
    if not isinstance(node, ast.Call):
        return False
    name = ast.unparse(node.func)
    return name.endswith(("Error", "warn", "TypeVar", "NewType", "getLogger")) or name in (
        "print",
        "typer.Option",
        "typer.Argument",
    )


def faults(root: Path, file: str) -> list[Fault]:
    """Every fault of a file (path below ``root``); a few are no Python and are left out where one
    is chosen.
    """
    source, known = Source(root, file), vocabulary(root)
    found = [fault for node in seen(source.tree) for fault in _of_node(source, node, known)]
    return [
        fault
        for fault in dict.fromkeys(found)
        if source.text[fault.start : fault.end] != fault.text
    ]


def seeded(text: str, fault: Fault) -> str:
    """The text of a file with the fault in it."""
    return text[: fault.start] + fault.text + text[fault.end :]


def _of_node(source: Source, node: ast.AST, known: dict[str, list[str]]) -> Iterator[Fault]:
    for rule in (_arithmetic, _logic, _constants, _calls, _order, _statements):
        yield from rule(source, node)
    if isinstance(node, ast.Constant) and isinstance(node.value, str):
        for other in (*known.get(node.value, ()), *UNITS.get(node.value, ())):
            yield source.fault(node, f'"{other}"', "another name or unit")


def _arithmetic(source: Source, node: ast.AST) -> Iterator[Fault]:
    if (
        isinstance(node, ast.BinOp)
        and type(node.op) in OPERATORS
        and not _is_text(node.left)
        and not _is_text(node.right)
    ):
        yield from source.between(node.left, node.right, *OPERATORS[type(node.op)], "operator")
        yield source.fault(node, source.of(node.left), "dropped term or factor")
        if not isinstance(node.op, (ast.Div, ast.Pow, ast.BitOr)):
            yield source.fault(node, source.of(node.right), "dropped term or factor")
    if isinstance(node, ast.AugAssign) and type(node.op) in OPERATORS:
        old, new = OPERATORS[type(node.op)]
        yield from source.between(node.target, node.value, f"{old}=", f"{new}=", "operator")
    if isinstance(node, ast.UnaryOp) and isinstance(node.op, ast.USub):
        yield source.fault(node, source.of(node.operand), "sign")
    if (
        isinstance(node, (ast.Return, ast.keyword))
        and isinstance(node.value, ast.BinOp)
        and isinstance(node.value.op, (ast.Mult, ast.Div))
    ):
        yield source.fault(node.value, f"-({source.of(node.value)})", "sign")


def _is_text(node: ast.AST) -> bool:
    return isinstance(node, (ast.JoinedStr, ast.List, ast.Tuple)) or (
        isinstance(node, ast.Constant) and isinstance(node.value, str)
    )


def _logic(source: Source, node: ast.AST) -> Iterator[Fault]:
    if isinstance(node, ast.Compare):
        left = node.left
        for op, right in zip(node.ops, node.comparators, strict=True):
            yield from source.between(left, right, *COMPARISONS[type(op)], "comparison")
            left = right
    if isinstance(node, ast.BoolOp):
        old, new = ("and", "or") if isinstance(node.op, ast.And) else ("or", "and")
        yield from source.between(node.values[0], node.values[1], f" {old} ", f" {new} ", "and, or")
        yield source.fault(node, source.of(node.values[0]), "dropped condition")
    if isinstance(node, (ast.If, ast.IfExp)) and not _leaves_by_error(node):
        yield source.fault(node.test, f"not ({source.of(node.test)})", "condition negated")
    if isinstance(node, ast.comprehension) and node.ifs:
        yield source.fault(node.ifs[0], "True", "dropped condition")


def _leaves_by_error(node: ast.AST) -> bool:
    """A refusal turned round stops every use: no fault that could go unseen."""
    return isinstance(node, ast.If) and isinstance(node.body[0], ast.Raise) and not node.orelse


def _constants(source: Source, node: ast.AST) -> Iterator[Fault]:
    if (
        not isinstance(node, ast.Constant)
        or isinstance(node.value, (str, bytes, complex))
        or node.value in (None, Ellipsis)
    ):
        return
    if isinstance(node.value, bool):
        yield source.fault(node, str(not node.value), "constant")
    elif node.value in SCALES:
        yield source.fault(node, "1.0", "scale of a unit")
    elif isinstance(node.value, int):
        if node.value >= LARGE_COUNT:
            return
        yield source.fault(node, str(node.value + 1), "constant by one")
        if node.value:
            yield source.fault(node, str(node.value - 1), "constant by one")
    else:
        yield source.fault(node, repr(2 * node.value) if node.value else "1.0", "constant doubled")
        if node.value:
            yield source.fault(node, repr(node.value / 2), "constant halved")


def _calls(source: Source, node: ast.AST) -> Iterator[Fault]:
    if not isinstance(node, ast.Call):
        return
    name = source.of(node.func)
    last = name.rsplit(".", 1)[-1]
    for other in SWAPPED_CALLS.get(last, ()):
        yield source.fault(node.func, name.removesuffix(last) + other, "another function")
    if (
        last
        in ("abs", "sqrt", "square", "cumsum", "sorted", "reversed", "unique", "degrees", "radians")
        and len(node.args) == 1
    ):
        yield source.fault(node, f"({source.of(node.args[0])})", "dropped function")
    for spot, given in enumerate(node.keywords):
        if given.arg and given.arg not in SILENT:
            before = (
                node.args[-1]
                if not spot and node.args
                else node.keywords[spot - 1].value
                if spot
                else None
            )
            if before is not None:
                first, last_place = source.span(before)[1], source.span(given)[1]
                line = source.text.count("\n", 0, first) + 1
                yield Fault(source.file, line, first, last_place, "", "dropped argument")


def _order(source: Source, node: ast.AST) -> Iterator[Fault]:
    items = (
        node.args
        if isinstance(node, ast.Call)
        else node.elts
        if isinstance(node, ast.Tuple) and isinstance(node.ctx, ast.Load)
        else []
    )
    if isinstance(node, ast.Call) and source.of(node.func) in (
        "isinstance",
        "getattr",
        "field",
        "TypeVar",
        "replace",
        "cast",
    ):
        return
    for left, right in pairwise(items):
        like = {ast.Name, ast.Attribute, ast.Subscript} >= {type(left), type(right)} or type(
            left
        ) is type(right) is ast.Constant
        if like and source.of(left) != source.of(right):
            first, last = source.span(left)[0], source.span(right)[1]
            middle = source.text[source.span(left)[1] : source.span(right)[0]]
            line = source.text.count("\n", 0, first) + 1
            yield Fault(
                source.file,
                line,
                first,
                last,
                source.of(right) + middle + source.of(left),
                "swapped items",
            )


def _statements(source: Source, node: ast.AST) -> Iterator[Fault]:
    if isinstance(node, (ast.AugAssign, ast.Continue, ast.Break)):
        yield source.fault(node, "pass", "dropped statement")
    if (
        isinstance(node, ast.Expr)
        and isinstance(node.value, ast.Call)
        and not _speaks_only(node.value)
    ):
        yield source.fault(node, "pass", "dropped statement")
    if isinstance(node, ast.Assign) and isinstance(node.targets[0], (ast.Subscript, ast.Attribute)):
        yield source.fault(node, "pass", "dropped statement")
