"""ROS into a real server: bags of ROS 1 (written by rosbag) and ROS 2, and the node beside a real master.

    python3 ros_test.py BIN_DIR OUT_DIR ROS_PACKAGE
"""

import math
import os
import re
import shutil
import socket
import sqlite3
import struct
import subprocess
import sys
import threading
import unittest
from pathlib import Path
from types import SimpleNamespace

import numpy as np

BIN, OUT, PACKAGE = (Path(sys.argv.pop(1)).absolute() for _ in range(3))
sys.path.insert(0, str(PACKAGE))

import genpy  # noqa: E402
import rosbag  # noqa: E402
from diagnostic_msgs.msg import DiagnosticArray  # noqa: E402
from geometry_msgs.msg import PoseStamped, Transform, TransformStamped  # noqa: E402
from headframe_ros import bags, corrected, messages, pairing  # noqa: E402
from nav_msgs.msg import OccupancyGrid, Odometry  # noqa: E402
from nav_msgs.msg import Path as PathMessage  # noqa: E402
from sensor_msgs.msg import PointCloud2, PointField  # noqa: E402
from std_msgs.msg import Empty  # noqa: E402
from tf2_msgs.msg import TFMessage  # noqa: E402

T_BASE_LIDAR = np.eye(4)
T_BASE_LIDAR[:3, :3] = messages.rotation_of(0, 0, math.sin(0.4), math.cos(0.4))
T_BASE_LIDAR[:3, 3] = 0.3, -0.1, 0.5


def pose(yaw, x, y, z):
    T = np.eye(4)
    T[:3, :3] = messages.rotation_of(0, 0, math.sin(yaw / 2), math.cos(yaw / 2))
    T[:3, 3] = x, y, z
    return T


def scans(folder):
    for (stamp_s, *t, x, y, z, w), path in zip(np.loadtxt(folder / "poses.txt"), sorted((folder / "scans").iterdir())):
        T = np.eye(4)
        T[:3, :3], T[:3, 3] = messages.rotation_of(x, y, z, w), t
        yield 100 + stamp_s, T, np.fromfile(path, np.float32).reshape(-1, 4)[:, :3]


def cloud_message(stamp_s, points):
    """As a driver writes it: padding between the fields and an intensity."""
    layout = np.dtype({"names": ["x", "y", "z", "intensity"], "formats": ["<f4"] * 4, "offsets": [0, 4, 8, 16],
                       "itemsize": 22})
    data = np.zeros(len(points), layout)
    data["x"], data["y"], data["z"] = points.T
    data["intensity"] = np.arange(len(points)) % 100
    out = PointCloud2(height=1, width=len(points), point_step=22, row_step=22 * len(points), data=data.tobytes())
    out.fields = [PointField(name, offset, PointField.FLOAT32, 1) for name, offset in
                  (("x", 0), ("y", 4), ("z", 8), ("intensity", 16))]
    out.header.stamp, out.header.frame_id = genpy.Time.from_sec(stamp_s), "lidar"
    return out


def odometry_message(stamp_s, T_local_base):
    out = Odometry(child_frame_id="base_link")
    out.header.stamp, out.header.frame_id = genpy.Time.from_sec(stamp_s), "odom"
    moved = messages.fill_transform(Transform(), T_local_base)
    out.pose.pose.position, out.pose.pose.orientation = moved.translation, moved.rotation
    return out


def mounting_message():
    out = TransformStamped(child_frame_id="lidar")
    out.header.frame_id = "base_link"
    messages.fill_transform(out.transform, T_BASE_LIDAR)
    return TFMessage([out])


def path_message(stamps_s, T_local_base, frame_id):
    out = PathMessage()
    out.header.frame_id = frame_id
    for stamp_s, T in zip(stamps_s, T_local_base):
        at, moved = PoseStamped(), messages.fill_transform(Transform(), T)
        at.header.stamp = genpy.Time.from_sec(stamp_s)
        at.pose.position, at.pose.orientation = moved.translation, moved.rotation
        out.poses.append(at)
    return out


