//! What an ended job produced: the result as stored, and views of it.

use axum::extract::State;
use axum::response::{IntoResponse, Response};
use http::{HeaderValue, header};
use serde::Serialize;
use utoipa::ToSchema;

use super::input::{JobPath, Parameters};
use super::jobs::json_text;
use super::problem::{Problem, ProblemFault, Problems};
use super::{Edge, comparisons};
use crate::job::JobId;
use crate::optimize::ConvergencePoint;
use crate::picture::{self, Curve, Section};
use crate::plan::{ComparisonResult, PathResult, PlanMetrics, PlanResult, TrajectoryResult};
use crate::service::{ServiceError, blocking};
use crate::trajectory::{
    BindingTimeline, Certificate, JointTrajectory, Quantity, Samples, Timeline, Trajectory,
};

/// The trajectories asked for.
struct Parts<'a> {
    sections: Vec<Section<'a>>,
    /// True for all legs of a program.
    legs: bool,
}

impl<'a> Parts<'a> {
    /// What `leg` names in `result`; everything without a name. Of a family that is
    /// the worst case.
    fn of(result: &'a PlanResult, leg: Option<&str>) -> Result<Self, Problem> {
        if matches!(result, PlanResult::Path(_)) {
            let detail = "a path has no trajectory; see /result, /plot.svg and /convergence";
            return Err(Problem::not_found(detail));
        }
        if matches!(result, PlanResult::Comparison(_)) {
            let detail = "a comparison or benchmark has no trajectory; see /result, /metrics, \
                          /convergence and /page";
            return Err(Problem::not_found(detail));
        }
        let Some(name) = leg else {
            let legs = matches!(result, PlanResult::Program(_));
            return Ok(Self { sections: Section::all(result), legs });
        };
        let section = Section::leg(result, name).ok_or_else(|| {
            if let PlanResult::Family(family) = result {
                let slowest = &family.slowest;
                let detail = format!(
                    "of a family the slowest member's plan is kept, `{slowest}`, and not `{name}`"
                );
                return Problem::not_found(detail);
            }
            let known = Section::all(result).into_iter().filter_map(|section| section.name);
            let known = match known.collect::<Vec<_>>()[..] {
                [] => "the job is no program".to_owned(),
                ref known => format!("there are: {}", known.join(", ")),
            };
            Problem::not_found(format!("there is no leg `{name}`; {known}"))
        })?;
        Ok(Self { sections: vec![section], legs: false })
    }

    /// One `view` of the trajectory, or a list of them with the legs' names.
    fn views<T>(&self, view: impl Fn(&'a TrajectoryResult) -> T) -> Views<T> {
        match &self.sections[..] {
            [only] if !self.legs => Views::One(view(only.result)),
            sections => {
                let views = sections.iter().map(|section| LegView {
                    leg: section.name.unwrap_or_default().to_owned(),
                    start: section.start,
                    view: view(section.result),
                });
                Views::Legs { legs: views.collect() }
            }
        }
    }

    /// [`views`](Self::views) as JSON.
    fn json<T: Serialize>(
        &self,
        view: impl Fn(&'a TrajectoryResult) -> T,
    ) -> Result<Response, Problem> {
        json(&self.views(view))
    }

    /// All trajectories on one time axis.
    fn timeline(&self) -> Option<Timeline<'a>> {
        let first = self.sections.first()?.result;
        let legs = self.sections.iter().map(|it| (it.start, &it.result.trajectory)).collect();
        Some(Timeline { joint_names: &first.joint_names, joint_units: &first.joint_units, legs })
    }
}

/// A view of one trajectory or, for a whole program, of each leg's.
#[derive(Serialize, ToSchema)]
#[serde(untagged)]
pub(super) enum Views<T> {
    /// Of a task with one trajectory, or of the leg asked for.
    One(T),
    /// Of a program's legs in order.
    Legs {
        /// One per leg.
        legs: Vec<LegView<T>>,
    },
}

/// A view of one leg of a program.
#[derive(Serialize, ToSchema)]
pub(super) struct LegView<T> {
    /// The leg's name.
    leg: String,
    /// When it starts within the program, s.
    start: f64,
    /// What was asked for.
    #[serde(flatten)]
    view: T,
}

/// A trajectory with what is needed to read it.
#[derive(Serialize, ToSchema)]
pub(super) struct Polynomials {
    /// Joint order of the coefficients.
    joint_names: Vec<String>,
    /// `rad` or `m` per joint.
    joint_units: Vec<String>,
    /// Breakpoints and coefficients.
    #[serde(flatten)]
    trajectory: Trajectory,
}

/// A trajectory as JSON, in the form asked for.
#[derive(Serialize, ToSchema)]
#[serde(untagged)]
enum TrajectoryDocument {
    /// Exact: breakpoints and coefficients.
    Polynomial(Views<Polynomials>),
    /// Sampled at the rate asked for.
    Samples(Samples),
    /// Sampled, in the shape of ROS' trajectory_msgs/JointTrajectory.
    JointTrajectory(JointTrajectory),
}

/// Reads a job's result and makes something of it, on a thread that may
/// compute for long.
pub(super) async fn from_result<T: Send + 'static>(
    edge: &Edge,
    id: JobId,
    make: impl FnOnce(&PlanResult) -> Result<T, Problem> + Send + 'static,
) -> Result<T, Problem> {
    let result = edge.service.result(id).await?;
    blocking(move || make(&result)).await
}

