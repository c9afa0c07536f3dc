//! Linker arguments that an extension module needs on some platforms: Python's own symbols come from the interpreter.

fn main() {
    pyo3_build_config::add_extension_module_link_args();
}
