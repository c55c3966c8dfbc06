"""Campaigns into a folder: by the command on this machine, or in parts on a cluster of Ray."""

from __future__ import annotations

import hashlib as _hashlib
import json as _json
import os as _os
import shutil as _shutil
import subprocess as _subprocess
import sys as _sys
import tempfile as _tempfile
from pathlib import Path as _Path
from typing import Any, Callable, Dict, List, Optional

from ._uchain import __version__, read_runs as _read_runs
from .progress import Bar as _Bar

__all__ = ["read"]

#: How often the part of a worker that died is flown again.
RETRIES = 5

#: The time between two looks whether a wait was interrupted, in seconds.
NAP_S = 0.2


def read(folder: Any) -> Any:
    """The runs of a campaign that ``uchain campaign --out`` or :func:`uchain.campaign` has written."""
    return _read_runs(_os.fspath(folder))


def here(
    options: List[str], out: _Path, threads: Optional[int], missions: int, bar: _Bar
) -> Any:
    """Fly a campaign on this machine's threads into a folder; return its runs.

    A campaign that was stopped goes on from its rows beside the folder.
    """
    rows = _Rows(out.with_name(out.name + ".rows"))
    with _scenario_file(options) as options, bar:

        def look() -> None:
            if flown := rows.count():
                bar(flown, missions)

        _fly([*options, "--out", str(out), "--resume"], threads, look)
    return read(out)


def on_ray(options: List[str], out: _Path, parts: int, bar: _Bar) -> Any:
    """Fly a campaign in parts as tasks of Ray into a folder; return its runs.

    Each part is put beside the folder as it comes, so that a campaign that was stopped goes on.
    """
    import ray

    if not ray.is_initialized():
        ray.init(log_to_driver=False)
    parts_folder = out.with_name(out.name + ".parts")
    with _only_writer(parts_folder), bar:
        _begin(parts_folder, options, parts)
        missing = [n for n in range(1, parts + 1) if not (parts_folder / str(n)).exists()]
        fly = ray.remote(num_cpus=1, max_retries=RETRIES)(_part)
        waiting = {fly.remote(options, n, parts): n for n in missing}
        try:
            while waiting:
                bar(parts - len(waiting), parts)
                [done], _ = ray.wait(list(waiting), num_returns=1)
                number = waiting.pop(done)
                _keep(parts_folder / str(number), _files_of(ray, done, number, parts))
        except BaseException:
            for task in waiting:
                ray.cancel(task)
            raise
        folders = [str(parts_folder / str(n)) for n in range(1, parts + 1)]
        _command(["campaign", "--quiet", "--merge", *folders, "--out", str(out)])
        _shutil.rmtree(parts_folder)
    return read(out)


def _files_of(ray: Any, done: Any, number: int, parts: int) -> Dict[str, bytes]:
    try:
        files = ray.get(done)
    except ray.exceptions.RayTaskError as error:
        raise error.as_instanceof_cause() from None
    except ray.exceptions.RayError as error:
        kind = type(error).__name__
        raise RuntimeError(
            f"part {number}/{parts} was lost with its worker ({kind}) more than {RETRIES} times; call "
            "campaign again, which goes on from the parts that are there"
        ) from None
    if isinstance(files, str):
        raise ValueError(files)
    return files


def _part(options: List[str], number: int, parts: int) -> Any:
    """Fly one part, in a task; return its files by name, or what is wrong with the input."""
    with _tempfile.TemporaryDirectory() as folder, _scenario_file(options) as own:
        out = _Path(folder) / "part"
        try:
            _fly([*own, "--out", str(out), "--shard", f"{number}/{parts}"], 1)
        except ValueError as error:
            return str(error)
        return {path.name: path.read_bytes() for path in sorted(out.iterdir())}


class _Rows:
    """The rows of a campaign under way, which are lines of a file beside its folder."""

    def __init__(self, path: _Path) -> None:
        self.path = path
        self.read = 0
        self.lines = 0

    def count(self) -> int:
        """The number of missions that have a row."""
        try:
            with open(self.path, "rb") as file:
                file.seek(self.read)
                while piece := file.read(1 << 20):
                    self.read += len(piece)
                    self.lines += piece.count(b"\n")
        except OSError:  # It is not there yet, or not any more.
            pass
        # The first line names the campaign.
        return max(self.lines - 1, 0)


def _fly(
    arguments: List[str], threads: Optional[int], look: Callable[[], None] = lambda: None
) -> None:
    environment = dict(_os.environ)
    if threads is not None:
        environment["RAYON_NUM_THREADS"] = str(threads)
    _command([*arguments, "--quiet"], environment, look)


