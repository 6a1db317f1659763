"""The operator's side of a base station: one method for each thing that an operator asks or orders."""

import os
import time
from typing import Any, Dict, Iterator, List, Optional, Union
from urllib.parse import quote, urlencode

from . import events, files
from .exchange import Exchange
from .fault import Fault

Json = Dict[str, Any]
SLICE_S = 20.0  # of a long wait: a server that died is noticed after one of these


class BaseStation:
    """Answers are the JSON of the API (server/operator/README.md): metres, poses as 16 numbers, row by row.

    address: HOST:PORT; with HTTPS but on the loopback, or with https:// or http:// before it.
    token_file: the server's DATA/operator.token or an operator's own; else $HEADFRAME_TOKEN_FILE, $HEADFRAME_TOKEN, or
        headframe-data/operator.token. Without any no token is shown.
    fingerprint, ca: of the server's certificate, as it prints it at its start, or a PEM file of who vouches for it; else
        $HEADFRAME_FINGERPRINT, $HEADFRAME_CA, or the system's authorities and identity.pem beside the token's file.

    A session is named "robot/session", or by its robot or label where that is the only one. Threads may share a
    BaseStation. What goes wrong is a Fault.
    """

    def __init__(self, address: str = "127.0.0.1:7448", *, token_file: Optional[str] = None, fingerprint: Optional[str] = None,
                 ca: Optional[str] = None) -> None:
        known = fingerprint or ca
        self._exchange = Exchange(address, token_file or os.environ.get("HEADFRAME_TOKEN_FILE"),
                                  fingerprint if known else os.environ.get("HEADFRAME_FINGERPRINT"),
                                  ca if known else os.environ.get("HEADFRAME_CA"))

    # ---- any route of the API

    def get(self, path: str, **query: Any) -> Json:
        """For instance get("/api/v1/changes", since=0)."""
        return self._asked("GET", path, query)

    def post(self, path: str, body: bytes = b"", **query: Any) -> Json:
        return self._asked("POST", path, query, body)

    def delete(self, path: str, **query: Any) -> Json:
        return self._asked("DELETE", path, query)

    # ---- what it knows

    def status(self) -> Json:
        return self.get("/api/v1/status")

    def sessions(self) -> List[Json]:
        return self.get("/api/v1/sessions")["sessions"]

    def session(self, name: str) -> Json:
        """The one of sessions() that is named so."""
        sessions = self.sessions()
        fitting = [s for s in sessions if f"{s['robot']}/{s['session']}" == name]
        fitting = fitting or [s for s in sessions if name in (s["robot"], s.get("label"))]
        if len(fitting) == 1:
            return fitting[0]
        there = ", ".join(f"{s['robot']}/{s['session']}" for s in sessions) or "none yet"
        raise Fault((f"{name!r} means several sessions; say which" if fitting else f"there is no session {name!r}") +
                    f"; there are: {there}", None if fitting else 404)

    def atlas(self, wait_s: Optional[float] = None) -> Json:
        """Which sessions are merged, where, and on what evidence. With wait_s: once no merge is pending, or this time has
        passed; `waited_out` says which."""
        if wait_s is None:
            return self.get("/api/v1/atlas")
        end = time.monotonic() + wait_s
        while True:
            left_s = max(0.0, end - time.monotonic())
            atlas = self._asked("GET", "/api/v1/atlas", {"wait": f"{min(left_s, SLICE_S):.3f}"})
            if not atlas["waited_out"] or left_s <= SLICE_S:
                return atlas

    def alignments(self, state: Optional[str] = None, most_rejected: int = 1000, id: Optional[int] = None) -> List[Json]:
        """All, or those in this state ("published", "verified", "rejected" and so on), or this one; of pairs that came to
        nothing at most so many, the newest."""
        return self.get("/api/v1/alignments", state=state, id=id, most=most_rejected)["alignments"]

    def explain(self, a: str, b: str) -> Json:
        """Why two sessions are or are not merged."""
        return self.get("/api/v1/explain", a=a, b=b)

    def events(self) -> Iterator[Json]:
        """What happens, as it happens: first {"type": "snapshot"} with all there is, then what changed since. It ends with
        a Fault when the server stops; who asks again gets a snapshot first."""
        return events.events(self._exchange)

    def watch(self) -> Iterator[List[Json]]:
        """sessions(), now and whenever something happened."""
        for event in self.events():
            yield event["sessions"]["sessions"] if event.get("type") == "snapshot" else self.sessions()

    # ---- what an operator decides

    def confirm(self, alignment: int, all_the_same: bool = False) -> Json:
        """Makes it a merge. One that is improbable, or that other sessions contradict, only all the same: a wrong merge
        sends robots wrong transforms."""
        for row in [] if all_the_same else self.alignments(id=alignment):
            probability = row["evidence"].get("probability") or 0.0
            if row["id"] == alignment and row["state"] != "published" and (row["state"] == "verified" or probability < 0.5):
                why = "other sessions contradict it" if row["state"] == "verified" else f"its probability is {probability:.3f}"
                raise Fault(f"alignment {alignment}: {why}; confirm it with all_the_same=True, if you know better", 403)
        return self._decided(alignment, "confirm")

    def refuse(self, alignment: int) -> Json:
        """It is never made again."""
        return self._decided(alignment, "refuse")

    def retract(self, alignment: int) -> Json:
        """A merge that stands is taken back."""
        return self._decided(alignment, "retract")

    def undo(self, alignment: int) -> Json:
        """The decision is forgotten."""
        return self._decided(alignment, "undo")

    def merge(self, wait_s: Optional[float] = None) -> Optional[Json]:
        """Tries every session again. With wait_s: the atlas, as atlas(wait_s)."""
        self.post("/api/v1/merge")
        return None if wait_s is None else self.atlas(wait_s)

    def add_robot(self, name: str) -> str:
        """Invites a robot; the string that it needs once, which is good for an hour."""
        return self.post("/api/v1/robots/add", robot=name)["enrolment"]

    # ---- files

    def export(self, component: Union[int, str], file: str, *, voxel_m: Optional[float] = None, scale: Optional[int] = None,
               frame: Optional[str] = None) -> int:
        """The map of a component, by its id or a session of it, into a .ply, .pcd or .las, or its plan into a .pdf, .svg
        or .png; frame: "component" or "grid". How many bytes it has."""
        form = files.format_of(file, points=scale is None, plans=voxel_m is None)
        number = component if isinstance(component, int) else self.session(component)["component"]
        if number is None:
            raise Fault(f"{component} has no map yet", 404)
        path = "/api/v1/plan" if form in files.PLANS else "/api/v1/export"
        return files.download(self._exchange, _target(path, {"component": number, "format": form, "voxel": voxel_m,
                                                             "scale": scale, "frame": frame}), file)

    def trajectory(self, session: str, file: str, frame: Optional[str] = None) -> int:
        """The session's keyframes, as CSV if the file ends so, else as TUM."""
        row = self.session(session)
        query = {"robot": row["robot"], "session": row["session"], "format": "csv" if file.endswith(".csv") else "tum", "frame": frame}
        return files.download(self._exchange, _target("/api/v1/trajectory", query), file)

    def backup(self, file: str) -> int:
        """All of the base station, its key and token too: nobody else may read the file."""
        return files.download(self._exchange, "/api/v1/backup", file, secret=True)

    # ----

    def _decided(self, alignment: int, decision: str) -> Json:
        return self.post(f"/api/v1/alignments/{quote(str(alignment), safe='')}/{decision}")

    def _asked(self, method: str, path: str, query: Dict[str, Any], body: bytes = b"") -> Json:
        with self._exchange.ask(method, _target(path, query), body) as answer:
            return self._exchange.read(answer)


def _target(path: str, query: Dict[str, Any]) -> str:
    """What is None is left out."""
    given = {name: value for name, value in query.items() if value is not None}
    return path + ("?" + urlencode(given, quote_via=quote) if given else "")
