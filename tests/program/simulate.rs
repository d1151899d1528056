//! `sagnac simulate`: records of noise files and studies.

use crate::desk::Desk;

const NOISE: &str = "angle_random_walk = \"0.01 deg/sqrt(h)\"\nrate_random_walk = \"0.5 deg/h/sqrt(h)\"\n";
const RECORD: &str = "simulate noise.toml --rate 1Hz --length 4h";

fn desk() -> Desk {
    let desk = Desk::with("");
    desk.write("noise.toml", NOISE);
    desk
}

/// The numbers of a record as text.
fn numbers(csv: &str) -> Vec<f64> {
    csv.lines().skip(1).map(|line| line.split_once(',').unwrap().1.parse().unwrap()).collect()
}

fn doubles(bytes: &[u8]) -> Vec<f64> {
    bytes.chunks_exact(8).map(|number| f64::from_le_bytes(number.try_into().unwrap())).collect()
}

#[test]
fn a_record_of_a_seed_is_the_same_wherever_it_is_made_and_in_every_form() {
    let desk = desk();
    desk.done(&format!("{RECORD} --seed 3 --records 8 --out all"));
    desk.done(&format!("{RECORD} --seed 3 --first 7 --out one"));
    let record = desk.read("all/record_00007.csv");
    assert_eq!(desk.read("one/record_00007.csv"), record);
    assert_ne!(desk.read("all/record_00006.csv"), record);
    let rates = numbers(&record);
    assert_eq!(rates.len(), 14400);
    for form in ["npy", "raw"] {
        desk.done(&format!("{RECORD} --seed 3 --first 7 --form {form} --out {form}"));
        let bytes = std::fs::read(desk.path(&format!("{form}/record_00007.{form}"))).unwrap();
        let numbers = match bytes.strip_prefix(b"\x93NUMPY\x01\x00") {
            Some(rest) => {
                let (header, numbers) =
                    rest[2..].split_at(usize::from(u16::from_le_bytes([rest[0], rest[1]])));
                let header = std::str::from_utf8(header).unwrap();
                assert!(
                    header.starts_with("{'descr': '<f8'") && header.contains("'shape': (14400,)"),
                    "{header}"
                );
                assert_eq!((bytes.len() - numbers.len()) % 64, 0);
                numbers
            }
            None => &bytes,
        };
        assert_eq!((form == "npy", doubles(numbers)), (numbers.len() < bytes.len(), rates.clone()), "{form}");
    }
    for form in ["npz", "mat", "h5", "mcap"] {
        desk.done(&format!("{RECORD} --seed 3 --first 7 --form {form} --out {form}"));
        let column = if form == "mcap" { "--column gz" } else { "" };
        desk.done(&format!(
            "allan {form}/record_00007.{form} {column} --bootstrap 0 --fit none --out of_{form}"
        ));
    }
    desk.done("allan all/record_00007.csv --bootstrap 0 --fit none --out of_csv");
    for form in ["npz", "mat", "h5", "mcap"] {
        let curve = |form: &str| -> Vec<String> {
            desk.table(&format!("of_{form}/curve.csv")).iter().map(|row| row["value"].clone()).collect()
        };
        assert_eq!(curve(form), curve("csv"), "{form}");
    }
    desk.fails(&format!("{RECORD} --form mcap --data angle --out angles"), 2, &["no angle", "another form"]);
    desk.done(&format!("{RECORD} --seed 3 --first 7 --data increment --out increments"));
    desk.done(&format!("{RECORD} --seed 3 --first 7 --data angle --out angles"));
    let increments = numbers(&desk.read("increments/record_00007.csv"));
    let angles = numbers(&desk.read("angles/record_00007.csv"));
    assert_eq!(increments, rates, "a sample is 1 s, and 1 ″/s is 1 °/h");
    assert!((angles[14399] - increments.iter().sum::<f64>()).abs() < 1e-9);
}

#[test]
fn an_array_of_numpy_has_its_rate_and_unit_beside_it_and_allan_asks_for_both() {
    let desk = desk();
    let ended = desk.done("simulate noise.toml --rate 10Hz --length 10min --form npy --out lab");
    assert!(!ended.stderr.contains("0 of 1"), "one record is no progress: {}", ended.stderr);
    let hint = "--rate 10Hz --data rate --unit deg/h";
    assert!(ended.stdout.contains(hint), "{}", ended.stdout);
    let study = desk.read("lab/simulated.toml");
    assert!(study.contains("rates in °/h") && study.contains("sample = \"0.1 s\""), "{study}");
    desk.fails("allan lab/record_00000.npy", 3, &["give the rate", "the unit of column 1 is missing"]);
    desk.done(&format!("allan lab/record_00000.npy {hint} --bootstrap 0 --out found"));
}

