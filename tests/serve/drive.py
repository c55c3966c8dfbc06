"""What tests/suite/serve.rs and bridge.rs have an unmodified cflib do to served drones: `drive.py PART HOST PORT COUNT`.

Nothing here is timed: every wait is for something to happen, and one generous limit ends the whole
with a trace of where it stood. The script to learn from is fly.py.
"""
import faulthandler
import math
import os
import subprocess
import sys
import tempfile
import threading
import traceback

PART, HOST, PORT, COUNT = sys.argv[1], sys.argv[2], int(sys.argv[3]), int(sys.argv[4])
LIMIT_S = 300
os.environ["SCAN_ADDRESS"] = HOST

import cflib.crtp  # noqa: E402
from cflib.crazyflie import Crazyflie  # noqa: E402
from cflib.crazyflie.log import LogConfig  # noqa: E402
from cflib.crazyflie.swarm import Swarm  # noqa: E402
from cflib.crazyflie.syncCrazyflie import SyncCrazyflie  # noqa: E402
from cflib.positioning.motion_commander import MotionCommander  # noqa: E402
from cflib.positioning.position_hl_commander import PositionHlCommander  # noqa: E402
from cflib.utils.reset_estimator import reset_estimator  # noqa: E402

URIS = [f"udp://{HOST}:{PORT + n}" for n in range(COUNT)]
IDLE, LEADING, RELAYING, LANDED, RETIRING = 0, 3, 4, 8, 11
WAIT = 0


def scan():
    """Every drone of the chain is found, and nothing else."""
    found = [uri for uri, _ in cflib.crtp.scan_interfaces() if uri.startswith("udp://")]
    assert found == URIS, found


def names(toc):
    return {f"{group}.{name}" for group in toc for name in toc[group]}


def tables(cf):
    """Both tables arrive whole, with what cfclient looks for and what the chain adds."""
    logs, params = names(cf.log.toc.toc), names(cf.param.toc.toc)
    for name in ("stabilizer.roll", "stateEstimate.x", "range.front", "pm.vbat", "uchain.state"):
        assert name in logs, f"no log variable {name}"
    for name in ("uchain.task", "uchain.speed", "uchain.height"):
        assert name in params, f"no parameter {name}"
    for name in params:
        assert cf.param.get_value(name) is not None, f"{name} has no value"
    print(f"{len(logs)} log variables, {len(params)} parameters")


FIRST = ("stateEstimate.x", "stateEstimate.y", "stateEstimate.z", "stateEstimate.vx", "pm.vbat")
SECOND = ("stabilizer.roll", "stabilizer.pitch", "stabilizer.yaw", "range.front", "uchain.state")


def logs(cf, seconds):
    """Ten variables at 100 Hz: every time stamp is 10 ms after the one before."""
    wanted = seconds * 100 + 1
    enough = [threading.Event(), threading.Event()]
    stamps = [[], []]

    def take(block):
        def taken(stamp, row, _):
            assert all(math.isfinite(value) for value in row.values()), row
            stamps[block].append(stamp)
            if len(stamps[block]) >= wanted:
                enough[block].set()
        return taken

    configs = []
    for block, variables in enumerate((FIRST, SECOND)):
        config = LogConfig(f"block {block}", period_in_ms=10)
        for variable in variables:
            config.add_variable(variable)
        cf.log.add_config(config)
        config.data_received_cb.add_callback(take(block))
        configs.append(config)
    for config in configs:
        config.start()
    for event in enough:
        event.wait()
    for config in configs:
        config.stop()
        config.delete()
    for block in stamps:
        steps = {(after - before) % 2**24 for before, after in zip(block, block[1:])}
        assert steps == {10}, f"time stamps step by {sorted(steps)} ms"
    print(f"{len(stamps[0])} and {len(stamps[1])} rows of 5 variables, all 10 ms apart")


def set_and_read(cf, name, value):
    """Sets a parameter and asks the drone for it anew."""
    read = threading.Event()
    cf.param.add_update_callback(group=name.split(".")[0], name=name.split(".")[1],
                                 cb=lambda _, now: close(now, value) and read.set())
    cf.param.set_value(name, value)
    read.wait()
    read.clear()
    cf.param.request_param_update(name)
    read.wait()
    assert close(cf.param.get_value(name), value)


def close(text, value):
    return abs(float(text) - value) < 1e-6


def parameters(cf):
    """What is set is what is read; what is to be read only cannot be set."""
    set_and_read(cf, "uchain.speed", 0.125)
    set_and_read(cf, "uchain.height", 0.5)
    set_and_read(cf, "uchain.task", 0)
    try:
        cf.param.set_value("uchain.node", 3)
    except AttributeError:
        return
    raise AssertionError("uchain.node was set")


def look():
    scan()
    with SyncCrazyflie(URIS[-1], cf=Crazyflie()) as scf:
        scf.wait_for_params()
        parameters(scf.cf)
    with SyncCrazyflie(URIS[0], cf=Crazyflie()) as scf:
        scf.wait_for_params()
        tables(scf.cf)
        logs(scf.cf, 30)
        scan()  # Somebody else looks round; nobody is thrown out.
        logs(scf.cf, 1)
    # A drone remembers what it was set to, for the next client too.
    with SyncCrazyflie(URIS[-1], cf=Crazyflie()) as scf:
        scf.wait_for_params()
        assert close(scf.cf.param.get_value("uchain.speed"), 0.125)


def bridged():
    """The one drone behind a bridge, which is polled."""
    scan()
    with SyncCrazyflie(URIS[0], cf=Crazyflie()) as scf:
        scf.wait_for_params()
        tables(scf.cf)
        parameters(scf.cf)


