"""How fast the simulator calls Python, and how fast its environments step, on this machine.

python python/benchmarks/speed.py
"""

import time

import numpy

import uchain
from uchain.env import RelayEnv, parallel_env


def seconds(work):
    """The least time of five."""
    times = []
    for _ in range(5):
        began = time.perf_counter()
        work()
        times.append(time.perf_counter() - began)
    return min(times)


def calls():
    """A policy in the loop: with the mission, and the calls alone."""
    count = 0

    def policy(drone, front_dbm, front_mps, back_dbm, back_mps):
        nonlocal count
        count += 1
        return 0.05 * (back_dbm - front_dbm)

    scenario, keys = "straight-n15", {"link": "ideal"}
    uchain.run(scenario, policy=policy, **keys)
    per_mission, count = count, 0
    with_python = seconds(lambda: uchain.run(scenario, policy=policy, **keys))
    without = seconds(lambda: uchain.run(scenario, policy="k-tuned", **keys))
    print(f"policy of Python: {per_mission / with_python:,.0f} calls a second with the mission")
    alone = with_python - without
    print(f"policy of Python: {per_mission / alone:,.0f} calls a second without it")


def law():
    """A radio law, when it is made."""
    count = 5 * len(uchain.RadioLaw(lambda *_: 50.0).distances_m)
    took = seconds(lambda: uchain.RadioLaw(lambda distance_m, walls: 40.0 + distance_m + walls))
    print(f"radio law: {count / took:,.0f} calls a second")


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
