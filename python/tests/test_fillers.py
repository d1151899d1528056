"""Fillers are those of the program, and their fractions exact."""

from __future__ import annotations

from fractions import Fraction
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import sagnac
from program import Program


def check(found: sagnac.Fillers, expected: Any) -> None:
    tables, question = expected["tables"], expected["question"]
    of_gap = f"Which filler belongs in the firmware? Weights for a gap of {found.gap_ticks} lost tick{'s' if found.gap_ticks > 1 else ''}"
    of_tick = "" if found.tick is None else f" of {1e3 * found.tick:g} ms"
    assert found.title == expected["title"]
    assert question.startswith(of_gap + of_tick)
    for key, value in found.at.items():
        assert key == "switching.gap_ticks" or question.endswith(str(value))
    caveats = [fact["text"] for fact in expected["answer"]["facts"] if fact["fact"] == "caveat"]
    assert [text for text in caveats if "there is no rms" in text] == (
        [] if found.no_rms_because is None else [f"there is no rms: {found.no_rms_because}"]
    )
    assert list(found) == list(dict.fromkeys(row["filler"] for row in tables["fillers"]))
    for name, filler in found.items():
        rules = [filler.interpolation, *([filler.extrapolation] if filler.extrapolation else [])]
        entries = [row for row in tables["fillers"] if row["filler"] == name]
        assert [rule.error for rule in rules] == [entry["error"] for entry in entries]
        for rule, entry in zip(rules, entries, strict=True):
            assert filler.method == entry["method"]
            own = [row for row in tables["weights"] if (row["filler"], row["error"]) == (name, rule.error)]
            rows: dict[str, list[Any]] = {}
            for row in own:
                rows.setdefault(row["row"], []).append(row)
            whole = rows.pop("sum")
            assert list(rule.ticks) == [row["tick"] for row in whole]
            assert {rule.denominator} == {row["denominator"] for row in own}
            assert rule.exact == (entry["exact"] == "yes")
            assert list(rule.fractions) == [Fraction(row["numerator"], row["denominator"]) for row in whole]
            assert list(rule.weights) == [float(row["weight"]) for row in whole]
            if rows:
                by_tick = [[Fraction(row["numerator"], row["denominator"]) for row in line] for line in rows.values()]
                assert [list(row) for row in rule.rows] == by_tick
            for key in ["noise_gain", "largest_gain", "largest_input"]:
                assert getattr(rule, key) == entry[key], key
            assert (rule.amplitude, rule.rms) == (entry["amplitude_arcsec"], entry["rms_arcsec"])
            assert sum(rule.fractions) == found.gap_ticks


def test_polynomials_and_designs_are_those_of_the_program(program: Program) -> None:
    kinds = ["const", "linear", "quadratic"]
    for n in [1, 3, 7]:
        check(sagnac.filler(kinds, n), program("filler", *kinds, "--gap-ticks", n))
    expected = program(
        "filler", "minimum-variance", "--gap-ticks", 3, "--tick", "5 ms", "--fit-ticks=-7..0,n+1,n+2", "--band",
        "18 Hz,22 Hz", "--amplitude", "12000 arcsec/s", "--noise", "0.5 arcsec",
    )  # fmt: skip
    found = sagnac.filler(
        "minimum-variance", 3, tick="5 ms", fit_ticks="-7..0,n+1,n+2", band="18 Hz,22 Hz",
        amplitude="12000 arcsec/s", noise="0.5 arcsec",
    )  # fmt: skip
    check(found, expected)
    assert "#define" in found.header


def test_fillers_of_a_study_are_those_of_the_program(program: Program, studies: Path) -> None:
    study = studies / "which_filler.toml"
    check(sagnac.filler(study), program("filler", study))
    study = studies / "error_vs_dtnu.toml"
    expected = program("filler", study, "--at", "gap_ticks=3", "--filler", "quadratic")
    check(sagnac.filler(str(study), at={"gap_ticks": 3}, fillers=["quadratic"]), expected)