#[test]
fn coefficients_of_simulated_records_are_within_their_intervals() {
    let desk = desk();
    desk.done(&format!("{RECORD} --records 40 --seed 5 --out all"));
    let mut within = [0; 2];
    for record in 0..40 {
        desk.done(&format!("allan all/record_{record:05}.csv --bootstrap 0 --fit N,K --out out"));
        let coefficients = desk.table("out/coefficients.csv");
        for (place, (name, truth)) in [("N", 0.01), ("K", 0.5)].into_iter().enumerate() {
            let row = coefficients.iter().find(|row| row["coefficient"] == name).unwrap();
            let end = |name: &str| row[name].parse::<f64>().unwrap();
            within[place] += usize::from((end("lower")..=end("upper")).contains(&truth));
        }
    }
    // 99.9 % of 40 draws of 95 % are 32 or more.
    assert!(within.iter().all(|count| *count >= 32), "{within:?}");
}

#[test]
fn records_of_a_study_are_its_trials() {
    let desk = desk();
    let study = "title = \"One\"\nkind = \"allan\"\ntrials = 1\nseed = 9\n[record]\nsample = \"1 s\"\nlength = \"2 h\"\n\
                 [allan]\noverlap = \"full\"\n[noise]\nangle_random_walk = \"0.01 deg/sqrt(h)\"\nreadout_lsb = \"0.5 arcsec\"\n";
    desk.write("s.toml", study);
    desk.done("run s.toml --out run");
    desk.done("simulate s.toml --out made");
    desk.done("allan made/record_00000.csv --fit none --tau octave --out found");
    let curve = desk.table("found/curve.csv");
    let points = desk.points("run");
    assert!(points.len() > 5);
    let mut compared = 0;
    for point in points {
        let is_same = |row: &&std::collections::BTreeMap<String, String>| row["tau_s"] == point["tau_s"];
        let Some(row) = curve.iter().find(is_same) else { continue };
        let [found, expected]: [f64; 2] =
            [&row["value"], &point["adev_deg_per_h"]].map(|text| text.parse().unwrap());
        assert!((found / expected - 1.0).abs() < 1e-6, "{}: {found} {expected}", point["tau_s"]);
        compared += 1;
    }
    assert!(compared > 5, "{compared}");
}

#[test]
fn what_cannot_be_simulated_is_refused_with_what_to_give() {
    let desk = desk();
    let study = "title = \"Two\"\nkind = \"allan\"\n[record]\nsample = \"1 s\"\nlength = \"1 h\"\n[noise]\n\
                 angle_random_walk = \"0.01 deg/sqrt(h)\"\n[[sweep]]\nkey = \"noise.angle_random_walk\"\nlist = [\"0.01 deg/sqrt(h)\", \"0.02 deg/sqrt(h)\"]\n";
    desk.write("two.toml", study);
    desk.fails("simulate noise.toml", 2, &["give --rate HZ and --length TIME"]);
    desk.fails("simulate none.toml", 2, &["cannot read none.toml"]);
    desk.fails("simulate two.toml", 2, &["--at KEY=VALUE for noise.angle_random_walk"]);
    desk.fails("simulate two.toml --rate 1Hz", 2, &["are for noise files"]);
    desk.fails(
        "simulate noise.toml --rate 1Hz --length 1s",
        2,
        &["--length \"1 s\" has 1 samples", "accepted: 16 to"],
    );
    desk.fails("simulate two.toml --at angle_random_walk=0.03deg/sqrt(h)", 2, &["the values are"]);
    let twice = "--at angle_random_walk=0.01deg/sqrt(h)";
    desk.fails(&format!("simulate two.toml {twice} {twice}"), 2, &["has a value already"]);
    desk.write("broken.toml", "kind = \"allan");
    desk.fails("simulate broken.toml --rate 1Hz --length 1h", 3, &["broken.toml:1"]);
    let spread = |value: &str| {
        desk.done(&format!("simulate two.toml --at angle_random_walk={value}deg/sqrt(h) --out of_{value}"));
        let rates = numbers(&desk.read(&format!("of_{value}/record_00000.csv")));
        (rates.iter().map(|rate| rate * rate).sum::<f64>() / rates.len() as f64).sqrt()
    };
    let ratio = spread("0.02") / spread("0.01");
    assert!((ratio - 2.0).abs() < 0.1, "{ratio}");
    desk.fails(
        "simulate two.toml --at angle_random_walk=0.02deg/sqrt(h) --out of_0.01",
        2,
        &["of another seed or point"],
    );
    desk.done("simulate two.toml --at angle_random_walk=0.01deg/sqrt(h) --first 1 --out of_0.01");
    assert!(desk.path("of_0.01/record_00000.csv").is_file(), "records that were there stay");
}

/// The columns of a record as text.
fn columns(csv: &str) -> Vec<Vec<f64>> {
    let rows = csv.lines().skip(1).map(|line| line.split(',').map(|cell| cell.parse().unwrap()).collect());
    let rows: Vec<Vec<f64>> = rows.collect();
    (0..rows[0].len()).map(|column| rows.iter().map(|row| row[column]).collect()).collect()
}

