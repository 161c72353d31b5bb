//! What Han et al. print, doi:10.3390/a15080269.

/// Table 2: a row per waypoint, deg.
pub(super) const TABLE_2: [[f64; 6]; 4] = [
    [0.0, -35.1, -29.8, 0.0, -25.1, 0.0],
    [-24.0, -37.7, -30.6, 0.0, -21.7, 23.96],
    [-43.7, -52.2, -4.14, 0.0, -33.6, 135.3],
    [-30.0, -58.3, -2.11, 0.0, -29.6, 125.0],
];

/// Table 3: times before any optimisation, s.
pub(super) const TABLE_3: [f64; 3] = [3.0, 6.0, 3.0];

/// Table 4: limits of velocity, acceleration and jerk; rad.
pub(super) const TABLE_4: [[f64; 6]; 3] = [
    [0.9, 0.9, 0.9, 0.9, 0.95, 1.0],
    [0.9, 0.9, 0.9, 0.9, 0.9, 1.0],
    [2.0, 2.0, 2.0, 2.0, 2.0, 2.0],
];

/// The speed limits that the peaks at the times of Table 5 show, rad/s. Not printed.
pub(super) const SPEEDS: [f64; 6] = [0.5, 0.5, 0.5, 0.5, 0.5, 1.0];

/// Table 5: joint index and the times of standard and of improved PSO, s.
/// Joint 4 does not move.
pub(super) const TABLE_5: [(usize, [[f64; 3]; 2]); 5] = [
    (0, [[3.0, 1.43, 1.9], [2.79, 1.29, 1.68]]),
    (1, [[0.38, 0.68, 0.7], [0.3, 0.54, 0.56]]),
    (2, [[0.63, 1.98, 0.58], [0.46, 1.67, 0.45]]),
    (4, [[0.81, 1.15, 0.85], [0.67, 0.88, 0.71]]),
    (5, [[1.95, 3.34, 1.85], [1.88, 3.31, 1.79]]),
];

/// Table 5, row "optimal": the times of all joints, standard and improved, s.
pub(super) const COMPOSED: [[f64; 3]; 2] = [[3.0, 3.34, 1.9], [2.79, 3.31, 1.79]];

/// By how many percent the motion is said to be shorter than before.
pub(super) const REDUCTION: f64 = 34.25;

/// Figure 13: peaks of acceleration and jerk, rad/s^2 and rad/s^3.
pub(super) const FIGURE_13: [f64; 2] = [0.8, 1.51];

/// Figure 12: iterations to the optimum of improved PSO, standard PSO, GA and
/// COA with an "optimisation space" of 100 and 200.
pub(super) const FIGURE_12: [f64; 5] = [8.0, 33.0, 17.0, 20.0, 56.0];

/// By how many percent improved PSO is said to be more accurate than the other
/// four; printed in one list, read in the order of the sentence before it.
pub(super) const ACCURACY: [f64; 4] = [1.1, 4.4, 15.7, 12.2];

/// Table 6: per section the times without optimisation, of standard PSO, GA, COA
/// and improved PSO, s.
pub(super) const TABLE_6: [(&str, [[f64; 3]; 5]); 4] = [
    (
        "AB",
        [
            [3.0, 6.0, 3.0],
            [3.0, 2.79, 3.34],
            [3.04, 2.53, 3.77],
            [3.43, 3.01, 2.88],
            [3.31, 1.9, 1.79],
        ],
    ),
    (
        "BC",
        [
            [8.0, 5.0, 8.0],
            [4.03, 1.8, 7.31],
            [5.13, 3.22, 6.97],
            [4.75, 2.06, 5.83],
            [4.1, 1.63, 5.8],
        ],
    ),
    (
        "CD",
        [
            [3.0, 6.0, 8.0],
            [3.0, 5.49, 4.11],
            [2.89, 4.51, 4.34],
            [2.51, 5.17, 4.4],
            [2.46, 4.89, 3.3],
        ],
    ),
    (
        "DE",
        [
            [7.0, 3.0, 3.0],
            [3.54, 1.55, 1.27],
            [4.01, 1.7, 1.62],
            [3.87, 1.5, 1.11],
            [2.82, 1.28, 1.05],
        ],
    ),
];

/// Table 6: seconds saved per section and together, and the share in percent.
pub(super) const SAVED: ([f64; 4], f64, f64) = ([2.13, 1.61, 1.95, 1.21], 6.9, 16.7);

/// Table 7: per part the times of the sections AB to DE and their printed total;
/// without optimisation, with standard and with improved PSO, s.
pub(super) const TABLE_7: [(&str, [[f64; 3]; 5]); 4] = [
    (
        "arc extinguisher",
        [
            [9.34, 16.43, 9.08],
            [15.36, 14.54, 12.85],
            [11.06, 4.64, 5.85],
            [12.52, 8.03, 12.75],
            [48.28, 43.63, 40.53],
        ],
    ),
    (
        "big U rod",
        [
            [12.76, 13.88, 12.68],
            [11.84, 9.0, 9.05],
            [15.04, 14.63, 11.23],
            [11.06, 11.39, 14.45],
            [50.7, 48.89, 47.4],
        ],
    ),
    (
        "yoke",
        [
            [10.22, 13.5, 7.43],
            [14.64, 11.9, 15.33],
            [12.18, 12.62, 10.3],
            [12.1, 9.65, 8.33],
            [49.14, 47.68, 41.38],
        ],
    ),
    (
        "handle",
        [
            [12.48, 12.65, 9.9],
            [13.9, 9.29, 10.45],
            [12.86, 9.36, 9.75],
            [8.34, 11.68, 9.68],
            [47.58, 42.98, 39.78],
        ],
    ),
];
