//! The figures of a test, to be read with `--nocapture`.

use crate::support::score::Score;

/// A table of scores that is printed when it is whole.
#[derive(Debug)]
pub(crate) struct Table {
    text: String,
}

impl Table {
    /// An empty table under a title.
    pub(crate) fn new(title: &str) -> Self {
        Self { text: format!("{title}\n{:<30}{:<26}{:>8}{:>8}{:>10}\n", "", "", "all", "edges", "interior") }
    }

    /// Adds a row: what was filtered, how, and what came of it, beside what was asked for.
    pub(crate) fn row(&mut self, what: &str, how: &str, score: Score, asked: Option<Score>) {
        let [all, edges, interior] = score.0;
        let asked = asked.map_or_else(String::new, |Score([all, edges, interior])| {
            format!("   asked {all:.1} / {edges:.1} / {interior:.1}")
        });
        self.text += &format!("{what:<30}{how:<26}{all:>8.2}{edges:>8.2}{interior:>10.2}{asked}\n");
    }

    /// Adds a line of text.
    pub(crate) fn note(&mut self, note: &str) {
        self.text += note;
        self.text.push('\n');
    }

    /// Prints it in one piece, so that tests that run at the same time do not mix their lines.
    #[expect(clippy::print_stderr, reason = "the figures are what the test is for")]
    pub(crate) fn print(&self) {
        eprintln!("{}", self.text);
    }
}