const MOTION: &str = "[motion]\ntones = [{ amplitude = \"90 arcsec\", frequency = [\"2 Hz\", \"3 Hz\"] },\n\
                      { amplitude = { uniform = [\"10 arcsec/s\", \"20 arcsec/s\"] }, frequency = \"0.1 Hz\", phase = \"extremum\" }]\n";

#[test]
fn motion_is_added_to_the_noise_and_its_truth_is_written() {
    let desk = desk();
    desk.write("motion.toml", MOTION);
    let record = "simulate noise.toml --rate 50Hz --length 40s --seed 3 --records 2";
    desk.done(&format!("{record} --out still"));
    desk.done(&format!("{record} --motion motion.toml --truth --out moving"));
    for number in 0..2 {
        let name = format!("record_{number:05}");
        let csv = desk.read(&format!("moving/{name}.csv"));
        assert!(csv.starts_with("time [s],rate [deg/h],true_rate [deg/h]\n"), "{}", &csv[..60]);
        let found = columns(&csv);
        let still = numbers(&desk.read(&format!("still/{name}.csv")));
        let tones = desk.table(&format!("moving/{name}_tones.csv"));
        let value = |tone: usize, column: &str| tones[tone][column].parse::<f64>().unwrap();
        assert!((2.0..3.0).contains(&value(0, "frequency_hz")) && value(1, "phase_deg") == 90.0);
        let amplitude =
            value(0, "amplitude_arcsec_per_s") / (std::f64::consts::TAU * value(0, "frequency_hz"));
        assert!((amplitude - 90.0).abs() < 1e-9, "{amplitude}");
        for sample in 0..2000 {
            let motion = found[2][sample];
            assert!((found[1][sample] - still[sample] - motion).abs() < 1e-6, "{sample}");
            // The mean of a sine over a sample is that in its middle times a sinc.
            let middle_s = (sample as f64 + 0.5) / 50.0;
            let sine = |tone: usize| {
                let half = std::f64::consts::PI * value(tone, "frequency_hz") / 50.0;
                let turns = value(tone, "frequency_hz") * middle_s + value(tone, "phase_deg") / 360.0;
                value(tone, "amplitude_arcsec_per_s") * half.sin() / half
                    * (std::f64::consts::TAU * turns).sin()
            };
            assert!((motion - sine(0) - sine(1)).abs() < 1e-5, "{sample}: {motion}");
        }
    }
    let sidecar = desk.read("moving/simulated.toml");
    assert!(
        sidecar.contains("# The base turns by the motion of motion.toml") && sidecar.contains("# tones = [{")
    );
    desk.fails(&format!("{record} --motion motion.toml --out still"), 2, &["give another folder"]);
    desk.fails(&format!("{record} --motion none.toml --out none"), 2, &["cannot read the motion none.toml"]);
    desk.fails(
        &format!("{record} --motion x=motion.toml --motion motion.toml --out none"),
        2,
        &["two motions"],
    );
    desk.fails(&format!("{record} --motion y=motion.toml --out none"), 2, &["give --axes 3"]);
    desk.write("bad.toml", "amplitude = \"3 arcsec\"\nfrequency = \"1 kHz\"\n");
    desk.fails(
        &format!("{record} --motion bad.toml --out none"),
        3,
        &["bad.toml:2", "ten times the sampling rate"],
    );
}

#[test]
fn pulses_give_the_quantization_of_their_size() {
    let desk = desk();
    desk.write("pulses.toml", "angle_random_walk = \"0.01 deg/sqrt(h)\"\nreadout_lsb = \"0.5 arcsec\"\n");
    desk.write("turn.toml", "rate = \"15.041 deg/h\"\n");
    let record = "simulate pulses.toml --rate 20Hz --length 10min --seed 4 --data pulses --motion turn.toml";
    desk.done(&format!("{record} --records 20 --out all"));
    let csv = desk.read("all/record_00000.csv");
    assert!(csv.starts_with("time [s],pulses [0.5 arcsec/pulse]\n"), "{}", &csv[..60]);
    let pulses = numbers(&csv);
    assert!(pulses.iter().all(|pulses| pulses.fract() == 0.0));
    let turned = 0.5 * pulses.iter().sum::<f64>();
    assert!((turned - 15.041 * 600.0).abs() < 100.0, "{turned}");
    let mut within = 0;
    for record in 0..20 {
        desk.done(&format!(
            "allan all/record_{record:05}.csv --data increment --bootstrap 0 --fit Q,N --out out"
        ));
        let coefficients = desk.table("out/coefficients.csv");
        let row = coefficients.iter().find(|row| row["coefficient"] == "Q").unwrap();
        let end = |name: &str| row[name].parse::<f64>().unwrap();
        within += usize::from((end("lower")..=end("upper")).contains(&(0.5 / 12_f64.sqrt())));
    }
    // 99.9 % of 20 draws of 95 % are 15 or more.
    assert!(within >= 15, "{within}");
    desk.fails("simulate noise.toml --rate 1Hz --length 1h --data pulses", 2, &["readout_lsb"]);
}

