from types import TracebackType
from typing import Callable, Dict, List, Mapping, Optional, Tuple, Type

import numpy as np
from numpy.typing import ArrayLike, NDArray

FREE: int
WALL: int
PATH: int

class Error(RuntimeError):
    """The library's faults: what happened, where, and what to do."""

class BadInput(Error):
    """This scan is no use; the next may be."""

class SessionKey:
    robot: str
    session: str

class Sensor:
    """A spinning lidar; fields of view from the horizon, both positive."""
    def __init__(self, model: str, beams: int = 0, fov_up_deg: float = 0, fov_down_deg: float = 0,
                 max_range_m: float = 0) -> None: ...

class Progress:
    keyframes: int
    keyframes_acknowledged: int
    pose_updates: int
    pose_updates_acknowledged: int
    pose_updates_unsupported: bool  # the server is older: they wait in the spool
    clouds_waiting: int
    clouds_acknowledged: int
    clouds_dropped: int
    bytes_sent: int
    connected: bool
    refused: bool
    hold: str
    cut: str
    link_error: str

class Support:
    """How sure a transform is: by the surest way of merges from the anchor to the session."""
    probability: float
    merged_with: Optional[SessionKey]
    merges: int
    shared_m: float
    confirmed: bool
    deviation_m: float
    deviation_rad: float
    def covariance(self, away_m: ArrayLike = ...) -> NDArray[np.float64]:
        """6 x 6, of a place that lies so far from the shared path: x, y, z in metres, rotations about them in radians."""

class Transforms:
    """Where every session of the component lies."""
    revision: int
    component: int
    anchor: SessionKey
    T_component_session: Dict[SessionKey, NDArray[np.float64]]  # 4 x 4 each
    def T_mine_other(self, mine: SessionKey, other: SessionKey) -> Optional[NDArray[np.float64]]:
        """p_mine = T_mine_other @ p_other; None: one of them is not in the component."""
    def support(self, session: SessionKey) -> Optional[Support]:
        """None: the base station is older, or no merge holds it."""

class Localization:
    """Where the robot is in the map of others, if found; else what is missing."""
    found: bool
    supported: bool  # False: this base station is older than the question
    T_component_session: NDArray[np.float64]
    T_component_sensor: NDArray[np.float64]  # of the keyframe
    covariance: NDArray[np.float64]  # 6 x 6 of T_component_sensor: x, y, z in m, then rotations in rad
    keyframe: int
    component: int
    anchor: SessionKey
    session: SessionKey
    merged: bool
    probability: float
    shared_m: float
    awaited_m: float
    missing: str

class Surroundings:
    """What trajectories and coverage have in common."""
    told: bool  # False: there is nothing, `missing` says why
    supported: bool
    revision: int
    component: int
    anchor: SessionKey
    T_component_local: NDArray[np.float64]
    missing: str

class Path:
    session: SessionKey
    last_stamp_s: float
    age_s: Optional[float]
    points: NDArray[np.float64]  # (n, 3) in the robot's local frame, about every 2 m

class Trajectories(Surroundings):
    paths: List[Path]

class Coverage(Surroundings):
    sessions: Dict[int, SessionKey]
    def cells(self) -> Tuple[NDArray[np.float64], NDArray[np.uint8], NDArray[np.float64], NDArray[np.uint32]]:
        """Cells of 1 m that anybody has seen: middles (n, 2) in the component's frame, what (FREE, WALL, PATH, summed),
        when last (the stamp of whoever did, to 600 s), who did (a number of `sessions`)."""
    def at(self, p_local: ArrayLike) -> int:
        """What was seen at this point of the robot's local frame; 0: nothing."""

class MapAround:
    refused: str  # not empty: there is no map, why, and what to do
    revision: int
    clouds: int
    clouds_left_out: int
    since: bool
    points: NDArray[np.float64]  # (n, 3) in the robot's local frame

class Robot:
    """One session of one robot. Scans are kept in the spool until the base station has them, which need not be there.

    Callbacks come on a thread of the library's, one at a time; what they raise is printed and goes no further. They may
    call the robot, but not close() or finish().
    """
    def __init__(self, robot: str, *, spool: str, server: str, enrolment: str = "", session: str = "",
                 credential: str = "", fingerprint: str = "", insecure: bool = False, sensor: Sensor = ...,
                 family: str = "learned", clouds: str = "all", bytes_per_s: float = 0.0,
                 provisional: bool = False, intensity: bool = True) -> None:
        """server: HOST:PORT; after a comma those that stand by for it. enrolment: what `headframe robot add` printed;
        needed once. clouds: all, on_request, never.
        intensity: False leaves it out of the clouds, which takes about a seventh off their bytes."""
    def add_scan(self, stamp_s: float, T_local_sensor: ArrayLike, points: ArrayLike,
                 intensity: Optional[ArrayLike] = None) -> bool:
        """One scan (n, 3) in the sensor's frame, at its pose. True: it became a keyframe and is on the disk.
        intensity (n): how strong the returns were, as the sensor says it, on a scale to 1, to 255 or to 65535."""
    def update_poses(self, T_local_sensor: Mapping[int, ArrayLike]) -> None:
        """SLAM moved the past: where these keyframes, which add_scan made before, lie now, by their numbers from 1 on
        (last_keyframe says how many there are). From the thread that calls add_scan."""
    def correct(self, stamps_s: ArrayLike, T_local_sensor: ArrayLike, least_moved_m: float = 0.05,
                least_turned_rad: float = 0.01, later_ones: bool = True) -> Tuple[Dict[int, NDArray[np.float64]], int]:
        """The same from SLAM's whole trajectory of the sensor, (n) and (n, 4, 4): keyframes whose stamps it has, or has poses
        close before and after, lie where it says if they moved by enough; the others move as those around them, those
        that are newer only with later_ones. Which were moved, and how many it had a pose for."""
    def on_transforms(self, callback: Optional[Callable[[Transforms], None]]) -> None: ...
    def localize(self, callback: Optional[Callable[[Localization], None]]) -> None:
        """Asks where the robot is in the map of others, from now on. None: no more."""
    def trajectories(self, callback: Optional[Callable[[Trajectories], None]]) -> None: ...
    def coverage(self, callback: Optional[Callable[[Coverage], None]]) -> None: ...
    def map_around(self, centre: ArrayLike, radius_m: float, resolution_m: float = 0.2,
                   since: Optional[MapAround] = None, *, callback: Callable[[MapAround], None]) -> None:
        """Asks once for the points of all robots in a sphere of the robot's local frame; since: only what came after."""
    def live(self, battery: Optional[float] = None, health: str = "", T_local_sensor: Optional[ArrayLike] = None,
             stamp_s: float = 0.0) -> None:
        """What operators see of the robot, each second at most; battery 0 to 1. add_scan says the pose by itself."""
    def trigger(self, reason: str = "") -> None: ...
    def finish(self, patience_s: float = 30.0) -> None:
        """Waits until all is acknowledged. Error: nothing went on for so long; the spool keeps everything."""
    def close(self) -> None: ...
    @property
    def transforms(self) -> Optional[Transforms]: ...
    @property
    def last_keyframe(self) -> int: ...
    @property
    def session(self) -> SessionKey: ...
    @property
    def warnings(self) -> List[str]: ...
    @property
    def progress(self) -> Progress: ...
    def __enter__(self) -> "Robot": ...
    def __exit__(self, kind: Optional[Type[BaseException]], value: Optional[BaseException],
                 trace: Optional[TracebackType]) -> None: ...