pub(super) fn json<T: Serialize>(value: &T) -> Result<Response, Problem> {
    Ok(json_text(serde_json::to_string(value).map_err(ServiceError::internal)?))
}

/// Get the result, byte for byte as it was stored
#[utoipa::path(
    get, path = "/v1/jobs/{id}/result", tag = "results",
    params(
        ("id" = String, Path, format = "uuid", description = "The job's id"),
        ("partial" = Option<bool>, Query,
            description = "`true` also serves what a job that did not succeed left of its plan"),
    ),
    responses((status = 200, description = "The result", body = PlanResult), Problems),
)]
pub(super) async fn result(
    State(edge): State<Edge>,
    JobPath(id): JobPath,
    mut query: Parameters,
) -> Result<Response, Problem> {
    let partial = query.value("partial").unwrap_or(false);
    let partial = query.finish(partial)?;
    let text = if partial {
        edge.service.partial_result_text(id).await?
    } else {
        edge.service.result_text(id).await?
    };
    Ok(json_text(text))
}

/// The figures of a plan, or of compared methods.
#[derive(Serialize, ToSchema)]
#[serde(untagged)]
#[expect(dead_code, reason = "describes what is written apart")]
enum Metrics {
    /// Of one trajectory or of each leg's.
    Plan(Views<PlanMetrics>),
    /// Of a comparison or benchmark: its result without the curves.
    Comparison(ComparisonResult),
}

/// Get the figures that describe the plan
#[utoipa::path(
    get, path = "/v1/jobs/{id}/metrics", tag = "results",
    params(
        ("id" = String, Path, format = "uuid", description = "The job's id"),
        ("leg" = Option<String>, Query, description = "One leg of a program; default a list of all. Of a family the worst case is shown"),
    ),
    responses((status = 200, description = "The figures", body = Metrics), Problems),
)]
pub(super) async fn metrics(
    State(edge): State<Edge>,
    JobPath(id): JobPath,
    query: Parameters,
) -> Result<Response, Problem> {
    let leg = leg(query)?;
    from_result(&edge, id, move |result| match result {
        PlanResult::Comparison(comparison) => comparisons::metrics(comparison, leg.as_deref()),
        _ => Parts::of(result, leg.as_deref())?.json(|part| &part.metrics),
    })
    .await
}

/// Get the certificate
#[utoipa::path(
    get, path = "/v1/jobs/{id}/certificate", tag = "results",
    params(
        ("id" = String, Path, format = "uuid", description = "The job's id"),
        ("leg" = Option<String>, Query, description = "One leg of a program; default a list of all. Of a family the worst case is shown"),
    ),
    responses((status = 200, description = "The certificate", body = Views<Certificate>), Problems),
)]
pub(super) async fn certificate(
    State(edge): State<Edge>,
    JobPath(id): JobPath,
    query: Parameters,
) -> Result<Response, Problem> {
    let leg = leg(query)?;
    from_result(&edge, id, move |result| {
        Parts::of(result, leg.as_deref())?.json(|part| &part.certificate)
    })
    .await
}

fn leg(mut query: Parameters) -> Result<Option<String>, Problem> {
    let leg = query.text("leg");
    query.finish(leg)
}

/// How a trajectory is written.
#[derive(Clone, Copy, ToSchema)]
#[schema(rename_all = "snake_case")]
enum Format {
    Polynomial,
    Samples,
    Csv,
    JointTrajectory,
}

