//! Part `counts`: the integer operations of each measured kernel.

use sagnac::device::load::Work;
use sagnac::kernel::curve::Recorded;
use sagnac::kernel::launch::Launch;
use sagnac::kernel::recipe::CHUNK;
use sagnac::kernel::shader::Variant;
use sagnac::verify::measured::{Measured, measured};
use serde_json::json;

use crate::count::{Operations, operations};
use crate::emit;

pub fn counts() {
    for measured in measured() {
        for variant in VARIANTS {
            let Operations { all, wide } = counted(&measured, variant);
            let Measured { kernel, configuration, unit, histogram, .. } = &measured;
            eprintln!(
                "{kernel:12} {configuration:34} histogram {histogram:5} int64 {:5} {all:6} operations, {wide:5} wide",
                variant.int64
            );
            emit(&json!({ "part": "counts", "kernel": kernel, "configuration": configuration, "unit": unit,
                "histogram": histogram, "int64": variant.int64, "operations": all, "wide": wide }));
        }
    }
}

const VARIANTS: [Variant; 2] = [
    Variant { int64: true, checked: false, workgroup: 64 },
    Variant { int64: false, checked: false, workgroup: 64 },
];

/// The operations of a trial, a run or a sample.
fn counted(measured: &Measured, variant: Variant) -> Operations {
    match &measured.work {
        Work::Trials(launch) => of_trial(launch, measured.histogram, variant),
        Work::Records(recipe) => of_sample(&**recipe, variant),
    }
}

/// The difference between an invocation of two trials and one of one trial.
fn of_trial(launch: &Launch, histogram: bool, variant: Variant) -> Operations {
    let (shader, _) = launch.shader(histogram, variant);
    let known = |words: &[u32]| words.iter().copied().map(Some).collect::<Vec<_>>();
    let of = |trials: u32| {
        let given = |name: &str| match name {
            "parameters" => Some(known(&launch.parameters(0))),
            // The number of the first trial is unknown, and so are those of all.
            "jobs" => Some(vec![None, Some(0), Some(trials * variant.workgroup), Some(0), Some(0)]),
            "table" => Some(known(launch.table())),
            _ => None,
        };
        operations(&shader, &given)
    };
    let (one, two) = (of(1), of(2));
    Operations { all: two.all - one.all, wide: two.wide - one.wide }
}

/// The mean of some samples from the middle of a record; where a sample has many steps, the mean of the steps at its start.
fn of_sample(recipe: &dyn Recorded, variant: Variant) -> Operations {
    let steps = recipe.steps() / u64::from(recipe.curve().samples);
    let (first, chunks) = if steps > 1 { (0, 1) } else { (256, 32) };
    let (shader, _) = recipe.shader(variant);
    let parameters = recipe.parameters(0, 64, [first, first + chunks]);
    let given = |name: &str| (name == "p").then(|| parameters.iter().copied().map(Some).collect());
    let Operations { all, wide } = operations(&shader, &given);
    let count = u64::from(chunks) * CHUNK as u64 * steps;
    Operations { all: (all + count / 2) / count, wide: (wide + count / 2) / count }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_program_knows_how_many_operations_its_kernels_need() {
        let of = |measured: &Measured| VARIANTS.map(|variant| counted(measured, variant).all as u32);
        let told = |measured: &Measured| VARIANTS.map(|variant| measured.operations(variant));
        let line = |measured: &Measured, counts| {
            format!("{}, {}: {counts:?}", measured.kernel, measured.configuration)
        };
        let found: Vec<String> = measured().iter().map(|measured| line(measured, of(measured))).collect();
        let known: Vec<String> = measured().iter().map(|measured| line(measured, told(measured))).collect();
        assert_eq!(found, known, "counted on the left, src/verify/measured.rs on the right");
    }
}