def drive(folder, climb_m=0):
    """(topic, stamp, message) in order: odometry half a second before and after each cloud, as straight between two. It
    climbs by so much more with each scan."""
    T_lidar_base = np.linalg.inv(T_BASE_LIDAR)
    all_scans = [(s, pose(0, 0, 0, i * climb_m) @ T, points) for i, (s, T, points) in enumerate(scans(folder))]
    yield "/tf_static", 99.0, mounting_message()
    yield "/odom", 99.5, odometry_message(99.5, all_scans[0][1] @ T_lidar_base)
    for (stamp_s, T, points), (_, T_next, _) in zip(all_scans, all_scans[1:] + all_scans[-1:]):
        yield "/odom", stamp_s, odometry_message(stamp_s, T @ T_lidar_base)
        yield "/lidar", stamp_s + 0.1, cloud_message(stamp_s, points)
        middle = pairing.between(T @ T_lidar_base, T_next @ T_lidar_base, 0.5)
        yield "/odom", stamp_s + 0.5, odometry_message(stamp_s + 0.5, middle)


class Cdr:
    """Writes what ROS 2 would have recorded."""

    def __init__(self):
        self.out = bytearray()

    def put(self, kind, *values):
        size = struct.calcsize(kind)
        self.out += bytes(-len(self.out) % size) + struct.pack(f"<{len(values)}{kind}", *values)
        return self

    def text(self, text):
        self.put("I", len(text) + 1)
        self.out += text.encode() + b"\0"
        return self

    def header(self, header):
        return self.put("i", header.stamp.secs).put("I", header.stamp.nsecs).text(header.frame_id)

    def transform(self, p, q):
        return self.put("d", p.x, p.y, p.z, q.x, q.y, q.z, q.w)

    def message(self, m):
        if isinstance(m, TFMessage):
            self.put("I", len(m.transforms))
            for t in m.transforms:
                self.header(t.header).text(t.child_frame_id).transform(t.transform.translation, t.transform.rotation)
        elif isinstance(m, Odometry):
            self.header(m.header).text(m.child_frame_id).transform(m.pose.pose.position, m.pose.pose.orientation)
            self.put("d", *[0.0] * 78)
        elif isinstance(m, PathMessage):
            self.header(m.header).put("I", len(m.poses))
            for at in m.poses:
                self.header(at.header).transform(at.pose.position, at.pose.orientation)
        else:
            self.header(m.header).put("I", m.height, m.width, len(m.fields))
            for f in m.fields:
                self.text(f.name).put("I", f.offset).put("B", f.datatype).put("I", f.count)
            self.put("B", m.is_bigendian).put("I", m.point_step, m.row_step, len(m.data))
            self.out += m.data
            self.put("B", m.is_dense)
        return b"\0\1\0\0" + bytes(self.out)


KINDS = {"/tf_static": "tf2_msgs/msg/TFMessage", "/odom": "nav_msgs/msg/Odometry", "/lidar": "sensor_msgs/msg/PointCloud2"}
IN_BAGS = {**KINDS, "/slam/path": "nav_msgs/msg/Path"}


def write_ros1(file, told, **how):
    with rosbag.Bag(str(file), "w", **how) as bag:
        for topic, stamp_s, message in told:
            bag.write(topic, message, genpy.Time.from_sec(stamp_s))


def write_ros2(folder, told):
    folder.mkdir()
    with sqlite3.connect(folder / "drive_0.db3") as bag:
        bag.execute("CREATE TABLE topics(id INTEGER PRIMARY KEY, name TEXT, type TEXT, serialization_format TEXT)")
        bag.execute("CREATE TABLE messages(id INTEGER PRIMARY KEY, topic_id INTEGER, timestamp INTEGER, data BLOB)")
        ids = {topic: i + 1 for i, topic in enumerate(IN_BAGS)}
        bag.executemany("INSERT INTO topics VALUES (?, ?, ?, 'cdr')", [(ids[t], t, IN_BAGS[t]) for t in IN_BAGS])
        bag.executemany("INSERT INTO messages(topic_id, timestamp, data) VALUES (?, ?, ?)",
                        [(ids[t], int(s * 1e9), Cdr().message(m)) for t, s, m in told])


