"""Bags of ROS 2 that the command writes, read by rosbags."""

import math
import subprocess
import sys

import pytest

pytest.importorskip("rosbags")

from rosbags.highlevel import AnyReader  # noqa: E402
from rosbags.rosbag2 import Reader  # noqa: E402
from rosbags.typesys import Stores, get_typestore  # noqa: E402

import uchain  # noqa: E402

FIGURES = ["--set", "duration_s=30", "--seed", "4"]


@pytest.fixture(scope="module")
def bag(tmp_path_factory):
    """The folder of a mission with its bag, and the mission."""
    from conftest import SHORT

    folder = tmp_path_factory.mktemp("bag")
    scenario = folder / "own.toml"
    scenario.write_text(SHORT)
    words = ["run", str(scenario), *FIGURES, "--quiet", "--bag", "--out", str(folder / "out")]
    done = subprocess.run([sys.executable, "-m", "uchain", *words], capture_output=True, text=True)
    assert done.returncode in (0, 1), done.stderr
    return folder / "out", uchain.run(str(scenario), seed=4, duration_s=30)


def messages(folder, topic):
    """The messages of a topic, by the definitions in the bag, with their times in seconds."""
    with AnyReader([folder]) as reader:
        chosen = [connection for connection in reader.connections if connection.topic == topic]
        assert chosen, topic
        return [
            (time * 1e-9, reader.deserialize(raw, connection.msgtype))
            for connection, time, raw in reader.messages(chosen)
        ]


def test_every_message_reads_by_the_definitions_of_ros_2_and_by_those_in_the_bag(bag):
    folder, _ = bag
    jazzy = get_typestore(Stores.ROS2_JAZZY)
    kinds, counts = set(), {}
    with AnyReader([folder]) as own, Reader(folder) as reader:
        assert reader.message_count == sum(it.msgcount for it in reader.connections) > 0
        for connection, _, raw in reader.messages():
            kinds.add(connection.msgtype)
            counts[connection.topic] = counts.get(connection.topic, 0) + 1
            # Read and written by rosbags, it is the same bytes.
            for store in (jazzy, own.typestore):
                message = store.deserialize_cdr(raw, connection.msgtype)
                assert bytes(store.serialize_cdr(message, connection.msgtype)) == bytes(raw)
        assert counts == {it.topic: it.msgcount for it in reader.connections if it.msgcount}
    assert kinds == {
        "diagnostic_msgs/msg/DiagnosticArray",
        "nav_msgs/msg/OccupancyGrid",
        "nav_msgs/msg/Odometry",
        "nav_msgs/msg/Path",
        "sensor_msgs/msg/Range",
        "std_msgs/msg/Float32",
        "tf2_msgs/msg/TFMessage",
        "visualization_msgs/msg/MarkerArray",
    }


def test_the_bag_holds_the_mission(bag):
    folder, mission = bag
    trace = mission.trace.to_dict()
    head = [n for n, node in enumerate(trace["node"]) if node == 0]
    odometry = messages(folder, "/drone_0/odom")
    assert [time for time, _ in odometry] == pytest.approx([trace["time_s"][n] for n in head])
    for n, (_, told) in zip(head, odometry):
        assert told.pose.pose.position.x == pytest.approx(trace["x_m"][n], abs=1e-6)
        yaw = 2 * math.atan2(told.pose.pose.orientation.z, told.pose.pose.orientation.w)
        assert math.sin(yaw) == pytest.approx(math.sin(trace["yaw_rad"][n]), abs=1e-6)
    fastest = max(told.twist.twist.linear.x for _, told in odometry)
    assert 0.15 < fastest < 0.3, "the pilot asks for 0.2 m/s"
    strengths = [told.data for _, told in messages(folder, "/drone_0/link/back/filtered_dbm")]
    assert strengths == pytest.approx(
        [trace["back_filtered_dbm"][n] for n in head if trace["back_filtered_dbm"][n] is not None]
    )
    ranges = [told for _, told in messages(folder, "/drone_0/range/nw")]
    assert {told.header.frame_id for told in ranges} == {"drone_0/range_nw"}
    assert any(told.range < 2.0 for told in ranges)
    [(_, grid)] = messages(folder, "/map")
    free = (grid.data == 0).sum() * grid.info.resolution**2
    assert 12.0 < free < 25.0, "a gallery of some 12 m by 1.2 m, and the hall of the base"
    _, path = messages(folder, "/drone_0/path")[-1]
    assert path.poses[-1].pose.position.x == pytest.approx(trace["x_m"][head[-1]], abs=0.3)
    _, last = messages(folder, "/diagnostics")[-1]
    assert [status.name for status in last.status] == ["head", "relay 1", "relay 2", "base"]


def test_a_bag_needs_a_folder():
    words = [sys.executable, "-m", "uchain", "run", "relay-pair", "--bag"]
    done = subprocess.run(words, capture_output=True, text=True)
    assert done.returncode == 2 and "--out" in done.stderr
