//! Runs a study and prints its table as CSV: `cargo run --release --example run -- studies/smoke.toml`.

use sagnac::progress::Silent;
use sagnac::run::Plan;
use sagnac::store::Store;
use sagnac::study::Study;
use sagnac::tally::Share;
use sagnac::verify::select;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let path = std::env::args().nth(1).unwrap_or_else(|| "studies/smoke.toml".to_owned());
    let study = Study::read(path.as_ref())?;
    let plan = Plan::new(&study)?;
    let mut store = Store::open("results/example".as_ref(), &plan.identity())?;
    let mut device = select("auto", 0)?.device;
    plan.run(&mut store, &mut device, Share::WHOLE, &Silent)?;
    plan.tables(&store, &Silent)?.points.write_csv(std::io::stdout())?;
    Ok(())
}
