"""The `sagnac` that the wheel puts on the path is the program: the same output, files, exit codes and signals."""

from __future__ import annotations

import os
import shutil
import signal
import subprocess
import sys
import sysconfig
import time
from collections.abc import Sequence
from pathlib import Path
from typing import IO

import pytest
from program import Program

posix = pytest.mark.skipif(os.name == "nt", reason="Windows has no such signals, pipes and names")

# More than a machine samples while a test waits.
ENDLESS = ["--device", "cpu", "--trials", str(1 << 31), "--out", "out"]

FEW = ["--device", "cpu", "--trials", "4096", "--out", "out"]

Arguments = Sequence[str | bytes]


class Sagnac:
    """A program in a folder of its own, named like its origin."""

    def __init__(self, path: str, folder: Path) -> None:
        self.path, self.folder = path, folder
        folder.mkdir()

    def start(self, arguments: Arguments, output: int | IO[bytes] = subprocess.PIPE) -> subprocess.Popen[bytes]:
        """Starts the program."""
        return subprocess.Popen(
            [self.path, *arguments], cwd=self.folder, stdin=subprocess.DEVNULL, stdout=output, stderr=subprocess.PIPE
        )

    def __call__(self, arguments: Arguments) -> tuple[int, bytes, bytes]:
        """Runs the program: its exit code, output and messages."""
        started = self.start(arguments)
        output, messages = started.communicate()
        return started.returncode, output, messages


@pytest.fixture
def both(program: Program, tmp_path: Path) -> list[Sagnac]:
    """The `sagnac` of the wheel, and the program."""
    wheel = shutil.which("sagnac", path=sysconfig.get_path("scripts"))
    assert wheel is not None, "the wheel has no program"
    return [Sagnac(wheel, tmp_path / "wheel"), Sagnac(program.path, tmp_path / "program")]


def agreed(both: list[Sagnac], arguments: Arguments) -> tuple[int, bytes, bytes]:
    """The exit code, output and messages, which are the same of both."""
    wheel, program = (each(arguments) for each in both)
    assert wheel == program, arguments
    return wheel


def test_version_and_help_are_the_same(both: list[Sagnac]) -> None:
    for arguments in (["--version"], ["--help"], ["run", "--help"], ["explain", "readout_lsb"]):
        code, output, messages = agreed(both, arguments)
        assert (code, messages) == (0, b"") and output, arguments


def test_a_study_gives_the_same_bytes(both: list[Sagnac], studies: Path) -> None:
    wheel, program = (each(["run", str(studies / "smoke.toml"), *FEW]) for each in both)
    assert wheel[:2] == program[:2] and wheel[0] == 0, (wheel, program)
    for name in ("points.csv", "resolved_study.toml", "chart.svg", "chart.png"):
        wheel_file, program_file = ((each.folder / "out" / name).read_bytes() for each in both)
        assert wheel_file == program_file, name


def test_failures_have_the_same_exit_codes_and_messages(both: list[Sagnac], studies: Path) -> None:
    study = str(studies / "smoke.toml")
    for each in both:
        (each.folder / "bad.toml").write_text('title = "Bad"\nkind = "gap-fill"\n')
        each(["run", study, *FEW])
        with (each.folder / "out/points.csv").open("a") as points:
            points.write("1")
    cases: list[tuple[list[str], int]] = [
        ([], 2),
        (["walk"], 2),
        (["walk\x1b[2J"], 2),
        (["run", study, "--device", "abacus"], 2),
        (["run", "bad.toml"], 3),
        (["run", "missing.toml"], 3),
        (["check", "out"], 5),
        (["run", study, *FEW[:-1], "bad.toml"], 6),
    ]
    for arguments, expected in cases:
        code, _, messages = agreed(both, arguments)
        assert code == expected and messages, (arguments, code, messages)
    # How far it comes differs.
    for each in both:
        late = ["run", str(studies / "noise_error_vs_gap.toml"), *ENDLESS[:-1], "late", "--time-limit", "300ms"]
        code, _, messages = each(late)
        assert code == 4 and b"stopped by the time limit" in messages, messages


