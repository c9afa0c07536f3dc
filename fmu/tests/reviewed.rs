//! The files shipped with the library are the reviewed ones: `UPDATE_EXPECT=1 cargo test -p pneutherm-fmu` rewrites them.

use expect_test::expect_file;
use fmu::identity::Identity;
use fmu::plant::values::Starts;
use fmu::{fmi2::description, package::documentation};

#[test]
fn the_model_description_is_the_reviewed_one() {
    let description = description::render(&Identity::reference(), &Starts::default(), None);
    expect_file!["../../modelDescription/modelDescription.xml"].assert_eq(&description.xml);
    expect_file!["../../modelDescription/guid.txt"].assert_eq(&format!("{}\n", description.guid));
}

#[test]
fn the_documentation_is_the_reviewed_one() {
    expect_file!["../../modelDescription/documentation/index.html"].assert_eq(&documentation::page(
        &Identity::reference(),
        &Starts::default(),
        &documentation::About::default(),
        &[],
    ));
}
