//! The robot service.

use tonic::{Request, Response, Status};

use super::convert::{MessageForm, read};
use super::proto;
use crate::fault::Faults;
use crate::robot::RobotDescription;
use crate::service::{Service, ServiceError};

/// Serves [`Service`] as `takt.v1.RobotService`.
pub(super) struct Robots(pub(super) Service);

#[tonic::async_trait]
impl proto::robot_service_server::RobotService for Robots {
    async fn put_robot(
        &self,
        request: Request<proto::PutRobotRequest>,
    ) -> Result<Response<proto::PutRobotResponse>, Status> {
        let robot = named(request.into_inner().robot)?;
        let robot: RobotDescription = read(robot).map_err(ServiceError::from)?;
        let name = robot.name.clone();
        let json = serde_json::to_value(robot).map_err(ServiceError::internal)?;
        let put = self.0.put_robot(&name, json).await?;
        Ok(Response::new(put.into_message()))
    }

    async fn get_robot(
        &self,
        request: Request<proto::GetRobotRequest>,
    ) -> Result<Response<proto::Robot>, Status> {
        let robot = self.0.robot(&request.into_inner().name).await?;
        Ok(Response::new(robot.description().clone().into_message()))
    }

    async fn list_robots(
        &self,
        _: Request<proto::ListRobotsRequest>,
    ) -> Result<Response<proto::ListRobotsResponse>, Status> {
        let robots = self.0.list_robots().await?.into_message();
        Ok(Response::new(proto::ListRobotsResponse { robots }))
    }

    async fn delete_robot(
        &self,
        request: Request<proto::DeleteRobotRequest>,
    ) -> Result<Response<()>, Status> {
        self.0.delete_robot(&request.into_inner().name).await?;
        Ok(Response::new(()))
    }
}

/// The robot to register, which has to have a name.
fn named(robot: Option<proto::Robot>) -> Result<proto::Robot, ServiceError> {
    let mut faults = Faults::default();
    let robot = robot.unwrap_or_default();
    if robot.name.is_empty() {
        faults.add("/name", "a robot is registered under its name: it must be given");
    }
    Ok(faults.into_result(robot)?)
}
