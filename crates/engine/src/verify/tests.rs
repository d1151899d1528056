//! Every shader of every kernel is valid and has the layout that Rust assumes, tested without an adapter.

use super::*;
use crate::device::remote::{Dispatch, Remote, Runner};
use sagnac_kernel::PARTS;
use sagnac_kernel::shader::Variant;

const VARIANTS: [(bool, u32); 4] = [(false, 32), (false, 64), (true, 64), (true, 128)];

fn variants() -> impl Iterator<Item = Variant> {
    VARIANTS.into_iter().map(|(int64, workgroup)| Variant { int64, checked: true, workgroup })
}

/// Parses and validates without a device, with no capability but 64-bit integers where the variant has them.
pub fn validate(source: &str, variant: Variant) -> (naga::Module, naga::valid::ModuleInfo) {
    let module = naga::front::wgsl::parse_str(source)
        .unwrap_or_else(|error| panic!("{}\n{source}", error.emit_to_string(source)));
    let mut capabilities = naga::valid::Capabilities::empty();
    capabilities.set(naga::valid::Capabilities::SHADER_INT64, variant.int64);
    let info = naga::valid::Validator::new(naga::valid::ValidationFlags::all(), capabilities)
        .validate(&module)
        .unwrap_or_else(|error| panic!("{error:?}"));
    (module, info)
}

/// A shader of a load, with the bytes of its parameters.
pub struct Text {
    pub name: &'static str,
    text: String,
    parameters: Option<usize>,
}

/// Every shader of every kernel.
fn texts(variant: Variant) -> Vec<Text> {
    let of_load = |Workload { name, work, .. }: Workload| match &work {
        Work::Trials(launch) => {
            assert_eq!(launch.words().len(), launch.sampled().words(), "{name}");
            let parameters = Some(4 * launch.words().len());
            let of = |histogram| Text { name, text: launch.shader(histogram, variant).0, parameters };
            vec![of(false), of(true)]
        }
        Work::Records(recipe) => {
            let parameters = Some(4 * recipe.parameters(0, 1, [0, 1]).len());
            vec![Text { name, text: recipe.shader(variant).0, parameters }]
        }
    };
    let of_kernel = |kernel: &Kernel| match kernel.form {
        Form::Map(map) => vec![Text { name: kernel.name, text: map.shader(variant).0, parameters: None }],
        Form::Moments | Form::Records => loads(kernel).into_iter().flat_map(of_load).collect(),
    };
    KERNELS.iter().flat_map(of_kernel).collect()
}

pub fn size(module: &naga::Module, is_wanted: impl Fn(&naga::GlobalVariable) -> bool) -> Option<usize> {
    let (_, found) = module.global_variables.iter().find(|(_, global)| is_wanted(global))?;
    Some(module.types[found.ty].inner.size(module.to_ctx()) as usize)
}

pub fn named(name: &str) -> impl Fn(&naga::GlobalVariable) -> bool + '_ {
    move |global| global.name.as_deref() == Some(name)
}

/// Bytes of the parameters; a structure has a word in each of its first members.
pub fn size_of_parameters(module: &naga::Module) -> Option<usize> {
    let (_, global) = module.global_variables.iter().find(|(_, global)| named("p")(global))?;
    if let naga::TypeInner::Struct { members, .. } = &module.types[global.ty].inner {
        let word = |ty| matches!(module.types[ty].inner, naga::TypeInner::Scalar(_));
        for (place, member) in members.iter().take_while(|member| word(member.ty)).enumerate() {
            assert_eq!(member.offset as usize, 4 * place, "{:?}", member.name);
        }
    }
    size(module, named("p"))
}

