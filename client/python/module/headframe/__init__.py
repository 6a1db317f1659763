"""A robot of headframe: scans with poses in, the transform of the robot's map and what others know out.

Poses are 4 x 4 arrays T_target_source, points arrays of (n, 3), metres and seconds. What each call does is said in
__init__.pyi, and in client/robot_client.hpp of the C++ library, which this is.
"""

import atexit as _atexit
import pkgutil as _pkgutil
import weakref as _weakref

__path__ = _pkgutil.extend_path(__path__, __name__)  # messages of the protocol (headframe.v1) may lie elsewhere

from . import _robot
from ._robot import (BadInput, Coverage, Error, Localization, MapAround, Path, Progress, Sensor, SessionKey, Surroundings,
                     Trajectories, Transforms)

FREE, WALL, PATH = 1, 2, 4  # what a cell of Coverage may hold, summed

_open = _weakref.WeakSet()


@_atexit.register
def _close_all():
    """A link's thread must not outlive the interpreter that its callbacks need."""
    for robot in list(_open):
        robot.close()


class Robot(_robot.Robot):
    """One session of one robot. Use it in a `with`, or close() it."""

    def __init__(self, *args, **named):
        super().__init__(*args, **named)
        _open.add(self)

    def __enter__(self):
        return self

    def __exit__(self, *what):
        self.close()


__all__ = ["BadInput", "Coverage", "Error", "FREE", "Localization", "MapAround", "PATH", "Path", "Progress", "Robot", "Sensor",
           "SessionKey", "Surroundings", "Trajectories", "Transforms", "WALL"]
