#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Statistics for counts of your own: 50 trials on a robot, and the same ones in a simulator."""

from sim2sim import statistics

table = statistics.PairTable(both=20, first_only=17, second_only=2, neither=11)
print("difference", table.difference, statistics.tango_interval(table))
print("ratio", round(table.ratio, 4), statistics.tang_interval(table))
print("verdict", statistics.verdict(table), "p", round(statistics.mcnemar_mid_p(table), 4))
discordant = (table.first_only + table.second_only) / table.pairs
print("trials to find 0.1:", statistics.episodes_for_rates(discordant, 0.1))
