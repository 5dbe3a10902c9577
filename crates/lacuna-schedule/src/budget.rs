//! Memory lent in order of asking, given back by `Drop`.

use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};

/// A number of bytes that is lent out and comes back. Clones share the same bytes.
///
/// Lending is first come, first served: a large request at the head waits for room, and no small one overtakes it.
#[derive(Clone, Debug)]
pub struct MemoryBudget {
    shared: Arc<Shared>,
}

#[derive(Debug)]
struct Shared {
    total_bytes: u64,
    state: Mutex<State>,
    changed: Condvar,
}

#[derive(Debug, Default)]
struct State {
    lent_bytes: u64,
    kept_bytes: u64,
    peak_bytes: u64,
    next_ticket: u64,
    now_serving: u64,
}

/// Bytes on loan from a [`MemoryBudget`]; dropping it gives them back.
#[derive(Debug)]
#[must_use = "a reservation that is dropped at once reserves nothing"]
pub struct Reservation {
    shared: Arc<Shared>,
    bytes: u64,
}

/// A request above the whole budget: waiting would never end.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{needed_bytes} bytes asked of a memory limit of {limit_bytes} bytes; raise --memory")]
pub struct OverLimit {
    /// Bytes asked for.
    pub needed_bytes: u64,
    /// Bytes of the whole budget.
    pub limit_bytes: u64,
}

impl MemoryBudget {
    /// A budget of `total_bytes`, all of them free.
    #[must_use]
    pub fn new(total_bytes: u64) -> Self {
        let shared = Shared { total_bytes, state: Mutex::default(), changed: Condvar::new() };
        Self { shared: Arc::new(shared) }
    }

    /// Waits until all earlier requests are served and `bytes` are free, then lends them.
    ///
    /// Never to be called by a worker that holds a reservation: two such workers can wait for each other for ever.
    ///
    /// # Errors
    /// [`OverLimit`] for more than the whole budget, at once, or as soon as so much is kept that waiting would never
    /// end. The request is refused and not clamped, for a clamped job would use more than it was lent.
    pub fn acquire(&self, bytes: u64) -> Result<Reservation, OverLimit> {
        let mut state = self.shared.lock();
        self.check(&state, bytes)?;
        let ticket = state.next_ticket;
        state.next_ticket += 1;
        while state.now_serving != ticket || (!self.fits(&state, bytes) && self.check(&state, bytes).is_ok())
        {
            state = self.shared.changed.wait(state).unwrap_or_else(PoisonError::into_inner);
        }
        state.now_serving += 1;
        let lent = self.check(&state, bytes).map(|()| self.lend(&mut state, bytes));
        drop(state);
        // The next in the queue may fit as well.
        self.shared.changed.notify_all();
        lent
    }

    /// Lends `bytes` if they are free now and nobody waits; `None` else.
    ///
    /// # Errors
    /// [`OverLimit`] for more than the whole budget.
    pub fn try_acquire(&self, bytes: u64) -> Result<Option<Reservation>, OverLimit> {
        let mut state = self.shared.lock();
        self.check(&state, bytes)?;
        let free = state.now_serving == state.next_ticket && self.fits(&state, bytes);
        Ok(free.then(|| self.lend(&mut state, bytes)))
    }

    /// Takes bytes out of the budget for good: a job's result that stays in memory. More than is left may be kept, for
    /// it is there already; then nothing can be lent any more.
    pub fn keep(&self, bytes: u64) {
        let mut state = self.shared.lock();
        state.kept_bytes = state.kept_bytes.saturating_add(bytes);
        drop(state);
        // Who waits for more than is left now waits in vain.
        self.shared.changed.notify_all();
    }

    /// Bytes that were taken out for good.
    #[must_use]
    pub fn kept_bytes(&self) -> u64 {
        self.shared.lock().kept_bytes
    }

    /// The whole budget but what is kept, bytes.
    #[must_use]
    pub fn total_bytes(&self) -> u64 {
        self.shared.left_bytes(&self.shared.lock())
    }

    /// Bytes on loan now.
    #[must_use]
    pub fn lent_bytes(&self) -> u64 {
        self.shared.lock().lent_bytes
    }

    /// Most bytes that were on loan at one time.
    #[must_use]
    pub fn peak_lent_bytes(&self) -> u64 {
        self.shared.lock().peak_bytes
    }

    fn check(&self, state: &State, bytes: u64) -> Result<(), OverLimit> {
        let limit_bytes = self.shared.left_bytes(state);
        if bytes > limit_bytes { Err(OverLimit { needed_bytes: bytes, limit_bytes }) } else { Ok(()) }
    }

    fn fits(&self, state: &State, bytes: u64) -> bool {
        bytes <= self.shared.left_bytes(state).saturating_sub(state.lent_bytes)
    }

    fn lend(&self, state: &mut State, bytes: u64) -> Reservation {
        state.lent_bytes += bytes;
        state.peak_bytes = state.peak_bytes.max(state.lent_bytes);
        Reservation { shared: Arc::clone(&self.shared), bytes }
    }
}

impl Reservation {
    /// Bytes on loan.
    #[must_use]
    pub fn bytes(&self) -> u64 {
        self.bytes
    }

    /// Gives back all but `bytes`, when the large part of the work is over; does nothing if no more than that is held.
    pub fn shrink_to(&mut self, bytes: u64) {
        let back = self.bytes.saturating_sub(bytes);
        self.bytes -= back;
        self.shared.give_back(back);
    }
}

