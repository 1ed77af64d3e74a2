//! How many threads do the work.

use anyhow::{Context, Result};

/// The processors that Slurm lets a task have, where it has been told how many a task needs.
const CPUS_OF_TASK: &str = "SLURM_CPUS_PER_TASK";

/// As many threads as are asked for, or as Slurm gives.
///
/// # Errors
/// If the system does not start them.
pub fn start(threads: Option<u32>) -> Result<rayon::ThreadPool> {
    let mut pool = rayon::ThreadPoolBuilder::new();
    if let Some(threads) = count(threads) {
        pool = pool.num_threads(threads as usize);
    }
    pool.build().context("cannot start the threads")
}

/// How many threads are to be used, if anybody says: who asks for the work, or who has started the program.
pub fn count(threads: Option<u32>) -> Option<u32> {
    threads.or_else(|| std::env::var(CPUS_OF_TASK).ok()?.parse().ok().filter(|n| (1..=4096).contains(n)))
}
