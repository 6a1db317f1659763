"""The fit of the verdict's curves finds the curves that made the labels, keeps their direction and their limits, and
writes a header that reads as it was fitted."""
import csv
import os
import re
import subprocess
import sys
import tempfile

import numpy as np

BENCH = os.path.join(os.path.dirname(__file__), "..", "bench")
sys.path.insert(0, BENCH)
import fit_verdict as fit  # noqa: E402


def drawn(count, rng):
    """Measures of each term, spread over its knots, and labels by known falls: 3 over all of two curves, else 0."""
    values = {t: rng.uniform(knots[0], knots[-1], count) for t, (knots, _, _) in fit.CURVES.items()}
    z = np.full(count, 2.0)
    for term in ("path that is shared", "places look alike"):
        knots, worse, _ = fit.CURVES[term]
        share = (values[term] - knots[0]) / (knots[-1] - knots[0])
        z -= 3 * (share if worse > 0 else 1 - share)
    return values, (rng.uniform(size=count) < 1 / (1 + np.exp(-z))).astype(float)


def fitted(values, y):
    X = np.stack([s for t, v in values.items() for s in fit.steps(t, v)], 1)
    low, high = np.array([pair for t in values for pair in fit.limits(t)], float).T
    return fit.fit(X, y, np.ones(len(y)), low, high, np.zeros(X.shape[1])), low, high


def total(c, term):
    at = 1
    for t, (knots, _, _) in fit.CURVES.items():
        if t == term:
            return c[at:at + len(knots) - 1].sum()
        at += len(knots) - 1


def finds_what_made_the_labels():
    fit.LEAST, fit.PULL = {}, 0.1
    c, low, high = fitted(*drawn(20000, np.random.default_rng(3)))
    assert (c[1:] >= low).all() and (c[1:] <= high + 1e-9).all()
    for term in fit.CURVES:
        expected = 3 if term in ("path that is shared", "places look alike") else 0
        assert abs(total(c, term) - expected) < 0.4, (term, total(c, term))


def keeps_directions_and_limits():
    """Labels that rise towards the worse side of a measure bend no curve upwards."""
    values, _ = drawn(2000, np.random.default_rng(4))
    y = (values["the mine repeats itself"] > 1).astype(float)
    fit.LEAST = {"places lie apart": {2.4: 4}}
    c, low, high = fitted(values, y)
    assert total(c, "the mine repeats itself") < 1e-9
    assert total(c, "places lie apart") >= 4 and (c[1:] <= high + 1e-9).all()


def writes_what_the_product_reads(folder):
    rows, out = os.path.join(folder, "rows.csv"), os.path.join(folder, "curves.hpp")
    values, y = drawn(600, np.random.default_rng(5))
    with open(rows, "w", newline="") as f:
        csv_rows = csv.writer(f)
        csv_rows.writerow(["source", "kind", "mine", "right", "status"] + ["term: " + t for t in values] + ["tilt_deg", "own_scatter_m"])
        for i in range(len(y)):
            csv_rows.writerow(["judged", "cave%d" % (i % 2) if i % 3 else "rough1", "m%d" % (i % 9), int(y[i]), "converged"]
                              + [v[i] for v in values.values()] + [0.1, 0.06])
    done = subprocess.run([sys.executable, os.path.join(BENCH, "fit_verdict.py"), out, rows], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    assert "cave " in done.stdout and "rough " in done.stdout, done.stdout
    product = open(os.path.join(BENCH, "..", "..", "server", "verification", "verdict_curves.hpp")).read()
    for text in (open(out).read(), product):
        curves = [[tuple(map(float, knot.split(","))) for knot in re.findall(r"\{([-0-9.e]+, [-0-9.]+)\}", line)]
                  for line in text.splitlines() if line.startswith("    {{{")]
        assert re.findall(r"^    // (.*)$", text, re.M) == list(fit.CURVES), "the terms, in their order"
        for (term, (knots, worse, _)), curve in zip(fit.CURVES.items(), curves):
            assert [k for k, _ in curve[:len(knots)]] == [float("%g" % k) for k in knots], term
            falls = -worse * np.diff([v for _, v in curve])
            assert (falls >= -0.011).all(), (term, curve)
    assert os.path.getsize(os.path.join(folder, "curves.svg")) > 1000
    refused = subprocess.run([sys.executable, os.path.join(BENCH, "fit_verdict.py"), out, rows + ".none"], capture_output=True, text=True)
    assert refused.returncode != 0 and "no such file" in refused.stderr
    with open(rows) as f:
        of_cubes = list(csv.DictReader(f))
    with open(rows, "w", newline="") as f:
        out_rows = csv.DictWriter(f, list(of_cubes[0]))
        out_rows.writeheader()
        out_rows.writerows({**r, "term: rock that both saw": float(r["term: rock that both saw"]) + 6} for r in of_cubes)
    refused = subprocess.run([sys.executable, os.path.join(BENCH, "fit_verdict.py"), out, rows], capture_output=True, text=True)
    assert refused.returncode != 0 and "not per metre" in refused.stderr and "rejudge" in refused.stderr


with tempfile.TemporaryDirectory() as of_test:
    writes_what_the_product_reads(of_test)
finds_what_made_the_labels()
keeps_directions_and_limits()
