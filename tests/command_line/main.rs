//! The program as seen by a user: help, exit codes, error messages for bad input, nothing left behind.

mod bad_input;
mod common;
mod deliver;
mod evaluate;
mod help;
mod look;
mod output;
mod simulate;
