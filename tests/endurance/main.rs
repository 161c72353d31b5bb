//! What must hold when things go badly or get crowded: killed servers, a
//! thousand watchers, busy workers, a drain.

#![expect(clippy::unwrap_used, clippy::panic, reason = "a test that cannot go on says where")]

mod busy;
mod kill;
mod support;
mod watchers;
