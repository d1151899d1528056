//! The gallery of the documents: each shipped study with its picture, question and answer, on pages by subject.
//!
//! The answers are those of few trials, which the golden tables have too. The pictures are those of whole runs, which `.ci/gallery` writes:
//! the tests check only that there is one of each study.

/// The question of a study, and its answer.
pub struct Asked {
    pub name: String,
    pub question: String,
    pub headline: String,
    /// What the program prints.
    pub shown: String,
    /// Words of the headline and lines of the answer.
    pub counts: [usize; 2],
}

/// A page of the gallery: its file and title, and its studies with what is worth a change.
type Page = (&'static str, &'static str, &'static [(&'static str, &'static str)]);

const PAGES: [Page; 8] = [
    (
        "fillers",
        "Gap fillers",
        &[
            ("which_filler", "Put your tick, noise and vibration in; add fillers to `switching.fillers`."),
            ("best_filler", "Set the upper ends of the band in the sweep of `motion.frequency.high`."),
            ("filler_map", "Sweep other ranges of `motion.frequency` and `motion.amplitude`."),
            ("noise_error_vs_gap", "Set `gyro.tick_noise`; the gyro does not move, so only noise remains."),
            ("readout_quantization", "Change `gyro.tick_noise`: its ratio to the pulse decides."),
            ("recorded_profile", "Name your own record in `motion.profile.file`."),
            (
                "what_decides",
                "`sagnac sensitivity` takes the `[[sensitivity]]` inputs; give each your range.",
            ),
            ("smoke", "Nothing: it takes a second and tries every kind of motion."),
        ],
    ),
    (
        "vibration",
        "Vibration",
        &[
            ("error_vs_dtnu", "Set `gyro.tick`, `motion.amplitude` and `limit`."),
            ("error_vs_dtnu_extremum", "`motion.phase` fixes the phase; remove it for a random one."),
            ("error_vs_dtnu_zero_crossing", "As above: this is the best case, not the usual one."),
            ("error_vs_amplitude_extremum", "Set `motion.frequency` to that of your vibration."),
            ("error_vs_amplitude_zero_crossing", "Chart `extrapolation` to see the error during the gap."),
            ("suspension", "Write your modes into `suspension.modes`."),
            (
                "lgk400_vs_lgv1_vibration",
                "Give the density of your vibration in `motion.suspension.random.psd`.",
            ),
        ],
    ),
    (
        "switching",
        "Switching interval and drift",
        &[
            ("design_point", "Use `sagnac design` to find the interval too."),
            (
                "drift_vs_interval",
                "Set `[drift]`; `run.end = \"exact\"` for runs that end after a whole number of intervals.",
            ),
            ("drift_vs_interval_bound", "The same keys, in closed form."),
            ("optimal_interval", "Set `drift.residual_max` to the largest residual of your filler."),
            ("sawtooth", "`run.trajectories` sets the number of curves."),
        ],
    ),
    (
        "relock",
        "Relock",
        &[
            ("relock_tables", "Set `relock.loop_time` and `relock.initial_detuning`."),
            ("relock_noise", "Sweep `relock.count_step` for the compensation by frequency."),
            ("relock_in_runs", "Sweep `relock.compensation` and `switching.interval`."),
        ],
    ),
    (
        "lock-in",
        "Lock-in and dither",
        &[
            ("lock_in_static", "Set `lock_in.threshold` and `gyro.scale_factor`."),
            ("dither_zones", "Sweep finer inputs: zone 2 lies between two of these."),
            (
                "dither_randomization",
                "Set `dither.rate` and `dither.frequency`; 3 rad of the beat phase are enough.",
            ),
            ("arw_from_lock_in", "Sweep `lock_in.threshold` over the range of your gyros."),
            ("lgv1_lock_in", "Scale factor, dither rate and randomization are assumed: set yours."),
            ("lock_in_in_allan", "Write your `noise.lock_in`."),
            ("dither_and_gap", "Set `gyro.tick` to whole periods of your dither."),
        ],
    ),
    (
        "allan",
        "Allan deviation",
        &[
            ("lgk400_vs_lgv1", "Sweep `noise.file` over the noise.toml files of your gyros."),
            ("lgv1_correlated", "Set `noise.markov.amplitude`, which is assumed."),
            ("record_length", "Write the coefficients of your data sheet into `[noise]`."),
            ("my_gyro", "Copy the noise.toml of `sagnac allan` over `studies/data/gyros/mine.toml`."),
            ("fit_recovery", "Set `record.length`, and the other coefficients of your gyro."),
            ("quantizer", "Set `noise.readout_lsb`, and `record.rate` for the rate of the Earth."),
        ],
    ),
    (
        "switching-in-records",
        "Mode switches in records",
        &[
            ("switching_in_allan", "Sweep `noise.switching.interval` over your intervals."),
            ("switching_in_allan_even", "Take averaging times at even multiples of your interval."),
        ],
    ),
    (
        "navigation",
        "Navigation",
        &[
            (
                "position_after_an_hour",
                "Set `navigation.latitude`, `alignment`, and a leg by `speed` and `course`.",
            ),
            ("heading_after", "Set `limit` and `navigation.alignment`."),
            ("gyrocompass", "Sweep `navigation.alignment` further."),
            ("switching_in_navigation", "Sweep `noise.file` over files with your filler's residual."),
            ("navigation_from_a_fit", "Copy the intervals from noise.toml into `[[sensitivity]]`."),
            ("bound_or_believe", "Name a model of `sagnac model --json` in `navigation.filter`."),
        ],
    ),
];

const ABOUT: &str = "# Gallery

The shipped studies, by subject. `sagnac run studies/NAME.toml` makes the whole page of each. Charts are those of whole runs; answers are those of
512 trials or fewer, which a test runs, so a whole run differs a little. Symbols such as Z(7) are explained in [physics](../explain/physics.md).
";

/// The files of the gallery with their texts.
pub fn pages(asked: &[Asked]) -> Vec<(String, String)> {
    let of = |name: &str| {
        asked.iter().find(|asked| asked.name == name).unwrap_or_else(|| panic!("no study {name}"))
    };
    for Asked { name, .. } in asked {
        let count = PAGES.iter().flat_map(|page| page.2).filter(|(study, _)| study == name).count();
        assert_eq!(count, 1, "{name} is to be on one page of the gallery");
    }
    let mut files = vec![];
    let mut index = ABOUT.to_owned();
    for (file, title, studies) in PAGES {
        let mut page = format!("# {title}\n\n[Gallery](index.md)\n");
        index += &format!("\n## [{title}]({file}.md)\n\n");
        for (name, _) in studies {
            index += &format!("[{}]({file}.md#{name})\n", picture(name, 280));
        }
        for (name, change) in studies {
            let Asked { question, shown, .. } = of(name);
            page += &format!(
                "\n## {name}\n\n{question}\n\n{}\n\n```text\n{}\n```\n\n**Change:** {change}\n",
                picture(name, 560),
                answer(shown)
            );
        }
        files.push((format!("docs/gallery/{file}.md"), page));
    }
    files.push(("docs/gallery/index.md".to_owned(), index));
    files
}

fn picture(name: &str, width: u32) -> String {
    format!("<img src=\"pictures/{name}.svg\" width=\"{width}\" alt=\"{name}\">")
}

/// The headline and the table of what the program prints.
fn answer(shown: &str) -> String {
    let parts: Vec<&str> = shown.split("\n\n").skip(1).take(2).collect();
    let is_table = |part: &str| !part.starts_with("  Worst case") && !part.starts_with("  Error budget");
    parts.into_iter().filter(|part| is_table(part)).collect::<Vec<_>>().join("\n\n")
}
