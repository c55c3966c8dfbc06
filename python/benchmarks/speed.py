"""How fast the simulator calls Python, and how fast its environments step, on this machine.

python python/benchmarks/speed.py
"""

import time

import numpy

import uchain
from uchain.env import RelayEnv, parallel_env


def seconds(work, clock=time.thread_time):
    """The least time of five, of this thread alone: other programs do not count."""
    times = []
    for _ in range(5):
        began = clock()
        work()
        times.append(clock() - began)
    return min(times)


def calls():
    """A policy in the loop of a campaign: the rule of the built-in `k`, and the same missions without Python."""
    count = 0

    def policy(drone, front_dbm, front_mps, back_dbm, back_mps):
        nonlocal count
        count += 1
        return 0.05 * (back_dbm - front_dbm)

    class Policy:
        def __call__(self, *ends):
            return policy(*ends)

    for scenario, missions in (("straight", 24), ("straight-n15", 4), ("random-n15", 4)):
        for link in ("ideal", "exact"):
            keys = {"link": link, "policy.name": "k"}

            def fly(law=None, threads=1, scenario=scenario, missions=missions, keys=keys):
                if law is None:
                    uchain.campaign(scenario, missions, threads=threads, **keys)
                else:
                    uchain.campaign(scenario, missions, policy=law, threads=threads, **keys)

            count = 0
            fly(policy)
            per_campaign = count
            plain = seconds(fly, time.process_time)
            print(f"policy of Python, {scenario}, link {link}, {per_campaign:,} calls in {missions} missions:")
            for name, law, threads in (
                ("a function, 1 thread", policy, 1),
                ("a function, 2 threads", policy, 2),
                ("a class, 1 thread", Policy, 1),
            ):
                took = seconds(lambda law=law, threads=threads: fly(law, threads), time.process_time)
                rate = per_campaign / took
                print(f"  {name}: {rate:,.0f} calls a second of processor time, missions included")
            print(f"  the simulator alone, for as many turns: {per_campaign / plain:,.0f} a second", flush=True)


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
