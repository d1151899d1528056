//! Words of the field and of this program that are no key and no column.

/// A word, as it may be written, and what it means.
pub struct Term {
    pub names: &'static [&'static str],
    pub meaning: &'static str,
}

pub const TERMS: [Term; 26] = [
    Term {
        names: &["Q", "quantisation noise"],
        meaning: "Coefficient of quantisation noise, ″: an Allan deviation of √3·Q/τ, slope −1. Pulses of q give Q = q/√12. \
                  Key: noise.quantisation.",
    },
    Term {
        names: &["N", "ARW", "angle random walk"],
        meaning: "Coefficient of the angle random walk, °/√h, the white noise of the rate: an Allan deviation of N/√τ, slope −1/2. \
                  Key: noise.angle_random_walk.",
    },
    Term {
        names: &["B", "bias instability"],
        meaning: "Coefficient of the bias instability, °/h, flicker noise of the rate: the flat part of the curve, at 0.664·B. \
                  Key: noise.bias_instability.",
    },
    Term {
        names: &["K", "RRW", "rate random walk"],
        meaning: "Coefficient of the rate random walk, (°/h)/√h: an Allan deviation of K·√(τ/3), slope +1/2. \
                  Key: noise.rate_random_walk.",
    },
    Term {
        names: &["R", "rate ramp"],
        meaning: "Rate ramp, (°/h)/h, a drift of the rate that goes on: an Allan deviation of R·τ/√2, slope +1. Key: noise.rate_ramp.",
    },
    Term {
        names: &["LSB", "pulse"],
        meaning: "The angle of one pulse of the readout, ″. A gyro that counts whole pulses keeps the fraction for the next tick. \
                  Key: gyro.readout_lsb.",
    },
    Term {
        names: &["n", "gap"],
        meaning: "The ticks 1 to n that a mode switch takes, and that a filler fills in. Key: switching.gap_ticks.",
    },
    Term {
        names: &["MT"],
        meaning: "The time between two mode switches, M ticks of T. Key: switching.interval.",
    },
    Term {
        names: &["Δt·ν", "dt·nu", "Δtν"],
        meaning: "The time from the middle of a gap to the nearest tick that is there, (n+1)·T/2, in periods of the vibration: for one n \
                  it tells alone how much of the motion a polynomial misses. Column: dt_nu.",
    },
    Term {
        names: &["Ω_m", "magnetic drift"],
        meaning: "The drift that turns its sign with the mode, °/h: A·(1 − e^(−t/τ)) + Ω_m0. An even number of intervals cancels most of it. \
                  Key: drift.magnetic.",
    },
    Term {
        names: &["Ω_nm", "non-magnetic drift"],
        meaning: "The drift that does not turn its sign with the mode, °/h: no switching cancels it. Key: drift.non_magnetic.",
    },
    Term {
        names: &["auto"],
        meaning: "Of allan.fit: those of Q, N, B, K and R that a record supports. Of --device: the fastest device that there is. \
                  Of --progress: a bar on a terminal, else lines.",
    },
    Term {
        names: &["octave", "decade10", "decade20"],
        meaning: "How dense averaging times are: each twice the one before, or 10 or 20 to a factor of ten. Key: allan.tau.",
    },
    Term {
        names: &["adev", "oadev", "mdev", "tdev", "hdev", "ohdev"],
        meaning: "Deviations over an averaging time τ that `sagnac allan --deviation` takes: the Allan deviation of averages side by side \
                  (adev) or of all that overlap (oadev, the usual one), the modified Allan deviation (mdev), the time deviation (tdev), and \
                  the Hadamard deviation, which a rate ramp does not touch (hdev, ohdev). The column adev of a study is that of its \
                  allan.estimator.",
    },
    Term {
        names: &["filler", "gap filler"],
        meaning: "The rule by which the angle over a gap is put together from the ticks around it: weights w of those samples. \
                  `sagnac filler` lists them. Key: switching.fillers.",
    },
    Term {
        names: &["Σ|w|", "Σw²", "√Σw²", "noise gain"],
        meaning: "Of the weights of a filler: √Σw², the noise gain, times the noise of a tick, if that is white, is the noise of the filled \
                  angle, and Σ|w| times the largest error of a tick is the most that such errors can do.",
    },
    Term {
        names: &["jackknife"],
        meaning: "How the standard error of what is no mean is found, as of the best interval: it is worked out again with each of 32 parts of \
                  the trials left out, and the differences tell.",
    },
    Term {
        names: &["oracle", "closed form"],
        meaning: "What theory says of a simulated value, where it has a formula: columns that begin with oracle_. The column z is how far \
                  the simulation lies from it, in its own standard errors.",
    },
    Term {
        names: &["trial"],
        meaning: "One sampled switch, run or record, with draws of its own that depend on the seed, its number and, unless streams are common, the point alone. \
                  Key: trials.",
    },
    Term {
        names: &["tally", "tallies"],
        meaning: "What a results folder keeps of trials, in tallies.sqlite: exact sums, extremes and the histogram of an error. More trials \
                  add to them, and folders of one study can be put together with `sagnac merge`.",
    },
    Term {
        names: &["shard", "share"],
        meaning: "A part of the trials of a study, which one of several machines samples: --shard 2/8. `sagnac merge` puts the folders \
                  together, to the bits of one run of as many trials.",
    },
    Term {
        names: &["kernel"],
        meaning: "The part of the program that samples, in whole numbers, as a shader on a GPU and the same on the CPU. Results name its \
                  version: those of another one are not mixed.",
    },
    Term {
        names: &["perimeter control", "loop"],
        meaning: "The loop that holds the optical path, and locks anew after each mode switch; until then the readout fakes a rotation. \
                  Keys: those of [relock].",
    },
    Term {
        names: &["point"],
        meaning: "One combination of the values of all sweeps, with results of its own: a row of points.csv for each filler and error.",
    },
    Term {
        names: &["points.csv", "coefficients.csv", "trajectories.csv"],
        meaning: "Tables of a results folder: a row for each point, filler and error, τ or angle; for each fitted coefficient; for each time of \
                  a run. `sagnac explain COLUMN` tells what a column holds.",
    },
    Term {
        names: &["resolved_study.toml", "tallies.sqlite", "report.html"],
        meaning: "Files of a results folder: the study as it was run, which repeats it; the exact tallies, from which a run goes on; the page, \
                  which can be sent alone.",
    },
];
