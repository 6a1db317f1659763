"""The robot: scans with poses in, the transform of its map and what others know out.

Poses are 4 x 4 arrays T_target_source, points arrays of (n, 3), metres and seconds. What each call does is said in
__init__.pyi, and in client/robot_client.hpp of the C++ library, which this is.
"""

import atexit as _atexit
import weakref as _weakref

from . import _robot
from ._robot import (BadInput, Coverage, Error, Localization, MapAround, Path, Progress, Sensor, SessionKey, Support,
                     Surroundings, Trajectories, Transforms)

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
