//! The memory of fillers against the C header: a C compiler for a 32-bit processor checks the sizes.

use std::fmt::Write as _;
use std::process::Command;

use sagnac::analysis::firmware::{Firmware, Memory, identifiers};
use sagnac::study::Study;
use sagnac_engine::kinds::gap_fill::GapFill;

/// Fillers of all kinds, with and without extrapolation, and rules with one row and with several.
const STUDY: &str = r#"title = "Memory"
kind = "gap-fill"
[gyro]
tick = "5 ms"
tick_noise = { three_sigma = "1.6 arcsec" }
[motion]
amplitude = "12000 arcsec/s"
frequency = "20 Hz"
[switching]
gap_ticks = 3
fillers = [
  "const", "linear", "quadratic",
  { kind = "minimum-variance", name = "mv8+2", band = ["18 Hz", "22 Hz"], fit_ticks = ["-7..0", "n+1", "n+2"] },
  { kind = "weights", name = "given", weights = [-1, "5/2", "5/2", -1] },
  { kind = "weights", name = "both", weights = ["3/4", "3/4", "3/4", "3/4"], extrapolation_weights = [0, 0, 0, 3] },
]
"#;

/// Checks a program with the C compiler for a 32-bit processor; `None` where there is no such compiler.
fn checked(program: &str) -> Option<Result<(), String>> {
    let folder = tempfile::tempdir().unwrap();
    let check = |program: &str| {
        let path = folder.path().join("main.c");
        std::fs::write(&path, program).unwrap();
        let options = ["-std=c11", "-m32", "-ffreestanding", "-fsyntax-only"];
        let ended = Command::new("cc").args(options).arg(&path).output().ok()?;
        let said = String::from_utf8_lossy(&ended.stderr).into_owned();
        Some(if ended.status.success() { Ok(()) } else { Err(said) })
    };
    check("#include <stdint.h>\n")?.ok()?;
    check(program)
}

#[test]
fn the_memory_of_a_filler_is_that_of_what_the_header_declares() {
    for gap_ticks in [1, 3] {
        let mut text = STUDY.replace("gap_ticks = 3", &format!("gap_ticks = {gap_ticks}"));
        if gap_ticks == 1 {
            // Given weights sum to the number of lost ticks.
            text = text.replace("[-1, \"5/2\", \"5/2\", -1]", "[-1, 1, 1, 0]");
            text = text.replace("\"3/4\"", "\"1/4\"").replace("[0, 0, 0, 3]", "[0, 0, 0, 1]");
        }
        let study = Study::parse("memory.toml", &text).unwrap();
        let gap_fill = study.asked::<GapFill>().unwrap();
        let point = &gap_fill.points[0];
        let firmware = Firmware::new(&study, point, &gap_fill.fillers).unwrap();
        let mut program = firmware.header();
        let names = identifiers(gap_fill.fillers.iter().map(|filler| filler.name.as_str()));
        for ((filler, fill), name) in gap_fill.fillers.iter().zip(point.fills.iter()).zip(&names) {
            let Memory { constants, state } = Memory::of_filler(filler, fill, gap_ticks);
            let own = firmware.designs.iter().find(|design| design.name == filler.name).unwrap();
            let (mut flash, mut ram) = (format!("sizeof sagnac_{name}"), "sizeof(int64_t)".to_owned());
            for (part, rule) in
                [("extrapolation", own.extrapolation.as_ref()), ("interpolation", Some(&own.interpolation))]
            {
                let Some(rule) = rule else { continue };
                let table = format!("sagnac_{name}_{part}");
                flash += &format!(" + sizeof {table} + sizeof {table}_ticks");
                let (count, rows) = (rule.ticks.len(), rule.rows.len());
                ram += &format!(" + sizeof(int32_t[{count}]) + sizeof(int64_t[{rows}])");
            }
            writeln!(program, "_Static_assert({flash} == {constants}, \"constants of {name}\");").unwrap();
            writeln!(program, "_Static_assert({ram} == {state}, \"state of {name}\");").unwrap();
        }
        match checked(&program) {
            None => eprintln!("no C compiler `cc` for 32-bit processors: the sizes are not compared"),
            Some(found) => assert_eq!(found, Ok(()), "n = {gap_ticks}"),
        }
    }
}
