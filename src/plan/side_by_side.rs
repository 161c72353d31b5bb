//! Long pieces of work on threads of their own.

use std::sync::atomic::{AtomicUsize, Ordering};
use std::thread;

/// The results of `work` for 0 to `count - 1`, in this order, from as many
/// threads as the pool has.
///
/// The threads are not the pool's own: a run may last minutes, and the short
/// pieces of work that other jobs leave to the pool would wait for it.
pub fn side_by_side<T: Send>(count: usize, work: impl Fn(usize) -> T + Sync) -> Vec<T> {
    let next = AtomicUsize::new(0);
    let take = || -> Vec<(usize, T)> {
        let indices = std::iter::repeat_with(|| next.fetch_add(1, Ordering::Relaxed));
        indices.take_while(|&index| index < count).map(|index| (index, work(index))).collect()
    };
    let helpers = rayon::current_num_threads().min(count).saturating_sub(1);
    let mut done = thread::scope(|scope| {
        // A thread that cannot be had leaves its share to the others.
        let spawn = |_| thread::Builder::new().spawn_scoped(scope, take).ok();
        let helpers: Vec<_> = (0..helpers).filter_map(spawn).collect();
        let mut done = take();
        for helper in helpers {
            done.extend(helper.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic)));
        }
        done
    });
    done.sort_unstable_by_key(|(index, _)| *index);
    done.into_iter().map(|(_, result)| result).collect()
}
