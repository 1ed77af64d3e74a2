//! The program in a folder of its own.

use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use tempfile::TempDir;

/// A small quick picture of a lit sphere, as `small.exr`.
pub const SMALL: &str = r#"
Film "rgb" "integer xresolution" 8 "integer yresolution" 8 "string filename" "small.exr"
Sampler "sobol" "integer pixelsamples" 2
Camera "perspective"
WorldBegin
LightSource "infinite"
Translate 0 0 3
Shape "sphere"
"#;

/// A folder for the files of one test.
pub struct Folder(TempDir);

/// What a run of the program comes to.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Outcome {
    /// Exit code; -1 if a signal ended it.
    pub code: i32,
    /// Standard output.
    pub out: String,
    /// Standard error.
    pub err: String,
}

impl Folder {
    /// A folder with the scene `scene.bhs`.
    pub fn new(scene: &str) -> Self {
        let folder = Self(tempfile::tempdir().expect("a temporary folder"));
        folder.write("scene.bhs", scene);
        folder
    }

    /// The path of a file in it.
    pub fn at(&self, name: impl AsRef<Path>) -> PathBuf {
        self.0.path().join(name)
    }

    /// Writes a file into it, and makes the folders that lead there.
    pub fn write(&self, name: &str, content: impl AsRef<[u8]>) {
        let path = self.at(name);
        std::fs::create_dir_all(path.parent().expect("a folder")).expect("the temporary folder can be written");
        std::fs::write(path, content).expect("the temporary folder can be written");
    }

    /// The content of a file.
    pub fn read(&self, name: &str) -> Vec<u8> {
        std::fs::read(self.at(name)).unwrap_or_else(|e| panic!("{name}: {e}"))
    }

    /// The names of all files, in order, those of folders within too.
    pub fn files(&self) -> Vec<String> {
        fn walk(folder: &Path, prefix: &str, into: &mut Vec<String>) {
            for entry in std::fs::read_dir(folder).expect("readable") {
                let entry = entry.expect("readable");
                let name = format!("{prefix}{}", entry.file_name().to_string_lossy());
                if entry.file_type().expect("readable").is_dir() {
                    walk(&entry.path(), &format!("{name}/"), into);
                } else {
                    into.push(name);
                }
            }
        }
        let mut all = Vec::new();
        walk(self.0.path(), "", &mut all);
        all.sort();
        all
    }

    /// All files with their contents.
    pub fn contents(&self) -> Vec<(String, Option<Vec<u8>>)> {
        self.files().into_iter().map(|name| (name.clone(), std::fs::read(self.at(&name)).ok())).collect()
    }

    /// The program, about to be started here.
    pub fn command(&self, args: &[&str]) -> Command {
        let mut command = Command::new(program());
        command.current_dir(self.0.path()).args(args).stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::piped());
        command
    }

    /// Runs the program here to its end.
    pub fn run(&self, args: &[&str]) -> Outcome {
        outcome(&mut self.command(args))
    }

    /// Runs a shell script here to its end, in which `$BHS` is the program.
    pub fn shell(&self, script: &str) -> Outcome {
        let mut command = Command::new("sh");
        command.current_dir(self.0.path()).arg("-c").arg(script).env("BHS", program()).stdin(Stdio::null());
        outcome(&mut command)
    }
}

/// The program's file.
pub fn program() -> &'static Path {
    Path::new(env!("CARGO_BIN_EXE_bhs"))
}

fn outcome(command: &mut Command) -> Outcome {
    let output = command.output().expect("the program starts");
    let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
    Outcome { code: output.status.code().unwrap_or(-1), out: text(&output.stdout), err: text(&output.stderr) }
}
