//! Every variant of every shader is valid, and laid out as Rust has it.

use super::*;
use crate::kernel::gap_fill::POLYNOMIALS;
use crate::kernel::map;

const PLAIN: Shape = POLYNOMIALS;

const SHAPES: [Shape; 8] = [
    PLAIN,
    Shape { before: 9, after: 6, residual_before: 9, fillers: 1, wide: true, tones: 8, ..PLAIN },
    Shape { after: 0, residual: false, tones: 0, fillers: 2, constants: true, readout: true, ..PLAIN },
    Shape { in_gap: true, gap_ticks: 5, fillers: 2, amplitudes: true, ..PLAIN },
    Shape { in_gap: true, gap_ticks: 5, fillers: 1, frequencies: true, tones: 2, wide: true, ..PLAIN },
    Shape { gaussian: true, gap_ticks: 3, in_gap: true, fillers: 2, constants: true, ..PLAIN },
    Shape { profile: true, tones: 0, readout: true, ..PLAIN },
    Shape { profile: true, every: true, in_gap: true, gap_ticks: 2, fillers: 2, ..PLAIN },
];

const RUN: switched_run::Shape = switched_run::Shape {
    ends: true,
    times: 0,
    walk: false,
    noise: false,
    tones: 0,
    magnetic: false,
    initial: false,
    non_magnetic: false,
    mode: false,
    warm_up: false,
    relock: None,
};

const RUNS: [switched_run::Shape; 4] = [
    RUN,
    switched_run::Shape {
        relock: Some(relock_ticks::Shape { ticks: 4, method: Method::Detuning }),
        warm_up: true,
        ..RUN
    },
    switched_run::Shape { ends: false, times: 4, walk: true, noise: true, tones: 1, mode: true, ..RUN },
    switched_run::Shape {
        tones: 8,
        times: 1,
        walk: true,
        magnetic: true,
        initial: true,
        non_magnetic: true,
        mode: true,
        ..RUN
    },
];

fn variants() -> impl Iterator<Item = Variant> {
    [(false, 32), (false, 64), (true, 64), (true, 128)].into_iter().map(|(int64, workgroup)| Variant {
        int64,
        checked: true,
        workgroup,
    })
}

/// Parses and validates without a device.
fn validate(source: &str) -> naga::Module {
    let module = naga::front::wgsl::parse_str(source)
        .unwrap_or_else(|error| panic!("{}\n{source}", error.emit_to_string(source)));
    naga::valid::Validator::new(naga::valid::ValidationFlags::all(), naga::valid::Capabilities::SHADER_INT64)
        .validate(&module)
        .unwrap_or_else(|error| panic!("{error:?}"));
    module
}

#[test]
fn every_variant_of_every_kernel_is_valid() {
    for variant in variants() {
        for shape in SHAPES {
            for histogram in [false, true] {
                validate(&moments(Sampled::GapFill(shape), histogram, variant));
            }
        }
        for shape in RUNS {
            validate(&moments(Sampled::SwitchedRun(shape), true, variant));
        }
        for ticks in [1, 4, 8] {
            for method in [Method::None, Method::Frequency, Method::Detuning] {
                let ticks = relock_ticks::Shape { ticks, method };
                let shape = relock::Shape { ticks, estimates: 6 };
                validate(&moments(Sampled::Relock(shape), true, variant));
            }
        }
        for block in [map::PHILOX, map::NORMAL, map::SINE, map::POWER] {
            validate(&crate::device::gpu::source::map(&block, variant));
        }
    }
}

#[test]
fn the_layouts_are_those_of_rust() {
    let variant = Variant { int64: false, checked: true, workgroup: 64 };
    let module = validate(&moments(Sampled::GapFill(SHAPES[0]), true, variant));
    let size = |name: &str| {
        let (_, global) =
            module.global_variables.iter().find(|(_, v)| v.name.as_deref() == Some(name)).unwrap();
        module.types[global.ty].inner.size(module.to_ctx()) as usize
    };
    assert_eq!(size("parameters"), shape::word_count(SHAPES[0]).div_ceil(4) * 16);
    assert_eq!(size("normal_table"), size_of::<crate::kernel::word::PairTable>());
    assert_eq!(
        size("jobs"),
        size_of::<crate::device::gpu::tile::Job>(),
        "one element of a runtime-sized array"
    );
    let shared = size("shared_words");
    assert!(shared <= 16384, "{shared} bytes of workgroup memory: more than every device has");
}

#[test]
fn words_are_replaced_whole() {
    assert_eq!(replace_word("k + kk + _k + p(k)", "k", "3u"), "3u + kk + _k + p(3u)");
}
