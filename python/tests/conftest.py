"""The program that the package is held against."""

from __future__ import annotations

import json
import os
import subprocess
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

ROOT = Path(__file__).resolve().parents[2]
Program = Callable[..., Any]


@pytest.fixture
def program(tmp_path: Path) -> Program:
    """Runs the program with `--json` in a folder of its own, and returns what it prints."""
    path = os.environ.get("SAGNAC", str(ROOT / "target/release/sagnac"))

    def run(*arguments: object) -> Any:
        command = [path, *map(str, arguments), "--json"]
        done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=False)
        assert done.returncode == 0, f"{command}\n{done.stderr}"
        return json.loads(done.stdout)

    return run


@pytest.fixture(scope="session")
def studies() -> Path:
    """The studies of the repository."""
    return ROOT / "studies"


@pytest.fixture(scope="session")
def reference() -> Path:
    """Values of formulas that other programs computed."""
    return ROOT / "tests/data"
