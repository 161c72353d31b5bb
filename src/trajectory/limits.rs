//! The limits a plan keeps, and where each comes from.

use super::kernel::KernelLimits;

/// One limit.
#[derive(Clone, Debug, PartialEq)]
pub struct Limit {
    /// rad or m, per second to the order of the derivative.
    pub value: f64,
    /// Where it comes from, as the certificate shows it.
    pub provenance: String,
}

/// One joint's limits; none where none is known, and then none is enforced.
#[derive(Clone, Debug, PartialEq)]
pub struct JointBounds {
    /// Joint name.
    pub name: String,
    /// `rad` or `m`.
    pub unit: &'static str,
    /// Lower position limit.
    pub lower: Option<Limit>,
    /// Upper position limit.
    pub upper: Option<Limit>,
    /// Limits on the magnitude of velocity, acceleration and jerk.
    pub derivatives: [Option<Limit>; 3],
}

/// The names of the limited derivatives, in order.
pub const DERIVATIVES: [&str; 3] = ["velocity", "acceleration", "jerk"];

impl JointBounds {
    /// The limit's value, infinite where there is none.
    pub fn derivative(&self, order: usize) -> f64 {
        self.derivatives[order].as_ref().map_or(f64::INFINITY, |limit| limit.value)
    }

    /// The limits as the kernel takes them; the first `orders` derivatives only.
    pub fn kernel(&self, orders: usize) -> KernelLimits {
        let value = |limit: &Option<Limit>, none: f64| limit.as_ref().map_or(none, |l| l.value);
        let mut derivatives = [f64::INFINITY; 3];
        for (order, derivative) in derivatives.iter_mut().enumerate().take(orders) {
            *derivative = self.derivative(order);
        }
        KernelLimits {
            derivatives,
            position: [value(&self.lower, f64::NEG_INFINITY), value(&self.upper, f64::INFINITY)],
        }
    }

    /// The unit of derivative `order` (0 is position).
    pub fn unit_of(&self, order: usize) -> String {
        let suffix = ["", "/s", "/s²", "/s³"];
        format!("{}{}", self.unit, suffix.get(order).copied().unwrap_or("/sⁿ"))
    }
}
