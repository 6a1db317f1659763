"""Labelled placements for the fits: rows that ./run bench stages, merges, recordings and drawn-mines write."""
import csv
import os
import sys

import numpy as np


def load(files, wanted, columns):
    """The rows of the files that are wanted; ends the program in one line if a file cannot be used."""
    rows = []
    for name in files:
        if not os.path.exists(name):
            sys.exit("%s: no such file" % name)
        with open(name, newline="", errors="replace") as f:
            reader = csv.DictReader(f)
            missing = [c for c in columns if c not in (reader.fieldnames or [])]
            if missing:
                sys.exit("%s: no column %r: not rows of ./run bench stages, merges, recordings or drawn-mines, or older ones, "
                         "which ./run bench rejudge judges anew if they hold all evidence" % (name, missing[0]))
            for row in reader:
                if None in row.values():
                    sys.exit("%s, line %d: cut short: run the bench again" % (name, reader.line_num))
                row["kind"] = row["kind"].rstrip("0123456789")  # cave31 is a cave
                if wanted(row):
                    rows.append(row)
    if len({r["kind"] for r in rows}) < 2:
        sys.exit("%s: placements of fewer than two kinds of mines, so none can be left out" % " ".join(files))
    return rows


def log_loss(p, y):
    p = np.clip(p, 1e-9, 1 - 1e-9)
    return -(y * np.log(p) + (1 - y) * np.log(1 - p)).mean()


def calibration_error(p, y):
    """Expected calibration error, in ten bins."""
    bins = np.minimum((10 * p).astype(int), 9)
    return sum(abs((p - y)[bins == b].sum()) for b in range(10)) / len(y)


def made_from(rows, y):
    return "from %d right and %d wrong placements in %d mines of\n// %d kinds. Drawn to the curves that these replaced." % (
        y.sum(), len(y) - y.sum(), len({r["mine"] for r in rows}), len({r["kind"] for r in rows}))


def run(main, doc):
    if len(sys.argv) < 3:
        sys.exit(doc)
    try:
        main(sys.argv[1], sys.argv[2:])
    except ValueError as error:
        sys.exit("a row is damaged (%s): ./run bench rejudge ROWS.csv says which" % error)
    except OSError as error:
        sys.exit("%s: %s" % (error.filename or sys.argv[1], error.strerror))
