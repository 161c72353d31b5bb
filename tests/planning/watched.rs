//! Objectives to try optimizers on: plain functions, and any objective watched.

use std::collections::HashSet;
use std::sync::Mutex;
use std::sync::atomic::{AtomicU64, AtomicUsize, Ordering};
use std::thread::ThreadId;
use std::time::{Duration, Instant};

use takt::budget::CancelToken;
use takt::optimize::{Appraisal, Bounds, Candidate, Objective, Ratios};

/// A function over a box.
pub struct Plain {
    bounds: Bounds,
    function: fn(&[f64]) -> f64,
}

impl Plain {
    /// Over the same interval in every variable.
    pub fn new(dimension: usize, [lower, upper]: [f64; 2], function: fn(&[f64]) -> f64) -> Self {
        let bounds = Bounds { lower: vec![lower; dimension], upper: vec![upper; dimension] };
        Self { bounds, function }
    }
}

struct PlainCandidate(fn(&[f64]) -> f64);

impl Candidate for PlainCandidate {
    fn fitness(&mut self, position: &[f64]) -> f64 {
        (self.0)(position)
    }
}

impl Objective for Plain {
    fn bounds(&self) -> &Bounds {
        &self.bounds
    }

    fn candidate(&self) -> Box<dyn Candidate + '_> {
        Box::new(PlainCandidate(self.function))
    }

    fn evaluation_ns(&self) -> f64 {
        50.0
    }
}

/// What an objective answers instead of the truth.
#[derive(Clone, Copy)]
pub enum Answer {
    Truth,
    Always(f64),
    /// No number for every other candidate.
    NanEveryOther,
}

/// An objective that is watched, and can be made difficult.
pub struct Watched<'a> {
    inner: &'a dyn Objective,
    pub answer: Answer,
    pub evaluation_ns: f64,
    /// At which evaluation to cancel what.
    pub cancel: Option<(u64, CancelToken)>,
    /// Every evaluation waits until this many threads have come.
    pub threads_awaited: usize,
    /// How long every evaluation sleeps.
    pub pause: Duration,
    evaluations: AtomicU64,
    outside: AtomicU64,
    candidates: AtomicUsize,
    threads: Mutex<HashSet<ThreadId>>,
}

impl<'a> Watched<'a> {
    pub fn new(inner: &'a dyn Objective) -> Self {
        Self {
            inner,
            answer: Answer::Truth,
            evaluation_ns: inner.evaluation_ns(),
            cancel: None,
            threads_awaited: 0,
            pause: Duration::ZERO,
            evaluations: AtomicU64::new(0),
            outside: AtomicU64::new(0),
            candidates: AtomicUsize::new(0),
            threads: Mutex::default(),
        }
    }

    pub fn evaluations(&self) -> u64 {
        self.evaluations.load(Ordering::Relaxed)
    }

    pub fn outside(&self) -> u64 {
        self.outside.load(Ordering::Relaxed)
    }

    /// Evaluators ask for one per thread.
    pub fn candidates(&self) -> usize {
        self.candidates.load(Ordering::Relaxed)
    }

    /// Threads that came while some were awaited.
    pub fn threads(&self) -> usize {
        self.threads.lock().unwrap().len()
    }

    fn count(&self) -> u64 {
        let number = self.evaluations.fetch_add(1, Ordering::Relaxed) + 1;
        if let Some((_, token)) = self.cancel.as_ref().filter(|(at, _)| *at == number) {
            token.cancel();
        }
        std::thread::sleep(self.pause);
        self.meet();
        number
    }

    /// Waits for other threads, so that one alone cannot do everything before
    /// the others wake up.
    fn meet(&self) {
        if self.threads_awaited == 0 {
            return;
        }
        self.threads.lock().unwrap().insert(std::thread::current().id());
        let patience = Instant::now() + Duration::from_secs(20);
        while self.threads.lock().unwrap().len() < self.threads_awaited {
            assert!(Instant::now() < patience, "no other thread came");
            std::thread::yield_now();
        }
    }
}

struct WatchedCandidate<'a> {
    watch: &'a Watched<'a>,
    inner: Box<dyn Candidate + 'a>,
}

impl WatchedCandidate<'_> {
    fn look(&self, position: &[f64]) -> u64 {
        let bounds = self.watch.inner.bounds();
        let ends = bounds.lower.iter().zip(&bounds.upper);
        if !position.iter().zip(ends).all(|(x, (lower, upper))| (lower..=upper).contains(&x)) {
            self.watch.outside.fetch_add(1, Ordering::Relaxed);
        }
        self.watch.count()
    }

    fn answer(&self, number: u64, truth: f64) -> f64 {
        match self.watch.answer {
            Answer::Always(value) => value,
            Answer::NanEveryOther if number.is_multiple_of(2) => f64::NAN,
            Answer::Truth | Answer::NanEveryOther => truth,
        }
    }
}

impl Candidate for WatchedCandidate<'_> {
    fn fitness(&mut self, position: &[f64]) -> f64 {
        let number = self.look(position);
        let truth = self.inner.fitness(position);
        self.answer(number, truth)
    }

    fn appraise(&mut self, position: &[f64]) -> Appraisal {
        let number = self.look(position);
        let truth = self.inner.appraise(position);
        Appraisal { fitness: self.answer(number, truth.fitness), ..truth }
    }

    fn repair(&mut self, position: &mut [f64]) {
        self.inner.repair(position);
    }

    fn homogeneous(&mut self, position: &[f64], ratios: &mut Ratios) -> f64 {
        let number = self.watch.count();
        let violation = self.inner.homogeneous(position, ratios);
        for ratio in ratios.iter_mut().flatten() {
            *ratio = self.answer(number, *ratio);
        }
        violation
    }
}

impl Objective for Watched<'_> {
    fn bounds(&self) -> &Bounds {
        self.inner.bounds()
    }

    fn candidate(&self) -> Box<dyn Candidate + '_> {
        self.candidates.fetch_add(1, Ordering::Relaxed);
        Box::new(WatchedCandidate { watch: self, inner: self.inner.candidate() })
    }

    fn evaluation_ns(&self) -> f64 {
        self.evaluation_ns
    }

    fn starts(&self) -> Vec<Vec<f64>> {
        self.inner.starts()
    }

    fn is_homogeneous(&self) -> bool {
        self.inner.is_homogeneous()
    }
}
