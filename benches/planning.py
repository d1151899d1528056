"""Time and memory until a study is planned, and of its resumption: python3 benches/planning.py PROGRAM…

It starts each program on studies of many points, and reads its processor time and its largest memory when it says that
sampling begins, and the time until the first rows are in the journal of the database; then it ends it. Of the first study
all is sampled, and it is resumed five times. Programs are compared in one sitting, study by study.
"""

import os
import pathlib
import statistics
import subprocess
import sys
import tempfile
import time

TICKS = """title = "Planning"
kind = "gap-fill"
trials = 1024
[gyro]
tick = "{tick}"
tick_noise = {{ three_sigma = "1.6 arcsec" }}
[motion]
{motion}
[switching]
gap_ticks = 3
fillers = ["const", "linear", "quadratic"{filler}]
"""
TONE = 'amplitude = "12000 arcsec/s"\nfrequency = "20 Hz"'
VIBRATION = (
    'suspension = { gyro = "LGK-400", alias = true, '
    'random = { psd = [["20 Hz", "0.001 g^2/Hz"], ["2000 Hz", "0.001 g^2/Hz"]] } }'
)
PROFILE = f'profile = {{ file = "{pathlib.Path(__file__).parent.parent.resolve()}/studies/data/base_vibration.csv" }}'
DESIGNED = ', { kind = "minimum-variance", name = "mv8+2", fit_ticks = ["-7..0", "n+1", "n+2"] }'
GAPS = '[[sweep]]\nkey = "switching.gap_ticks"\nlist = [1, 2, 3, 4, 5, 6, 7, 8, 9, 10]\n'


def sweep(key, start, end, points):
    return f'[[sweep]]\nkey = "{key}"\nlog = {{ from = "{start}", to = "{end}", points = {points} }}\n'


def grid(frequencies, amplitudes):
    return (
        sweep("motion.frequency", "2 Hz", "40 Hz", frequencies)
        + sweep("motion.amplitude", "1000 arcsec/s", "20000 arcsec/s", amplitudes)
        + GAPS
    )


NOISE = sweep("gyro.tick_noise.three_sigma", "0.5 arcsec", "5 arcsec", 100) + GAPS
LEVELS = sweep("motion.suspension.random.rms", "0.1 g", "10 g", 1000) + GAPS
STUDIES = {
    "tone, 10,000 points": TICKS.format(tick="5 ms", motion=TONE, filler="") + grid(50, 20),
    "random vibration, minimum variance, 10,000 points": TICKS.format(tick="1 ms", motion=VIBRATION, filler=DESIGNED) + LEVELS,
    "recorded profile, minimum variance, 1000 points": TICKS.format(tick="5 ms", motion=PROFILE, filler=DESIGNED) + NOISE,
    "tone, 100,000 points": TICKS.format(tick="5 ms", motion=TONE, filler="") + grid(100, 100),
    "tone, minimum variance, 100,000 points": TICKS.format(tick="5 ms", motion=TONE, filler=DESIGNED) + grid(100, 100),
}


# What the journal has before any rows: the tables and the owner of the folder.
OWNER = 64 << 10


def words(program, path, folder):
    return [program, "run", str(path), "--out", str(folder), "--device", "cpu", "--progress", "plain"]


def planned(program, study):
    """Seconds, processor seconds and MiB until sampling begins, and seconds until rows are in the database."""
    with tempfile.TemporaryDirectory() as folder:
        path = pathlib.Path(folder) / "study.toml"
        path.write_text(study)
        started = time.time()
        run = subprocess.Popen(words(program, path, folder + "/out"), stderr=subprocess.PIPE, stdout=subprocess.DEVNULL, text=True)
        said = []
        for line in run.stderr:
            said.append(line)
            if line.endswith(" done\n"):
                break
        else:
            raise SystemExit(f"{program} did not begin to sample:\n{''.join(said)}")
        seconds = time.time() - started
        process = pathlib.Path(f"/proc/{run.pid}")
        processor = int(process.joinpath("stat").read_text().rsplit(")", 1)[1].split()[11]) / 100
        lines = process.joinpath("status").read_text().splitlines()
        memory = next(int(line.split()[1]) / 1024 for line in lines if line.startswith("VmHWM"))
        journal = pathlib.Path(folder) / "out" / "tallies.sqlite-wal"
        while run.poll() is None and journal.stat().st_size <= OWNER:
            time.sleep(0.002)
        first = time.time() - started
        run.kill()
        run.wait()
        return seconds, processor, memory, first


def resumed(program, study, times=5):
    """Median seconds and processor seconds of complete runs that are resumed, and MiB."""
    with tempfile.TemporaryDirectory() as folder:
        path = pathlib.Path(folder) / "study.toml"
        path.write_text(study)
        found = []
        for _ in range(1 + times):
            started = time.time()
            run = subprocess.Popen(words(program, path, folder + "/out") + ["--quiet"], stderr=subprocess.DEVNULL)
            _, status, used = os.wait4(run.pid, 0)
            if status != 0:
                raise SystemExit(f"{program} failed")
            found.append((time.time() - started, used.ru_utime + used.ru_stime, used.ru_maxrss / 1024))
        # The first one samples.
        return [statistics.median(figures) for figures in zip(*found[1:])]


for at, (name, study) in enumerate(STUDIES.items()):
    for program in sys.argv[1:]:
        seconds, processor, memory, first = planned(program, study)
        figures = f"{seconds:.2f} s, processor {processor:.2f} s, {memory:.0f} MiB; first rows after {first:.2f} s"
        print(f"{name}: {program}: {figures}", flush=True)
    for program in sys.argv[1:] if at == 0 else []:
        seconds, processor, memory = resumed(program, study)
        print(f"{name}, resumed: {program}: {seconds:.2f} s, processor {processor:.2f} s, {memory:.0f} MiB", flush=True)
