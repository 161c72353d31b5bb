//! What handlers read from a request: JSON bodies, query parameters and ids,
//! each refused with a problem that names the fault.

use std::collections::BTreeMap;
use std::fmt::Display;
use std::pin::pin;
use std::str::FromStr;
use std::time::Duration;

use axum::extract::{FromRequest, FromRequestParts, Path, Query, Request};
use bytes::Bytes;
use futures::{Stream, StreamExt};
use http::request::Parts;
use http::{HeaderMap, header};
use serde_json::Value;

use super::Edge;
use super::problem::{Problem, ProblemFault};
use crate::fault::Faults;
use crate::job::JobId;
use crate::service::blocking;

/// A body declared as JSON and of an allowed size, not yet parsed.
pub(super) struct JsonBody(Vec<u8>);

impl JsonBody {
    /// Parses the body and hands it to `parse`, on a thread that may take its
    /// time: megabytes of numbers would keep other requests waiting.
    pub(super) async fn parse<T: Send + 'static>(
        self,
        parse: fn(Value) -> Result<T, Faults>,
    ) -> Result<T, Problem> {
        blocking(move || {
            let value = serde_json::from_slice(&self.0)
                .map_err(|error| Problem::unreadable(format!("the body is not JSON: {error}")))?;
            Ok(parse(value)?)
        })
        .await
    }
}

impl FromRequest<Edge> for JsonBody {
    type Rejection = Problem;

    async fn from_request(request: Request, edge: &Edge) -> Result<Self, Problem> {
        check_content_type(request.headers())?;
        let body = request.into_body().into_data_stream();
        receive(body, edge.settings.max_body_bytes, PATIENCE).await.map(Self)
    }
}

/// How long a client may pause within a body.
const PATIENCE: Duration = Duration::from_secs(30);

/// Reads a body of at most `limit` bytes that never pauses for longer than
/// `patience`.
async fn receive<E: Display>(
    body: impl Stream<Item = Result<Bytes, E>>,
    limit: usize,
    patience: Duration,
) -> Result<Vec<u8>, Problem> {
    let mut body = pin!(body);
    let mut bytes = Vec::new();
    let mut length = 0;
    // Beyond the limit some more is read and thrown away: a client that is
    // still sending would not hear the answer.
    loop {
        let chunk = tokio::time::timeout(patience, body.next()).await.map_err(|_| {
            Problem::unreadable(format!("nothing of the body came for {} s", patience.as_secs()))
        })?;
        let Some(chunk) = chunk else { break };
        let chunk = chunk.map_err(|error| {
            Problem::unreadable(format!("the body could not be received: {error}"))
        })?;
        length += chunk.len();
        if length <= limit {
            bytes.extend_from_slice(&chunk);
        } else if length > 8 * limit {
            break;
        }
    }
    if length > limit { Err(Problem::too_large(limit)) } else { Ok(bytes) }
}

fn check_content_type(headers: &HeaderMap) -> Result<(), Problem> {
    let Some(value) = headers.get(header::CONTENT_TYPE) else {
        let message = "the Content-Type header is missing; send application/json";
        return Err(Problem::unsupported_media_type(message));
    };
    let text = value.to_str().unwrap_or_default();
    let essence = text.split(';').next().unwrap_or_default().trim();
    if essence.eq_ignore_ascii_case("application/json") {
        return Ok(());
    }
    let message = format!("the Content-Type is `{text}`; send application/json");
    Err(Problem::unsupported_media_type(message))
}

/// The job named in the address.
pub(super) struct JobPath(pub(super) JobId);

impl<S: Send + Sync> FromRequestParts<S> for JobPath {
    type Rejection = Problem;

    async fn from_request_parts(parts: &mut Parts, state: &S) -> Result<Self, Problem> {
        let NamePath(text) = NamePath::from_request_parts(parts, state).await?;
        let not_an_id = |_| Problem::not_found(format!("`{text}` is not the id of a job"));
        text.parse().map(Self).map_err(not_an_id)
    }
}

/// The robot, scenario or problem named in the address.
pub(super) struct NamePath(pub(super) String);

impl<S: Send + Sync> FromRequestParts<S> for NamePath {
    type Rejection = Problem;

    async fn from_request_parts(parts: &mut Parts, state: &S) -> Result<Self, Problem> {
        match Path::<String>::from_request_parts(parts, state).await {
            Ok(Path(name)) => Ok(Self(name)),
            Err(error) => Err(Problem::not_found(error.body_text())),
        }
    }
}

/// The query parameters, taken one by one; what is left at the end is unknown.
#[derive(Debug)]
pub(super) struct Parameters {
    given: Vec<(String, String)>,
    faults: Vec<ProblemFault>,
    known: Vec<String>,
}

impl<S: Send + Sync> FromRequestParts<S> for Parameters {
    type Rejection = Problem;

    async fn from_request_parts(parts: &mut Parts, _state: &S) -> Result<Self, Problem> {
        let given = Query::try_from_uri(&parts.uri)
            .map_err(|error| Problem::unreadable(format!("the query: {error}")))?;
        Ok(Self { given: given.0, faults: Vec::new(), known: Vec::new() })
    }
}

