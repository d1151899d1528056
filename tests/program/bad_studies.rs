//! Bad studies and records: every one is refused with its place, what was found, what is accepted, and exit code 3.

use crate::desk::{Desk, STUDY, refused, replaced, swept_chart, with};

#[test]
fn an_unknown_key_is_pointed_at_and_the_nearest_known_one_named() {
    refused(&format!("sed = 1\n{STUDY}"), "1:1", &["unknown key `sed`", "did you mean `seed`?", "trials"]);
    refused(
        &replaced("frequency", "freqency"),
        "8:1",
        &["8 freqency = \"20 Hz\"", "unknown key `freqency`", "did you mean `frequency`?"],
    );
    refused(&replaced("std", "sdt"), "5:16", &["unknown key `sdt`", "did you mean `std`?", "three_sigma"]);
    refused(&replaced("[gyro]", "[giro]"), "3:2", &["unknown key `giro`", "did you mean `gyro`?"]);
}

#[test]
fn a_wrong_or_missing_unit_is_told_with_the_units_that_are_accepted() {
    let accepted = "accepted: a frequency in Hz, kHz, 1/s, for example \"20 Hz\"";
    refused(&replaced("20 Hz", "20 deg"), "8:13", &["\"20 deg\" is an angle", accepted]);
    refused(&replaced("20 Hz", "20 hz"), "8:13", &["`hz` is not a known unit", accepted]);
    refused(&replaced("\"20 Hz\"", "20"), "8:13", &["a bare number", accepted]);
    refused(&replaced("20 Hz", "20"), "8:13", &["a bare number", accepted]);
    refused(&replaced("\"5 ms\"", "5"), "4:8", &["a bare number", "accepted: a time in s, ms"]);
}

#[test]
fn a_comma_in_a_number_is_told_from_its_point() {
    let pieces = ["has a comma in its number", "as in \"20.5 Hz\"", "a comma in a number"];
    refused(&replaced("20 Hz", "20,5 Hz"), "8:13", &pieces);
}

#[test]
fn whole_numbers_may_be_written_as_floats() {
    refused(&format!("trials = 1.5\n{STUDY}"), "1:10", &["trials: 1.5 is not a whole number"]);
    refused(&format!("trials = 1e300\n{STUDY}"), "1:10", &["is not a whole number"]);
    let desk = Desk::with(&format!("trials = 1e2\n{STUDY}"));
    desk.done("run study.toml --device cpu");
    assert_eq!(desk.points("results/study")[0]["trials"], "100");
    assert!(desk.read("results/study/resolved_study.toml").starts_with("trials = 1e2\n"));
}

#[test]
fn a_folder_in_place_of_a_study_is_told_with_its_files() {
    let desk = Desk::with(STUDY);
    desk.fails("run .", 3, &[". is a folder, not a study file", "give one of its files: ./study.toml"]);
    std::fs::create_dir(desk.path("none")).unwrap();
    desk.fails("run none", 3, &["none is a folder", "sagnac new gap-fill"]);
}

#[test]
fn negative_values_and_values_that_are_no_numbers_are_refused() {
    refused(&replaced("20 Hz", "-20 Hz"), "8:13", &["motion.frequency = -20 Hz", "negative"]);
    refused(&replaced("1 arcsec\"", "-1 arcsec\""), "5:22", &["gyro.tick_noise.std", "negative"]);
    refused(&replaced("20 Hz", "NaN Hz"), "8:13", &["does not begin with a number"]);
    refused(&replaced("\"20 Hz\"", "nan"), "8:13", &["accepted: a frequency in Hz"]);
    refused(&replaced("20 Hz", "1e999 Hz"), "8:13", &["is not a finite number"]);
    refused(&format!("seed = -1\n{STUDY}"), "1:8", &["seed = -1"]);
}

#[test]
fn absurd_values_are_refused_with_the_range_that_is_accepted() {
    refused(&replaced("20 Hz", "1 000 kHz"), "8:13", &["accepted: "]);
    refused(&replaced("20 Hz", "1e9 Hz"), "8:13", &["too large", "accepted: 1e-9 Hz to 1e7 Hz"]);
    refused(&replaced("20 Hz", "2001 Hz"), "8:13", &["too fast for a tick rate of 200 Hz", "2000 Hz here"]);
    refused(&replaced("5 ms", "1 h"), "4:8", &["gyro.tick = 3600 s", "1 µs to 1000 s"]);
    refused(&replaced("12000", "1e12"), "7:13", &["motion.amplitude", "accepted: "]);
    refused(&format!("trials = 0\n{STUDY}"), "1:10", &["trials = 0", "1 … 1099511627776"]);
}

