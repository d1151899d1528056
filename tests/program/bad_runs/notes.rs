//! What a run says of itself: what it assumes, what it leaves out, and how it shows gyros side by side.

use super::{FILLED, replaced, swept};
use crate::desk::{Desk, unwrapped};

/// FILLED with a random vibration of the base on the suspension of one of two gyros.
fn shaken() -> String {
    let tone = "amplitude = \"12000 arcsec/s\"\nfrequency = \"20 Hz\"\n";
    let vibration = "suspension = { random = { psd = [[\"20 Hz\", \"0.01 g^2/Hz\"], [\"80 Hz\", \"0.01 g^2/Hz\"]] }, \
                     alias = true }\n";
    swept(&replaced(FILLED, tone, vibration), "motion.suspension.gyro", "[\"LGK-400\", \"LGV-1\"]")
}

#[test]
fn a_sweep_over_names_alone_has_the_fillers_side_by_side_and_is_no_axis_beside_another() {
    let gap_fill =
        replaced(&replaced(&shaken(), "[run]\nduration = \"10 min\"\n", ""), "interval = \"40 s\"\n", "");
    let gap_fill = replaced(&gap_fill, "switched-run", "gap-fill");
    for (text, swept_key, values) in [
        (shaken(), "switching.interval", "[\"20 s\", \"40 s\"]"),
        (gap_fill, "switching.gap_ticks", "[1, 2]"),
    ] {
        let desk = Desk::with(&text);
        let ended = desk.done("run study.toml --device cpu --trials 200");
        for piece in ["LGK-400", "LGV-1", "const", "quadratic"] {
            assert!(ended.stdout.contains(piece), "{piece} is missing in\n{}", ended.stdout);
        }
        let svg = desk.read("results/study/chart.svg");
        assert!(svg.contains(">const<") && svg.contains("LGK-400") && svg.contains("LGV-1"), "{svg}");
        desk.write("two.toml", &swept(&text, swept_key, values));
        desk.done("run two.toml --device cpu --trials 200");
        let svg = desk.read("results/two/chart.svg");
        assert!(svg.contains("LGK-400") && svg.contains("LGV-1"), "the gyros are no curves");
    }
}

/// The notes of a study.
fn noted(text: &str) -> String {
    let desk = Desk::with(text);
    unwrapped(&desk.done("run study.toml --device cpu --trials 100").stderr)
}

#[test]
fn what_is_assumed_of_suspensions_and_residuals_is_said() {
    let assumed = "Q factors and responses of the suspension of LGK-400 and LGV-1 are assumed";
    let independent = "independent from switch to switch, whatever switching.timing says";
    let said = noted(&shaken());
    assert!(said.contains(assumed) && !said.contains(independent), "{said}");
    let said = noted(&replaced(&shaken(), "interval", "timing = \"periodic\"\ninterval"));
    assert!(said.contains(&format!("residuals of Gaussian motion are taken as {independent}")), "{said}");
    let drawn = noted(&replaced(FILLED, "\"20 Hz\"", "[\"18 Hz\", \"22 Hz\"]"));
    assert!(drawn.contains("are taken as normally distributed") && drawn.contains(independent), "{drawn}");
    let said = noted(FILLED);
    assert!(!said.contains("assumed") && !said.contains(independent), "{said}");
}

#[test]
fn switches_in_the_noise_are_left_out_and_that_is_said() {
    let noise = "[noise]\nangle_random_walk = \"0.003 deg/sqrt(h)\"\nswitching = { interval = \"40 s\", residual = \"10 \
                 arcsec\" }\n";
    let filled = replaced(FILLED, "tick_noise = { three_sigma = \"1.6 arcsec\" }\n", "");
    let said = noted(&format!("{filled}{noise}"));
    assert!(said.contains("left out") && said.contains("fill residuals (7.1″)"), "{said}");
    let gap_fill = replaced(&replaced(&filled, "switched-run", "gap-fill"), "interval = \"40 s\"\n", "");
    let said = noted(&format!("{}{noise}", replaced(&gap_fill, "[run]\nduration = \"10 min\"\n", "")));
    assert!(said.contains("left out") && said.contains("fill residuals (7.1″)"), "{said}");
}
