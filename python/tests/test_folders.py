"""Campaigns into folders: the tables that others read, and what cannot be written."""

import errno
import json
import math
import os
import signal
import subprocess
import sys
import threading
import time
from pathlib import Path

import pytest

import uchain
from uchain import cluster

VARY = {"radio.packet_loss": [0.0, 0.5], "policy.name": ["t5", "k-tuned"], "drones.relays": [1, 2]}


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """A campaign in a folder."""
    from conftest import SHORT

    out = tmp_path_factory.mktemp("campaign") / "out"
    uchain.campaign(SHORT, 3, VARY, out=out, duration_s=15)
    return out


def test_a_folder_holds_the_table(folder, short):
    table = uchain.campaign(short, 3, VARY, duration_s=15)
    assert len(table) == 24
    assert repr(uchain.read(folder).to_dict()) == repr(table.to_dict())


def expected(folder, name):
    return uchain.read(folder)[name]


def test_pandas_reads_the_runs(folder):
    pandas = pytest.importorskip("pandas")
    pytest.importorskip("pyarrow")
    table = pandas.read_parquet(folder / "runs.parquet")
    assert list(table.columns) == uchain.read(folder).column_names
    for name in ("seed", "success", "policy.name", "farthest_m"):
        assert table[name].tolist() == expected(folder, name)
    assert table["no_hold"].isna().tolist() == [it is None for it in expected(folder, "no_hold")]


def test_polars_reads_the_runs(folder):
    polars = pytest.importorskip("polars")
    table = polars.read_parquet(folder / "runs.parquet")
    assert table.columns == uchain.read(folder).column_names
    for name in table.columns:
        assert table[name].to_list() == expected(folder, name), name
    assert table["seed"].dtype == polars.UInt64 and table["farthest_m"].dtype == polars.Float32


def test_duckdb_reads_the_runs(folder):
    duckdb = pytest.importorskip("duckdb")
    query = (
        'SELECT "policy.name", count(*), sum(seed) FROM read_parquet(?) GROUP BY ALL ORDER BY ALL'
    )
    rows = duckdb.execute(query, [str(folder / "runs.parquet")]).fetchall()
    assert rows == [("k-tuned", 12, 24), ("t5", 12, 24)]


def test_the_summary_is_that_of_the_rows(tmp_path, short):
    """Means with their intervals, and a median by rank, reckoned anew from all rows."""
    out = tmp_path / "out"
    uchain.campaign(short, 300, out=out, duration_s=10)
    metrics = json.loads((out / "summary.json").read_text())["metrics"]
    rows = uchain.read(out)
    count = len(rows)
    for name in ("farthest_m", "peak_excess_db", "cruise_gap_db"):
        values = rows[name]
        mean = math.fsum(values) / count
        squares = math.fsum((value - mean) ** 2 for value in values)
        half = 1.96 * math.sqrt(squares / (count - 1) / count)
        told = [metrics[name][key] for key in ("value", "low", "high")]
        assert told == pytest.approx([mean, mean - half, mean + half], rel=1e-12), name
    times = sorted(rows["t_farthest_s"])
    assert metrics["t_farthest_median_s"]["value"] == times[round((count - 1) * 0.5)]


def test_the_command_comes_along(folder):
    def run(*arguments):
        return subprocess.run(
            [sys.executable, "-m", "uchain", *arguments], capture_output=True, text=True
        )

    assert run("--version").stdout.startswith("uchain ")
    wrong = run("run", "no-such-scenario")
    assert wrong.returncode == 2 and wrong.stderr.count("\n") == 1
    shown = run("campaign", "relay-pair", "--runs", "2", "--set", "duration_s=5", "--json")
    assert shown.returncode in (0, 1) and shown.stdout.startswith("{")


def test_what_is_no_campaign_is_one_line(folder, tmp_path, short):
    for path in (tmp_path, tmp_path / "nowhere"):
        with pytest.raises(ValueError) as error:
            uchain.read(path)
        assert "\n" not in str(error.value) and str(path) in str(error.value)
    with pytest.raises(ValueError, match="did you mean packet_loss"):
        uchain.campaign(short, 1, {"radio.packet_los": [0.1]}, out=tmp_path / "wrong")
    with pytest.raises(ValueError, match="consecutive"):
        uchain.campaign(short, [1, 3], out=tmp_path / "wrong")
    with pytest.raises(ValueError, match='"threads" or "ray"'):
        uchain.campaign(short, 1, on="cloud", out=tmp_path / "wrong")
    with pytest.raises(ValueError, match="out="):
        uchain.campaign(short, 1, on="ray")
    with pytest.raises(ValueError, match="threads= counts on this machine"):
        uchain.campaign(short, 1, on="ray", threads=2, out=tmp_path / "wrong")
    with pytest.raises(ValueError, match="parts= counts on a cluster"):
        uchain.campaign(short, 1, parts=2, out=tmp_path / "wrong")
    assert not (tmp_path / "wrong").exists()


