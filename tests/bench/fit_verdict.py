#!/usr/bin/python3
"""Fits the weights of the verdict's terms (server/verification/verdict.cpp) on labelled placements.

usage: fit_verdict.py OUT.hpp ROWS.csv [ROWS.csv ...]     rows: as ./run bench stages and ./run bench merges write them
Logistic regression with weights that are never negative and a weak pull towards 0, on placements that converged. Wrong
placements in mines that show copies of themselves are left out where hardly anything contradicts them, and so are exact
copies longer than 25 m: what holds those back is set by hand (the column "by hand"), or other sessions. Prints, with one kind of world left out at a time, how many right placements reach 0.9, how
many wrong ones do, the log loss and the expected calibration error. Needs numpy.
"""
import csv
import datetime
import os
import sys

import numpy as np

ACCEPTED = 0.9
FLOORS = {"places disagree": 8}  # hardly any row has such places: what they are worth is set by hand
PULL = 0.3  # of the squared weights, in units of the terms' spread


def load(files):
    rows = []
    for name in files:
        with open(name) as f:
            rows += [r for r in csv.DictReader(f) if r["status"] == "converged" and float(r["tilt_deg"]) < 3]
    return rows


def copy(row):
    violation = float(row["worst_place_violation"])
    known = float(row["aliases"]) > 0 or float(row["repetition"]) >= 0.15
    exact = violation < 1e-3 and float(row["overlap_m"]) > 25
    return row["right"] == "0" and (exact or (known and violation < 3e-3))


def fit(X, y, by_hand, least, steps=4000):
    spread = np.abs(X).std(0) + 1e-6
    A = np.c_[X / spread, np.ones(len(X))]
    b, m, v = (np.zeros(A.shape[1]) for _ in range(3))
    for t in range(1, steps + 1):  # Adam, with the weights kept from going below 0
        g = A.T @ (1 / (1 + np.exp(-A @ b - by_hand)) - y)
        g[:-1] += PULL * b[:-1]
        g /= len(y)
        m, v = 0.9 * m + 0.1 * g, 0.999 * v + 0.001 * g * g
        b -= 0.02 * (m / (1 - 0.9**t)) / (np.sqrt(v / (1 - 0.999**t)) + 1e-8)
        b[:-1] = np.maximum(least * spread, b[:-1])
    return np.r_[b[:-1] / spread, b[-1]]


def main(out, files):
    rows = [r for r in load(files) if not copy(r)]
    terms = [k for k in rows[0] if k.startswith("term: ")]
    X = np.array([[float(r[t]) for t in terms] for r in rows])
    y = np.array([float(r["right"]) for r in rows])
    by_hand = np.array([float(r["by hand"]) for r in rows])
    least = np.array([FLOORS.get(t[6:], 0) for t in terms])
    kinds = np.array([r["kind"] for r in rows])
    left_out = np.zeros(len(y))
    print("%-18s %6s %8s %6s %8s" % ("kind left out", "right", ">= 0.9", "wrong", ">= 0.9"))
    for kind in sorted(set(kinds)):
        here = kinds == kind
        c = fit(X[~here], y[~here], by_hand[~here], least)
        p = left_out[here] = 1 / (1 + np.exp(-(X[here] @ c[:-1] + c[-1] + by_hand[here])))
        right = y[here] == 1
        print("%-18s %6d %8d %6d %8d" % (kind, right.sum(), (p[right] >= ACCEPTED).sum(), (~right).sum(), (p[~right] >= ACCEPTED).sum()))
    p = np.clip(left_out, 1e-9, 1 - 1e-9)
    bins = np.minimum((10 * p).astype(int), 9)
    ece = sum(abs(p[bins == b].mean() - y[bins == b].mean()) * (bins == b).mean() for b in set(bins))
    print("log loss %.3f, expected calibration error %.3f" % (-(y * np.log(p) + (1 - y) * np.log(1 - p)).mean(), ece))
    c = fit(X, y, by_hand, least)
    for t, w in zip(terms, c):
        print("%8.2f  %s" % (w, t[6:]))
    print("%8.2f  bias" % c[-1])
    mines = len({r["mine"] for r in rows})
    with open(out, "w") as f:
        f.write("#pragma once\n// Made by tests/bench/fit_verdict.py on %s from %d right and %d wrong placements in %d mines of %d kinds.\n\n"
                % (datetime.date.today(), y.sum(), len(y) - y.sum(), mines, len(set(kinds))))
        f.write("#include <array>\n#include <string_view>\n\nnamespace headframe {\n\n"
                "/// Of the descriptors in those rows. Of others the verdict does not know how alike they are at right and\n"
                "/// wrong placements.\ninline constexpr std::string_view verdict_family = \"learned\";\n\n"
                "inline constexpr double verdict_bias = %.3f;\n" % c[-1])
        f.write("inline constexpr std::array<double, %d> verdict_weights{%s};\n\n}  // namespace headframe\n"
                % (len(terms), ", ".join("%.3f" % w for w in c[:-1])))


if __name__ == "__main__":
    if len(sys.argv) < 3:
        sys.exit(__doc__)
    for name in sys.argv[2:]:
        if not os.path.exists(name):
            sys.exit("fit_verdict.py: no such file: " + name)
    main(sys.argv[1], sys.argv[2:])
