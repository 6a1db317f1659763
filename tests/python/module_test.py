"""`import headframe`: two small drives into a real server, numpy in and numpy out; and what is refused.

    python3 module_test.py BIN_DIR OUT_DIR EXAMPLE
"""

import math
import shutil
import subprocess
import sys
import threading
import unittest
from pathlib import Path

import headframe
import numpy as np
from headframe.operator import BaseStation
from real_server import Server

BIN, OUT, EXAMPLE = (Path(sys.argv.pop(1)).absolute() for _ in range(3))


def scans(folder):
    for (stamp_s, *t, x, y, z, w), path in zip(np.loadtxt(folder / "poses.txt"), sorted((folder / "scans").iterdir())):
        T = np.eye(4)
        yaw = 2 * math.atan2(z, w)
        T[:2, :2] = [[math.cos(yaw), -math.sin(yaw)], [math.sin(yaw), math.cos(yaw)]]
        T[:3, 3] = t
        yield stamp_s, T, np.fromfile(path, np.float32).reshape(-1, 4)


def pose(yaw, x, y, z):
    T = np.eye(4)
    T[:2, :2] = [[math.cos(yaw), -math.sin(yaw)], [math.sin(yaw), math.cos(yaw)]]
    T[:3, 3] = x, y, z
    return T


class Waiting:
    """A callback that somebody waits for."""

    def __init__(self):
        self.told, self.changed = [], threading.Condition()

    def __call__(self, told):
        with self.changed:
            self.told.append(told)
            self.changed.notify_all()

    def wait_for(self, condition):
        with self.changed:
            assert self.changed.wait_for(lambda: any(map(condition, self.told)), 300), "it never came"
            return next(t for t in reversed(self.told) if condition(t))


