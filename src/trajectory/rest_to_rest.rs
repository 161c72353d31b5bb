//! One joint's ways from rest to rest: closed forms.

/// The fastest way from rest to rest: durations of a jerk phase, of constant
/// acceleration and of constant speed.
///
/// Where no limit of acceleration or jerk exists, `limits` must hold a finite one instead.
pub fn rest_to_rest(way: f64, limits: [f64; 3]) -> [f64; 3] {
    let [velocity, acceleration, jerk] = limits;
    let ramp =
        libm::cbrt(way / (2.0 * jerk)).min(libm::sqrt(velocity / jerk)).min(acceleration / jerk);
    // Speed gained is `a (ramp + hold)`, way `a (ramp + hold) (2 ramp + hold)`.
    if ramp < acceleration / jerk {
        let speed = jerk * ramp * ramp;
        return [ramp, 0.0, (way / speed - 2.0 * ramp).max(0.0)];
    }
    let peak = acceleration;
    let root = libm::sqrt(ramp * ramp + 4.0 * way / peak);
    let hold = ((root - 3.0 * ramp) / 2.0).min(velocity / peak - ramp).max(0.0);
    let speed = peak * (ramp + hold);
    [ramp, hold, (way / speed - 2.0 * ramp - hold).max(0.0)]
}

/// The time one joint needs at least for `way` from rest to rest, s; `limits` of velocity,
/// acceleration and jerk may be infinite. Zero where no limit says anything.
pub fn alone(way: f64, limits: [f64; 3]) -> f64 {
    let [velocity, acceleration, jerk] = limits;
    let way = way.abs();
    if way == 0.0 || acceleration.is_infinite() && jerk.is_infinite() {
        return way / velocity;
    }
    let [ramp, hold, cruise] = rest_to_rest(way, limits);
    4.0 * ramp + 2.0 * hold + cruise
}

/// What the limits of velocity, acceleration and jerk hold back in [`alone`], s per relative change: how
/// much less time there would be with a limit higher by one percent, times 100.
///
/// Since time scales with the limits, `velocity + 2 acceleration + 3 jerk` is the whole time.
pub fn gains(way: f64, limits: [f64; 3]) -> [f64; 3] {
    let [velocity, acceleration, jerk] = limits;
    let whole = alone(way, limits);
    if whole == 0.0 || acceleration.is_infinite() && jerk.is_infinite() {
        return [whole, 0.0, 0.0];
    }
    let [ramp, hold, _] = rest_to_rest(way.abs(), limits);
    // Which limits are reached, not which phases have a duration: rounding leaves some of the others.
    let held = ramp >= acceleration / jerk;
    let peak = if held { acceleration * (ramp + hold) } else { jerk * ramp * ramp };
    match (peak >= velocity * (1.0 - 1e-12), held) {
        // whole = way/V + V/A + A/J.
        (true, true) => {
            let rise = velocity / acceleration;
            [whole - 2.0 * rise - ramp, rise - ramp, ramp]
        }
        // whole = way/V + 2 sqrt(V/J).
        (true, false) => [whole - 3.0 * ramp, 0.0, ramp],
        // way = A s (s - A/J), where s is half of the whole.
        (false, true) => {
            let half = 0.5 * whole;
            let by_jerk = 2.0 * ramp * half / (2.0 * half - ramp);
            [0.0, 0.5 * (whole - 3.0 * by_jerk), by_jerk]
        }
        (false, false) => [0.0, 0.0, whole / 3.0],
    }
}

/// The time in which a fifth-order polynomial from rest to rest keeps all limits, s; its peaks are
/// `15/8 way/t`, `10/sqrt(3) way/t²` and `60 way/t³`.
pub fn quintic(way: f64, [velocity, acceleration, jerk]: [f64; 3]) -> f64 {
    let way = way.abs();
    (1.875 * way / velocity)
        .max((5.7735 * way / acceleration).sqrt())
        .max(libm::cbrt(60.0 * way / jerk))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Every shape of the profile, with and without limits.
    #[test]
    fn gains_are_the_slopes_of_the_time() {
        let free = f64::INFINITY;
        for (way, limits) in [
            (0.1, [9.0, 9.0, 5.0]),
            (0.4188790204786391, [0.9, 0.9, 2.0]),
            (1.0, [9.0, 1.0, 5.0]),
            (2.0, [0.5, 1.0, 5.0]),
            (2.0, [0.5, 9.0, 5.0]),
            (2.0, [0.5, 1.0, free]),
            (2.0, [free, 1.0, free]),
            (2.0, [0.5, free, 3.0]),
            (-2.0, [0.5, free, free]),
        ] {
            let found = gains(way, limits);
            for order in 0..3 {
                let at = |factor: f64| {
                    let mut limits = limits;
                    limits[order] *= factor;
                    alone(way, limits)
                };
                let slope = (at(1.0 - 1e-6) - at(1.0 + 1e-6)) / 2e-6;
                assert!(
                    (found[order] - slope).abs() < 1e-7,
                    "{limits:?} {order}: {found:?}, {slope}"
                );
            }
        }
    }
}
