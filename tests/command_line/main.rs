//! The program as a user meets it: help, exit codes, sentences on bad input, nothing left behind.

mod bad_input;
mod common;
mod deliver;
mod evaluate;
mod help;
mod look;
mod output;
mod simulate;