#[test]
fn every_shader_of_every_kernel_is_valid_and_laid_out_as_in_rust() {
    for variant in variants() {
        for Text { name, text, parameters } in texts(variant) {
            let (module, _) = validate(&text, variant);
            assert_eq!(size_of_parameters(&module), parameters, "parameters of {name}");
            let normals = size(&module, named("normal_table"));
            assert!(normals.is_none_or(|size| size == size_of::<sagnac_kernel::word::PairTable>()));
            #[cfg(feature = "gpu")]
            if let Some(size) = size(&module, named("jobs")) {
                assert_eq!(size, 4 * crate::device::tile::JOB_WORDS, "one element of the array");
            }
            let shared = size(&module, named("shared_words")).unwrap_or(0);
            // The limit that every device guarantees.
            assert!(variant.workgroup > 64 || shared <= 16384, "{name}: {shared} bytes of a workgroup");
        }
    }
}

#[test]
fn every_kernel_with_loads_has_a_self_test() {
    for kernel in KERNELS {
        let loads = loads(kernel);
        let is_tested = loads.iter().any(|load| load.self_test_units.is_some());
        assert!(is_tested || matches!(kernel.form, Form::Map(_)), "{} has no self-test", kernel.name);
    }
}

/// A file that no kernel includes would never be run.
#[test]
fn every_part_is_in_a_shader() {
    let variant = Variant { int64: false, checked: true, workgroup: 64 };
    let texts: String = texts(variant).into_iter().map(|shader| shader.text).collect();
    for part in PARTS {
        let title = part.wgsl.lines().next().unwrap();
        assert!(texts.contains(title), "shaders/{}.wgsl is in no shader", part.stem);
    }
}

/// What wgpu's backends hand to a driver, written by the same functions with the options that they derive from a
/// variant: those of `wgpu-hal` are private, so the lines that read the runtime checks are repeated here.
#[cfg(feature = "gpu")]
mod backend {
    pub use naga::ShaderStage::Compute;
    pub use naga::back::{hlsl, msl, spv};
    pub use naga::proc::{BoundsCheckPolicies, BoundsCheckPolicy};
    pub use naga::valid::ModuleInfo;

    use super::*;
    use crate::device::gpu::runtime_checks;

    /// How wgpu's backends for Vulkan, Metal and DX12 write a module.
    type Write = fn(&naga::Module, &ModuleInfo, Variant) -> Vec<u8>;
    const BACKENDS: [(&str, Write); 3] = [("SPIR-V", spir_v), ("MSL", metal), ("HLSL", hlsl)];

    fn policies(variant: Variant) -> BoundsCheckPolicies {
        let checks = runtime_checks(variant).bounds_checks;
        let policy = if checks { BoundsCheckPolicy::Restrict } else { BoundsCheckPolicy::Unchecked };
        BoundsCheckPolicies { index: policy, buffer: policy, ..BoundsCheckPolicies::default() }
    }

    pub fn spir_v(module: &naga::Module, info: &ModuleInfo, variant: Variant) -> Vec<u8> {
        let checks = runtime_checks(variant);
        let int64 = variant.int64.then_some(spv::Capability::Int64);
        let workgroup_memory = match variant.checked {
            true => spv::ZeroInitializeWorkgroupMemoryMode::Polyfill,
            false => spv::ZeroInitializeWorkgroupMemoryMode::None,
        };
        let options = spv::Options {
            // With the names of variables, which tell naga's counters from those of the kernels.
            flags: spv::WriterFlags::DEBUG,
            capabilities: Some([spv::Capability::Shader].into_iter().chain(int64).collect()),
            bounds_check_policies: policies(variant),
            zero_initialize_workgroup_memory: workgroup_memory,
            force_loop_bounding: checks.force_loop_bounding,
            emit_int_div_checks: checks.int_div_checks,
            ..spv::Options::default()
        };
        let entry = spv::PipelineOptions { shader_stage: Compute, entry_point: "main".to_owned() };
        let words = spv::write_vec(module, info, &options, Some(&entry));
        words.unwrap_or_else(|error| panic!("{error}")).iter().flat_map(|word| word.to_le_bytes()).collect()
    }

