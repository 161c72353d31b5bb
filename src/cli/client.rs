//! The client of a server: REST, and gRPC for watching.

use clap::Args;
use reqwest::{Method, RequestBuilder, Response, StatusCode};
use serde::de::DeserializeOwned;
use serde_json::Value;
use tonic::Streaming;

use crate::grpc::proto;
use crate::grpc::proto::planning_service_client::PlanningServiceClient;
use crate::http::ProblemBody;

use super::failure::{Exit, Failure, with_causes};

/// Which server to talk to.
#[derive(Clone, Debug, Args)]
pub(super) struct Server {
    /// Address of the server
    #[arg(long = "server", value_name = "URL", env = "TAKT_SERVER", default_value = DEFAULT_SERVER)]
    pub(super) url: String,
}

/// Where `takt serve` listens unless told otherwise.
pub(super) const DEFAULT_SERVER: &str = "http://127.0.0.1:8080";

/// A connection to a server.
#[derive(Clone, Debug)]
pub(super) struct Client {
    http: reqwest::Client,
    base: String,
}

impl Client {
    /// A client of the server at `url`; connects when first used.
    pub(super) fn new(url: &str) -> Result<Self, Failure> {
        let base = url.trim_end_matches('/').to_owned();
        if !base.starts_with("http://") {
            let message = format!("`{url}` is not a server's address, such as {DEFAULT_SERVER}");
            return Err(Failure::input(message));
        }
        // Planning servers stand in the same network: no proxy, as with gRPC.
        let http = reqwest::Client::builder().no_proxy().build();
        let http = http.map_err(|error| Failure::system("cannot start a client", &error))?;
        Ok(Self { http, base })
    }

    fn request(&self, method: Method, path: &str) -> RequestBuilder {
        self.http.request(method, format!("{}{path}", self.base))
    }

    async fn send(&self, request: RequestBuilder) -> Result<Response, Failure> {
        let response = request.send().await.map_err(|error| self.unreachable(&error))?;
        if response.status().is_success() {
            return Ok(response);
        }
        let status = response.status();
        let body = response.bytes().await.unwrap_or_default();
        Err(refused(status, &body))
    }

    /// `GET`s text.
    pub(super) async fn text(&self, path: &str) -> Result<String, Failure> {
        let response = self.send(self.request(Method::GET, path)).await?;
        response.text().await.map_err(|error| self.unreachable(&error))
    }

    /// `GET`s JSON.
    pub(super) async fn get<T: DeserializeOwned>(
        &self,
        path: &str,
        query: &[(String, String)],
    ) -> Result<T, Failure> {
        let response = self.send(self.request(Method::GET, path).query(query)).await?;
        self.read(response).await
    }

    /// `POST`s JSON, or nothing.
    pub(super) async fn post<T: DeserializeOwned>(
        &self,
        path: &str,
        body: Option<&Value>,
    ) -> Result<T, Failure> {
        let request = self.request(Method::POST, path);
        let request = match body {
            Some(body) => request.json(body),
            None => request,
        };
        let response = self.send(request).await?;
        self.read(response).await
    }

    async fn read<T: DeserializeOwned>(&self, response: Response) -> Result<T, Failure> {
        let text = response.text().await.map_err(|error| self.unreachable(&error))?;
        serde_json::from_str(&text).map_err(|error| {
            let message = format!("the answer of {} makes no sense: {error}", self.base);
            Failure::new(Exit::Unreachable, message)
        })
    }

    /// A job's events that follow number `after_seq`, as they happen.
    pub(super) async fn watch(
        &self,
        id: &str,
        after_seq: u64,
    ) -> Result<Streaming<proto::JobEvent>, Failure> {
        let connected = PlanningServiceClient::connect(self.base.clone()).await;
        let mut client = connected.map_err(|error| self.unreachable(&error))?;
        let request = proto::WatchJobRequest { id: id.to_owned(), after_seq };
        let answer = client.watch_job(request).await;
        Ok(answer.map_err(|status| self.refused_call(&status))?.into_inner())
    }

    /// A failed gRPC call.
    pub(super) fn refused_call(&self, status: &tonic::Status) -> Failure {
        use tonic::Code;
        let exit = match status.code() {
            Code::NotFound | Code::InvalidArgument | Code::FailedPrecondition => Exit::Input,
            _ => Exit::Unreachable,
        };
        Failure::new(exit, status.message())
    }

    fn unreachable(&self, error: &dyn std::error::Error) -> Failure {
        let message = format!("cannot reach {}: {}", self.base, with_causes(error));
        let note = "start a server with `takt serve`, or name another with --server or TAKT_SERVER";
        Failure::new(Exit::Unreachable, message).with_notes([note.to_owned()])
    }
}

/// What an error answer says.
fn refused(status: StatusCode, body: &[u8]) -> Failure {
    let Ok(problem) = serde_json::from_slice::<ProblemBody>(body) else {
        let message = format!("the server answered {status}; is it a Takt server?");
        return Failure::new(Exit::Unreachable, message);
    };
    let exit = match status.as_u16() {
        // The job ended, and not with a result.
        409 if problem.code == "no_result" => Exit::Planning,
        429 | 500.. => Exit::Unreachable,
        _ => Exit::Input,
    };
    if problem.errors.is_empty() {
        return Failure::new(exit, problem.detail);
    }
    let lines = problem.errors.into_iter().map(|fault| {
        let place = fault.pointer.or(fault.parameter).filter(|place| !place.is_empty());
        place.map(|place| format!("{place}: ")).unwrap_or_default() + &fault.detail
    });
    let title = problem.title;
    let title =
        title.chars().next().map(|c| c.to_lowercase().chain(title.chars().skip(1)).collect());
    Failure::new(exit, title.unwrap_or_else(|| problem.code.clone())).with_notes(lines)
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::*;

    fn failure(status: u16, code: &str, errors: Value) -> Failure {
        let body = json!({"type": "/problems/x", "title": "The request is not valid", "status": status,
            "detail": "what happened", "code": code, "errors": errors, "request_id": "1"});
        refused(StatusCode::from_u16(status).unwrap(), body.to_string().as_bytes())
    }

    #[test]
    fn shows_a_problem_with_all_its_faults() {
        let errors = json!([{"pointer": "/seed", "detail": "too small"},
            {"parameter": "rate_hz", "detail": "too high"}, {"pointer": "", "detail": "no object"}]);
        let failure = failure(422, "invalid", errors);
        assert_eq!(
            failure.text(),
            "error: the request is not valid\n  /seed: too small\n  rate_hz: too high\n  no object\n"
        );
        assert_eq!(failure.exit(), Exit::Input);
    }

    #[test]
    fn the_status_decides_the_exit() {
        assert_eq!(failure(404, "not_found", json!([])).exit(), Exit::Input);
        assert_eq!(failure(409, "not_ended", json!([])).exit(), Exit::Input);
        assert_eq!(failure(409, "no_result", json!([])).exit(), Exit::Planning);
        assert_eq!(failure(429, "queue_full", json!([])).exit(), Exit::Unreachable);
        assert_eq!(failure(503, "draining", json!([])).text(), "error: what happened\n");
        assert_eq!(refused(StatusCode::BAD_GATEWAY, b"<html>").exit(), Exit::Unreachable);
    }

    #[test]
    fn only_plain_http_addresses_are_taken() {
        assert!(Client::new("https://takt.example").is_err());
        assert!(Client::new("localhost:8080").is_err());
        assert_eq!(Client::new("http://localhost:8080/").unwrap().base, "http://localhost:8080");
    }
}
