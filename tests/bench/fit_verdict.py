#!/usr/bin/python3
"""Fits the curves of the verdict (server/verification/verdict.cpp) to labelled placements.

usage: fit_verdict.py OUT.hpp ROWS.csv [ROWS.csv ...]

ROWS.csv are files that ./run bench stages, merges, recordings, drawn-mines and rejudge write; their columns "term: ..."
hold what each term measures. The log-odds of a placement are a constant plus one curve for each term, linear between
the knots below and never rising towards the worse side: a logistic regression whose weights, the falls from knot to
knot, are never negative. They are drawn to the falls of the curves in place, server/verification/verdict_curves.hpp,
which were fitted to rows that are not given here: so give each row to one fit only. A wrong placement weighs
WRONG_WEIGHT right ones; calibrated() takes that out of what people are told. A right one of a recording weighs
RECORDED_WEIGHT others. The rows of known_placements.csv take part in every fit, each weighing so many times as others
as its row says: the copies that looked most like right placements so far, as much as it takes to keep them waiting,
and a drawn drive that is merged in many tests. LEAST holds falls where hardly any row lies, set by hand.

For each kind of world, prints how many right and wrong placements reach 0.9 with curves that were fitted without this
kind; then the log loss and the expected calibration error of what is told. Writes OUT.hpp and, beside it, curves.svg,
replacements for those in server/verification. Needs numpy.
"""
import datetime
import os
import re
import sys

import numpy as np

from fit_rows import calibration_error, load, log_loss, made_from, run

ACCEPTED = 0.9
WRONG_WEIGHT = 1.25  # with 1, seven more right ones of 726 in mines left out, and three more wrong ones, two of them copies over 25 and 45 m of equal tunnels
RECORDED, RECORDED_WEIGHT = ("tunnel", "nclt"), 10  # right placements in recordings are few, and robots of them have to get one map; with 5, one in a tunnel that is similar to itself everywhere would wait
PULL = 4  # strength with which falls are drawn to those in place: with 4, as many right placements of mines left out are believed as with 8 or 16, and one or two wrong ones fewer
STEEPEST = 20  # most a curve may fall if it fell like that over all its range: then 1 % of it moves no probability by over .05
MOST_ROCK = 7  # log2 of cubes per metre: no median is as high; until 2026-11-30 rows held the log2 of all cubes, 8 to 11
BENCH = os.path.dirname(os.path.abspath(__file__))
KNOWN = os.path.join(BENCH, "known_placements.csv")
IN_PLACE = os.path.join(BENCH, "..", "..", "server", "verification", "verdict_curves.hpp")
# Knots of each curve, whether larger values are worse (+1) or better (-1), and their unit.
CURVES = {
    "path that is shared": ([2, 3, 4, 4.5, 5, 5.5, 6, 6.2], -1, "log2 of metres"),
    "free space contradicts": ([-4, -3.3, -2.7, -2.3, -2, -1.7], 1, "log10 of a share"),
    "free space farther off contradicts": ([-3.5, -2.9, -2.6, -2.3, -2, -1.6], 1, "log10 of a share"),
    "points scatter about the surfaces": ([1.2, 1.5, 1.7, 1.9, 2.2, 2.8], 1, "times as much as about their own"),
    "places lie apart": ([0, 0.1, 0.25, 0.5, 1.2, 2.4, 4.8], 1, "m"),
    "places disagree": ([0, 0.15, 0.34, 0.6, 1], 1, "share"),
    "the mine repeats itself": ([0, 0.3, 1, 2, 4], 1, "aliases"),
    "places look alike": ([0, 0.4, 1, 1.6, 2.3, 3.2, 4], 1, "log2 of one more than look-alikes"),
    "places are similar": ([0, 0.07, 0.16, 0.26, 0.37, 0.5], 1, "per 100 m"),
    "walls hold it": ([0.02, 0.04, 0.06, 0.09, 0.13, 0.2], -1, "smallest eigenvalue"),
    "surfaces across the tunnel match": ([0, 0.12, 0.25, 0.45], -1, "share"),
    "descriptors agree": ([0.5, 0.65, 0.72, 0.78, 0.83, 0.88, 0.92, 0.96], -1, "similarity"),
    "descriptors differ over little path": ([0, 1], 1, "how far"),
    "gravity disagrees": ([0, 0.25, 0.5, 1, 2], 1, "degrees"),
    "walls match": ([0, 2, 4, 6, 9, 14], -1, "half-metre cells per metre"),
    "rock that both saw": ([2, 2.8, 3.3, 3.75, 4.15, 4.6, 5.2], -1, "log2 of cubes of a metre per metre"),
}
# Near by, .2 % cost at least 2.7, because with 2.3 all other curves at their best made up for a contradiction of 10 %.
# Farther off, right placements show .12 % and less, but for one, and wrong ones .17 % and more (eleven mines of rounds 20
# to 22 and generated ones, with the tolerance for drift); a drawn mine whose end alone differs, at .3 %, reached .903 over
# 88 m while the fall to .1 % was .9. Copies: few rows show any, so the falls are those of the fit to 139 mines, and the
# last keeps the known copy beside three of them waiting.
LEAST = {"free space contradicts": {-2.7: 2.7, -2.3: 3.4, -2: 2.6, -1.7: 2.6},
         "free space farther off contradicts": {-2.9: 1.1, -2.6: 3.1, -2.3: 3.1, -2: 3.1, -1.6: 3},
         "the mine repeats itself": {0.3: 1, 1: 0.7, 2: 0.3, 4: 1}, "places lie apart": {2.4: 4, 4.8: 4}, "places disagree": {0.6: 2, 1: 3}, "descriptors agree": {0.65: 2.5}, "descriptors differ over little path": {1: 3}, "gravity disagrees": {2: 3}}


