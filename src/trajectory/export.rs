//! Trajectories as samples: for programs, spreadsheets and ROS.

use std::fmt::Write as _;

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

use super::{KinematicState, Trajectory};

/// The most samples one export may have: beyond that a client is better
/// served by the polynomials themselves.
pub const MAX_SAMPLES: usize = 200_000;

/// What is followed over time: the position or one of its derivatives.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub enum Quantity {
    /// rad or m.
    Position,
    /// rad/s or m/s.
    Velocity,
    /// rad/s² or m/s².
    Acceleration,
    /// rad/s³ or m/s³.
    Jerk,
}

impl Quantity {
    /// All of them, by order of the derivative.
    pub const ALL: [Self; 4] = [Self::Position, Self::Velocity, Self::Acceleration, Self::Jerk];

    /// The name users write.
    pub fn as_str(self) -> &'static str {
        match self {
            Self::Position => "position",
            Self::Velocity => "velocity",
            Self::Acceleration => "acceleration",
            Self::Jerk => "jerk",
        }
    }

    /// Order of the derivative of the position.
    pub fn order(self) -> usize {
        self as usize
    }

    /// The unit for a joint whose position has `position_unit`, in ASCII:
    /// `rad/s^2`.
    pub fn unit(self, position_unit: &str) -> String {
        let per_time = ["", "/s", "/s^2", "/s^3"][self.order()];
        format!("{position_unit}{per_time}")
    }
}

impl std::fmt::Display for Quantity {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(self.as_str())
    }
}

/// No quantity has this name.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("unknown quantity `{0}`; known: position, velocity, acceleration, jerk")]
pub struct UnknownQuantity(pub String);

impl std::str::FromStr for Quantity {
    type Err = UnknownQuantity;

    fn from_str(text: &str) -> Result<Self, Self::Err> {
        let named = |quantity: &Self| quantity.as_str() == text;
        Self::ALL.into_iter().find(named).ok_or_else(|| UnknownQuantity(text.to_owned()))
    }
}

/// Why trajectories cannot be sampled.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum ExportError {
    /// There is nothing to sample.
    #[error("there is no trajectory to sample")]
    Empty,
    /// The rate is no rate.
    #[error("a rate of {rate_hz} Hz is not possible; give a positive number")]
    Rate {
        /// The rate asked for, Hz.
        rate_hz: f64,
    },
    /// The result would be too large.
    #[error(
        "{duration} s at {rate_hz} Hz are more than {MAX_SAMPLES} samples; \
         ask for at most {possible_hz} Hz"
    )]
    TooManySamples {
        /// Total duration, s.
        duration: f64,
        /// The rate asked for, Hz.
        rate_hz: f64,
        /// The highest rate that is possible, Hz.
        possible_hz: f64,
    },
}

/// One or several trajectories of the same joints on one time axis.
#[derive(Clone, Debug)]
pub struct Timeline<'a> {
    /// The joints' names.
    pub joint_names: &'a [String],
    /// Unit of each joint's position, `rad` or `m`.
    pub joint_units: &'a [String],
    /// When each trajectory starts, s, ascending, and the trajectory. Between
    /// two of them the earlier one's end is held.
    pub legs: Vec<(f64, &'a Trajectory)>,
}

