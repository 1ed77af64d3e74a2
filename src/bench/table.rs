//! Tables of measurements: for the terminal, for CSV and JSON files, for Markdown pages.

use serde_json::{Map, Value};

/// A table; every row has a cell for every column.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Table {
    columns: Vec<String>,
    rows: Vec<Vec<String>>,
}

impl Table {
    /// A table with these columns and no rows.
    pub fn new(columns: &[&str]) -> Self {
        Self { columns: columns.iter().map(|c| (*c).to_owned()).collect(), rows: Vec::new() }
    }

    /// Appends a row; what is missing of it stays empty.
    pub fn row<S: AsRef<str>>(&mut self, cells: &[S]) {
        let mut row: Vec<String> = cells.iter().map(|c| c.as_ref().to_owned()).collect();
        row.resize(self.columns.len(), String::new());
        self.rows.push(row);
    }

    /// As comma-separated values; cells that need it are quoted.
    pub fn to_csv(&self) -> String {
        let cell = |c: &String| {
            if c.contains([',', '"', '\n']) { format!("\"{}\"", c.replace('"', "\"\"")) } else { c.clone() }
        };
        let line = |row: &Vec<String>| row.iter().map(cell).collect::<Vec<_>>().join(",") + "\n";
        std::iter::once(&self.columns).chain(&self.rows).map(line).collect()
    }

    /// As a Markdown table, in columns of equal width that are as easy to read on a terminal.
    pub fn to_markdown(&self) -> String {
        let width = |i: usize| {
            let cells = std::iter::once(&self.columns).chain(&self.rows);
            cells.map(|row| row[i].chars().count()).max().unwrap_or(0)
        };
        let widths: Vec<usize> = (0..self.columns.len()).map(width).collect();
        let line = |row: &Vec<String>| {
            let cells: String = row.iter().zip(&widths).map(|(c, w)| format!(" {c:w$} |")).collect();
            format!("|{cells}\n")
        };
        let rule: String = widths.iter().map(|w| format!("{}|", "-".repeat(w + 2))).collect();
        line(&self.columns) + &format!("|{rule}\n") + &self.rows.iter().map(line).collect::<String>()
    }

    /// As a list of objects, one a row; what reads as a number is one.
    pub fn to_json(&self) -> Value {
        let value = |c: &String| c.parse::<f64>().map_or_else(|_| Value::from(c.as_str()), Value::from);
        let object =
            |row: &Vec<String>| -> Map<String, Value> { self.columns.iter().cloned().zip(row.iter().map(value)).collect() };
        self.rows.iter().map(object).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_table_in_three_forms() {
        let mut table = Table::new(&["name", "ns"]);
        table.row(&["a, b", "12.5"]);
        table.row(&["c"]);
        assert_eq!(table.to_csv(), "name,ns\n\"a, b\",12.5\nc,\n");
        assert_eq!(table.to_markdown(), "| name | ns   |\n|------|------|\n| a, b | 12.5 |\n| c    |      |\n");
        assert_eq!(table.to_json(), serde_json::json!([{"name": "a, b", "ns": 12.5}, {"name": "c", "ns": ""}]));
    }
}
