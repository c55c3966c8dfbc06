"""A peer of another maker's DDS: it hears the topics of a served mission and steers its head.

Its argument is the domain. It ends with 0 once the map has come, which was sent before it joined, the head
has flown a metre and a half by its odometry, and its order to return has been sent; with 1 after a minute.
"""

import math
import sys
import time
from dataclasses import dataclass
from pathlib import Path

from cyclonedds.idl import IdlStruct
from cyclonedds.idl.types import array, float32, float64, int8, sequence, uint32

sys.path.insert(0, str(Path(__file__).parents[2] / "ros2-topics/tests"))

from dds_peer import LATCHED, Domain, Header, String, Time, Twist, Vector3


@dataclass
class Clock(IdlStruct, typename="rosgraph_msgs::msg::dds_::Clock_"):
    clock: Time


@dataclass
class Point(IdlStruct, typename="geometry_msgs::msg::dds_::Point_"):
    x: float64
    y: float64
    z: float64


@dataclass
class Quaternion(IdlStruct, typename="geometry_msgs::msg::dds_::Quaternion_"):
    x: float64
    y: float64
    z: float64
    w: float64


@dataclass
class Pose(IdlStruct, typename="geometry_msgs::msg::dds_::Pose_"):
    position: Point
    orientation: Quaternion


@dataclass
class PoseWithCovariance(IdlStruct, typename="geometry_msgs::msg::dds_::PoseWithCovariance_"):
    pose: Pose
    covariance: array[float64, 36]


@dataclass
class TwistWithCovariance(IdlStruct, typename="geometry_msgs::msg::dds_::TwistWithCovariance_"):
    twist: Twist
    covariance: array[float64, 36]


@dataclass
class Odometry(IdlStruct, typename="nav_msgs::msg::dds_::Odometry_"):
    header: Header
    child_frame_id: str
    pose: PoseWithCovariance
    twist: TwistWithCovariance


@dataclass
class Transform(IdlStruct, typename="geometry_msgs::msg::dds_::Transform_"):
    translation: Vector3
    rotation: Quaternion


@dataclass
class TransformStamped(IdlStruct, typename="geometry_msgs::msg::dds_::TransformStamped_"):
    header: Header
    child_frame_id: str
    transform: Transform


@dataclass
class TFMessage(IdlStruct, typename="tf2_msgs::msg::dds_::TFMessage_"):
    transforms: sequence[TransformStamped]


@dataclass
class MapMetaData(IdlStruct, typename="nav_msgs::msg::dds_::MapMetaData_"):
    map_load_time: Time
    resolution: float32
    width: uint32
    height: uint32
    origin: Pose


@dataclass
class OccupancyGrid(IdlStruct, typename="nav_msgs::msg::dds_::OccupancyGrid_"):
    header: Header
    info: MapMetaData
    data: sequence[int8]


def main(number):
    domain = Domain(number)
    clock, odometry = domain.reader("/clock", Clock), domain.reader("/drone_0/odom", Odometry)
    transforms = domain.reader("/tf", TFMessage)
    grid = domain.reader("/map", OccupancyGrid, LATCHED)
    began, now, first, flown, frames, area = time.time(), 0.0, None, 0.0, set(), 0
    while time.time() - began < 60:
        domain.fly(0.3)
        for sample in clock.take():
            now = sample.clock.sec + sample.clock.nanosec * 1e-9
        for sample in odometry.take():
            at = sample.pose.pose.position
            first = first or at
            flown = math.dist((at.x, at.y), (first.x, first.y))
        for sample in transforms.take():
            frames |= {transform.child_frame_id for transform in sample.transforms}
        for sample in grid.take():
            assert len(sample.data) == sample.info.width * sample.info.height
            area = len(sample.data)
        if flown > 1.5 and now > 0 and area and {"drone_0", "drone_1"} <= frames:
            break
        time.sleep(0.05)
    else:
        sys.exit(f"after a minute: clock {now}, flown {flown}, frames {frames}, map {area}")
    # An order comes once; a Twist that came later would be another one.
    time.sleep(0.5)
    domain.orders.write(String("return"))
    time.sleep(1.0)


main(int(sys.argv[1]))
