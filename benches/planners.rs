//! Paths of a point in a plane on one core: how soon the first one is found, and
//! how short it is after a tenth of a second, beside what OMPL took from C++ as
//! the maps' file tells.
//!
//! The maps stand in `maps2d.json` in the folder that `TAKT_BENCH_DATA` names,
//! `../shared/bench` if it names none. `benches/peers/run.sh planners` runs OMPL
//! from Python beside it.

use std::error::Error;
use std::time::Instant;

use serde::Deserialize;
use serde_json::Value;
use takt::budget::Budget;
use takt::plan::path::{Obstacle, PointSpace, Space};
use takt::planner::{PathSolution, PlannerEntry, PlanningProblem, planner, solve};

#[derive(Deserialize)]
struct Maps {
    maps: Vec<Map>,
}

#[derive(Deserialize)]
struct Map {
    name: String,
    lower: Vec<f64>,
    upper: Vec<f64>,
    start: Vec<f64>,
    goal: Vec<f64>,
    obstacles: Vec<Obstacle>,
    /// Figures of OMPL by planner.
    ompl: Value,
}

/// How long and how short the paths of many seeds are.
struct Figures {
    microseconds: Vec<f64>,
    lengths: Vec<f64>,
}

impl Map {
    fn solve(
        &self,
        entry: &PlannerEntry,
        limit: Option<f64>,
        seed: u64,
    ) -> Option<(f64, PathSolution)> {
        let [lower, upper] = [&self.lower, &self.upper].map(Clone::clone);
        let space = Space { lower, upper, obstacles: self.obstacles.clone() };
        let problem = PlanningProblem {
            lower: space.lower.clone(),
            upper: space.upper.clone(),
            start: self.start.clone(),
            goal: self.goal.clone(),
        };
        let mut settings = entry.defaults().with("iterations", 1e8);
        if let Some(limit) = limit {
            settings = settings.with("time_limit_s", limit);
        } else if entry.anytime {
            settings = settings.with("first_path", 1.0);
        }
        let mut space = PointSpace::new(&space);
        let begun = Instant::now();
        let budget = Budget::default();
        let found =
            solve(entry, &settings, &problem, &mut space, seed, &budget, &mut |_| {}).ok()?;
        Some((begun.elapsed().as_secs_f64() * 1e6, found))
    }

    fn measure(&self, entry: &PlannerEntry, limit: Option<f64>, seeds: u64) -> Figures {
        let runs: Vec<(f64, PathSolution)> =
            (0..seeds).filter_map(|seed| self.solve(entry, limit, seed)).collect();
        let sorted = |mut values: Vec<f64>| {
            values.sort_by(f64::total_cmp);
            values
        };
        Figures {
            microseconds: sorted(runs.iter().map(|(time, _)| *time).collect()),
            lengths: sorted(runs.iter().map(|(_, found)| found.length).collect()),
        }
    }
}

fn share(sorted: &[f64], share: usize) -> f64 {
    sorted.get(sorted.len() * share / 100).copied().unwrap_or(f64::NAN)
}

fn main() -> Result<(), Box<dyn Error>> {
    let folder = std::env::var("TAKT_BENCH_DATA").unwrap_or("../shared/bench".to_owned());
    let text = std::fs::read_to_string(format!("{folder}/maps2d.json"))?;
    let maps: Maps = serde_json::from_str(&text)?;
    for map in &maps.maps {
        println!("{}: first path, median and 95th percentile of 999 seeds", map.name);
        for (name, peer) in [
            ("rrt_connect", "RRTConnect"),
            ("rrt", "RRT"),
            ("rrt_star", "RRTstar"),
            ("informed_rrt_star", "InformedRRTstar"),
        ] {
            let Some(entry) = planner(name) else { continue };
            let found = map.measure(entry, None, 999);
            let ompl = &map.ompl[peer];
            println!(
                "  {name:18} {:8.1} {:8.1} us, length {:7.2}; OMPL {:8.1} {:8.1} us, length {:7.2}",
                share(&found.microseconds, 50),
                share(&found.microseconds, 95),
                share(&found.lengths, 50),
                ompl["first_us_median"].as_f64().unwrap_or(f64::NAN),
                ompl["first_us_p95"].as_f64().unwrap_or(f64::NAN),
                ompl["first_length_median"].as_f64().unwrap_or(f64::NAN),
            );
        }
        println!("{}: length after 0.01 s and 0.1 s, median of 15 seeds", map.name);
        for (name, peer) in [
            ("informed_rrt_star", "InformedRRTstar"),
            ("rrt_star_smart", "RRTstar"),
            ("quick_rrt_star", "RRTstar"),
            ("rrt_star", "RRTstar"),
        ] {
            let Some(entry) = planner(name) else { continue };
            let [soon, later] =
                [0.01, 0.1].map(|limit| share(&map.measure(entry, Some(limit), 15).lengths, 50));
            println!(
                "  {name:18} {soon:9.4} {later:9.4}; OMPL's {peer} after 0.1 s {:9.3}, after 1 s {:9.3}",
                map.ompl[peer]["length_at_0_1s_median"].as_f64().unwrap_or(f64::NAN),
                map.ompl[peer]["length_at_1s_median"].as_f64().unwrap_or(f64::NAN),
            );
        }
    }
    Ok(())
}
