//! Prints the angle random walk of the first column of a log whose header says times and units, without the removal of events and the
//! check by the spectrum of `sagnac allan`:
//! `cargo run --release -p sagnac-records --example angle_random_walk -- gyro.csv`.

use sagnac_records::allan::Trend;
use sagnac_records::fit::selection::{Terms, describe};
use sagnac_records::fit::{Quantity, Term, curve_of};
use sagnac_records::record::log::{Log, read::Request};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let path = std::env::args().nth(1).ok_or("give the path of a log")?;
    let log = Log::read(path.as_ref(), &Request::default())?;
    let gyro = log.channels[0].view(log.data, log.step_s);
    let curve = curve_of(&gyro.angles(Trend::None))?;
    let fit = describe(&curve, &Terms::of_model(Trend::None).into())?.fit;
    let n = fit.coefficient(Term::AngleRandomWalk).and_then(|n| n.value).ok_or("the log shows no N")?;
    let (scale, _, unit) = Quantity::Coefficient(Term::AngleRandomWalk).unit(log.channels[0].unit.curves);
    println!("N = {:.4} {unit}", scale * n);
    Ok(())
}
