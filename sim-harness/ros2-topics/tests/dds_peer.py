"""What peers of another maker's DDS, Eclipse Cyclone DDS, have in common: messages, profiles and topics."""

from dataclasses import dataclass

from cyclonedds.core import Policy, Qos
from cyclonedds.domain import DomainParticipant
from cyclonedds.idl import IdlStruct
from cyclonedds.idl.types import float64, int32, uint32
from cyclonedds.pub import DataWriter
from cyclonedds.sub import DataReader
from cyclonedds.topic import Topic
from cyclonedds.util import duration


@dataclass
class Time(IdlStruct, typename="builtin_interfaces::msg::dds_::Time_"):
    sec: int32
    nanosec: uint32


@dataclass
class Header(IdlStruct, typename="std_msgs::msg::dds_::Header_"):
    stamp: Time
    frame_id: str


@dataclass
class String(IdlStruct, typename="std_msgs::msg::dds_::String_"):
    data: str


@dataclass
class Vector3(IdlStruct, typename="geometry_msgs::msg::dds_::Vector3_"):
    x: float64
    y: float64
    z: float64


@dataclass
class Twist(IdlStruct, typename="geometry_msgs::msg::dds_::Twist_"):
    linear: Vector3
    angular: Vector3


RELIABLE = Policy.Reliability.Reliable(duration(seconds=1))
# The profiles of rclcpp: what a subscriber and a publisher have where nothing else is asked for.
DEFAULT = Qos(RELIABLE, Policy.History.KeepLast(10))
LATCHED = Qos(RELIABLE, Policy.Durability.TransientLocal, Policy.History.KeepLast(1))


class Domain:
    """A domain that the peer has joined, with the two topics by which an operator gives orders."""

    def __init__(self, number):
        self.participant = DomainParticipant(number)
        self.twists, self.orders = self.writer("/cmd_vel", Twist), self.writer("/order", String)

    def reader(self, name, kind, qos=DEFAULT):
        return DataReader(self.participant, self.topic(name, kind), qos=qos)

    def writer(self, name, kind):
        return DataWriter(self.participant, self.topic(name, kind), qos=DEFAULT)

    def topic(self, name, kind):
        # ROS 2 has its topics under "rt".
        return Topic(self.participant, "rt" + name, kind)

    def fly(self, speed):
        """Asks for a forward speed, m/s."""
        self.twists.write(Twist(Vector3(speed, 0.0, 0.0), Vector3(0.0, 0.0, 0.0)))