#[test]
fn a_sweep_without_values_or_over_text_is_refused() {
    let sweep = |key: &str, list: &str| with(&format!("[[sweep]]\nkey = \"{key}\"\nlist = {list}"));
    refused(
        &sweep("motion.frequency", "[]"),
        "14:8",
        &["the sweep over motion.frequency is empty", "no values"],
    );
    refused(
        &sweep("motion.phase", "[\"uniform\"]"),
        "13:7",
        &["motion.phase is text", "motion.frequency", "switching.gap_ticks"],
    );
    refused(&sweep("motion.freqency", "[\"1 Hz\"]"), "13:7", &["did you mean `motion.frequency`?"]);
    refused(&sweep("motion.frequency", "[\"1 Hz\", 2]"), "14:17", &["a bare number", "Hz, kHz, 1/s"]);
}

#[test]
fn gaps_and_fits_that_make_no_sense_are_refused() {
    refused(&replaced("gap_ticks = 3", "gap_ticks = 65"), "10:13", &["within 1 … 64", "too large"]);
    refused(&replaced("gap_ticks = 3", "gap_ticks = 0"), "10:13", &["within 1 … 64"]);
    refused(&with("fit_ticks = [-1, 0, 2]"), "12:21", &["tick 2 lies inside the gap", "gap_ticks = 3"]);
    refused(&with("fit_ticks = [-1, 0]"), "12:13", &["quadratic needs 3 ticks, switching.fit_ticks has 2"]);
    refused(&with("fit_ticks = [-1, 0, 0]"), "12:21", &["tick 0 is listed twice"]);
}

#[test]
fn noise_too_small_to_be_represented_is_refused_by_name() {
    refused(
        &replaced("1 arcsec\"", "1e-9 arcsec\""),
        "5:22",
        &["gyro.tick_noise", "make the noise larger, or 0"],
    );
    Desk::with(&replaced("1 arcsec\"", "0 arcsec\"")).done("run study.toml --device cpu --trials 100");
}

#[test]
fn what_cannot_be_represented_is_pointed_at_however_it_is_written() {
    let noise = |lines: &str| replaced("tick_noise = { std = \"1 arcsec\" }", lines);
    refused(&noise("tick_noise.std = \"1e-9 arcsec\""), "5:18", &["gyro.tick_noise"]);
    refused(&noise("[gyro.tick_noise]\nstd = \"\"\"1e-9 arcsec\"\"\""), "6:7", &["gyro.tick_noise"]);
    refused(&noise("\"tick_noise\" = { std = \"1e-9 arcsec\" }"), "5:24", &["gyro.tick_noise"]);
    let quoted = noise("tick_noise.std = \"1e-9 arcsec\"")
        .replace("\"A study\"", "\"\"\"\ntick_noise = { std = \"1 arcsec\" }\n\"\"\"");
    refused(&quoted, "7:18", &["gyro.tick_noise"]);
    let swept = with("[[sweep]]\nkey = \"gyro.tick_noise.std\"\nlist = [\"1 arcsec\", \"1e-9 arcsec\"]");
    refused(&swept, "14:8", &["gyro.tick_noise", "at gyro.tick_noise.std = 1e-9"]);
}

#[test]
fn a_value_of_the_wrong_type_is_told_in_the_words_of_studies() {
    let line = |old: &str, place: &str, new: &str, pieces: &[&str]| {
        let desk = Desk::with(&replaced(old, new));
        desk.fails(
            "run study.toml --device cpu",
            3,
            &[&[&*format!("[study.toml:{place}]")], pieces].concat(),
        );
        let said = desk.sagnac("run study.toml --device cpu").stderr;
        for word in ["struct", "sequence", "invalid type", "Table", "wanted", "= …"] {
            assert!(!said.contains(word), "`{word}` in\n{said}");
        }
    };
    let gyro = "[gyro]\ntick = \"5 ms\"\ntick_noise = { std = \"1 arcsec\" }\n";
    let noise = "{ std = \"1 arcsec\" }";
    let (kind, like_gyro) = ("kind = \"gap-fill\"", "[gyro] tick = \"5 ms\" tick_noise = {");
    let five = format!("{kind}\ngyro = 5\n");
    line(&format!("{kind}\n{gyro}"), "3:8", &five, &["`gyro` is the number 5", "must be a table", like_gyro]);
    line(gyro, "2:8", "", &["needs the table [gyro]", like_gyro]);
    line("tick = \"5 ms\"\n", "3:1", "", &["the key `gyro.tick` is missing", "tick = \"5 ms\""]);
    line(
        noise,
        "5:14",
        "\"1 arcsec\"",
        &["`gyro.tick_noise` is the text \"1 arcsec\"", "{ std = \"0.53 arcsec\" }"],
    );
    line(
        "[\"const\", \"quadratic\"]",
        "11:11",
        "\"const\"",
        &["is the text \"const\"", "a list in brackets", "[\"const\", "],
    );
    line(
        "\"quadratic\"",
        "11:21",
        "2",
        &["switching.fillers: 2 is not a filler", "const, linear, quadratic, or a table"],
    );
    line("\"gap-fill\"", "2:8", "1", &["`kind` is the number 1", "kind = \"gap-fill\""]);
    line("\"5 ms\"", "4:8", "2026-01-01", &["`gyro.tick` is a date", "tick = \"5 ms\""]);
}

