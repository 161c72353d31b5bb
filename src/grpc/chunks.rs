//! Results in chunks: clients refuse messages beyond 4 MiB unless told
//! otherwise.
//!
//! A chunk continues a message the way protobuf merges: lists are appended, the
//! rest is set once. What has no bound of its own (segments, iterations) is
//! spread over chunks; what has one (joints) stays in the first.

use std::mem;

use prost::Message;

use super::convert::{Place, read};
use super::proto::plan_result::Kind;
use super::proto::result_chunk::Part;
use super::proto::{
    LegResult, PathResult, PlanResult, ProgramResult, ResultChunk, Space, Trajectory,
    TrajectoryResult,
};
use crate::fault::Faults;
use crate::plan;

/// Size at which a chunk is sent, bytes. A list's element may go beyond it, and
/// is itself far smaller than the limit.
const CHUNK_BYTES: usize = 1 << 20;

/// The result in chunks, in the order in which [`join`] takes them.
pub fn split(result: PlanResult) -> Vec<ResultChunk> {
    let mut chunks = Vec::new();
    let mut send = |part| chunks.push(ResultChunk { part: Some(part) });
    match result.kind {
        None => {}
        Some(Kind::Trajectory(result)) => {
            split_trajectory(result).into_iter().for_each(|part| send(Part::Trajectory(part)));
        }
        Some(Kind::Program(mut program)) => {
            let legs = mem::take(&mut program.legs);
            send(Part::Program(program));
            for LegResult { name, note, start, result } in legs {
                let mut parts = split_trajectory(result.unwrap_or_default()).into_iter();
                send(Part::Leg(LegResult { name, note, start, result: parts.next() }));
                parts.for_each(|part| send(Part::Trajectory(part)));
            }
        }
        Some(Kind::Family(mut family)) => {
            let members = mem::take(&mut family.members);
            let worst_case = family.worst_case.take().unwrap_or_default();
            send(Part::Family(family));
            members.into_iter().for_each(|member| send(Part::Member(member)));
            split_trajectory(worst_case).into_iter().for_each(|part| send(Part::Trajectory(part)));
        }
        Some(Kind::Path(path)) => {
            split_path(path).into_iter().for_each(|part| send(Part::Path(part)))
        }
        // A problem is bounded: methods and points of their curves are.
        Some(Kind::Comparison(mut comparison)) => {
            let problems = mem::take(&mut comparison.problems);
            send(Part::Comparison(comparison));
            problems.into_iter().for_each(|problem| send(Part::Problem(problem)));
        }
    }
    chunks
}

/// The result that `chunks` make together.
///
/// # Errors
///
/// If they are not the chunks of one result.
pub fn join(chunks: impl IntoIterator<Item = ResultChunk>) -> Result<plan::PlanResult, Faults> {
    let mut joined = None;
    for (index, chunk) in chunks.into_iter().enumerate() {
        if let Err(detail) = append(&mut joined, chunk) {
            let mut faults = Faults::default();
            Place::Root.element(index).fault(&mut faults, detail);
            return Err(faults);
        }
    }
    read(PlanResult { kind: joined })
}

fn append(joined: &mut Option<Kind>, chunk: ResultChunk) -> Result<(), String> {
    let part = chunk.part.ok_or("an empty chunk")?;
    match (part, joined) {
        (Part::Program(program), joined @ None) => *joined = Some(Kind::Program(program)),
        (Part::Trajectory(result), joined @ None) => *joined = Some(Kind::Trajectory(result)),
        (Part::Comparison(result), joined @ None) => *joined = Some(Kind::Comparison(result)),
        (Part::Path(result), joined @ None) => *joined = Some(Kind::Path(result)),
        (Part::Path(more), Some(Kind::Path(path))) => merge(path, &more)?,
        (Part::Family(result), joined @ None) => *joined = Some(Kind::Family(result)),
        (Part::Member(member), Some(Kind::Family(family))) => family.members.push(member),
        (Part::Trajectory(more), Some(Kind::Family(family))) => {
            merge(family.worst_case.get_or_insert_default(), &more)?;
        }
        (Part::Problem(problem), Some(Kind::Comparison(result))) => result.problems.push(problem),
        (Part::Leg(leg), Some(Kind::Program(program))) => program.legs.push(leg),
        (Part::Trajectory(more), Some(Kind::Trajectory(result))) => merge(result, &more)?,
        (Part::Trajectory(more), Some(Kind::Program(ProgramResult { legs, .. }))) => {
            let leg = legs.last_mut().ok_or("a trajectory before its leg")?;
            merge(leg.result.get_or_insert_default(), &more)?;
        }
        (Part::Trajectory(_), Some(Kind::Comparison(_) | Kind::Path(_)))
        | (Part::Program(_) | Part::Path(_) | Part::Family(_) | Part::Comparison(_), Some(_)) => {
            return Err("a second result".to_owned());
        }
        (Part::Problem(_), _) => return Err("a problem without its comparison".to_owned()),
        (Part::Member(_), _) => return Err("a member without its family".to_owned()),
        (Part::Leg(_), _) => return Err("a leg without its program".to_owned()),
    }
    Ok(())
}

