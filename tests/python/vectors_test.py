"""The plain Python client against the protocol's test vectors. HEADFRAME_VECTORS names their folder, HEADFRAME_LEARNED the network."""

import json
import os
import stat
import tempfile
import unittest

import numpy as np
from headframe.v1 import robot_pb2, types_pb2
from headframe_plain import cloud, credential, descriptor, geometry, keyframes, learned, protocol


def vectors(name):
    with open(os.path.join(os.environ["HEADFRAME_VECTORS"], name + ".json"), encoding="utf-8") as file:
        return json.load(file)


def pose(row):
    return geometry.pose(row[:3], row[3:])


def from_halves(text):
    return np.frombuffer(bytes.fromhex(text), "<f2").astype(float)


class Vectors(unittest.TestCase):
    def test_frames(self):
        for row in vectors("frames")["frames"]:
            reader = protocol.FrameReader()
            for byte in bytes.fromhex(row["frame"]):
                self.assertIsNone(reader.next())
                reader.feed(bytes([byte]))
            self.assertEqual(reader.next().hex(), row["payload"])
        for row in vectors("frames")["refused"]:
            reader = protocol.FrameReader()
            reader.feed(bytes.fromhex(row["bytes"]))
            self.assertRaises(protocol.LinkEnds, reader.next)

    def test_names(self):
        for row in vectors("names")["names"]:
            self.assertEqual(protocol.is_name(bytes.fromhex(row["utf8"])), row["accepted"], row["utf8"])

    def test_enrolments(self):
        for row in vectors("enrolments")["enrolments"]:
            if row["accepted"]:
                fingerprint, code = credential.parse_enrolment(row["text"])
                self.assertEqual((fingerprint.hex(), code.hex()), (row["fingerprint"], row["code"]))
            else:
                self.assertRaises(credential.Refused, credential.parse_enrolment, row["text"])

    def test_messages_are_parsed_and_a_keyframe_of_ours_has_the_same_fields(self):
        rows = vectors("messages")
        hello, keyframe = (robot_pb2.RobotMessage() for _ in range(2))
        hello.ParseFromString(bytes.fromhex(rows["hellos"][0]["messages"][0]))
        self.assertEqual((hello.hello.session.robot, hello.hello.spool_runs), ("scout", [5, 6]))
        keyframe.ParseFromString(bytes.fromhex(rows["keyframes"][0]["messages"][1]))
        self.assertEqual(keyframe.keyframe.q, descriptor.halves_of_q([1.5, 0]))
        self.assertEqual(keyframe.keyframe.w, descriptor.halves([0.25, 2]))
        p = keyframe.keyframe.T_local_sensor
        np.testing.assert_allclose(geometry.pose([p.x, p.y, p.z], [p.qx, p.qy, p.qz, p.qw])[:2, 0], np.cos([0.5, 0.5 - np.pi / 2]))

    def test_halves(self):
        rows = vectors("halves")
        for row in rows["values"]:
            if row["half"] is None:
                self.assertRaises(ValueError, descriptor.halves, [row["value"]])
            else:
                self.assertEqual(descriptor.halves([row["value"]]).hex(), row["half"], row)
        for row in rows["q"]:
            self.assertEqual(descriptor.halves_of_q(row["q"]).hex(), row["bytes"])

    def test_levelled_frame(self):
        rows = vectors("levelled_frame")
        for row in rows["levelled"]:
            level = geometry.levelled(pose(row["T_local_sensor"]), np.array(rows["points_sensor"]))
            np.testing.assert_allclose(level, row["points_level"], atol=1e-5)

    def test_quaternions_come_back(self):
        rng = np.random.default_rng(1)
        for q in [*np.eye(4), *rng.normal(size=(50, 4))]:
            q = q / np.linalg.norm(q)
            back = geometry.quaternion(geometry.pose([0, 0, 0], q)[:3, :3])
            self.assertAlmostEqual(abs(back @ q), 1)

    def test_wall_profile(self):
        rows = vectors("wall_profile")
        for row in rows["codes"]:
            self.assertEqual(descriptor.wall_code(row["range_m"]), row["code"], row)
        for row in rows["scans"]:
            ours = np.frombuffer(descriptor.wall_profile(np.array(row["points_level"])), np.uint8).astype(int)
            theirs = np.frombuffer(bytes.fromhex(row["walls"]), np.uint8).astype(int)
            self.assertLessEqual(abs(ours - theirs).max(), 1, row["what"])

    def test_scan_context(self):
        for row in vectors("scan_context")["scans"]:
            points = np.array(row["points_level"])
            self.assertEqual(len(points) >= descriptor.FEWEST_POINTS, row["described"])
            if row["described"]:
                q, w = descriptor.scan_context(points)
                np.testing.assert_allclose(q, row["q"], atol=1e-3)
                np.testing.assert_allclose(w, row["w"], atol=1e-3)
                np.testing.assert_allclose(from_halves(descriptor.halves_of_q(q).hex()), from_halves(row["q_bytes"]), rtol=2e-3, atol=1e-3)
                np.testing.assert_allclose(from_halves(descriptor.halves(w).hex()), from_halves(row["w_bytes"]), rtol=2e-3, atol=1e-3)

    def test_learned(self):
        family = learned.Learned(os.environ["HEADFRAME_LEARNED"])
        for row in vectors("learned")["scans"]:
            points = np.array(row["points_level"])
            image = learned.range_image(points)
            np.testing.assert_allclose(image.ravel(), row["image_m"], atol=2e-3, err_msg=row["what"])
            q, w, place_class = family.describe(points)
            np.testing.assert_allclose(q, row["q"], atol=1e-3)
            np.testing.assert_allclose(w, row["w"], atol=1e-2)
            self.assertEqual(place_class, row["place_class"])

    def test_keyframes(self):
        selector = keyframes.Selector()
        for i, row in enumerate(vectors("keyframes")["scans"]):
            self.assertEqual(selector.add(pose(row["T_local_sensor"]), row["mean_range_m"]), row["keyframe"], i)
            self.assertAlmostEqual(selector.spaciousness, row["spaciousness_m"], places=4)

    def test_sweeps(self):
        rows = vectors("sweeps")
        scan, sweeps, taken = np.array(rows["every_scan"]), keyframes.Sweeps(), None
        for row in rows["scans"]:
            T = pose(row["T_local_sensor"])
            taken = sweeps.take(T, scan) if row["keyframe"] else sweeps.add(T, scan)
        self.assertEqual(len(taken), len(rows["cloud_of_the_second_keyframe"]))
        for (origin, points), row in zip(taken, rows["cloud_of_the_second_keyframe"]):
            self.assertEqual(len(points), row["points"])
            np.testing.assert_allclose(origin, row["origin"], atol=1e-5)
            np.testing.assert_allclose(points.sum(axis=0), row["sum_of_points"], atol=1e-3)

    def test_clouds(self):
        for row in vectors("clouds")["clouds"]:
            sweeps = [(np.array(s["origin"]), np.array(s["points"], float).reshape(-1, 3)) for s in row["sweeps"]]
            self.assertEqual(cloud.content(sweeps, row["cell_m"], form=1).hex(), row["form_1"], row["what"])
            written = row.get("form_2") or row["written_as_form_1"]
            self.assertEqual(cloud.content(sweeps, row["cell_m"], form=2).hex(), written, row["what"])
            if "zstd_raw_blocks" in row:
                self.assertEqual(cloud.encode(sweeps, row["cell_m"], form=2).hex(), row["zstd_raw_blocks"])

    def test_clouds_with_intensity(self):
        for row in vectors("clouds")["with_intensity"]:
            sweeps = [(np.array(s["origin"]), np.array(s["points"], float).reshape(-1, 3), s["intensity"])
                      for s in row["sweeps"]]
            self.assertEqual(cloud.content([s[:2] for s in sweeps], row["cell_m"], form=2).hex(), row["without"], row["what"])
            self.assertEqual(cloud.content_with_intensity(sweeps, row["cell_m"]).hex(), row["form_3"], row["what"])
            for (_, _, intensity), read in zip(sweeps, row["intensity_read"]):
                self.assertEqual(sorted(round(255 * (cloud.intensity_level(i) / 31) ** 2) for i in intensity), sorted(read))

    def test_transforms(self):
        rows = vectors("transforms")
        ours = geometry.inverse(pose(rows["T_component_mine"])) @ pose(rows["T_component_other"])
        np.testing.assert_allclose(ours, pose(rows["T_mine_other"]), atol=1e-9)