impl Timeline<'_> {
    /// When the last trajectory ends, s.
    pub fn duration(&self) -> f64 {
        self.legs.last().map_or(0.0, |(start, trajectory)| start + trajectory.duration())
    }

    /// Samples at `k / rate_hz` for k = 0, 1, ... and at the exact end.
    ///
    /// # Errors
    ///
    /// If there is nothing to sample, the rate is not positive, or there would
    /// be more than [`MAX_SAMPLES`].
    pub fn sample(&self, rate_hz: f64) -> Result<Samples, ExportError> {
        if self.legs.is_empty() {
            return Err(ExportError::Empty);
        }
        let times = sample_times(self.duration(), rate_hz)?;
        let count = times.len();
        let mut samples = Samples {
            joint_names: self.joint_names.to_vec(),
            joint_units: self.joint_units.to_vec(),
            rate_hz,
            time: times,
            position: Vec::with_capacity(count),
            velocity: Vec::with_capacity(count),
            acceleration: Vec::with_capacity(count),
            jerk: Vec::with_capacity(count),
        };
        let mut state = KinematicState::new(self.joint_names.len());
        for index in 0..count {
            self.state_at(samples.time[index], &mut state);
            samples.position.push(state.position.clone());
            samples.velocity.push(state.velocity.clone());
            samples.acceleration.push(state.acceleration.clone());
            samples.jerk.push(state.jerk.clone());
        }
        Ok(samples)
    }

    /// Where two trajectories meet, the later one counts.
    fn state_at(&self, t: f64, state: &mut KinematicState) {
        let later = self.legs.partition_point(|(start, _)| *start <= t);
        let Some((start, trajectory)) = self.legs.get(later.saturating_sub(1)) else { return };
        let mut local = t - start;
        // Adding and subtracting the start must not push the very end outside,
        // where the trajectory rests.
        if t >= self.duration() {
            local = trajectory.duration();
        }
        trajectory.sample(local, state);
    }
}

fn sample_times(duration: f64, rate_hz: f64) -> Result<Vec<f64>, ExportError> {
    if !(rate_hz > 0.0 && rate_hz.is_finite()) {
        return Err(ExportError::Rate { rate_hz });
    }
    // A last regular sample a rounding error before the end would repeat it.
    let regular = (duration * rate_hz - 1e-6).ceil().max(1.0);
    if regular >= MAX_SAMPLES as f64 {
        let possible_hz = ((MAX_SAMPLES - 1) as f64 / duration).floor();
        return Err(ExportError::TooManySamples { duration, rate_hz, possible_hz });
    }
    let regular = (0..regular as usize).map(|k| k as f64 / rate_hz);
    Ok(regular.chain(std::iter::once(duration)).collect())
}

/// A sampled trajectory. Each row of `position` and its derivatives belongs to
/// the time at the same index and holds one value per joint.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[schema(as = SampledTrajectory)]
pub struct Samples {
    /// Joint order of every row.
    pub joint_names: Vec<String>,
    /// Unit of each joint's position, `rad` or `m`; rates add `/s`, `/s^2`, `/s^3`.
    pub joint_units: Vec<String>,
    /// Samples per second, Hz; the last step may be shorter.
    pub rate_hz: f64,
    /// Times, s, ascending; the last is the exact end.
    pub time: Vec<f64>,
    /// rad or m.
    pub position: Vec<Vec<f64>>,
    /// rad/s or m/s.
    pub velocity: Vec<Vec<f64>>,
    /// rad/s² or m/s².
    pub acceleration: Vec<Vec<f64>>,
    /// rad/s³ or m/s³.
    pub jerk: Vec<Vec<f64>>,
}

impl Samples {
    /// The rows of one quantity.
    pub fn rows(&self, quantity: Quantity) -> &[Vec<f64>] {
        match quantity {
            Quantity::Position => &self.position,
            Quantity::Velocity => &self.velocity,
            Quantity::Acceleration => &self.acceleration,
            Quantity::Jerk => &self.jerk,
        }
    }

    /// As comma-separated values (RFC 4180): time, then all joints' positions,
    /// velocities, accelerations and jerks. The header names joint and unit.
    pub fn to_csv(&self) -> String {
        let mut csv = String::from("t [s]");
        for quantity in Quantity::ALL {
            for (name, unit) in self.joint_names.iter().zip(&self.joint_units) {
                csv.push(',');
                csv.push_str(&quoted(&format!("{name} {quantity} [{}]", quantity.unit(unit))));
            }
        }
        csv.push_str("\r\n");
        for (index, time) in self.time.iter().enumerate() {
            // Writing to a string cannot fail.
            let _ = write!(csv, "{time}");
            for quantity in Quantity::ALL {
                for value in &self.rows(quantity)[index] {
                    let _ = write!(csv, ",{value}");
                }
            }
            csv.push_str("\r\n");
        }
        csv
    }

