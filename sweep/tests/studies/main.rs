//! Studies as run by users. One program, which compiles and links the shared code once; `many_parts.rs` reads the memory of its
//! process and stays separate.

#[path = "../common/mod.rs"]
mod common;
mod constraints;
mod distributions;
mod folders;
mod growing;
mod refusals;
mod rows;
mod whole;
