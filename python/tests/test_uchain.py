"""What the package promises: the missions of the command, tables, errors, policies and steps."""

import math
import os
import signal
import threading

import pytest

import uchain
from conftest import SHORT


def test_a_mission_is_flown_and_told():
    mission = uchain.run(SHORT, seed=7)
    assert mission.summary["seed"] == 7
    assert mission.metrics["farthest_m"] > 3
    assert mission.success == (not mission.failures)
    again = uchain.run(mission.scenario_toml, seed=7)
    assert again.metrics == mission.metrics
    assert again.scenario_toml == mission.scenario_toml
    assert uchain.run(SHORT, seed=8).metrics != mission.metrics
    assert mission.report_html().startswith("<!")
    assert mission._repr_svg_().startswith("<svg")
    assert "straight" in uchain.scenarios()


def test_keys_are_those_of_the_scenario_file():
    nested = uchain.run(SHORT, radio={"packet_loss": 0.6}, duration_s=10)
    dotted = uchain.run(SHORT, **{"radio.packet_loss": 0.6, "duration_s": 10.0})
    assert nested.metrics == dotted.metrics
    assert "packet_loss = 0.6" in nested.scenario_toml
    assert uchain.run(SHORT, policy="t5", duration_s=2).summary["policy"] == "t5"


@pytest.mark.parametrize(
    "keys, parts",
    [
        ({"radio.packet_los": 0.2}, ["radio.packet_los=0.2", "did you mean packet_loss?"]),
        ({"radio": {"packet_loss": 7}}, ["radio.packet_loss=7", "from 0 to 1"]),
        ({"policy": "k-tund"}, ["did you mean k-tuned?"]),
        ({"radio.packet_loss": object()}, ["radio.packet_loss", "object"]),
        ({"fidelity": "virtual"}, ["virtual"]),
    ],
)
def test_wrong_keys_are_one_line(keys, parts):
    with pytest.raises(ValueError) as error:
        uchain.run(SHORT, **keys)
    assert "\n" not in str(error.value)
    for part in parts:
        assert part in str(error.value)


def test_wrong_scenarios_are_one_line():
    for scenario in ["no-such-scenario", "title = 1\n", "/"]:
        with pytest.raises(ValueError) as error:
            uchain.run(scenario)
        assert "\n" not in str(error.value) and "; " in str(error.value)


def test_a_campaign_is_a_table_whatever_the_threads():
    vary = {"radio.packet_loss": [0.0, 0.5], "policy.name": ["t5", "k-tuned"]}
    tables = [
        uchain.campaign(SHORT, 3, vary, threads=threads, duration_s=20).to_dict()
        for threads in (1, 2)
    ]
    assert tables[0] == tables[1]
    table = tables[0]
    assert table["radio.packet_loss"] == [0.0] * 6 + [0.5] * 6
    assert table["policy.name"][:6] == ["t5"] * 3 + ["k-tuned"] * 3
    assert table["seed"] == [1, 2, 3] * 4
    single = uchain.run(
        SHORT, seed=2, policy="k-tuned", duration_s=20, **{"radio.packet_loss": 0.5}
    )
    assert table["farthest_m"][10] == pytest.approx(single.metrics["farthest_m"], abs=1e-5)
    assert table["success"][10] == single.success
    chosen = uchain.campaign(SHORT, seeds=[5, 9], duration_s=2)
    assert chosen["seed"] == [5, 9] and len(chosen) == 2
    with pytest.raises(KeyError):
        chosen["no-such-column"]
    with pytest.raises(ValueError, match="vary"):
        uchain.campaign(SHORT, 1, {"radio.packet_loss": 0.5})
    with pytest.raises(ValueError, match="threads"):
        uchain.campaign(SHORT, 1, threads=0)


def test_what_a_new_user_tries_first():
    table = uchain.campaign(SHORT, 1, {"policy": ["t5", "k-tuned"]}, duration_s=5)
    assert table["policy.name"] == ["t5", "k-tuned"]
    with pytest.raises(ValueError, match="seed=3: .* give seeds="):
        uchain.campaign(SHORT, 2, seed=3)
    with pytest.raises(ValueError, match="seeds=3: .* give seed="):
        uchain.run(SHORT, seeds=3)
    law = uchain.RadioLaw(lambda distance_m, walls: 40.0 + 30.0 * math.log10(distance_m))
    laws = {"radio.model": [law.model, {"law": "log-distance"}]}
    assert len(uchain.campaign(SHORT, 1, laws, duration_s=5)) == 2


def test_tables_are_read_by_others():
    table = uchain.run(SHORT, duration_s=5).trace
    assert len(table) == 25 * 4
    times = table["time_s"]
    assert times == sorted(times) and table["role"][:4] == ["head", "relay", "relay", "base"]
    assert table.column_names[:2] == ["time_s", "node"]
    assert table.__arrow_c_stream__() is not None