def test_a_folder_has_one_writer(tmp_path, short):
    parts = tmp_path / "out.parts"
    pytest.importorskip("fcntl")
    with cluster._only_writer(parts):
        with pytest.raises(ValueError, match="another process is writing"):
            with cluster._only_writer(parts):
                pass
    with cluster._only_writer(parts):
        pass


def test_the_parts_of_another_campaign_are_refused(tmp_path, short):
    options = uchain._words(short, [1, 2], None, {})
    cluster._begin(tmp_path, options, 2)
    cluster._begin(tmp_path, options, 2)
    for other, parts in ((options, 3), (uchain._words(short, [1, 2, 3], None, {}), 2)):
        with pytest.raises(ValueError, match="another campaign"):
            cluster._begin(tmp_path, other, parts)
    title = tmp_path / "campaign.json"
    title.write_bytes(title.read_bytes()[:9])
    with pytest.raises(ValueError, match=r"campaign\.json: this file is damaged; remove"):
        cluster._begin(tmp_path, options, 2)


def test_a_built_in_scenario_comes_before_a_path_of_its_name(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "straight").mkdir()
    options = uchain._words("straight", [1], None, {})
    assert options[1] == "straight"
    cluster._begin(tmp_path, options, 1)
    (tmp_path / "own.toml").write_text("title = 'own'\n")
    assert uchain._words("own.toml", [1], None, {})[1] == str(tmp_path / "own.toml")


PARENT = """
import signal
import sys
import uchain
# A process that a shell has put into the background ignores the signal, and so would Python.
signal.signal(signal.SIGINT, signal.default_int_handler)
try:
    uchain.campaign(sys.argv[1], 20_000, out=sys.argv[2], threads=2)
except KeyboardInterrupt:
    sys.exit(5)
"""


def until(is_so):
    for _ in range(6000):
        if is_so():
            return
        time.sleep(0.02)
    pytest.fail("it has not come to that in two minutes")


@pytest.mark.skipif(os.name != "posix", reason="signals")
@pytest.mark.parametrize("end", [signal.SIGINT, signal.SIGKILL])
def test_a_campaign_that_is_stopped_keeps_its_missions_and_goes_on(tmp_path, short, end):
    """By Ctrl-C, or because the process is killed that has called it."""
    out, rows = tmp_path / "out", tmp_path / "out.rows"
    parent = subprocess.Popen(
        [sys.executable, "-c", PARENT, short, str(out)],
        env={**os.environ, "TMPDIR": str(tmp_path)},
        start_new_session=True,
    )
    until(lambda: rows.exists() and rows.read_bytes().count(b"\n") > 2)
    os.killpg(parent.pid, end)
    assert parent.wait() == (5 if end == signal.SIGINT else -signal.SIGKILL)
    until(out.exists)
    flown = uchain.read(out)["seed"]
    assert 2 <= len(flown) < 20_000 and flown == sorted(flown)
    until(lambda: not (tmp_path / ".out.uchain-lock").exists())
    with pytest.raises(ValueError, match="rows of another campaign"):
        uchain.campaign(short, 3, out=out)
    assert rows.exists()



def test_a_full_disk_is_one_line_and_leaves_no_half_part(tmp_path, monkeypatch):
    def full(self, content):
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    monkeypatch.setattr(Path, "write_bytes", full)
    with pytest.raises(ValueError, match="No space left on device; make room"):
        cluster._keep(tmp_path / "1", {"runs.csv": b"rows"})
    assert list(tmp_path.iterdir()) == []


@pytest.mark.skipif(sys.platform != "linux", reason="mounts a small disk")
def test_a_disk_that_is_full_ends_a_campaign_in_one_line(tmp_path, short):
    disk = tmp_path / "disk"
    disk.mkdir()
    size = ["mount", "-t", "tmpfs", "-o", "size=32k", "none", str(disk)]
    if subprocess.run(size, capture_output=True).returncode != 0:
        pytest.skip("needs the right to mount")
    try:
        with pytest.raises(ValueError) as error:
            uchain.campaign(short, 100, out=disk / "out", duration_s=2)
        assert "No space left" in str(error.value) and "\n" not in str(error.value)
        assert not (disk / "out").exists()
    finally:
        subprocess.run(["umount", "--lazy", str(disk)], check=True)


def test_two_campaigns_into_one_folder(tmp_path, short):
    """One of two that begin at once is refused, or comes after the other; the results are whole."""
    errors = []

    def fly():
        try:
            uchain.campaign(short, 4, out=tmp_path / "out", duration_s=10)
        except ValueError as error:
            errors.append(str(error))

    threads = [threading.Thread(target=fly) for _ in range(2)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert len(errors) <= 1 and all("\n" not in error for error in errors)
    assert len(uchain.read(tmp_path / "out")) == 4
