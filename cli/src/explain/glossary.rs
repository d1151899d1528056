//! Terms of the field and of this program that are neither keys nor columns.

/// A term with its spellings and its meaning.
pub struct Term {
    pub names: &'static [&'static str],
    pub meaning: &'static str,
}

pub const TERMS: [Term; 26] = [
    Term {
        names: &["Q", "quantisation noise"],
        meaning: "Coefficient of quantisation noise, ″: an Allan deviation of √3·Q/τ, slope −1. A readout in pulses of weight q gives Q = q/√12. \
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
        meaning: "Rate ramp, (°/h)/h, a steady drift of the rate: an Allan deviation of R·τ/√2, slope +1. Key: noise.rate_ramp.",
    },
    Term {
        names: &["LSB", "pulse"],
        meaning: "The angle of one pulse of the readout, ″. A gyro that counts whole pulses keeps the fraction for the next tick. \
                  Key: gyro.readout_lsb.",
    },
    Term {
        names: &["n", "gap"],
        meaning: "The ticks 1 to n that are lost in a mode switch and that a filler fills. Key: switching.gap_ticks.",
    },
    Term {
        names: &["MT"],
        meaning: "The time between two mode switches, M ticks of T. Key: switching.interval.",
    },
    Term {
        names: &["Δt·ν", "dt·nu", "Δtν"],
        meaning: "The time from the middle of a gap to the nearest measured tick, (n+1)·T/2, in periods of the vibration. For a given n \
                  it alone determines what part of the motion a polynomial misses. Column: dt_nu.",
    },
    Term {
        names: &["Ω_m", "magnetic drift"],
        meaning: "The drift that changes its sign with the mode, °/h: A·(1 − e^(−t/τ)) + Ω_m0. An even number of intervals cancels most of it. \
                  Key: drift.magnetic.",
    },
    Term {
        names: &["Ω_nm", "non-magnetic drift"],
        meaning: "The drift that does not change its sign with the mode, °/h: switching does not cancel it. Key: drift.non_magnetic.",
    },
    Term {
        names: &["auto"],
        meaning: "For allan.fit: those of Q, N, B, K and R that a record supports. For --device: the fastest available device. \
                  For --progress: a bar on a terminal, else lines.",
    },
    Term {
        names: &["octave", "decade10", "decade20"],
        meaning: "Density of the averaging times: each is twice the previous one (octave), or there are 10 or 20 per factor of ten. Key: allan.tau.",
    },
    Term {
        names: &["adev", "oadev", "mdev", "tdev", "hdev", "ohdev"],
        meaning: "Deviations over an averaging time τ that `sagnac allan --deviation` computes: the Allan deviation of adjacent averages \
                  (adev) or of all overlapping ones (oadev, the usual one), the modified Allan deviation (mdev), the time deviation (tdev), \
                  and the Hadamard deviation, which a rate ramp does not affect (hdev, ohdev). The column adev of a study is that of its \
                  allan.estimator.",
    },
    Term {
        names: &["filler", "gap filler"],
        meaning: "The rule that estimates the angle over a gap from the ticks around it, with a weight w for each of these. \
                  `sagnac filler` lists them. Key: switching.fillers.",
    },
    Term {
        names: &["Σ|w|", "Σw²", "√Σw²", "noise gain"],
        meaning: "Gains of the weights of a filler. √Σw², the noise gain, times the white noise of a tick is the noise of the filled \
                  angle; Σ|w| times the largest error of a tick is the largest possible effect of such errors.",
    },
    Term {
        names: &["jackknife"],
        meaning: "Method for the standard error of an estimate that is not a mean, such as the best interval: the estimate is computed without \
                  each of 32 parts of the trials in turn, and the differences give the error.",
    },
    Term {
        names: &["oracle", "closed form"],
        meaning: "The theoretical value of a simulated estimate, where there is a formula: columns that begin with oracle_. The column z is \
                  the difference of the simulation from it, in standard errors of the simulation.",
    },
    Term {
        names: &["trial"],
        meaning: "One sampled switch, run or record. Its random draws depend only on the seed, its number and, unless streams are common, \
                  the point. Key: trials.",
    },
    Term {
        names: &["tally", "tallies"],
        meaning: "The summary of trials that a results folder keeps in tallies.sqlite: exact sums, extremes and the histogram of an error. \
                  More trials add to them, and `sagnac merge` combines the folders of one study.",
    },
    Term {
        names: &["shard", "share"],
        meaning: "A part of the trials of a study, sampled by one of several machines: --shard 2/8. `sagnac merge` combines the folders; \
                  the result has the same bits as one run of all trials.",
    },
    Term {
        names: &["kernel"],
        meaning: "The part of the program that samples, in integer arithmetic, with identical code for the GPU and the CPU. Results record \
                  its version, and results of different versions are never mixed.",
    },
    Term {
        names: &["perimeter control", "loop"],
        meaning: "The control loop that keeps the optical path constant and relocks after each mode switch; until then the readout shows an \
                  apparent rotation. \
                  Keys: those of [relock].",
    },
    Term {
        names: &["point"],
        meaning: "One combination of the values of all sweeps, with its own results: a row of points.csv for each filler and error.",
    },
    Term {
        names: &["points.csv", "coefficients.csv", "trajectories.csv"],
        meaning: "Tables of a results folder. points.csv has a row for each point, and at a point for each filler and error, τ, or angle. \
                  coefficients.csv has a row for each fitted coefficient, and trajectories.csv one for each time of a run. \
                  `sagnac explain COLUMN` describes a column.",
    },
    Term {
        names: &["resolved_study.toml", "tallies.sqlite", "report.html"],
        meaning: "Files of a results folder. resolved_study.toml is the study as it was run, which reproduces the run. tallies.sqlite holds the \
                  exact tallies, from which a run continues. report.html is the report, complete in one file.",
    },
];
