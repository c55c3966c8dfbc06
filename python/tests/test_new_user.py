"""What a new user meets: tables and progress as they look, and wrong input as it is told."""

import io
import math
import signal
import subprocess
import sys
import threading
import time

import pytest

import uchain
from uchain.progress import Bar


def flat(distance_m, walls):
    return 40.0 + 20.0 * math.log10(distance_m) + 9.0 * walls


def test_a_law_replaces_the_one_that_the_file_names():
    law = uchain.RadioLaw(flat)
    assert uchain.run("s-turns-5", 1, radio_law=law, duration_s=5).summary["seed"] == 1
    models = {"radio.model": [law.model, {"law": "subt"}]}
    assert len(uchain.campaign("s-turns-5", 1, models, duration_s=5)) == 2
    with pytest.raises(ValueError, match="belong to the paper's law"):
        uchain.run("s-turns-5", radio={"walls": "leaky"}, radio_law=law)


def test_a_policy_is_called_in_a_scenario_of_the_chain_wide_policy():
    """The demonstration flies `chain`, which launches by sums that a callable does not get."""
    own = uchain.run("demo", 3, policy=uchain.Policy("k-tuned"))
    assert own.metrics == uchain.run("demo", 3, policy="k-tuned").metrics
    assert own.metrics["launched"] == 3


def test_a_table_shows_its_first_rows_and_has_them_one_by_one(short):
    table = uchain.campaign(short, 12, duration_s=5)
    rows = list(table)
    assert len(rows) == 12 and rows[3]["seed"] == 4 and list(rows[0]) == table.column_names
    assert list(table.head(3)) == rows[:3] and len(table.head()) == 5
    assert table.head(20).to_dict() == table.to_dict() and len(table.head(0)) == 0
    assert "explored" in table.empty_columns and "seed" not in table.empty_columns
    page = table._repr_html_()
    assert page.count("<tr>") == 11 and "<th>farthest_m</th>" in page and "<th>explored</th>" not in page
    assert "12 rows, 71 columns, of which" in page


def test_pandas_reads_rows(short):
    pandas = pytest.importorskip("pandas")
    table = uchain.campaign(short, 3, duration_s=5)
    assert list(pandas.DataFrame(table)["seed"]) == [1, 2, 3]


def test_progress_is_told_after_a_second(monkeypatch, capsys):
    stream = io.StringIO()
    monkeypatch.setattr(sys, "stderr", stream)
    with Bar(True) as bar:
        bar(1, 100)
        assert stream.getvalue() == ""
        bar.began -= 10.0
        bar(51, 100)
        assert stream.getvalue() == "\r51 of 100 missions, 51 %, 10 s left"
        bar(100, 100)
    assert stream.getvalue().split("\r")[2].rstrip() == "100 of 100 missions, 100 %, 10 s"
    # On what is no terminal nothing is shown by itself.
    with Bar(None) as bar:
        assert not bar.shown


@pytest.mark.parametrize("keys", [{}, {"out": "folder"}])
def test_a_campaign_says_how_far_it_is(tmp_path, capfd, keys):
    keys = {name: tmp_path / value for name, value in keys.items()}
    uchain.campaign("straight", 120, threads=1, progress=True, **keys)
    assert " of 120 missions, " in capfd.readouterr().err
    uchain.campaign("straight", 2, duration_s=120, progress=True)
    uchain.campaign("straight", 80, threads=1)
    assert capfd.readouterr().err == ""


def test_a_comparison_says_how_far_it_is(capfd):
    uchain.compare(
        lambda *_: 0.0, "k-tuned", scenarios="spiral", runs=10, threads=1, progress=True
    )
    assert " of 20 missions, " in capfd.readouterr().err


class Unmade:
    def __init__(self):
        raise RuntimeError("no such weights")

    def __call__(self, *_):
        return 0.0


async def later(*_):
    return 0.0


