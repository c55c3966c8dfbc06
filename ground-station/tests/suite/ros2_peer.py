"""A peer of another maker's DDS: it hears the topics of a station, and steers the head by it.

Its arguments are the domain, and `look` or `steer`. With `look` it ends with 0 once it has heard all topics
and no subscriber follows /cmd_vel and /order; with `steer` once it has taken over, the head has flown half a metre by its
Twists, has been ordered to hold when they stopped, and the base has taken the recall. It ends with 1 after
two minutes.
"""

import sys
import time
from dataclasses import dataclass
from pathlib import Path

from cyclonedds.idl import IdlStruct
from cyclonedds.idl.types import float32, sequence, uint8

sys.path.insert(0, str(Path(__file__).parents[3] / "sim-harness/ros2-topics/tests"))

from dds_peer import Domain, Header, String


@dataclass
class Float32(IdlStruct, typename="std_msgs::msg::dds_::Float32_"):
    data: float32


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


class Peer:
    def __init__(self, domain):
        self.ends = time.time() + 120
        self.domain = Domain(domain)
        self.diagnostics = self.domain.reader("/diagnostics", DiagnosticArray)
        self.notices = self.domain.reader("/notice", String)
        self.link = self.domain.reader("/drone_0/link/back/filtered_dbm", Float32)
        self.odometer = self.domain.reader("/drone_0/odometer_m", Float32)
        self.known, self.strength, self.flown, self.said = {}, None, 0.0, []

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

    def values(self):
        return {pair.key: pair.value for pair in self.known["drone_0"].values}

    # The first diagnostics may be of a moment at which the base had not heard of the head's link yet.
    def hears_all(self):
        drones = {f"drone_{number}" for number in range(5)}
        hears_drones = drones <= self.known.keys() and self.strength is not None
        return hears_drones and float(self.values().get("back_filtered_dbm") or 0) < 0

    def has_heard(self, text):
        return any(text in line for line in self.said)

    def fly(self):
        # An order comes once, and the station may not have known this peer yet: it is given again.
        if self.flown == 0.0:
            self.domain.orders.write(String("steer"))
        self.domain.fly(0.25)


def main(domain, does):
    peer = Peer(domain)
    peer.until("topics", peer.hears_all)
    assert -120 < peer.strength < 0, peer.strength
    assert float(peer.values()["odometer_m"]) >= 0, peer.values()
    if does == "look":
        # A station that followed a topic would have been found together with what it publishes.
        writers = (peer.domain.twists, peer.domain.orders)
        assert not any(writer.get_matched_subscriptions() for writer in writers)
        return
    peer.until("flight", lambda: peer.flown > 0.5, peer.fly)
    peer.until("hold", lambda: peer.has_heard("taken the order to hold"))
    peer.domain.orders.write(String("return"))
    peer.until("recall", lambda: peer.has_heard("taken the order to recall"))


main(int(sys.argv[1]), sys.argv[2])
