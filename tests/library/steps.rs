//! A run whose steps another driver takes gives the same tables.

use std::path::Path;

use sagnac::device::Device;
use sagnac::progress::Silent;
use sagnac::run::{Batch, Budget, Plan, Tables, Worker};
use sagnac::store::{Provenance, Store};
use sagnac::study::Study;
use sagnac::tally::Share;
use sagnac::verify::select;

/// Studies whose trials are launches, with a stop rule, with trajectories and with neither, and those whose trials are records; with
/// their trials here.
const STUDIES: [(&str, u64); 6] = [
    ("smoke", 3000),
    ("which_filler", 5000),
    ("sawtooth", 64),
    ("my_gyro", 20),
    ("lock_in_static", 6),
    ("position_after_an_hour", 64),
];

fn processor() -> Device {
    select("cpu", 2).unwrap().device
}

/// The tables of a share whose batches have about so many steps, and are stored in the order opposite to that in which they
/// were taken.
fn by_hand(plan: &Plan, steps: u64) -> Tables {
    let mut device = processor();
    let mut worker = Worker::new(&mut device, &Silent);
    let mut store = Store::in_memory(&plan.identity());
    let mut run = plan.steps(&store, Share::WHOLE).unwrap();
    let budget = Budget { steps, records: 3 };
    let (mut trials, mut amount) = (0, 0);
    loop {
        let [done, all] = run.amounts();
        let mut taken = vec![];
        while let Some(batch) = run.next(budget).unwrap() {
            taken.push(batch);
        }
        let of_round: u64 = taken.iter().map(Batch::amount).sum();
        assert_eq!(done + of_round, all, "the batches of a round are what it lacks");
        amount += of_round;
        for batch in taken.iter().rev() {
            let results = batch.make(&mut worker, &|_| ()).unwrap();
            trials += batch.trials();
            let made = Provenance { device: "by hand".to_owned(), trials, seconds: 1.0 };
            batch.put(results, &mut store, &made).unwrap();
        }
        if !run.more(&store).unwrap() {
            break;
        }
    }
    assert!(amount > 0);
    drop(run);
    plan.keep(&mut store, Share::WHOLE).unwrap();
    assert_eq!(plan.lacks(&store, Share::WHOLE).unwrap(), 0);
    plan.tables(&store, &Silent).unwrap()
}

#[test]
fn steps_of_any_size_in_any_order_give_the_tables_of_a_run() {
    for (name, trials) in STUDIES {
        let path = Path::new("studies").join(name).with_extension("toml");
        let mut study = Study::read(&path).unwrap_or_else(|error| panic!("{}", error.render(false, 100)));
        study.trials = trials;
        let plan = Plan::new(&study).unwrap();
        let mut store = Store::in_memory(&plan.identity());
        plan.run(&mut store, &mut processor(), Share::WHOLE, &Silent).unwrap();
        let expected = plan.tables(&store, &Silent).unwrap();
        for steps in [1000, 300_000] {
            assert_eq!(by_hand(&plan, steps), expected, "{name}, {steps} steps");
        }
    }
}
