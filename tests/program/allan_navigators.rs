//! `sagnac allan --navigate`: from a log to the position error of navigators with its gyro, in one command.

use rand::SeedableRng;
use rand::rngs::StdRng;
use sagnac::theory::allan::{Part, Process};
use serde_json::Value;

use crate::desk::{Desk, rows_of, unwrapped};
use crate::logs::desk_with;

/// N = 0.0288 ″/√s.
const WHITE: [Part; 1] = [Part::angle_random_walk(0.0288)];

const READ: &str = "allan gyro.csv --data rate --rate 1Hz --bootstrap 0 --out out";

/// Nine hours of rates in °/h at 1 Hz, with a column of accelerations beside them.
fn desk() -> Desk {
    let process = Process { sample_s: 1.0, parts: WHITE.to_vec() };
    let angles = crate::noise::record(&process, 32_400, &mut StdRng::seed_from_u64(5));
    let rows = angles
        .windows(2)
        .map(|pair| format!("{},{}\n", pair[1] - pair[0], 9.81 + 1e-4 * (pair[1] - pair[0])));
    desk_with("gyro.csv", format!("gz [deg/h],az [m/s2]\n{}", rows.collect::<String>()))
}

fn json(desk: &Desk, time: &str) -> Value {
    serde_json::from_str(&desk.done(&format!("{READ} --column gz --navigate {time} --json")).stdout).unwrap()
}

fn within(document: &Value) -> f64 {
    rows_of(document, "navigation")[0]["p95"].as_f64().unwrap()
}

#[test]
fn one_command_leads_from_a_log_to_the_position_error_and_its_study_gives_the_same() {
    let desk = desk();
    let ended = desk.done(&format!("{READ} --column gz --navigate 1h"));
    assert!(ended.stdout.contains(" nmi R95 after 1 h (0."), "{}", ended.stdout);
    assert!(ended.stdout.contains("At upper limits") && ended.stdout.contains(" CEP "), "{}", ended.stdout);
    assert!(desk.read("out/report.html").contains(" nmi R95 after 1 h (0."));
    let document = json(&desk, "1h");
    let navigation = &rows_of(&document, "navigation")[0];
    assert_eq!(document["answer"]["value"]["value"], navigation["p95"]);
    assert_eq!(navigation["unit"], "nmi");
    assert_eq!(navigation["class"], "navigation");
    assert!(
        ended.stdout.lines().any(|line| line.starts_with("▸ gz") && line.ends_with(" navigation")),
        "{}",
        ended.stdout
    );
    // Of a circle 2.4 times, of errors in one direction 2.9 times.
    let ratio = within(&document) / navigation["cep"].as_f64().unwrap();
    assert!((1.9..3.2).contains(&ratio), "{ratio}");
    assert!(navigation["p95_at_bounds"].as_f64().unwrap() > within(&document), "{navigation}");
    assert_eq!(document["answer"]["status"]["is"], "no_limit");
    // The study that was written gives the same value.
    desk.done("run out/navigation.toml --device cpu --out study");
    let row = desk.table("study/points.csv").remove(0);
    let value: f64 = row["position_p95_nmi"].parse().unwrap();
    assert!((value - within(&document)).abs() < 1e-8, "{value} against {navigation}");
    // A longer time is worse; the oscillation of 84 min leaves less than the power 3/2 of white noise.
    let longer = json(&desk, "4h");
    let ratio = within(&longer) / within(&document);
    assert!((2.0..8.0).contains(&ratio), "{ratio}");
    let judged = |limit: &str| {
        let asked = format!("{READ} --column gz --navigate 1h --position-limit {limit} --json");
        let document: Value = serde_json::from_str(&desk.done(&asked).stdout).unwrap();
        document["answer"]["status"]["is"].clone()
    };
    assert_eq!([judged("1nmi"), judged("0.05nmi")], ["met", "not_met"]);
    assert!(desk.read("out/navigation.toml").contains("limit = \"0.05 nmi\""));
    // A limit on a coefficient asks for its decision.
    let both = desk.done(&format!("{READ} --column gz --navigate 1h --limit N=1deg/sqrt(h)"));
    assert!(both.stdout.contains("meets the 1 °/√h limit"), "{}", both.stdout);
    assert!(desk.read("out/report.html").contains(" nmi R95 after 1 h (0."));
    // With a limit on the position too, it is that of the position.
    let limits = "--limit N=1deg/sqrt(h) --position-limit 1nmi";
    let both = desk.done(&format!("{READ} --column gz --navigate 1h {limits}"));
    assert!(both.stdout.contains("met · limit 1 nmi"), "{}", both.stdout);
    // Without the option the study of an earlier run is not left beside other results.
    desk.done(&format!("{READ} --column gz"));
    assert!(!desk.names("out").contains(&"navigation.toml".to_owned()));
}

#[test]
fn columns_that_are_no_gyros_say_so_and_a_fit_is_needed() {
    let desk = desk();
    let ended = desk.done(&format!("{READ} --column gz,az --unit deg/h,m/s^2 --navigate 1h"));
    assert!(unwrapped(&ended.stdout).contains("az: no navigator: it is not a gyro"), "{}", ended.stdout);
    assert!(desk.names("out").contains(&"navigation_gz.toml".to_owned()), "{:?}", desk.names("out"));
    desk.fails(
        &format!("{READ} --column gz --fit none --navigate 1h"),
        2,
        &["--navigate needs coefficients"],
    );
    desk.fails(
        &format!("{READ} --column gz --navigate 1h --position-limit 5deg"),
        2,
        &["--position-limit", "a distance"],
    );
}
