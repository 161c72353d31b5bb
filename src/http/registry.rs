//! What is on offer, and certificates for anyone's trajectory.

use axum::Json;
use axum::extract::State;
use axum::response::{IntoResponse, Response};
use serde::Serialize;
use utoipa::ToSchema;

use super::Edge;
use super::examples;
use super::input::{JsonBody, NamePath, NoParameters, Parameters};
use super::problem::{Problem, ProblemFault, Problems};
use crate::fault::Fault;
use crate::optimize::OptimizerInfo;
use crate::plan::path::SmoothingInfo;
use crate::plan::scenarios::Scenario;
use crate::plan::verify::VerifyRequest;
use crate::planner::PlannerInfo;
use crate::trajectory::Certificate;
use crate::trajectory::interpolation::InterpolationInfo;

/// All optimizers.
#[derive(Serialize, ToSchema)]
pub(super) struct OptimizerList {
    /// With their parameters, defaults and sources.
    optimizers: Vec<OptimizerInfo>,
}

/// All planners.
#[derive(Serialize, ToSchema)]
pub(super) struct PlannerList {
    /// With their parameters, defaults and sources; `auto` stands for one of them.
    planners: Vec<PlannerInfo>,
    /// What makes a path smoother.
    smoothings: Vec<SmoothingInfo>,
}

/// All interpolations.
#[derive(Serialize, ToSchema)]
pub(super) struct InterpolationList {
    /// With what they guarantee and need.
    interpolations: Vec<InterpolationInfo>,
}

/// All scenarios.
#[derive(Serialize, ToSchema)]
pub(super) struct ScenarioList {
    /// Each with a request that is ready to be sent.
    scenarios: &'static [Scenario],
}

/// List the optimizers
#[utoipa::path(
    get, path = "/v1/optimizers", tag = "methods",
    responses((status = 200, description = "All optimizers", body = OptimizerList), Problems),
)]
pub(super) async fn optimizers(State(edge): State<Edge>, _: NoParameters) -> Json<OptimizerList> {
    Json(OptimizerList { optimizers: edge.service.optimizers() })
}

/// List the planners
#[utoipa::path(
    get, path = "/v1/planners", tag = "methods",
    responses((status = 200, description = "All planners", body = PlannerList), Problems),
)]
pub(super) async fn planners(State(edge): State<Edge>, _: NoParameters) -> Json<PlannerList> {
    let (planners, smoothings) = (edge.service.planners(), edge.service.smoothings());
    Json(PlannerList { planners, smoothings })
}

/// List the interpolations
#[utoipa::path(
    get, path = "/v1/interpolations", tag = "methods",
    responses((status = 200, description = "All interpolations", body = InterpolationList), Problems),
)]
pub(super) async fn interpolations(
    State(edge): State<Edge>,
    _: NoParameters,
) -> Json<InterpolationList> {
    Json(InterpolationList { interpolations: edge.service.interpolations() })
}

/// List the scenarios
#[utoipa::path(
    get, path = "/v1/scenarios", tag = "methods",
    responses((status = 200, description = "All scenarios", body = ScenarioList), Problems),
)]
pub(super) async fn scenarios(State(edge): State<Edge>, _: NoParameters) -> Response {
    Json(ScenarioList { scenarios: edge.service.scenarios() }).into_response()
}

/// Get a scenario
#[utoipa::path(
    get, path = "/v1/scenarios/{name}", tag = "methods",
    params(("name" = String, Path, example = "mcb-ab", description = "The scenario's name")),
    responses((status = 200, description = "The scenario", body = Scenario), Problems),
)]
pub(super) async fn scenario(
    State(edge): State<Edge>,
    NamePath(name): NamePath,
    _: NoParameters,
) -> Result<Response, Problem> {
    Ok(Json(find(&edge, &name)?).into_response())
}

/// Get a scenario's request, ready to be sent to /v1/jobs
///
/// The scenario's parameters are query parameters; those left out have their
/// defaults.
#[utoipa::path(
    get, path = "/v1/scenarios/{name}/request", tag = "methods",
    params(
        ("name" = String, Path, example = "mcb-assembly", description = "The scenario's name"),
        (
            "settings" = Option<std::collections::BTreeMap<String, String>>, Query, style = Form, explode,
            description = "The scenario's parameters, as ?part=yoke&posture=1",
        ),
    ),
    responses((status = 200, description = "The request", body = crate::plan::PlanRequest), Problems),
)]
pub(super) async fn scenario_request(
    State(edge): State<Edge>,
    NamePath(name): NamePath,
    parameters: Parameters,
) -> Result<Response, Problem> {
    let request = find(&edge, &name)?.select(&parameters.all()).map_err(|faults| {
        let fault = |Fault { pointer, detail }: Fault| {
            ProblemFault::parameter(pointer.trim_start_matches('/'), detail)
        };
        Problem::parameters(faults.0.into_iter().map(fault).collect())
    })?;
    Ok(Json(request).into_response())
}

fn find(edge: &Edge, name: &str) -> Result<&'static Scenario, Problem> {
    let scenarios = edge.service.scenarios();
    scenarios.iter().find(|scenario| scenario.name == name).ok_or_else(|| {
        let known: Vec<_> = scenarios.iter().map(|scenario| scenario.name.as_str()).collect();
        Problem::not_found(format!(
            "there is no scenario `{name}`; there are: {}",
            known.join(", ")
        ))
    })
}

/// Certify anyone's trajectory
///
/// Exact extrema of position, velocity, acceleration and jerk against the
/// robot's limits, over continuous time. Samples are certified as the curve
/// that their consumer drives, which `interpolation` names; exports of
/// `GET /v1/jobs/{id}/trajectory` are taken as they come, `interpolation` added.
#[utoipa::path(
    post, path = "/v1/verify", tag = "results", request_body(content = VerifyRequest, example = examples::trajectory_to_verify),
    responses((status = 200, description = "The certificate", body = Certificate), Problems),
)]
pub(super) async fn verify(
    State(edge): State<Edge>,
    _: NoParameters,
    body: JsonBody,
) -> Result<Json<Certificate>, Problem> {
    let request = body.parse(VerifyRequest::parse).await?;
    Ok(Json(edge.service.verify(request).await?))
}
