//! One problem in many variants: what is asked for and what comes out.

use crate::plan::{
    FamilyMember, FamilyProblem, FamilyResult, FamilyTask, MemberFailure, MemberResult,
    MembersDone, MostBinding, SweepAxis,
};

message_form!(FamilyTask { problem: Required, members, sweep });

message_form!(FamilyProblem { robot, limits, limit_scale, task: Required });

message_form!(FamilyMember { name, set: Defaulted });

message_form!(SweepAxis { path, values });

message_form!(FamilyResult {
    robot,
    verdict,
    sweep,
    members,
    fastest,
    slowest,
    median_duration,
    failed,
    lawful,
    worst_ratio,
    worst_case: Required,
    evaluations,
    planning_s,
    seed,
    version,
});

message_form!(MemberResult {
    name,
    values,
    duration,
    lower_bound,
    gap,
    lawful,
    worst_ratio,
    most_binding,
    evaluations,
    failure,
});

message_form!(MostBinding { joint, limit, segments, seconds_per_percent });

message_form!(MemberFailure { code, message, details: Required });

message_form!(MembersDone { done, of, failed, slowest });
