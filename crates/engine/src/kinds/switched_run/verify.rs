//! Named runs that cover every distinction made by the kernel.

use crate::device::Workload;
use crate::kinds::switched_run::SwitchedRun;
use crate::kinds::switched_run::lower::LoweredRun;
use crate::study::Study;
use sagnac_kernel::launch::Launch;

/// The drift of the paper's gyro, without spreads.
const DRIFT: &str =
    "[drift]\nmagnetic = \"14 arcsec/s\"\nwarm_up_time = \"3000 s\"\nnon_magnetic = \"0.05 arcsec/s\"\n";

/// The paper's gyro with two fillers; the motion follows.
const FILLED: &str = "[gyro]\ntick = \"5 ms\"\ntick_noise = { three_sigma = \"1.6 arcsec\" }\n[motion]\n";

/// The rest of a study with relock, whose last table is continued.
const RELOCKED: &str = "amplitude = \"12000 arcsec/s\"\nfrequency = \"20 Hz\"\n[switching]\ninterval = \"3 s\"\ngap_ticks = 3\n\
    fillers = [\"quadratic\"]\n[run]\nduration = \"60 s\"\n[relock]\nmiss = 0.05\nhalf_wave_error = 0.005\nloop_time = \"12 ms\"\n\
    bias_frequency = \"80 kHz\"\npulse_weight = \"2.6 arcsec\"\ncurvature = 40\n";

/// Tables of studies, by name.
const RUNS: [(&str, &[&str]); 12] = [
    (
        "plain",
        &[
            DRIFT,
            "residual_max = \"10 arcsec\"\n[switching]\ninterval = \"40 s\"\n[run]\nduration = \"10 min\"\n",
        ],
    ),
    ("no residual", &[DRIFT, "[switching]\ninterval = \"7 s\"\n[run]\nduration = \"60 s\"\n"]),
    (
        "spreads",
        &[
            DRIFT,
            "magnetic_spread = \"1 arcsec/s\"\nnon_magnetic_spread = \"0.01 arcsec/s\"\ninitial_magnetic = \"0.3 arcsec/s\"\n\
             initial_magnetic_spread = \"0.1 arcsec/s\"\nangle_random_walk = \"0.003 deg/sqrt(h)\"\n\
             residual_max = \"10 arcsec\"\n[switching]\ninterval = \"13 s\"\nfirst_mode = \"random\"\n[run]\n\
             duration = \"5 min\"\ntimes = [\"1 s\", \"13 s\", \"100 s\", \"299 s\", \"300 s\"]\n",
        ],
    ),
    (
        "warm-up",
        &[
            DRIFT,
            "magnetic_spread = \"1 arcsec/s\"\nwarm_up_time_spread = \"20 %\"\nresidual_max = \"10 arcsec\"\n\
             initial_magnetic = \"0.3 arcsec/s\"\n[switching]\ninterval = \"41 s\"\nfirst_mode = \"random\"\n[run]\n\
             duration = \"600 s\"\ntimes = [\"30 s\", \"100 s\"]\n",
        ],
    ),
    (
        "fillers",
        &[
            DRIFT,
            "angle_random_walk = \"0.003 deg/sqrt(h)\"\n",
            FILLED,
            "amplitude = \"12000 arcsec/s\"\nfrequency = \"20.01 Hz\"\n[switching]\ninterval = \"3 s\"\ntiming = \"periodic\"\n\
             first_mode = \"negative\"\ngap_ticks = 3\nfillers = [\"const\", \"quadratic\"]\n[run]\nduration = \"100 s\"\n",
        ],
    ),
    (
        "eight tones",
        &[
            FILLED,
            "tones = [\n{ amplitude = \"12000 arcsec/s\", frequency = \"20 Hz\" },\n\
             { amplitude = \"6000 arcsec/s\", frequency = \"13 Hz\" },\n{ amplitude = \"4000 arcsec/s\", frequency = \"7 Hz\" },\n\
             { amplitude = \"3000 arcsec/s\", frequency = \"31 Hz\" },\n{ amplitude = \"2000 arcsec/s\", frequency = \"37 Hz\" },\n\
             { amplitude = \"2000 arcsec/s\", frequency = \"41 Hz\" },\n{ amplitude = \"1000 arcsec/s\", frequency = \"3 Hz\" },\n\
             { amplitude = \"1000 arcsec/s\", frequency = \"5 Hz\" },\n]\n[switching]\ninterval = \"2 s\"\ngap_ticks = 2\n\
             fillers = [\"linear\"]\n[run]\nduration = \"59 s\"\ntimes = [\"30 s\"]\n",
        ],
    ),
    (
        "constant residual",
        &[
            FILLED,
            "amplitude = \"12000 arcsec/s\"\nfrequency = \"20 Hz\"\nphase = \"extremum\"\n[switching]\ninterval = \"2 s\"\n\
             gap_ticks = 2\nfillers = [\"linear\"]\n[run]\nduration = \"20 s\"\n",
        ],
    ),
    (
        "exact end",
        &[
            DRIFT,
            "residual_max = \"10 arcsec\"\n[switching]\ninterval = \"40 s\"\n[run]\nduration = \"610 s\"\nend = \"exact\"\n",
        ],
    ),
    (
        "exact end with spreads",
        &[
            DRIFT,
            "magnetic_spread = \"1 arcsec/s\"\nwarm_up_time_spread = \"20 %\"\nresidual_max = \"10 arcsec\"\n\
             non_magnetic_spread = \"0.01 arcsec/s\"\nangle_random_walk = \"0.003 deg/sqrt(h)\"\n[switching]\n\
             interval = \"13 s\"\nfirst_mode = \"random\"\n[run]\nduration = \"300 s\"\nend = \"exact\"\ntimes = [\"299 s\", \"300 s\"]\n",
        ],
    ),
    ("relock by frequency", &[FILLED, RELOCKED, "compensation = \"frequency\"\n"]),
    ("relock by detuning", &[FILLED, RELOCKED, "compensation = \"detuning\"\nadc_noise = 0.0002\n"]),
    (
        "many switches",
        &[
            DRIFT,
            "residual_max = \"10 arcsec\"\n[switching]\ninterval = \"10 s\"\n[run]\nduration = \"36000 s\"\n",
        ],
    ),
];