def test_arrow_reads_a_table():
    pyarrow = pytest.importorskip("pyarrow")
    table = uchain.campaign(SHORT, 2, {"radio.packet_loss": [0.0, 0.5]}, duration_s=5)
    read = pyarrow.table(table)
    assert read.column_names == table.column_names
    assert read.to_pydict() == table.to_dict()


def test_polars_reads_a_table():
    polars = pytest.importorskip("polars")
    table = uchain.run(SHORT, duration_s=5).trace
    assert polars.DataFrame(table)["time_s"].to_list() == table["time_s"]


def test_pandas_reads_a_table():
    pandas = pytest.importorskip("pandas")
    table = uchain.campaign(SHORT, 2, duration_s=5)
    assert list(pandas.DataFrame(table.to_dict())["seed"]) == [1, 2]


def test_a_policy_that_copies_k_tuned_gives_its_missions_to_the_digit():
    copy, calls = uchain.Policy("k-tuned"), []

    def policy(drone, *ends):
        calls.append(drone)
        return copy(drone, *ends)

    for seed in (1, 2):
        own = uchain.run("straight", seed, policy="k-tuned", duration_s=120)
        called = uchain.run("straight", seed, policy=policy, duration_s=120, **{"policy.name": "k-tuned"})
        assert called.summary == own.summary
        assert called.trace.to_dict() == own.trace.to_dict()
    assert calls and set(calls) <= {1, 2}


def test_a_policy_moves_the_relays():
    still = uchain.run("straight", policy=lambda *_: 0.0, duration_s=120)
    own = uchain.run("straight", duration_s=120)
    assert still.trace.to_dict()["x_m"] != own.trace.to_dict()["x_m"]


def test_what_a_policy_does_wrong_is_told():
    with pytest.raises(ValueError, match="returned NaN for drone"):
        uchain.run("straight", policy=lambda *_: math.nan)

    def raises(*_):
        raise RuntimeError("no idea")

    with pytest.raises(RuntimeError, match="no idea"):
        uchain.run("straight", policy=raises)
    with pytest.raises(TypeError):
        uchain.run("straight", policy=lambda *_: "fast")
    with pytest.raises(ValueError, match="did you mean k-tuned?"):
        uchain.Policy("k-tund")


def test_a_simulation_is_stepped_looked_at_and_steered():
    simulation = uchain.Simulation(SHORT, live=True, duration_s=60)
    head = simulation.look()[0]
    assert (head["role"], head["state"], head["front"]) == ("head", "idle", None)
    simulation.step(10)
    simulation.order("explore", speed_mps=0.2)
    assert simulation.step(150)
    assert simulation.time_s == pytest.approx(32.0)
    assert simulation.order_now == "explore at 0.20 m/s"
    moved = simulation.look()[0]
    assert moved["way_m"] > head["way_m"] + 1.0
    assert moved["back"]["true_dbm"] < 0
    assert not simulation.step(1000) and simulation.is_over
    with pytest.raises(ValueError, match="did you mean explore"):
        simulation.order("explor")
    with pytest.raises(ValueError, match="speed_mps"):
        simulation.order("explore")
    with pytest.raises(ValueError, match="live=True"):
        uchain.Simulation(SHORT).order("return")


def test_a_policy_cannot_use_the_simulation_that_calls_it():
    simulation = uchain.Simulation("straight", policy=lambda *_: simulation.look() and 0.0)
    with pytest.raises(RuntimeError, match="between two steps"):
        while simulation.step(100):
            pass
    assert simulation.look()


def test_the_steps_are_those_of_a_run():
    simulation = uchain.Simulation(SHORT, seed=3, policy="t5")
    while simulation.step(7):
        pass
    trace = uchain.run(SHORT, seed=3, policy="t5").trace
    assert [drone["x_m"] for drone in simulation.look()] == trace["x_m"][-4:]


@pytest.mark.skipif(os.name != "posix", reason="signals")
def test_ctrl_c_ends_a_campaign():
    # A process that a shell has put into the background ignores the signal, and so would Python.
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    try:
        threading.Timer(0.5, os.kill, (os.getpid(), signal.SIGINT)).start()
        with pytest.raises(KeyboardInterrupt):
            uchain.campaign(SHORT, 20_000)
    finally:
        signal.signal(signal.SIGINT, before)


def test_other_threads_go_on_meanwhile():
    ticks, stop = [], threading.Event()

    def tick():
        while not stop.wait(0.001):
            ticks.append(1)

    thread = threading.Thread(target=tick)
    thread.start()
    before = len(ticks)
    try:
        uchain.run("demo")
    finally:
        stop.set()
        thread.join()
    assert len(ticks) > before