class Messages(unittest.TestCase):
    def test_clouds_of_every_layout_are_read(self):
        points = np.random.default_rng(3).normal(0, 9, (6, 3)).astype(np.float32)
        np.testing.assert_array_equal(messages.points_of(cloud_message(1, points)), points)
        for order, size in (("<", 8), (">", 4)):  # organised, rows padded by 5 bytes, doubles or big-endian
            row = [points[i:i + 3].astype(f"{order}f{size}").tobytes() + b"\x7f" * 5 for i in (0, 3)]
            fields = [SimpleNamespace(name=n, offset=i * size, datatype=8 if size == 8 else 7) for i, n in enumerate("xyz")]
            cloud = SimpleNamespace(fields=fields, is_bigendian=order == ">", point_step=3 * size, row_step=9 * size + 5,
                                    width=3, height=2, data=b"".join(row))
            np.testing.assert_array_equal(messages.points_of(cloud), points)
            cloud.data = cloud.data[:-1]
            self.assertRaisesRegex(ValueError, "bytes", messages.points_of, cloud)
            cloud.fields = fields[:2]
            self.assertRaisesRegex(ValueError, "'z'", messages.points_of, cloud)
        points[2, 1], points[4, 0] = np.nan, np.inf
        kept, intensity = messages.returns_of(cloud_message(1, points))
        self.assertEqual(len(kept), 4)
        np.testing.assert_array_equal(intensity, [0, 1, 3, 5])
        cloud = cloud_message(1, points)
        cloud.fields[3].name = "ring"
        self.assertIsNone(messages.returns_of(cloud)[1])
        cloud.fields[2].name, cloud.fields[3].name = "reflectivity", "z"
        np.testing.assert_array_equal(messages.returns_of(cloud)[1], points[np.isfinite(points[:, :2]).all(axis=1), 2])

    def test_rotations_come_back(self):
        for q in np.random.default_rng(4).normal(size=(200, 4)):
            q /= np.linalg.norm(q) * (-1 if q[3] < 0 else 1)
            np.testing.assert_allclose(messages.quaternion_of(messages.rotation_of(*q)), q, atol=1e-9)
        self.assertRaises(ValueError, messages.rotation_of, 0, 0, 0, 0)


class Pairing(unittest.TestCase):
    def test_a_cloud_gets_the_pose_of_its_stamp_once_it_is_known(self):
        pairs = pairing.Pairing()
        pairs.static("base", "mast", pose(0.2, 0, 0, 1))
        pairs.static("lidar", "mast", pose(-0.1, 1, 0, 0))  # the other way round
        pairs.cloud(10.25, "lidar", "a", "b")
        pairs.odometry(10, "base", pose(0.0, 0, 0, 0))
        self.assertEqual(pairs.take(), [])
        pairs.odometry(10.5, "base", pose(1.0, 4, 2, 0))
        ((stamp_s, T, points, intensity),) = pairs.take()
        self.assertEqual((stamp_s, points, intensity), (10.25, "a", "b"))
        np.testing.assert_allclose(T, pose(0.5, 2, 1, 0) @ pose(0.2, 0, 0, 1) @ np.linalg.inv(pose(-0.1, 1, 0, 0)), atol=1e-9)
        self.assertEqual((pairs.take(), pairs.lost), ([], {}))

    def test_what_can_not_be_placed_is_counted_with_the_reason(self):
        pairs = pairing.Pairing()
        pairs.odometry(10, "base", np.eye(4))
        pairs.odometry(11, "base", np.eye(4))
        pairs.odometry(11, "base", np.eye(4))
        pairs.odometry(12.001, "base", np.eye(4))
        for stamp_s, frame in ((9.9, "base"), (10.999, "base"), (11.5, "base"), (12.001, "lidar")):
            pairs.cloud(stamp_s, frame, None)
        self.assertEqual([s for s, *_ in pairs.take()], [10.999])
        self.assertEqual(pairs.lost, {"odometry that goes back in time": 1, "no odometry near its stamp": 2})
        pairs.end()
        self.assertEqual(pairs.lost["no transform from base to lidar"], 1)
        for i in range(pairing.MOST_WAITING + 3):
            pairs.cloud(100 + i, "base", None)
        self.assertEqual(pairs.lost["no odometry came for it"], 3)
        pairs.end()
        self.assertEqual(pairs.lost["no odometry came for it"], 3 + pairing.MOST_WAITING)

    def test_a_cloud_waits_for_the_transform_that_says_where_its_lidar_sits(self):
        pairs = pairing.Pairing()
        for stamp_s in (10, 11, 12):
            pairs.odometry(stamp_s, "base", np.eye(4))
        pairs.cloud(10.5, "lidar", None)
        pairs.cloud(11.5, "lidar", None)
        self.assertEqual(pairs.take(), [])
        pairs.static("base", "lidar", T_BASE_LIDAR)
        self.assertEqual([s for s, *_ in pairs.take()], [10.5, 11.5])
        for i in range(pairing.MOST_WAITING + 1):
            pairs.cloud(11.6 + 1e-3 * i, "camera", None)
        self.assertEqual((pairs.take(), pairs.lost), ([], {"no transform from base to camera": 1}))

    def test_hours_of_odometry_are_not_kept(self):
        pairs = pairing.Pairing()
        for i in range(20000):
            pairs.odometry(0.1 * i, "base", np.eye(4))
        self.assertLess(len(pairs._stamps), 1400)
        pairs.cloud(0.1 * 19750.5, "base", None)
        self.assertEqual(len(pairs.take()), 1)


