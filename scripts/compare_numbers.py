"""Numbers of all shipped cases, examples and templates, for comparing two checkouts.

A refactoring must leave every number in place. Dump the numbers of both checkouts on one
processor, then compare:

    PYTHONPATH=OLD/src python scripts/compare_numbers.py dump old.json
    PYTHONPATH=src     python scripts/compare_numbers.py dump new.json
    python scripts/compare_numbers.py compare old.json new.json

Only public names and commands that survive a refactoring are used.
"""

from __future__ import annotations

import json
import math
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path

import valvetrain as vt

ROOT = Path(__file__).resolve().parents[1]
#: Relative difference that rounding of a reordered sum may make.
TOLERANCE = 1e-9
#: Words of a quantity's name -> SI size below which it counts as zero; others 1e-9.
FLOORS = {"force": 1e-6, "stress": 1.0, "pressure": 1.0, "moment": 1e-9, "torque": 1e-6}
TEMPLATES = ("spring", "direct", "finger", "rocker", "pushrod")
MODELS = (
    "massless",
    "multi-mass",
    "modal-uniform",
    "modal-varied",
    "wave-rod",
    "wave-rod-clash",
    "finite-element",
)
Numbers = dict[str, float]


def cases(folder: Path) -> Iterator[tuple[str, str]]:
    """Name and argument of every case: library, examples, templates written into ``folder``."""
    for name in vt.list_cases():
        yield name.name, name.name
    for path in sorted((ROOT / "examples").glob("*.toml")):
        if not path.name.startswith(("identify", "optimise")):
            yield f"examples/{path.stem}", str(path)
    for kind in TEMPLATES:
        path = folder / f"{kind}.toml"
        command = [sys.executable, "-m", "valvetrain", "new", str(path), "--kind", kind]
        subprocess.run(command, check=True, capture_output=True)
        yield f"template-{kind}", str(path)


def numbers_of(case: str) -> Numbers:
    """Named quantities of a case by every model that runs it, at all its own speeds."""
    found: Numbers = {}
    for model in MODELS:
        try:
            study = vt.simulate(case, spring_models=[model])
        except (vt.InputError, vt.ValvetrainError) as refusal:
            found[f"{model} refused: {str(refusal)[:60]}"] = 0.0
            continue
        found |= {f"{model} {one.name}": float(value) for one, value in study.quantities.items()}
        for run in study.solutions:
            place = f"{run.label} {run.spring_set} {run.engine_speed:.6g} rad/s {run.status.code}"
            for key, value in run.quantities.items():
                found[f"{place} {key}"] = float(value)
    return found


def dump(target: Path) -> None:
    """Write the numbers of all cases to ``target``, whole after each case."""
    found: dict[str, Numbers] = {}
    with tempfile.TemporaryDirectory() as folder:
        for name, case in cases(Path(folder)):
            found[name] = numbers_of(case)
            print(f"{name}: {len(found[name])} numbers", flush=True)
            part = target.with_suffix(".part")
            part.write_text(json.dumps(found), encoding="utf-8")
            part.replace(target)


def floor_of(key: str) -> float:
    """Size below which a number counts as zero, by the words of its name."""
    return next((size for word, size in FLOORS.items() if word in key), 1e-9)


def differences(old: dict[str, Numbers], new: dict[str, Numbers]) -> tuple[int, list[str]]:
    """Count of numbers compared, and a line on each that is missing, new or different."""
    count, found = 0, []
    for case in old.keys() | new.keys():
        first, second = old.get(case, {}), new.get(case, {})
        found += [f"{case}: {key} is in one checkout alone" for key in first.keys() ^ second.keys()]
        for key in first.keys() & second.keys():
            a, b = first[key], second[key]
            count += 1
            if a == b or (math.isnan(a) and math.isnan(b)):
                continue
            if not abs(a - b) <= TOLERANCE * max(abs(a), abs(b)) + floor_of(key):
                found.append(f"{case}: {key} {a!r} -> {b!r}")
    return count, sorted(found)


def main() -> int:
    """Run one of the two commands; 1 where numbers differ."""
    if sys.argv[1:2] == ["dump"] and len(sys.argv) == 3:
        dump(Path(sys.argv[2]))
        return 0
    if sys.argv[1:2] == ["compare"] and len(sys.argv) == 4:
        old, new = (json.loads(Path(one).read_text(encoding="utf-8")) for one in sys.argv[2:])
        count, found = differences(old, new)
        print("\n".join(found[:200]))
        alone = sum(line.endswith("in one checkout alone") for line in found)
        print(
            f"{count} numbers of {len(old.keys() & new.keys())} cases compared, {len(found) - alone} differ, "
            f"{alone} in one checkout alone"
        )
        return int(bool(found))
    print(__doc__)
    return 2


if __name__ == "__main__":
    sys.exit(main())
