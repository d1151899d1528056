//! The variants of a study: the combinations of its swept keys other than the interval, each with its runs.

use sagnac_engine::drift::INTERVAL;
use sagnac_engine::key::sweep::Swept;
use sagnac_engine::kinds::switched_run::SwitchedRun;

/// The values of the swept keys other than the interval, in the order of the sweeps.
pub(crate) type Values = Vec<(&'static str, Swept)>;

/// The runs of each variant, in the order of the sweeps; a single one where only the interval is swept. The points of a
/// variant differ in the interval alone.
pub(crate) fn of(runs: &SwitchedRun) -> Vec<(Values, SwitchedRun)> {
    let mut variants: Vec<(Values, SwitchedRun)> = Vec::new();
    for point in &runs.points {
        let values: Values = point.swept.iter().filter(|(key, _)| *key != INTERVAL.name).cloned().collect();
        match variants.iter_mut().find(|(known, _)| *known == values) {
            Some((_, own)) => own.points.push(point.clone()),
            None => {
                // Further times and trajectories would cost runs and are not needed.
                let own = SwitchedRun {
                    points: vec![point.clone()],
                    times: vec![],
                    trajectories: 0,
                    ..runs.clone()
                };
                variants.push((values, own));
            }
        }
    }
    variants
}
