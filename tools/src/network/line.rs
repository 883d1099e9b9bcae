//! The line to a server: how many requests are on it at a time, and which stretches of bytes go as one.
//!
//! There are no threads here. Whoever waits for bytes either finds room on the line, and then carries the oldest request that waits, with those
//! next to it; or is woken when somebody else has carried his.

use std::collections::HashMap;
use std::ops::Range;
use std::sync::{Condvar, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};
use terrane_planet::published::{FetchError, Freshness, ObjectName};

/// Most requests on the line at a time, and how many there are at first.
const WIDEST: f64 = 6.0;
const FIRST: f64 = 3.0;

/// Bytes between two stretches that are fetched along rather than asked for apart.
const GAP: u64 = 2048;

/// Most bytes of a request.
const LARGEST: u64 = 1 << 20;

/// Longer requests make the line narrower: more would only wait for each other.
const SLOW: Duration = Duration::from_secs(2);

/// Stretches that wait or are on their way, from which on the line is busy.
const BUSY: usize = 12;

/// Longest time that a server's wish to be left alone is granted.
const LONGEST_REST: Duration = Duration::from_secs(30);

/// What came of a request.
#[derive(Debug)]
pub(super) enum Carried {
    /// The bytes of its range.
    Bytes(Vec<u8>),
    /// They will not come.
    Missing(String),
    /// They do not come now.
    Failed(String),
    /// The server is at its limit; after how long it may be asked again.
    Refused(String, Duration),
}

/// A stretch that somebody waits for: of what, and which bytes.
pub(super) type Stretch = ((ObjectName, Freshness), Range<u64>);

#[derive(Default)]
struct State {
    /// In the order in which they were asked for.
    waiting: Vec<(u64, Stretch)>,
    /// Answers that nobody has fetched.
    answers: HashMap<u64, Result<Vec<u8>, FetchError>>,
    next: u64,
    /// Requests on the line.
    active: usize,
    /// Stretches of these.
    on_their_way: usize,
    /// How many requests there may be.
    window: f64,
    rests_until: Option<Instant>,
    /// Requests and bytes so far.
    requests: u64,
    bytes: u64,
}

impl State {
    /// How long the server is to be left alone, if it is.
    fn rests(&self) -> Option<Duration> {
        let rest = self.rests_until?.saturating_duration_since(Instant::now());
        Some(rest).filter(|rest| !rest.is_zero())
    }
}

/// A line.
pub(super) struct Line {
    state: Mutex<State>,
    changed: Condvar,
}

impl Line {
    /// A line with nothing on it.
    pub(super) fn new() -> Line {
        Line { state: Mutex::new(State { window: FIRST, ..State::default() }), changed: Condvar::new() }
    }

    /// Whether as much is under way as can be.
    pub(super) fn is_busy(&self) -> bool {
        let state = self.lock();
        state.rests().is_some() || state.waiting.len() + state.on_their_way >= BUSY
    }

    /// Requests and bytes of their answers so far.
    pub(super) fn traffic(&self) -> (u64, u64) {
        let state = self.lock();
        (state.requests, state.bytes)
    }

    /// The bytes of a stretch; `carry` asks the server for one.
    pub(super) fn fetch(&self, stretch: Stretch, carry: &dyn Fn(&Stretch) -> Carried) -> Result<Vec<u8>, FetchError> {
        let mut state = self.lock();
        let number = state.next;
        state.next += 1;
        state.waiting.push((number, stretch));
        loop {
            if let Some(answer) = state.answers.remove(&number) {
                return answer;
            }
            let rest =
                state.rests_until.map(|until| until.saturating_duration_since(Instant::now())).filter(|rest| !rest.is_zero());
            if rest.is_none() && !state.waiting.is_empty() && (state.active as f64) < state.window.floor() {
                state = self.carry_oldest(state, carry);
                continue;
            }
            let limit = rest.unwrap_or(LONGEST_REST);
            state = self.changed.wait_timeout(state, limit).unwrap_or_else(PoisonError::into_inner).0;
        }
    }

