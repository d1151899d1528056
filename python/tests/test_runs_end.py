"""A run ends when it is told to, keeps what it has, and leaves Python to others meanwhile."""

from __future__ import annotations

import multiprocessing
import os
import signal
import subprocess
import sys
import threading
import time
from pathlib import Path

import numpy as np
import pytest

import sagnac

# More than a machine samples while a test waits.
ENDLESS = 1 << 31


@pytest.mark.usefixtures("interrupted")
def test_ctrl_c_ends_a_run_and_what_was_sampled_is_kept(studies: Path, tmp_path: Path) -> None:
    study, out = studies / "smoke.toml", tmp_path / "out"
    timer = threading.Timer(2.0, os.kill, (os.getpid(), signal.SIGINT))
    started = time.monotonic()
    timer.start()
    with pytest.raises(KeyboardInterrupt):
        sagnac.run(study, trials=ENDLESS, device="cpu", out=out)
    took = time.monotonic() - started
    assert took < 20.0, f"{took} s"
    assert (out / "resolved_study.toml").is_file() and not (out / "points.csv").exists()
    # The trials of the interrupted run are the first ones of this.
    again = sagnac.run(study, trials=1000, device="cpu", out=out)
    fresh = sagnac.run(study, trials=1000, device="cpu")
    assert again.sampled_trials is not None and fresh.sampled_trials is not None
    assert again.sampled_trials < fresh.sampled_trials


def test_a_function_hears_of_progress_and_ends_the_run_by_raising(studies: Path) -> None:
    heard: list[tuple[int, int, str]] = []
    found = sagnac.run(
        studies / "smoke.toml", trials=20_000, device="cpu", progress=lambda *told: heard.append(told)
    )
    # First the trials, then the evaluations that the decision sheet needs, of which more turn out as they are made.
    trials = [told for told in heard if told[2] == "trials"]
    sheet = heard[len(trials) :]
    assert trials and trials[-1][0] == trials[-1][1] == found.sampled_trials
    assert sheet and sheet[-1][0] == sheet[-1][1] and all(told[2] == "evaluations" for told in sheet)
    for told in (trials, sheet):
        assert all(before[0] <= after[0] for before, after in zip(told, told[1:]))

    def enough(done: int, total: int, unit: str) -> None:
        if done > 0:
            raise LookupError("enough")

    with pytest.raises(LookupError, match="enough"):
        sagnac.run(studies / "smoke.toml", trials=ENDLESS, device="cpu", progress=enough)


def test_other_threads_go_on_while_one_computes(studies: Path) -> None:
    done = threading.Event()

    def work() -> None:
        sagnac.run(studies / "smoke.toml", trials=3_000_000, device="cpu", threads=1)
        done.set()

    thread = threading.Thread(target=work)
    thread.start()
    turns, longest, last = 0, 0.0, time.monotonic()
    while not done.wait(0.001):
        now = time.monotonic()
        turns, longest, last = turns + 1, max(longest, now - last), now
    thread.join()
    # If the lock were held this thread would have had no turn until the end.
    assert turns > 20 and longest < 2.0, f"{turns} turns, {longest} s"


def test_several_threads_and_any_number_of_them_give_the_same(studies: Path) -> None:
    data = np.random.default_rng(1).normal(0.0, 1.0, 50_000)
    expected = sagnac.allan(data, 100.0, unit="deg/h", threads=1)["oadev"].value
    found: list[bool] = []

    def work(threads: int) -> None:
        for _ in range(5):
            value = sagnac.allan(data, 100.0, unit="deg/h", threads=threads)["oadev"].value
            found.append(np.array_equal(value, expected))

    threads = [threading.Thread(target=work, args=(count,)) for count in [1, 2, 3, 8]]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert found == [True] * 20


def deviation(seed: int) -> float:
    data = np.random.default_rng(seed).normal(0.0, 1.0, 5000)
    return float(sagnac.allan(data, 100.0, unit="deg/h")["oadev"].value[0])


@pytest.mark.skipif(not hasattr(os, "fork"), reason="needs fork")
@pytest.mark.filterwarnings("ignore:.*fork.*:DeprecationWarning")
def test_a_process_that_is_forked_computes_too() -> None:
    expected = [deviation(seed) for seed in range(4)]
    with multiprocessing.get_context("fork").Pool(2) as pool:
        assert pool.map_async(deviation, range(4)).get(timeout=60.0) == expected


@pytest.mark.skipif(sys.platform != "linux", reason="reads /proc")
def test_a_large_array_is_not_copied_beside_the_angles_that_are_made_of_it(tmp_path: Path) -> None:
    samples = 20_000_000
    script = tmp_path / "large.py"
    script.write_text(
        f"""
import numpy, sagnac
def peak():
    return next(int(line.split()[1]) for line in open("/proc/self/status") if line.startswith("VmHWM"))
data = numpy.random.default_rng(1).normal(0.0, 1.0, {samples})
sagnac.allan(data[:100_000], 100.0, unit="deg/h")
before = peak()
sagnac.allan(data, 100.0, unit="deg/h", taus=[0.01, 1.0, 100.0])
print((peak() - before) * 1024 / data.nbytes)
""",
        encoding="utf-8",
    )
    done = subprocess.run([sys.executable, script], capture_output=True, text=True, check=True)
    # The angles are one copy; two would be another of the data.
    assert 0.9 < float(done.stdout) < 1.5, done.stdout
