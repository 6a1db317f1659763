"""Whom to trust, and how to be known: what `headframe robot add` printed becomes a file that only its owner reads."""

import hashlib
import json
import os
import re
import secrets


class Refused(Exception):
    """What can not be helped by trying again; the text says what to do."""


def parse_enrolment(text):
    """hf1-FINGERPRINT-CODE as (32 bytes, 16 bytes)."""
    match = re.fullmatch(r"hf1-([0-9a-fA-F]{64})-([0-9a-fA-F]{32})", text)
    if not match:
        raise Refused("this is no enrolment: paste the whole of what `headframe robot add` printed, hf1-...")
    return bytes.fromhex(match[1]), bytes.fromhex(match[2])


class Credential:
    """On the disk before the first hello. `code` is empty once the server has let the robot in."""

    def __init__(self, path, robot, enrolment=""):
        self.path, self.robot = path, robot
        self.fingerprint = self.token = self.code = b""
        self._enrolled_with = ""
        if os.path.exists(path):
            self._read()
        if not enrolment:
            if not self.token:
                raise Refused(f"robot {robot} has no credential in {path}: give what `headframe robot add {robot}` prints")
            return
        enrolled_with = hashlib.sha256(enrolment.encode()).hexdigest()
        if enrolled_with != self._enrolled_with:
            self.fingerprint, self.code = parse_enrolment(enrolment)
            self.token, self._enrolled_with = secrets.token_bytes(32), enrolled_with
            self._write()

    def confirmed(self):
        """A Welcome came: the code is done with."""
        if self.code:
            self.code = b""
            self._write()

    def _read(self):
        if os.stat(self.path).st_mode & 0o077:
            raise Refused(f"{self.path} can be used by others; take it from them: chmod 600 {self.path}")
        try:
            with open(self.path, encoding="utf-8") as file:
                kept = json.load(file)
            robot, self._enrolled_with = kept["robot"], kept["enrolled_with"]
            self.fingerprint, self.token, self.code = (bytes.fromhex(kept[k]) for k in ("server", "token", "code"))
        except (ValueError, KeyError, TypeError) as fault:
            raise Refused(f"{self.path} is no credential; remove it and enrol the robot anew") from fault
        if robot != self.robot:
            raise Refused(f"{self.path} is robot {robot}'s, not {self.robot}'s")

    def _write(self):
        kept = {"robot": self.robot, "enrolled_with": self._enrolled_with, "server": self.fingerprint.hex(),
                "token": self.token.hex(), "code": self.code.hex()}
        part = f"{self.path}.part"
        if os.path.exists(part):
            os.remove(part)
        with os.fdopen(os.open(part, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o600), "w", encoding="utf-8") as file:
            json.dump(kept, file)
            file.flush()
            os.fsync(file.fileno())
        os.replace(part, self.path)
