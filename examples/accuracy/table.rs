//! Tables of measurements, and what is left of many errors.

use std::fmt::Write;

/// What is left of many errors.
#[derive(Clone, Copy, Debug)]
pub struct Summary {
    pub median: f64,
    pub p99: f64,
    pub worst: f64,
}

impl Summary {
    /// Of these errors; NaN if there are none.
    pub fn of(mut errors: Vec<f64>) -> Self {
        errors.sort_by(f64::total_cmp);
        let at = |share: f64| errors.get(((errors.len() as f64 - 1.0) * share).round() as usize).copied().unwrap_or(f64::NAN);
        Self { median: at(0.5), p99: at(0.99), worst: at(1.0) }
    }

    /// As three cells of a table.
    pub fn cells(&self) -> [String; 3] {
        [self.median, self.p99, self.worst].map(|e| format!("{e:.1e}"))
    }
}

/// A table, as CSV for programs and as Markdown for people.
pub struct Table {
    columns: usize,
    csv: String,
    markdown: String,
}

impl Table {
    /// A table with these columns.
    pub fn new(columns: &[&str]) -> Self {
        let mut table = Self { columns: columns.len(), csv: String::new(), markdown: String::new() };
        table.row(columns);
        let rule: String = columns.iter().map(|_| "---|").collect();
        writeln!(table.markdown, "|{rule}").expect("a string takes whatever is written to it");
        table
    }

    /// Appends a row.
    pub fn row(&mut self, cells: &[impl AsRef<str>]) {
        assert_eq!(cells.len(), self.columns, "a row has a cell for every column");
        let cells: Vec<&str> = cells.iter().map(AsRef::as_ref).collect();
        let fits = |cell: &&str| !cell.contains([',', '"', '\n', '|']);
        assert!(cells.iter().all(fits), "cells hold no separators: {cells:?}");
        self.csv += &(cells.join(",") + "\n");
        self.markdown += &format!("| {} |\n", cells.join(" | "));
    }

    /// Writes `docs/accuracy/NAME.csv` and shows the table.
    pub fn finish(self, name: &str) -> anyhow::Result<()> {
        eprintln!("\n{}", self.markdown);
        crate::write(&format!("{name}.csv"), &self.csv)
    }
}
