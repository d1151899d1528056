"""What tests are given."""

from __future__ import annotations

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