def test_the_response_is_the_amplitude_that_the_program_tells(program: Program) -> None:
    options = ["--gap-ticks", 3, "--tick", "5 ms", "--band", "20 Hz", "--amplitude", "12000 arcsec/s"]
    expected = program("filler", "quadratic", *options)["tables"]["fillers"]
    found = sagnac.filler("quadratic", 3, tick="5 ms", band="20 Hz", amplitude="12000 arcsec/s")["quadratic"]
    assert found.extrapolation is not None
    for rule, theirs in zip([found.interpolation, found.extrapolation], expected):
        assert 12000.0 * rule.response(20.0) == theirs["amplitude_arcsec"]
        assert rule.response([0.0, 20.0]).shape == (2,)


@pytest.mark.parametrize(
    "arguments, piece",
    [
        ({"what": "cubic", "gap_ticks": 3}, "`cubic` is not a filler"),
        ({"what": "const"}, "gap_ticks is missing"),
        ({"what": "const", "gap_ticks": 0}, "accepted: 1 to"),
        ({"what": "const", "gap_ticks": 100_000}, "gap_ticks"),
        ({"what": "minimum-variance", "gap_ticks": 3}, "tick is missing"),
        ({"what": "quadratic", "gap_ticks": 3, "fit_ticks": "0,4"}, "fit_ticks"),
        ({"what": "const", "gap_ticks": 3, "at": {"n": 1}}, "select from a study"),
        ({"what": "const", "gap_ticks": 3, "band": "20 Hz"}, "belong together"),
    ],
)
def test_fillers_that_cannot_be_are_refused_in_terms_of_the_arguments(arguments: Any, piece: str) -> None:
    with pytest.raises(sagnac.UsageError) as refused:
        sagnac.filler(**arguments)
    said = str(refused.value)
    assert piece in said and "--" not in said and "switching." not in said, said


def test_of_a_study_of_several_points_one_has_to_be_chosen(studies: Path) -> None:
    with pytest.raises(sagnac.UsageError, match="choose one with at=KEY=VALUE"):
        sagnac.filler(studies / "error_vs_dtnu.toml")
    with pytest.raises(sagnac.UsageError, match="has no fillers"):
        sagnac.filler(studies / "suspension.toml")
    with pytest.raises(sagnac.UsageError, match="leave it out"):
        sagnac.filler(studies / "which_filler.toml", 3)


def test_weights_are_numbers_too() -> None:
    weights = sagnac.filler("quadratic", 3)["quadratic"].interpolation.weights
    assert weights.dtype == np.float64 and list(weights) == [-1.0, 2.5, 2.5, -1.0]


def test_a_search_of_ticks_is_that_of_the_program(program: Program, studies: Path) -> None:
    asked: Any = {"tick": "5 ms", "band": "18 Hz,22 Hz", "amplitude": "12000 arcsec/s", "noise": "0.5 arcsec"}
    options = [part for name, value in asked.items() for part in (f"--{name}", value)]
    searched = ["--limit", "residual=8 arcsec", "--latency", "20 ms"]
    expected = program("filler", "minimum-variance", "--gap-ticks", 3, *options, *searched)
    found = sagnac.filler("minimum-variance", 3, **asked, limits={"residual": "8 arcsec"}, latency="20 ms")
    check(found, expected)
    assert found.data == expected and found.answer.data == expected["answer"]
    trade = expected["tables"]["trade"]
    for name, column in found.tables["trade.csv"].items():
        assert list(column) == [row[name] for row in trade], name
    assert set(found.charts) == {"trade", "response"}
    study = studies / "which_filler.toml"
    expected = program("filler", study, *searched)
    found = sagnac.filler(study, limits={"residual": "8 arcsec"}, latency="20 ms")
    check(found, expected)
    assert found.data == expected
    wrong: Any
    for wrong, piece in (
        ({"what": "quadratic", "limits": {"residual": "8 arcsec"}}, "one filler, minimum-variance"),
        ({"fit_ticks": "-3..0", "latency": "20 ms"}, "leave fit_ticks out"),
        ({"limits": {"residual": "8 s"}}, "limits="),
        ({"limits": {"rms": "8 arcsec"}}, "accepted: residual"),
        ({"latency": "-1 ms"}, "below 0"),
    ):
        with pytest.raises(sagnac.UsageError, match=piece):
            sagnac.filler(**{"what": "minimum-variance", "gap_ticks": 3, **asked, **wrong})
