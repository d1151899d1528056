//! Changes of a shader's text whose effect is measured.

/// A change of a shader.
pub struct Edit {
    pub name: &'static str,
    /// Whether the sums stay the same. An ablation leaves work out to show what that work costs.
    pub keeps_sums: bool,
    /// The changed text, where the change applies; the flag is that of 64-bit products.
    pub apply: fn(&str, bool) -> Option<String>,
}

const fn edit(name: &'static str, apply: fn(&str, bool) -> Option<String>) -> Edit {
    Edit { name, keeps_sums: true, apply }
}

const fn ablation(name: &'static str, apply: fn(&str, bool) -> Option<String>) -> Edit {
    Edit { name, keeps_sums: false, apply }
}

pub const PLAIN: Edit = edit("as it is", |text, _| Some(text.to_owned()));
pub const ONE_PRODUCT: Edit = edit("Philox: both halves of one product", one_product);
pub const UNIFORM: Edit = edit("parameters read in place from a uniform buffer", uniform_in_place);

pub const EDITS: [Edit; 11] = [
    ONE_PRODUCT,
    UNIFORM,
    edit("parameters copied from a uniform buffer", uniform),
    edit("normal table in workgroup memory", shared_normals),
    edit("FLUSH 4", |text, _| flush(text, 4)),
    edit("FLUSH 16", |text, _| flush(text, 16)),
    ablation("ablation: no load of the normal table", no_normal_load),
    ablation("ablation: one round of Philox", one_philox_round),
    ablation("ablation: no squares", no_squares),
    ablation("ablation: no bins", no_bins),
    ablation("ablation: one bin for all trials", one_bin),
];

/// The text with one thing replaced, if it has it.
fn replaced(text: &str, what: &str, by: &str) -> Option<String> {
    text.contains(what).then(|| text.replace(what, by))
}

fn one_product(text: &str, int64: bool) -> Option<String> {
    let mut text = int64.then(|| text.to_owned())?;
    for (at, word) in [(0, "c.x"), (1, "c.z")] {
        let halves = format!(
            "let high{at} = mulhi(MULTIPLIER[{at}], {word});\n    let low{at} = MULTIPLIER[{at}] * {word};"
        );
        let one = format!(
            "let product{at} = u64(MULTIPLIER[{at}]) * u64({word});\n    let high{at} = u32(product{at} >> 32u);\n    \
             let low{at} = u32(product{at} & 0xfffffffflu);"
        );
        text = replaced(&text, &halves, &one)?;
    }
    Some(text)
}

/// The lab has one point.
fn uniform(text: &str, _: bool) -> Option<String> {
    let from = "var<storage, read> parameters: array<vec4<u32>>;";
    replaced(text, from, "var<uniform> parameters: array<vec4<u32>, PARAMETER_VECTORS>;")
}

fn uniform_in_place(text: &str, int64: bool) -> Option<String> {
    let text = uniform(text, int64)?;
    let text = replaced(&text, "var<private> p: array<u32, PARAMETER_WORDS>;", "")?;
    let text = replaced(&text, "    load_parameters(job.point);\n", "")?;
    let load = text.find("fn load_parameters(")?;
    let end = load + text[load..].find("\n}")? + 2;
    let text = format!("{}{}", &text[..load], &text[end..]);
    let (mut changed, mut rest) = (String::new(), text.as_str());
    while let Some(at) = rest.find("p[") {
        let is_word = |c: char| c.is_ascii_alphanumeric() || c == '_';
        let is_longer = rest[..at].ends_with(is_word);
        changed += &rest[..at];
        rest = &rest[at + 2..];
        if is_longer {
            changed += "p[";
            continue;
        }
        let mut depth = 1;
        let close = rest.find(|c| {
            depth += i32::from(c == '[') - i32::from(c == ']');
            depth == 0
        })?;
        let index = &rest[..close];
        changed += &format!("parameters[({index}) / 4u][({index}) % 4u]");
        rest = &rest[close + 1..];
    }
    Some(changed + rest)
}

fn shared_normals(text: &str, _: bool) -> Option<String> {
    let text = replaced(text, "let entry = normal_table[segment];", "let entry = shared_normals[segment];")?;
    let main = "@compute @workgroup_size(WORKGROUP)";
    let text =
        replaced(&text, main, &format!("var<workgroup> shared_normals: array<vec2<u32>, PAIRS>;\n{main}"))?;
    let load = "    load_parameters(job.point);\n";
    let copy = "    for (var i = lane; i < PAIRS; i += WORKGROUP) {\n        shared_normals[i] = normal_table[i];\n    }\n    \
                workgroupBarrier();\n";
    replaced(&text, load, &format!("{load}{copy}"))
}

/// An invocation carries its sums over to its totals after fewer trials.
fn flush(text: &str, trials: u32) -> Option<String> {
    replaced(text, "const FLUSH: u32 = 64u;", &format!("const FLUSH: u32 = {trials}u;"))
}

fn no_normal_load(text: &str, _: bool) -> Option<String> {
    let entry = "let entry = vec2<u32>(segment * 0x9E3779B9u + normal_table[14].x, segment ^ f);";
    replaced(text, "let entry = normal_table[segment];", entry)
}

fn one_philox_round(text: &str, _: bool) -> Option<String> {
    (1..10).try_fold(text.to_owned(), |text, round| {
        replaced(&text, &format!("    c = philox_round(c, keys[{round}u]);\n"), "")
    })
}

fn no_squares(text: &str, _: bool) -> Option<String> {
    replaced(text, "add_wide(sums.square, mul_wide(error, error))", "sums.square")
}

/// Counts a trial into its bin.
const COUNT: &str = "atomicAdd(&shared_words[";

fn no_bins(text: &str, _: bool) -> Option<String> {
    let keep = |line: &&str| !line.trim_start().starts_with(COUNT);
    text.contains(COUNT).then(|| text.lines().filter(keep).map(|line| format!("{line}\n")).collect())
}

fn one_bin(text: &str, _: bool) -> Option<String> {
    let line = |line: &str| match line.find(COUNT) {
        Some(at) => format!("{}{COUNT}0u], 1u);\n", &line[..at]),
        None => format!("{line}\n"),
    };
    text.contains(COUNT).then(|| text.lines().map(line).collect())
}

#[cfg(test)]
mod tests {
    use sagnac_kernel::shader::Variant;

    use super::*;

    #[test]
    fn every_edit_finds_its_text() {
        let bench = &crate::benches()[1];
        let variant = Variant { int64: true, checked: false, workgroup: 64 };
        let (text, _) = bench.launch.shader(bench.histogram, variant);
        for edit in &EDITS {
            let edited = (edit.apply)(&text, true);
            assert!(edited.is_some_and(|edited| edited != text), "{}: the shader has changed", edit.name);
        }
    }
}
