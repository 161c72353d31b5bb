//! Request bodies that work as they stand, for whoever tries the interface out.

use serde_json::{Value, json};

/// The least that makes a job.
pub(super) fn job() -> Value {
    json!({
        "robot": "woodworking_pprr",
        "task": {
            "type": "waypoints",
            "waypoints": [[0.8, 1.2, 3.1, 0.0], [0.6, 0.9, 1.9, 1.0], [0.5, 1.0, 2.4, 0.8]],
        },
    })
}

/// A job with most of what can be said.
pub(super) fn published_job() -> Value {
    json!({
        "robot": "ur5e",
        "limits": { "acceleration": 8, "jerk": [60, 60, 60, 120, 120, null] },
        "limit_scale": { "velocity": 0.8 },
        "task": {
            "type": "waypoints",
            "interpolation": "quintic_han",
            "clock": "per_joint",
            "optimizer": { "name": "improved_pso", "iterations": 40 },
            "waypoints": [
                [0.0, -1.6, 1.2, -1.2, -1.6, 0.0],
                [0.4, -1.3, 1.4, -1.5, -1.6, 0.3],
                [0.8, -1.1, 1.3, -1.6, -1.5, 0.5],
                [1.2, -1.5, 1.1, -1.3, -1.6, 0.8],
            ],
        },
        "seed": 7,
        "priority": 70,
        "labels": { "cell": "7" },
    })
}

/// A job of two legs.
pub(super) fn program_job() -> Value {
    let there = json!([[0.8, 1.2, 3.1, 0.0], [0.6, 0.9, 1.9, 1.0]]);
    let back = json!([[0.6, 0.9, 1.9, 1.0], [0.8, 1.2, 3.1, 0.0]]);
    json!({
        "robot": "woodworking_pprr",
        "task": {
            "type": "program",
            "legs": [
                { "name": "there", "task": { "type": "waypoints", "waypoints": there } },
                { "name": "back", "task": { "type": "waypoints", "waypoints": back } },
            ],
        },
    })
}

/// One motion within scaled limits: what if?
pub(super) fn family_job() -> Value {
    json!({
        "robot": "woodworking_pprr",
        "task": {
            "type": "family",
            "problem": {
                "task": {
                    "type": "waypoints",
                    "waypoints": [[0.8, 1.2, 3.1, 0.0], [0.6, 0.9, 1.9, 1.0], [0.5, 1.0, 2.4, 0.8]],
                },
            },
            "sweep": [
                { "path": "/limit_scale/acceleration", "values": [0.25, 0.5, 0.75, 1.0] },
                { "path": "/limit_scale/velocity", "values": [0.5, 1.0] },
            ],
        },
    })
}

/// Three methods compared on one motion.
pub(super) fn comparison_job() -> Value {
    json!({
        "robot": "woodworking_pprr",
        "task": {
            "type": "comparison",
            "task": {
                "type": "waypoints",
                "waypoints": [[0.8, 1.2, 3.1, 0.0], [0.6, 0.9, 1.9, 1.0], [0.5, 1.0, 2.4, 0.8]],
            },
            "methods": ["cfpso", "coa", { "name": "ga", "label": "small ga", "population": 40 }],
            "runs": 10,
            "max_evaluations": 1000,
        },
    })
}

/// A way for a point around two obstacles; no robot is needed.
pub(super) fn path_job() -> Value {
    json!({
        "task": {
            "type": "path",
            "space": {
                "lower": [0, 0],
                "upper": [100, 100],
                "obstacles": [
                    { "type": "ball", "center": [50, 50], "radius": 20 },
                    { "type": "box", "lower": [70, 20], "upper": [80, 60] },
                ],
            },
            "start": [10, 50],
            "goal": [90, 50],
            "smoothing": { "name": "bezier" },
        },
    })
}

/// A robot around a pillar, to where its tool shall be.
pub(super) fn motion_job() -> Value {
    json!({
        "robot": "ur5e",
        "scene": {
            "obstacles": [{
                "name": "pillar",
                "shape": { "type": "box", "size": [0.12, 0.12, 1.2] },
                "pose": { "position": [-0.55, 0, 0.2] },
            }],
        },
        "limits": { "acceleration": 8, "jerk": 80 },
        "task": {
            "type": "motion",
            "start": { "joints": [-0.9, -1.2, 1.4, -1.8, -1.57, 0] },
            "goal": { "joints": [0.9, -1.2, 1.4, -1.8, -1.57, 0] },
            "clearance_m": 0.01,
        },
    })
}

/// Two methods compared on functions with known optima; no robot is needed.
pub(super) fn benchmark_job() -> Value {
    json!({
        "task": {
            "type": "benchmark",
            "functions": ["f1", "f6"],
            "dimension": 10,
            "iterations": 100,
            "runs": 10,
            "optimizers": ["cfpso", "golds_pso"],
            "shifted": true,
        },
    })
}

/// A robot of two joints; what is not known is left out.
pub(super) fn robot() -> Value {
    json!({
        "joints": [
            {
                "name": "x",
                "type": "prismatic",
                "limits": { "lower": 0, "upper": 2, "velocity": 1.5, "acceleration": 4, "jerk": 40 },
            },
            {
                "name": "turn",
                "type": "continuous",
                "limits": { "velocity": 3, "acceleration": 12 },
            },
        ],
    })
}

/// A configuration of a UR5e.
pub(super) fn configuration() -> Value {
    json!({ "joints": [0.0, -1.6, 1.2, -1.2, -1.6, 0.0] })
}

/// A pose in front of a UR5e, the tool pointing down, and where its joints are now.
pub(super) fn pose() -> Value {
    json!({
        "pose": { "position": [-0.4, -0.2, 0.3], "orientation": [1.0, 0.0, 0.0, 0.0] },
        "seed": [0.0, -1.6, 1.2, -1.2, -1.6, 0.0],
    })
}

/// Samples, and that the controller runs cubics through them.
pub(super) fn trajectory_to_verify() -> Value {
    json!({
        "robot": "woodworking_pprr",
        "samples": {
            "interpolation": "cubic",
            "times": [0, 1, 2],
            "positions": [[0, 0, 0, 0], [0.2, 0.1, 0.5, 0.5], [0.3, 0.2, 1, 1]],
            "velocities": [[0, 0, 0, 0], [0.2, 0.1, 0.5, 0.5], [0, 0, 0, 0]],
        },
    })
}
