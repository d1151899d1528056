//! The files that `sagnac model` writes for tools: read back, their densities give the Allan deviation of the model at τ = 1 s to 1 %.

use std::process::Command;

use sagnac::analysis::model::writers::WRITERS;
use serde_json::Value;

use crate::desk::Desk;
use crate::logs::desk_with;

/// What a file says of its first gyro, in rad and s: N, K, and the σ and T of Markov states.
#[derive(Debug, Default)]
struct Read {
    white: f64,
    walk: f64,
    markov: Vec<[f64; 2]>,
}

impl Read {
    fn new(white: f64, walk: f64, state: Option<[f64; 2]>) -> Read {
        Read { white, walk, markov: state.into_iter().collect() }
    }

    fn deviation(&self, tau: f64) -> f64 {
        let of_state = |[sigma, time]: &[f64; 2]| {
            let z = tau / time;
            let bracket = if z < 1e-3 {
                z * z * z * 2.0 / 3.0
            } else {
                z - 1.5 + 2.0 * (-z).exp() - 0.5 * (-2.0 * z).exp()
            };
            2.0 * sigma * sigma / (z * z) * bracket
        };
        let markov: f64 = self.markov.iter().map(of_state).sum();
        (self.white.powi(2) / tau + self.walk.powi(2) * tau / 3.0 + markov).sqrt()
    }
}

const DEGREE: f64 = std::f64::consts::PI / 180.0;

/// The first number after `name` and what separates them.
fn after(text: &str, name: &str) -> f64 {
    let lines =
        text.lines().filter(|line| !["#", "%", "//", " *"].iter().any(|start| line.starts_with(start)));
    let code: String = lines.map(|line| format!("{line}\n")).collect();
    let start = code.find(name).unwrap_or_else(|| panic!("{name} is missing in\n{text}"));
    let rest = code[start + name.len()..].trim_start_matches(|c: char| !c.is_ascii_digit() && c != '\n');
    let end = rest.find(|c: char| !"0123456789.e-+".contains(c)).unwrap_or(rest.len());
    rest[..end].parse().unwrap_or_else(|_| panic!("no number after {name} in\n{text}"))
}

/// The conventions of the tools, as they themselves read their files.
fn read(writer: &str, text: &str) -> Read {
    match writer {
        "kalibr" | "allan_variance_ros" | "openvins" => {
            Read::new(after(text, "gyroscope_noise_density"), after(text, "gyroscope_random_walk"), None)
        }
        // imuSensor with single-sided noise draws NoiseDensity·√rate.
        "matlab" => Read::new(after(text, "'NoiseDensity'"), after(text, "'RandomWalk'"), None),
        // imu_si_errors: arw/60 in degrees; gb_psd = gb_dyn/√gb_corr drives the bias, whose variance is then gb_psd²·gb_corr/2.
        "navego" => {
            let (dyn_, corr) = (DEGREE * after(text, "imu.gb_dyn"), after(text, "imu.gb_corr"));
            let psd = dyn_ / corr.sqrt();
            let simulated =
                DEGREE * after(&text.replace("% For simulation: ", "simulated "), "simulated imu.gb_dyn");
            assert!((simulated * f64::sqrt(2.0) / dyn_ - 1.0).abs() < 1e-5, "{simulated} and {dyn_}");
            Read::new(DEGREE / 60.0 * after(text, "imu.arw"), 0.0, Some([psd * (0.5 * corr).sqrt(), corr]))
        }
        "psins" => {
            let state = [DEGREE / 3600.0 * after(text, "sqrtR0G"), after(text, "TauG")];
            Read::new(DEGREE / 60.0 * after(text, "web"), 0.0, Some(state))
        }
        "gtsam_cpp" => Read::new(
            after(text, "gyroscopeCovariance = gtsam::Vector3(").sqrt(),
            after(text, "biasOmegaCovariance = gtsam::Vector3(").sqrt(),
            None,
        ),
        "gtsam_python" => Read::new(
            after(text, "setGyroscopeCovariance").sqrt(),
            after(text, "setBiasOmegaCovariance").sqrt(),
            None,
        ),
        "pyins" => Read::new(after(text, "\"noise\""), after(text, "\"bias_walk\""), None),
        "kf_gins" => {
            let state = [DEGREE / 3600.0 * after(text, "gbstd"), 3600.0 * after(text, "corrtime")];
            Read::new(DEGREE / 60.0 * after(text, "arw"), 0.0, Some(state))
        }
        // EKF2 adds (noise·step)² per step.
        "px4" => {
            let step = 1e-6 * after(text, "EKF2_PREDICT_US");
            let per_root = |name: &str| after(text, name) * step.sqrt();
            Read::new(per_root("EKF2_GYR_NOISE"), per_root("EKF2_GYR_B_NOISE"), None)
        }
        "json" => whole(&serde_json::from_str(text).unwrap()),
        other => panic!("no test reads the file of {other}"),
    }
}

