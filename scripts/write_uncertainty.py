"""Refine a library case and write what came out beside it, for every report of that case.

    python scripts/write_uncertainty.py [CASE] [--workers 4]     all meshes and steps, minutes
    python scripts/write_uncertainty.py [CASE] --restamp         after a change of words in the case
    file: one run, seconds

Side files count only for the case file they name by its digest. ``--restamp`` runs the case once
and, where every stored value comes out
again (to 1e-3 or its own uncertainty), writes the new digest into the side files; otherwise it says
what differs and writes nothing.
"""

from __future__ import annotations

import argparse
import re
import tomllib
from importlib import resources
from pathlib import Path

from valvetrain.parameters.case import Case
from valvetrain.parameters.loading import load_case
from valvetrain.runs.api import simulate
from valvetrain.runs.error_bars import UncertaintyStudy
from valvetrain.runs.refine import refined
from valvetrain.runs.stored_error_bars import OF_VARIANT, belongs, heading_of, numbers_of, rows_of
from valvetrain.solution.atomic import write_text
from valvetrain.solution.uncertainty import Uncertainty

LIBRARY = Path(str(resources.files("valvetrain") / "parameters" / "library"))
DIGEST = re.compile(r'^digest = "\w*"$', re.MULTILINE)


def uncertainty_text(study: UncertaintyStudy) -> str:
    """Content of the file that ships with a library case."""
    meshes = ", ".join(map(str, study.elements_per_coil))
    (soft, stiff), (least, most) = study.stiffness_factors, study.damping_factors
    lines = [
        f"# Uncertainty of the headline numbers of {study.record.name}; written by scripts/write_uncertainty.py. SI units.",
        "# value, numerical uncertainty, observed order (nan: not monotonic), extrapolated value, part of the step,",
        f"# least and largest over contact stiffness x {soft:g} to x {stiff:g}, least and largest over damping x {least:g} to "
        f"x {most:g}.",
        "", "[case]", f'digest = "{study.record.digest}"', f"elements_per_coil = [{meshes}]",
    ]  # fmt: skip
    groups: dict[tuple[float | None, str], list[Uncertainty]] = {}
    for row in study.rows:
        groups.setdefault((row.engine_speed, row.label), []).append(row)
    for (speed, label), rows in groups.items():
        variant = OF_VARIANT + label if label else ""
        lines += ["", f'["{heading_of(speed)}{variant}"]']
        for row in rows:
            numbers = ", ".join(f"{number:.7g}" for number in numbers_of(row))
            lines.append(f"{row.quantity} = [{numbers}]")
    return "\n".join(lines) + "\n"


def restamp(case: Case, workers: int) -> None:
    """Write the case's digest into its side files, after one run has shown that the stored values
    still hold.
    """
    rows = rows_of(
        tomllib.loads((LIBRARY / f"{case.name}.uncertainty").read_text(encoding="utf-8"))
    )
    study = simulate(
        case, models=() if case.train is not None else ("finite-element",), workers=workers
    )
    if changed := [row for row in rows if not belongs(row, study.quantities)]:
        lines = (
            f"  {row.quantity} {row.label} at {row.engine_speed or 0:.6g} rad/s" for row in changed
        )
        raise SystemExit("values have changed, refine the case again:\n" + "\n".join(lines))
    for ending in ("uncertainty", "spread"):
        path = LIBRARY / f"{case.name}.{ending}"
        if path.is_file():
            write_text(
                str(path),
                DIGEST.sub(
                    f'digest = "{case.record().digest}"', path.read_text(encoding="utf-8"), count=1
                ),
            )
            print(f"{path.name} belongs to the case as it is now; {len(rows)} values compared")


def main() -> None:
    """Command line."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("case", nargs="?", default="gu2021-beehive-blind")
    parser.add_argument("--workers", type=int, default=4)
    parser.add_argument("--restamp", action="store_true")
    options = parser.parse_args()
    case = load_case(options.case)
    if options.restamp:
        restamp(case, options.workers)
        return
    study = refined(
        case,
        workers=options.workers,
        progress=lambda share, words: print(f"{100 * share:3.0f} %  {words}"),
    )
    if study.failures:
        raise SystemExit("; ".join(study.failures))
    path = LIBRARY / f"{options.case}.uncertainty"
    write_text(str(path), uncertainty_text(study))
    print(f"wrote {path.name}")


if __name__ == "__main__":
    main()
