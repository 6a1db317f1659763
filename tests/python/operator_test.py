"""headframe.operator over a real server: what it asks, decides, exports and hears; whom it trusts; and what is no server.

    python3 operator_test.py BIN_DIR OUT_DIR README
"""

import contextlib
import io
import os
import re
import shutil
import socket
import subprocess
import sys
import threading
import unittest
from pathlib import Path

from headframe.operator import BaseStation, Fault
from real_server import Server

BIN, OUT, README = (Path(sys.argv.pop(1)).absolute() for _ in range(3))


def fault_of(call, *args, **named):
    try:
        call(*args, **named)
    except Fault as fault:
        return fault
    raise AssertionError("it went well")


class Merged(unittest.TestCase):
    """Two drives that meet are merged."""

    @classmethod
    def setUpClass(cls):
        cls.out = OUT / "merged"
        cls.out.mkdir(parents=True)
        cls.server = Server(BIN, cls.out / "data")
        cls.station = BaseStation(cls.server.http, token_file=cls.server.token_file)
        for robot in ("a", "b"):
            cls.server.play(robot, OUT / "drives" / robot, "--enrol", cls.station.add_robot(robot), "--clouds", "all")
        cls.atlas = cls.station.merge(wait_s=300)

    @classmethod
    def tearDownClass(cls):
        cls.server.stop()

    def test_what_it_knows(self):
        self.assertFalse(self.atlas["waited_out"])
        self.assertEqual([len(c["sessions"]) for c in self.atlas["components"]], [2])
        self.assertEqual(self.station.status()["sessions"], 2)
        self.assertEqual({s["robot"] for s in self.station.sessions()}, {"a", "b"})
        self.assertEqual(self.station.session("b")["robot"], "b")
        self.assertEqual([a["state"] for a in self.station.alignments("published")], ["published"])
        self.assertEqual(self.station.alignments(id=999), [])
        self.assertIn("outcome", self.station.explain("a", "b"))
        self.assertEqual(self.station.get("/api/v1/changes", since=0)["changes"], [])

    def test_a_merge_is_taken_back_and_made_again_and_events_tell_of_it(self):
        events, watched = self.station.events(), self.station.watch()
        first = next(events)
        self.assertEqual(first["type"], "snapshot")
        self.assertEqual(len(first["sessions"]["sessions"]), 2)
        self.assertEqual(len(next(watched)), 2)
        alignment = self.station.alignments("published")[0]["id"]
        self.station.retract(alignment)
        told = next(event for event in events if event["type"] == "alignment")
        self.assertNotEqual(told["alignment"]["state"], "published")
        self.assertEqual(len(next(watched)), 2)
        self.station.undo(alignment)
        self.assertTrue(any(event["type"] == "revision" for event in iter(lambda: next(events), None)))
        refusal = fault_of(self.station.refuse, alignment)
        self.assertEqual(refusal.status, 403)
        self.assertIn("retract it instead", str(refusal))
        self.station.retract(alignment)
        self.assertEqual(self.station.confirm(alignment)["alignment"]["state"], "published")
        self.assertEqual(fault_of(self.station.refuse, 999).status, 404)
        events.close()
        watched.close()

    def test_a_doubtful_one_is_confirmed_all_the_same_only(self):
        row = {"id": 7, "state": "rejected", "evidence": {"probability": 0.2}}
        station = BaseStation(self.server.http, token_file=self.server.token_file)
        station.alignments = lambda id: [row]
        fault = fault_of(station.confirm, 7)
        self.assertEqual(fault.status, 403)
        self.assertIn("0.200", str(fault))
        self.assertEqual(fault_of(station.confirm, 7, all_the_same=True).status, 404)  # the server was asked
        row["evidence"]["probability"] = 0.5
        self.assertEqual(fault_of(station.confirm, 7).status, 404)

    def test_files_are_whole_or_not_there(self):
        cloud, path = str(self.out / "map.ply"), str(self.out / "a.csv")
        self.assertEqual(self.station.export("a", cloud, voxel_m=0.2), os.path.getsize(cloud))
        self.assertEqual(open(cloud, "rb").read(3), b"ply")
        self.station.export(self.atlas["components"][0]["id"], str(self.out / "plan.svg"))
        self.assertGreater(self.station.trajectory("a", path), 0)
        self.station.backup(str(self.out / "backup"))
        self.assertEqual((self.out / "backup").stat().st_mode & 0o777, 0o600)
        self.assertIn(".ply", str(fault_of(self.station.export, "a", str(self.out / "map.e57"))))
        self.assertIn("scale", str(fault_of(self.station.export, "a", cloud, scale=500)))
        self.assertIn("cannot write", str(fault_of(self.station.export, "a", str(self.out / "none" / "map.ply"))))
        self.assertEqual(fault_of(self.station.export, 999, str(self.out / "other.ply")).status, 404)
        self.assertEqual({p.name for p in self.out.iterdir()}, {"data", "map.ply", "plan.svg", "a.csv", "backup"})

    def test_names_tokens_and_robots_that_are_not_there(self):
        self.assertIn("a/", str(fault_of(self.station.session, "z")))
        wrong = self.out / "data" / "wrong.token"
        wrong.write_text("0" * 64)
        wrong.chmod(0o644)
        self.assertIn("chmod 600", str(fault_of(BaseStation, self.server.http, token_file=str(wrong))))
        wrong.chmod(0o600)
        self.assertEqual(fault_of(BaseStation(self.server.http, token_file=str(wrong)).status).status, 401)
        wrong.write_text("two words")
        self.assertIn("one word", str(fault_of(BaseStation, self.server.http, token_file=str(wrong))))
        wrong.unlink()
        self.assertIn("no token", str(fault_of(BaseStation, self.server.http, token_file=str(wrong))))

    def test_the_example_of_the_readme(self):
        example = re.search(r"```python\n(from headframe\.operator.*?)```", README.read_text(), re.DOTALL)[1]
        self.assertLessEqual(example.count("\n"), 20)
        environment = {**os.environ, "HEADFRAME_TOKEN_FILE": self.server.token_file}
        example = example.replace("127.0.0.1:7448", self.server.http).replace("map.ply", str(OUT / "example.ply"))
        self.assertIn("for event in station.events():", example)
        example = example.replace("for event in station.events():", "for _, event in zip(range(1), station.events()):")
        done = subprocess.run([sys.executable, "-c", example], env=environment, timeout=120, capture_output=True, text=True)
        self.assertEqual((done.returncode, done.stderr), (0, ""))
        self.assertTrue((OUT / "example.ply").exists())


