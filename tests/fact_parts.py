"""Facts of a study by their code, for tests."""

from collections.abc import Iterable

from valvetrain.solution.status import Fact


def with_code(facts: Iterable[Fact], code: str) -> tuple[Fact, ...]:
    """The facts of one code, such as ``assumed-ramp``."""
    return tuple(one for one in facts if one.code == code)
