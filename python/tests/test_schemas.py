"""What `--json` prints is what the committed schemas say, for every command and kind of study."""

from __future__ import annotations

import copy
import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from jsonschema import Draft202012Validator
from program import ROOT, Program

VALIDATOR = Draft202012Validator(json.loads((ROOT / "schema/document.schema.json").read_text()))
STUDIES = ROOT / "studies"
LOG = STUDIES / "data/gyro_at_rest.csv"
FEW = ["--trials", "64", "--device", "cpu"]


def check(document: Any) -> None:
    """Holds a document against the schema."""
    faults = [f"{fault.message} at {fault.json_path}" for fault in VALIDATOR.iter_errors(document)]
    assert not faults, "\n".join(faults[:5])


def logs(folder: Path) -> None:
    """Writes logs: one that differs from the shipped one in a value, two gyros, and one with a temperature."""
    (folder / "g.csv").write_text(LOG.read_text().replace("9.8947", "9.9947", 1))
    values = np.random.default_rng(7).normal(0.0, 2.0, (3000, 2))
    np.savetxt(folder / "two.csv", values, "%.5f", ",", header="gx [deg/h],gz [deg/h]", comments="")
    row = np.arange(400)
    warm = np.column_stack([row * 37 % 101, 20.0 + 5.0 * np.sin(0.05 * row)])
    np.savetxt(folder / "warm.csv", warm, "%.9g", ",", header="gz [deg/h],temp [degC]", comments="")
    (folder / "noise.toml").write_text('angle_random_walk = "0.003 deg/sqrt(h)"\n')


@pytest.mark.parametrize(
    "names",
    [
        ["error_vs_dtnu"],
        ["record_length"],
        ["relock_tables"],
        ["drift_vs_interval"],
        ["suspension", "optimal_interval"],
    ],
)
def test_runs_of_every_kind_print_what_the_schema_says(program: Program, names: list[str]) -> None:
    check(program("run", *(STUDIES / f"{name}.toml" for name in names), *FEW))


@pytest.mark.parametrize(
    "command",
    [
        "design {studies}/design_point.toml --trials 64 --device cpu",
        "design {studies}/design_point.toml --trials 64 --device cpu --search --latency 20ms",
        "sensitivity {studies}/what_decides.toml --device cpu --out s --by theory_rms --samples 32",
        "sensitivity {studies}/what_decides.toml --device cpu --out s --samples 32 --trials 64",
        "filler quadratic const --gap-ticks 3",
        "filler {studies}/which_filler.toml",
        "allan {log} --bootstrap 0",
        "allan {log} --fit none --no-psd --bootstrap 0",
        "allan {log} --segment 600s --segment-detrend linear --bootstrap 0",
        "allan {log} --deviation oadev,tdev,hdev --remove-outliers --detrend linear --skip 60s --bootstrap 0",
        "allan {log} --bootstrap 200",
        "allan {log} --bootstrap 0 --dynamic 30min",
        "allan {log} --bootstrap 0 --navigate 1h",
        "allan {log} --bootstrap 0 --limit N=0.001deg/sqrt(h) --limit B=0.1deg/h --limit floor=1deg/sqrt(h)",
        "allan warm.csv --data rate --rate 1Hz --column gz --temperature temp --bootstrap 0",
        "compare {log} {log}",
        "compare {log} g.csv --limit N=1.1 --limit sine=2 --fit Q,N,sine",
        "compare {log} {log} --fit none",
        "compare two.csv --data rate --rate 1Hz --column gx,gz",
        "compare two.csv --data rate --rate 1Hz --column gx,gz --fit none",
        "compare two.csv --data rate --rate 1Hz --column gx,gz --limit in_run_bias_stability=1deg/s",
        "model {log} --overbound",
        "model {log} --overbound=repeat --write all",
        "model {log} --overbound --quantization white --states 1",
        "model noise.toml --from 1s --to 100s",
        "model two.csv --data rate --rate 1Hz --column gx,gz --overbound",
    ],
)
def test_other_commands_print_what_the_schema_says(program: Program, command: str) -> None:
    logs(program.folder)
    words = command.replace("{log}", f"{LOG} --data rate --rate 1Hz", 1)
    check(program(*words.format(studies=STUDIES, log=LOG).split()))


def test_a_document_that_lacks_or_adds_a_key_is_not_what_the_schema_says(program: Program) -> None:
    document = program("filler", "quadratic", "--gap-ticks", 3)
    check(document)
    above, below = copy.deepcopy(document), copy.deepcopy(document)
    above["more"] = 1
    below["tables"]["weights"][0]["more"] = 1
    assert not VALIDATOR.is_valid(above)
    assert not VALIDATOR.is_valid(below)
    for key in ["schema", "title", "question", "answer", "notes", "tables"]:
        less = {name: value for name, value in document.items() if name != key}
        assert not VALIDATOR.is_valid(less), key
