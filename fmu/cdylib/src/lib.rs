//! The FMU's shared library.