@posix
def test_names_of_files_need_not_be_text(both: list[Sagnac], studies: Path) -> None:
    assert agreed(both, ["run", b"\xff.toml"])[0] == 3
    for each in both:
        shutil.copy(os.fsencode(studies / "smoke.toml"), os.fsencode(each.folder) + b"/\xff.toml")
    assert [each(["run", b"\xff.toml", *FEW])[0] for each in both] == [0, 0]


@posix
@pytest.mark.usefixtures("interrupted")
@pytest.mark.parametrize(("number", "expected"), [(signal.SIGINT, 130), (signal.SIGTERM, 143)])
def test_a_signal_ends_a_run_that_resumes(
    both: list[Sagnac], studies: Path, number: signal.Signals, expected: int
) -> None:
    run = ["run", str(studies / "noise_error_vs_gap.toml")]
    for each in both:
        started = each.start([*run, *ENDLESS])
        assert started.stderr is not None
        while not started.stderr.readline().endswith(b"trials done\n"):
            assert started.poll() is None, "nothing is sampled"
        time.sleep(0.5)
        started.send_signal(number)
        _, messages = started.communicate(timeout=60)
        assert started.returncode == expected, messages
        assert f"{number.name}: stopping after this batch".encode() in messages and b"resumable" in messages
        assert not (each.folder / "out/points.csv").exists()
        # It has the first trials already.
        code, _, messages = each([*run, *FEW])
        before = next(line for line in messages.splitlines() if line.endswith(b"trials done"))
        assert code == 0 and not before.startswith(b"0 of"), messages
        assert each(["check", "out"])[0] == 0


@posix
@pytest.mark.usefixtures("interrupted")
def test_ctrl_c_ends_commands_that_do_not_listen_for_it(both: list[Sagnac]) -> None:
    for each in both:
        # The schema is larger than the pipe, which nobody reads.
        started = each.start(["schema"])
        with pytest.raises(subprocess.TimeoutExpired):
            started.wait(1.0)
        started.send_signal(signal.SIGINT)
        assert started.wait(10.0) == -signal.SIGINT
        started.communicate()


@posix
def test_a_closed_pipe_ends_the_program_in_silence(both: list[Sagnac]) -> None:
    for each in both:
        started = each.start(["schema"])
        assert started.stdout is not None and started.stderr is not None
        assert started.stdout.readline() == b"{\n"
        started.stdout.close()
        assert (started.wait(10.0), started.stderr.read()) == (0, b"")
        started.stderr.close()


@posix
def test_closed_streams_do_not_become_files(both: list[Sagnac], studies: Path) -> None:
    for each in both:
        closed = f'"{each.path}" run "{studies / "smoke.toml"}" {" ".join(FEW)} <&- >&- 2>&-'
        assert subprocess.run(closed, shell=True, cwd=each.folder, check=False).returncode == 0
        assert each(["check", "out"])[0] == 0


@posix
def test_a_terminal_is_seen(both: list[Sagnac]) -> None:
    import pty

    shown = []
    for each in both:
        ours, theirs = pty.openpty()
        subprocess.run([each.path, "run", "missing.toml"], cwd=each.folder, stderr=theirs, check=False)
        os.close(theirs)
        shown.append(os.read(ours, 1 << 16))
        os.close(ours)
    assert shown[0] == shown[1] and b"\x1b[" in shown[0], shown


def test_the_program_starts_without_numpy_and_the_package(tmp_path: Path) -> None:
    start = "import sys; sys.argv[1:] = ['--version']; from _sagnac import main; main()"
    done = subprocess.run(
        [sys.executable, "-X", "importtime", "-c", start], cwd=tmp_path, capture_output=True, text=True, check=False
    )
    imported = [line.split("|")[-1].strip() for line in done.stderr.splitlines()]
    assert done.returncode == 0 and "_sagnac._sagnac" in imported, done.stderr
    assert not {"numpy", "sagnac"} & set(imported), imported
