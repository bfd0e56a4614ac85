"""Count the functions of the package that one command enters: each `def` once, by package; lambdas
and class bodies do not count.

Use: python scripts/count_functions.py run gu2021-beehive-blind --engine-speed '4200 rpm'
     python scripts/count_functions.py --list run gu2021-beehive-blind     names every function too
"""

from __future__ import annotations

import contextlib
import importlib.util
import io
import os
import sys
import threading
from collections import Counter
from inspect import CO_OPTIMIZED
from pathlib import Path
from types import CodeType, FrameType

SPEC = importlib.util.find_spec("valvetrain")
assert SPEC is not None and SPEC.origin is not None
PACKAGE = Path(SPEC.origin).parent


def entered(arguments: list[str]) -> set[CodeType]:
    """Code of every function of the package that ``valvetrain ARGUMENTS`` enters, imports included,
    in any thread of this process.
    """
    found: set[CodeType] = set()
    folder = f"{PACKAGE}{os.sep}"

    def note(frame: FrameType, event: str, _: object) -> None:
        code = frame.f_code
        # modules and class bodies are not optimised code; comprehensions and lambdas have names in
        # angle brackets
        if (
            event == "call"
            and code.co_flags & CO_OPTIMIZED
            and code.co_name[0] != "<"
            and code.co_filename.startswith(folder)
        ):
            found.add(code)

    sys.argv = ["valvetrain", *arguments]
    threading.setprofile(note)
    sys.setprofile(note)
    try:
        from valvetrain.cli.main import main

        with contextlib.redirect_stdout(io.StringIO()):
            main()
    except SystemExit as end:
        if end.code:
            raise
    finally:
        sys.setprofile(None)
        threading.setprofile(None)
    return found


def package_of(code: CodeType) -> str:
    """First folder (or module) below the package that holds ``code``."""
    return Path(code.co_filename).relative_to(PACKAGE).parts[0].removesuffix(".py")


if __name__ == "__main__":
    named = sys.argv[1:2] == ["--list"]
    codes = entered(sys.argv[2:] if named else sys.argv[1:])
    for package, count in sorted(
        Counter(map(package_of, codes)).items(), key=lambda item: -item[1]
    ):
        print(f"{count:5d}  {package}")
        for code in sorted(
            (code for code in codes if named and package_of(code) == package),
            key=lambda code: code.co_filename,
        ):
            print(f"         {Path(code.co_filename).stem}.{code.co_name}")
    print(f"{len(codes):5d}  in all")
