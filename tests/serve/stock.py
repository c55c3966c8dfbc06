"""Connects to the vendor's firmware in the emulator, arms it, hovers it and logs it."""
import json
import sys
import time

import cflib.crtp
from cflib.crazyflie import Crazyflie
from cflib.crazyflie.log import LogConfig
from cflib.crazyflie.syncCrazyflie import SyncCrazyflie
from cflib.crazyflie.syncLogger import SyncLogger

URI = sys.argv[1] if len(sys.argv) > 1 else "udp://127.0.0.1:19850"
HEIGHT, HOVER_S = 0.4, 12.0
NAMES = ("stateEstimate.x", "stateEstimate.y", "stateEstimate.z", "range.zrange", "range.front")

cflib.crtp.init_drivers()
with SyncCrazyflie(URI, cf=Crazyflie(rw_cache=None)) as scf:
    cf = scf.cf
    variables = sum(len(group) for group in cf.log.toc.toc.values())
    parameters = sum(len(group) for group in cf.param.toc.toc.values())
    # The vendor's firmware calibrates its gyroscope before it lets itself be armed.
    time.sleep(2)
    cf.supervisor.send_arming_request(True)
    log = LogConfig("hover", period_in_ms=20)
    for name in NAMES:
        log.add_variable(name, "float")
    rows, start_ms = [], None
    commander = cf.high_level_commander
    with SyncLogger(scf, log) as logger:
        commander.takeoff(HEIGHT, 2.0)
        for time_ms, row, _ in logger:
            start_ms = start_ms or time_ms
            since = (time_ms - start_ms) / 1000
            if since > 5.0:
                rows.append([row[name] for name in NAMES])
            if since > 5.0 + HOVER_S:
                break
        commander.land(0.0, 2.0)
        for time_ms, row, _ in logger:
            if (time_ms - start_ms) / 1000 > since + 3.0:
                break
    heights = [row[2] for row in rows]
    print(json.dumps({
        "variables": variables,
        "parameters": parameters,
        "rows": len(rows),
        "height_m": sum(heights) / len(heights),
        "spread_m": max(heights) - min(heights),
        "front_mm": rows[-1][4],
    }))
    assert abs(sum(heights) / len(heights) - HEIGHT) < 0.05, heights
