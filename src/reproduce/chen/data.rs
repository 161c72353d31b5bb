//! What Chen et al. print, doi:10.3390/app131810482.

/// Methods of Table 3 as printed, and by registry name.
pub(super) const METHODS: [(&str, &str); 5] = [
    ("PSO", "pso"),
    ("CFPSO", "cfpso"),
    ("SPSO", "spso"),
    ("Gold-SA", "gold_sa"),
    ("GoldS-PSO", "golds_pso"),
];

/// Runs of every method in Table 3.
pub(super) const RUNS: u32 = 30;

/// Table 3: per function F1 to F8 and method mean, best and standard deviation.
pub(super) const TABLE_3: [[[f64; 3]; 5]; 8] = [
    [
        [37.3248, 24.3271, 4.6358],
        [1.2322, 0.53919, 3.9174],
        [6.4918e-190, 2.5027e-190, 1.4048e-189],
        [0.0, 0.0, 0.0],
        [0.0, 0.0, 0.0],
    ],
    [
        [25.9152, 23.1681, 1.6301],
        [3.1992, 1.7982, 0.80076],
        [7.6576e-96, 3.6225e-96, 2.852e-96],
        [1.3191e-259, 0.0, 0.0],
        [0.0, 0.0, 0.0],
    ],
    [
        [2.3978, 2.0577, 0.12016],
        [0.9964, 0.81201, 0.11032],
        [1.3423e-95, 1.2058e-95, 5.1565e-97],
        [2.4626e-214, 0.0, 0.0],
        [0.0, 0.0, 0.0],
    ],
    [
        [35.8749, 27.984, 4.9812],
        [1.2009, 0.526, 0.46943],
        [5.3438, 4.776, 0.42675],
        [6.3772e-05, 2.7074e-07, 0.00016428],
        [3.0695e-05, 2.3277e-07, 3.52212e-05],
    ],
    [
        [1586.7973, 1011.8771, 326.9182],
        [7.5091, 2.8872, 3.8832],
        [0.13191, 0.023587, 0.076126],
        [4.141e-05, 3.9512e-06, 5.6872e-05],
        [2.9164e-05, 1.0577e-06, 2.3199e-05],
    ],
    [
        [3.8518, 3.5918, 11.5],
        [1.6354, 0.71535, 0.46235],
        [7.8752e-15, 4.4409e-15, 6.4863e-16],
        [8.8818e-16, 8.8818e-16, 0.0],
        [8.8818e-16, 8.8818e-16, 0.0],
    ],
    [
        [0.86704, 0.77332, 0.046326],
        [0.050136, 0.015054, 0.020134],
        [0.11211, 0.0, 0.26264],
        [0.0, 0.0, 0.0],
        [0.0, 0.0, 0.0],
    ],
    [
        [5.6774, 3.0884, 0.83954],
        [0.32971, 0.14755, 0.10153],
        [3.1016, 2.6321, 0.38235],
        [9.1171e-05, 1.0629e-07, 0.00025837],
        [9.823e-05, 1.3947e-77, 0.00010078],
    ],
];

/// Table 4: a row per waypoint; m and rad. Its columns are printed A, B, B, D
/// and read as A, B, C, D.
#[expect(clippy::approx_constant, reason = "the paper prints 3.141")]
pub(super) const TABLE_4: [[f64; 4]; 4] = [
    [0.8, 1.2, 3.141, 0.0],
    [0.578, 0.868, 1.897, 1.047],
    [0.688, 0.567, 1.468, 1.771],
    [0.459, 0.964, 2.355, 0.754],
];

/// Section 3.2: limits of velocity and acceleration per joint; m or rad.
pub(super) const LIMITS: [[f64; 2]; 4] = [[0.6, 0.8], [0.6, 0.8], [1.8, 2.4], [1.8, 2.4]];

/// A method's times in Table 5.
pub(super) struct PublishedTimes {
    /// As printed.
    pub(super) method: &'static str,
    /// In the registry.
    pub(super) optimizer: &'static str,
    /// Per joint the printed total and the times of the three segments, s.
    pub(super) joints: [[f64; 4]; 4],
    /// The sum over segments of the largest time of any joint, s.
    pub(super) composed: f64,
}

/// Table 5.
pub(super) const TABLE_5: [PublishedTimes; 3] = [
    PublishedTimes {
        method: "PSO",
        optimizer: "pso",
        joints: [
            [7.221, 1.7301, 3.5905, 1.9008],
            [7.4472, 2.0576, 2.2782, 3.0889],
            [7.0339, 2.6648, 2.3479, 2.0272],
            [6.9658, 2.0908, 2.5381, 2.3368],
        ],
        composed: 9.3442,
    },
    PublishedTimes {
        method: "Gold-SA",
        optimizer: "gold_sa",
        joints: [
            [7.121, 1.9488, 3.1077, 2.0645],
            [7.5203, 2.2059, 2.2647, 3.0497],
            [6.9526, 2.4483, 2.4637, 2.0406],
            [7.1518, 2.3862, 2.4097, 2.356],
        ],
        composed: 8.6057,
    },
    PublishedTimes {
        method: "GoldS-PSO",
        optimizer: "golds_pso",
        joints: [
            [7.0672, 2.1107, 2.954, 2.0025],
            [7.2177, 2.0009, 2.6121, 2.6047],
            [6.897, 2.3189, 2.5846, 1.9935],
            [6.8713, 2.0205, 2.5096, 2.3412],
        ],
        composed: 7.8776,
    },
];

/// The times of all joints together, s.
pub(super) const COMPOSED: [f64; 3] = [2.3189, 2.954, 2.6047];

/// Their sum as the conclusion prints it, s.
pub(super) const CONCLUSION: f64 = 7.8876;

/// Duration before any optimisation, 5 s per segment, s.
pub(super) const BEFORE: f64 = 15.0;

/// By how many percent GoldS-PSO is said to be shorter: than what, in the text
/// and in the abstract.
pub(super) const REDUCTIONS: [(&str, f64, f64); 3] =
    [("5 s per segment", 47.483, 47.35), ("PSO", 15.695, 8.99), ("Gold-SA", 8.461, 6.23)];
