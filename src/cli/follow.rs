//! Following a job to its end over gRPC.

use std::time::Duration;

use crate::grpc::proto::{self, JobState, job_event::Kind};

use super::client::Client;
use super::failure::Failure;
use super::progress::{Display, Standing};

/// A stream that breaks off is taken up again this often without progress.
const ATTEMPTS: u32 = 5;
const PAUSE: Duration = Duration::from_secs(1);

/// Follows job `id` until it has ended, showing its progress on `display`.
/// A broken connection is taken up where it ended; nothing is missed.
pub(super) async fn follow(
    client: &Client,
    id: &str,
    display: &mut Display,
) -> Result<proto::Finished, Failure> {
    let (mut seen, mut attempts) = (0, 0);
    loop {
        let mut events = match client.watch(id, seen).await {
            Ok(events) => events,
            // A server that was there a moment ago may be starting again.
            Err(_) if (1..ATTEMPTS).contains(&attempts) => {
                attempts += 1;
                tokio::time::sleep(PAUSE).await;
                continue;
            }
            Err(failure) => return Err(failure),
        };
        let broken = loop {
            match events.message().await {
                Ok(Some(event)) => {
                    (seen, attempts) = (event.seq, 0);
                    match event.kind {
                        Some(Kind::Finished(finished)) => return Ok(finished),
                        Some(Kind::Progress(progress)) => display.show(&standing(&progress)),
                        Some(Kind::State(state)) => display.message(state_name(state.state)),
                        None => {}
                    }
                }
                Ok(None) => break Failure::planning("the server ended the stream before the job"),
                Err(status) => break client.refused_call(&status),
            }
        };
        attempts += 1;
        if attempts >= ATTEMPTS {
            return Err(broken);
        }
        tokio::time::sleep(PAUSE).await;
    }
}

fn standing(progress: &proto::Progress) -> Standing<'_> {
    Standing {
        leg: progress.leg.as_deref(),
        method: progress.method.as_deref(),
        iteration: progress.iteration,
        evaluations: progress.evaluations,
        best: progress.best,
        lower_bound: progress.lower_bound,
        members: progress.members.as_ref().map(|it| [it.done as usize, it.of as usize]),
        slowest: progress.members.as_ref().and_then(|it| it.slowest),
    }
}

fn state_name(state: i32) -> &'static str {
    match JobState::try_from(state) {
        Ok(JobState::Queued) => "queued",
        Ok(JobState::Running) => "running",
        Ok(JobState::Succeeded) => "succeeded",
        Ok(JobState::Failed) => "failed",
        Ok(JobState::Cancelled) => "cancelled",
        Ok(JobState::Expired) => "expired",
        Ok(JobState::Unspecified) | Err(_) => "in a state this client does not know",
    }
}

/// The line that tells how a job ended; a failure unless it succeeded.
pub(super) fn outcome(finished: &proto::Finished) -> Result<String, Failure> {
    if finished.state == JobState::Succeeded as i32 {
        return Ok(finished.summary.as_ref().map_or("succeeded".to_owned(), summary));
    }
    let state = state_name(finished.state);
    Err(Failure::planning(match &finished.error {
        Some(error) => format!("the job {state}: {} ({})", error.message, error.code),
        None => format!("the job was {state}"),
    }))
}

fn summary(summary: &proto::ResultSummary) -> String {
    let work = format!("{} evaluations in {:.3} s", summary.evaluations, summary.planning_s);
    if let Some(verdict) = &summary.verdict {
        return format!("{verdict} {work}");
    }
    let lawful = if summary.lawful() { "lawful" } else { "NOT LAWFUL" };
    let bound = summary.lower_bound.map(|bound| format!(", no plan can be below {bound:.4} s"));
    format!(
        "{:.4} s, {lawful}, largest peak {:.2} % of its limit{}; {work}",
        summary.duration(),
        100.0 * summary.worst_ratio(),
        bound.unwrap_or_default(),
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cli::failure::Exit;

    #[test]
    fn only_success_is_success() {
        let summary = proto::ResultSummary {
            duration: Some(7.0255),
            lawful: Some(true),
            worst_ratio: Some(1.0),
            lower_bound: Some(4.8),
            legs: 1,
            evaluations: 500,
            planning_s: 0.004,
            verdict: None,
        };
        let mut finished = proto::Finished {
            state: JobState::Succeeded as i32,
            summary: Some(summary),
            error: None,
        };
        assert_eq!(
            outcome(&finished).unwrap(),
            "7.0255 s, lawful, largest peak 100.00 % of its limit, no plan can be below 4.8000 s; \
             500 evaluations in 0.004 s"
        );
        finished.state = JobState::Failed as i32;
        finished.error = Some(proto::JobError {
            code: "limits_unreachable".into(),
            message: "no way".into(),
            details: None,
        });
        let failure = outcome(&finished).unwrap_err();
        assert_eq!(failure.text(), "error: the job failed: no way (limits_unreachable)\n");
        assert_eq!(failure.exit(), Exit::Planning);
    }
}
