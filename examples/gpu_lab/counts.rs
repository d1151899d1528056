//! Part `counts`: the integer operations of each measured kernel.

use sagnac::device::Work;
use sagnac::verify::{Measured, measured};
use sagnac_kernel::curve::Recorded;
use sagnac_kernel::launch::Launch;
use sagnac_kernel::recipe::CHUNK;
use sagnac_kernel::shader::Variant;
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

    /// The figures of docs/dev/performance.md, with 64-bit products and with 16-bit ones.
    const KNOWN: [[u64; 2]; 13] = [
        [552, 1743],
        [630, 1821],
        [786, 2853],
        [1479, 5985],
        [605, 1619],
        [14_058, 46_641],
        [398, 1587],
        [1208, 4933],
        [1834, 7195],
        [266, 811],
        [319, 1008],
        [30, 123],
        [219, 741],
    ];

    #[test]
    fn the_operations_are_those_of_the_documents() {
        let of = |measured: &Measured| VARIANTS.map(|variant| counted(measured, variant).all);
        let line = |(measured, counts): (&Measured, _)| {
            format!("{}, {}: {counts:?}", measured.kernel, measured.configuration)
        };
        let measured = measured();
        let found: Vec<String> = measured.iter().map(|measured| line((measured, of(measured)))).collect();
        let known: Vec<String> = measured.iter().zip(KNOWN).map(line).collect();
        assert_eq!(found, known, "counted on the left, those of docs/dev/performance.md on the right");
    }
}
