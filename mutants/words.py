"""Words of the faults: what may stand for what, and what no result shows."""

from __future__ import annotations

import ast
import re
from collections import defaultdict
from functools import cache
from pathlib import Path

#: Arguments that steer Python and its libraries, or only how a thing looks, and no result.
SILENT = frozenset(
    "strict encoding errors dtype _nrt exist_ok parents indent maxsize stacklevel frozen slots kw_only repr compare order copy key_only "
    "help description rich_help_panel metavar show_default cache fastmath nogil error_model inline boundscheck stdout stderr check text "
    "capture_output flush missing_ok ensure_ascii sort_keys compression compression_opts shuffle chunks engine "
    "colour color width height style justify no_wrap overflow min_width max_width padding box expand size font family".split()
)
UNITS = {
    "N": ("N m", "Hz"), "mm": ("m", "deg"), "m": ("mm",), "deg": ("rad", "mm"), "rad": ("deg",), "Hz": ("rad/s", "N"), "MPa": ("Pa", "N"),
    "Pa": ("MPa",), "mJ": ("J",), "J": ("mJ", "N m"), "rpm": ("rad/s",), "rad/s": ("rpm", "Hz"), "m/s": ("m/s2", "mm"), "N m": ("N", "J"),
    "m/s2": ("m/s",), "N/mm": ("N/m", "N"), "N/m": ("N/mm",), "N s": ("N", "J"), "s": ("ms",), "ms": ("s",), "deg/s": ("rad/s",),
    "%": ("1",), "um": ("mm",), "mN s": ("N s",), "N mm": ("N m",), "m/s²": ("m/s",), "kg": ("g",), "g": ("kg",),
}  # fmt: skip
SWAPPED_CALLS = {
    "min": ("max",), "max": ("min",), "minimum": ("maximum",), "maximum": ("minimum",), "argmin": ("argmax",), "argmax": ("argmin",),
    "mean": ("max",), "median": ("max",), "sin": ("cos",), "cos": ("sin",), "any": ("all",), "all": ("any",), "degrees": ("radians",),
    "radians": ("degrees",), "floor": ("ceil",), "ceil": ("floor",), "sum": ("max",), "nanmax": ("nanmin",), "nanmin": ("nanmax",),
    "startswith": ("endswith",), "endswith": ("startswith",), "rfftfreq": ("fftfreq",), "zeros": ("ones",), "ones": ("zeros",),
}  # fmt: skip
#: The last word of a name says what it is: names of one word are taken for each other.
ENDS = (
    "force forces displacement velocity acceleration angle stress energy frequency torque gap lift duration amplitude impulse count "
    "order pressure clearance compression stiffness rate mass damping ratio speed power work position range period"
).split()


@cache
def vocabulary(root: Path) -> dict[str, list[str]]:
    """Name of a quantity or channel -> up to two others of its kind (next in the alphabet, so the
    same for all runs).
    """
    names: dict[str, set[str]] = defaultdict(set)
    for path in sorted(root.rglob("*.py")):
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if (
                isinstance(node, ast.Constant)
                and isinstance(node.value, str)
                and re.fullmatch(r"[a-z][a-z0-9]*(_[a-z0-9]+)+", node.value)
            ):
                names[node.value.rsplit("_", 1)[-1]].add(node.value)
    found: dict[str, list[str]] = {}
    for end in ENDS:
        alike = sorted(names[end])
        for place, name in enumerate(alike):
            turned = alike[place + 1 :] + alike[:place]
            found[name] = turned[:2]
    return found
