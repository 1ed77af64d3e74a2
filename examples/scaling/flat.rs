//! A flat scene, rendered by the whole program and by one that holds no curved integrator.

use crate::{medians, program, show};
use anyhow::{Context, Result};
use bhs::bench::table::Table;
use std::io::{BufRead, BufReader, Write};
use std::process::{Child, ChildStdin, ChildStdout, Command, Stdio};

/// The word that makes this program a [`crate::timer`].
pub const WORKER: &str = "flat-worker";

const ROUNDS: usize = 31;

/// A process that renders when asked.
struct Worker {
    child: Child,
    ask: ChildStdin,
    answers: BufReader<ChildStdout>,
}

impl Worker {
    fn start(mut command: Command) -> Result<Self> {
        let mut child = command.stdin(Stdio::piped()).stdout(Stdio::piped()).spawn()?;
        let ask = child.stdin.take().context("no input")?;
        let answers = BufReader::new(child.stdout.take().context("no output")?);
        Ok(Self { child, ask, answers })
    }

    fn seconds(&mut self) -> Result<f64> {
        writeln!(self.ask, "again")?;
        self.ask.flush()?;
        let mut line = String::new();
        self.answers.read_line(&mut line)?;
        line.trim().parse().with_context(|| format!("`{line}` is no time"))
    }
}

pub fn measure() -> Result<()> {
    let mut whole = Command::new(std::env::current_exe()?);
    whole.arg(WORKER);
    let mut workers = [Worker::start(whole)?, Worker::start(Command::new(program("flat_only")?))?];
    let seconds = medians(ROUNDS, &mut workers, Worker::seconds)?;
    for worker in workers {
        let Worker { mut child, ask, .. } = worker;
        // Its input ends, and so does it.
        drop(ask);
        child.wait()?;
    }
    let mut table = Table::new(&["program", "seconds", "over the second"]);
    for (name, seconds_of) in ["all integrators", "`straight` alone"].iter().zip(&seconds) {
        table.row(&[(*name).to_owned(), format!("{seconds_of:.4}"), format!("{:.4}", seconds_of / seconds[1])]);
    }
    show("`cornell_box`, 128 x 128 pixels, 16 samples, with and without curved light in the program (processor time)", &table);
    Ok(())
}