    pub fn metal(module: &naga::Module, info: &ModuleInfo, variant: Variant) -> Vec<u8> {
        let checks = runtime_checks(variant);
        let options = msl::Options {
            lang_version: (2, 4),
            bounds_check_policies: policies(variant),
            zero_initialize_workgroup_memory: variant.checked,
            force_loop_bounding: checks.force_loop_bounding,
            emit_int_div_checks: checks.int_div_checks,
            ..msl::Options::default()
        };
        let entry =
            msl::PipelineOptions { entry_point: Some((Compute, "main".to_owned())), ..Default::default() };
        let (text, translated) = msl::write_string(module, info, &options, &entry).unwrap();
        translated.entry_point_names[0].as_ref().unwrap();
        text.into_bytes()
    }

    pub fn hlsl(module: &naga::Module, info: &ModuleInfo, variant: Variant) -> Vec<u8> {
        let checks = runtime_checks(variant);
        let options = hlsl::Options {
            // 64-bit integers exist from 6.0 on.
            shader_model: if variant.int64 { hlsl::ShaderModel::V6_0 } else { hlsl::ShaderModel::V5_1 },
            zero_initialize_workgroup_memory: variant.checked,
            restrict_indexing: checks.bounds_checks,
            force_loop_bounding: checks.force_loop_bounding,
            ..hlsl::Options::default()
        };
        let entry = hlsl::PipelineOptions { entry_point: Some((Compute, "main".to_owned())) };
        let mut text = String::new();
        let translated = hlsl::Writer::new(&mut text, &options, &entry).write(module, info, None).unwrap();
        translated.entry_point_names[0].as_ref().unwrap();
        text.into_bytes()
    }

    /// A counter in each loop, which naga adds against endless ones, would cost the kernels time.
    #[test]
    fn every_backend_takes_every_shader_and_bounds_the_loops_of_checked_ones_alone() {
        for (int64, checked) in [(false, false), (false, true), (true, false), (true, true)] {
            let variant = Variant { int64, checked, workgroup: 64 };
            for Text { name, text, .. } in texts(variant) {
                let (module, info) = validate(&text, variant);
                for (backend, write) in BACKENDS {
                    let written = write(&module, &info, variant);
                    let counter = b"loop_bound";
                    let has_counter = written.windows(counter.len()).any(|window| window == counter);
                    assert_eq!(has_counter, checked, "{name} in {backend}: a counter in loops, {variant:?}");
                }
            }
        }
    }
}

/// Answers every dispatch by its number of words.
struct Answer(fn(usize) -> Result<Option<Vec<u32>>, String>);

impl Runner for Answer {
    fn name(&self) -> String {
        "elsewhere".to_owned()
    }

    fn run(&mut self, dispatch: Dispatch) -> Result<Option<Vec<u32>>, String> {
        (self.0)(dispatch.words())
    }
}

#[test]
fn a_device_elsewhere_that_answers_otherwise_than_the_processor_is_not_believed() {
    let device = |answer| Device::Remote(Remote::new(Box::new(Answer(answer))));
    for kernel in KERNELS {
        let name = kernel.name;
        if let Form::Map(map) = &kernel.form {
            let items = items(map, 0..8);
            let ones = device(|words| Ok(Some(vec![1; words]))).map(map, &items).unwrap();
            assert_ne!(ones, (map.cpu)(Width::PORTABLE, &items), "{name}");
            assert!(matches!(device(|_| Ok(Some(vec![]))).map(map, &items), Err(GpuError::Refused(_))));
            continue;
        }
        let load = loads(kernel).into_iter().next().unwrap();
        let answered = |answer| on_device(&mut device(answer), &load.work, 2);
        assert!(answered(|_| Ok(None)).is_ok(), "{name}: not known yet");
        let wrong = [answered(|words| Ok(Some(vec![0; words]))), answered(|words| Ok(Some(vec![1; words])))];
        assert!(wrong.iter().all(|found| matches!(found, Err(GpuError::WrongBits))), "{name}: {wrong:?}");
        let refused =
            [answered(|words| Ok(Some(vec![0; words + 1]))), answered(|_| Err("it is lost".to_owned()))];
        assert!(
            refused.iter().all(|found| matches!(found, Err(GpuError::Refused(_)))),
            "{name}: {refused:?}"
        );
    }
}