    /// In the shape of ROS' `trajectory_msgs/JointTrajectory`.
    pub fn to_joint_trajectory(&self) -> JointTrajectory {
        let point = |index: usize| JointTrajectoryPoint {
            positions: self.position[index].clone(),
            velocities: self.velocity[index].clone(),
            accelerations: self.acceleration[index].clone(),
            time_from_start: RosDuration::from_seconds(self.time[index]),
        };
        JointTrajectory {
            joint_names: self.joint_names.clone(),
            points: (0..self.time.len()).map(point).collect(),
        }
    }
}

/// A CSV field, quoted where a comma, quote or line break asks for it.
fn quoted(field: &str) -> String {
    if field.contains([',', '"', '\n', '\r']) {
        format!("\"{}\"", field.replace('"', "\"\""))
    } else {
        field.to_owned()
    }
}

/// A trajectory in the shape of ROS' `trajectory_msgs/JointTrajectory`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct JointTrajectory {
    /// Joint order of every point.
    pub joint_names: Vec<String>,
    /// The samples.
    pub points: Vec<JointTrajectoryPoint>,
}

/// One sample of a [`JointTrajectory`].
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct JointTrajectoryPoint {
    /// rad or m.
    pub positions: Vec<f64>,
    /// rad/s or m/s; empty if not given.
    #[serde(default)]
    pub velocities: Vec<f64>,
    /// rad/s² or m/s²; empty if not given.
    #[serde(default)]
    pub accelerations: Vec<f64>,
    /// When, counted from the trajectory's start.
    pub time_from_start: RosDuration,
}

/// A duration as ROS writes it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize, ToSchema)]
pub struct RosDuration {
    /// Full seconds.
    pub sec: i32,
    /// Nanoseconds beyond them, below 10⁹.
    pub nanosec: u32,
}

impl RosDuration {
    /// s; rounded once, so that a time read back is the nearest to what is written.
    pub fn seconds(self) -> f64 {
        let total = i64::from(self.sec) * 1_000_000_000 + i64::from(self.nanosec);
        total as f64 / 1e9
    }

