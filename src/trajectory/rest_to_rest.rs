//! One joint's fastest way from rest to rest: closed form.

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
