# SPDX-License-Identifier: BSD-3-Clause
"""The statistics of the suite, for counts and samples of any origin. Names, sources and limits of
the methods: sim2sim_statistics; their measured coverage: docs/statistics.md.

Intervals are of 95 %. Where too few samples are there for one, it is None.
"""

from typing import Any, List, NamedTuple, Optional, Sequence, Tuple

import numpy as np
from numpy.typing import ArrayLike

from sim2sim import _sim2sim
from sim2sim.checks import (
    checked_integer,
    checked_list,
    checked_number,
    checked_numbers,
)
from sim2sim.errors import InvalidInput

_functions = _sim2sim.statistics
MOST = 500_000_000  # of a count


class Interval(NamedTuple):
    """A closed interval, in the unit of the figure."""

    low: float
    high: float

    def __str__(self) -> str:
        return f"[{self.low:.4g}, {self.high:.4g}]"


class Estimate(NamedTuple):
    """A figure with its interval, in the unit of the samples; NaN without samples."""

    value: float
    interval: Optional[Interval]


class Difference(NamedTuple):
    """A paired difference with its interval, and the p-value of a two-sided test against 0."""

    value: float
    interval: Optional[Interval]
    p: Optional[float]


class PairTable(NamedTuple):
    """Counts of paired successes. The first is the reference or baseline."""

    both: int
    first_only: int
    second_only: int
    neither: int

    @classmethod
    def of(cls, first: ArrayLike, second: ArrayLike) -> "PairTable":
        """The table of two lists of successes over the same episodes, in the same order."""
        one, other = _truths("first", first), _truths("second", second)
        if len(one) != len(other):
            raise InvalidInput(f"second: {len(other)} successes; must be {len(one)}, as of first")
        both, first_only, second_only = one & other, one & ~other, other & ~one
        neither = ~(one | other)
        return cls(*(int(kind.sum()) for kind in (both, first_only, second_only, neither)))

    @property
    def pairs(self) -> int:
        """Number of pairs."""
        return sum(self)

    @property
    def difference(self) -> float:
        """Difference of the success rates, second - first; NaN without pairs."""
        return (self.second_only - self.first_only) / self.pairs if self.pairs else np.nan

    @property
    def ratio(self) -> float:
        """Ratio of the success rates, second / first (the transfer); NaN if first never does."""
        first = self.both + self.first_only
        return (self.both + self.second_only) / first if first else np.nan


Table = Sequence[int]  # a PairTable, or four counts in its order


def wilson_interval(successes: int, trials: int) -> Interval:
    """Interval of a success probability (Wilson's score)."""
    most = checked_integer("trials", trials, 1, MOST)
    count = checked_integer("successes", successes, 0, most)
    return Interval(*_functions.wilson_interval(count, most))


def tango_interval(table: Table) -> Optional[Interval]:
    """Interval of the difference of success rates, second - first (Tango's score)."""
    return _interval(_functions.tango_interval(_counts(table)))


def tang_interval(table: Table) -> Optional[Interval]:
    """Interval of the ratio of success rates, second / first: the transfer (Tang's score)."""
    return _interval(_functions.tang_interval(_counts(table)))


def mcnemar_exact(table: Table) -> float:
    """p-value of McNemar's exact test that both rates are equal, two-sided."""
    return float(_functions.mcnemar_exact(_counts(table)))


def mcnemar_mid_p(table: Table) -> float:
    """p-value of McNemar's mid-p test, whose error rate is near its level: that of the commands."""
    return float(_functions.mcnemar_mid_p(_counts(table)))


def transfer_sequence(table: Table) -> Interval:
    """Interval of the transfer that holds whenever one stops: all of a run together, at 95 %."""
    return Interval(*_functions.transfer_sequence(_counts(table)))


def verdict(table: Table) -> str:
    """The verdict of a headline on the transfer: "exceeds", "transfers", "transfers_in_part",
    "at_most_in_part", "does_not_transfer", "cannot_say" or "nothing_to_transfer"."""
    counts = _counts(table)
    if counts[0] + counts[1] == 0:
        return "nothing_to_transfer"
    return verdict_of(tang_interval(counts))


def verdict_of(transfer: Optional[Tuple[float, float]]) -> str:
    """Likewise, by an interval of the transfer; "cannot_say" without one."""
    if transfer is None:
        return "cannot_say"
    low, high = checked_numbers("transfer", transfer, (2,))
    return str(_functions.verdict_of(low, high))


def holm(p: ArrayLike) -> List[float]:
    """p-values of a family of tests after Holm's correction, in their order."""
    return list(_functions.holm(checked_numbers("p", p)))


