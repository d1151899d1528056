"""What tests are given."""

from __future__ import annotations

import signal
from collections.abc import Iterator
from pathlib import Path

import pytest
from program import ROOT, Program


@pytest.fixture
def program(tmp_path: Path) -> Program:
    """The program, in a folder of its own."""
    return Program(tmp_path)


@pytest.fixture(scope="session")
def studies() -> Path:
    """The studies of the repository."""
    return ROOT / "studies"


@pytest.fixture(scope="session")
def reference() -> Path:
    """Values of formulas that other programs computed."""
    return ROOT / "tests/data"


@pytest.fixture
def interrupted() -> Iterator[None]:
    """Programs that a shell starts in the background ignore Ctrl-C; not so here."""
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    yield
    signal.signal(signal.SIGINT, before)
