//! What is said on standard error, in one place.
//!
//! Whether anybody reads it must not matter: a closed pipe or a full disk behind standard error ends nothing and changes no exit code.
//! `eprintln!` panics there, so the `print_stderr` lint forbids it.
//!
//! Programs that start this one may ask for lines that they can read ([`Form`]): then everything comes in that form, what is said to people
//! too, and the last line says how it ended. No result depends on it.

use indicatif::ProgressBar;
use serde_json::{Value, json};
use std::fmt::Arguments;
use std::io::Write;
use std::sync::{Mutex, MutexGuard, PoisonError};

/// The form of what is said.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Form {
    /// Words for people.
    #[default]
    Plain,
    /// A JSON object a line, each with an `event`.
    Json,
    /// Words for people, and the lines by which Open Job Description knows progress and failures.
    OpenJd,
}

/// What has been said so far, as far as it matters for what is said later.
#[derive(Default)]
struct Said {
    form: Form,
    /// The first error: what the last line is about.
    error: Option<String>,
    /// Nothing follows the last line.
    has_ended: bool,
}

static SAID: Mutex<Said> = Mutex::new(Said { form: Form::Plain, error: None, has_ended: false });

fn said() -> MutexGuard<'static, Said> {
    SAID.lock().unwrap_or_else(PoisonError::into_inner)
}

/// The bar that is drawn on the same terminal, if one is.
static BAR: Mutex<Option<ProgressBar>> = Mutex::new(None);

/// What is said from now on does not get in the way of this bar, or of none. A bar that is kept out of the way by others is none.
pub fn keep_clear_of(bar: Option<&ProgressBar>) {
    *BAR.lock().unwrap_or_else(PoisonError::into_inner) = bar.cloned();
}

/// A text that cannot be written is lost.
fn put(text: &str) {
    let write = || {
        let _ = std::io::stderr().lock().write_all(text.as_bytes());
    };
    let bar = BAR.lock().unwrap_or_else(PoisonError::into_inner).clone();
    match bar {
        Some(bar) => bar.suspend(write),
        None => write(),
    }
}

/// Says everything in this form from now on, and that the program has begun.
pub fn begin(form: Form, what: Value) {
    said().form = form;
    event("start", what);
}

/// Writes a text to standard error, as one piece. A text that cannot be written is lost.
pub fn write(text: Arguments) {
    let text = text.to_string();
    let mut said = said();
    let first = text.trim_end();
    if let Some(error) = first.strip_prefix("error: ").filter(|_| said.error.is_none()) {
        said.error = Some(error.to_owned());
    }
    match said.form {
        Form::Plain => {
            // Whoever does not read keeps nobody else waiting.
            drop(said);
            put(&text);
        }
        Form::OpenJd if !said.has_ended => put(&text),
        Form::Json if !said.has_ended => {
            let severity = ["error", "warning", "note"].into_iter().find(|s| first.starts_with(&format!("{s}: ")));
            let words = severity.map_or(first, |s| &first[s.len() + 2..]);
            put(&line("message", json!({ "severity": severity.unwrap_or("info"), "text": words })));
        }
        _ => {}
    }
}

/// Says what was found wrong with a scene: `text` to people, `all` as objects of `bhs check --json` to programs.
pub fn findings(text: &str, all: impl FnOnce() -> Vec<Value>) {
    if said().form == Form::Plain {
        return put(text);
    }
    let all = all();
    let mut said = said();
    if said.has_ended {
        return;
    }
    if let Some(error) = all.iter().find(|found| found["severity"] == "error").filter(|_| said.error.is_none()) {
        said.error = error["message"].as_str().map(str::to_owned);
    }
    match said.form {
        Form::Json => put(&all.into_iter().map(|found| line("diagnostic", found)).collect::<String>()),
        _ => put(text),
    }
}

/// Tells programs that something has happened; says nothing to people.
pub fn event(name: &str, what: Value) {
    let said = said();
    if said.form == Form::Json && !said.has_ended {
        put(&line(name, what));
    }
}

/// Tells Open Job Description something, such as `progress` or `status`; says nothing to others.
pub fn openjd(name: &str, what: &str) {
    let said = said();
    if said.form == Form::OpenJd && !said.has_ended {
        put(&format!("openjd_{name}: {}\n", what.replace('\n', " ")));
    }
}

/// Tells programs how it ended, once, as the last line of all: `status` is `done`, `failed` or `stopped`.
pub fn end(status: &str, exit_code: u8) {
    end_with(said(), status, exit_code);
}

/// The same before the program ends at once: who is in the middle of saying something is not waited for.
pub fn end_at_once(status: &str, exit_code: u8) {
    if let Ok(said) = SAID.try_lock() {
        end_with(said, status, exit_code);
    }
}

fn end_with(mut said: MutexGuard<Said>, status: &str, exit_code: u8) {
    if said.has_ended {
        return;
    }
    let error = said.error.take().filter(|_| status == "failed");
    match said.form {
        Form::Plain => return,
        Form::Json => {
            let mut what = json!({ "status": status, "exit_code": exit_code });
            if let Some(error) = error {
                what["error"] = error.into();
            }
            put(&line("end", what));
        }
        Form::OpenJd if status == "done" => {}
        Form::OpenJd => {
            let why = error.unwrap_or_else(|| format!("{status}, exit code {exit_code}"));
            put(&format!("openjd_fail: {}\n", why.replace('\n', " ")));
        }
    }
    said.has_ended = true;
}

/// One event: its name before everything else.
fn line(name: &str, what: Value) -> String {
    let mut text = format!("{{\"event\":{}", Value::from(name));
    for (key, value) in what.as_object().into_iter().flatten() {
        text += &format!(",{}:{value}", Value::from(key.as_str()));
    }
    text + "}\n"
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_event_is_one_line_of_json_whatever_it_holds() {
        let line = line("message", json!({ "text": "two\nlines, a \"quote\"", "at": [1, 2] }));
        assert_eq!(line.matches('\n').count(), 1);
        let read: Value = serde_json::from_str(&line).expect("JSON");
        assert_eq!(read, json!({ "event": "message", "text": "two\nlines, a \"quote\"", "at": [1, 2] }));
        assert!(line.starts_with(r#"{"event":"message","#));
    }
}