/// The model of a gyro in a document.
fn whole(model: &Value) -> Read {
    let number = |value: &Value| value.as_f64().unwrap();
    let state = |state: &Value| {
        [DEGREE / 3600.0 * number(&state["sigma_deg_per_h"]), number(&state["correlation_time_s"])]
    };
    Read {
        white: DEGREE / 60.0 * number(&model["white_deg_per_rt_h"]),
        walk: DEGREE / 3600.0 / 60.0 * number(&model["random_walk_deg_per_h_per_rt_h"]),
        markov: model["markov"].as_array().unwrap().iter().map(state).collect(),
    }
}

/// What a C program reads in the header.
fn read_by_c(desk: &Desk, folder: &str) -> Option<Read> {
    Command::new("cc").arg("--version").output().ok()?;
    let program = "#include <stdio.h>\n#include \"sagnac_noise.h\"\nint main(void) {\n    const struct sagnac_noise *g = &sagnac_gyros[0];\n    \
                   printf(\"%.9e %.9e %d\", g->white, g->walk, g->states);\n    for (int i = 0; i < g->states; i++) \
                   printf(\" %.9e %.9e\", g->sigma[i], g->time_s[i]);\n    return 0;\n}\n";
    desk.write("read.c", program);
    let words = ["-std=c99", "-Wall", "-Werror", "-I", folder, "-o", "read_c", "read.c"];
    let compiled = Command::new("cc").args(words).current_dir(desk.path("")).output().unwrap();
    assert!(compiled.status.success(), "{}", String::from_utf8_lossy(&compiled.stderr));
    let printed = Command::new(desk.path("read_c")).output().unwrap();
    let text = String::from_utf8(printed.stdout).unwrap();
    let numbers: Vec<f64> = text.split(' ').map(|number| number.parse().unwrap()).collect();
    assert_eq!(numbers.len(), 3 + 2 * numbers[2] as usize, "{text}");
    let markov = numbers[3..].chunks(2).map(|pair| [pair[0], pair[1]]).collect();
    Some(Read { white: numbers[0], walk: numbers[1], markov })
}

/// Gyros of different make: with flicker over a white noise, with much flicker, and with quantization and a walk.
const GYROS: [&str; 3] = [
    "angle_random_walk = \"0.0003 deg/sqrt(h)\"\nbias_instability = \"0.009 deg/h\"\nrate_random_walk = \"0.0108 deg/h/sqrt(h)\"\n",
    "angle_random_walk = \"0.2 deg/sqrt(h)\"\nbias_instability = \"6 deg/h\"\n",
    "quantization = \"0.3 arcsec\"\nangle_random_walk = \"0.0005 deg/sqrt(h)\"\nrate_random_walk = \"0.02 deg/h/sqrt(h)\"\n",
];

#[test]
fn every_file_has_the_deviation_of_the_model_at_1_s_and_bounds_it_elsewhere() {
    for gyro in GYROS {
        let desk = desk_with("noise.toml", gyro);
        desk.done(
            "model noise.toml --from 1s --to 10000s --overbound --filter-rate 100Hz --write all --out m",
        );
        let whole = read("json", &desk.read("m/model.json"));
        for writer in WRITERS {
            let text = desk.read(&format!("m/{}", writer.file));
            let found = match writer.name {
                "c" => match read_by_c(&desk, "m") {
                    Some(found) => found,
                    None => continue,
                },
                name => read(name, &text),
            };
            let ratio = found.deviation(1.0) / whole.deviation(1.0);
            assert!(
                (ratio - 1.0).abs() < 0.01,
                "{}: {ratio} times at 1 s; {found:?}, not {whole:?}",
                writer.name
            );
            for i in 0..=40 {
                let tau = 10_f64.powf(f64::from(i) / 10.0);
                let ratio = found.deviation(tau) / whole.deviation(tau);
                assert!(ratio > 0.989, "{}: {ratio} times at {tau} s", writer.name);
            }
            assert!(
                text.contains("sagnac model") && text.contains("onvention: "),
                "{}:\n{text}",
                writer.name
            );
        }
    }
}