#[test]
fn charts_that_name_what_is_not_there_are_refused() {
    let chart = |lines: &str| with(&format!("[chart]\nx = \"dt_nu\"\n{lines}"));
    refused(
        &chart("y = \"rsm\""),
        "14:5",
        &["no column is called `rsm`", "rms_arcsec", "did you mean `rms`?"],
    );
    let swept = swept_chart("x = \"freq\"\ny = \"rms\"\nwhere = { filler = \"const\" }");
    refused(&swept, "19:5", &["no column is called `freq`", "did you mean `motion.frequency`?"]);
    refused(
        &swept_chart("y = \"rms\""),
        "18:1",
        &["the key `chart.x` is missing", "x = \"motion.frequency\""],
    );
    refused(&chart("y = \"rms\"\nseries = [\"filer\"]"), "15:11", &["no column is called `filer`"]);
    refused(&chart("y = \"filler\""), "14:5", &["`filler`"]);
    refused(
        &chart("y = \"rms\"\nwhere = { errors = \"residual\" }"),
        "15:11",
        &["`where` cannot choose rows by `errors`", "did you mean `error`?"],
    );
    refused(&chart("y = \"rms\"\nwhere = { trials = 0 }"), "15:11", &["by `trials`", "filler, error"]);
    refused(&chart("y = \"rms\"\nwhere = { rms = \"\" }"), "15:11", &["by `rms`", "filler, error"]);
    refused(&chart("y = \"rms\"\nwhere = { error = \"residuals\" }"), "15:19", &["residuals", "residual"]);
    refused(
        &chart("y = \"rms\"\nwhere = { filler = \"linear\" }"),
        "15:20",
        &["linear", "const", "quadratic"],
    );
    let swept = |lines: &str| {
        chart(&format!("{lines}\n[[sweep]]\nkey = \"motion.frequency\"\nlist = [\"5 Hz\", \"20 Hz\"]"))
    };
    refused(
        &swept("y = \"rms\"\nwhere = { frequency = \"6 Hz\" }"),
        "15:23",
        &["no point has motion.frequency = 6 Hz", "accepted: 5 Hz, 20 Hz"],
    );
    refused(&chart("y = \"rms\"\nlimit = \"0 arcsec\""), "15:9", &["chart.limit = 0″", "not above 0"]);
    refused(
        &chart("y = \"z\"\nlimit = \"10 arcsec\""),
        "14:5",
        &["`z` is a number without unit, a limit in ″ cannot be drawn on it", "leave out the limit"],
    );
    refused(&swept("y = \"frequency_hz\"\nlimit = \"10 arcsec\""), "14:5", &["`frequency_hz` is in Hz"]);
}

#[test]
fn charts_with_keys_of_another_kind_are_refused() {
    let map = "kind = \"heat-map\"\nx = \"frequency\"\ny = \"amplitude\"\n";
    refused(
        &swept_chart("kind = \"pie\""),
        "19:8",
        &["unknown value \"pie\"", "curves, heat-map, winner-map"],
    );
    refused(&swept_chart(map), "19:8", &["needs z", "z = \"p99_73\""]);
    refused(
        &swept_chart("x = \"dt_nu\"\ny = \"rms\"\nz = \"rms\""),
        "21:5",
        &["chart.z is not a key of a chart of kind = \"curves\"", "leave it out"],
    );
    refused(&swept_chart(&format!("{map}z = \"rsm\"")), "22:5", &["no column is called `rsm`"]);
    refused(
        &swept_chart(&format!("{map}z = \"z\"\nlimit = \"10 arcsec\"")),
        "22:5",
        &["a limit in ″ cannot be drawn on it", "name an estimate in ″ instead, or leave out the limit"],
    );
    let twice = map.replace("amplitude", "frequency_hz");
    refused(&swept_chart(&format!("{twice}z = \"rms\"")), "21:5", &["both x and y", "another column as y"]);
}

