"""Cases of the Mann-Whitney U test as SciPy has them, for the tests of `master/src/statistics`. Needs SciPy 1.17; from
the repository's root: `python3 master/referee/mann_whitney.py > master/referee/mann_whitney.csv`."""

import csv
import sys

import numpy as np
from scipy.stats import mannwhitneyu, permutation_test


def u(a, b):
    return mannwhitneyu(a, b, method="asymptotic").statistic


def untied(a, b):
    """SciPy's exact distribution, which holds without ties."""
    return mannwhitneyu(a, b, method="exact").pvalue


def tied(a, b):
    """The exact permutation distribution of U, whatever the ties: all ways to deal the values to both groups."""
    test = permutation_test((a, b), u, n_resamples=np.inf, alternative="two-sided")
    return test.pvalue


def many(a, b):
    """Normal approximation, corrected for ties and continuity."""
    return mannwhitneyu(a, b, method="asymptotic", use_continuity=True).pvalue


def cases():
    random = np.random.default_rng(1)
    for sizes in [(1, 1), (1, 4), (3, 3), (5, 2), (6, 9), (10, 10), (10, 10), (12, 10), (20, 30)]:
        for shift in [0.0, 1.0]:
            yield untied, random.normal(size=sizes[0]) + shift, random.normal(size=sizes[1])
    for sizes in [(2, 2), (3, 5), (5, 5), (4, 7), (6, 6)]:
        for levels in [1, 2, 4]:
            yield tied, random.integers(0, levels, sizes[0]), random.integers(0, levels, sizes[1])
    for sizes in [(60, 60), (150, 80)]:
        for levels in [5, 1000]:
            yield many, random.integers(0, levels, sizes[0]), random.integers(0, levels, sizes[1])


def main():
    writer = csv.writer(sys.stdout, lineterminator="\n")
    writer.writerow(["case", "a", "b", "u", "p"])
    for kind, a, b in cases():
        written = [" ".join(repr(float(value)) for value in group) for group in (a, b)]
        writer.writerow([kind.__name__, *written, repr(float(u(a, b))), repr(float(kind(a, b)))])


if __name__ == "__main__":
    main()
