//! Planning in parallel: the same words and the same refusal as point by point, and an end where it is asked for.

use std::sync::atomic::{AtomicU64, Ordering};

use rayon::ThreadPoolBuilder;

use crate::kinds::gap_fill::GapFill;
use crate::kinds::gap_fill::lower::Lowered;
use crate::kinds::gap_fill::run::{Plan as GapPlan, Proven};
use crate::kinds::plan::PointsPlan;
use crate::study::Study;
use sagnac_base::diagnostics::StudyError;
use sagnac_base::progress::{Progress, Silent};

/// Points of different gaps, with motion that several of them share.
fn study(noise: &str, to: &str) -> Study {
    let text = format!(
        "title = \"Many\"\nkind = \"gap-fill\"\ntrials = 8\n[gyro]\ntick = \"5 ms\"\ntick_noise = {{ std = \"{noise}\" }}\n\
         [motion]\namplitude = \"12000 arcsec/s\"\nfrequency = \"20 Hz\"\ngaussian = {{ rms = \"9000 arcsec/s\", band = [\"1 Hz\", \"60 Hz\"] }}\n\
         [switching]\ngap_ticks = 3\nfillers = [\"const\", {{ kind = \"minimum-variance\", name = \"mv\" }}]\n\
         [[sweep]]\nkey = \"motion.amplitude\"\nlog = {{ from = \"1e3 arcsec/s\", to = \"{to}\", points = 600 }}\n\
         [[sweep]]\nkey = \"switching.gap_ticks\"\nlist = [1, 2, 3, 5]\n"
    );
    Study::parse("many.toml", &text).unwrap_or_else(|error| panic!("{}", error.render(false, 100)))
}

fn lowered(asked: &GapFill, study: &Study, place: usize) -> Result<Lowered, crate::key::Unrepresentable> {
    Lowered::new(&asked.points[place], &asked.fillers, &asked.errors, study.seed, study.streams)
}

fn plan<'a>(study: &'a Study, progress: &dyn Progress) -> Result<Option<GapPlan<'a>>, StudyError> {
    let asked: &GapFill = study.asked().unwrap();
    let prove = |point| Proven::new(study, asked, point);
    PointsPlan::new(study, asked, &asked.points, |point| &point.swept, prove, progress)
}

fn with_threads<T: Send>(threads: usize, work: impl FnOnce() -> T + Send) -> T {
    ThreadPoolBuilder::new().num_threads(threads).build().unwrap().install(work)
}

#[test]
fn several_threads_give_the_words_of_each_point_alone() {
    let study = study("0.5 arcsec", "2e4 arcsec/s");
    let asked: &GapFill = study.asked().unwrap();
    let planned = with_threads(5, || plan(&study, &Silent)).unwrap().unwrap();
    assert_eq!(planned.points.len(), 2400);
    // From the other end, so that what points share is computed for others first.
    for place in (0..2400).rev() {
        let (proven, alone) = (&planned.points[place], lowered(asked, &study, place).unwrap());
        let proofs = proven
            .estimates
            .iter()
            .map(|own| (proven.address(own), own.theory, own.unit_arcsec, own.bin_base));
        let estimates = alone.fillers.iter().flatten();
        let estimates = estimates.map(|own| (own.address, own.theory, own.unit_arcsec, own.bin_base));
        assert!(proofs.eq(estimates), "point {place}");
        assert!(proven.launch(&[0, 1]).unwrap() == alone.launch(&[0, 1]), "the launch of point {place}");
    }
}

#[test]
fn the_first_refused_point_is_reported_whichever_thread_finds_it() {
    let study = study("0.05 arcsec", "9e8 arcsec/s");
    let asked: &GapFill = study.asked().unwrap();
    let refused = |place: &usize| lowered(asked, &study, *place).is_err();
    let first = (0..asked.points.len()).find(refused).expect("all points fit");
    let others = (first + 1..asked.points.len()).filter(refused).count();
    assert!(first > 0 && others > 100, "point {first} and {others} others are refused");
    let point = &asked.points[first];
    let expected = study.refused(&point.swept, &lowered(asked, &study, first).unwrap_err());
    for threads in [1, 2, 7] {
        let found = with_threads(threads, || plan(&study, &Silent).map(drop)).unwrap_err();
        assert_eq!(found.render(false, 100), expected.render(false, 100), "{threads} threads");
    }
}

/// Asks to stop after some points.
struct Until {
    points: u64,
    done: AtomicU64,
    total: AtomicU64,
}

impl Progress for Until {
    fn start(&self, _: &'static str, _: u64, total: u64) {
        self.total.store(total, Ordering::SeqCst);
    }

    fn advance(&self, more: u64) {
        self.done.fetch_add(more, Ordering::SeqCst);
    }

    fn stops(&self) -> bool {
        self.done.load(Ordering::SeqCst) >= self.points
    }
}

#[test]
fn planning_ends_with_the_points_at_hand_when_asked() {
    let study = study("0.5 arcsec", "2e4 arcsec/s");
    for (points, ends) in [(0, true), (1500, true), (2401, false)] {
        let until = Until { points, done: AtomicU64::new(0), total: AtomicU64::new(0) };
        let planned = with_threads(3, || plan(&study, &until)).unwrap();
        assert_eq!(planned.is_none(), ends, "asked to stop after {points}");
        // Each of the threads may have had a point at hand.
        let done = until.done.load(Ordering::SeqCst);
        assert!((points.min(2400)..=points.min(2400) + 2).contains(&done), "{done} points, not {points}");
        assert_eq!(until.total.load(Ordering::SeqCst), 2400);
    }
}