#[test]
fn a_map_of_several_rows_on_one_cell_is_refused_with_what_tells_them_apart() {
    let map = |y: &str, more: &str| {
        swept_chart(&format!("kind = \"heat-map\"\nx = \"frequency\"\ny = \"{y}\"\nz = \"rms\"\n{more}"))
    };
    refused(
        &map("amplitude", ""),
        "22:5",
        &["they differ in filler (const, quadratic)", "where = { filler = \"const\" }"],
    );
    refused(
        &map("dt_nu", "where = { filler = \"const\" }"),
        "22:5",
        &[
            "differ in motion.amplitude (10, 12000)",
            "where = { amplitude = \"10 arcsec/s\" }",
            "amplitude an axis",
        ],
    );
}

#[test]
fn references_are_refused_where_they_cannot_be_drawn() {
    let references = |lines: &str| swept_chart(&format!("{lines}\nreferences = [\"noise\"]"));
    refused(
        &references("x = \"max\"\ny = \"rms\""),
        "19:5",
        &["reference curves cannot be drawn over `max`", "motion.frequency"],
    );
    refused(
        &references("x = \"dt_nu\"\ny = \"z\""),
        "20:5",
        &["a law in ″ cannot be drawn on it", "leave out the law"],
    );
    refused(
        &references("x = \"dt_nu\"\ny = \"rms\"").replace("noise\"]", "nose\"]"),
        "21:15",
        &["unknown value \"nose\"", "did you mean `noise`?"],
    );
}

#[test]
fn what_is_no_toml_or_no_file_is_told() {
    refused(&replaced("\"20 Hz\"", "20 Hz"), "8:13", &["not valid TOML", "stand in quotes"]);
    refused(&replaced("[gyro]", "[gyro"), "3:6", &["not valid TOML"]);
    let desk = Desk::with(STUDY);
    desk.fails("run missing.toml --device cpu", 3, &["cannot read the study missing.toml", "help:"]);
    std::fs::create_dir(desk.path("folder")).unwrap();
    desk.fails("run folder --device cpu", 3, &["folder is a folder, not a study file", "help:"]);
    std::fs::write(desk.path("latin1.toml"), b"title = \"\xe9\"\n").unwrap();
    desk.fails("run latin1.toml --device cpu", 3, &["cannot read the study latin1.toml", "UTF-8"]);
    std::fs::write(desk.path("utf16.toml"), STUDY.replace('\n', "\0\n")).unwrap();
    desk.fails(
        "run utf16.toml --device cpu",
        3,
        &["it contains a zero byte, as UTF-16 does", "save it as UTF-8"],
    );
    assert_eq!(desk.names("."), ["folder", "latin1.toml", "study.toml", "utf16.toml"]);
}

#[test]
fn a_last_point_that_does_not_fit_is_refused_before_anything_is_written() {
    let study = |last: &str| {
        let amplitudes =
            (1000..4000).map(|amplitude| format!("\"{amplitude} arcsec/s\"")).collect::<Vec<_>>();
        let sweep =
            format!("[[sweep]]\nkey = \"motion.amplitude\"\nlist = [{}, \"{last}\"]", amplitudes.join(", "));
        with(&sweep).replace("\"1 arcsec\"", "\"0.05 arcsec\"")
    };
    let desk = Desk::with(&study("9e8 arcsec/s"));
    let refused = ["gyro.tick_noise: 0.05″ of noise", "motion.amplitude = 900000000 ″/s", "study.toml:5:22"];
    desk.fails("run study.toml --device cpu --trials 64 --out out", 3, &refused);
    assert_eq!(desk.names(""), ["study.toml"]);
    // The results of the points that fit stay as they are.
    desk.write("fits.toml", &study("4000 arcsec/s"));
    desk.done("run fits.toml --device cpu --trials 64 --quiet --out out");
    let contents = || {
        let names = desk.names("out").into_iter();
        names.map(|name| (std::fs::read(desk.path("out").join(&name)).unwrap(), name)).collect::<Vec<_>>()
    };
    let before = contents();
    desk.fails("run study.toml --device cpu --trials 64 --out out", 3, &refused);
    assert!(contents() == before, "a file changed");
}
