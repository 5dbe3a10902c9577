//! A panic inside a job becomes text, and nothing on the terminal.

use std::any::Any;
use std::cell::{Cell, RefCell};
use std::panic::{AssertUnwindSafe, catch_unwind, set_hook, take_hook};
use std::sync::Once;

thread_local! {
    static IN_JOB: Cell<bool> = const { Cell::new(false) };
    static PLACE: RefCell<Option<String>> = const { RefCell::new(None) };
}

/// Runs `work`; a panic in it is returned as its message and the place in the source where it was raised.
///
/// `work` must own or lock what it changes: what it left half changed is not to be used after a panic.
pub(crate) fn catch_text<T>(work: impl FnOnce() -> T) -> Result<T, String> {
    keep_quiet_in_jobs();
    let before = IN_JOB.replace(true);
    let outcome = catch_unwind(AssertUnwindSafe(work));
    IN_JOB.set(before);
    outcome.map_err(|payload| text(payload.as_ref(), PLACE.take()))
}

/// Once per process: a job's panic is noted with its place and goes to its record instead of stderr; every other panic
/// goes the way it went before.
fn keep_quiet_in_jobs() {
    static ONCE: Once = Once::new();
    ONCE.call_once(|| {
        let earlier = take_hook();
        set_hook(Box::new(move |info| {
            if IN_JOB.get() {
                PLACE.set(info.location().map(ToString::to_string));
            } else {
                earlier(info);
            }
        }));
    });
}

fn text(payload: &(dyn Any + Send), place: Option<String>) -> String {
    let message = payload
        .downcast_ref::<&str>()
        .copied()
        .or_else(|| payload.downcast_ref::<String>().map(String::as_str))
        .unwrap_or("a panic without a message");
    match place {
        Some(place) => format!("{message} (at {place})"),
        None => message.to_owned(),
    }
}
