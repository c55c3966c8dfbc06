"""Policies of Python in campaigns, and beside built-in ones by the measures of the benchmark."""

import math
import sys
import threading
import time

import pytest

import uchain

K_TUNED = {"policy.name": "k-tuned"}


def test_a_campaign_of_a_copy_of_k_tuned_is_its_campaign_whatever_the_threads():
    own = uchain.campaign("straight", 4, policy="k-tuned", duration_s=120).to_dict()
    for threads in (1, 2):
        copy = uchain.campaign(
            "straight", 4, policy=uchain.Policy("k-tuned"), threads=threads, duration_s=120, **K_TUNED
        )
        assert repr(copy.to_dict()) == repr(own)
    still = uchain.campaign("straight", 4, policy=lambda *_: 0.0, duration_s=120, **K_TUNED)
    assert still["path_m"] != own["path_m"] or still["gap_db"] != own["gap_db"]


class Damped:
    """A policy with a memory."""

    def __init__(self):
        self.before = {}

    def __call__(self, drone, front_dbm, front_mps, back_dbm, back_mps):
        difference = back_dbm - front_dbm
        change = difference - self.before.get(drone, difference)
        self.before[drone] = difference
        return 0.03 * difference + 0.1 * change


def test_of_a_class_each_mission_has_an_object_of_its_own():
    tables = [
        uchain.campaign("straight-n4", 6, policy=Damped, threads=threads).to_dict()
        for threads in (1, 2)
    ]
    assert repr(tables[0]) == repr(tables[1])
    single = uchain.run("straight-n4", 6, policy=Damped())
    assert tables[0]["path_m"][5] == pytest.approx(single.metrics["path_m"], abs=1e-5)
    assert uchain.run("straight-n4", 6, policy=Damped).metrics == single.metrics

    class Broken:
        def __init__(self):
            raise RuntimeError("no memory")

    with pytest.raises(RuntimeError, match="no memory") as raised:
        uchain.campaign("relay-pair", 2, policy=Broken, duration_s=20)
    told = str(getattr(raised.value, "__notes__", ""))
    assert "the policy was made for the mission of seed" in told or sys.version_info < (3, 11)


def test_a_grid_is_flown_by_a_policy():
    table = uchain.campaign(
        "straight", 2, {"radio.packet_loss": [0.0, 0.5]}, policy=lambda *_: 0.05, duration_s=120
    )
    assert table["radio.packet_loss"] == [0.0, 0.0, 0.5, 0.5] and table["seed"] == [1, 2, 1, 2]
    single = uchain.run(
        "straight", 2, policy=lambda *_: 0.05, duration_s=120, **{"radio.packet_loss": 0.5}
    )
    assert table["farthest_m"][3] == pytest.approx(single.metrics["farthest_m"], abs=1e-5)


def test_calls_of_two_missions_at_once_have_clocks_of_their_own():
    """While one call sleeps, another mission calls."""
    threads = set()

    def policy(*_):
        threads.add(threading.get_ident())
        time.sleep(0.02)
        return 0.0

    uchain.campaign("relay-pair", 4, policy=policy, threads=2, duration_s=4, timeout_s=5.0)
    assert len(threads) == 2


def without_end():
    while True:
        pass


def raises():
    raise RuntimeError("no idea")


@pytest.mark.parametrize(
    "failure, error, text",
    [
        (lambda: math.nan, ValueError, r"returned NaN for drone \d of seed \d+; give a finite number"),
        (raises, RuntimeError, "no idea"),
        (without_end, TimeoutError, r"took longer than 0.3 s for drone \d of seed \d+"),
        (lambda: "fast", TypeError, "str"),
    ],
)
def test_what_a_policy_does_wrong_ends_the_campaign(failure, error, text):
    flown = []

    def policy(drone, *_):
        flown.append(drone)
        return failure() if len(flown) > 20 else 0.0

    with pytest.raises(error, match=text) as raised:
        uchain.campaign("relay-pair", 2_000, policy=policy, threads=2, timeout_s=0.3)
    told = str(raised.value) + str(getattr(raised.value, "__notes__", ""))
    assert "of seed" in told or sys.version_info < (3, 11)
    # It was not called for long after.
    assert len(flown) < 30
    with pytest.raises(error, match=text):
        uchain.compare(policy, scenarios=["s-turns-5"], runs=500, threads=2, timeout_s=0.3)
    with pytest.raises(error, match=text):
        uchain.compare(policy, drawn=True, runs=100, threads=2, timeout_s=0.3)