class Trusted(unittest.TestCase):
    """Over HTTPS the server is known before it is sent anything."""

    @classmethod
    def setUpClass(cls):
        cls.server = Server(BIN, OUT / "trusted", http="0.0.0.0:0")
        cls.address = "https://127.0.0.1:" + cls.server.http.rpartition(":")[2]
        cls.elsewhere = OUT / "elsewhere"
        cls.elsewhere.mkdir()
        shutil.copy(cls.server.token_file, cls.elsewhere / "token")

    @classmethod
    def tearDownClass(cls):
        cls.server.stop()

    def station(self, **trust):
        return BaseStation(self.address, token_file=str(self.elsewhere / "token"), **trust)

    def test_by_its_fingerprint_or_by_what_lies_beside_the_token(self):
        self.assertEqual(self.station(fingerprint=self.server.fingerprint.upper()).status()["sessions"], 0)
        self.assertEqual(next(self.station(fingerprint=self.server.fingerprint).events())["type"], "snapshot")
        self.assertEqual(BaseStation(self.address, token_file=self.server.token_file).status()["sessions"], 0)

    def test_another_one_is_sent_nothing(self):
        self.assertIn(self.server.fingerprint, str(fault_of(self.station().status)))
        self.assertIn("another server", str(fault_of(self.station(fingerprint="0" * 64).status)))
        self.assertIn("64 hexadecimal", str(fault_of(self.station, fingerprint="12")))
        self.assertIn("give one", str(fault_of(self.station, fingerprint="0" * 64, ca="ca.pem")))
        self.assertIn("can not be read", str(fault_of(self.station, ca=str(self.elsewhere / "none.pem"))))

    def test_by_an_authority_that_vouches_for_its_name(self):
        own, data = self.elsewhere / "own.pem", OUT / "named"
        subprocess.run(["openssl", "req", "-x509", "-newkey", "ed25519", "-nodes", "-days", "2", "-subj", "/CN=mine", "-addext",
                        "subjectAltName=IP:127.0.0.1", "-keyout", own, "-out", self.elsewhere / "ca.pem"], check=True, capture_output=True)
        with open(own, "a") as whole:
            whole.write((self.elsewhere / "ca.pem").read_text())
        own.chmod(0o600)
        (self.elsewhere / "hf.toml").write_text(f"[operator]\ncertificate = '{own}'\n")
        server = Server(BIN, data, "--config", self.elsewhere / "hf.toml")
        shutil.copy(server.token_file, self.elsewhere / "named.token")
        try:
            def station(host, **trust):
                return BaseStation(f"https://{host}:" + server.http.rpartition(":")[2],
                                   token_file=str(self.elsewhere / "named.token"), **trust)
            self.assertEqual(station("127.0.0.1", ca=str(self.elsewhere / "ca.pem")).status()["sessions"], 0)
            self.assertIn("vouches", str(fault_of(station("localhost", ca=str(self.elsewhere / "ca.pem")).status)))
            self.assertIn("vouches", str(fault_of(station("127.0.0.1").status)))
        finally:
            server.stop()

    def test_plain_where_https_is_spoken_and_the_other_way_round(self):
        fault = fault_of(BaseStation(self.address.replace("https", "http"), token_file=str(self.elsewhere / "token")).status)
        self.assertEqual(fault.status, 403)
        with answering(b"HTTP/1.1 200 OK\r\n\r\n") as address:
            self.assertIn("does not speak HTTPS", str(fault_of(BaseStation("https://" + address, fingerprint="0" * 64).status)))


