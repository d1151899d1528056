//! Shader sources: the files of `shaders/`, assembled and specialized as text.
//!
//! Override constants can give invalid modules (wgpu#7793), so shapes and variants are written into the text. Three
//! directives do this, each on its own line and closed by `//#end`: `//#for k in 0..N` repeats its lines with the word
//! `k` replaced by 0u, 1u, …; `//#if FLAG` and `//#else` choose between lines.

use std::collections::HashMap;

use crate::part;

/// A file of `shaders/`, with the constants that it takes from its twin.
#[derive(Debug)]
pub struct Part {
    /// The stem of both files.
    pub stem: &'static str,
    /// The text of the shader file.
    pub wgsl: &'static str,
    /// The constants that Rust generates into the shader.
    pub constants: fn() -> Constants,
}

/// Constants of a shader by name.
pub type Constants = Vec<(String, Value)>;

/// The value of a constant.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Value {
    /// A word.
    Word(usize),
    /// An array of words.
    Words(Vec<u32>),
}

impl From<u32> for Value {
    fn from(word: u32) -> Value {
        Value::Word(word as usize)
    }
}

impl From<u64> for Value {
    fn from(word: u64) -> Value {
        Value::Word(word as usize)
    }
}

impl From<usize> for Value {
    fn from(word: usize) -> Value {
        Value::Word(word)
    }
}

impl<const N: usize> From<[u32; N]> for Value {
    fn from(words: [u32; N]) -> Value {
        Value::Words(words.to_vec())
    }
}

/// Declares the constants of a module that its shader takes.
macro_rules! constants {
    ($($name:ident),* $(,)?) => {
        /// The constants that the shader takes from this module.
        pub(crate) fn constants() -> crate::shader::Constants {
            vec![$((stringify!($name).to_owned(), $name.into())),*]
        }
    };
}

pub(crate) use constants;

/// How a kernel is built for a device. All variants give the same bits.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct Variant {
    /// Whether products use 64-bit registers instead of 16-bit parts.
    pub int64: bool,
    /// Whether the shader compiler adds its bounds checks.
    pub checked: bool,
    /// Invocations per workgroup, a power of two.
    pub workgroup: u32,
}

impl Variant {
    /// What products are made of, in messages.
    pub fn products(self) -> &'static str {
        if self.int64 { "64-bit products" } else { "16-bit products" }
    }
}

/// A shader before its text is generated.
#[derive(Debug, Default)]
pub struct Shader {
    /// Its files, except [`part::word`], which every shader has.
    pub parts: Vec<&'static Part>,
    /// Constants besides those of the files.
    pub constants: Vec<(&'static str, usize)>,
    /// The conditions of the directives, each with its value.
    pub flags: Vec<(&'static str, bool)>,
    /// Declarations generated for this shader.
    pub declarations: String,
}

impl Shader {
    /// Whether normal numbers are drawn; their table is bound only then.
    pub fn has_normals(&self) -> bool {
        self.parts.iter().any(|&own| core::ptr::eq(own, &part::normal))
    }

    /// The WGSL text.
    pub fn text(&self, variant: Variant) -> String {
        let parts: Vec<&Part> = [&part::word].into_iter().chain(self.parts.iter().copied()).collect();
        let mut constants: Constants = parts.iter().flat_map(|part| (part.constants)()).collect();
        constants.push(("WORKGROUP".to_owned(), variant.workgroup.into()));
        constants.extend(self.constants.iter().map(|&(name, value)| (name.to_owned(), value.into())));
        let mut text: String = constants.iter().map(declaration).collect();
        text += &self.declarations;

        let counts = constants.iter().filter_map(|(name, value)| match value {
            Value::Word(word) => Some((name.as_str(), *word)),
            Value::Words(_) => None,
        });
        let int64 = [("INT64", variant.int64)];
        let flags = self.flags.iter().chain(&int64).filter(|flag| flag.1);
        let expansion = Expansion { counts: counts.collect(), flags: flags.map(|flag| flag.0).collect() };
        let lines: Vec<&str> = parts.iter().flat_map(|part| part.wgsl.lines()).collect();
        expansion.expand_all(&lines, &mut text);
        text
    }
}

fn declaration((name, value): &(String, Value)) -> String {
    match value {
        Value::Word(word) => format!("const {name}: u32 = {word}u;\n"),
        Value::Words(words) => {
            let list: Vec<String> = words.iter().map(|word| format!("{word}u")).collect();
            format!("const {name} = array<u32, {}>({});\n", words.len(), list.join(", "))
        }
    }
}

/// The names to which directives refer.
struct Expansion<'a> {
    counts: HashMap<&'a str, usize>,
    flags: Vec<&'a str>,
}

impl Expansion<'_> {
    fn expand_all(&self, lines: &[&str], to: &mut String) {
        let mut at = 0;
        while at < lines.len() {
            at = self.expand(lines, at, to);
        }
    }