def test_a_policy_is_compared_by_the_measures_of_the_benchmark():
    copy = uchain.Policy("k-tuned")
    table = uchain.compare(
        {"copy": copy, "still": lambda *_: 0.0},
        against=["k-tuned"],
        scenarios=["s-turns-5", "repair-6"],
        runs=3,
    ).to_dict()
    assert table["scenario"] == ["s-turns-5"] * 3 + ["repair-6"] * 3
    assert table["policy"] == ["copy", "still", "k-tuned"] * 2
    assert table["runs"] == [3] * 6
    # Relays that stand still do not come to be equal, and mend nothing.
    assert table["gap_db"][1] > table["gap_db"][2]
    assert table["c_repair"][0] is None and table["c_repair"][4] < table["c_repair"][5]
    # These begin in the air with the rule of their own policy, so the copy is near, and not the same.
    assert table["c3"][0] == table["c3"][2]


def test_a_single_name_is_no_list_of_letters():
    table = uchain.compare(lambda *_: 0.0, against="k-tuned", scenarios="s-turns-5", runs=1)
    assert table["policy"] == ["python", "k-tuned"] and table["scenario"] == ["s-turns-5"] * 2


def test_a_policy_is_compared_in_drawn_places():
    table = uchain.compare(lambda *_: 0.0, against=["chain"], drawn=True, runs=4).to_dict()
    assert table["policy"] == ["python", "chain"] and table["missions"] == [4, 4]
    for name in ("good", "deep_in_time", "touched"):
        for n in range(2):
            assert table[f"{name}_low"][n] <= table[name][n] <= table[f"{name}_high"][n]


def test_wrong_comparisons_are_one_line(tmp_path):
    for text, arguments, keys in [
        ("did you mean k-tuned", (lambda *_: 0.0, ["k-tund"]), {}),
        ("no scenario", (lambda *_: 0.0,), {"scenarios": ["nowhere"]}),
        ("runs=0", (lambda *_: 0.0,), {"runs": 0}),
        ("another name", ({"chain": lambda *_: 0.0},), {}),
        ("against=", ({"mine": "chain"},), {}),
        ("timeout_s", (lambda *_: 0.0,), {"timeout_s": -1.0}),
        ("leave scenarios=", (lambda *_: 0.0,), {"drawn": True, "scenarios": ["demo"]}),
    ]:
        with pytest.raises(ValueError) as error:
            uchain.compare(*arguments, **keys)
        assert "\n" not in str(error.value) and text in str(error.value)
    for keys in ({"out": tmp_path / "out"}, {"on": "ray", "out": tmp_path / "out"}):
        with pytest.raises(ValueError, match="threads only"):
            uchain.campaign("straight", 1, policy=lambda *_: 0.0, **keys)


def test_the_policy_is_varied_by_one_of_its_names():
    with pytest.raises(ValueError, match="give one of them"):
        uchain.campaign("straight", 1, vary={"policy": ["t5"], "policy.name": ["chain"]})


def busy(seconds):
    """Spend so much time of this thread's processor in Python."""
    until = time.thread_time() + seconds
    while time.thread_time() < until:
        pass


def test_waits_for_other_missions_calls_are_not_a_call_s_own_time():
    """Of eight missions that call at once each call waits for seven others, longer than its limit."""
    waited = []

    class Slow:
        """Its first call takes a while."""

        def __init__(self):
            self.takes_s = 0.2

        def __call__(self, *_):
            began = time.perf_counter()
            busy(self.takes_s)
            self.takes_s = 0.0
            waited.append(time.perf_counter() - began)
            return 0.0

    uchain.campaign("relay-pair", 8, policy=Slow, threads=8, duration_s=4, timeout_s=1.0)
    assert max(waited) > 1.1


def test_a_call_that_goes_on_after_its_interruption_is_interrupted_again():
    told = []

    def policy(*_):
        while len(told) < 2:
            try:
                while True:
                    pass
            except TimeoutError as error:
                told.append(error)
        return 0.0

    with pytest.raises(TimeoutError, match="took longer than 0.1 s"):
        uchain.run("relay-pair", policy=policy, timeout_s=0.1)
    assert len(told) == 2


def test_a_call_within_its_limit_is_not_interrupted_by_the_one_before():
    """Calls that end just at their limit leave no error behind."""
    for _ in range(20):
        with pytest.raises(TimeoutError, match="took longer than 0.02 s"):
            uchain.run("relay-pair", policy=lambda *_: busy(0.1) or 0.0, timeout_s=0.02)
        busy(0.01)
