"""Messages out of bags: ROS 1 (.bag, with Debian's python3-rosbag) and ROS 2 (.db3, which is SQLite; no ROS needed)."""

import sqlite3
from pathlib import Path

from . import cdr


def messages(path, topics):
    """(topic, message) in the order of recording. ValueError: what can not be read, and what to do."""
    path = Path(path)
    if path.suffix == ".bag":
        return _of_ros1(path, topics)
    files = sorted(path.glob("*.db3")) if path.is_dir() else [path]
    if path.suffix == ".mcap" or (path.is_dir() and not files):
        raise ValueError(f"{path}: no .db3 of ROS 2; one of another kind is converted by `ros2 bag convert`")
    if not all(file.suffix == ".db3" and file.is_file() for file in files):
        raise ValueError(f"{path}: neither a .bag nor a .db3 nor a folder with one")
    return (message for file in files for message in _of_ros2(file, topics))


def _of_ros1(path, topics):
    try:
        import rosbag
    except ImportError:
        raise ValueError(f"{path}: a bag of ROS 1 needs python3-rosbag") from None
    try:
        with rosbag.Bag(str(path)) as bag:
            _check(path, topics, bag.get_type_and_topic_info().topics)
            for topic, message, _ in bag.read_messages(topics):
                yield topic, message
    except (rosbag.ROSBagException, OSError) as fault:
        raise ValueError(f"{path}: {fault}; an unfinished one is mended by `rosbag reindex`") from None


def _of_ros2(path, topics):
    try:
        with sqlite3.connect(f"file:{path}?mode=ro", uri=True) as bag:
            there = {id: (name, kind) for id, name, kind in bag.execute("SELECT id, name, type FROM topics")}
            _check(path, topics, {name for name, _ in there.values()})
            wanted = {id: (name, kind) for id, (name, kind) in there.items() if name in topics}
            marks = ",".join("?" * len(wanted))
            rows = bag.execute(f"SELECT topic_id, data FROM messages WHERE topic_id IN ({marks}) ORDER BY timestamp, id",
                               list(wanted))
            for topic, data in rows:
                yield wanted[topic][0], cdr.decoded(wanted[topic][1], data)
    except sqlite3.Error as fault:
        raise ValueError(f"{path}: {fault}") from None


def _check(path, topics, there):
    for topic in topics:
        if topic not in there and topic != "/tf_static":
            raise ValueError(f"{path}: no topic {topic}; there are {', '.join(sorted(there))}")
