//! Time, as measurements need it.

/// Processor time that this program has taken so far on all its threads (s), which other programs disturb less than the clock on the
/// wall; where the system does not tell, the time since the first call.
pub fn processor_seconds() -> f64 {
    static START: std::sync::OnceLock<std::time::Instant> = std::sync::OnceLock::new();
    let elapsed = START.get_or_init(std::time::Instant::now).elapsed().as_secs_f64();
    // proc_pid_stat(5): fields 14 and 15, in hundredths of a second; names in field 2 may hold spaces.
    let stat = std::fs::read_to_string("/proc/self/stat").unwrap_or_default();
    let ticks = stat.rsplit_once(')').map(|(_, rest)| rest.split_whitespace().skip(11).take(2).map(str::parse::<f64>));
    match ticks.and_then(|t| t.collect::<Result<Vec<f64>, _>>().ok()) {
        Some(times) if times.len() == 2 => 0.01 * (times[0] + times[1]),
        _ => elapsed,
    }
}

/// The middle one of some values; NaN of none.
pub fn median(values: &[f64]) -> f64 {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    sorted.get(sorted.len() / 2).copied().unwrap_or(f64::NAN)
}
