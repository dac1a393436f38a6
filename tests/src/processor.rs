//! How much of the processors was used, where the system tells.

/// Processor time of all processes that this one has waited for, in seconds; none where the system does not tell.
#[must_use]
pub fn processor_time_of_children() -> Option<f64> {
    times("self", 13)
}

/// Processor time of a running process, in seconds; none where the system does not tell.
#[must_use]
pub fn processor_time(process: u32) -> Option<f64> {
    times(&process.to_string(), 11)
}

/// Two numbers after each other in a process's `stat`, user and system time in 1/100 s, counted from the one after its name,
/// which may hold anything.
fn times(process: &str, first: usize) -> Option<f64> {
    let statistics = std::fs::read_to_string(format!("/proc/{process}/stat")).ok()?;
    let fields = statistics.rsplit(')').next()?.split_whitespace().skip(first).take(2);
    Some(fields.filter_map(|field| field.parse::<f64>().ok()).sum::<f64>() / 100.0)
}
