"""How fast the simulator calls Python, and how fast its environments step, on this machine.

python python/benchmarks/speed.py
"""

import time

import numpy

import uchain
from uchain.env import RelayEnv, parallel_env


def seconds(work):
    """The least time of five, of this thread alone: other programs do not count."""
    times = []
    for _ in range(5):
        began = time.thread_time()
        work()
        times.append(time.thread_time() - began)
    return min(times)


def calls():
    """A policy in the loop, the mission included."""
    count = 0

    def policy(drone, front_dbm, front_mps, back_dbm, back_mps):
        nonlocal count
        count += 1
        return 0.05 * (back_dbm - front_dbm)

    scenario, keys = "straight-n15", {"link": "ideal"}
    uchain.run(scenario, policy=policy, **keys)
    per_mission, count = count, 0
    rate = per_mission / seconds(lambda: uchain.run(scenario, policy=policy, **keys))
    print(f"policy of Python in a mission: {rate:,.0f} calls a second")


def law():
    """The calls alone: a radio law is called in the same way as a policy, without a mission."""
    count = 5 * len(uchain.RadioLaw(lambda *_: 50.0).distances_m)
    took = seconds(lambda: uchain.RadioLaw(lambda distance_m, walls: 40.0 + 20.0 * walls))
    print(f"calls of Python alone: {count / took:,.0f} a second")


def environments():
    """Steps a second of the environments, resets included."""
    for fidelity in ("point", "flight"):
        relay = RelayEnv("relay-pair", fidelity=fidelity)
        action = numpy.array([0.1], numpy.float32)

        def episode():
            relay.reset(seed=1)
            while not relay.step(action)[3]:
                pass

        print(f"Gymnasium, one relay, {fidelity}: {100 / seconds(episode):,.0f} steps a second")
    for link in ("exact", "ideal"):
        relays = parallel_env("random-n15", link=link, duration_s=60)
        actions = {agent: action for agent in relays.possible_agents}

        def mission():
            relays.reset(seed=1)
            while relays.agents:
                relays.step(actions)

        rate = 300 / seconds(mission)
        print(f"PettingZoo, 14 relays, link {link}: {rate:,.0f} steps, {14 * rate:,.0f} of agents a second")


if __name__ == "__main__":
    calls()
    law()
    environments()
