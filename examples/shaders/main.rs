//! Writes the shaders of all kernels with their inputs and results, to check any other stack of compilers and drivers.
//!
//! ```text
//! shaders DIR
//! ```
//! `DIR/check.html` checks them in a browser with WebGPU; docs/dev/numerics.md explains `DIR/shaders.json` for other hosts.

mod files;

fn main() -> std::io::Result<()> {
    let folder = std::env::args().nth(1).expect("a folder for the shaders");
    std::fs::create_dir_all(&folder)?;
    for (name, text) in files::files() {
        std::fs::write(std::path::Path::new(&folder).join(name), text)?;
    }
    println!("open {folder}/check.html in a browser with WebGPU: it runs the shaders and compares all words");
    Ok(())
}