impl Parameters {
    /// The value of `name`; giving it twice is a fault.
    pub(super) fn text(&mut self, name: &'static str) -> Option<String> {
        self.known.push(name.to_owned());
        let mut values = self.given.extract_if(.., |(given, _)| given == name).map(|pair| pair.1);
        let first = values.next();
        if values.count() > 0 {
            self.fault(name, "is given more than once");
        }
        first
    }

    /// The value of `name`, read as a `T`.
    pub(super) fn value<T: FromStr<Err: Display>>(&mut self, name: &'static str) -> Option<T> {
        let text = self.text(name)?;
        match text.parse() {
            Ok(value) => Some(value),
            Err(error) => {
                self.fault(name, format!("`{text}`: {error}"));
                None
            }
        }
    }

    /// The value of `name` read as one of `choices`, or their first.
    pub(super) fn choice<T: Copy>(
        &mut self,
        name: &'static str,
        choices: &[(&str, T)],
    ) -> Option<T> {
        let Some(text) = self.text(name) else { return choices.first().map(|(_, choice)| *choice) };
        let found = choices.iter().find(|(choice, _)| *choice == text).map(|(_, choice)| *choice);
        if found.is_none() {
            let known: Vec<_> = choices.iter().map(|(choice, _)| *choice).collect();
            self.fault(name, format!("`{text}` is unknown; known: {}", known.join(", ")));
        }
        found
    }

    /// All values whose names start with `prefix`, by the rest of their names.
    pub(super) fn prefixed(&mut self, prefix: &'static str) -> BTreeMap<String, String> {
        self.known.push(format!("{prefix}KEY"));
        let matching = self.given.extract_if(.., |(given, _)| given.starts_with(prefix));
        matching.map(|(name, value)| (name[prefix.len()..].to_owned(), value)).collect()
    }

    /// All that is given, where the names are data.
    pub(super) fn all(mut self) -> Vec<(String, String)> {
        std::mem::take(&mut self.given)
    }

    /// Notes what is wrong with `name`.
    pub(super) fn fault(&mut self, name: &str, detail: impl Into<String>) {
        self.faults.push(ProblemFault::parameter(name, detail));
    }

    /// `value`, unless something was wrong or is left over.
    pub(super) fn finish<T>(mut self, value: T) -> Result<T, Problem> {
        let known = match &self.known[..] {
            [] => "there are none here".to_owned(),
            known => format!("known: {}", known.join(", ")),
        };
        for (name, _) in std::mem::take(&mut self.given) {
            self.fault(&name, format!("unknown query parameter; {known}"));
        }
        if self.faults.is_empty() { Ok(value) } else { Err(Problem::parameters(self.faults)) }
    }
}

/// Stands for a query without parameters.
pub(super) struct NoParameters;

impl<S: Send + Sync> FromRequestParts<S> for NoParameters {
    type Rejection = Problem;

    async fn from_request_parts(parts: &mut Parts, state: &S) -> Result<Self, Problem> {
        Parameters::from_request_parts(parts, state).await?.finish(Self)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parameters(given: &[(&str, &str)]) -> Parameters {
        let given = given.iter().map(|(name, value)| ((*name).into(), (*value).into())).collect();
        Parameters { given, faults: Vec::new(), known: Vec::new() }
    }

    #[test]
    fn names_every_parameter_that_is_wrong() {
        let mut query = parameters(&[("rate", "x"), ("kind", "c"), ("kind", "d"), ("more", "1")]);
        assert_eq!(query.value::<f64>("rate"), None);
        assert_eq!(query.choice("kind", &[("a", 1), ("b", 2)]), None);
        let problem = format!("{:?}", query.finish(()).unwrap_err());
        for expected in ["rate", "`c` is unknown; known: a, b", "more than once", "\"more\""] {
            assert!(problem.contains(expected), "{expected}: {problem}");
        }
    }

    #[tokio::test]
    async fn a_body_has_a_limit_in_size_and_patience() {
        use futures::stream;
        const LONG: Duration = Duration::from_secs(60);
        let chunk = || Ok::<_, std::io::Error>(Bytes::from_static(b"four"));
        let body = receive(stream::iter([chunk(), chunk()]), 8, LONG).await;
        assert_eq!(body.unwrap(), b"fourfour");
        // A bomb without an end is not read to its end.
        let endless = receive(stream::repeat_with(chunk), 8, LONG).await;
        assert!(format!("{:?}", endless.unwrap_err()).contains("more than 8 bytes"));
        let stalled = stream::iter([chunk()]).chain(stream::pending());
        let stalled = receive(stalled, 8, Duration::from_millis(1)).await;
        assert!(format!("{:?}", stalled.unwrap_err()).contains("nothing of the body"));
    }

    #[test]
    fn the_first_choice_is_the_default() {
        let mut query = parameters(&[("label.cell", "3")]);
        assert_eq!(query.choice("kind", &[("a", 1), ("b", 2)]), Some(1));
        assert_eq!(query.prefixed("label.")["cell"], "3");
        assert!(query.finish(()).is_ok());
    }
}
