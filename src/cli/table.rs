//! Tables of text with aligned columns.

/// A table; the first row is its head.
#[derive(Debug, Default)]
pub(super) struct Table {
    rows: Vec<Vec<String>>,
}

impl Table {
    /// A table with these column heads. Heads that begin with `>` align their
    /// column to the right.
    pub(super) fn new<const N: usize>(heads: [&str; N]) -> Self {
        Self { rows: vec![heads.map(str::to_owned).to_vec()] }
    }

    pub(super) fn row<const N: usize>(&mut self, cells: [String; N]) {
        self.rows.push(cells.to_vec());
    }

    /// The lines, two spaces between columns.
    pub(super) fn text(&self) -> String {
        let Some(heads) = self.rows.first() else { return String::new() };
        let right: Vec<bool> = heads.iter().map(|head| head.starts_with('>')).collect();
        let cell = |row: usize, column: usize| {
            let cell = self.rows[row].get(column).map_or("", String::as_str);
            if row == 0 { cell.trim_start_matches('>') } else { cell }
        };
        let widths: Vec<usize> = (0..heads.len())
            .map(|column| {
                let width = |row| cell(row, column).chars().count();
                (0..self.rows.len()).map(width).max().unwrap_or(0)
            })
            .collect();
        let mut text = String::new();
        for row in 0..self.rows.len() {
            let mut line = String::new();
            for (column, &width) in widths.iter().enumerate() {
                let cell = cell(row, column);
                let padded = if right[column] {
                    format!("{cell:>width$}")
                } else {
                    format!("{cell:<width$}")
                };
                line.push_str(&padded);
                line.push_str("  ");
            }
            text.push_str(line.trim_end());
            text.push('\n');
        }
        text
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn aligns_columns_by_characters() {
        let mut table = Table::new(["leg", ">time"]);
        table.row(["AB".into(), "7.89 s".into()]);
        table.row(["größer".into(), "11 s".into()]);
        assert_eq!(table.text(), "leg       time\nAB      7.89 s\ngrößer    11 s\n");
    }
}
