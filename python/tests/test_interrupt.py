"""Long work leaves Python free, and ends on Ctrl-C."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import threading
import time

import host_sim
import pytest
from conftest import CASE, TRAIN

MACHINE = CASE / "machine.toml"

SEARCH = f"""
import host_sim, sys
print("begins", flush=True)
try:
    host_sim.diagnose({str(CASE)!r}, threads=2)
except KeyboardInterrupt:
    # The module works on.
    assert len(host_sim.inspect({str(TRAIN[0])!r}).recordings) == 1
    sys.exit(17)
print("ended by itself")
"""


@pytest.mark.skipif(sys.platform == "win32", reason="a process is sent no Ctrl-C there")
def test_ctrl_c_ends_a_search():
    running = subprocess.Popen([sys.executable, "-c", SEARCH], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    assert running.stdout is not None
    assert running.stdout.readline() == "begins\n"
    time.sleep(0.3) # well within the search, which takes a second or two
    asked = time.monotonic()
    running.send_signal(signal.SIGINT)
    out, err = running.communicate(timeout=60)
    assert running.returncode == 17, out + err
    assert "panicked" not in err
    print(f"ended {time.monotonic() - asked:.2f} s after Ctrl-C")
    assert time.monotonic() - asked < 10


def test_a_handler_of_the_user_s_own_ends_it_too():
    class Stop(Exception):
        pass

    def stop(*_):
        raise Stop

    before = signal.signal(signal.SIGINT, stop)
    try:
        threading.Timer(0.5, os.kill, (os.getpid(), signal.SIGINT)).start()
        with pytest.raises(Stop):
            host_sim.diagnose(CASE)
    finally:
        signal.signal(signal.SIGINT, before)


def test_python_runs_on_meanwhile():
    counted, done = 0, threading.Event()

    def count():
        nonlocal counted
        while not done.wait(0.01):
            counted += 1

    counting = threading.Thread(target=count)
    counting.start()
    began = time.monotonic()
    host_sim.fit(MACHINE, TRAIN, threads=1)
    took = time.monotonic() - began
    done.set()
    counting.join()
    # A tenth of what an idle machine counts: with the lock held it would be none.
    assert counted >= took / 0.01 / 10, (counted, took)


def test_two_threads_of_python_compute_at_once():
    results: list[dict] = []
    work = [threading.Thread(target=lambda: results.append(host_sim.compare(MACHINE, TRAIN[0]).to_dict())) for _ in range(2)]
    for one in work:
        one.start()
    for one in work:
        one.join()
    assert len(results) == 2 and results[0] == results[1]