fn merge<M: Message>(result: &mut M, more: &M) -> Result<(), String> {
    result.merge(more.encode_to_vec().as_slice()).map_err(|error| error.to_string())
}

/// The first part holds everything but lists without a narrow bound, the others
/// pieces of those.
fn split_path(mut path: PathResult) -> Vec<PathResult> {
    let obstacles = path.space.as_mut().map(|space| mem::take(&mut space.obstacles));
    let lists = [&mut path.path, &mut path.smoothed_path].map(mem::take);
    let (curve, edges) = (mem::take(&mut path.curve), mem::take(&mut path.tree_edges));
    let mut parts = vec![path];
    parts.extend(pieces(obstacles.unwrap_or_default(), |obstacles| PathResult {
        space: Some(Space { obstacles, ..<_>::default() }),
        ..<_>::default()
    }));
    let [path, smoothed_path] = lists;
    parts.extend(pieces(path, |path| PathResult { path, ..<_>::default() }));
    parts.extend(pieces(smoothed_path, |smoothed_path| PathResult {
        smoothed_path,
        ..<_>::default()
    }));
    parts.extend(pieces(curve, |curve| PathResult { curve, ..<_>::default() }));
    parts.extend(pieces(edges, |tree_edges| PathResult { tree_edges, ..<_>::default() }));
    parts
}

/// A list in parts of few enough elements: each has 12 coordinates, six times at
/// most.
fn pieces<T: Clone>(list: Vec<T>, part: impl Fn(Vec<T>) -> PathResult) -> Vec<PathResult> {
    const ELEMENTS: usize = 1 << 10;
    list.chunks(ELEMENTS).map(|piece| part(piece.to_vec())).collect()
}

/// Chunks under construction.
struct Parts {
    full: Vec<TrajectoryResult>,
    current: TrajectoryResult,
    bytes: usize,
}

impl Parts {
    /// The message that takes the next `bytes`.
    fn room(&mut self, bytes: usize) -> &mut TrajectoryResult {
        if self.bytes > 0 && self.bytes + bytes > CHUNK_BYTES {
            self.full.push(mem::take(&mut self.current));
            self.bytes = 0;
        }
        self.bytes += bytes;
        &mut self.current
    }

    /// The message that takes `element` of a list.
    fn room_for(&mut self, element: &impl Message) -> &mut TrajectoryResult {
        // Tag and length of the element in its list.
        const OVERHEAD: usize = 8;
        self.room(element.encoded_len() + OVERHEAD)
    }
}

/// The first part has what cannot grow; lists follow until it is full, then in
/// more parts.
fn split_trajectory(mut result: TrajectoryResult) -> Vec<TrajectoryResult> {
    let durations = mem::take(&mut result.durations);
    let waypoint_times = mem::take(&mut result.waypoint_times);
    let waypoints = mem::take(&mut result.waypoints);
    let trajectory = result.trajectory.as_mut().map(mem::take).unwrap_or_default();
    let certificate = result.certificate.as_mut();
    let violations = certificate.map(|it| mem::take(&mut it.violations)).unwrap_or_default();
    let binding = result.metrics.as_mut().map(|it| mem::take(&mut it.binding)).unwrap_or_default();
    let front = result.pareto.as_mut().map(|it| mem::take(&mut it.points)).unwrap_or_default();
    let per_joint = mem::take(&mut result.per_joint);
    let convergence = mem::take(&mut result.convergence);

    let bytes = result.encoded_len();
    let mut parts = Parts { full: Vec::new(), current: result, bytes };
    let number = mem::size_of::<f64>();
    for duration in durations {
        parts.room(number).durations.push(duration);
    }
    for time in waypoint_times {
        parts.room(number).waypoint_times.push(time);
    }
    for waypoint in waypoints {
        parts.room_for(&waypoint).waypoints.push(waypoint);
    }
    let Trajectory { breakpoints, pieces } = trajectory;
    for breakpoint in breakpoints {
        parts.room(number).trajectory.get_or_insert_default().breakpoints.push(breakpoint);
    }
    for piece in pieces {
        parts.room_for(&piece).trajectory.get_or_insert_default().pieces.push(piece);
    }
    for violation in violations {
        let part = parts.room_for(&violation);
        part.certificate.get_or_insert_default().violations.push(violation);
    }
    for limit in binding {
        parts.room_for(&limit).metrics.get_or_insert_default().binding.push(limit);
    }
    for point in front {
        parts.room_for(&point).pareto.get_or_insert_default().points.push(point);
    }
    for joint in per_joint {
        parts.room_for(&joint).per_joint.push(joint);
    }
    for point in convergence {
        parts.room_for(&point).convergence.push(point);
    }
    parts.full.push(parts.current);
    parts.full
}