@pytest.mark.parametrize(
    "text, call",
    [
        ("seed=-1 is out of range", lambda: uchain.run(seed=-1)),
        ("seed=1.5 is no whole number", lambda: uchain.run(seed=1.5)),
        ("seed=-1 is out of range", lambda: uchain.Simulation(seed=-1)),
        ("seeds=0 is out of range", lambda: uchain.campaign("straight", 0)),
        ("seeds=-1 is out of range", lambda: uchain.campaign("straight", -1)),
        ("seeds=1.5 is no whole number", lambda: uchain.campaign("straight", 1.5)),
        ("seeds='3' is no whole number", lambda: uchain.campaign("straight", "3")),
        ("there is none in this list", lambda: uchain.campaign("straight", [])),
        ("out of range", lambda: uchain.run(duration_s=10**30)),
        ("the name of a key is a string", lambda: uchain.run(radio={"packet_loss": {1: 2}})),
        (
            "radio.packet_loss: this key is varied and given",
            lambda: uchain.campaign(
                "straight", 1, {"radio.packet_loss": [0.2]}, radio={"packet_loss": 0.1}
            ),
        ),
        (
            "radio.model: this key is varied and given",
            lambda: uchain.campaign(
                "straight", 1, {"radio.model": [{"law": "subt"}]}, radio_law=uchain.RadioLaw(flat)
            ),
        ),
        (
            "give a callable as policy=",
            lambda: uchain.campaign("straight", 1, {"policy": [lambda *_: 0.0]}),
        ),
        ('"swarm" follow no movement policy', lambda: uchain.run("swarm-b", policy=lambda *_: 0.0)),
        (
            '"explore" follow no movement policy',
            lambda: uchain.campaign("explore-room", 1, policy=lambda *_: 0.0),
        ),
        ("the policy returned None for drone 1", lambda: uchain.run(policy=lambda *_: None)),
        (
            "the policy returned a value of the type coroutine",
            lambda: uchain.run("straight", policy=later),
        ),
        ("the type int is none of one", lambda: uchain.run(policy=3)),
        ("compare takes a callable", lambda: uchain.compare("chain", runs=1)),
        ("compare takes a callable", lambda: uchain.compare(None)),
        ("the name of a policy is a string", lambda: uchain.compare({1: later})),
        ("against takes a name", lambda: uchain.compare(later, against=3)),
        ("runs='3' is no whole number", lambda: uchain.compare(later, runs="3")),
        ("no such weights", lambda: uchain.Simulation(policy=Unmade)),
        ("has 1 distances; give 2 to", lambda: uchain.RadioLaw(flat, distances_m=[1])),
        ("give 0.01 to 10,000 m", lambda: uchain.RadioLaw(flat, distances_m=[-1, 1])),
    ],
)
@pytest.mark.filterwarnings("ignore:coroutine")
def test_what_is_wrong_is_one_line(text, call):
    with pytest.raises((ValueError, TypeError, RuntimeError)) as error:
        call()
    assert text in str(error.value) and "\n" not in str(error.value)


def test_arrays_of_numpy_are_lists(short):
    numpy = pytest.importorskip("numpy")
    line = numpy.array([[0.0, 0.0], [12.0, 0.0]])
    own = uchain.run(short, tunnel={"centre_line_m": line}, duration_s=5)
    assert own.metrics == uchain.run(short, duration_s=5).metrics


@pytest.mark.skipif(not hasattr(signal, "SIGURG"), reason="this system has no such signal")
@pytest.mark.parametrize("of_ctrl_c", [signal.default_int_handler, signal.SIG_IGN])
def test_a_wait_outside_of_python_is_woken_in_the_main_thread(of_ctrl_c):
    """Calls that wait for a held lock or sleep for long end in an error, in the background, too."""
    lock = threading.Lock()
    lock.acquire()
    before = signal.getsignal(signal.SIGURG)
    ctrl_c = signal.signal(signal.SIGINT, of_ctrl_c)
    waits = [lambda *_: lock.acquire() or 0.0, lambda *_: time.sleep(60.0) or 0.0]
    try:
        for wait in waits:
            began = time.monotonic()
            simulation = uchain.Simulation("relay-pair", policy=wait, timeout_s=0.2)
            for fly in (
                lambda: uchain.run("relay-pair", policy=wait, timeout_s=0.2),
                lambda: simulation.step(1_000),
                lambda: uchain.RadioLaw(wait, timeout_s=0.2),
            ):
                with pytest.raises(TimeoutError, match="took longer than 0.2 s for"):
                    fly()
                # Nothing of it is left over.
                time.sleep(0.01)
                assert signal.getsignal(signal.SIGURG) is before
            assert time.monotonic() - began < 30.0
    finally:
        signal.signal(signal.SIGINT, ctrl_c)


HANGS = """
import threading, time, uchain
lock = threading.Lock()
lock.acquire()
began = time.monotonic()
for wait in (lambda *_: lock.acquire() or 0.0, lambda *_: time.sleep(600.0) or 0.0):
    for fly in (
        lambda: uchain.campaign("relay-pair", 20, policy=wait, threads=2, timeout_s=0.2),
        lambda: uchain.compare(wait, scenarios="s-turns-5", runs=20, threads=2, timeout_s=0.2),
    ):
        try:
            fly()
        except TimeoutError as error:
            assert "waits for something outside of Python" in str(error), error
        else:
            raise AssertionError("it ended")
assert time.monotonic() - began < 60.0
# Other missions fly on.
assert len(uchain.campaign("relay-pair", 2, policy=lambda *_: 0.0, duration_s=4)) == 2
print("on it goes")
"""


def test_a_wait_outside_of_python_does_not_hang_a_campaign():
    """In a process of its own, which such waits do not keep from its end."""
    done = subprocess.run(
        [sys.executable, "-c", HANGS], capture_output=True, text=True, timeout=120, check=False
    )
    assert (done.returncode, done.stdout, done.stderr) == (0, "on it goes\n", "")