#[test]
fn three_axes_have_noise_of_their_own_and_sense_the_motion_of_the_others() {
    let desk = desk();
    desk.write("spin.toml", "rate = \"100 deg/s\"\n");
    desk.write("sway.toml", "amplitude = \"3 deg/s\"\nfrequency = \"1 Hz\"\n");
    let record = "simulate noise.toml --rate 20Hz --length 30s --seed 3";
    desk.done(&format!("{record} --records 6 --out single"));
    desk.done(&format!("{record} --axes 3 --records 2 --out three"));
    let single = |number: usize| numbers(&desk.read(&format!("single/record_{number:05}.csv")));
    let three = columns(&desk.read("three/record_00001.csv"));
    assert_eq!(three[1..], [single(3), single(4), single(5)]);
    let moving = "--motion spin.toml --motion y=sway.toml --misalignment xz=10arcsec,yx=-1deg,xy=2mrad --scale-factor z=50ppm,x=-0.1%";
    desk.done(&format!("{record} --axes 3 --first 1 {moving} --truth --out moving"));
    let moving_text = desk.read("moving/record_00001.csv");
    let title =
        "time [s],rate_x [deg/h],rate_y [deg/h],rate_z [deg/h],true_rate_y [deg/h],true_rate_z [deg/h]";
    assert!(moving_text.starts_with(title), "{}", &moving_text[..99]);
    let found = columns(&moving_text);
    let arcsec = (1.0_f64 / 3600.0).to_radians();
    for sample in 0..600 {
        let [y, z] = [found[4][sample], found[5][sample]];
        assert!((z - 360_000.0).abs() < 1e-6, "{z}");
        let turned = [(1.0 - 1e-3) * (2e-3 * y + 10.0 * arcsec * z), y, (1.0 + 50e-6) * z];
        for axis in 0..3 {
            let found = found[1 + axis][sample] - three[1 + axis][sample];
            assert!((found - turned[axis]).abs() < 1e-4, "{axis} {sample}: {found}, not {}", turned[axis]);
        }
    }
    desk.done(&format!("{record} --axes 3 --records 2 --form mcap --out ros"));
    for (axis, column) in ["gx", "gy", "gz"].into_iter().enumerate() {
        desk.done(&format!(
            "allan ros/record_00001.mcap --column {column} --bootstrap 0 --fit none --out of_ros"
        ));
        desk.done(&format!("allan single/record_{:05}.csv --bootstrap 0 --fit none --out of_csv", 3 + axis));
        let curve = |out: &str| -> Vec<f64> {
            desk.table(&format!("{out}/curve.csv")).iter().map(|row| row["value"].parse().unwrap()).collect()
        };
        let (ros, csv) = (curve("of_ros"), curve("of_csv"));
        assert!(
            ros.len() == csv.len() && ros.iter().zip(&csv).all(|(a, b)| (a / b - 1.0).abs() < 1e-9),
            "{column}"
        );
    }
    desk.fails(
        &format!("{record} --axes 3 --misalignment xy=10arcsec --out none"),
        2,
        &["give --motion FILE"],
    );
    desk.fails(&format!("{record} --axes 3 --misalignment xx=10arcsec --out none"), 2, &["xy=10arcsec"]);
    desk.fails(&format!("{record} --axes 3 --scale-factor x=2 --out none"), 2, &["ppm"]);
}

#[test]
fn a_dependence_on_temperature_is_recovered() {
    let desk = desk();
    let warm = "--temperature 20..60 --temperature-coefficient 0.02deg/h/K";
    desk.done(&format!("simulate noise.toml --rate 1Hz --length 4h --seed 3 {warm} --out warm"));
    desk.done("simulate noise.toml --rate 1Hz --length 4h --seed 3 --out cold");
    let csv = desk.read("warm/record_00000.csv");
    assert!(csv.starts_with("time [s],rate [deg/h],temperature [degC]\n"), "{}", &csv[..60]);
    let (warm, cold) = (columns(&csv), numbers(&desk.read("cold/record_00000.csv")));
    for sample in 0..14_400 {
        let temperature = warm[2][sample];
        let expected = 20.0 + 40.0 * (sample as f64 + 0.5) / 14_400.0;
        assert!((temperature - expected).abs() < 1e-9, "{sample}");
        let added = warm[1][sample] - cold[sample];
        assert!((added - 0.02 * (temperature - 20.0)).abs() < 1e-6, "{sample}: {added}");
    }
    desk.write("quiet.toml", "angle_random_walk = \"0.001 deg/sqrt(h)\"\n");
    desk.done(
        "simulate quiet.toml --rate 1Hz --length 4h --temperature 20..60 --temperature-coefficient 0.02deg/h/K --out quiet",
    );
    desk.done("allan quiet/record_00000.csv --column rate --temperature temperature --bootstrap 0 --fit N --out found");
    let rows = desk.table("found/temperature.csv");
    let row = rows.iter().find(|row| row["coefficient"] == "T").unwrap_or_else(|| panic!("{rows:?}"));
    let value = |name: &str| row[name].parse::<f64>().unwrap_or_else(|_| panic!("{row:?}"));
    assert!((value("value") - 0.02).abs() < 5e-4, "{row:?}");
    assert!((value("lower")..=value("upper")).contains(&0.02), "{row:?}");
}

