//! Studies of Allan curves that are refused, each with its place and what is accepted.

use sagnac::run::Plan;
use sagnac::study::Study;

use super::{LGV_1, text, with_files};

fn refused(text: &str, pieces: &[&str]) {
    let report = match Study::parse("a.toml", text) {
        Ok(study) => match Plan::new(&study) {
            Ok(_) => panic!("accepted although {pieces:?} was expected:\n{text}"),
            Err(error) => error.render(false, 400),
        },
        Err(error) => error.render(false, 400),
    };
    for piece in pieces {
        assert!(report.contains(piece), "`{piece}` is missing in\n{report}");
    }
}

#[test]
fn what_makes_no_sense_is_refused_with_its_place_and_what_is_accepted() {
    let allan = |lines: &str| text("", LGV_1, &format!("[allan]\n{lines}"));
    let noise = |lines: &str| text("", lines, "");
    let locks_in = |threshold: &str, dither: &str| {
        noise(&format!(
            "lock_in = {{ threshold = \"{threshold}\", scale_factor = \"2 arcsec/pulse\", dither_amplitude = \"{dither}\", \
             dither_frequency = \"400 Hz\" }}"
        ))
    };
    let switching = |keys: &str| noise(&format!("{LGV_1}\nswitching = {{ {keys} }}"));
    let table: &[(String, &[&str])] = &[
        (
            allan("tau = \"octaves\""),
            &["a.toml:13:7", "is not a list of averaging times", "did you mean", "octave"],
        ),
        (allan("tau = []"), &["allan.tau is empty"]),
        (allan("tau = [\"1.5 s\"]"), &["not a whole number of samples of 1 s", "multiples of record.sample"]),
        (
            allan("tau = [\"1001 s\"]"),
            &["too long for a record of 2000 s", "τ ≤ 1000 s", "lengthen the record"],
        ),
        (allan("tau = [\"10 s\", \"10 s\"]"), &["lists 10 s twice"]),
        (allan("tau = [\"0 s\"]"), &["above 0"]),
        (allan("fit = [\"Q\", \"X\"]"), &["\"X\" is not a term", "fit = \"auto\""]),
        (allan("fit = [\"Q\", \"Q\"]"), &["lists \"Q\" twice"]),
        (allan("fit = \"all\""), &["names no terms"]),
        (allan("estimator = \"hadamar\""), &["unknown value \"hadamar\"", "hadamard"]),
        (allan("estimator = \"non-overlapping\"\noverlap = \"full\""), &["nothing overlaps"]),
        (allan("tau = [\"1 s\"]\nfit = [\"Q\", \"N\"]"), &["too few for 2 parameters", "a longer record"]),
        (noise("angle_random_walk = \"1 deg/h\""), &["angular rate", "deg/sqrt(h)"]),
        (noise("angle_random_walk = 0.001"), &["its unit is missing"]),
        (noise("quantization = \"-1 arcsec\""), &["out of range", "negative"]),
        (noise(""), &["all records would be constant", "noise.toml"]),
        (noise("file = \"nowhere.toml\""), &["cannot read the noise", "nowhere.toml", "sagnac allan"]),
        (noise("markov = { amplitude = \"1 deg/h\" }"), &["the key `noise.markov.time` is missing"]),
        (noise("sine = { amplitude = \"1 deg/h\", frequency = \"0.6 Hz\" }"), &["Nyquist", "up to 0.5 Hz"]),
        (
            locks_in("0 arcsec/s", "100 deg/s"),
            &["noise.lock_in.threshold = 0", "out of range", "below the dither rate"],
        ),
        (locks_in("-1 arcsec/s", "100 deg/s"), &["out of range", "negative"]),
        (
            locks_in("200 deg/s", "100 deg/s"),
            &[
                "a.toml:9:25",
                "not below the dither rate of 360000 arcsec/s",
                "locked",
                "the gyro would stay locked",
            ],
        ),
        (
            locks_in("0.1 arcsec/s", "0.1 arcsec"),
            &["a.toml:9:", "turns the beat phase by only 0.314 rad", "too small", "kind = \"lock-in\""],
        ),
        (
            locks_in("180 arcsec/s", "100 deg/s^2"),
            &["dither_amplitude", "an angular acceleration", "or an angle"],
        ),
        (
            noise("lock_in = { threshold = \"1 arcsec/s\" }"),
            &["the key `noise.lock_in.scale_factor` is missing"],
        ),
        (noise("jitter = \"1 s\""), &["unknown key `jitter`"]),
        (
            switching("interval = \"2000 s\", residual = \"1 arcsec\""),
            &["a.toml:12:26", "there is no switch in a record of 2000 s", "accepted: 1 s to 1999 s"],
        ),
        (
            switching("interval = \"0.2 s\", residual = \"1 arcsec\""),
            &["0.2 s is less than half a sample of 1 s", "accepted: 1 s to 1999 s"],
        ),
        (
            switching("interval = \"0 s\", residual = \"1 arcsec\""),
            &["noise.switching.interval", "out of range"],
        ),
        (switching("interval = \"-40 s\", residual = \"1 arcsec\""), &["out of range", "negative"]),
        (switching("interval = \"40 s\", residual = \"-1 arcsec\""), &["out of range", "negative"]),
        (
            switching("interval = \"40 s\", residual_noise = \"1 deg/h\""),
            &["noise.switching.residual_noise", "arcsec"],
        ),
        (switching(""), &["the key `noise.switching.interval` is missing"]),
        (switching("interval = \"40 s\""), &["switches without effect", "leave the table out"]),
        (switching("interval = \"40 s\", residual = \"0 arcsec\""), &["switches without effect"]),
        (
            switching("interval = \"40 s\", residual = \"1 arcsec\", warm_up_time = \"1 h\""),
            &["warm_up_time is given without magnetic", "nothing warms up"],
        ),
        (switching("interval = \"40 s\", amplitude = \"1 deg/h\""), &["unknown key `amplitude`"]),
        (
            text("", LGV_1, "[[sweep]]\nkey = \"noise.switching.interval\"\nlist = [\"40 s\"]"),
            &["noise.switching.interval is swept, but [noise] has none"],
        ),
        (
            text("", LGV_1, "[[sweep]]\nkey = \"noise.switching\"\nlist = [\"40 s\"]"),
            &["noise.switching is a table and cannot be swept"],
        ),
        (
            switching("interval = \"40 s\", residual = \"1 arcsec\"")
                + "[[sweep]]\nkey = \"noise.switching.interval\"\nlist = [\"40 s\", \"1 h\"]\n",
            &["a.toml:16:8", "there is no switch in a record of 2000 s"],
        ),
        (noise(LGV_1).replace("2000 s", "10 s"), &["10 samples of 1 s", "16 to 67108864 samples"]),
        (noise(LGV_1).replace("2000 s", "3 a"), &["`a` is not a known unit"]),
        (noise(LGV_1).replace("2000 s", "100000 h"), &["too long", "record.length"]),
        (
            noise(LGV_1).replace("[record]", "[gyro]\ntick = \"5 ms\"\n[record]"),
            &["[gyro] is not a table of a study of kind"],
        ),
        (
            noise(LGV_1).replace("kind = \"allan\"", "kind = \"gap-fill\""),
            &["[record] is not a table", "kind = \"allan\""],
        ),
        (
            noise(LGV_1).replace("[record]\nsample = \"1 s\"\nlength = \"2000 s\"\n", ""),
            &["needs the table [record]"],
        ),
        (text("precision = \"1 %\"", LGV_1, ""), &["precision is not a key of a study of kind"]),
        (
            text("", LGV_1, "[[sweep]]\nkey = \"noise.markov.time\"\nlist = [\"1 s\"]"),
            &["noise.markov.time is swept, but [noise] has none"],
        ),
        (
            text("", LGV_1, "[[sweep]]\nkey = \"motion.frequency\"\nlist = [\"1 Hz\"]"),
            &["there is no key `motion.frequency` to sweep"],
        ),
        (
            text(
                "",
                LGV_1,
                "[[sweep]]\nkey = \"noise.file\"\nlog = { from = \"1 s\", to = \"2 s\", points = 2 }",
            ),
            &["it is over files"],
        ),
        (
            text("", LGV_1, "[[sweep]]\nkey = \"record.rate\"\nlist = [\"1 deg/h\"]"),
            &["record.rate is swept", "affects only a readout in whole pulses"],
        ),
        (allan("estimator = \"hadamard\"\nfit = [\"R\"]"), &["does not see a rate ramp R"]),
        (
            noise(LGV_1).replace("trials = 200", "trials = 20_000_000"),
            &["20000000 records", "trials, which are records here and take 1 GiB of memory"],
        ),
        (
            allan("overlap = \"full\"").replace("2000 s", "18000 h"),
            &["records of 64800000 samples need", "MiB on each thread", "m/64"],
        ),
        (
            text("", LGV_1, "[chart]\ntable = \"coefficients\"\nx = \"length\"\ny = \"sd\""),
            &["none are fitted"],
        ),
        (
            text("", LGV_1, "[chart]\nx = \"tau\"\ny = \"adev\"\nlimit = \"1 arcsec\""),
            &["chart.limit", "an angular rate"],
        ),
        (
            text("", LGV_1, "[chart]\nx = \"tau\"\ny = \"adev\"\nlaws = [\"noise\"]"),
            &["is a reference curve of gap fillers"],
        ),
    ];
    for (text, pieces) in table {
        refused(text, pieces);
    }
}

#[test]
fn a_fault_in_a_file_of_noise_is_shown_there() {
    for (content, pieces) in [
        ("quantization = \"1 deg/h\"", &["mine.toml:1:16", "angular rate"][..]),
        ("quantization = ", &["mine.toml:1", "not valid TOML"]),
        ("quantizatoin = \"1 arcsec\"", &["unknown key `quantizatoin`", "quantization"]),
        ("file = \"other.toml\"", &["names another noise file"]),
    ] {
        let folder = with_files(&[("mine.toml", content)]);
        let name = folder.path().join("a.toml").display().to_string();
        let error = Study::parse(&name, &text("", "file = \"mine.toml\"", "")).unwrap_err();
        let report = error.render(false, 400);
        for piece in pieces {
            assert!(report.contains(piece), "`{piece}` is missing in\n{report}");
        }
    }
}
