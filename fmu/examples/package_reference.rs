//! Packages libraries as built into an FMU of the reference chamber, without the command line: for tests of the library
//! itself. `package_reference OUT.fmu PLATFORM=LIBRARY…`; of FMI 3.0 where the environment has `FMI3`

use fmu::package::documentation::About;
use fmu::package::identity::Identity;
use fmu::package::{Contents, Library, Version, package};
use fmu::plant::values::Starts;
use std::path::Path;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [out, libraries @ ..] = arguments.as_slice() else { return Err("OUT.fmu PLATFORM=LIBRARY…".into()) };
    let mut read = Vec::new();
    for library in libraries {
        let (platform, path) = library.split_once('=').ok_or("PLATFORM=LIBRARY")?;
        let extension = Path::new(path).extension().and_then(|e| e.to_str()).unwrap_or("so");
        read.push((platform, extension, std::fs::read(path)?));
    }
    let libraries: Vec<Library> =
        read.iter().map(|(platform, extension, bytes)| Library { platform, extension, bytes }).collect();
    let starts = Starts::default();
    let identity = Identity::of(Path::new(out).file_stem().and_then(|stem| stem.to_str()).unwrap_or("Chamber"));
    let about = About::default();
    let version = if std::env::var_os("FMI3").is_some() { Version::Three } else { Version::Two };
    let contents = Contents {
        version,
        identity: &identity,
        about: &about,
        starts: &starts,
        validations: &[],
        generated: None,
        model_file: None,
        libraries: &libraries,
    };
    std::fs::write(out, package(&contents)?)?;
    Ok(())
}
