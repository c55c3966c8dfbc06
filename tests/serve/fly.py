"""Flies the head of a chain down the tunnel and back, and calls all drones home."""
import sys

import cflib.crtp
from cflib.crazyflie import Crazyflie
from cflib.crazyflie.log import LogConfig
from cflib.crazyflie.syncCrazyflie import SyncCrazyflie
from cflib.crazyflie.syncLogger import SyncLogger

URI = sys.argv[1] if len(sys.argv) > 1 else "udp://127.0.0.1:19854"  # the base
FAR = float(sys.argv[2]) if len(sys.argv) > 2 else 10.0  # m
LANDED, RETURN = 8, 2  # node0.state, uchain.task

cflib.crtp.init_drivers()
with SyncCrazyflie(URI, cf=Crazyflie(rw_cache="./cache")) as scf:
    log = LogConfig("chain", period_in_ms=100)
    for name in ("node0.odometer", "node0.backRssi", "node0.state"):
        log.add_variable(name)
    speed, farthest, start_ms = 0.3, 0.0, None
    with SyncLogger(scf, log) as rows:
        for time_ms, row, _ in rows:
            start_ms = start_ms or time_ms
            way = row["node0.odometer"]
            farthest = max(farthest, way)
            # The head stops where its links can bear no more: give up after five minutes.
            if way > FAR or time_ms - start_ms > 300_000:
                speed = -0.3
            elif speed < 0 and way < 2.0:
                break
            # Ten times a second: a set-point holds for half a second.
            scf.cf.commander.send_hover_setpoint(speed, 0, 0, 0.4)
        scf.cf.param.set_value("uchain.task", RETURN)
        for time_ms, row, _ in rows:
            if row["node0.state"] == LANDED:
                break
    print(f"reached {farthest:.1f} m, landed after {time_ms / 1000:.1f} s")
