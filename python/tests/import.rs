//! Python imports the library and hears the program's sentence. Without Python there is nothing to test.

use std::path::{Path, PathBuf};
use std::process::Command;

/// The library, beside the test's own program or one folder up.
fn library() -> PathBuf {
    let name = format!("{}pneutherm_native{}", std::env::consts::DLL_PREFIX, std::env::consts::DLL_SUFFIX);
    let program = std::env::current_exe().unwrap();
    let candidates = program.ancestors().skip(1).take(2).map(|folder| folder.join(&name));
    candidates.into_iter().find(|path| path.exists()).unwrap_or_else(|| panic!("{name} was not built"))
}

#[test]
fn python_imports_the_library_and_gets_its_error_message() {
    if Command::new("python3").arg("--version").output().is_err() {
        println!("skipped: no python3 here");
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let package = folder.path().join("pneutherm");
    std::fs::create_dir(&package).unwrap();
    let sources = Path::new(env!("CARGO_MANIFEST_DIR")).join("pneutherm");
    for file in std::fs::read_dir(sources).unwrap().map(|entry| entry.unwrap()) {
        if file.path().is_file() {
            std::fs::copy(file.path(), package.join(file.file_name())).unwrap();
        }
    }
    let ending = if cfg!(windows) { "pyd" } else { "abi3.so" };
    std::fs::copy(library(), package.join(format!("_native.{ending}"))).unwrap();
    let code = "import pneutherm\ntry:\n    pneutherm.identify('absent')\nexcept pneutherm.Error as e:\n    print(e)";
    // In the folder, whose package comes first then.
    let output = Command::new("python3").args(["-c", code]).current_dir(folder.path()).output().unwrap();
    let (stdout, stderr) = (String::from_utf8_lossy(&output.stdout), String::from_utf8_lossy(&output.stderr));
    assert!(stdout.starts_with("absent: cannot be read"), "{stdout}{stderr}");
}
