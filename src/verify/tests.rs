//! Every shader of every kernel is valid and has the layout that Rust assumes, tested without an adapter.

use super::*;
use crate::kernel::PARTS;
use crate::kernel::shader::Variant;

const VARIANTS: [(bool, u32); 4] = [(false, 32), (false, 64), (true, 64), (true, 128)];

fn variants() -> impl Iterator<Item = Variant> {
    VARIANTS.into_iter().map(|(int64, workgroup)| Variant { int64, checked: true, workgroup })
}

/// Parses and validates without a device.
fn validate((source, _): (String, bool)) -> naga::Module {
    let module = naga::front::wgsl::parse_str(&source)
        .unwrap_or_else(|error| panic!("{}\n{source}", error.emit_to_string(&source)));
    naga::valid::Validator::new(naga::valid::ValidationFlags::all(), naga::valid::Capabilities::SHADER_INT64)
        .validate(&module)
        .unwrap_or_else(|error| panic!("{error:?}"));
    module
}

fn size(module: &naga::Module, is_wanted: impl Fn(&naga::GlobalVariable) -> bool) -> Option<usize> {
    let (_, found) = module.global_variables.iter().find(|(_, global)| is_wanted(global))?;
    Some(module.types[found.ty].inner.size(module.to_ctx()) as usize)
}

fn named(name: &str) -> impl Fn(&naga::GlobalVariable) -> bool + '_ {
    move |global| global.name.as_deref() == Some(name)
}

/// Bytes of the uniform buffer; a structure has a word in each of its first members.
fn uniform(module: &naga::Module) -> Option<usize> {
    let is_uniform = |global: &naga::GlobalVariable| global.space == naga::AddressSpace::Uniform;
    let (_, global) = module.global_variables.iter().find(|(_, global)| is_uniform(global))?;
    if let naga::TypeInner::Struct { members, .. } = &module.types[global.ty].inner {
        let word = |ty| matches!(module.types[ty].inner, naga::TypeInner::Scalar(_));
        for (place, member) in members.iter().take_while(|member| word(member.ty)).enumerate() {
            assert_eq!(member.offset as usize, 4 * place, "{:?}", member.name);
        }
    }
    size(module, is_uniform)
}

#[test]
fn every_shader_of_every_kernel_is_valid_and_laid_out_as_in_rust() {
    for kernel in KERNELS {
        if let Form::Map(map) = kernel.form {
            variants().for_each(|variant| drop(validate(map.shader(variant))));
            continue;
        }
        let loads = loads(kernel);
        assert!(loads.iter().any(|load| load.self_test_units.is_some()), "{} has no self-test", kernel.name);
        for Load { name, work, .. } in &loads {
            for variant in variants() {
                let (modules, words) = match work {
                    Work::Trials(launch) => {
                        assert_eq!(launch.words.len(), launch.sampled.words(), "{name}");
                        let of = |histogram| validate(launch.shader(histogram, variant));
                        (vec![of(false), of(true)], launch.words.len())
                    }
                    Work::Records(recipe) => {
                        (vec![validate(recipe.shader(variant))], recipe.parameters(0, 1, [0, 1]).len())
                    }
                };
                for module in &modules {
                    assert_eq!(uniform(module), Some(words.div_ceil(4) * 16), "parameters of {name}");
                    let normals = size(module, named("normal_table"));
                    assert!(normals.is_none_or(|size| size == size_of::<crate::kernel::word::PairTable>()));
                    #[cfg(feature = "gpu")]
                    if let Some(size) = size(module, named("jobs")) {
                        assert_eq!(
                            size,
                            size_of::<crate::device::gpu::tile::Job>(),
                            "one element of the array"
                        );
                    }
                    let shared = size(module, named("shared_words")).unwrap_or(0);
                    // The limit that every device guarantees.
                    assert!(
                        variant.workgroup > 64 || shared <= 16384,
                        "{name}: {shared} bytes of a workgroup"
                    );
                }
            }
        }
    }
}

/// A file that no kernel includes would never be run.
#[test]
fn every_part_is_in_a_shader() {
    let variant = Variant { int64: false, checked: true, workgroup: 64 };
    let mut texts = String::new();
    for kernel in KERNELS {
        if let Form::Map(map) = kernel.form {
            texts += &map.shader(variant).0;
        }
        for load in loads(kernel) {
            texts += &match &load.work {
                Work::Trials(launch) => launch.shader(true, variant).0,
                Work::Records(recipe) => recipe.shader(variant).0,
            };
        }
    }
    for part in PARTS {
        let title = part.wgsl.lines().next().unwrap();
        assert!(texts.contains(title), "shaders/{}.wgsl is in no shader", part.stem);
    }
}
