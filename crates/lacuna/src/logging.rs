//! Log lines on stderr, as text or JSON. Names from tiles cannot send escape codes to the terminal.

use crate::cli::OutputArgs;
use crate::progress::Progress;
use std::fmt::Write as _;
use std::io::{self, Write};
use tracing_subscriber::filter::LevelFilter;
use tracing_subscriber::fmt::MakeWriter;

/// Starts logging for the process; a second call changes nothing.
///
/// Errors only with `-q`, warnings by default, `-v` for what is done, `-vv` for everything.
pub fn start(options: &OutputArgs, progress: &Progress) {
    let level = match (options.quiet, options.verbose) {
        (true, _) => LevelFilter::ERROR,
        (false, 0) => LevelFilter::WARN,
        (false, 1) => LevelFilter::INFO,
        (false, _) => LevelFilter::TRACE,
    };
    let writer = StderrWriter { progress: progress.clone() };
    let builder = tracing_subscriber::fmt().with_max_level(level).with_writer(writer).with_ansi(false);
    // An error says that somebody has started logging before: their choice stays.
    let _ = if options.log_json {
        builder.json().flatten_event(true).try_init()
    } else {
        builder.with_target(false).compact().try_init()
    };
}

/// A name as it is shown to people: control characters, quotes left as they are, written as `\u{1b}` and the like.
#[must_use]
pub fn shown(name: &str) -> String {
    let mut text = String::with_capacity(name.len());
    for c in name.chars() {
        if is_harmless(c) {
            text.push(c);
        } else {
            let _ = write!(text, "{}", c.escape_debug());
        }
    }
    text
}

/// Neither a control character nor one that turns the direction of the text or hides in it.
fn is_harmless(c: char) -> bool {
    !c.is_control()
        && !matches!(c, '\u{200b}'..='\u{200f}' | '\u{2028}'..='\u{202e}' | '\u{2066}'..='\u{2069}' | '\u{feff}')
}

#[derive(Clone)]
struct StderrWriter {
    progress: Progress,
}

impl<'a> MakeWriter<'a> for StderrWriter {
    type Writer = Self;

    fn make_writer(&'a self) -> Self {
        self.clone()
    }
}

impl Write for StderrWriter {
    /// Takes one whole line, as the formatter writes it.
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let line = one_line(bytes);
        self.progress.suspend(|| io::stderr().write_all(line.as_bytes()))?;
        Ok(bytes.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        io::stderr().flush()
    }
}

/// A log line whose only control character is the line feed at its end.
fn one_line(bytes: &[u8]) -> String {
    let text = String::from_utf8_lossy(bytes);
    let body = text.strip_suffix('\n').unwrap_or(&text);
    shown(body) + "\n"
}

#[cfg(test)]
mod tests {
    use super::{one_line, shown};

    #[test]
    fn control_characters_are_written_out() {
        for (name, expected) in [
            ("Tile_+000_+001", "Tile_+000_+001"),
            ("caf\u{e9} 'x'", "caf\u{e9} 'x'"),
            ("\u{1b}[31mred", "\\u{1b}[31mred"),
            ("two\nlines", "two\\nlines"),
            ("\u{202e}gnp", "\\u{202e}gnp"),
            ("\u{9b}2J", "\\u{9b}2J"),
        ] {
            assert_eq!(shown(name), expected);
        }
        assert_eq!(one_line(b"a\x1bb\nWARN c\n"), "a\\u{1b}b\\nWARN c\n");
    }
}
