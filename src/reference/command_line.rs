//! The page of commands, from clap's definitions.

use super::MADE;
use clap::{Command, CommandFactory};
use std::fmt::Write;

fn page() -> String {
    let mut program = crate::Cli::command().term_width(100);
    program.build();
    let mut page =
        format!("{MADE}# Command line\n\nThis is the output of `pneutherm --help` and `pneutherm COMMAND --help`.\n");
    section(&mut page, &mut program);
    for command in program.get_subcommands_mut().filter(|c| c.get_name() != "help" && !c.is_hide_set()) {
        section(&mut page, command);
    }
    page
}

fn section(page: &mut String, command: &mut Command) {
    let name = command.get_bin_name().unwrap_or(command.get_name()).to_owned();
    let help = command.render_long_help().to_string();
    let help: String = help.lines().map(|line| format!("{}\n", line.trim_end())).collect();
    write!(page, "\n## {name}\n\n```text\n{help}```\n").expect("a String takes all");
}

#[test]
fn the_page_of_commands_agrees_with_the_program_s_help() {
    expect_test::expect_file!["../../book/src/reference/command-line.md"].assert_eq(&page());
}
