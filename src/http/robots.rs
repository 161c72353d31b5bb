//! Robots: list, look up, register, delete, forward and inverse kinematics.

use axum::Json;
use axum::extract::State;
use axum::response::{IntoResponse, Response};
use http::StatusCode;
use serde::Serialize;
use utoipa::ToSchema;

use super::Edge;
use super::examples;
use super::input::{JsonBody, NamePath, NoParameters};
use super::problem::{Problem, Problems};
use crate::robot::RobotDescription;
use crate::service::{
    ForwardKinematics, ForwardKinematicsRequest, InverseKinematicsAnswer, InverseKinematicsRequest,
    RobotSummary,
};

/// All robots.
#[derive(Serialize, ToSchema)]
pub(super) struct RobotList {
    /// The catalogue's, then those registered, each by name.
    robots: Vec<RobotSummary>,
}

/// List all robots
#[utoipa::path(
    get, path = "/v1/robots", tag = "robots",
    responses((status = 200, description = "All robots", body = RobotList), Problems),
)]
pub(super) async fn list(
    State(edge): State<Edge>,
    _: NoParameters,
) -> Result<Json<RobotList>, Problem> {
    Ok(Json(RobotList { robots: edge.service.list_robots().await? }))
}

/// Get a robot
#[utoipa::path(
    get, path = "/v1/robots/{name}", tag = "robots",
    params(("name" = String, Path, description = "The robot's name")),
    responses((status = 200, description = "The robot", body = RobotDescription), Problems),
)]
pub(super) async fn get(
    State(edge): State<Edge>,
    NamePath(name): NamePath,
    _: NoParameters,
) -> Result<Response, Problem> {
    let robot = edge.service.robot(&name).await?;
    Ok(Json(robot.description()).into_response())
}

/// Register a robot, or replace a registered one
///
/// Jobs already accepted keep the robot they came with.
#[utoipa::path(
    put, path = "/v1/robots/{name}", tag = "robots",
    request_body(content = RobotDescription, example = examples::robot),
    params(("name" = String, Path, example = "gantry", description = "The robot's name; the body's may be left out")),
    responses(
        (status = 201, description = "Registered", body = RobotDescription),
        (status = 200, description = "Replaced", body = RobotDescription),
        Problems,
    ),
)]
pub(super) async fn put(
    State(edge): State<Edge>,
    NamePath(name): NamePath,
    _: NoParameters,
    body: JsonBody,
) -> Result<Response, Problem> {
    let put = edge.service.put_robot(&name, body.parse(Ok).await?).await?;
    let status = if put.created { StatusCode::CREATED } else { StatusCode::OK };
    Ok((status, Json(put.robot)).into_response())
}

/// Delete a registered robot
#[utoipa::path(
    delete, path = "/v1/robots/{name}", tag = "robots",
    params(("name" = String, Path, description = "The robot's name")),
    responses((status = 204, description = "Deleted"), Problems),
)]
pub(super) async fn delete(
    State(edge): State<Edge>,
    NamePath(name): NamePath,
    _: NoParameters,
) -> Result<StatusCode, Problem> {
    edge.service.delete_robot(&name).await?;
    Ok(StatusCode::NO_CONTENT)
}

/// Compute where a configuration takes the tool
#[utoipa::path(
    post, path = "/v1/robots/{name}/fk", tag = "robots",
    request_body(content = ForwardKinematicsRequest, example = examples::configuration),
    params(("name" = String, Path, example = "ur5e", description = "The robot's name")),
    responses((status = 200, description = "The frames", body = ForwardKinematics), Problems),
)]
pub(super) async fn forward_kinematics(
    State(edge): State<Edge>,
    NamePath(name): NamePath,
    _: NoParameters,
    body: JsonBody,
) -> Result<Json<ForwardKinematics>, Problem> {
    let request = body.parse(ForwardKinematicsRequest::parse).await?;
    Ok(Json(edge.service.forward_kinematics(&name, &request).await?))
}

/// Find the configurations that bring the tool to a pose
///
/// All branches within the limits, or the nearest to a seed. If there is none, the answer tells how near the tool can come
/// and which limit is in the way.
#[utoipa::path(
    post, path = "/v1/robots/{name}/ik", tag = "robots",
    request_body(content = InverseKinematicsRequest, example = examples::pose),
    params(("name" = String, Path, example = "ur5e", description = "The robot's name")),
    responses((status = 200, description = "The configurations, or why there is none", body = InverseKinematicsAnswer), Problems),
)]
pub(super) async fn inverse_kinematics(
    State(edge): State<Edge>,
    NamePath(name): NamePath,
    _: NoParameters,
    body: JsonBody,
) -> Result<Json<InverseKinematicsAnswer>, Problem> {
    let request = body.parse(InverseKinematicsRequest::parse).await?;
    Ok(Json(edge.service.inverse_kinematics(&name, request).await?))
}
