//! The page of results as one HTML file that can be sent to a colleague, and a gallery of several results.
//!
//! ```text
//! answer, sections, tables ─▶ Page ─┬ html ─▶ one file: text, styles, data, script; no network
//!                                   ├ text ─▶ terminal
//!                                   └ card ─▶ gallery of several results
//! ```
//!
//! A page has still pictures of its charts. Its script replaces them by charts that it draws from the numbers of the
//! pictures, so that curves can be switched, axes changed and values read. The script is our own, some tens of kilobytes. A chart library with bands, closed forms under points,
//! winner maps with hatching, slices, keyboard control and printing takes a megabyte, or uses a canvas that neither
//! prints sharply nor works with a screen reader.

mod data;
pub mod document;
pub mod gallery;
mod html;
pub mod sections;
mod text;

pub use crate::page::gallery::{Card, MARKS, gallery};

/// The name of a page in its folder of results.
pub const FILE: &str = "report.html";
