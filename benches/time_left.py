#!/usr/bin/env python3
"""How right the time left is: runs a study with a bar and holds what it says against what was, as docs/performance.md tells.

    python3 benches/time_left.py target/release/sagnac studies/drift_vs_interval.toml --trials 500000

Prints how long it took, how fast the machine was meanwhile, and how far the bar was off at most between a tenth and nine tenths
of the run, beyond its rounding to 1 s. For Unix.
"""

import fcntl
import os
import pty
import re
import struct
import subprocess
import sys
import tempfile
import termios
import time

SECONDS = {"s": 1, "min": 60, "h": 3600, "d": 86400}
SAID = re.compile(r"\s((?:\d+ (?:min|s|h|d) ?)+) ?left")


def probe():
    """Tells 25 times a second what the same work takes of its own processor time, which is longer on a slower machine."""
    while True:
        begun = time.thread_time()
        total = 0
        for i in range(3000):
            total += i * i
        print(time.thread_time() - begun, flush=True)
        time.sleep(0.04)


def watched(command):
    """Runs a command on a terminal: its time, and what it said was left, each with when."""
    child, terminal = pty.fork()
    if child == 0:
        os.environ["TERM"] = "xterm"
        os.execvp(command[0], command)
    begun = time.time()
    fcntl.ioctl(terminal, termios.TIOCSWINSZ, struct.pack("HHHH", 40, 160, 0, 0))
    said = []
    while True:
        try:
            output = os.read(terminal, 1 << 16)
        except OSError:
            output = b""
        if not output:
            break
        for words in SAID.findall(output.decode(errors="replace")):
            left = sum(int(count) * SECONDS[unit] for count, unit in re.findall(r"(\d+) (min|s|h|d)", words))
            said.append((time.time() - begun, left))
    _, status = os.waitpid(child, 0)
    if status != 0:
        sys.exit(f"the run failed with status {os.waitstatus_to_exitcode(status)}")
    return time.time() - begun, said


def main():
    if sys.argv[1:] == ["--probe"]:
        probe()
    if len(sys.argv) < 3:
        sys.exit(__doc__)
    program, *study = sys.argv[1:]
    with tempfile.TemporaryDirectory() as folder:
        readings = open(os.path.join(folder, "readings"), "w+")
        beside = subprocess.Popen([sys.executable, __file__, "--probe"], stdout=readings)
        command = [program, "run", *study, "--out", os.path.join(folder, "results"), "--progress", "bar"]
        try:
            whole, said = watched(command)
        finally:
            beside.kill()
            beside.wait()
        readings.seek(0)
        speeds = sorted(1 / float(line) for line in readings.read().split("\n")[:-1])
    middle = [(at, left) for at, left in said if 0.1 * whole < at < 0.9 * whole]
    if not middle:
        sys.exit("nothing was said of the time left: take more trials")
    off = max(max(0.0, abs(left - (whole - at)) - 0.5) / (whole - at) for at, left in middle)
    usual = speeds[len(speeds) // 2]
    slow, fast = speeds[len(speeds) // 20] / usual, speeds[-len(speeds) // 20] / usual
    print(f"{whole:.1f} s, speed within {slow:.2f} to {fast:.2f}, off by at most {100 * off:.0f} %")


main()
