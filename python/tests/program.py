"""The program that the package is checked against."""

from __future__ import annotations

import json
import os
import subprocess
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parents[2]


class Program:
    """Runs the program with `--json` in a folder of its own, and returns what it prints."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self.path = os.environ.get("SAGNAC", str(ROOT / "target/release/sagnac"))

    def __call__(self, *arguments: object) -> Any:
        command = [self.path, *map(str, arguments), "--json"]
        done = subprocess.run(command, cwd=self.folder, capture_output=True, text=True, check=False)
        assert done.returncode == 0, f"{command}\n{done.stderr}"
        return json.loads(done.stdout)
