//! Progress of a run on stderr: bars on a terminal, plain lines elsewhere. Nothing of it goes to stdout.

use crate::config::ProgressMode;
use indicatif::{HumanBytes, MultiProgress, ProgressBar, ProgressDrawTarget, ProgressStyle};
use std::fmt;
use std::io::{IsTerminal, Write};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};

/// Time after which a plain line is written even if less than 5 % were done.
const LONGEST_SILENCE: Duration = Duration::from_secs(60);

/// Time in which no second plain line is written, however much was done: logs of short runs stay short.
const SHORTEST_SILENCE: Duration = Duration::from_secs(5);

/// Handle on the display. Clones share it, and any thread may call it.
#[derive(Clone)]
pub struct Progress {
    shared: Arc<Shared>,
}

struct Shared {
    kind: Kind,
    stage: Mutex<Option<Stage>>,
}

enum Kind {
    Bars(MultiProgress),
    Plain(Mutex<Box<dyn Write + Send>>),
    Silent,
}

/// The stage under way.
struct Stage {
    name: String,
    items: u64,
    total_items: u64,
    bytes: u64,
    total_bytes: u64,
    started: Instant,
    /// Plain: twentieth of the work and time of the last line.
    last_line: (u64, Instant),
    bar: Option<ProgressBar>,
    note: String,
}

impl fmt::Debug for Progress {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("Progress")
    }
}

impl Progress {
    /// A display on stderr. `auto` is bars if stderr is a terminal, else lines; `quiet` shows nothing.
    #[must_use]
    pub fn new(mode: ProgressMode, quiet: bool) -> Self {
        let is_terminal = std::io::stderr().is_terminal();
        let kind = match (mode, quiet) {
            (_, true) | (ProgressMode::None, _) => Kind::Silent,
            (ProgressMode::Auto, _) if is_terminal => bars(),
            (ProgressMode::Bar, _) => bars(),
            (ProgressMode::Auto | ProgressMode::Plain, _) => {
                Kind::Plain(Mutex::new(Box::new(std::io::stderr())))
            }
        };
        Self::of(kind)
    }

    /// A display that shows nothing.
    #[must_use]
    pub fn silent() -> Self {
        Self::of(Kind::Silent)
    }

    /// Plain lines into any sink.
    #[must_use]
    pub fn plain(sink: Box<dyn Write + Send>) -> Self {
        Self::of(Kind::Plain(Mutex::new(sink)))
    }

    fn of(kind: Kind) -> Self {
        Self { shared: Arc::new(Shared { kind, stage: Mutex::new(None) }) }
    }

    /// Begins a stage of so many tiles (or holes) and bytes; the stage before it ends. Its title is the stage's
    /// `Debug` text in lower case. Where there are no more bytes than items, they are taken for counts and not shown.
    pub fn start(&self, stage: impl fmt::Debug, items: u64, bytes: u64) {
        self.finish();
        let name = format!("{stage:?}").trim_matches('"').to_lowercase();
        let now = Instant::now();
        let bar = match &self.shared.kind {
            Kind::Bars(all) => Some(all.add(new_bar(&name, items))),
            Kind::Plain(_) | Kind::Silent => None,
        };
        *self.stage() = Some(Stage {
            name,
            items: 0,
            total_items: items,
            bytes: 0,
            total_bytes: bytes,
            started: now,
            last_line: (0, now),
            bar,
            note: String::new(),
        });
    }

    /// One more tile (or hole) is done, which had so many bytes.
    pub fn advance(&self, bytes: u64) {
        let mut guard = self.stage();
        let Some(stage) = guard.as_mut() else { return };
        stage.items += 1;
        stage.bytes += bytes;
        match &self.shared.kind {
            Kind::Bars(_) => stage.update_bar(),
            Kind::Plain(sink) => stage.line_if_due(sink),
            Kind::Silent => {}
        }
    }

    /// Memory in use and its limit, shown beside the counts.
    pub fn memory(&self, used_bytes: u64, limit_bytes: u64) {
        if let Some(stage) = self.stage().as_mut() {
            stage.note = format!("{} of {}", HumanBytes(used_bytes), HumanBytes(limit_bytes));
        }
    }

    /// Ends the stage under way.
    pub fn finish(&self) {
        if let Some(stage) = self.stage().take()
            && let Some(bar) = stage.bar
        {
            bar.abandon();
        }
    }

    /// Writes something to stderr (or anywhere else) without tearing the bars.
    pub fn suspend<T>(&self, write: impl FnOnce() -> T) -> T {
        match &self.shared.kind {
            Kind::Bars(all) => all.suspend(write),
            Kind::Plain(_) | Kind::Silent => write(),
        }
    }

