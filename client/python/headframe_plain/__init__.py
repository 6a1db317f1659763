"""A robot's side of headframe's protocol v1 in plain Python: numpy and protobuf only, no C++.

Written from proto/headframe/v1/README.md, whose words and section names are used here.
"""

from .robot import Robot, Settings

__all__ = ["Robot", "Settings"]
