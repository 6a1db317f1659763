"""headframe for Python: a robot, in numpy (client/python/example.py is a whole one), and headframe.operator, which asks and
orders a base station.

What each call of the robot does is said in __init__.pyi.
"""

import pkgutil as _pkgutil

__path__ = _pkgutil.extend_path(__path__, __name__)  # messages of the protocol (headframe.v1) may lie elsewhere
__all__ = ["BadInput", "Coverage", "Error", "FREE", "Localization", "MapAround", "PATH", "Path", "Progress", "Robot", "Sensor",
           "SessionKey", "Support", "Surroundings", "Trajectories", "Transforms", "WALL"]


def __getattr__(name):
    """The robot library and numpy come once they are asked for: an operator needs neither."""
    if name not in __all__:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    from . import robot
    return getattr(robot, name)