    fn stage(&self) -> std::sync::MutexGuard<'_, Option<Stage>> {
        self.shared.stage.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

fn bars() -> Kind {
    Kind::Bars(MultiProgress::with_draw_target(ProgressDrawTarget::stderr()))
}

fn new_bar(stage: &str, items: u64) -> ProgressBar {
    let style = ProgressStyle::with_template("{prefix:5} {bar:28}  {pos}/{len}   {msg}")
        .unwrap_or_else(|_| ProgressStyle::default_bar())
        .progress_chars("##-");
    ProgressBar::new(items).with_style(style).with_prefix(stage.to_owned())
}

impl Stage {
    fn update_bar(&self) {
        let Some(bar) = &self.bar else { return };
        bar.set_position(self.items);
        bar.set_message(self.tail());
    }

    /// Bytes or memory, the time so far, and the time left.
    fn tail(&self) -> String {
        let elapsed = self.started.elapsed();
        let bytes = (self.total_bytes > self.total_items).then(|| HumanBytes(self.bytes).to_string());
        let amount = if self.note.is_empty() { bytes } else { Some(self.note.clone()) };
        let left = self.left(elapsed).map(|left| format!("left {}", clock(left)));
        [amount, Some(clock(elapsed)), left].into_iter().flatten().collect::<Vec<_>>().join("   ")
    }

    /// Share of the work that is done: by bytes where they are known, else by count.
    fn share(&self) -> f64 {
        let (part, whole) = if self.total_bytes > 0 {
            (self.bytes, self.total_bytes)
        } else {
            (self.items, self.total_items)
        };
        if whole == 0 { 1.0 } else { part as f64 / whole as f64 }
    }

    fn left(&self, elapsed: Duration) -> Option<Duration> {
        let share = self.share();
        let is_told = share > 0.05 && share < 1.0 && self.items < self.total_items;
        is_told.then(|| elapsed.mul_f64((1.0 - share) / share))
    }

    /// A line at the end, and on the way where one is due.
    fn line_if_due(&mut self, sink: &Mutex<Box<dyn Write + Send>>) {
        let twentieth = (self.share() * 20.0) as u64;
        let is_last = self.items >= self.total_items;
        let (last, when) = self.last_line;
        if !is_last && !is_due(twentieth > last, when.elapsed()) {
            return;
        }
        self.last_line = (twentieth, Instant::now());
        let percent = (self.share() * 100.0) as u64;
        let mut sink = sink.lock().unwrap_or_else(PoisonError::into_inner);
        // Nobody reads stderr any more: the run goes on.
        let _ = writeln!(
            sink,
            "{} {percent}% {}/{} {}",
            self.name,
            self.items,
            self.total_items,
            self.tail().replace("   ", " ")
        );
    }
}

/// A line is due at every twentieth of the work, but not soon after another, and after a long silence.
fn is_due(is_further: bool, silence: Duration) -> bool {
    silence >= LONGEST_SILENCE || (is_further && silence >= SHORTEST_SILENCE)
}

/// `m:ss`, from an hour on `h:mm:ss`.
fn clock(time: Duration) -> String {
    let seconds = time.as_secs();
    let (hours, minutes, seconds) = (seconds / 3600, seconds / 60 % 60, seconds % 60);
    if hours > 0 { format!("{hours}:{minutes:02}:{seconds:02}") } else { format!("{minutes}:{seconds:02}") }
}

#[cfg(test)]
mod tests {
    use super::{Progress, clock, is_due};
    use std::io::Write;
    use std::sync::{Arc, Mutex};
    use std::time::Duration;

    #[derive(Clone, Default)]
    struct Sink(Arc<Mutex<Vec<u8>>>);

    impl Write for Sink {
        fn write(&mut self, bytes: &[u8]) -> std::io::Result<usize> {
            self.0.lock().expect("no panic in the test").extend_from_slice(bytes);
            Ok(bytes.len())
        }

        fn flush(&mut self) -> std::io::Result<()> {
            Ok(())
        }
    }

    #[test]
    fn a_short_stage_is_one_plain_line() {
        let sink = Sink::default();
        let progress = Progress::plain(Box::new(sink.clone()));
        progress.start("scan", 1000, 0);
        (0..1000).for_each(|_| progress.advance(3));
        progress.finish();
        let text = String::from_utf8(sink.0.lock().expect("no panic").clone()).expect("text");
        let lines: Vec<&str> = text.lines().collect();
        assert_eq!(lines.len(), 1, "{text}");
        assert!(lines[0].starts_with("scan 100% 1000/1000 "), "{}", lines[0]);
    }

    #[test]
    fn lines_of_a_long_stage_keep_their_distance() {
        for (is_further, seconds, expected) in
            [(true, 4, false), (true, 5, true), (false, 5, false), (false, 59, false), (false, 60, true)]
        {
            assert_eq!(
                is_due(is_further, Duration::from_secs(seconds)),
                expected,
                "{is_further} {seconds} s"
            );
        }
    }

    #[test]
    fn clocks_read_as_people_write_them() {
        for (seconds, text) in [(0, "0:00"), (6, "0:06"), (61, "1:01"), (3661, "1:01:01")] {
            assert_eq!(clock(Duration::from_secs(seconds)), text);
        }
    }
}