#[test]
fn axes_and_accelerometers_of_an_imu_have_their_places() {
    let desk = Desk::with("");
    let log = format!("{}/tests/data/imu/log.csv", crate::ROOT);
    let units = "--unit deg/s,deg/s,deg/s,g,g,g --column gx,gy,gz,ax,ay,az";
    desk.done(&format!("model {log} --data rate --time time {units} --overbound --write all --out m"));
    let document: Value = serde_json::from_str(&desk.read("m/model.json")).unwrap();
    let columns = document["columns"].as_array().unwrap();
    assert_eq!(columns.len(), 6);
    // Three axes in their order.
    let gtsam = desk.read("m/gtsam_noise.py");
    let second = |name: &str| -> f64 {
        let values = gtsam.split(name).nth(1).unwrap().split(',').nth(1).unwrap();
        values.trim().parse::<f64>().unwrap().sqrt()
    };
    let gy = Read::new(second("setGyroscopeCovariance"), second("setBiasOmegaCovariance"), None);
    let longest = columns[1]["to_s"].as_f64().unwrap();
    let ratio = gy.deviation(longest) / whole(&columns[1]).deviation(longest);
    assert!((0.98..3.0).contains(&ratio), "{ratio} times at {longest} s");
    let density = after(&desk.read("m/kalibr.yaml"), "accelerometer_noise_density");
    assert!(density > 0.0 && desk.read("m/sagnac_noise.h").contains("sagnac_accelerometers[3]"), "{density}");
    let kf = desk.read("m/kf_gins.yaml");
    for key in ["arw: [", "vrw: [", "gbstd: [", "abstd: [", "corrtime: "] {
        assert!(kf.contains(key), "{key} is missing in\n{kf}");
    }
    // Another run without writers removes their files.
    desk.done(&format!("model {log} --data rate --time time {units} --overbound --out m"));
    assert!(!desk.path("m/kalibr.yaml").exists() && desk.path("m/model.csv").exists());
}

#[test]
fn the_topic_of_a_bag_is_named_and_that_of_kalibr() {
    let desk = Desk::with("");
    let bag = format!("{}/tests/data/formats/imu_bag --column gx", crate::ROOT);
    let ended = desk.done(&format!("allan {bag} --bootstrap 0"));
    let source = "Source  /imu/data (sensor_msgs/Imu): angular_velocity.x [rad/s]";
    assert!(ended.stdout.contains(source), "{}", ended.stdout);
    desk.done(&format!("model {bag} --write kalibr --out m"));
    assert!(desk.read("m/kalibr.yaml").contains("rostopic: /imu/data\n"));
}

/// What the files for MATLAB leave behind in Octave, with functions of the toolboxes that return their arguments.
const OCTAVE: &str = "1;\n\
    function made = gyroparams(varargin) made = struct(varargin{:}); end\n\
    function made = accelparams(varargin) made = struct(varargin{:}); end\n\
    function made = imuerrset(eb, db, web, wdb, sqg, taug, sqa, taua) made = struct('web', web, 'sqg', sqg, 'taug', taug); end\n\
    source('m/imu_sensor.m'); source('m/navego_imu.m'); source('m/psins_imuerr.m');\n\
    printf('%.9e ', gyro.NoiseDensity(1), gyro.RandomWalk(1), imu.arw(3), imu.gb_dyn(2), imu.gb_corr(1), imuerr.web(1), \
    imuerr.sqg(2), imuerr.taug(3)); printf('%s', gyro.NoiseType);\n";

#[test]
fn octave_runs_the_files_for_matlab() {
    let desk = desk_with("noise.toml", GYROS[0]);
    desk.done("model noise.toml --from 1s --to 10000s --overbound --filter-rate 100Hz --write matlab,navego,psins --out m");
    desk.write("read.m", OCTAVE);
    let Ok(ended) = Command::new("octave-cli").args(["--norc", "read.m"]).current_dir(desk.path("")).output()
    else {
        eprintln!("no octave-cli: the files are read by the test alone");
        return;
    };
    let text = String::from_utf8(ended.stdout).unwrap();
    assert!(
        ended.status.success() && text.ends_with("single-sided"),
        "{text}{}",
        String::from_utf8_lossy(&ended.stderr)
    );
    let numbers: Vec<f64> = text.split(' ').filter_map(|word| word.parse().ok()).collect();
    let (matlab, navego, psins) =
        (desk.read("m/imu_sensor.m"), desk.read("m/navego_imu.m"), desk.read("m/psins_imuerr.m"));
    let expected = [
        after(&matlab, "'NoiseDensity'"),
        after(&matlab, "'RandomWalk'"),
        after(&navego, "imu.arw"),
        after(&navego, "imu.gb_dyn"),
        after(&navego, "imu.gb_corr"),
        after(&psins, "web"),
        after(&psins, "sqrtR0G"),
        after(&psins, "TauG"),
    ];
    assert_eq!(numbers, expected, "{text}");
}
