//! `sagnac filler` as a user meets it: the weights of theory, the files, the C header against the test vectors.

mod choice;
#[path = "../desk/mod.rs"]
mod desk;
mod fillers;
mod vectors;
mod weights;