#[test]
fn a_gap_fill_study_gives_its_ticks() {
    let desk = desk();
    let study = "title = \"Gap\"\nkind = \"gap-fill\"\nseed = 4\n[gyro]\ntick = \"5 ms\"\ntick_noise = { std = \"0.5 arcsec\" }\n\
                 [motion]\namplitude = \"12000 arcsec/s\"\nfrequency = \"20 Hz\"\n[switching]\ngap_ticks = 3\nfillers = [\"const\"]\n\
                 errors = [\"residual\"]\n[[sweep]]\nkey = \"motion.frequency\"\nlist = [\"10 Hz\", \"20 Hz\"]\n";
    desk.write("gap.toml", study);
    desk.done("simulate gap.toml --at frequency=10Hz --length 20s --data increment --truth --out made");
    let found = columns(&desk.read("made/record_00000.csv"));
    assert_eq!(found[1].len(), 4000);
    let rms = |numbers: &mut dyn Iterator<Item = f64>| (numbers.map(|x| x * x).sum::<f64>() / 4000.0).sqrt();
    let noise = rms(&mut found[1].iter().zip(&found[2]).map(|(read, truth)| read - truth));
    assert!((noise - 0.5).abs() < 0.03, "{noise}");
    // A_Ω T sinc(νT)/√2.
    let half = std::f64::consts::PI * 0.05;
    let expected = 12000.0 * 0.005 * half.sin() / half / 2_f64.sqrt();
    let motion = rms(&mut found[2].iter().copied());
    assert!((motion / expected - 1.0).abs() < 1e-6, "{motion}, not {expected}");
    assert_eq!(desk.table("made/record_00000_tones.csv")[0]["frequency_hz"], "10");
    desk.fails("simulate gap.toml --at frequency=10Hz --out none", 2, &["give --length TIME"]);
    desk.fails("simulate gap.toml --length 9s --out none", 2, &["--at KEY=VALUE for motion.frequency"]);
}

/// The rows of a record with its columns, in which samples may be lost.
fn rows(csv: &str) -> Vec<Vec<f64>> {
    csv.lines().skip(1).map(|line| line.split(',').map(|cell| cell.parse().unwrap()).collect()).collect()
}

#[test]
fn gaps_are_filled_as_well_as_the_table_of_their_study_says() {
    let desk = Desk::with("");
    desk.write("smoke.toml", include_str!("../../studies/smoke.toml"));
    desk.done("run smoke.toml --trials 200000 --out run");
    // 6.1 turns of 20 Hz.
    let gaps = "--at gap_ticks=3 --switch-every 0.305s --length 0.7s";
    desk.done(&format!("simulate smoke.toml {gaps} --records 600 --truth --data increment --out made"));
    let weights = [("const", [0.75; 4]), ("quadratic", [-1.0, 2.5, 2.5, -1.0])];
    let mut squares = [vec![], vec![]];
    for number in 0..600 {
        let rows = rows(&desk.read(&format!("made/record_{number:05}.csv")));
        for ((_, weights), squares) in weights.iter().zip(&mut squares) {
            let square = |gap: usize| {
                assert!(rows[gap - 1][1].is_finite() && rows[gap + 3][1].is_finite(), "{number} {gap}");
                assert!(rows[gap..gap + 3].iter().all(|row| row[1].is_nan() && row[2].is_finite()));
                let ticks = [gap - 2, gap - 1, gap + 3, gap + 4];
                let filled: f64 =
                    ticks.iter().zip(weights).map(|(tick, weight)| weight * rows[*tick][1]).sum();
                let turned: f64 = rows[gap..gap + 3].iter().map(|row| row[2]).sum();
                (filled - turned) * (filled - turned)
            };
            squares.push(0.5 * (square(61) + square(122)));
        }
    }
    let points = desk.points("run");
    for ((filler, _), squares) in weights.iter().zip(&squares) {
        let is_row = |row: &&std::collections::BTreeMap<String, String>| {
            row["filler"] == *filler && row["error"] == "residual" && row["switching.gap_ticks"] == "3"
        };
        let expected: f64 = points.iter().find(is_row).unwrap()["rms_arcsec"].parse().unwrap();
        let mean = squares.iter().sum::<f64>() / 600.0;
        let variance = squares.iter().map(|square| (square - mean) * (square - mean)).sum::<f64>() / 599.0;
        let z = (mean - expected * expected) / (variance / 600.0).sqrt();
        assert!(z.abs() < 4.0, "{filler}: {} ″, not {expected} ″: {z}", mean.sqrt());
    }
}