@contextlib.contextmanager
def answering(answer):
    """Who reads a request and answers these bytes, whatever it was."""
    def serve():
        with contextlib.suppress(OSError):
            while True:
                peer, _ = listener.accept()
                with peer:
                    peer.recv(65536)
                    peer.sendall(answer)
    with socket.create_server(("127.0.0.1", 0)) as listener:
        thread = threading.Thread(target=serve)
        thread.start()
        try:
            yield f"127.0.0.1:{listener.getsockname()[1]}"
        finally:
            listener.shutdown(socket.SHUT_RDWR)
            thread.join()


class NoServer(unittest.TestCase):
    """Bytes of whoever else answers end in a Fault."""

    def test_what_is_no_answer(self):
        header = b"HTTP/1.1 200 OK\r\nContent-Length: "
        for answer in (b"", b"\0" * 100, b"SSH-2.0-OpenSSH_9.2\r\n", b"HTTP/1.1 200 OK\r\n" + b"X: y\r\n" * 200 + b"\r\n",
                       header + b"2\r\n\r\n[]", header + b"9\r\n\r\nnot json!", header + b"100\r\n\r\n{}", header + b"3\r\n\r\n\xff{}",
                       header + b"200000\r\n\r\n" + b"[" * 200000, b"HTTP/1.1 500 No\r\nContent-Length: 2\r\n\r\n{}",
                       b"HTTP/1.1 302 Found\r\nLocation: http://127.0.0.1:1/\r\nContent-Length: 0\r\n\r\n",
                       b"HTTP/1.1 200 OK\r\nTransfer-Encoding: chunked\r\n\r\nzz\r\n"):
            with self.subTest(answer[:60]), answering(answer) as address:
                fault_of(BaseStation(address).status)

    def test_half_a_file_is_none(self):
        with answering(b"HTTP/1.1 200 OK\r\nContent-Length: 100\r\n\r\nply") as address:
            self.assertIn("broke off", str(fault_of(BaseStation(address).export, 1, str(OUT / "half.ply"))))
        self.assertEqual([p for p in OUT.iterdir() if p.name.startswith("half")], [])

    def test_what_are_no_events(self):
        with answering(b"HTTP/1.1 101 Switching Protocols\r\nUpgrade: websocket\r\n\r\n") as address:
            self.assertIn("did not go over", str(fault_of(next, BaseStation(address).events())))

    def test_frames_in_pieces_pings_and_what_is_none(self):
        from headframe.operator.events import _messages
        sent = []
        whole = b"\x89\x02hi" + b"\x01\x03{\"a" + b"\x80\x7e\x00\x05\":1}\n" + b"\x81\x7f" + b"\0" * 7 + b"\x02{}"
        self.assertEqual(list(zip(range(2), _messages(io.BytesIO(whole), sent.append))), [(0, b'{"a":1}\n'), (1, b"{}")])
        pong = sent[0]
        self.assertEqual(pong[:2] + bytes(b ^ pong[2 + i % 4] for i, b in enumerate(pong[6:])), b"\x8a\x82hi")
        for bad in (b"\x81", b"\x81\x05ab", b"\x81\x80", b"\xf1\x00", b"\x81\x7f" + b"\xff" * 8, b"\x88\x00", b""):
            with self.subTest(bad):
                fault_of(next, _messages(io.BytesIO(bad), sent.append))

    def test_addresses(self):
        for bad in ("", "host", "host:", ":7448", "host:0", "host:65536", "host:99999", "ftp://host:1", "a b:1", "user@host:1", "host:1/x",
                    "host:1\r\nX: y", "[::1:7448"):
            with self.subTest(bad):
                self.assertIn("address", str(fault_of(BaseStation, bad)))

    def test_it_needs_nothing_but_python(self):
        code = "import sys, headframe.operator; print([m for m in ('numpy', 'headframe._robot') if m in sys.modules])"
        done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
        self.assertEqual(done.stdout.strip(), "[]")


if __name__ == "__main__":
    shutil.rmtree(OUT, ignore_errors=True)
    OUT.mkdir(parents=True)
    for of_this_shell in ("HEADFRAME_HTTP", "HEADFRAME_TOKEN_FILE", "HEADFRAME_TOKEN", "HEADFRAME_FINGERPRINT", "HEADFRAME_CA"):
        os.environ.pop(of_this_shell, None)
    os.chdir(OUT)
    subprocess.run([BIN / "headframe-drawn-sessions", OUT / "drives"], check=True)
    unittest.main()
