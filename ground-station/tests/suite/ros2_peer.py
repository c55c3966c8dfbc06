"""A peer of another maker's DDS: it hears the topics of a station, and steers the head by it.

Its arguments are the domain, and `look` or `steer`. With `look` it ends with 0 once it has heard all topics
and nobody follows /cmd_vel and /order; with `steer` once it has taken over, the head has flown half a metre by its
Twists, has been ordered to hold when they stopped, and the base has taken the recall. It ends with 1 after
two minutes.
"""

import sys
import time
from dataclasses import dataclass

from cyclonedds.core import Policy, Qos
from cyclonedds.domain import DomainParticipant
from cyclonedds.idl import IdlStruct
from cyclonedds.idl.types import float32, float64, int32, sequence, uint8, uint32
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
class Float32(IdlStruct, typename="std_msgs::msg::dds_::Float32_"):
    data: float32


@dataclass
class Vector3(IdlStruct, typename="geometry_msgs::msg::dds_::Vector3_"):
    x: float64
    y: float64
    z: float64


@dataclass
class Twist(IdlStruct, typename="geometry_msgs::msg::dds_::Twist_"):
    linear: Vector3
    angular: Vector3


@dataclass
class KeyValue(IdlStruct, typename="diagnostic_msgs::msg::dds_::KeyValue_"):
    key: str
    value: str


@dataclass
class DiagnosticStatus(IdlStruct, typename="diagnostic_msgs::msg::dds_::DiagnosticStatus_"):
    level: uint8
    name: str
    message: str
    hardware_id: str
    values: sequence[KeyValue]


@dataclass
class DiagnosticArray(IdlStruct, typename="diagnostic_msgs::msg::dds_::DiagnosticArray_"):
    header: Header
    status: sequence[DiagnosticStatus]


# The profile of rclcpp: what a subscriber and a publisher have where nothing else is asked for.
DEFAULT = Qos(Policy.Reliability.Reliable(duration(seconds=1)), Policy.History.KeepLast(10))


class Peer:
    def __init__(self, domain):
        self.ends = time.time() + 120
        self.domain = DomainParticipant(domain)
        self.diagnostics = self.reader("/diagnostics", DiagnosticArray)
        self.notices = self.reader("/notice", String)
        self.link = self.reader("/drone_0/link/back/filtered_dbm", Float32)
        self.odometer = self.reader("/drone_0/odometer_m", Float32)
        self.twists, self.orders = self.writer("/cmd_vel", Twist), self.writer("/order", String)
        self.known, self.strength, self.flown, self.said = {}, None, 0.0, []

    def topic(self, name, kind):
        return Topic(self.domain, "rt" + name, kind)

    def reader(self, name, kind):
        return DataReader(self.domain, self.topic(name, kind), qos=DEFAULT)

    def writer(self, name, kind):
        return DataWriter(self.domain, self.topic(name, kind), qos=DEFAULT)

    def listen(self):
        for message in self.diagnostics.take():
            self.known = {status.hardware_id: status for status in message.status}
        for message in self.link.take():
            self.strength = message.data
        for message in self.odometer.take():
            self.flown = message.data
        self.said += [message.data for message in self.notices.take()]

    def until(self, what, is_so, meanwhile=lambda: None):
        while not is_so():
            if time.time() > self.ends:
                sys.exit(f"no {what}: {self.known}, {self.strength}, {self.flown}, {self.said}")
            meanwhile()
            time.sleep(0.05)
            self.listen()

    def hears_all(self):
        drones = {f"drone_{number}" for number in range(5)}
        return drones <= self.known.keys() and self.strength is not None

    def has_heard(self, text):
        return any(text in line for line in self.said)

    def fly(self):
        # An order comes once, and the station may not have known this peer yet: it is given again.
        if self.flown == 0.0:
            self.orders.write(String("steer"))
        self.twists.write(Twist(Vector3(0.25, 0.0, 0.0), Vector3(0.0, 0.0, 0.0)))


def main(domain, does):
    peer = Peer(domain)
    peer.until("topics", peer.hears_all)
    assert -120 < peer.strength < 0, peer.strength
    values = {pair.key: pair.value for pair in peer.known["drone_0"].values}
    assert float(values["back_filtered_dbm"]) < 0 and float(values["odometer_m"]) >= 0, values
    if does == "look":
        # Whoever follows a topic was found with those that publish.
        assert not peer.twists.get_matched_subscriptions() and not peer.orders.get_matched_subscriptions()
        return
    peer.until("flight", lambda: peer.flown > 0.5, peer.fly)
    peer.until("hold", lambda: peer.has_heard("taken the order to hold"))
    peer.orders.write(String("return"))
    peer.until("recall", lambda: peer.has_heard("taken the order to recall"))


main(int(sys.argv[1]), sys.argv[2])
