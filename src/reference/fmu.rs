//! The page of the FMU's variables.

use super::{MADE, number, table};
use fmu::table::{Role, Variability, Variable};

const HEAD: &str = "\
# FMU variables

Start values are those of the model that the FMU was made from. A parameter is *fixed* (set it before initialisation) or
*tunable* (between steps, or in event mode). Units are SI; the FMU declares them, with bar, mm and the like to display.

";

const STROKE: &str = "
Within a communication step of co-simulation from t the piston goes x = `position` + `velocity` · (time − t), or with the position's
derivative where the host has set one. Where the host's next `position` differs from what was reached, the volume is
taken there adiabatically at the start of the next step, so that `volume` always belongs to `position`. Where `strokeInput`
is `velocity`, the velocity alone moves the piston. Under Model Exchange `velocity` has to be the rate of `position`.
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
    let bound = |bound: Option<f64>| bound.map_or("—".to_owned(), number);
    let rows = variables.map(|v| {
        let when = match v.variability {
            Variability::Fixed => "fixed",
            Variability::Tunable => "tunable",
            Variability::Continuous => "always",
        };
        let bounds = match (v.min, v.max) {
            (None, None) => "—".to_owned(),
            (min, max) => format!("{} to {}", bound(min), bound(max)),
        };
        [format!("`{}`", v.name), v.quantity.unit.to_owned(), bounds, when.to_owned(), v.description.clone()]
    });
    format!("\n## {title}\n\n{}", table(["variable", "unit", "bounds", "changes", ""], rows))
}

#[test]
fn the_page_of_fmu_variables_is_their_table() {
    expect_test::expect_file!["../../book/src/reference/fmu.md"].assert_eq(&page());
}