def steps(term, values):
    """For each piece of the curve, how far down it the values lie, 0 to 1; a value that is not known lies nowhere."""
    knots, worse, _ = CURVES[term]
    down = [np.clip((values - a) / (b - a), 0, 1) for a, b in zip(knots, knots[1:])]
    return [d if worse > 0 else 1 - d for d in down]


def limits(term):
    """For each piece of the curve, the least and the most it may fall."""
    knots = CURVES[term][0]
    return [(LEAST.get(term, {}).get(b, 0), STEEPEST * (b - a) / (knots[-1] - knots[0])) for a, b in zip(knots, knots[1:])]


def descend(gradient, curvature, low, high, sweeps=100):
    """The step within low and high that makes the quadratic model least, one coordinate after the other."""
    step = np.zeros(len(gradient))
    slope = gradient.copy()
    for _ in range(sweeps):
        for i in range(len(step)):
            new = np.clip(step[i] - slope[i] / curvature[i, i], low[i], high[i])
            slope += curvature[:, i] * (new - step[i])
            step[i] = new
    return step


def usual_bias(fallen, y, weight):
    """The bias with which as much weight is believed as is right."""
    least, most = -50.0, 50.0
    for _ in range(50):
        middle = (least + most) / 2
        too_much = (weight / (1 + np.exp(np.clip(fallen - middle, -50, 50)))).sum() > weight[y == 1].sum()
        least, most = (least, middle) if too_much else (middle, most)
    return least


def fit(X, y, weight, low, high, drawn_to, rounds=60):
    """Bias and falls: Newton's method with limits. The falls are drawn to those given."""
    A, pull = np.c_[np.ones(len(y)), -X], PULL * (np.arange(X.shape[1] + 1) > 0)
    low, high = np.r_[-np.inf, low], np.r_[np.inf, high]
    drawn_to = np.clip(np.r_[usual_bias(X @ drawn_to, y, weight), drawn_to], low, high)

    def loss(c):
        z = A @ c
        return (weight * np.logaddexp(0, np.where(y == 1, -z, z))).sum() + (pull * (c - drawn_to) ** 2).sum() / 2

    c = drawn_to
    for _ in range(rounds):
        p = 1 / (1 + np.exp(-np.clip(A @ c, -50, 50)))
        gradient = A.T @ (weight * (p - y)) + pull * (c - drawn_to)
        curvature = (A * (weight * p * (1 - p))[:, None]).T @ A + np.diag(pull + 1e-3)
        step, before = descend(gradient, curvature, low - c, high - c), loss(c)
        size = 1.0
        while loss(c + size * step) > before and size > 1e-3:
            size /= 2
        c = c + size * step
        if before - loss(c) < 1e-6 * before:
            break
    return c


