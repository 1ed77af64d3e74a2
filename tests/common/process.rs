//! The program as a process: in a folder of its own, and told to stop or killed on the way.

use bhs::image::Picture;
use std::path::{Path, PathBuf};
use std::process::{Child, ChildStdin, Command, Stdio};
use std::time::{Duration, Instant};
use tempfile::TempDir;

/// A folder with a scene `scene.bhs`.
pub struct Folder(TempDir);

/// The names of the files in a folder, in order.
pub fn files(folder: &Path) -> Vec<String> {
    let mut names: Vec<_> = std::fs::read_dir(folder)
        .expect("readable")
        .map(|e| e.expect("readable").file_name().into_string().expect("plain names"))
        .collect();
    names.sort();
    names
}

impl Folder {
    /// A folder with the given scene.
    pub fn new(scene: &str) -> Self {
        let folder = Self(tempfile::tempdir().expect("a temporary folder"));
        folder.write("scene.bhs", scene);
        folder
    }

    /// The path of a file in it.
    pub fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    /// Writes a file.
    pub fn write(&self, name: &str, content: impl AsRef<[u8]>) {
        std::fs::write(self.path(name), content).expect("the temporary folder can be written");
    }

    fn command(&self, args: &[&str]) -> Command {
        let mut command = Command::new(assert_cmd::cargo::cargo_bin!("bhs"));
        command.current_dir(self.0.path()).args(args).stdin(Stdio::null()).stdout(Stdio::null());
        command
    }

    /// Runs the program to its end: its exit code and what it says on standard error.
    pub fn run(&self, args: &[&str]) -> (i32, String) {
        let out = self.command(args).stderr(Stdio::piped()).output().expect("bhs starts");
        (out.status.code().unwrap_or(-1), String::from_utf8_lossy(&out.stderr).into_owned())
    }

    /// Starts the program with a scene that it waits for, and goes on waiting for: standard input never ends.
    pub fn start_loading(&self, args: &[&str]) -> Running {
        let mut child = self.command(args).stdin(Stdio::piped()).stderr(Stdio::null()).spawn().expect("bhs starts");
        // Whoever waits for the child would close it.
        let input = child.stdin.take();
        Running(child, input)
    }

    /// Starts the program with hangups ignored, as `nohup` does.
    #[cfg(unix)]
    pub fn start_without_hangup(&self, args: &[&str]) -> Running {
        let mut shell = Command::new("sh");
        shell.args(["-c", "trap '' HUP; exec \"$@\"", "sh"]).arg(assert_cmd::cargo::cargo_bin!("bhs")).args(args);
        shell.current_dir(self.0.path()).stdin(Stdio::null()).stdout(Stdio::null()).stderr(Stdio::null());
        Running(shell.spawn().expect("sh starts"), None)
    }

    /// Starts the program.
    pub fn start(&self, args: &[&str]) -> Running {
        Running(self.command(args).stderr(Stdio::null()).spawn().expect("bhs starts"), None)
    }

    /// An attribute of the header of an EXR file.
    pub fn header(&self, file: &str, name: &str) -> String {
        let meta = exr::meta::MetaData::read_from_file(self.path(file), false).expect("an EXR file");
        let value = meta.headers[0].own_attributes.other.get(name.as_bytes()).unwrap_or_else(|| panic!("{file} has no {name}"));
        match value {
            exr::meta::attribute::AttributeValue::Text(text) => text.to_string(),
            exr::meta::attribute::AttributeValue::F64(number) => number.to_string(),
            exr::meta::attribute::AttributeValue::I32(number) => number.to_string(),
            other => panic!("{name} is {other:?}"),
        }
    }

    /// That two pictures are the same: every channel of the EXR file, and the bytes of the PNG file.
    ///
    /// # Panics
    /// If they are not.
    pub fn assert_same(&self, a: &str, b: &str) {
        let [one, other] = [a, b].map(|name| Picture::read_exr(&self.path(&format!("{name}.exr"))).expect("a whole picture"));
        assert!(one.same_channels(&other), "{a}.exr and {b}.exr differ");
        let [one, other] = [a, b].map(|name| std::fs::read(self.path(&format!("{name}.png"))).expect("it is there"));
        assert!(one == other, "{a}.png and {b}.png differ");
    }
}

/// The program under way; killed when it is let go.
pub struct Running(
    Child,
    #[expect(dead_code, reason = "the program waits for input as long as this is open")] Option<ChildStdin>,
);

impl Running {
    /// Waits until a file is there.
    ///
    /// # Panics
    /// If the program ends before, or after a long time.
    pub fn wait_for(&mut self, file: &Path) {
        let start = Instant::now();
        while !file.exists() {
            assert!(self.0.try_wait().expect("it can be asked").is_none(), "it ended before there was {}", file.display());
            assert!(start.elapsed() < Duration::from_secs(300), "there is no {}", file.display());
            std::thread::sleep(Duration::from_millis(5));
        }
    }

    /// Kills it, so that it can do nothing more.
    pub fn kill(&mut self) {
        let _ = self.0.kill();
        let _ = self.0.wait();
    }

    /// Sends it a signal, such as `TERM`.
    #[cfg(unix)]
    pub fn signal(&self, name: &str) {
        // It may have ended already.
        let id = self.0.id().to_string();
        let _ = Command::new("kill").args([&format!("-{name}"), &id]).stderr(Stdio::null()).status();
    }

    /// Whether it does something of its own when a signal comes; where the system does not tell, after a while.
    #[cfg(unix)]
    pub fn handles(&self, name: &str) -> bool {
        let number = match name {
            "HUP" => 1,
            "INT" => 2,
            "TERM" => 15,
            other => panic!("{other} has no number here"),
        };
        let Ok(status) = std::fs::read_to_string(format!("/proc/{}/status", self.0.id())) else {
            std::thread::sleep(Duration::from_secs(2));
            return true;
        };
        let mask = status.lines().find_map(|l| l.strip_prefix("SigCgt:")).expect("it is told");
        u64::from_str_radix(mask.trim(), 16).expect("a mask") >> (number - 1) & 1 == 1
    }

    /// Waits for its end: its exit code, if it was not killed by a signal.
    pub fn wait(&mut self) -> Option<i32> {
        self.0.wait().expect("it can be waited for").code()
    }

    /// Whether it has ended.
    pub fn has_ended(&mut self) -> bool {
        self.0.try_wait().expect("it can be asked").is_some()
    }
}

impl Drop for Running {
    fn drop(&mut self) {
        self.kill();
    }
}
