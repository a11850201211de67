//! What the machine has: memory left, processor time used.

use std::fs;

use anyhow::bail;

const GIB: f64 = (1_u64 << 30) as f64;

/// Refuses work that needs more memory than is available, before the system ends the process for it.
///
/// `bytes`: what the work will allocate; `what`: what it is for, the subject of the message. Does nothing where the
/// system does not say how much memory it has.
pub fn require_memory(bytes: u64, what: &str) -> anyhow::Result<()> {
    match available_memory() {
        Some(available) if bytes > available => bail!(
            "{what} needs {:.1} GiB of memory and {:.1} GiB are available; choose a smaller size",
            bytes as f64 / GIB,
            available as f64 / GIB
        ),
        _ => Ok(()),
    }
}

/// Memory that can be allocated without swapping, bytes: the system's, or what is left of the control group's limit.
fn available_memory() -> Option<u64> {
    let system = available_in_meminfo(&fs::read_to_string("/proc/meminfo").ok()?)?;
    Some(control_group_rest().map_or(system, |rest| rest.min(system)))
}

fn available_in_meminfo(meminfo: &str) -> Option<u64> {
    let line = meminfo.lines().find_map(|line| line.strip_prefix("MemAvailable:"))?;
    let kibibytes: u64 = line.trim().strip_suffix("kB")?.trim().parse().ok()?;
    kibibytes.checked_mul(1024)
}

/// What a container's memory limit leaves, page cache that the kernel can drop counted as free.
fn control_group_rest() -> Option<u64> {
    let read = |name: &str| fs::read_to_string(format!("/sys/fs/cgroup/{name}")).ok()?.trim().parse::<u64>().ok();
    let reclaimable = fs::read_to_string("/sys/fs/cgroup/memory.stat")
        .ok()
        .and_then(|stat| stat.lines().find_map(|line| line.strip_prefix("inactive_file ")?.trim().parse::<u64>().ok()))
        .unwrap_or(0);
    Some(read("memory.max")?.saturating_sub(read("memory.current")?.saturating_sub(reclaimable)))
}

/// Processor time of all threads of this process so far, seconds; `None` where the system does not say.
pub fn cpu_seconds() -> Option<f64> {
    #[cfg(unix)]
    {
        let time = rustix::time::clock_gettime(rustix::time::ClockId::ProcessCPUTime);
        Some(time.tv_sec as f64 + time.tv_nsec as f64 * 1e-9)
    }
    #[cfg(not(unix))]
    None
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn memory_available_is_read_in_bytes() {
        let meminfo = "MemTotal:       16000 kB\nMemAvailable:    8000 kB\n";
        assert_eq!(available_in_meminfo(meminfo), Some(8000 * 1024));
        assert_eq!(available_in_meminfo("MemTotal: 16000 kB"), None);
    }

    #[cfg(target_os = "linux")]
    #[test]
    fn more_memory_than_exists_is_refused() {
        assert!(require_memory(1 << 20, "a small film").is_ok());
        let message = require_memory(1 << 60, "a film of 65536x65536").unwrap_err().to_string();
        assert!(message.starts_with("a film of 65536x65536 needs 1073741824.0 GiB"), "{message}");
    }

    #[cfg(unix)]
    #[test]
    fn processor_time_grows_with_work() {
        let before = cpu_seconds().expect("a clock");
        let sum: f64 = (0..20_000_000).map(|i| f64::from(i).sqrt()).sum();
        assert!(sum > 0.0 && cpu_seconds().expect("a clock") > before);
    }
}
