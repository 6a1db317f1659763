"""Mines laid out of tiles (tests/bench/lay_out_mine.py): every opening leads somewhere, and the same seed lays out the same mine."""

import math
import os
import re
import subprocess
import sys
import unittest

TOOL = os.path.join(os.path.dirname(__file__), "..", "bench", "lay_out_mine.py")
sys.path.insert(0, os.path.dirname(TOOL))
import lay_out_mine  # noqa: E402

OPENINGS = {name: openings for pieces in lay_out_mine.TUNNELS.values() for name, openings, _ in pieces}
POSE = re.compile(r"model://(\S+?)</uri><pose>(\S+) (\S+) (\S+) 0 0 (\S+)</pose>")


def tiles(kind, seed):
    return [(m[1], float(m[2]), float(m[3]), float(m[4]), float(m[5])) for m in POSE.finditer(lay_out_mine.lay_out(kind, seed))]


def doors(name, x, y, z, yaw):
    """Where the openings of a tile lie, with their height."""
    for heading, rise in OPENINGS[name].items():
        angle = heading * math.pi / 2 + yaw
        yield round(x + 10 * math.cos(angle)), round(y + 10 * math.sin(angle)), round(z + rise)


class LayOutMine(unittest.TestCase):
    def test_every_opening_of_a_tunnel_meets_another_or_a_blocker(self):
        for kind in lay_out_mine.TUNNELS:
            for seed in range(30):
                laid_out = tiles(kind, seed)
                blockers = [(round(t[1]), round(t[2]), round(t[3])) for t in laid_out if t[0] == "tunnel_tile_blocker"]
                pieces = [t for t in laid_out if t[0] != "tunnel_tile_blocker"]
                all_doors = [door for piece in pieces for door in doors(*piece)]
                for door in all_doors:
                    self.assertGreaterEqual(all_doors.count(door) + blockers.count(door), 2, (kind, seed, door))

    def test_no_cell_holds_two_tiles(self):
        for kind in ("cave", "few_kinds", "rough", "smooth", "mixed"):
            cells = [(t[1], t[2]) for t in tiles(kind, 1) if t[0] != "tunnel_tile_blocker"]
            self.assertEqual(len(cells), len(set(cells)), kind)
            self.assertLessEqual(len(cells), max(lay_out_mine.TUNNEL_TILES, lay_out_mine.CAVE_COLUMNS * lay_out_mine.CAVE_ROWS))

    def test_few_kinds_are_four(self):
        self.assertLessEqual(len({t[0] for t in tiles("few_kinds", 3)}), 4)
        self.assertEqual(len({t[0] for t in tiles("cave", 3)}), 10)

    def test_the_same_seed_lays_out_the_same_mine_and_another_does_not(self):
        first = subprocess.run([sys.executable, TOOL, "mixed", "5"], capture_output=True, text=True)
        self.assertEqual(first.returncode, 0)
        self.assertEqual(first.stdout, lay_out_mine.lay_out("mixed", "5"))
        self.assertNotEqual(first.stdout, lay_out_mine.lay_out("mixed", "6"))

    def test_an_unknown_kind_is_refused_by_name(self):
        refused = subprocess.run([sys.executable, TOOL, "sewer", "5"], capture_output=True, text=True)
        self.assertEqual((refused.returncode, refused.stdout), (2, ""))
        self.assertIn("'sewer'", refused.stderr)
        self.assertIn("few_kinds", refused.stderr)
        self.assertEqual(subprocess.run([sys.executable, TOOL], capture_output=True).returncode, 2)

    def test_a_full_disk_gets_one_line(self):
        with open("/dev/full", "w") as full:
            failed = subprocess.run([sys.executable, TOOL, "cave", "5"], stdout=full, stderr=subprocess.PIPE, text=True)
        self.assertEqual(failed.returncode, 1)
        self.assertEqual(failed.stderr.count("\n"), 1, failed.stderr)
        self.assertIn("cannot be written", failed.stderr)


if __name__ == "__main__":
    unittest.main()
