"""Steps a second of this package's environments beside other drone simulators, in one run on one machine.

python python/benchmarks/peers.py

Those that are not installed are named and left out. gym-pybullet-drones and crazyflow are installed from
their repositories (https://github.com/utiasDSL), with pybullet or jax from PyPI. What a step is differs:
the table says how long it lasts, how often physics moves each drone in it, and what a step contains.
"""

import contextlib
import io
import time

import numpy

#: Each is measured for about this long, s, and the fastest of these many parts counts.
SECONDS, PARTS = 3.0, 6


def steps_a_second(step):
    """The steps a second of the fastest part, by processor time of all threads: other programs do not count."""
    step()
    best = 0.0
    for _ in range(PARTS):
        began, count = time.process_time(), 0
        while time.process_time() - began < SECONDS / PARTS:
            step()
            count += 1
        best = max(best, count / (time.process_time() - began))
    return best


def row(name, step, *, drones, seconds, physics_hz, contains):
    """Measure and print one row. `drones` are those that are moved in each step."""
    rate = steps_a_second(step)
    physics = round(seconds * physics_hz)
    print(
        f"| {name} | {drones} | {seconds:.4g} s | {physics} | {rate:,.0f} | {rate * drones:,.0f} "
        f"| {rate * drones * seconds:,.0f} | {rate * drones * physics:,.0f} | {contains} |",
        flush=True,
    )


def own():
    """The environments of this package: the head and the relays fly, the base stands."""
    from uchain.env import RelayEnv, parallel_env

    for fidelity, physics_hz in (("point", 50), ("flight", 1000)):
        relay = RelayEnv("relay-pair", fidelity=fidelity)
        relay.reset(seed=1)
        action = numpy.array([0.1], numpy.float32)

        def step(relay=relay, action=action):
            if relay.step(action)[3]:
                relay.reset(seed=1)

        row(
            f"uchain, {fidelity}", step, drones=2, seconds=0.2, physics_hz=physics_hz,
            contains="packets, tunnel, agents",
        )
    for name, keys, physics_hz in (
        ("point", {}, 50),
        ("point, ideal link", {"link": "ideal"}, 50),
        ("flight", {"fidelity": "flight"}, 1000),
    ):
        relays = parallel_env("random-n15", **keys)
        relays.reset(seed=1)
        actions = {agent: action for agent in relays.possible_agents}

        def step_all(relays=relays, actions=actions):
            relays.step(actions)
            if not relays.agents:
                relays.reset(seed=1)

        row(
            f"uchain, {name}", step_all, drones=15, seconds=0.2, physics_hz=physics_hz,
            contains="strengths, tunnel, agents" if keys.get("link") else "packets, tunnel, agents",
        )


def pybullet():
    """gym-pybullet-drones with velocities as actions, at its examples' rates: physics 240 Hz, control 30 Hz.

    Its learning environments begin anew where a drone leaves their room, so the one without an end flies.
    """
    from gym_pybullet_drones.envs.VelocityAviary import VelocityAviary
    from gym_pybullet_drones.utils.enums import Physics

    for physics, name in ((Physics.PYB, "Bullet"), (Physics.DYN, "explicit dynamics")):
        for drones in (2, 15):
            with contextlib.redirect_stdout(io.StringIO()):
                aviary = VelocityAviary(num_drones=drones, physics=physics, ctrl_freq=30)
                aviary.reset(seed=1)
            # Up, and not so fast that it leaves the place where numbers are exact.
            action = numpy.tile(numpy.array([0.0, 0.0, 1.0, 0.05], numpy.float32), (drones, 1))

            def step(aviary=aviary, action=action):
                aviary.step(action)

            row(
                f"gym-pybullet-drones, {name}", step, drones=drones, seconds=1 / 30, physics_hz=240,
                contains="PID",
            )
            aviary.close()


def crazyflow():
    """crazyflow on the processor, with attitudes as actions: one drone in each of many worlds."""
    import crazyflow  # noqa: F401  It registers its environments, and has to come before SciPy.
    import gymnasium
    import jax

    for worlds in (1, 64, 1024):
        worlds_at_once = gymnasium.make_vec("DroneReachPos-v0", num_envs=worlds, freq=50, device="cpu")
        worlds_at_once.reset(seed=1)
        action = numpy.zeros((worlds, 4), numpy.float32)
        action[:, 3] = 0.3

        def step(worlds_at_once=worlds_at_once, action=action):
            jax.block_until_ready(worlds_at_once.step(action)[0])

        row(
            f"crazyflow, {worlds} worlds", step, drones=worlds, seconds=0.02, physics_hz=500,
            contains="attitude control",
        )
        worlds_at_once.close()


def main():
    print(
        "| simulator | drones | a step lasts | physics in it | steps/s | drones' steps/s "
        "| drones' seconds/s | drones' physics/s | beside physics |"
    )
    print("|---|---|---|---|---|---|---|---|---|")
    for measure in (crazyflow, pybullet, own):
        try:
            measure()
        except ImportError as error:
            print(f"{measure.__name__} is left out: {error}")


if __name__ == "__main__":
    main()
