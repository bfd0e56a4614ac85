"""What the data determine: which measurement tells which quantity, and which quantities only
together.

All of it follows from the slopes of the scaled misses at the likeliest point, in standard
deviations of the priors, so that the
information of the priors is the identity. Source: D. Sivia and J. Skilling, Data Analysis (2nd ed.
2006), chapter 3.
"""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from valvetrain.identification.posterior import Posterior

Array = NDArray[np.float64]
#: Posterior correlation beyond which two quantities are one, and information (over the prior's)
#: that each would have were the other known.
TWINS, TOLD_ALONE = 0.9, 4.0
#: Share of the prior's deviation that must be left of one of the two, for a narrow stretch within a
#: wide prior is knowledge all the same.
OPEN = 0.4
#: A quantity is told where the data leave less than this share of the prior's variance.
UNTOLD = 0.75
#: Least part of a combination that is named in words.
NAMED = 0.3


@dataclass(frozen=True, eq=False)
class Information:
    """``told`` (quantities): share of the prior's variance that the data remove. ``brought``
    (measurements, quantities): share that each
    measurement has of all the data's information on a quantity, the others known. ``lost``
    (measurements, quantities): share by which the
    variance is smaller than it were without that measurement. ``correlation`` (quantities,
    quantities) of what is left open;
    ``warnings``: a sentence per quantity that is not told, and per group that cannot be told
    apart."""

    measurements: tuple[str, ...]
    told: Array
    brought: Array
    lost: Array
    correlation: Array
    warnings: tuple[str, ...]


def information_of(posterior: Posterior, jacobian: Array, whole_search: bool = True) -> Information:
    """From the slopes (used data, quantities) at the likeliest point; without warnings where the
    search was cut short.
    """
    count = jacobian.shape[1]
    owners = [one.name for one in posterior.used]
    measurements = tuple(dict.fromkeys(owners))
    whole: NDArray[Any] = np.linalg.inv(np.eye(count) + jacobian.T @ jacobian)
    variance = np.diag(whole)
    lost, brought = np.zeros((len(measurements), count)), np.zeros((len(measurements), count))
    every = np.sum(jacobian**2, axis=0)
    for place, name in enumerate(measurements):
        others = jacobian[[owner != name for owner in owners]]
        brought[place] = np.sum(
            jacobian[[owner == name for owner in owners]] ** 2, axis=0
        ) / np.where(every > 0, every, 1.0)
        without = np.diag(np.linalg.inv(np.eye(count) + others.T @ others))
        lost[place] = np.clip(1.0 - variance / without, 0.0, 1.0)
    correlation = np.asarray(whole / np.sqrt(np.outer(variance, variance)), dtype=np.float64)
    return Information(
        measurements,
        1.0 - variance,
        brought,
        lost,
        correlation,
        _warnings(posterior.names, jacobian, whole, correlation) if whole_search else (),
    )


def _warnings(
    names: Sequence[str], jacobian: Array, covariance: NDArray[Any], correlation: NDArray[Any]
) -> tuple[str, ...]:
    alone = np.sum(jacobian**2, axis=0)
    found, spoken = [], set()
    for one, other in itertools.combinations(range(len(names)), 2):
        known = alone[one] > TOLD_ALONE and alone[other] > TOLD_ALONE
        vague = np.sqrt(np.diag(covariance)[[one, other]])
        if known and abs(correlation[one, other]) > TWINS and vague.max() > OPEN:
            found.append(_pair(names[one], names[other], correlation[one, other], vague))
            spoken |= {one, other}
    values, vectors = np.linalg.eigh(jacobian.T @ jacobian)
    for value, vector in zip(values, vectors.T, strict=True):
        large = [
            place for place in np.argsort(-np.abs(vector)).tolist() if abs(vector[place]) > NAMED
        ]
        if (
            value < 1.0
            and len(large) > 2
            and not set(large) <= spoken
            and all(alone[place] > TOLD_ALONE for place in large)
        ):
            words = (
                ", ".join(f"'{names[place]}'" for place in sorted(large)[:-1])
                + f" and '{names[sorted(large)[-1]]}'"
            )
            found.append(
                f"the data cannot tell {words} apart: they know combinations of them only, and one is left to the priors"
            )
            spoken |= set(large)
    for place, name in enumerate(names):
        if place not in spoken and covariance[place, place] > UNTOLD:
            share = 100 * (1 - covariance[place, place])
            found.append(
                f"the data hardly tell '{name}': they remove {max(share, 0.0):.0f} % of the variance of its prior, the rest is the prior"
            )
    return tuple(found)


def _pair(one: str, other: str, correlation: float, vague: Array) -> str:
    together, apart = ("sum", "difference") if correlation < 0 else ("difference", "sum")
    left = ", ".join(f"{100 * part:.0f} %" for part in vague)
    return (
        f"the data cannot tell '{one}' and '{other}' apart: they know a kind of {together} of the two, of their {apart} little more than "
        f"the priors do (correlation {correlation:.3f}; {left} of the priors' deviations are left); measure one of them by itself"
    )