#[test]
fn a_record_with_switches_is_the_one_without_them_but_for_gaps_and_relock() {
    let desk = Desk::with("");
    desk.write("smoke.toml", include_str!("../../studies/smoke.toml"));
    let record = "simulate smoke.toml --at gap_ticks=2 --length 9s --seed 5";
    desk.done(&format!("{record} --truth --data increment --out still"));
    desk.done(&format!("{record} --truth --data increment --switch-every 2s --out switched"));
    let [still, switched] =
        ["still", "switched"].map(|folder| rows(&desk.read(&format!("{folder}/record_00000.csv"))));
    for (sample, (still, switched)) in still.iter().zip(&switched).enumerate() {
        assert_eq!([still[0], still[2]], [switched[0], switched[2]], "{sample}");
        let added = match (sample / 400, sample % 400) {
            (1.., 0 | 1) => f64::NAN,
            (1.., 2) => 3.0,
            (1.., 3) => 1.0,
            _ => 0.0,
        };
        let found = switched[1] - still[1];
        // Where a whole number of pulses is added, each boundary falls at the same place in its pulse.
        assert!((found - added).abs() < 1e-6 || found.is_nan() && added.is_nan(), "{sample}: {found}");
    }
    let sidecar = desk.read("switched/simulated.toml");
    assert!(sidecar.contains("# The modes switch after every 400 samples, and the next 2 are lost: NaN."));
    for form in ["csv", "npz", "mat", "h5", "mcap"] {
        desk.done(&format!("{record} --switch-every 2s --form {form} --out {form}"));
        let column = if form == "mcap" { "--column gz" } else { "" };
        desk.done(&format!(
            "allan {form}/record_00000.{form} {column} --bootstrap 0 --fit none --out of_{form}"
        ));
        let curve = |form: &str| -> Vec<f64> {
            let curve = desk.table(&format!("of_{form}/curve.csv"));
            curve.iter().map(|row| row["value"].parse().unwrap()).collect()
        };
        let (found, expected) = (curve(form), curve("csv"));
        assert_eq!(found.len(), expected.len(), "{form}");
        assert!(found.iter().zip(&expected).all(|(a, b)| (a / b - 1.0).abs() < 1e-9), "{form}");
    }
    let refused =
        |more: &str, code: i32, why: &str| desk.fails(&format!("{record} {more} --out none"), code, &[why]);
    refused("--switch-every 15ms", 2, "accepted: 0.02 s to 8.995 s");
    refused("--switch-every 9s", 2, "accepted: 0.02 s to 8.995 s");
    refused("--switch-every 2s --data angle", 2, "is not known after a gap");
    desk.write("noise.toml", NOISE);
    desk.fails(
        &format!("{RECORD} --switch-every 2s --out none"),
        2,
        &["--switch-every TIME is for gap-fill"],
    );
}

