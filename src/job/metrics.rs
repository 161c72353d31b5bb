//! Prometheus metrics of the jobs and their store.

use prometheus::{
    Histogram, HistogramOpts, HistogramVec, IntCounter, IntCounterVec, IntGauge, IntGaugeVec, Opts,
    Registry, TextEncoder,
};

use super::JobState;

/// All metrics of the process, in a registry of their own.
pub struct Metrics {
    registry: Registry,
    /// Jobs that wait for a worker.
    pub queue_depth: IntGauge,
    /// Jobs that run.
    pub running: IntGauge,
    /// Rejected submissions, by the error code that the client got.
    pub rejections: IntCounterVec,
    /// Results that came after their job had ended or been claimed anew.
    pub discarded_results: IntCounter,
    /// Seconds a commit takes.
    pub store_commit_seconds: Histogram,
    /// Writes that share a commit.
    pub store_batch_size: Histogram,
    ended: IntCounterVec,
    wait_seconds: HistogramVec,
    run_seconds: HistogramVec,
    evaluations: IntCounterVec,
}

/// From a millisecond to several minutes, about three steps per decade.
const SECONDS: &[f64] =
    &[0.001, 0.002, 0.005, 0.01, 0.02, 0.05, 0.1, 0.2, 0.5, 1.0, 2.0, 5.0, 10.0, 30.0, 60.0, 300.0];
const COMMIT_SECONDS: &[f64] =
    &[0.0001, 0.0002, 0.0005, 0.001, 0.002, 0.005, 0.01, 0.02, 0.05, 0.1, 0.5, 1.0];
const BATCH: &[f64] = &[1.0, 2.0, 4.0, 8.0, 16.0, 32.0, 64.0, 128.0, 256.0, 512.0];

impl Metrics {
    /// Registers all metrics, each at zero.
    ///
    /// # Errors
    ///
    /// If two metrics had the same name.
    pub fn new() -> Result<Self, prometheus::Error> {
        let registry = Registry::new();
        let add = Adder(&registry);
        let build = add.gauges("takt_build_info", "Always 1; names the version.", &["version"])?;
        build.with_label_values(&[env!("CARGO_PKG_VERSION")]).set(1);
        Ok(Self {
            queue_depth: add.gauge("takt_queue_depth", "Jobs that wait for a worker.")?,
            running: add.gauge("takt_jobs_running", "Jobs that run.")?,
            rejections: add.counters(
                "takt_rejections_total",
                "Rejected submissions by error code.",
                &["code"],
            )?,
            discarded_results: add.counter(
                "takt_discarded_results_total",
                "Results that came after their job had ended or been claimed anew.",
            )?,
            store_commit_seconds: add.histogram(
                "takt_store_commit_seconds",
                "Seconds a commit takes.",
                COMMIT_SECONDS,
            )?,
            store_batch_size: add.histogram(
                "takt_store_batch_size",
                "Writes that share a commit.",
                BATCH,
            )?,
            ended: add.counters(
                "takt_jobs_ended_total",
                "Ended jobs by final state, task and method.",
                &["state", "task", "method"],
            )?,
            wait_seconds: add.histograms(
                "takt_job_wait_seconds",
                "Seconds from acceptance to the start of an attempt.",
            )?,
            run_seconds: add.histograms("takt_job_run_seconds", "Seconds an attempt runs.")?,
            evaluations: add.counters(
                "takt_evaluations_total",
                "Evaluations of the objective by method.",
                &["method"],
            )?,
            registry,
        })
    }

    /// An attempt began after `wait_s` seconds.
    pub(super) fn started(&self, task: &str, method: &str, wait_s: f64) {
        self.wait_seconds.with_label_values(&[task, method]).observe(wait_s);
    }

    /// An attempt ran for `run_s` seconds and evaluated the objective so often.
    pub(super) fn ran(&self, task: &str, method: &str, run_s: f64, evaluations: u64) {
        self.run_seconds.with_label_values(&[task, method]).observe(run_s);
        self.evaluations.with_label_values(&[method]).inc_by(evaluations);
    }

    /// A job ended.
    pub(super) fn ended(&self, state: JobState, task: &str, method: &str) {
        self.ended.with_label_values(&[state.as_str(), task, method]).inc();
    }

    /// Everything in Prometheus' text format.
    ///
    /// # Errors
    ///
    /// If a metric cannot be written as text.
    pub fn text(&self) -> Result<String, prometheus::Error> {
        TextEncoder::new().encode_to_string(&self.registry.gather())
    }
}

/// Creates metrics and registers them.
struct Adder<'a>(&'a Registry);

impl Adder<'_> {
    fn register<C>(&self, metric: C) -> Result<C, prometheus::Error>
    where
        C: prometheus::core::Collector + Clone + 'static,
    {
        self.0.register(Box::new(metric.clone()))?;
        Ok(metric)
    }

    fn gauge(&self, name: &str, help: &str) -> Result<IntGauge, prometheus::Error> {
        self.register(IntGauge::new(name, help)?)
    }

    fn gauges(
        &self,
        name: &str,
        help: &str,
        labels: &[&str],
    ) -> Result<IntGaugeVec, prometheus::Error> {
        self.register(IntGaugeVec::new(Opts::new(name, help), labels)?)
    }

    fn counter(&self, name: &str, help: &str) -> Result<IntCounter, prometheus::Error> {
        self.register(IntCounter::new(name, help)?)
    }

    fn counters(
        &self,
        name: &str,
        help: &str,
        labels: &[&str],
    ) -> Result<IntCounterVec, prometheus::Error> {
        self.register(IntCounterVec::new(Opts::new(name, help), labels)?)
    }

    fn histogram(
        &self,
        name: &str,
        help: &str,
        buckets: &[f64],
    ) -> Result<Histogram, prometheus::Error> {
        let options = HistogramOpts::new(name, help).buckets(buckets.to_vec());
        self.register(Histogram::with_opts(options)?)
    }

    fn histograms(&self, name: &str, help: &str) -> Result<HistogramVec, prometheus::Error> {
        let options = HistogramOpts::new(name, help).buckets(SECONDS.to_vec());
        self.register(HistogramVec::new(options, &["task", "method"])?)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn counts_appear_in_the_text() {
        let metrics = Metrics::new().unwrap();
        metrics.started("waypoints", "pso", 0.5);
        metrics.ran("waypoints", "pso", 1.0, 5000);
        metrics.ended(JobState::Succeeded, "waypoints", "pso");
        metrics.rejections.with_label_values(&["queue_full"]).inc();
        let text = metrics.text().unwrap();
        for line in [
            "takt_jobs_ended_total{method=\"pso\",state=\"succeeded\",task=\"waypoints\"} 1",
            "takt_evaluations_total{method=\"pso\"} 5000",
            "takt_rejections_total{code=\"queue_full\"} 1",
            "takt_job_wait_seconds_count{method=\"pso\",task=\"waypoints\"} 1",
            "takt_queue_depth 0",
            &format!("takt_build_info{{version=\"{}\"}} 1", env!("CARGO_PKG_VERSION")),
        ] {
            assert!(text.lines().any(|found| found == line), "{line} not in\n{text}");
        }
    }
}
