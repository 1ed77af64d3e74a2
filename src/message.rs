//! What is said on standard error, in one place.
//!
//! Whether anybody reads it must not matter: a closed pipe or a full disk behind standard error ends nothing and changes no exit code.
//! `eprintln!` panics there, so the `print_stderr` lint forbids it.

use std::fmt::Arguments;
use std::io::Write;

/// Writes a text to standard error, as one piece. A text that cannot be written is lost.
pub fn write(text: Arguments) {
    let _ = std::io::stderr().lock().write_all(text.to_string().as_bytes());
}

/// Lets a panic, which is always a fault of the program, say so whether or not anybody reads it; with the way there, if the environment
/// variable `RUST_BACKTRACE` is set.
pub fn report_panics() {
    std::panic::set_hook(Box::new(|panic| {
        let way = std::backtrace::Backtrace::capture();
        let way = if way.status() == std::backtrace::BacktraceStatus::Captured { format!("\n{way}") } else { String::new() };
        crate::say!("error: this is a fault of bhs, please report it: {panic}{way}");
    }));
}

/// Writes a line to standard error, as `eprintln!` does, but whether or not anybody reads it.
#[macro_export]
macro_rules! say {
    ($($part:tt)*) => { $crate::message::write(format_args!("{}\n", format_args!($($part)*))) };
}