#[test]
fn a_run_gives_its_ticks_with_its_switches_relock_and_drift() {
    let desk = Desk::with("");
    let study = "title = \"Run\"\nkind = \"switched-run\"\nseed = 8\n[gyro]\ntick = \"5 ms\"\ntick_noise = { std = \"0.001 arcsec\" }\n\
                 [motion]\namplitude = \"12000 arcsec/s\"\nfrequency = \"20 Hz\"\n\
                 [drift]\nmagnetic = \"14 arcsec/s\"\nmagnetic_spread = \"1 arcsec/s\"\nwarm_up_time = \"300 s\"\nwarm_up_time_spread = \"5 %\"\n\
                 non_magnetic = \"0.5 arcsec/s\"\ninitial_magnetic = \"1 arcsec/s\"\n\
                 [relock]\ninitial_detuning = 0.0591\nloop_time = \"12 ms\"\nbias_frequency = \"80 kHz\"\npulse_weight = \"2.6 arcsec\"\n\
                 curvature = 40\nticks = 8\n[switching]\ninterval = \"5 s\"\ngap_ticks = 3\nfillers = [\"quadratic\"]\nfirst_mode = \"random\"\n\
                 [run]\nduration = \"18 s\"\n";
    desk.write("run.toml", study);
    desk.done("simulate run.toml --records 40 --truth --data increment --out made");
    let mut drawn = vec![];
    for number in 0..40 {
        let rows = rows(&desk.read(&format!("made/record_{number:05}.csv")));
        assert_eq!(rows.len(), 3600);
        let drift = &desk.table(&format!("made/record_{number:05}_drift.csv"))[0];
        let value = |name: &str| drift[name].parse::<f64>().unwrap();
        let [first_mode, magnetic] = ["first_mode", "magnetic_arcsec_per_s"].map(value);
        drawn.push([first_mode, magnetic]);
        for (sample, row) in rows.iter().enumerate() {
            let place = sample % 1000;
            if sample >= 1000 && place < 3 {
                assert!(row[1].is_nan());
                continue;
            }
            let t = 0.005 * (sample as f64 + 0.5);
            let warm = magnetic * (1.0 - (-t / value("warm_up_time_s")).exp())
                + value("initial_magnetic_arcsec_per_s");
            let sign = if (sample / 1000).is_multiple_of(2) { first_mode } else { -first_mode };
            // Z(11), with f0 = 80 kHz · 2.6 ″.
            let relocked = match place.checked_sub(3) {
                Some(tick @ 0..8) if sample >= 1000 => {
                    let q = |ticks: f64| (-ticks * 0.005 / 0.012_f64).exp();
                    40.0 * 208_000.0
                        * 0.0591
                        * 0.0591
                        * 0.006
                        * q(2.0 * tick as f64)
                        * (1.0 - q(1.0))
                        * (1.0 - q(1.0))
                }
                _ => 0.0,
            };
            let expected = 0.005 * (sign * warm + value("non_magnetic_arcsec_per_s")) + relocked;
            let found = row[1] - row[2];
            assert!((found - expected).abs() < 0.0065, "{number} {sample}: {found}, not {expected}");
        }
    }
    let negative = drawn.iter().filter(|[mode, _]| *mode < 0.0).count();
    assert!((8..=32).contains(&negative), "{negative}");
    let mean = drawn.iter().map(|[_, magnetic]| magnetic).sum::<f64>() / 40.0;
    let variance =
        drawn.iter().map(|[_, magnetic]| (magnetic - mean) * (magnetic - mean)).sum::<f64>() / 39.0;
    // Four standard errors.
    assert!((mean - 14.0).abs() < 0.64 && (variance - 1.0).abs() < 0.91, "{mean} {variance}");
    desk.fails(
        "simulate run.toml --switch-every 5s --out none",
        2,
        &["has `gyro.tick` and `switching.interval`"],
    );
    let (before, after) = (study.find("[gyro]").unwrap(), study.find("[drift]").unwrap());
    let relock = study.find("[relock]").unwrap();
    let bare = format!(
        "{}{}[switching]\ninterval = \"5 s\"\n[run]\nduration = \"18 s\"\n",
        &study[..before],
        &study[after..relock]
    );
    desk.write("bare.toml", &bare);
    desk.fails("simulate bare.toml --out none", 2, &["no fillers", "switching.fillers"]);
}

#[test]
fn a_study_of_lock_in_gives_the_pulses_of_its_gyros_on_a_moving_base() {
    let desk = Desk::with("");
    let study = "title = \"Lock-in\"\nkind = \"lock-in\"\ntrials = 2\n[gyro]\nscale_factor = \"2 arcsec/pulse\"\n\
                 [record]\nlength = \"10 s\"\n";
    let threshold = |arcsec_per_s: u32| format!("[lock_in]\nthreshold = \"{arcsec_per_s} arcsec/s\"\n");
    let rates = "[[sweep]]\nkey = \"input.rate\"\nlist = [\"100 arcsec/s\", \"300 arcsec/s\"]\n";
    desk.write("static.toml", &format!("{study}{}{rates}", threshold(180)));
    // Locked, and √(300² − 180²) ″/s.
    for (rate, expected) in [(100, 0.0), (300, 240.0)] {
        desk.done(&format!(
            "simulate static.toml --at input.rate={rate}arcsec/s --data pulses --out of_{rate}"
        ));
        let pulses = numbers(&desk.read(&format!("of_{rate}/record_00000.csv")));
        assert!(pulses.len() == 1000 && pulses.iter().all(|pulses| pulses.fract() == 0.0));
        let turned = 2.0 * pulses.iter().sum::<f64>();
        assert!((turned - 10.0 * expected).abs() <= 4.0, "{rate}: {turned}");
    }
    let dither = "[dither]\nfrequency = \"400 Hz\"\nrate = \"100 deg/s\"\namplitude_noise = \"2 %\"\n[input]\nrate = \"37 arcsec/s\"\n";
    let tone = "[motion]\namplitude = \"500 arcsec/s\"\nfrequency = \"1.3 Hz\"\nphase = \"extremum\"\n";
    desk.write("moving.toml", &format!("{study}{}{dither}{tone}", threshold(1800)));
    desk.done("simulate moving.toml --records 40 --truth --data increment --out moving");
    let mut squares = vec![];
    for number in 0..40 {
        let found = columns(&desk.read(&format!("moving/record_{number:05}.csv")));
        let tau = std::f64::consts::TAU * 1.3;
        let angle = |t: f64| 37.0 * t + 500.0 / tau * (tau * t).sin();
        for (sample, truth) in found[2].iter().enumerate() {
            let expected = angle((sample as f64 + 1.0) / 400.0) - angle(sample as f64 / 400.0);
            assert!((truth - expected).abs() < 1e-6, "{number} {sample}: {truth}, not {expected}");
        }
        let errors: Vec<f64> = found[1].iter().zip(&found[2]).map(|(read, truth)| read - truth).collect();
        squares.extend(errors.chunks(400).map(|second| second.iter().sum::<f64>().powi(2)));
    }
    let mean = squares.iter().sum::<f64>() / squares.len() as f64;
    // N² = Ω_L² q/(2π Ω_D) in a second, and the fractions of a pulse at both ends.
    let expected = 1800.0 * 1800.0 * 2.0 / (std::f64::consts::TAU * 360_000.0) + 2.0 * 4.0 / 12.0;
    // Four standard errors.
    assert!((mean / expected - 1.0).abs() < 4.0 * (2.0 / 400_f64).sqrt(), "{mean}, not {expected}");
    let profile: String = (0..=2000)
        .map(|k| format!("{},{}\n", 0.01 * f64::from(k), 300.0 * (0.05 * f64::from(k)).sin()))
        .collect();
    desk.write("base.csv", &format!("time [s],rate [arcsec/s]\n{profile}"));
    desk.write(
        "profile.toml",
        &format!("{study}{}{dither}[motion]\nprofile = {{ file = \"base.csv\" }}\n", threshold(1800)),
    );
    desk.done("simulate profile.toml --records 2 --truth --data increment --out profile");
    let [first, second] =
        [0, 1].map(|number| columns(&desk.read(&format!("profile/record_0000{number}.csv"))));
    assert!(first[2] == second[2] && first[1] != second[1], "all gyros have the same motion");
    desk.fails("simulate moving.toml --motion none.toml --out none", 2, &["cannot read the motion"]);
    desk.fails("simulate moving.toml --axes 3 --out none", 2, &["has its own times and input"]);
}