def falls_in_place(text):
    """The falls from knot to knot of the curves in a header, in the order of CURVES; a term that is new falls nowhere."""
    known = {term: [tuple(map(float, knot)) for knot in re.findall(r"\{(-?[0-9.e-]+), (-?[0-9.]+)\}", knots)]
             for term, knots in re.findall(r"^    // (.*)\n    \{\{(.*)\}\},$", text, re.M)}
    if not known:
        sys.exit("%s: no curves to draw the fit to; restore it (git checkout)" % IN_PLACE)
    falls = []
    for term, (knots, worse, _) in CURVES.items():
        at, values = np.array(known.get(term, [(0, 0)])).T
        falls += list(worse * -np.diff(np.interp(knots, at, values)))
    return np.array(falls)


def curve(term, falls, median):
    """Log-odds at the knots, 0 at the median; and what has to be added to the bias for that."""
    knots, worse, _ = CURVES[term]
    down = np.r_[0, -np.cumsum(falls)] if worse > 0 else np.r_[-np.cumsum(falls[::-1])[::-1], 0]
    usual = np.interp(median, knots, down)
    return list(zip(knots, down - usual)), usual


def write(out, c, medians, rows, y):
    bias, at, text, curves = c[0], 1, "", {}
    for term, median in medians.items():
        pieces = len(CURVES[term][0]) - 1
        knots, usual = curve(term, c[at:at + pieces], median)
        at += pieces
        bias += usual
        curves[term] = knots
        text += "    // %s\n    {{%s}},\n" % (term, ", ".join("{%g, %.2f}" % (k, v + 0.0) for k, v in padded(knots)))
    draw(os.path.join(os.path.dirname(out), "curves.svg"), curves)
    with open(out, "w") as f:
        f.write("#pragma once\n// Generated by tests/bench/fit_verdict.py on %s, %s\n\n" % (datetime.date.today(), made_from(rows, y)))
        f.write("#include <array>\n#include <string_view>\n\nnamespace headframe {\n\n"
                "/// The descriptor family of these placements. The similarity of other families' descriptors at "
                "right and wrong\n/// placements is not known, so the verdict ignores them.\n"
                "inline constexpr std::string_view verdict_family = \"learned\";\n\n"
                "/// What a wrong placement weighed in the fit, in right ones.\n"
                "inline constexpr double verdict_wrong_weight = %g;\n\n"
                "/// A point of a term's curve: the log-odds where it measures `at`.\n"
                "struct VerdictKnot {\n  double at = 0, log_odds = 0;\n};\n\n"
                "/// The log-odds of a placement that is usual in everything, and the curves of all terms, in the order "
                "of\n/// verdict_measures(). A curve with fewer knots than others ends in copies of its last one.\n"
                "inline constexpr double verdict_bias = %.2f;\n// clang-format off\n"
                "inline constexpr std::array<std::array<VerdictKnot, %d>, %d> verdict_curves{{\n%s}};\n// clang-format on\n\n"
                "}  // namespace headframe\n" % (WRONG_WEIGHT, bias, most_knots(), len(medians), text))