def mean_of(samples: ArrayLike, limit: float = np.inf) -> Estimate:
    """Mean of a quantity in [0, `limit`], with Student's interval on the scale of the logarithm."""
    return _estimate(
        _functions.mean_of(checked_numbers("samples", samples), checked_number("limit", limit))
    )


def median_of(samples: ArrayLike) -> Estimate:
    """Median, with an interval between order statistics."""
    return _estimate(_functions.median_of(checked_numbers("samples", samples)))


def paired_difference(differences: ArrayLike, extreme: Optional[float] = None) -> Difference:
    """Mean of paired differences: by Student's t, or, where few samples carry the mean, by an
    interval that counts one sample more, of the size `extreme`."""
    most = None if extreme is None else checked_number("extreme", extreme)
    return _difference(
        _functions.paired_difference(checked_numbers("differences", differences), most)
    )


def repeated_rate_interval(successes: Sequence[int], episodes: Sequence[int]) -> Optional[Interval]:
    """Interval of a success rate where each start was run several times: counts by start."""
    counts = [_count("successes", count) for count in checked_list("successes", successes)]
    starts = [_count("episodes", count) for count in checked_list("episodes", episodes)]
    if len(counts) != len(starts):
        raise InvalidInput(f"episodes: {len(starts)} starts; must be {len(counts)}, as successes")
    return _interval(_functions.repeated_rate_interval(list(zip(counts, starts))))


def repeated_difference(starts: Sequence[Table]) -> Difference:
    """Difference of success rates where each start was run several times: a table for each."""
    return _difference(
        _functions.repeated_difference([_counts(table) for table in checked_list("starts", starts)])
    )


def repeated_ratio_interval(starts: Sequence[Table]) -> Optional[Interval]:
    """Interval of the ratio of success rates, likewise."""
    return _interval(
        _functions.repeated_ratio_interval(
            [_counts(table) for table in checked_list("starts", starts)]
        )
    )


def smallest_difference(standard_deviation: float, episodes: int) -> float:
    """Smallest mean of paired differences that is found in 80 % of runs, at 5 %."""
    deviation = checked_number("standard_deviation", standard_deviation)
    return float(_functions.smallest_difference(deviation, _count("episodes", episodes)))


def episodes_for(standard_deviation: float, difference: float) -> Optional[int]:
    """Number of episodes that find a mean difference likewise; None: more than 100 000."""
    deviation = checked_number("standard_deviation", standard_deviation)
    found = _functions.episodes_for(deviation, checked_number("difference", difference))
    return None if found is None else int(found)


def mcnemar_power(discordant: float, difference: float, episodes: int) -> float:
    """Probability that McNemar's mid-p finds a difference of success rates, if only one of the two
    succeeds in a share `discordant` of the pairs."""
    share, wanted = _rates(discordant, difference)
    return float(_functions.mcnemar_power(share, wanted, _count("episodes", episodes)))


def smallest_rate_difference(discordant: float, episodes: int) -> Optional[float]:
    """Smallest difference of success rates that is found in 80 % of runs, at 5 %; None: none is."""
    share = checked_number("discordant", discordant)
    found = _functions.smallest_rate_difference(share, _count("episodes", episodes))
    return None if found is None else float(found)


def episodes_for_rates(discordant: float, difference: float) -> Optional[int]:
    """Number of episodes that find a difference of success rates likewise; None: more than
    100 000."""
    found = _functions.episodes_for_rates(*_rates(discordant, difference))
    return None if found is None else int(found)


def _count(name: str, value: object) -> int:
    return checked_integer(name, value, 0, MOST)


def _counts(table: Table) -> List[int]:
    table = checked_list("table", table)
    if len(table) != len(PairTable._fields):
        raise InvalidInput(f"table {table!r}: must have 4 counts: {', '.join(PairTable._fields)}")
    return [_count(name, count) for name, count in zip(PairTable._fields, table)]


def _rates(discordant: float, difference: float) -> Tuple[float, float]:
    return checked_number("discordant", discordant), checked_number("difference", difference)


def _truths(name: str, given: ArrayLike) -> Any:
    array = np.asarray(given)
    if array.ndim != 1 or (array.dtype != np.bool_ and not np.isin(array, (0, 1)).all()):
        raise InvalidInput(f"{name}: must be a list of true and false, or of 1 and 0")
    return array.astype(np.bool_)


def _interval(ends: Any) -> Optional[Interval]:
    return None if ends is None else Interval(*ends)


def _estimate(found: Any) -> Estimate:
    return Estimate(found[0], _interval(found[1]))


def _difference(found: Any) -> Difference:
    return Difference(found[0], _interval(found[1]), found[2])