def _command(
    arguments: List[str],
    environment: Optional[Dict[str, str]] = None,
    look: Callable[[], None] = lambda: None,
) -> None:
    """Carry out a command line in a process of its own, and look now and then how far it is.

    Missions that failed are no error.
    """
    with _tempfile.TemporaryFile("w+", encoding="utf-8", errors="replace") as told:
        with _subprocess.Popen(
            [_sys.executable, "-m", "uchain._child", *arguments],
            env=environment,
            stdin=_subprocess.PIPE,
            stdout=_subprocess.DEVNULL,
            stderr=told,
            # In the session of the terminal it would get each Ctrl-C twice: from there, and from here.
            start_new_session=True,
        ) as process:
            status = _status(process, look)
        told.seek(0)
        lines = told.read().strip().splitlines() or [""]
    if status == 130:
        raise KeyboardInterrupt
    if status == 2:
        raise ValueError(lines[-1].removeprefix("uchain: "))
    if status not in (0, 1):
        raise RuntimeError(f"uchain ended with status {status}: {lines[-1]}")


def _status(process: _subprocess.Popen, look: Callable[[], None]) -> int:
    """Wait for a command; return its exit status. Ctrl-C is passed on to it.

    The missions of a campaign that have begun end after the first Ctrl-C; a second one drops them.
    """
    interrupted = False
    while True:
        try:
            # A wait without a limit does not notice an interrupt by ray.cancel, which is no signal.
            status = process.wait(NAP_S)
            break
        except _subprocess.TimeoutExpired:
            look()
        except KeyboardInterrupt:
            interrupted = True
            # On Windows the command has the terminal's Ctrl-C.
            if _os.name == "posix":
                process.terminate()
    if interrupted:
        raise KeyboardInterrupt
    return status


class _scenario_file:
    """The options with the path of a file where the scenario is a text."""

    def __init__(self, options: List[str]) -> None:
        self.options = options
        self.folder: Optional[_tempfile.TemporaryDirectory] = None

    def __enter__(self) -> List[str]:
        text = self.options[1]
        if "\n" not in text:
            return self.options
        self.folder = _tempfile.TemporaryDirectory()
        path = _Path(self.folder.name) / "scenario.toml"
        path.write_text(text, encoding="utf-8")
        return [self.options[0], str(path), *self.options[2:]]

    def __exit__(self, *_: Any) -> None:
        if self.folder is not None:
            self.folder.cleanup()


class _only_writer:
    """Holds the folder of the parts, which no other process may write into meanwhile."""

    def __init__(self, folder: _Path) -> None:
        self.folder = folder

    def __enter__(self) -> None:
        try:
            self.folder.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            raise _unwritable(self.folder, error) from None
        self.lock = open(self.folder / "lock", "w")
        try:
            import fcntl

            fcntl.flock(self.lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except ImportError:  # Windows has no such locks.
            pass
        except OSError:
            self.lock.close()
            raise ValueError(
                f"{self.folder}: another process is writing this campaign; give another folder, or "
                "wait for it"
            ) from None

    def __exit__(self, *_: Any) -> None:
        self.lock.close()


def _begin(folder: _Path, options: List[str], parts: int) -> None:
    """Make sure that the parts that are there are of this campaign."""
    told = {"version": __version__, "parts": parts, "campaign": _digest(options)}
    title = folder / "campaign.json"
    if not title.exists():
        return _keep_file(title, _json.dumps(told).encode())
    try:
        known = _json.loads(title.read_text(encoding="utf-8"))
    except ValueError:
        raise ValueError(f"{title}: this file is damaged; remove {folder}") from None
    if known != told:
        raise ValueError(
            f"{folder}: these are the parts of another campaign; give its options and number of "
            "parts, or remove the folder"
        )


def _digest(options: List[str]) -> str:
    digest = _hashlib.sha256("\0".join(options).encode())
    # A built-in scenario has its name there, another one its text or its whole path.
    if _os.path.isabs(options[1]) and _os.path.isfile(options[1]):
        digest.update(_Path(options[1]).read_bytes())
    return digest.hexdigest()


def _keep(folder: _Path, files: Dict[str, bytes]) -> None:
    """Put the files of a part where they belong, whole or not at all."""
    staging = folder.with_name(f".{folder.name}.part")
    try:
        _shutil.rmtree(staging, ignore_errors=True)
        staging.mkdir()
        for name, content in files.items():
            (staging / name).write_bytes(content)
        staging.rename(folder)
    except OSError as error:
        _shutil.rmtree(staging, ignore_errors=True)
        raise _unwritable(folder, error) from None


def _keep_file(path: _Path, content: bytes) -> None:
    """Put a file where it belongs, whole or not at all."""
    staging = path.with_name(f".{path.name}.part")
    try:
        staging.write_bytes(content)
        staging.replace(path)
    except OSError as error:
        staging.unlink(missing_ok=True)
        raise _unwritable(path, error) from None


def _unwritable(path: _Path, error: OSError) -> ValueError:
    return ValueError(
        f"{path}: cannot be written: {error.strerror}; make room on the disk, or give another folder; "
        "a second call goes on from here"
    )
