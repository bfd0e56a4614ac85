"""Refine a library case and write what came out beside it, for every report of that case.

Use: python scripts/write_uncertainty.py [CASE] [--workers 4]
"""

from __future__ import annotations

import argparse
from importlib import resources

from valvetrain.parameters.loading import load_case
from valvetrain.solution.atomic import write_text
from valvetrain.studies.uncertainty import uncertainty_study
from valvetrain.studies.uncertainty_file import uncertainty_text


def main() -> None:
    """Command line."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("case", nargs="?", default="gu2021-beehive")
    parser.add_argument("--workers", type=int, default=4)
    options = parser.parse_args()
    case = load_case(options.case)
    study = uncertainty_study(case, workers=options.workers, progress=lambda share, words: print(f"{100 * share:3.0f} %  {words}"))
    if study.failures:
        raise SystemExit("; ".join(study.failures))
    path = resources.files("valvetrain") / "parameters" / "library" / f"{options.case}.uncertainty"
    write_text(str(path), uncertainty_text(study))
    print(f"wrote {path.name}")


if __name__ == "__main__":
    main()