def draw(out, curves):
    """All curves, each over its own range, on one scale of log-odds that is cut off at the bottom."""
    wide, high, across, low = 230, 150, 4, -6
    top = max(v for knots in curves.values() for _, v in knots)
    parts = []
    for i, (term, knots) in enumerate(curves.items()):
        x0, y0 = 20 + wide * (i % across), 30 + high * (i // across)
        first, last = knots[0][0], knots[-1][0]
        def at(k, v):
            return "%.1f,%.1f" % ((wide - 40) * (k - first) / (last - first), (high - 50) * (top - v) / (top - low))
        parts.append('<text x="%d" y="%d">%s</text><svg x="%d" y="%d" width="%d" height="%d"><path class="zero" d="M%s L%s"/>'
                     '<polyline points="%s"/></svg><text class="end" x="%d" y="%d">%g</text><text class="end last" x="%d" y="%d">%g</text>'
                     '<text class="end unit" x="%d" y="%d">%s</text>'
                     % (x0, y0 - 8, term, x0, y0, wide - 40, high - 50, at(first, 0), at(last, 0),
                        " ".join(at(k, v) for k, v in knots), x0, y0 + high - 36, first, x0 + wide - 40, y0 + high - 36, last, x0 + (wide - 40) // 2, y0 + high - 36, CURVES[term][2]))
    rows = -(-len(curves) // across)
    with open(out, "w") as f:
        f.write('<svg xmlns="http://www.w3.org/2000/svg" width="%d" height="%d" font-family="sans-serif" font-size="11">'
                "<style>polyline{fill:none;stroke:#2a7;stroke-width:2}.zero{stroke:#bbb}.end{fill:#888;font-size:9px}.last{text-anchor:end}.unit{text-anchor:middle}</style>"
                '<rect width="100%%" height="100%%" fill="white"/>%s'
                '<text class="end" x="20" y="%d">log-odds from %g (cut off) to %.1f in each; grey: 0, the median of right placements</text></svg>\n'
                % (wide * across, rows * high + 30, "".join(parts), rows * high + 20, low, top))


def most_knots():
    return max(len(knots) for knots, _, _ in CURVES.values())


def padded(knots):
    return knots + [knots[-1]] * (most_knots() - len(knots))


def main(out, files):
    terms = list(CURVES)
    rows = load(files + [KNOWN], lambda r: r["source"] == "judged" and r["status"] == "converged" and float(r["tilt_deg"]) < 3,
                ["source", "status", "tilt_deg", "own_scatter_m", "right", "kind", "mine"] + ["term: " + t for t in terms])
    if np.nanmedian([float(r["term: rock that both saw"]) for r in rows]) > MOST_ROCK:
        sys.exit("%s: 'rock that both saw' is not per metre of tunnel; run ./run bench rejudge on these rows first" % ", ".join(files))
    y = np.array([float(r["right"]) for r in rows])
    values = {t: np.array([float(r["term: " + t]) for r in rows]) for t in terms}
    medians = {t: np.nanmedian(v[y == 1]) for t, v in values.items()}
    X = np.stack([s for t, v in values.items() for s in steps(t, np.where(np.isnan(v), medians[t], v))], 1)
    low, high = np.array([pair for t in terms for pair in limits(t)], float).T
    with open(IN_PLACE) as f:
        before = falls_in_place(f.read())
    kinds = np.array([r["kind"] for r in rows])
    known = kinds == "known"
    of_right = np.where(np.isin(kinds, RECORDED), RECORDED_WEIGHT, 1.0)
    weight = np.where(y == 1, of_right, WRONG_WEIGHT) * np.array([float(r.get("weight", 1)) for r in rows])
    left_out = np.zeros(len(y))
    print("%-18s %6s %8s %6s %8s" % ("kind left out", "right", ">= 0.9", "wrong", ">= 0.9"))
    for kind in sorted(set(kinds[~known])):
        here = kinds == kind
        c = fit(X[~here], y[~here], weight[~here], low, high, before)
        z = c[0] - X[here] @ c[1:]
        p, right = 1 / (1 + np.exp(-z)), y[here] == 1
        left_out[here] = 1 / (1 + np.exp(-z) / WRONG_WEIGHT)
        print("%-18s %6d %8d %6d %8d" % (kind, right.sum(), (p[right] >= ACCEPTED).sum(), (~right).sum(), (p[~right] >= ACCEPTED).sum()))
    print("told: log loss %.3f, expected calibration error %.3f" % (log_loss(left_out[~known], y[~known]), calibration_error(left_out[~known], y[~known])))
    write(out, fit(X, y, weight, low, high, before), medians, rows, y)


if __name__ == "__main__":
    run(main, __doc__)
