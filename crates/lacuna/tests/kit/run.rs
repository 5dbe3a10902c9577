//! One run of the program.

use super::SceneFolder;
use assert_cmd::Command;
use std::ffi::OsStr;
use std::path::Path;
use std::time::Duration;

/// How a run ended.
#[derive(Clone, Debug)]
pub(crate) struct Run {
    /// Exit code; -1 if a signal ended it.
    pub(crate) code: i32,
    pub(crate) stdout: String,
    pub(crate) stderr: String,
}

/// Runs the program without stdin and without progress; a minute is plenty for every scene of the tests.
pub(crate) fn lacuna<I, S>(arguments: I) -> Run
where
    I: IntoIterator<Item = S>,
    S: AsRef<OsStr>,
{
    let output = Command::new(env!("CARGO_BIN_EXE_lacuna"))
        .args(arguments)
        .arg("--progress=none")
        .timeout(Duration::from_secs(60))
        .output()
        .expect("the program starts");
    Run {
        code: output.status.code().unwrap_or(-1),
        stdout: String::from_utf8(output.stdout).expect("UTF-8 on stdout"),
        stderr: String::from_utf8(output.stderr).expect("UTF-8 on stderr"),
    }
}

/// `lacuna repair SCENE OUT` and more flags.
pub(crate) fn repair(scene: &SceneFolder, out: &Path, flags: &[&str]) -> Run {
    let mut arguments = vec!["repair".as_ref(), scene.path().as_os_str(), out.as_os_str()];
    arguments.extend(flags.iter().map(OsStr::new));
    lacuna(arguments)
}

impl Run {
    /// Checks the exit code; the program's own words are in the message.
    #[track_caller]
    pub(crate) fn ends(&self, code: i32) -> &Self {
        assert_eq!(self.code, code, "stdout:\n{}\nstderr:\n{}", self.stdout, self.stderr);
        assert!(!self.stderr.contains("panicked"), "{}", self.stderr);
        self
    }

    /// Checks that stderr says something.
    #[track_caller]
    pub(crate) fn says(&self, text: &str) -> &Self {
        assert!(self.stderr.contains(text), "no {text:?} in stderr:\n{}", self.stderr);
        self
    }
}