impl Drop for Reservation {
    fn drop(&mut self) {
        self.shared.give_back(self.bytes);
    }
}

impl Shared {
    /// The state is sums only and is whole after every statement, so a panic elsewhere leaves it usable.
    fn lock(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn left_bytes(&self, state: &State) -> u64 {
        self.total_bytes.saturating_sub(state.kept_bytes)
    }

    fn give_back(&self, bytes: u64) {
        self.lock().lent_bytes -= bytes;
        self.changed.notify_all();
    }
}

#[cfg(test)]
mod tests {
    use super::{MemoryBudget, OverLimit};
    use std::sync::mpsc;
    use std::thread;
    use std::time::{Duration, Instant};

    const PATIENCE: Duration = Duration::from_secs(20);

    /// Until `count` requests wait.
    fn wait_for_queue(budget: &MemoryBudget, count: u64) {
        let waiting = || {
            let state = budget.shared.lock();
            state.next_ticket - state.now_serving
        };
        let start = Instant::now();
        while waiting() != count {
            assert!(start.elapsed() < PATIENCE, "{} requests wait, not {count}", waiting());
            thread::yield_now();
        }
    }

    #[test]
    fn a_small_request_does_not_overtake_a_large_one() {
        let budget = MemoryBudget::new(100);
        let most = budget.acquire(60).expect("fits");
        let some = budget.acquire(30).expect("fits");
        thread::scope(|scope| {
            let large = scope.spawn(|| budget.acquire(50).expect("within the limit").bytes());
            wait_for_queue(&budget, 1);
            let small = scope.spawn(|| budget.acquire(10).expect("within the limit").bytes());
            wait_for_queue(&budget, 2);
            assert!(budget.try_acquire(1).expect("within the limit").is_none(), "a try overtook the queue");
            drop(some);
            thread::sleep(Duration::from_millis(30));
            wait_for_queue(&budget, 2);
            assert_eq!(budget.lent_bytes(), 60, "the small request overtook the large one");
            drop(most);
            assert_eq!((large.join().ok(), small.join().ok()), (Some(50), Some(10)));
        });
        assert_eq!(budget.lent_bytes(), 0);
    }

    #[test]
    fn many_that_fit_are_all_served_by_one_return() {
        let budget = MemoryBudget::new(90);
        let all = budget.acquire(90).expect("fits");
        let (sender, receiver) = mpsc::channel();
        for _ in 0..3 {
            let (budget, sender) = (budget.clone(), sender.clone());
            thread::spawn(move || sender.send(budget.acquire(30).expect("within the limit")));
        }
        wait_for_queue(&budget, 3);
        drop(all);
        // Nothing comes back until all three are served.
        let shares: Vec<_> = (0..3).map(|_| receiver.recv_timeout(PATIENCE).expect("served")).collect();
        drop(shares);
        assert_eq!((budget.lent_bytes(), budget.peak_lent_bytes()), (0, 90));
    }

    #[test]
    fn what_is_lent_comes_back() {
        let budget = MemoryBudget::new(100);
        assert_eq!((budget.total_bytes(), budget.lent_bytes(), budget.peak_lent_bytes()), (100, 0, 0));
        let mut first = budget.acquire(70).expect("fits");
        let nothing = budget.acquire(0).expect("fits");
        assert!(budget.try_acquire(31).expect("within the limit").is_none());
        first.shrink_to(80);
        assert_eq!((first.bytes(), budget.lent_bytes()), (70, 70), "shrinking never grows");
        first.shrink_to(20);
        assert_eq!((first.bytes(), budget.lent_bytes()), (20, 20));
        let second = budget.try_acquire(80).expect("within the limit").expect("free");
        assert_eq!((second.bytes(), nothing.bytes(), budget.lent_bytes()), (80, 0, 100));
        drop((first, second, nothing));
        assert_eq!((budget.lent_bytes(), budget.peak_lent_bytes()), (0, 100));
    }

    #[test]
    fn what_is_kept_is_not_lent_and_ends_vain_waiting() {
        let budget = MemoryBudget::new(100);
        let some = budget.acquire(50).expect("fits");
        thread::scope(|scope| {
            let large = scope.spawn(|| budget.acquire(80).map(|r| r.bytes()));
            wait_for_queue(&budget, 1);
            budget.keep(15);
            thread::sleep(Duration::from_millis(30));
            wait_for_queue(&budget, 1);
            assert_eq!((budget.total_bytes(), budget.kept_bytes()), (85, 15));
            budget.keep(15);
            let refused = Err(OverLimit { needed_bytes: 80, limit_bytes: 70 });
            assert_eq!(large.join().ok(), Some(refused), "80 of 70 can never be lent");
        });
        assert!(budget.try_acquire(21).expect("within the limit").is_none());
        let rest = budget.try_acquire(20).expect("within the limit").expect("free");
        drop((some, rest));
        budget.keep(200);
        assert_eq!((budget.total_bytes(), budget.lent_bytes()), (0, 0));
    }

    #[test]
    fn more_than_the_whole_is_refused_at_once() {
        for (limit_bytes, needed_bytes) in [(0, 1), (99, 100), (100, u64::MAX)] {
            let budget = MemoryBudget::new(limit_bytes);
            let expected = OverLimit { needed_bytes, limit_bytes };
            assert_eq!(budget.acquire(needed_bytes).err(), Some(expected));
            assert_eq!(budget.try_acquire(needed_bytes).err(), Some(expected));
            assert_eq!(budget.lent_bytes(), 0);
        }
    }
}
