//! Launches and recipes whose words or tables are too short, or lead too far, are refused; the shortest ones allowed are sampled
//! in every width, where debug assertions and Miri see each access.

use std::sync::Arc;

use super::*;
use crate::curve::Recorded;
use crate::gap_fill::{self, POLYNOMIALS};
use crate::recipe::{Level, Recipe};
use crate::relock_ticks::{self, Method};
use crate::word::Scalar;
use crate::{relock, switched_run};

/// The number of trials is twice that of the widest lanes, and less under Miri, which takes a second for some of them.
const COUNT: u64 = if cfg!(miri) { 16 } else { 32 };
const TRIALS: Trials = Trials { first: (1 << 32) - COUNT, count: COUNT, histogram: true };

const IN_PROFILE: gap_fill::Shape =
    gap_fill::Shape { before: 64, after: 64, tones: 0, profile: true, ..POLYNOMIALS };

const GAUSSIAN: gap_fill::Shape = gap_fill::Shape { tones: 0, gaussian: true, gap_ticks: 5, ..POLYNOMIALS };

const SWITCHED: switched_run::Shape = switched_run::Shape {
    ends: true,
    times: 2,
    walk: true,
    noise: true,
    tones: 2,
    magnetic: true,
    initial: true,
    non_magnetic: true,
    mode: true,
    warm_up: false,
    relock: None,
    any_end: true,
};

/// Words of gap filling in a profile with so many positions and such a gap.
fn profile_words(shape: gap_fill::Shape, positions: u32, gap: u32) -> Vec<u32> {
    let zeros = vec![0; shape.words()];
    let (length, positions, inverse) = ([gap], [positions], [u32::MAX / positions.max(1)]);
    let p = gap_fill::Parameters::new(&zeros, shape);
    gap_fill::Parameters { gap_length: &length, positions: &positions, positions_inverse: &inverse, ..p }
        .words()
}

fn switched_words(intervals: u32) -> Vec<u32> {
    let zeros = vec![0; SWITCHED.words()];
    let p = switched_run::Parameters::new(&zeros, SWITCHED);
    switched_run::Parameters { intervals: &[intervals], ..p }.words()
}

/// Launches that read their tables in each of the ways, without their tables.
fn tabled() -> Vec<(&'static str, Arc<dyn Sampled>, Vec<u32>)> {
    let in_turn = gap_fill::Shape { every: true, ..IN_PROFILE };
    let in_gap = gap_fill::Shape { extrapolation: false, in_gap: true, gap_ticks: 3, ..POLYNOMIALS };
    let both = gap_fill::Shape { in_gap: true, gap_ticks: 3, fillers: 1, ..IN_PROFILE };
    vec![
        ("profile, one position", IN_PROFILE.into(), profile_words(IN_PROFILE, 1, 1)),
        ("profile", IN_PROFILE.into(), profile_words(IN_PROFILE, 37, 11)),
        ("profile in turn", in_turn.into(), profile_words(in_turn, 61, 2)),
        ("profile, errors in the gap", both.into(), profile_words(both, 5, 3)),
        ("errors in the gap", in_gap.into(), vec![0; in_gap.words()]),
        ("Gaussian motion", GAUSSIAN.into(), vec![0; GAUSSIAN.words()]),
        ("switched run", SWITCHED.into(), switched_words(7)),
    ]
}

#[test]
fn the_shortest_table_is_sampled_in_every_width_and_a_shorter_one_refused() {
    for (name, shape, words) in tabled() {
        let expected = shape.table_words(&words).unwrap();
        let table = |words: usize| vec![3_u32; words].into();
        let short = Launch::new(Arc::clone(&shape), words.clone(), table(expected - 1));
        assert_eq!(short.err(), Some(Misfit::Table { expected, found: expected - 1 }), "{name}");
        let launch = Launch::new(shape, words, table(expected)).unwrap();
        let reference = launch.tally(Width::PORTABLE, TRIALS);
        assert!(reference.iter().all(|tally| tally.count == TRIALS.count), "{name}");
        for width in Width::available() {
            assert_eq!(launch.tally(width, TRIALS), reference, "{name}, {}", width.name());
        }
    }
}

