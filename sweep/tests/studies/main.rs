//! Studies as users run them. One program, which compiles and links what they share once; `many_parts.rs` reads the memory
//! of its process and stays one of its own.

#[path = "../common/mod.rs"]
mod common;
mod constraints;
mod distributions;
mod folders;
mod growing;
mod refusals;
mod rows;
mod whole;
