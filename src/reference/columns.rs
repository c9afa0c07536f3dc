//! The page of columns: those of traces, `simulate` and studies, and what a study can vary.

use super::{MADE, table};
use crate::simulation::columns::COLUMNS;
use records::layout::Quantity;
use sweep::result::outputs::{OUTPUTS, When};
use sweep::{quantity, traces};

fn page() -> String {
    let code = |name: &str| format!("`{name}`");
    let mut page = format!("{MADE}# Columns\n\n## Traces\n\n");
    page += &table(
        ["key in `[columns]`", "default column", "units"],
        Quantity::ALL.map(|q| [code(q.key()), code(q.default_name()), q.unit_names().collect::<Vec<_>>().join(", ")]),
    );
    page += "\nThe first unit is that of the default column. Columns of mercury are at 0 °C (13595.1 kg/m³), columns of water have \
             1000 kg/m³ (mmH2O, cmH2O, mH2O) or are at 4 °C (inH2O, 249.089 Pa), both under 9.80665 m/s². A pressure's unit may say from where \
             it counts: `mbar(a)`, `bar abs`, `psig`, `bar rel`.\n\n## Output of `simulate`\n\n";
    page += &table(["column", "unit", ""], COLUMNS.iter().map(|c| [code(c.name), c.unit.to_owned(), c.doc.to_owned()]));
    page += "\nWith `--samples` each column but time has two more, the ends of its prediction band: `pressure_low_pa`, `pressure_high_pa` \
             and so on. The band of `pressure_pa` is that of a future record, noise included.\n";
    page += "\n## Output of `sweep`\n\nThe columns are `row` (the number of the row in the design), each varied quantity under its own name, and\n\n";
    page += &table(
        ["column", "unit", ""],
        OUTPUTS.iter().map(|o| {
            let when = match o.when {
                When::Always => String::new(),
                When::Fit => " (with `fit = true`)".to_owned(),
                When::Solved(base) => format!(" (where `{}` varies)", quantity::all()[base as usize].name),
            };
            [code(o.name), o.unit.to_owned(), format!("{}{when}", o.doc)]
        }),
    );
    page += "\nPressures are those that the sensor of the model shows, with its lag, delay, offset and drift, and with a curve of the \
             reading\n(the effect `empirical` with `balance = \"reading\"`).\n";
    page += "\nand `status`, which is one of\n\n\
             - `ok`;\n\
             - `not_settled`: the test ends before the pressure has settled;\n\
             - `no_time_constant` (with `fit = true`): the relaxation is not an exponential, for instance because of a leak. It deviates \
             from one by more than 5 % of its rise, and by more than the relaxation of a closed chamber would;\n\
             - `left_out: ` and the constraint of `[vary]` that the row breaks;\n\
             - `failed: ` and the reason.\n";
    page += "\n## Output of `sweep --traces`\n\nThe columns are `row` and\n\n";
    page += &table(
        ["column", "unit", ""],
        traces::COLUMNS.iter().map(|c| [code(c.name), c.unit.to_owned(), c.doc.to_owned()]),
    );
    page +=
        "\n## Quantities that a study can vary\n\nUse the dotted name, or its last part if that is unambiguous.\n\n";
    page += &table(
        ["quantity", "unit", "values", ""],
        (0..)
            .zip(quantity::all())
            .filter(|(index, _)| !quantity::is_of_recorded_stroke(*index) && !quantity::is_of_table(*index))
            .map(|(_, q)| [code(&q.name), q.unit.to_owned(), q.allowed.to_string(), q.doc.to_owned()]),
    );
    page
}

#[test]
fn the_page_of_columns_is_what_the_code_declares() {
    expect_test::expect_file!["../../book/src/reference/columns.md"].assert_eq(&page());
}