#[test]
fn words_that_are_missing_or_lead_beyond_every_table_are_refused() {
    let table: Arc<[u32]> = vec![0; 1000].into();
    let refused =
        |shape: gap_fill::Shape, words: Vec<u32>| Launch::new(shape, words, Arc::clone(&table)).err();
    let all = IN_PROFILE.words();
    let field = |name| Some(Misfit::Field(name));
    assert_eq!(refused(IN_PROFILE, vec![0; all - 1]), Some(Misfit::Words { expected: all, found: all - 1 }));
    assert_eq!(refused(IN_PROFILE, profile_words(IN_PROFILE, 0, 1)), field("positions"));
    assert_eq!(refused(IN_PROFILE, profile_words(IN_PROFILE, u32::MAX, 1)), field("positions"));
    assert_eq!(refused(IN_PROFILE, profile_words(IN_PROFILE, 1, u32::MAX)), field("gap_length"));
    let in_turn = gap_fill::Shape { every: true, ..IN_PROFILE };
    let mut words = profile_words(in_turn, 61, 2);
    *words.iter_mut().find(|word| **word == u32::MAX / 61).unwrap() -= 1;
    assert_eq!(refused(in_turn, words), field("positions_inverse"));
    let far = gap_fill::Shape { after: 65, ..IN_PROFILE };
    assert_eq!(refused(far, profile_words(far, 1, 1)), field("after"));
    let endless = Launch::new(SWITCHED, switched_words(u32::MAX), Arc::clone(&table)).err();
    assert_eq!(endless, field("intervals"));
}

#[test]
#[should_panic(expected = "belongs to another shape: a table of 130 words found")]
fn a_kernel_refuses_the_launch_of_another_shape() {
    let far = gap_fill::Shape { before: 64, after: 63, ..IN_PROFILE };
    let near = gap_fill::Shape { before: 63, ..far };
    let words = profile_words(near, 2, 1);
    assert_eq!(words.len(), far.words(), "only the table differs");
    let table = vec![0; near.table_words(&words).unwrap()];
    let launch = Launch::new(near, words, table.into()).unwrap();
    Trial::tally::<Scalar>(far, &launch, TRIALS);
}

#[test]
fn more_estimates_than_a_trial_has_are_refused() {
    let shape = gap_fill::Shape { in_gap: true, gap_ticks: 3, ..POLYNOMIALS };
    let refused = Launch::new(shape, vec![0; shape.words()], vec![0; 1000].into()).err();
    assert_eq!(refused, Some(Misfit::Field("estimates")));
}

#[test]
fn relocked_trials_read_no_further_than_their_words() {
    for method in [Method::None, Method::Frequency, Method::Detuning] {
        let ticks = relock_ticks::Shape { ticks: relock_ticks::MAX_TICKS, method };
        let shape = relock::Shape { ticks, estimates: 2 };
        let launch = Launch::new(shape, vec![1; shape.words()], Arc::new([])).unwrap();
        let reference = launch.tally(Width::PORTABLE, TRIALS);
        for width in Width::available() {
            assert_eq!(launch.tally(width, TRIALS), reference, "{method:?}, {}", width.name());
        }
    }
}

fn recipe() -> Recipe {
    Recipe {
        key: [1, 2],
        samples: 200,
        white: 160,
        rate_scale: 1 << 20,
        walk: 5,
        flicker: vec![100; 8],
        markov: Some([1 << 20, 40, 50]),
        sine: Some([1 << 24, 400]),
        quantization: 16,
        pulse: Some(2),
        switching: Some([50, 40, 30]),
        drift: vec![7; 201].into(),
        order: 3,
        levels: vec![Level { stride: 1, spans: vec![1, 3] }, Level { stride: 4, spans: vec![1, 16] }],
    }
}

#[test]
fn a_record_reads_no_further_than_its_recipe() {
    let reference = recipe().sums(Width::PORTABLE, 5, 3);
    for width in Width::available() {
        assert_eq!(recipe().sums(width, 5, 3), reference, "{}", width.name());
    }
}

#[test]
fn a_recipe_that_leads_beyond_its_lists_is_refused() {
    let refused = |edit: fn(&mut Recipe)| {
        let mut recipe = recipe();
        edit(&mut recipe);
        recipe.fits().err()
    };
    assert_eq!(refused(|_| {}), None);
    let short = Misfit::Table { expected: 201, found: 200 };
    assert_eq!(refused(|recipe| recipe.drift = vec![7; 200].into()), Some(short));
    type Edit = (&'static str, fn(&mut Recipe));
    let edits: [Edit; 7] = [
        ("samples", |recipe| (recipe.samples, recipe.drift) = (u32::MAX, Arc::new([]))),
        ("order", |recipe| recipe.order = 4),
        ("flicker", |recipe| recipe.flicker = vec![1; 30]),
        ("switching", |recipe| recipe.switching = Some([0, 1, 1])),
        ("pulse", |recipe| recipe.pulse = Some(32)),
        ("stride", |recipe| recipe.levels[0].stride = 0),
        ("spans", |recipe| recipe.levels[1].spans[0] = u32::MAX),
    ];
    for (name, edit) in edits {
        assert_eq!(refused(edit), Some(Misfit::Field(name)));
    }
}

#[test]
#[should_panic(expected = "the recipe of a record does not fit: a table of 100 words found")]
fn a_recipe_without_all_of_its_drift_makes_no_record() {
    Recipe { drift: vec![0; 100].into(), ..recipe() }.sums(Width::widest(), 0, 1);
}