class Credentials(unittest.TestCase):
    def test_is_private_and_the_code_goes_once_a_welcome_came(self):
        enrolment = "hf1-" + "a" * 64 + "-" + "b" * 32
        with tempfile.TemporaryDirectory() as folder:
            path = os.path.join(folder, "scout.credential")
            self.assertRaises(credential.Refused, credential.Credential, path, "scout")
            first = credential.Credential(path, "scout", enrolment)
            self.assertEqual(stat.S_IMODE(os.stat(path).st_mode), 0o600)
            again = credential.Credential(path, "scout", enrolment)
            self.assertEqual((again.token, again.code.hex()), (first.token, "b" * 32))
            again.confirmed()
            after = credential.Credential(path, "scout", enrolment)
            self.assertEqual((after.token, after.code), (first.token, b""))
            self.assertRaises(credential.Refused, credential.Credential, path, "hauler")
            os.chmod(path, 0o644)
            self.assertRaises(credential.Refused, credential.Credential, path, "scout")


class PosesThatChange(unittest.TestCase):
    """The protocol page's rules of PoseUpdate, beside a server that the test plays."""

    def setUp(self):
        hello = robot_pb2.Hello(clouds=robot_pb2.CLOUD_POLICY_NEVER)
        self.session = protocol.Session(hello, lambda sequence: b"", lambda update: None)

    def drive(self, keyframes):
        for _ in range(keyframes):
            self.session.keyframes.append(types_pb2.Keyframe(sequence=len(self.session.keyframes) + 1))

    def move(self, **x):
        """k3=9: keyframe 3 lies at x = 9 now."""
        moved = {int(name[1:]): types_pb2.Pose(x=value) for name, value in x.items()}
        self.session.updates.append((len(self.session.keyframes), moved))

    def welcome(self, keyframes=0, update=0, capabilities=("poses",)):
        self.session.disconnected()
        self.tell(welcome=robot_pb2.Welcome(protocol_version=1, durable_keyframes=keyframes, durable_pose_update=update,
                                            capabilities=capabilities))

    def tell(self, **body):
        self.session.receive(protocol.frame(robot_pb2.ServerMessage(**body)))

    def said(self):
        out = []
        while (framed := self.session.next_frame()) is not None:
            message = robot_pb2.RobotMessage()
            message.ParseFromString(framed[4:])
            out.append(message.pose_update if message.HasField("pose_update") else message.keyframe.sequence)
        return out

    def test_go_behind_the_keyframes_that_there_were_and_ahead_of_later_ones_and_those_that_wait_as_one(self):
        self.drive(3)
        self.move(k1=1, k2=2, k3=3)
        self.drive(1)
        self.move(k2=9)
        self.move(k2=10, k4=4)
        self.welcome()
        *keyframes, first, last_keyframe, both = self.said()
        self.assertEqual((keyframes, last_keyframe), ([1, 2, 3], 4))
        self.assertEqual((first.number, first.total_poses, [(r.first, len(r.T_local_sensor)) for r in first.runs]), (1, 3, [(1, 3)]))
        self.assertEqual((both.number, [(r.first, r.T_local_sensor[0].x) for r in both.runs]), (3, [(2, 10), (4, 4)]))
        self.tell(keyframe_ack=robot_pb2.KeyframeAck(durable_keyframes=4))
        self.tell(pose_update_ack=robot_pb2.PoseUpdateAck(durable_pose_update=1))
        self.assertFalse(self.session.all_acknowledged())
        self.welcome(keyframes=4, update=1)
        self.assertEqual([update.number for update in self.said()], [3], "again, for it was not acknowledged")
        self.tell(pose_update_ack=robot_pb2.PoseUpdateAck(durable_pose_update=3))
        self.assertTrue(self.session.all_acknowledged())

    def test_a_large_one_comes_in_parts(self):
        self.drive(500)
        self.session.updates.append((500, {s: types_pb2.Pose(x=s) for s in range(1, 501) if s != 7}))
        self.welcome(keyframes=500)
        parts = self.said()
        self.assertGreater(len(parts), 3)
        self.assertTrue(all(len(part.SerializeToString()) <= protocol.MOST_CHUNK_BYTES for part in parts))
        offset, moved = 0, []
        for part in parts:
            self.assertEqual((part.number, part.total_poses, part.offset), (1, 499, offset))
            offset += sum(len(run.T_local_sensor) for run in part.runs)
            moved += [(run.first + i, T.x) for run in part.runs for i, T in enumerate(run.T_local_sensor)]
        self.assertEqual(moved, [(s, s) for s in range(1, 501) if s != 7])

    def test_a_server_that_is_older_or_that_holds_what_nobody_sent(self):
        self.drive(1)
        self.move(k1=1)
        self.welcome(keyframes=1, capabilities=())
        self.assertEqual(self.said(), [])
        self.assertTrue(self.session.all_acknowledged())
        with self.assertRaises(protocol.LinkEnds) as end:
            self.welcome(keyframes=1, update=2)
        self.assertTrue(end.exception.permanent)
        self.welcome(keyframes=1)
        with self.assertRaises(protocol.LinkEnds) as end:
            self.tell(pose_update_ack=robot_pb2.PoseUpdateAck(durable_pose_update=1))
        self.assertFalse(end.exception.permanent)


if __name__ == "__main__":
    unittest.main()
