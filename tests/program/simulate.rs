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
    for form in ["npz", "mat", "mcap"] {
        desk.done(&format!("{RECORD} --seed 3 --first 7 --form {form} --out {form}"));
        let column = if form == "mcap" { "--column gz" } else { "" };
        desk.done(&format!(
            "allan {form}/record_00007.{form} {column} --bootstrap 0 --fit none --out of_{form}"
        ));
    }
    desk.done("allan all/record_00007.csv --bootstrap 0 --fit none --out of_csv");
    for form in ["npz", "mat", "mcap"] {
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