    fn from_seconds(seconds: f64) -> Self {
        const NANOSECONDS: u64 = 1_000_000_000;
        let total = (seconds * 1e9).round() as u64;
        let sec = i32::try_from(total / NANOSECONDS).unwrap_or(i32::MAX);
        Self { sec, nanosec: (total % NANOSECONDS) as u32 }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// One joint that moves as t², and one that stands still.
    fn parabola(duration: f64) -> Trajectory {
        Trajectory {
            breakpoints: vec![0.0, duration],
            pieces: vec![vec![vec![0.0, 0.0, 1.0], vec![5.0]]],
        }
    }

    fn names() -> (Vec<String>, Vec<String>) {
        (vec!["turn".into(), "lift, \"z\"".into()], vec!["rad".into(), "m".into()])
    }

    fn sample(trajectories: &[(f64, &Trajectory)], rate_hz: f64) -> Result<Samples, ExportError> {
        let (joint_names, joint_units) = names();
        let legs = trajectories.to_vec();
        Timeline { joint_names: &joint_names, joint_units: &joint_units, legs }.sample(rate_hz)
    }

    #[test]
    fn samples_regularly_and_at_the_exact_end() {
        let samples = sample(&[(0.0, &parabola(0.35))], 10.0).unwrap();
        assert_eq!(samples.time, [0.0, 0.1, 0.2, 0.3, 0.35]);
        assert_eq!(samples.position[2], [0.2 * 0.2, 5.0]);
        assert_eq!(samples.velocity[4], [0.7, 0.0]);
        assert_eq!(samples.acceleration[4], [2.0, 0.0]);
        assert_eq!(samples.jerk[1], [0.0, 0.0]);
    }

    #[test]
    fn an_end_on_the_grid_comes_once() {
        for (duration, rate) in [(0.3, 10.0), (1.1, 1000.0), (7.0, 3.0), (0.004, 250.0)] {
            let times = sample(&[(0.0, &parabola(duration))], rate).unwrap().time;
            assert_eq!(
                times.len(),
                (duration * rate).round() as usize + 1,
                "{duration} s, {rate} Hz"
            );
            assert_eq!(times.last(), Some(&duration));
            assert!(times.is_sorted_by(|a, b| a < b));
        }
    }

    #[test]
    fn legs_follow_each_other_and_pauses_rest() {
        let leg = parabola(1.0);
        let samples = sample(&[(0.0, &leg), (1.5, &leg)], 4.0).unwrap();
        assert_eq!(samples.time.last(), Some(&2.5));
        let position: Vec<f64> = samples.position.iter().map(|row| row[0]).collect();
        let grid = [0.0, 0.0625, 0.25, 0.5625, 1.0, 1.0, 0.0, 0.0625, 0.25, 0.5625, 1.0];
        assert_eq!(position, grid);
        // At rest in the pause at 1.25 s, still moving at both ends' last sample.
        assert_eq!(samples.velocity[5][0], 0.0);
        assert_eq!(samples.velocity[10][0], 2.0);
    }

    #[test]
    fn refuses_what_cannot_be_sampled() {
        let trajectory = parabola(2.0);
        for rate in [0.0, -1.0, f64::NAN, f64::INFINITY] {
            let error = sample(&[(0.0, &trajectory)], rate).unwrap_err();
            assert!(matches!(error, ExportError::Rate { .. }), "{error}");
        }
        assert_eq!(sample(&[], 1.0), Err(ExportError::Empty));
        let error = sample(&[(0.0, &trajectory)], 1e9).unwrap_err();
        let ExportError::TooManySamples { possible_hz, .. } = error else { panic!("{error}") };
        let samples = sample(&[(0.0, &trajectory)], possible_hz).unwrap();
        assert!(samples.time.len() <= MAX_SAMPLES, "{}", samples.time.len());
    }

    #[test]
    fn csv_names_joints_and_units_and_reads_back_exactly() {
        let samples = sample(&[(0.0, &parabola(0.35))], 10.0).unwrap();
        let csv = samples.to_csv();
        let mut lines = csv.split_terminator("\r\n");
        let header = lines.next().unwrap();
        assert!(header.starts_with(
            "t [s],turn position [rad],\"lift, \"\"z\"\" position [m]\",turn velocity [rad/s],"
        ));
        assert!(header.ends_with("turn jerk [rad/s^3],\"lift, \"\"z\"\" jerk [m/s^3]\""));
        let rows: Vec<Vec<f64>> =
            lines.map(|line| line.split(',').map(|x| x.parse().unwrap()).collect()).collect();
        assert_eq!(rows.len(), samples.time.len());
        for (index, row) in rows.iter().enumerate() {
            assert_eq!(row.len(), 9);
            assert_eq!(row[0], samples.time[index]);
            assert_eq!(row[1..3], samples.position[index]);
            assert_eq!(row[7..9], samples.jerk[index]);
        }
    }

    #[test]
    fn ros_shape_splits_seconds_from_nanoseconds() {
        let samples = sample(&[(0.0, &parabola(2.000_000_001))], 1.0).unwrap();
        let json = serde_json::to_value(samples.to_joint_trajectory()).unwrap();
        assert_eq!(json["joint_names"][0], "turn");
        let times: Vec<_> =
            json["points"].as_array().unwrap().iter().map(|p| &p["time_from_start"]).collect();
        assert_eq!(times.len(), 3);
        assert_eq!(times[2], &serde_json::json!({"sec": 2, "nanosec": 1}));
        assert_eq!(json["points"][1]["positions"], serde_json::json!([1.0, 5.0]));
        assert_eq!(json["points"][1]["velocities"], serde_json::json!([2.0, 0.0]));
        assert_eq!(json["points"][1]["accelerations"], serde_json::json!([2.0, 0.0]));
        assert_eq!(RosDuration::from_seconds(0.999_999_999_9), RosDuration { sec: 1, nanosec: 0 });
        for k in 0..1000 {
            let time = f64::from(k) / 250.0;
            assert_eq!(RosDuration::from_seconds(time).seconds(), time);
        }
    }

    #[test]
    fn quantities_have_one_name_everywhere() {
        for quantity in Quantity::ALL {
            assert_eq!(serde_json::to_value(quantity).unwrap(), quantity.as_str());
            assert_eq!(quantity.as_str().parse(), Ok(quantity));
        }
        assert!("snap".parse::<Quantity>().is_err());
        assert_eq!(Quantity::Jerk.unit("m"), "m/s^3");
    }
}