    /// Carries the oldest request that waits, with those next to it, and hands out the answers.
    fn carry_oldest<'a>(
        &'a self,
        mut state: MutexGuard<'a, State>,
        carry: &dyn Fn(&Stretch) -> Carried,
    ) -> MutexGuard<'a, State> {
        let (request, taken) = take(&mut state.waiting);
        state.active += 1;
        state.on_their_way += taken.len();
        drop(state);
        let begun = Instant::now();
        let carried = carry(&request);
        let took = begun.elapsed();
        let mut state = self.lock();
        state.active -= 1;
        state.on_their_way -= taken.len();
        state.requests += 1;
        match &carried {
            Carried::Bytes(bytes) => {
                state.bytes += bytes.len() as u64;
                let step = if took < SLOW { 1.0 / state.window } else { -1.0 };
                state.window = (state.window + step).clamp(1.0, WIDEST);
            }
            Carried::Refused(_, rest) => {
                state.window = (state.window / 2.0).max(1.0);
                state.rests_until = Some(Instant::now() + (*rest).min(LONGEST_REST));
            }
            Carried::Missing(_) | Carried::Failed(_) => state.window = (state.window / 2.0).max(1.0),
        }
        for (number, range) in taken {
            let answer = match &carried {
                Carried::Bytes(bytes) => Ok(part(bytes, request.1.start, &range)),
                Carried::Missing(reason) => Err(FetchError::Missing(reason.clone())),
                Carried::Failed(reason) | Carried::Refused(reason, _) => Err(FetchError::Unreachable(reason.clone())),
            };
            state.answers.insert(number, answer);
        }
        self.changed.notify_all();
        state
    }

    fn lock(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// A range of bytes that begin at `first`, as far as there are such.
fn part(bytes: &[u8], first: u64, range: &Range<u64>) -> Vec<u8> {
    let at = |position: u64| usize::try_from(position.saturating_sub(first)).unwrap_or(usize::MAX).min(bytes.len());
    bytes[at(range.start)..at(range.end)].to_vec()
}

/// Takes the oldest stretch and those that lie next to it, as one.
fn take(waiting: &mut Vec<(u64, Stretch)>) -> (Stretch, Vec<(u64, Range<u64>)>) {
    let (number, (object, mut whole)) = waiting.remove(0);
    let mut taken = vec![(number, whole.clone())];
    loop {
        let fits = |(_, (other, range)): &(u64, Stretch)| {
            let (start, end) = (whole.start.min(range.start), whole.end.max(range.end));
            let is_near = range.start <= whole.end.saturating_add(GAP) && whole.start <= range.end.saturating_add(GAP);
            *other == object && is_near && end - start <= LARGEST
        };
        let Some(k) = waiting.iter().position(fits) else { return ((object, whole), taken) };
        let (number, (_, range)) = waiting.remove(k);
        whole = whole.start.min(range.start)..whole.end.max(range.end);
        taken.push((number, range));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::atomic::{AtomicUsize, Ordering};

    #[test]
    fn stretches_next_to_each_other_go_as_one_and_others_apart() {
        let [a, b] = [b"a", b"b"].map(|bytes| (ObjectName::of(bytes), Freshness::Any));
        let mut waiting =
            vec![(1, (a, 5000..6000)), (2, (b, 6000..7000)), (3, (a, 0..10)), (4, (a, 3500..4000)), (5, (a, 9000..9001))];
        let (request, taken) = take(&mut waiting);
        assert_eq!(request, (a, 3500..6000));
        assert_eq!(taken.iter().map(|(number, _)| *number).collect::<Vec<_>>(), [1, 4]);
        // 0..10 is more than the gap away from the first, but not from what it grew to.
        let mut chain = vec![(1, (a, 5000..6000)), (2, (a, 0..2000)), (3, (a, 3000..4000))];
        assert_eq!(take(&mut chain).0, (a, 0..6000));
        assert_eq!(waiting.len(), 3);
    }

    #[test]
    fn everybody_gets_his_bytes_and_a_line_at_its_limit_rests() {
        let (line, object) = (Line::new(), (ObjectName::of(b"a"), Freshness::Any));
        let (now, most, refusals) = (AtomicUsize::new(0), AtomicUsize::new(0), AtomicUsize::new(0));
        let carry = |(_, range): &Stretch| {
            most.fetch_max(now.fetch_add(1, Ordering::SeqCst) + 1, Ordering::SeqCst);
            std::thread::sleep(Duration::from_millis(5));
            now.fetch_sub(1, Ordering::SeqCst);
            if range.start == 0 && refusals.fetch_add(1, Ordering::SeqCst) == 0 {
                return Carried::Refused("at its limit".to_owned(), Duration::from_millis(50));
            }
            Carried::Bytes((range.start..range.end).map(|k| (k / 10_000) as u8).collect())
        };
        std::thread::scope(|scope| {
            for k in 0..40u64 {
                let (line, carry) = (&line, &carry);
                scope.spawn(move || {
                    let range = k * 10_000..k * 10_000 + 100;
                    match line.fetch((object, range.clone()), carry) {
                        Ok(bytes) => assert_eq!(bytes, vec![k as u8; 100]),
                        Err(error) => assert!(k == 0 && error.to_string() == "at its limit", "{k}: {error}"),
                    }
                });
            }
        });
        assert!(most.load(Ordering::SeqCst) <= WIDEST as usize && !line.is_busy());
        assert_eq!(line.traffic(), (40, 3900));
    }
}