/// The loads on which the kernel is checked.
pub fn loads() -> Vec<Workload> {
    Workload::of_launches(run_launches(), &["spreads", "warm-up"])
}

/// Every launch of every named run.
pub fn run_launches() -> Vec<(&'static str, Launch)> {
    RUNS.iter()
        .flat_map(|(name, tables)| launches(tables).into_iter().map(|launch| (*name, launch)))
        .collect()
}

/// The paper's gyro over an hour with a switch every 40 s: 89 or 90 of them.
pub fn hour_launches() -> Vec<Launch> {
    let run = "residual_max = \"10 arcsec\"\n[switching]\ninterval = \"40 s\"\n[run]\nduration = \"1 h\"\n";
    launches(&[DRIFT, run])
}

fn launches(tables: &[&str]) -> Vec<Launch> {
    let of_filled = lowered(tables).fillers.into_iter().flat_map(|filled| filled.launches());
    of_filled.map(|(launch, _)| launch).collect()
}

/// The only point of a study that consists of these tables.
fn lowered(tables: &[&str]) -> LoweredRun {
    let text = format!("title = \"identity\"\nkind = \"switched-run\"\n{}", tables.concat());
    let study = match Study::parse("identity", &text) {
        Ok(study) => study,
        Err(error) => panic!("{}", error.render(false, 100)),
    };
    let runs = study.asked::<SwitchedRun>().expect("a study of whole runs");
    let lowered = LoweredRun::new(&runs.points[0], runs, study.seed, study.streams);
    lowered.unwrap_or_else(|error| panic!("a named run does not lower: {error}"))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Lowering refuses a run whose words do not stand for its inputs.
    #[test]
    fn every_closed_form_of_a_run_is_that_of_its_inputs_within_rounding() {
        let times = "[run]\nduration = \"301 s\"\ntimes = [\"1 s\", \"100 s\"]\n";
        let walk = "angle_random_walk = \"0.3 deg/sqrt(h)\"\n[switching]\ninterval = \"13 s\"\n";
        let pulses =
            FILLED.replace("[motion]", "readout_lsb = \"2 arcsec\"\n[motion]\nrate = \"31 arcsec/s\"");
        let switched =
            "[switching]\ninterval = \"3 s\"\ngap_ticks = 5\nfillers = [\"const\", \"quadratic\"]\n";
        // Pulses larger than the motion in a tick, whose variance is an average: over drawn values, alone or beside Gaussian
        // motion, and over the places of a record.
        let drawn = "[gyro]\ntick = \"5 ms\"\ntick_noise = { std = \"4 arcsec\" }\nreadout_lsb = \"40 arcsec\"\n[motion]\n\
                     amplitude = { uniform = [\"100 arcsec/s\", \"900 arcsec/s\"] }\nfrequency = [\"18 Hz\", \"22 Hz\"]\n";
        let fixed_phase = format!(
            "{drawn}phase = \"extremum\"\ngaussian = {{ rms = \"200 arcsec/s\", band = [\"5 Hz\", \"9 Hz\"] }}\n"
        );
        let recorded = "[gyro]\ntick = \"5 ms\"\ntick_noise = { std = \"20 arcsec\" }\nreadout_lsb = \"200 arcsec\"\n[motion]\n\
                        profile = { file = \"../../studies/data/base_vibration.csv\" }\n";
        let drift = "[drift]\nmagnetic = \"0.02 arcsec/s\"\n";
        let minute = "[run]\nduration = \"60 s\"\n";
        for gyro in [drawn, &fixed_phase, recorded] {
            let filled = lowered(&[drift, gyro, switched, minute]).fillers;
            let parts = filled.iter().flat_map(|filled| &filled.estimates).filter(|own| own.theory.is_some());
            for part in parts {
                let found = part.representation.expect("a second closed form").abs();
                assert!(found > 1e-12 && found < 1e-3, "{gyro}: {found:e}");
            }
        }
        // No error at all.
        let vanishing = "[gyro]\ntick = \"1 ms\"\ntick_noise = { std = \"0 arcsec\" }\nreadout_lsb = \"155.6 arcsec\"\n[motion]\n\
                         amplitude = \"4076 arcsec/s\"\nfrequency = \"8.549 Hz\"\nphase = \"zero-crossing\"\n";
        let more: [&[&str]; 4] = [
            &[drift, vanishing, switched, minute],
            &["[drift]\n", walk, times],
            &["[drift]\ninitial_magnetic_spread = \"2 arcsec/s\"\n[switching]\ninterval = \"7 s\"\n", times],
            &[&pulses, switched, "[run]\nduration = \"60 s\"\n"],
        ];
        let (mut compared, mut largest) = (0, 0.0_f64);
        for tables in RUNS.iter().map(|(_, tables)| *tables).chain(more) {
            let filled = lowered(tables).fillers;
            for part in
                filled.iter().flat_map(|filled| &filled.estimates).filter_map(|own| own.representation)
            {
                compared += 1;
                largest = largest.max(part.abs());
            }
        }
        assert!(compared > 20 && largest > 1e-12 && largest < 1e-3, "{compared}: {largest:e}");
    }

    /// It was taken as independent from switch to switch, by the kernel and its closed form alike.
    #[test]
    fn a_fixed_tone_beside_a_weak_one_of_drawn_frequency_stays_in_phase() {
        let rms = |more: &str| {
            let motion = format!(
                "[drift]\nmagnetic = \"0 arcsec/s\"\n[gyro]\ntick = \"2 ms\"\ntick_noise = {{ std = \"0 arcsec\" }}\n[motion]\n\
                 tones = [{{ amplitude = \"7401.1 arcsec/s\", frequency = \"138.26 Hz\" }}{more}]\n"
            );
            let switched = "[switching]\ngap_ticks = 2\ninterval = \"6.958 s\"\ntiming = \"periodic\"\nfillers = [\"const\"]\n";
            let filled = lowered(&[&motion, switched, "[run]\nduration = \"206.72016 s\"\n"]).fillers;
            filled[0].estimates[0].theory.unwrap().rms() * filled[0].estimates[0].unit_arcsec
        };
        let beside = rms(", { amplitude = \"60 arcsec/s\", frequency = [\"1 Hz\", \"1.01 Hz\"] }");
        assert!((beside / rms("") - 1.0).abs() < 1e-4, "{beside}, alone {}", rms(""));
    }
}