class Module(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        shutil.rmtree(OUT, ignore_errors=True)
        OUT.mkdir(parents=True)
        subprocess.run([BIN / "headframe-drawn-sessions", OUT / "drives"], check=True)
        cls.server = Server(BIN, OUT / "data", "--insecure")
        cls.address = cls.server.address

    @classmethod
    def tearDownClass(cls):
        cls.server.stop()

    def robot(self, name, **more):
        return headframe.Robot(name, spool=str(OUT / ("spool-" + name)), server=self.address, insecure=True,
                               sensor=headframe.Sensor("drawn-32", 32, 22.5, 22.5, 60), **more)

    def test_two_robots_are_merged_and_the_second_is_told_what_the_first_knows(self):
        paths, coverage, mapped = Waiting(), Waiting(), Waiting()
        with self.robot("a") as a, self.robot("b") as b:
            keyframes = sum(a.add_scan(*scan) for scan in scans(OUT / "drives" / "a"))
            a.finish(120)
            self.assertEqual(a.progress.keyframes, keyframes)
            self.assertEqual(a.progress.keyframes_acknowledged, keyframes)
            b.trajectories(paths)
            b.coverage(coverage)
            for scan in scans(OUT / "drives" / "b"):
                b.add_scan(*scan)
            b.finish(120)
            path = paths.wait_for(lambda t: t.told and t.paths).paths[0]
            self.assertEqual(path.session, a.session)
            # Truth of the drawn mine: where the local frames of both lie in it.
            T_b_a = np.linalg.inv(pose(2.3, 88, 0, 1.2)) @ pose(0, 2, 0, 1.2)
            T = b.transforms.T_mine_other(b.session, a.session)
            np.testing.assert_allclose(T[:3, 3], T_b_a[:3, 3], atol=0.6)
            np.testing.assert_allclose(T[:2, :2], T_b_a[:2, :2], atol=0.02)
            support = b.transforms.support(b.session)
            self.assertEqual((support.merged_with, support.merges, support.confirmed), (a.session, 1, False))
            self.assertGreater(support.probability, 0.9)
            self.assertIsNone(b.transforms.support(a.session).merged_with)  # the anchor
            near, far = support.covariance(), support.covariance([30, 0, 0])
            self.assertLess(math.sqrt(near[0, 0]), 0.5)
            self.assertGreater(far[1, 1], near[1, 1])  # what is turned moves what lies far off
            np.linalg.cholesky(far)
            self.assertEqual(path.points.shape[1], 3)
            in_a = (np.linalg.inv(T_b_a) @ np.c_[path.points, np.ones(len(path.points))].T).T
            self.assertLess(np.abs(in_a[in_a[:, 0] < 26, 1]).max(), 0.7)  # it began along y = 0
            seen = coverage.wait_for(lambda c: c.told)
            middles, what, when, who = seen.cells()
            self.assertEqual(middles.shape, (len(what), 2))
            self.assertTrue((what & headframe.PATH).any() and (what & headframe.WALL).any())
            self.assertEqual({seen.sessions[n] for n in np.unique(who)} - {a.session, b.session}, set())
            b.map_around(np.linalg.inv(pose(2.3, 88, 0, 1.2))[:3] @ [30, 30, 1, 1], 5, 0.2, callback=mapped)
            points = mapped.wait_for(lambda m: True)
            self.assertEqual(points.refused, "")
            self.assertGreater(len(points.points), 100)

    def test_what_is_no_scan_or_pose_is_refused_and_nothing_is_lost(self):
        T, points = np.eye(4), np.random.default_rng(1).uniform(2, 9, (500, 3))
        with self.robot("c") as robot:
            for bad in (np.zeros((500, 2)), np.zeros(500)):
                self.assertRaises(ValueError, robot.add_scan, 1, T, bad)
            for bad in (2 * T, np.diag([1, 1, -1, 1]), np.full((4, 4), np.nan)):
                self.assertRaises(ValueError, robot.add_scan, 1, bad, points)
            self.assertRaises(TypeError, robot.add_scan, 1, np.eye(3), points)
            self.assertRaises(headframe.BadInput, robot.add_scan, 1, T, np.zeros((500, 3)))
            for bad in (np.ones(499), np.ones((500, 1)), 7):
                self.assertRaises(ValueError, robot.add_scan, 1, T, points, bad)
            self.assertTrue(robot.add_scan(1, T, points, intensity=np.arange(500, dtype=np.uint16) % 256))
            self.assertFalse(robot.add_scan(1, T, points.astype(np.float32)[::-1]))  # its stamp is not after the last
            robot.finish(60)
        robot.close()  # once more: harmless

    def test_a_robot_that_stands_still_is_seen_to_live(self):
        station = BaseStation(self.server.http)
        with self.robot("still") as robot:
            robot.add_scan(1, pose(0.5, 3, 4, 0), np.random.default_rng(2).uniform(2, 9, (500, 3)))
            robot.live(battery=0.83, health="left track slips")
            told = [e for e, _ in zip((e for e in station.events() if e["type"] == "live" and e["robot"] == "still"), range(2))][-1]
            self.assertAlmostEqual(told["live"]["battery"], 0.83, 6)
            self.assertEqual(told["live"]["health"], "left track slips")
            self.assertEqual([round(told["live"]["T_session_sensor"][i], 6) for i in (3, 7, 11)], [3, 4, 0])
            self.assertEqual(told["keyframes"], 1)  # none of it is stored
            self.assertLess(station.session("still")["live"]["age_s"], 30)
            table = subprocess.run([BIN / "headframe", "--http", self.server.http, "sessions"], capture_output=True, text=True)
            self.assertRegex(table.stdout, r"still/.* s ago, 83 %, left track slips")
            for bad in (1.5, -1, math.nan):
                self.assertRaises(ValueError, robot.live, bad)
            self.assertRaises(ValueError, robot.live, None, "", np.full((4, 4), np.nan))

    def test_where_keyframes_lie_now_is_told_when_slam_moves_the_past(self):
        station = BaseStation(self.server.http)
        with self.robot("slam") as robot:
            points = np.random.default_rng(3).uniform(2, 9, (500, 3))
            for i in range(3):
                self.assertTrue(robot.add_scan(1 + i, pose(0, 15 * i, 0, 0), points))
            self.assertEqual(robot.last_keyframe, 3)
            robot.update_poses({2: pose(0.1, 14, 1, 0), 3: pose(0.2, 28, 3, 0)})
            for bad in ({}, {4: np.eye(4)}, {0: np.eye(4)}, {1: 2 * np.eye(4)}):
                self.assertRaises(ValueError, robot.update_poses, bad)
            stamps, path = [1, 2, 3], [pose(0, 0, 0, 0), pose(0.1, 14, 1, 0), pose(0.2, 28, 5, 0)]
            moved, matched = robot.correct(stamps, path)
            self.assertEqual((list(moved), matched), ([3], 3))
            np.testing.assert_allclose(moved[3], path[2], atol=1e-9)
            self.assertEqual(robot.correct(stamps, path), ({}, 3), "nothing has moved since")
            self.assertEqual(robot.correct([50], path[:1]), ({}, 0))
            for bad in (([1, 1, 3], path), (stamps, path[:2]), (stamps, [np.ones((4, 4))] * 3)):
                self.assertRaises(ValueError, robot.correct, *bad)
            robot.finish(60)
            self.assertEqual((robot.progress.pose_updates, robot.progress.pose_updates_acknowledged), (2, 2))
            self.assertFalse(robot.progress.pose_updates_unsupported)
        path_m = math.hypot(14, 1) + math.hypot(14, 4)  # when the merge has taken in both updates, at once or one by one
        next(e for e in station.events() if abs(station.session("slam")["distance_m"] - path_m) < 1e-3)
        self.assertGreater(station.session("slam")["moves"], 0)

    def test_what_can_not_be_opened_says_why(self):
        self.assertRaisesRegex(ValueError, "robot", self.robot, "a/b")
        self.assertRaisesRegex(ValueError, "clouds", self.robot, "d", clouds="some")
        with self.assertRaises((headframe.Error, ValueError)):
            self.robot("e", family="none of these")

    def test_a_callback_that_fails_harms_nobody_and_may_be_taken_away(self):
        raised = []
        before, sys.unraisablehook = sys.unraisablehook, lambda what: raised.append(what.exc_type)
        try:
            with self.robot("f") as robot:
                came = Waiting()

                def fails(told):
                    came(told)
                    raise KeyError("planned")

                robot.trajectories(fails)
                self.assertFalse(came.wait_for(lambda t: True).told)
                robot.trajectories(None)
            self.assertEqual(raised, [KeyError])
        finally:
            sys.unraisablehook = before

    def test_a_robot_that_nobody_closes_ends_with_the_interpreter(self):
        script = ("import headframe\n"
                  f"r = headframe.Robot('g', spool={str(OUT / 'spool-g')!r}, server={self.address!r}, insecure=True)\n"
                  "r.trajectories(lambda t: None)\n")
        done = subprocess.run([sys.executable, "-c", script], timeout=60)
        self.assertEqual(done.returncode, 0)

    def test_the_example_enrols_and_sends_a_recording(self):
        server = Server(BIN, OUT / "guarded")
        try:
            added = subprocess.run([BIN / "headframe", "--http", server.http, "--token-file", OUT / "guarded" / "operator.token",
                                    "robot", "add", "example"], check=True, capture_output=True, text=True).stdout
            enrolment = next(word for word in added.split() if word.startswith("hf1-"))
            done = subprocess.run([sys.executable, EXAMPLE, OUT / "drives" / "short_0", server.address, enrolment], cwd=OUT,
                                  timeout=120)
            self.assertEqual(done.returncode, 0)
        finally:
            server.stop()

    def test_the_stubs_name_what_there_is(self):
        import ast
        stub = ast.parse((Path(headframe.__file__).parent / "__init__.pyi").read_text())
        classes = [node for node in stub.body if isinstance(node, ast.ClassDef)]
        for node in classes:
            named = {b.name for b in node.body if isinstance(b, ast.FunctionDef)}
            named |= {b.target.id for b in node.body if isinstance(b, ast.AnnAssign)}
            made = getattr(headframe, node.name)
            own = {m for kind in ([made, headframe._robot.Robot] if node.name == "Robot" else [made]) for m in vars(kind)}
            if node.name != "Error":
                self.assertEqual({n for n in named if n[0] != "_"}, {m for m in own if m[0] != "_"}, node.name)
        self.assertEqual(set(headframe.__all__), {node.name for node in classes} | {"FREE", "WALL", "PATH"})


if __name__ == "__main__":
    unittest.main()