class Robot:
    """What the corrected path asks of it."""

    def __init__(self, last_keyframe=0):
        self.last_keyframe, self.told = last_keyframe, []

    def correct(self, stamps_s, T_local_sensor, least_moved_m, least_turned_rad, later_ones):
        self.told.append((list(stamps_s), T_local_sensor, later_ones))
        return {1: T_local_sensor[0]}, len(stamps_s)


class CorrectedPath(unittest.TestCase):
    def listening(self, robot):
        pairs = pairing.Pairing(T_BASE_LIDAR)
        path = corrected.Corrected(robot, pairs)
        for i in range(20):
            pairs.odometry(100 + i, "base", pose(0, i, 0, 0))
        pairs.cloud(110, "lidar", "points")
        return pairs, path

    def test_of_another_frame_lays_odometry_where_its_newest_pose_does(self):
        robot = Robot()
        pairs, path = self.listening(robot)
        ((_, T, *_),) = path.scans(pairs.take())
        np.testing.assert_allclose(T, pose(0, 10, 0, 0) @ T_BASE_LIDAR, atol=1e-12)
        T_map_odom = pose(0.3, 5, 6, 7)
        path.path(path_message([105, 112], [pose(0, 5, 0, 0), T_map_odom @ pose(0, 12, 0, 0)], "map"), "odom")
        ((stamps, T_map_sensor, later_ones),) = robot.told
        self.assertEqual((stamps, later_ones, path.frame, path.moved), ([105, 112], True, "map", 1))
        np.testing.assert_allclose(T_map_sensor[1], T_map_odom @ pose(0, 12, 0, 0) @ T_BASE_LIDAR, atol=1e-9)
        pairs.cloud(115, "lidar", "points")
        ((_, T, *_),) = path.scans(pairs.take())
        np.testing.assert_allclose(T, T_map_odom @ pose(0, 15, 0, 0) @ T_BASE_LIDAR, atol=1e-9)
        path.path(path_message([5], [np.eye(4)], "map"), "odom")
        self.assertIn("ends before the odometry", path.warning)

    def test_of_the_odometrys_own_frame_leaves_it_as_it_is(self):
        robot = Robot()
        pairs, path = self.listening(robot)
        path.path(path_message([112], [pose(0.3, 5, 6, 7)], "odom"), "odom")
        self.assertFalse(robot.told[0][2], "what is newer than the path lies right already")
        ((_, T, *_),) = path.scans(pairs.take())
        np.testing.assert_allclose(T, pose(0, 10, 0, 0) @ T_BASE_LIDAR, atol=1e-12)

    def test_a_session_that_goes_on_waits_until_the_path_says_in_which_frame(self):
        pairs, path = self.listening(Robot(last_keyframe=3))
        self.assertEqual(path.scans(pairs.take()), [])
        self.assertEqual(pairs.lost, {"no corrected path yet": 1})
        path.path(path_message([112], [pose(0, 1, 0, 0) @ pose(0, 12, 0, 0)], "map"), "odom")
        pairs.cloud(115, "lidar", "points")
        self.assertEqual(len(path.scans(pairs.take())), 1)

    def test_one_whose_stamps_do_not_rise_is_refused(self):
        robot = Robot()
        _, path = self.listening(robot)
        with self.assertRaisesRegex(ValueError, "stamps of their own"):
            path.path(path_message([112, 112], [np.eye(4)] * 2, "map"), "odom")
        path.path(path_message([], [], "map"), "odom")
        self.assertEqual(robot.told, [])


