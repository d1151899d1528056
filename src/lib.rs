pub mod backend;
pub mod kernel;