    /// Expands the line `at`, or the directive that starts there, and returns the index of the next line.
    fn expand(&self, lines: &[&str], at: usize, to: &mut String) -> usize {
        let line = lines[at].trim();
        if let Some(rest) = line.strip_prefix("//#for ") {
            let (name, range) = rest.split_once(" in 0..").expect("for NAME in 0..COUNT");
            let count = *self.counts.get(range).expect("a known count");
            let end = block_end(lines, at);
            for value in 0..count {
                let by = format!("{value}u");
                let body: Vec<String> =
                    lines[at + 1..end].iter().map(|line| replace_word(line, name, &by)).collect();
                self.expand_all(&body.iter().map(String::as_str).collect::<Vec<_>>(), to);
            }
            end + 1
        } else if let Some(flag) = line.strip_prefix("//#if ") {
            let end = block_end(lines, at);
            let is_middle = |&i: &usize| depth(&lines[at + 1..i]) == 0 && lines[i].trim() == "//#else";
            let middle = (at + 1..end).find(is_middle);
            let chosen = match (self.flags.contains(&flag), middle) {
                (true, middle) => at + 1..middle.unwrap_or(end),
                (false, middle) => middle.map_or(end, |middle| middle + 1)..end,
            };
            self.expand_all(&lines[chosen], to);
            end + 1
        } else {
            to.push_str(lines[at]);
            to.push('\n');
            at + 1
        }
    }
}

/// The line of the `//#end` that closes the directive at `start`.
fn block_end(lines: &[&str], start: usize) -> usize {
    (start + 1..lines.len())
        .find(|&i| lines[i].trim() == "//#end" && depth(&lines[start + 1..i]) == 0)
        .expect("a directive is closed")
}

/// Number of directives that `lines` open and do not close.
fn depth(lines: &[&str]) -> i32 {
    lines
        .iter()
        .map(|line| match line.trim() {
            "//#end" => -1,
            line if line.starts_with("//#for ") || line.starts_with("//#if ") => 1,
            _ => 0,
        })
        .sum()
}

/// `line` with the whole word `name` replaced.
fn replace_word(line: &str, name: &str, by: &str) -> String {
    if line.trim().starts_with("//") && !line.trim().starts_with("//#") {
        return line.to_owned();
    }
    let in_word = |c: char| c.is_alphanumeric() || c == '_';
    let mut replaced = String::new();
    let mut rest = line;
    while let Some(found) = rest.find(name) {
        replaced += &rest[..found];
        let whole = !replaced.ends_with(in_word) && !rest[found + name.len()..].starts_with(in_word);
        replaced += if whole { by } else { name };
        rest = &rest[found + name.len()..];
    }
    replaced + rest
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_are_replaced_whole() {
        assert_eq!(replace_word("k + kk + _k + p(k)", "k", "3u"), "3u + kk + _k + p(3u)");
    }
}
