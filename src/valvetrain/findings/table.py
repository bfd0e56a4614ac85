"""The table of rules by importance, and the findings of a study by it."""

from __future__ import annotations

import re
from collections.abc import Container

from valvetrain.errors import UnknownNameError
from valvetrain.findings.engine import Findings, Rule, judge
from valvetrain.findings.facts import Facts
from valvetrain.findings.words import Words
from valvetrain.registry import members
from valvetrain.solution.study import Study

LEVELS = {
    "decides": "decides the verdict", "warns": "warns", "notes": "notes",
}  # fmt: skip


def rules(kinds: Container[str] | None = None) -> tuple[Rule, ...]:
    """All rules by importance: the tables that the registry lists (kind ``rules``), those of packages last.

    Parameters
    ----------
    kinds : what a study is (:attr:`Facts.kinds`), of which rules shall speak; None: every rule

    Returns
    -------
    The rules, those that decide a verdict among them

    Raises
    ------
    InputError : a table of another package that cannot be loaded

    Examples
    --------
    >>> any(rule.code == "C101" for rule in rules())
    True
    """
    return tuple(rule for _, table in members("rules", kinds) for rule in table)


def every_rule() -> tuple[Rule, ...]:
    """The rules on studies, then those on every other kind of result."""
    return (*rules(), *(rule for _, table in members("other_rules") for rule in table))


def findings_of(study: Study, words: Words | None = None) -> Findings:
    """What a study shows, the verdict first.

    Parameters
    ----------
    study : what ``simulate`` or ``run_up`` gave
    words : system of units and language; SI and English by default

    Returns
    -------
    Findings in order of importance

    Raises
    ------
    InputError : a table of rules of another package that cannot be loaded

    Examples
    --------
    >>> import valvetrain as vt
    >>> found = findings_of(vt.simulate("job-t", "2000 rpm", models=["massless"]))
    >>> found.verdict.code, found.verdict.mark
    ('K104', 'warn')
    """
    facts = Facts(study)
    return judge(facts, rules(facts.kinds), words or Words())


def rule_of(code: str) -> Rule:
    """The rule of a ``code``. Raises :class:`UnknownNameError` for an unknown one, with the nearest."""
    known = {one.code: one for one in every_rule()}
    if code.upper() not in known:
        raise UnknownNameError(code, known, "finding")
    return known[code.upper()]


def explain(code: str) -> dict[str, str]:
    """A rule in words.

    Parameters
    ----------
    code : of the rule, such as ``"C101"``

    Returns
    -------
    What it says, with ``…`` for its numbers and names, when it holds, what it reads, why, and what to do next

    Raises
    ------
    UnknownNameError : an unknown code, with the nearest

    Examples
    --------
    >>> explain("C101")["level"]
    'decides the verdict'
    """
    rule = rule_of(code)
    found = {
        "code": rule.code, "level": LEVELS[rule.level], "says": plain(rule.text),
        "holds": " ".join((rule.hits.__doc__ or "").split()), "reads": ", ".join(rule.reads), "why": plain(rule.reason),
        "next": plain(rule.step), "guide": f"docs/{rule.guide}" if rule.guide else "",
    }  # fmt: skip
    return {name: text for name, text in found.items() if text}


def plain(template: str) -> str:
    """A template as people read it: ``…`` for its numbers and names.

    >>> plain("the valve floats: {value} above its path[ {at}]")
    'the valve floats: … above its path …'
    """
    text = re.sub(r"\{[^}]*\}", "…", template.replace("{case}", "CASE"))
    return re.sub(r"…(,? ?…)+", "…", re.sub(r"[][]", "", text)).removeprefix("…: ")
