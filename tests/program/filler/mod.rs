//! `sagnac filler` as a user meets it: the weights of theory, the files, the C header against the test vectors.

mod choice;
mod fillers;
mod specification;
mod vectors;
mod weights;
