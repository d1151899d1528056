pub mod gap_fill;
pub mod map;
pub mod moments;
pub mod normal;
pub(crate) mod normal_table;
pub mod philox;
pub mod sine;
pub mod word;
