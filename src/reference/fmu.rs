//! The page of the FMU's variables.

use super::{MADE, table};
use fmu::table::variable::Enumeration;
use fmu::table::variable::{Role, Type, Variability, Variable};
use report::number::shortest;

const HEAD: &str = "\
# FMU variables

Start values are those of the model from which the FMU was made. A *fixed* parameter can be set before initialisation. A
*tunable* parameter can also be set between steps, or in event mode. Units are SI; the FMU also declares display units such as
bar and mm.

";

const STROKE: &str = "
Within a communication step of co-simulation from t the piston follows x = `position` + `velocity` · (time − t), or the
derivative of `position` if the host has set one. If the host's next `position` differs from the position reached, the FMU moves
the piston by the difference adiabatically at the start of the next step, so that `volume` always belongs to `position`. If
`strokeInput` is `velocity`, the velocity alone moves the piston. Under Model Exchange `velocity` must be the rate of
`position`.
";

fn page() -> String {
    let mut page = format!("{MADE}{HEAD}");
    let of = |kind: fn(&Role) -> bool| fmu::table::table().iter().filter(move |v| kind(&v.role));
    page += &section("Inputs", of(|role| matches!(role, Role::Input(_))));
    page += STROKE;
    page += &section("Outputs", of(|role| matches!(role, Role::Output(_))));
    page += &section("Parameters", of(|role| matches!(role, Role::Parameter(_) | Role::Choice(_))));
    page += &section("States and their rates", of(|role| matches!(role, Role::State(_) | Role::Rate(_))));
    page
}

fn section<'a>(title: &str, variables: impl Iterator<Item = &'a Variable>) -> String {
    let rows = variables.map(|v| {
        let when = match v.variability {
            Variability::Fixed => "fixed",
            Variability::Tunable => "tunable",
            Variability::Continuous => "always",
        };
        let bounds = match (v.is, v.min, v.max) {
            (Type::Boolean, ..) => "false, true".to_owned(),
            (Type::Enumeration(choices), ..) => numbered(choices),
            (Type::Real, None, None) => "—".to_owned(),
            (Type::Real, Some(min), None) => format!("at least {}", shortest(min)),
            (Type::Real, None, Some(max)) => format!("at most {}", shortest(max)),
            (Type::Real, Some(min), Some(max)) => format!("{} to {}", shortest(min), shortest(max)),
        };
        let unit = if v.is == Type::Real { v.quantity.unit } else { "—" };
        [format!("`{}`", v.name), unit.to_owned(), bounds, when.to_owned(), v.description.clone()]
    });
    format!("\n## {title}\n\n{}", table(["variable", "unit", "bounds", "changes", ""], rows))
}

/// The items of an enumeration with their numbers.
fn numbered(of: &Enumeration) -> String {
    let items = of.items.iter().enumerate().map(|(i, (name, _))| format!("{} `{name}`", i + 1));
    items.collect::<Vec<_>>().join(", ")
}

#[test]
fn the_page_of_fmu_variables_is_their_table() {
    expect_test::expect_file!["../../book/src/reference/fmu.md"].assert_eq(&page());
}