#[test]
fn files_that_a_motion_or_a_study_names_are_not_replaced() {
    let desk = desk();
    desk.done("simulate noise.toml --rate 50Hz --length 20s --out lab");
    let profile = "profile = { file = \"lab/record_00000.csv\" }\n";
    desk.write("motion.toml", profile);
    let study = "title = \"Gap\"\nkind = \"gap-fill\"\n[gyro]\ntick = \"20 ms\"\ntick_noise = { std = \"0.5 arcsec\" }\n\
                 [switching]\ngap_ticks = 3\nfillers = [\"const\"]\n[motion]\n";
    desk.write("gap.toml", &format!("{study}{profile}"));
    std::fs::remove_file(desk.path("lab/simulated.toml")).unwrap();
    let before = desk.read("lab/record_00000.csv");
    let why = ["lab/record_00000.csv is read by this command", "write to another folder"];
    desk.fails("simulate noise.toml --rate 50Hz --length 10s --motion motion.toml --out lab", 6, &why);
    desk.fails("simulate gap.toml --length 10s --out lab", 6, &why);
    assert_eq!(desk.read("lab/record_00000.csv"), before);
}

#[test]
fn long_records_are_refused_only_where_their_noise_cannot_be_made() {
    let desk = desk();
    let long = |noise: &str| {
        desk.write("long.toml", noise);
        "simulate long.toml --rate 1kHz --length 1000000s --records 1"
    };
    desk.fails(long("bias_instability = \"1 deg/h\"\n"), 3, &["noise.bias_instability", "2^27 samples"]);
    let ramp = "rate_ramp = \"1 deg/h/h\"\nangle_random_walk = \"0.1 deg/sqrt(h)\"\n";
    desk.fails(long(ramp), 3, &["too long for a ramp", "2^26 samples"]);
    desk.fails(
        "simulate long.toml --rate 1kHz --length 10000000s",
        2,
        &["accepted: 16 to 2147483584 samples"],
    );
}

#[test]
fn records_that_a_gpu_makes_are_those_of_the_processor_byte_for_byte() {
    let desk = desk();
    let noise = format!("{NOISE}bias_instability = \"1 deg/h\"\nreadout_lsb = \"0.5 arcsec\"\n");
    desk.write("full.toml", &noise);
    desk.write("motion.toml", "rate = \"40 deg/h\"\n");
    let command = "simulate full.toml --rate 10Hz --length 20min --records 3 --axes 3 --motion motion.toml";
    for form in ["csv", "npz"] {
        for device in ["cpu", "gpu"] {
            let ended =
                desk.done(&format!("{command} --form {form} --device {device} --out {form}_{device}"));
            assert!(!ended.stderr.contains("0 of 3"), "nothing is done yet: {}", ended.stderr);
        }
        for number in 0..3 {
            let read = |device: &str| {
                std::fs::read(desk.path(&format!("{form}_{device}/record_0000{number}.{form}"))).unwrap()
            };
            assert!(read("gpu") == read("cpu"), "record {number} as {form}");
        }
    }
    let unknown = "no device is called `abacus`; the devices are auto, cpu";
    desk.fails(&format!("{command} --device abacus --out none"), 2, &[unknown]);
    desk.fails(&format!("{command} --device gpu:99 --out none"), 2, &["no device is called `gpu:99`"]);
}
