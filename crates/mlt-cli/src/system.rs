//! Resources of the machine: memory left, processor time used.

use std::fs;

use anyhow::anyhow;
use mlt_core::memory::{Memory, Shortage};

/// Addresses that a thread reserves for its stack and its share of the heap, bytes: 2 MiB and glibc's 64 MiB.
const ADDRESSES_PER_THREAD: u64 = 66 << 20;

/// The memory that this process may still take without the system ending it; unlimited where the system does not say.
pub fn memory() -> Memory {
    available_memory().map_or_else(Memory::unlimited, Memory::of)
}

/// Refuses work that needs more memory than is available.
///
/// `bytes`: what the work will allocate; `what`: what it is for, the subject of the message.
pub fn require_memory(bytes: u64, what: &str) -> anyhow::Result<()> {
    check_memory(&memory(), bytes, what)
}

/// The same within a budget, for what is soon freed.
pub fn check_memory(memory: &Memory, bytes: u64, what: &str) -> anyhow::Result<()> {
    memory.check(bytes).map_err(|shortage| too_large(what, shortage))
}

/// The same for good: nobody else gets that memory.
pub fn take_memory(memory: &Memory, bytes: u64, what: &str) -> anyhow::Result<()> {
    memory.take(bytes).map_err(|shortage| too_large(what, shortage))
}

fn too_large(what: &str, shortage: Shortage) -> anyhow::Error {
    anyhow!("{what} {shortage}; choose a smaller size")
}

/// Memory that can be allocated without swapping, bytes: the least of the system's, of what is left of the control group's
/// limit, and of what the process's own limits (`ulimit -v`, `-d`) leave.
fn available_memory() -> Option<u64> {
    let system = available_in_meminfo(&fs::read_to_string("/proc/meminfo").ok()?)?;
    let address_space = process_rest("Max address space", "VmSize:").map(beside_threads);
    let data = process_rest("Max data size", "VmData:");
    [Some(system), control_group_rest(), address_space, data].into_iter().flatten().min()
}

/// Rest of an address space when the threads of two pools have taken theirs, or half of it if that is more.
fn beside_threads(bytes: u64) -> u64 {
    let threads = 2 * std::thread::available_parallelism().map_or(1, usize::from) as u64;
    bytes.saturating_sub(threads * ADDRESSES_PER_THREAD).max(bytes / 2)
}

/// Rest under a limit of the process, beside what it holds of that kind.
fn process_rest(limit: &str, held: &str) -> Option<u64> {
    let number = |text: &str| text.split_whitespace().next()?.parse::<u64>().ok();
    let line = |file: &str, key: &str| {
        let text = fs::read_to_string(file).ok()?;
        text.lines().find_map(|line| number(line.strip_prefix(key)?))
    };
    let limit = line("/proc/self/limits", limit)?;
    Some(limit.saturating_sub(1024 * line("/proc/self/status", held)?))
}

fn available_in_meminfo(meminfo: &str) -> Option<u64> {
    let line = meminfo.lines().find_map(|line| line.strip_prefix("MemAvailable:"))?;
    let kibibytes: u64 = line.trim().strip_suffix("kB")?.trim().parse().ok()?;
    kibibytes.checked_mul(1024)
}

/// Rest under a container's memory limit; page cache that the kernel can drop counts as free.
fn control_group_rest() -> Option<u64> {
    let read = |name: &str| fs::read_to_string(format!("/sys/fs/cgroup/{name}")).ok()?.trim().parse::<u64>().ok();
    let reclaimable = fs::read_to_string("/sys/fs/cgroup/memory.stat")
        .ok()
        .and_then(|stat| stat.lines().find_map(|line| line.strip_prefix("inactive_file ")?.trim().parse::<u64>().ok()))
        .unwrap_or(0);
    Some(read("memory.max")?.saturating_sub(read("memory.current")?.saturating_sub(reclaimable)))
}

/// The processor's name if the system says it, the number of processors, the system.
pub(crate) fn machine() -> String {
    let text = fs::read_to_string("/proc/cpuinfo").unwrap_or_default();
    let name =
        text.lines().find_map(|line| line.strip_prefix("model name")?.split_once(':')).map(|(_, name)| name.trim());
    let processors = std::thread::available_parallelism().map_or(1, usize::from);
    let processors = if processors == 1 { "1 processor".to_owned() } else { format!("{processors} processors") };
    let system = format!("{} {}", std::env::consts::OS, std::env::consts::ARCH);
    name.into_iter().chain([&*processors, &*system]).collect::<Vec<_>>().join(", ")
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