def free_port():
    with socket.socket() as s:
        s.bind(("127.0.0.1", 0))
        return s.getsockname()[1]


class Bags(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        shutil.rmtree(OUT, ignore_errors=True)
        OUT.mkdir(parents=True)
        subprocess.run([BIN / "headframe-drawn-sessions", OUT / "drives"], check=True)
        write_ros1(OUT / "a.bag", drive(OUT / "drives" / "a"), compression="lz4")
        write_ros2(OUT / "b", drive(OUT / "drives" / "b"))
        cls.server = subprocess.Popen([BIN / "headframe-server", "--data", OUT / "data", "--insecure", "--listen", "127.0.0.1:0",
                                       "--http", "127.0.0.1:0"], stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True)
        ready = next(line for line in cls.server.stdout if "ready" in line)
        cls.address = ready.split("robots on ")[1].split(",")[0]

    @classmethod
    def tearDownClass(cls):
        cls.server.terminate()
        cls.server.wait()
        cls.server.stdout.close()

    def replay(self, robot, bag, *more):
        return subprocess.run([sys.executable, "-m", "headframe_ros.replay", "--server", self.address, "--insecure", "--robot",
                               robot, "--spool", OUT / robot, "--points", "/lidar", "--odometry", "/odom", *more, bag],
                              env=dict(os.environ, PYTHONPATH=f"{PACKAGE}:{os.environ['PYTHONPATH']}"),
                              capture_output=True, text=True, timeout=300)

    def test_both_kinds_hold_the_same_scans(self):
        write_ros2(OUT / "a_too", drive(OUT / "drives" / "a"))
        topics = list(KINDS)
        for (topic, one), (other_topic, two) in zip(bags.messages(OUT / "a.bag", topics), bags.messages(OUT / "a_too", topics)):
            self.assertEqual(topic, other_topic)
            if topic == "/lidar":
                self.assertEqual(messages.stamp_s(one.header), messages.stamp_s(two.header))
                np.testing.assert_array_equal(messages.points_of(one), messages.points_of(two))
            if topic == "/odom":
                np.testing.assert_array_equal(messages.pose_of(one.pose.pose), messages.pose_of(two.pose.pose))

    def test_1_a_bag_a_folder_and_a_node_become_one_map(self):
        done = self.replay("a", OUT / "a.bag")
        self.assertEqual((done.returncode, done.stderr), (0, ""), done.stdout)
        self.assertIn("66 scans became", done.stdout)
        again = self.replay("a", OUT / "a.bag")
        self.assertIn("66 scans became 0 keyframes", again.stdout, "what is spooled is not sent twice")
        port = free_port()
        told = Heard(port)
        node = subprocess.Popen(["roslaunch", "-p", str(port), "headframe_ros", "headframe.launch", f"server:={self.address}", "robot:=b",
                                 f"spool:={OUT / 'b_spool'}", "points:=/lidar", "odometry:=/odom", "map_radius:=8",
                                 "insecure:=true", "corrected:=/slam/path"], env=told.environment, stdout=subprocess.DEVNULL, stderr=subprocess.STDOUT)
        try:
            told.listen_and_drive(list(drive(OUT / "drives" / "b", climb_m=0.02)))
            told.close_loops(OUT / "drives" / "b")
            told.ask_for_a_merge()
            T_map_odom = told.wait("/tf", lambda m: m.transforms[0].header.frame_id == "map")
            path = told.wait("paths", lambda m: True)
            grid = told.wait("/headframe/coverage", lambda m: True)
            health = told.wait("/diagnostics", lambda m: m.status[0].level == 0)
            cloud = told.wait("/headframe/map", lambda m: m.width > 100)
        finally:
            node.terminate()
            node.wait()
        # Truth of the drawn mine: a's local frame, which the map's is, and b's.
        T_a_b = np.linalg.inv(pose(0, 2, 0, 1.2)) @ pose(2.3, 88, 0, 1.2)
        T = messages.pose_of(T_map_odom.transforms[0].transform)
        self.assertEqual(T_map_odom.transforms[0].child_frame_id, "odom")
        np.testing.assert_allclose(T[:3, 3], T_a_b[:3, 3], atol=0.6)
        np.testing.assert_allclose(T[:2, :2], T_a_b[:2, :2], atol=0.02)
        self.assertEqual(path.header.frame_id, "odom")
        first = path.poses[0].pose.position
        self.assertLess(np.abs((T @ [first.x, first.y, first.z, 1])[:2]).max(), 0.8, "a began at its own origin")
        cells = np.array(grid.data, np.int8).reshape(grid.info.height, grid.info.width)
        origin = grid.info.origin.position
        self.assertEqual(cells[int(0.5 - origin.y), int(10.5 - origin.x)], 0, "a drove there")
        self.assertTrue((cells == 100).any() and (cells == -1).any())
        self.assertEqual(cloud.header.frame_id, "odom")
        self.assertGreater({v.key: float(v.value) for v in health.status[0].values if v.key == "scans"}["scans"], 0)

    def test_2_another_format_of_bag_merges_too(self):
        done = self.replay("c", OUT / "b", "--linger", "30")
        self.assertEqual((done.returncode, done.stderr), (0, ""), done.stdout)
        self.assertRegex(done.stdout, "revision [0-9]+: [23] sessions on one map")

    def test_3_a_path_in_a_bag_moves_the_keyframes(self):
        """SLAM closes its loop at the end of the drive, and finds that the mine is level."""
        truth = list(scans(OUT / "drives" / "b"))
        path = path_message([s for s, *_ in truth], [T @ np.linalg.inv(T_BASE_LIDAR) for _, T, _ in truth], "odom")
        told = [*drive(OUT / "drives" / "b", climb_m=0.02), ("/slam/path", truth[-1][0] + 1, path)]
        write_ros1(OUT / "climbs.bag", told)
        write_ros2(OUT / "climbs", told)
        for bag in OUT / "climbs.bag", OUT / "climbs":
            done = self.replay(f"climbs_{bag.suffix[1:]}", bag, "--corrected", "/slam/path")
            self.assertEqual((done.returncode, done.stderr), (0, ""), done.stdout)
            keyframes, moved = (int(re.search(f"{before} ([0-9]+)", done.stdout)[1]) for before in ("became", "moved keyframes"))
            self.assertGreater(moved, 0.8 * keyframes)
            self.assertLessEqual(moved, keyframes, "one path moves each once")

    def test_what_can_not_be_played_is_said_in_one_line(self):
        write_ros1(OUT / "unmounted.bag", list(drive(OUT / "drives" / "short_0"))[1:])
        (OUT / "cut.bag").write_bytes((OUT / "a.bag").read_bytes()[:200000])
        (OUT / "junk.db3").write_bytes(b"no database" * 100)
        for bag, word, more in ((OUT / "cut.bag", "reindex", ()), (OUT / "junk.db3", "junk.db3", ()),
                                (OUT / "none.bag", "none.bag", ()), (OUT / "drives", "convert", ()),
                                (OUT / "a.bag", "/imu", ("--odometry", "/imu")),
                                (OUT / "a.bag", "no nav_msgs/Path", ("--odometry", "/odom", "--corrected", "/odom")),
                                (OUT / "a.bag", "no topic /tf", ("--mounting", *"0000001", "--tf", "odom")),
                                (OUT / "unmounted.bag", "no cloud has met", ())):
            with self.subTest(bag=bag, word=word):
                spool = OUT / f"spool_{bag.name}_{len(more)}"
                arguments = ["--points", "/lidar"] + (list(more) if more else ["--odometry", "/odom"])
                done = subprocess.run([sys.executable, "-m", "headframe_ros.replay", "--server", self.address, "--insecure", "--robot",
                                       "d", "--spool", spool, *arguments, bag], capture_output=True, text=True, timeout=120,
                                      env=dict(os.environ, PYTHONPATH=f"{PACKAGE}:{os.environ['PYTHONPATH']}"))
                self.assertEqual(done.returncode, 1)
                self.assertEqual(done.stderr.count("\n"), 1, done.stderr)
                self.assertIn(word, done.stderr)


class Heard:
    """A ROS node of the test: drives, and keeps what the node of the robot publishes."""

    def __init__(self, port):
        self.environment = dict(os.environ, ROS_MASTER_URI=f"http://127.0.0.1:{port}", ROS_HOSTNAME="127.0.0.1",
                                ROS_HOME=str(OUT / "ros"), ROS_LOG_DIR=str(OUT / "ros_log"),
                                ROS_PACKAGE_PATH=f"{PACKAGE}:{os.environ.get('ROS_PACKAGE_PATH', '/usr/share')}")
        self._changed, self._heard = threading.Condition(), {}
        self._port = port

    def listen_and_drive(self, told):
        os.environ.update(self.environment)
        import rospy
        import rosgraph
        while not rosgraph.is_master_online():
            threading.Event().wait(0.1)
        rospy.init_node("robot", disable_signals=True)
        kinds = {"/tf": TFMessage, "/headframe/coverage": OccupancyGrid, "/headframe/map": PointCloud2,
                 "/diagnostics": DiagnosticArray}
        for topic, kind in kinds.items():
            rospy.Subscriber(topic, kind, lambda m, topic=topic: self._take(topic, m))
        out = {topic: rospy.Publisher(topic, type(next(m for t, _, m in told if t == topic)), queue_size=1000, latch="static" in topic)
               for topic in KINDS}
        self.wait_for(lambda: all(one.get_num_connections() > 0 for one in out.values()))
        for topic, _, message in told:
            out[topic].publish(message)

    def close_loops(self, folder):
        """When all scans have come SLAM finds that the mine is level."""
        import rospy
        value = lambda m, key: float({v.key: v.value for v in m.status[0].values}.get(key, 0) or 0)  # noqa: E731
        self.wait("/diagnostics", lambda m: value(m, "scans") == 84)
        out = rospy.Publisher("/slam/path", PathMessage, queue_size=1)
        self.wait_for(lambda: out.get_num_connections() > 0)
        truth = list(scans(folder))
        out.publish(path_message([s for s, *_ in truth], [T @ np.linalg.inv(T_BASE_LIDAR) for _, T, _ in truth], "odom"))
        told = self.wait("/diagnostics", lambda m: value(m, "moves acknowledged") == 1)
        assert value(told, "keyframes moved") > 0.8 * value(told, "keyframes"), told.status[0]

    def ask_for_a_merge(self):
        """Until then the robot drives on, and an exact copy of the mine may lie ahead of it."""
        import rospy
        asks = rospy.Publisher("/headframe/merge", Empty, queue_size=1)
        self.wait_for(lambda: asks.get_num_connections() > 0)
        asks.publish(Empty())
        self.wait_for(lambda: [n for n, _ in rospy.get_published_topics("/headframe/paths")])
        name = rospy.get_published_topics("/headframe/paths")[0][0]
        rospy.Subscriber(name, PathMessage, lambda m: self._take("paths", m))

    def _take(self, topic, message):
        with self._changed:
            self._heard.setdefault(topic, []).append(message)
            self._changed.notify_all()

    def wait(self, topic, condition):
        found = lambda: [m for m in self._heard.get(topic, []) if condition(m)]  # noqa: E731
        with self._changed:
            assert self._changed.wait_for(found, 120), f"{topic}, the last: {self._heard.get(topic, [None])[-1]}"
            return found()[-1]

    @staticmethod
    def wait_for(condition):
        for _ in range(1200):
            if condition():
                return
            threading.Event().wait(0.1)
        raise AssertionError("it never came")


if __name__ == "__main__":
    unittest.main()