class Watched:
    """A drone that is connected to for what it does."""

    def __init__(self, uri):
        self.seen, self.now, self.changed = set(), None, threading.Condition()
        self.scf = SyncCrazyflie(uri, cf=Crazyflie())
        self.scf.open_link()
        config = LogConfig("watched", period_in_ms=100)
        config.add_variable("uchain.state")
        self.scf.cf.log.add_config(config)
        config.data_received_cb.add_callback(self.look)
        config.start()

    def look(self, _, row, __):
        with self.changed:
            self.now = row["uchain.state"]
            self.seen.add(self.now)
            self.changed.notify_all()

    def wait_for(self, states):
        with self.changed:
            self.changed.wait_for(lambda: self.now in states)

    def close(self):
        self.scf.close_link()


def fly():
    """fly.py orders at the base, down the tunnel and back, while every other drone is watched."""
    far = sys.argv[5]
    others = [Watched(uri) for uri in URIS[:-1]]
    script = os.path.join(os.path.dirname(os.path.abspath(__file__)), "fly.py")
    with tempfile.TemporaryDirectory() as folder:  # for the script's cache
        subprocess.run([sys.executable, script, URIS[-1], far], check=True, cwd=folder)
    head, relays = others[0], others[1:]
    for relay in relays:
        relay.wait_for({IDLE, LANDED})
    flew = [relay for relay in relays if RELAYING in relay.seen]
    assert len(flew) >= 2, [sorted(relay.seen) for relay in relays]
    # As the head comes back, relays that it no longer needs fly home and wait there.
    ended = [(relay.now, sorted(relay.seen)) for relay in flew]
    assert all(now == LANDED or RETIRING in seen for now, seen in ended), ended
    head.wait_for({LANDED})
    print(f"{len(flew)} relays flew and landed")
    for other in others:
        other.close()


class Console:
    """What a drone prints on its console from now on."""

    def __init__(self, cf):
        self.text, self.changed = "", threading.Condition()
        cf.console.receivedChar.add_callback(self.take)

    def take(self, text):
        with self.changed:
            self.text += text
            self.changed.notify_all()

    def wait_for(self, text):
        with self.changed:
            self.changed.wait_for(lambda: text in self.text)


def motion():
    """A MotionCommander at the base flies the head, and lands it; a second flight needs a wait."""
    head = Watched(URIS[0])
    with SyncCrazyflie(URIS[-1], cf=Crazyflie()) as scf:
        console = Console(scf.cf)
        scf.cf.supervisor.send_arming_request(True)
        with MotionCommander(scf, default_height=0.3) as commander:
            commander.forward(1.5, velocity=0.3)
            commander.turn_left(90)
            head.wait_for({LEADING})
        console.wait_for("only vx is flown")
        head.wait_for({LANDED})
        with MotionCommander(scf) as commander:
            commander.start_forward()
            console.wait_for("The head stays down")
        scf.cf.param.set_value("uchain.task", WAIT)
        head.wait_for({IDLE})
        with PositionHlCommander(scf) as commander:
            head.wait_for({LEADING})
            commander.forward(0.5)
            commander.go_to(0.0, 0.0, 0.5)
        console.wait_for("no mission flies to a place")
        head.wait_for({LANDED})
        assert console.text.count("no mission flies to a place") == 1, console.text
    head.close()


def estimators():
    """Every drone says that it knows where it stands; a set-point at a relay is refused once."""
    with SyncCrazyflie(URIS[-1], cf=Crazyflie()) as scf:
        reset_estimator(scf)
    with Swarm(URIS) as swarm:
        swarm.reset_estimators()
        for x, y, z in swarm.get_estimated_positions().values():
            assert all(math.isfinite(value) for value in (x, y, z))
    with SyncCrazyflie(URIS[1], cf=Crazyflie()) as scf:
        console = Console(scf.cf)
        for _ in range(60):
            scf.cf.commander.send_hover_setpoint(0.2, 0, 0, 0.4)
            threading.Event().wait(0.05)
        console.wait_for("give them at the base.")
        assert console.text.count("Refused") == 1, console.text


class Rows:
    """The rows of one log block."""

    def __init__(self, cf, variable):
        self.variable, self.count, self.changed = variable, 0, threading.Condition()
        config = LogConfig("rows", period_in_ms=50)
        config.add_variable(variable)
        cf.log.add_config(config)
        config.data_received_cb.add_callback(self.take)
        config.start()

    def take(self, _, row, __):
        assert list(row) == [self.variable], row
        with self.changed:
            self.count += 1
            self.changed.notify_all()

    def wait_for(self, more):
        with self.changed:
            wanted = self.count + more
            self.changed.wait_for(lambda: self.count >= wanted)


def two():
    """Two clients at one port, as cfclient and a script: each reads, logs and sets for itself."""
    with SyncCrazyflie(URIS[-1], cf=Crazyflie()) as one:
        first = Rows(one.cf, "uchain.state")
        first.wait_for(5)
        with SyncCrazyflie(URIS[-1], cf=Crazyflie()) as other:
            second = Rows(other.cf, "uchain.odometer")
            first.wait_for(40)
            second.wait_for(40)
            for scf in (one, other):
                scf.wait_for_params()
                set_and_read(scf.cf, "uchain.speed", 0.125)
        first.wait_for(5)


faulthandler.dump_traceback_later(LIMIT_S, exit=True)
cflib.crtp.init_drivers()
try:
    {
        "look": look, "fly": fly, "bridged": bridged,
        "motion": motion, "estimators": estimators, "two": two,
    }[PART]()
except BaseException:
    traceback.print_exc()
    sys.stdout.flush()
    # Connections that are still open would keep the interpreter waiting.
    os._exit(1)
