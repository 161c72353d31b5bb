//! From the service's failures to gRPC statuses.

use std::collections::HashMap;
use std::time::Duration;

use tonic::{Code, Status};
use tonic_types::{ErrorDetails, FieldViolation, StatusExt};

use crate::fault::{Fault, Faults};
use crate::service::{ErrorCode, ServiceError};

/// The domain of every ErrorInfo.
pub const ERROR_DOMAIN: &str = "takt";

/// When a client may try again that met a full queue.
const RETRY_DELAY: Duration = Duration::from_secs(1);

/// Statuses travel in headers, of which clients take as little as 8 KiB in all:
/// room for the text of all violations, bytes.
const VIOLATION_BYTES: usize = 3072;
/// Room for one text, bytes.
const TEXT_BYTES: usize = 512;

impl From<ServiceError> for Status {
    fn from(error: ServiceError) -> Self {
        let ServiceError { code, message, faults } = error;
        let mut details =
            ErrorDetails::with_error_info(code.as_str(), ERROR_DOMAIN, HashMap::new());
        if code == ErrorCode::QueueFull {
            details.set_retry_info(Some(RETRY_DELAY));
        }
        if !faults.is_empty() {
            details.set_bad_request(violations(&faults));
        }
        let message = match faults.as_slice() {
            // Each has its own place below; here one is enough.
            [first, rest @ ..] if !rest.is_empty() => {
                let more = rest.len();
                let first = shortened(&Faults(vec![first.clone()]).to_string()).to_owned();
                format!("{first}; {more} more faults in the details")
            }
            _ => shortened(&message).to_owned(),
        };
        Status::with_error_details(status_code(code), message, details)
    }
}

fn status_code(code: ErrorCode) -> Code {
    match code {
        ErrorCode::Unreadable | ErrorCode::Invalid => Code::InvalidArgument,
        ErrorCode::NotFound => Code::NotFound,
        ErrorCode::Conflict | ErrorCode::NotEnded | ErrorCode::NoResult => Code::FailedPrecondition,
        ErrorCode::IdempotencyMismatch => Code::AlreadyExists,
        ErrorCode::TooLarge | ErrorCode::QueueFull => Code::ResourceExhausted,
        ErrorCode::Draining | ErrorCode::Unavailable => Code::Unavailable,
        ErrorCode::Internal => Code::Internal,
    }
}

/// As many faults as there is room for; the rest is counted.
fn violations(faults: &[Fault]) -> Vec<FieldViolation> {
    let mut left = VIOLATION_BYTES;
    let mut violations = Vec::new();
    for (index, Fault { pointer, detail }) in faults.iter().enumerate() {
        let (pointer, detail) = (shortened(pointer), shortened(detail));
        let bytes = pointer.len() + detail.len();
        if bytes > left {
            let hidden = faults.len() - index;
            violations.push(FieldViolation::new("", format!("and {hidden} more faults")));
            break;
        }
        left -= bytes;
        violations.push(FieldViolation::new(pointer, detail));
    }
    violations
}

/// The beginning of `text` that there is room for.
fn shortened(text: &str) -> &str {
    let fits = |&end: &usize| end <= TEXT_BYTES;
    let ends = text.char_indices().map(|(start, char)| start + char.len_utf8());
    &text[..ends.take_while(fits).last().unwrap_or(0)]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_failure_names_its_reason() {
        for code in ErrorCode::ALL {
            let status = Status::from(ServiceError::new(code, "why"));
            assert_ne!(status.code(), Code::Ok);
            assert_eq!(status.message(), "why");
            let details = status.get_error_details();
            let info = details.error_info().unwrap();
            assert_eq!((info.reason.as_str(), info.domain.as_str()), (code.as_str(), "takt"));
            assert_eq!(details.retry_info().is_some(), code == ErrorCode::QueueFull);
            assert!(details.bad_request().is_none());
        }
    }

    #[test]
    fn every_fault_becomes_a_violation() {
        let mut faults = Faults::default();
        faults.add("/task/waypoints/1", "too short");
        let one = Status::from(ServiceError::from(faults.clone()));
        assert_eq!(one.code(), Code::InvalidArgument);
        assert_eq!(one.message(), "/task/waypoints/1: too short");
        faults.add("/seed", "odd");
        let two = Status::from(ServiceError::from(faults));
        assert_eq!(two.message(), "/task/waypoints/1: too short; 1 more faults in the details");
        let details = two.get_error_details();
        let violations = &details.bad_request().unwrap().field_violations;
        let found: Vec<_> =
            violations.iter().map(|it| (it.field.as_str(), it.description.as_str())).collect();
        assert_eq!(found, [("/task/waypoints/1", "too short"), ("/seed", "odd")]);
    }

    /// A status that outgrows the headers a client takes would reach it as a
    /// broken connection.
    #[test]
    fn a_status_fits_into_headers() {
        let mut faults = Faults::default();
        (0..50).for_each(|index| faults.add(format!("/{index}"), "ä".repeat(1000)));
        let status = Status::from(ServiceError::from(faults));
        let violations = status.get_error_details().bad_request().unwrap().field_violations.clone();
        assert_eq!(violations.last().unwrap().description, "and 45 more faults");
        let headers = status.into_http::<()>().into_parts().0.headers;
        let bytes: usize =
            headers.iter().map(|(name, value)| name.as_str().len() + value.len()).sum();
        assert!(bytes < 8 * 1024, "{bytes}");
    }
}