/// Get the trajectory
///
/// `samples`, `csv` and `joint_trajectory` (the shape of ROS'
/// trajectory_msgs/JointTrajectory) are sampled at `rate_hz` and run through
/// all legs of a program unless one is named.
#[utoipa::path(
    get, path = "/v1/jobs/{id}/trajectory", tag = "results",
    params(
        ("id" = String, Path, format = "uuid", description = "The job's id"),
        ("format" = inline(Option<Format>), Query,
            description = "`polynomial` (default), `samples`, `csv` or `joint_trajectory`"),
        ("rate_hz" = Option<f64>, Query, exclusive_minimum = 0, maximum = 10_000,
            description = "Samples per second, above 0 to 10000; default 250; not with `polynomial`"),
        ("leg" = Option<String>, Query, description = "One leg of a program; default all. Of a family the worst case is shown"),
    ),
    responses(
        (status = 200, description = "The trajectory", content(
            (TrajectoryDocument = "application/json"), (String = "text/csv"),
        )),
        Problems,
    ),
)]
pub(super) async fn trajectory(
    State(edge): State<Edge>,
    JobPath(id): JobPath,
    mut query: Parameters,
) -> Result<Response, Problem> {
    const HIGHEST_RATE_HZ: f64 = 10_000.0;
    let format = query.choice(
        "format",
        &[
            ("polynomial", Format::Polynomial),
            ("samples", Format::Samples),
            ("csv", Format::Csv),
            ("joint_trajectory", Format::JointTrajectory),
        ],
    );
    let given = query.value("rate_hz");
    if let (Some(Format::Polynomial), Some(_)) = (format, given) {
        query.fault("rate_hz", "polynomials are exact and have no rate; choose another format");
    }
    let rate_hz = given.unwrap_or(250.0);
    if !(rate_hz > 0.0 && rate_hz <= HIGHEST_RATE_HZ) {
        query.fault("rate_hz", format!("{rate_hz} is not above 0 and at most {HIGHEST_RATE_HZ}"));
    }
    let leg = query.text("leg");
    let (format, leg) = query.finish((format.unwrap_or(Format::Polynomial), leg))?;
    from_result(&edge, id, move |result| {
        let parts = Parts::of(result, leg.as_deref())?;
        write_trajectory(id, &parts, format, rate_hz)
    })
    .await
}

fn write_trajectory(
    id: JobId,
    parts: &Parts<'_>,
    format: Format,
    rate_hz: f64,
) -> Result<Response, Problem> {
    let samples = || {
        let timeline = parts.timeline().ok_or_else(|| Problem::not_found("there are no legs"))?;
        timeline.sample(rate_hz).map_err(|error| {
            Problem::parameters(vec![ProblemFault::parameter("rate_hz", error.to_string())])
        })
    };
    json(&match format {
        Format::Polynomial => TrajectoryDocument::Polynomial(parts.views(|part| Polynomials {
            joint_names: part.joint_names.clone(),
            joint_units: part.joint_units.clone(),
            trajectory: part.trajectory.clone(),
        })),
        Format::Samples => TrajectoryDocument::Samples(samples()?),
        Format::JointTrajectory => {
            TrajectoryDocument::JointTrajectory(samples()?.to_joint_trajectory())
        }
        Format::Csv => return Ok(csv(&format!("takt-{id}.csv"), samples()?.to_csv())),
    })
}

fn csv(file_name: &str, text: String) -> Response {
    let mut response =
        ([(header::CONTENT_TYPE, "text/csv; charset=utf-8; header=present")], text).into_response();
    if let Ok(value) = HeaderValue::from_str(&format!("attachment; filename=\"{file_name}\"")) {
        response.headers_mut().insert(header::CONTENT_DISPOSITION, value);
    }
    response
}

/// How a convergence curve is written.
#[derive(Clone, Copy, ToSchema)]
#[schema(rename_all = "snake_case")]
enum ConvergenceFormat {
    Json,
    Csv,
    Svg,
}

/// Points of a convergence curve.
#[derive(Serialize, ToSchema)]
pub(super) struct Convergence {
    /// How the best candidate improved.
    convergence: Vec<crate::optimize::ConvergencePoint>,
}

/// How a search, or how compared methods converged.
#[derive(Serialize, ToSchema)]
#[serde(untagged)]
#[expect(dead_code, reason = "describes what is written apart")]
enum ConvergenceDocument {
    /// Of one search or of each leg's.
    Search(Views<Convergence>),
    /// Of a comparison or benchmark.
    Comparison(comparisons::ComparedConvergence),
}

/// Get how the search converged
#[utoipa::path(
    get, path = "/v1/jobs/{id}/convergence", tag = "results",
    params(
        ("id" = String, Path, format = "uuid", description = "The job's id"),
        ("format" = inline(Option<ConvergenceFormat>), Query,
            description = "`json` (default), `csv` or `svg`"),
        ("leg" = Option<String>, Query, description = "One leg of a program or problem of a comparison; default all, but a picture shows one problem. Of a family the worst case is shown"),
    ),
    responses(
        (status = 200, description = "The curve, per leg of a program", content(
            (ConvergenceDocument = "application/json"), (String = "text/csv"), (String = "image/svg+xml"),
        )),
        Problems,
    ),
)]
pub(super) async fn convergence(
    State(edge): State<Edge>,
    JobPath(id): JobPath,
    mut query: Parameters,
) -> Result<Response, Problem> {
    let formats = [
        ("json", ConvergenceFormat::Json),
        ("csv", ConvergenceFormat::Csv),
        ("svg", ConvergenceFormat::Svg),
    ];
    let format = query.choice("format", &formats).unwrap_or(ConvergenceFormat::Json);
    let leg = query.text("leg");
    let (format, leg) = query.finish((format, leg))?;
    from_result(&edge, id, move |result| {
        if let PlanResult::Comparison(comparison) = result {
            return compared_convergence(id, comparison, format, leg.as_deref());
        }
        if let PlanResult::Path(path) = result {
            return path_convergence(id, path, format, leg.as_deref());
        }
        let parts = Parts::of(result, leg.as_deref())?;
        match format {
            ConvergenceFormat::Json => {
                parts.json(|part| Convergence { convergence: part.convergence.clone() })
            }
            ConvergenceFormat::Csv => {
                let legs = parts.sections.iter().map(|section| {
                    (section.name.unwrap_or_default(), &section.result.convergence[..])
                });
                let text = convergence_csv(legs);
                Ok(csv(&format!("takt-{id}-convergence.csv"), text))
            }
            ConvergenceFormat::Svg => {
                let curves: Vec<_> = parts.sections.iter().map(Curve::of).collect();
                Ok(svg(picture::convergence(&curves)))
            }
        }
    })
    .await
}

fn path_convergence(
    id: JobId,
    path: &PathResult,
    format: ConvergenceFormat,
    leg: Option<&str>,
) -> Result<Response, Problem> {
    refuse_leg(leg)?;
    match format {
        ConvergenceFormat::Json => json(&Convergence { convergence: path.convergence.clone() }),
        ConvergenceFormat::Csv => {
            let text = convergence_csv([("", &path.convergence[..])]);
            Ok(csv(&format!("takt-{id}-convergence.csv"), text))
        }
        ConvergenceFormat::Svg => Ok(svg(picture::convergence(&[Curve::of_path(path)]))),
    }
}

/// A path has no legs.
fn refuse_leg(leg: Option<&str>) -> Result<(), Problem> {
    let unknown =
        |leg| Problem::not_found(format!("there is no leg `{leg}`; the job is no program"));
    leg.map_or(Ok(()), |leg| Err(unknown(leg)))
}

fn compared_convergence(
    id: JobId,
    comparison: &ComparisonResult,
    format: ConvergenceFormat,
    leg: Option<&str>,
) -> Result<Response, Problem> {
    match format {
        ConvergenceFormat::Json => comparisons::convergence(comparison, leg),
        ConvergenceFormat::Csv => {
            let text = comparisons::convergence_csv(comparison, leg)?;
            Ok(csv(&format!("takt-{id}-convergence.csv"), text))
        }
        ConvergenceFormat::Svg => comparisons::convergence_svg(comparison, leg).map(svg),
    }
}

fn convergence_csv<'a>(
    legs: impl IntoIterator<Item = (&'a str, &'a [ConvergencePoint])>,
) -> String {
    let mut text = String::from("leg,iteration,evaluations,elapsed_s,best,mean\r\n");
    let number = |value: Option<f64>| value.map(|value| value.to_string()).unwrap_or_default();
    for (leg, convergence) in legs {
        // RFC 4180: a quote within quotes is doubled.
        let leg = leg.replace('"', "\"\"");
        for point in convergence {
            let (best, mean) = (number(point.best), number(point.mean));
            text.push_str(&format!(
                "\"{leg}\",{},{},{},{best},{mean}\r\n",
                point.iteration, point.evaluations, point.elapsed_s
            ));
        }
    }
    text
}

/// Draw the motion
///
/// All joints over time with their limits as lines; of a path its first two coordinates, among obstacles.
#[utoipa::path(
    get, path = "/v1/jobs/{id}/plot.svg", tag = "results",
    params(
        ("id" = String, Path, format = "uuid", description = "The job's id"),
        ("quantity" = Option<String>, Query,
            description = "Of `position`, `velocity`, `acceleration` and `jerk`, with commas between; default all"),
        ("leg" = Option<String>, Query, description = "One leg of a program; default all. Of a family the worst case is shown"),
    ),
    responses((status = 200, description = "The picture", body = String, content_type = "image/svg+xml"), Problems),
)]
pub(super) async fn plot(
    State(edge): State<Edge>,
    JobPath(id): JobPath,
    mut query: Parameters,
) -> Result<Response, Problem> {
    let quantities = quantities(&mut query);
    let leg = query.text("leg");
    let leg = query.finish(leg)?;
    from_result(&edge, id, move |result| {
        if let PlanResult::Path(path) = result {
            refuse_leg(leg.as_deref())?;
            return Ok(svg(picture::path(path)));
        }
        let parts = Parts::of(result, leg.as_deref())?;
        Ok(svg(picture::plot(&parts.sections, &quantities)))
    })
    .await
}

/// How a binding timeline is written.
#[derive(Clone, Copy, ToSchema)]
#[schema(rename_all = "snake_case")]
enum TimelineFormat {
    Json,
    Svg,
}

/// Get which limit holds the motion back, and when
///
/// For each joint and each known limit the intervals in which velocity,
/// acceleration or jerk is within 0.1 % of it, exactly.
#[utoipa::path(
    get, path = "/v1/jobs/{id}/timeline", tag = "results",
    params(
        ("id" = String, Path, format = "uuid", description = "The job's id"),
        ("format" = inline(Option<TimelineFormat>), Query, description = "`json` (default) or `svg`"),
        ("leg" = Option<String>, Query, description = "One leg of a program; default all. Of a family the worst case is shown"),
    ),
    responses(
        (status = 200, description = "The timeline, per leg of a program", content(
            (Views<BindingTimeline> = "application/json"), (String = "image/svg+xml"),
        )),
        Problems,
    ),
)]
pub(super) async fn timeline(
    State(edge): State<Edge>,
    JobPath(id): JobPath,
    mut query: Parameters,
) -> Result<Response, Problem> {
    let formats = [("json", TimelineFormat::Json), ("svg", TimelineFormat::Svg)];
    let format = query.choice("format", &formats).unwrap_or(TimelineFormat::Json);
    let leg = query.text("leg");
    let (format, leg) = query.finish((format, leg))?;
    from_result(&edge, id, move |result| {
        let parts = Parts::of(result, leg.as_deref())?;
        match format {
            TimelineFormat::Json => {
                parts.json(|part| BindingTimeline::new(&part.trajectory, &part.certificate.joints))
            }
            TimelineFormat::Svg => Ok(svg(picture::timeline(&parts.sections))),
        }
    })
    .await
}

/// Draw the front
///
/// Of a job with `pareto`: every motion of it, the fastest one stretched, and
/// the plan.
#[utoipa::path(
    get, path = "/v1/jobs/{id}/pareto.svg", tag = "results",
    params(
        ("id" = String, Path, format = "uuid", description = "The job's id"),
        ("leg" = Option<String>, Query, description = "One leg of a program; default all. Of a family the worst case is shown"),
    ),
    responses((status = 200, description = "The picture", body = String, content_type = "image/svg+xml"), Problems),
)]
pub(super) async fn pareto(
    State(edge): State<Edge>,
    JobPath(id): JobPath,
    query: Parameters,
) -> Result<Response, Problem> {
    let leg = leg(query)?;
    from_result(&edge, id, move |result| {
        let parts = Parts::of(result, leg.as_deref())?;
        if parts.sections.iter().all(|section| section.result.pareto.is_none()) {
            return Err(Problem::not_found(format!(
                "job {id} has no front: ask for one with `pareto`"
            )));
        }
        Ok(svg(picture::pareto(&parts.sections)))
    })
    .await
}

fn quantities(query: &mut Parameters) -> Vec<Quantity> {
    let Some(text) = query.text("quantity") else { return Quantity::ALL.to_vec() };
    let mut quantities = Vec::new();
    for name in text.split(',') {
        match name.trim().parse() {
            Ok(quantity) if quantities.contains(&quantity) => {}
            Ok(quantity) => quantities.push(quantity),
            Err(error) => query.fault("quantity", format!("{error}")),
        }
    }
    quantities
}

fn svg(text: String) -> Response {
    ([(header::CONTENT_TYPE, "image/svg+xml")], text).into_response()
}
