//! Memory that this process can still get, by what the system says.

use super::Bytes;
use rustix::process::{Resource, getrlimit};
use std::fmt;
use std::fs;
use std::path::{Path, PathBuf};

/// Memory that this process can still get.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Available {
    /// How much (bytes).
    pub bytes: u64,
    /// What sets the limit.
    limit: Limit,
}

/// What limits memory.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Limit {
    Machine,
    ControlGroup,
    AddressSpace,
    Data,
}

impl fmt::Display for Available {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        let what = match self.limit {
            Limit::Machine => "on this machine",
            Limit::ControlGroup => "in this control group (a container's limit)",
            Limit::AddressSpace => "within the limit on address space (`ulimit -v`)",
            Limit::Data => "within the limit on data (`ulimit -d`)",
        };
        write!(f, "{} are free {what}", Bytes(self.bytes))
    }
}

/// Memory that this process can still get; `None` where nothing is known of it.
pub fn available() -> Option<Available> {
    let root = Path::new("/");
    let status = fs::read_to_string("/proc/self/status").unwrap_or_default();
    let left = |resource, used: &str| Some(getrlimit(resource).current?.saturating_sub(field(&status, used).unwrap_or(0)));
    let limits = [
        (Limit::Machine, machine(root)),
        (Limit::ControlGroup, control_groups(root)),
        (Limit::AddressSpace, left(Resource::As, "VmSize:")),
        (Limit::Data, left(Resource::Data, "VmData:")),
    ];
    let known = limits.into_iter().filter_map(|(limit, bytes)| Some(Available { bytes: bytes?, limit }));
    known.min_by_key(|a| a.bytes)
}

/// A line `name   123 kB`, in bytes.
fn field(text: &str, name: &str) -> Option<u64> {
    let line = text.lines().find_map(|l| l.strip_prefix(name))?;
    line.split_whitespace().next()?.parse::<u64>().ok()?.checked_mul(1024)
}

/// Memory and swap space that can be had without ending anything.
fn machine(root: &Path) -> Option<u64> {
    let text = fs::read_to_string(root.join("proc/meminfo")).ok()?;
    Some(field(&text, "MemAvailable:")? + field(&text, "SwapFree:").unwrap_or(0))
}

/// The least that a control group of this process has left, its parents included (Linux, cgroups(7): versions 1 and 2).
fn control_groups(root: &Path) -> Option<u64> {
    let groups = fs::read_to_string(root.join("proc/self/cgroup")).ok()?;
    let mut least: Option<u64> = None;
    for line in groups.lines() {
        // number:controllers:path
        let mut parts = line.splitn(3, ':').skip(1);
        let (Some(controllers), Some(path)) = (parts.next(), parts.next()) else { continue };
        let (mount, files) = match controllers {
            "" => ("sys/fs/cgroup", ["memory.max", "memory.current", "inactive_file"]),
            c if c.split(',').any(|c| c == "memory") => {
                ("sys/fs/cgroup/memory", ["memory.limit_in_bytes", "memory.usage_in_bytes", "total_inactive_file"])
            }
            _ => continue,
        };
        let mount = root.join(mount);
        // Inside a container the path may be that outside of it, and only the mount itself be there.
        let mut group: PathBuf = mount.join(path.trim_start_matches('/'));
        while group.starts_with(&mount) {
            if let Some(left) = left_in(&group, files) {
                least = Some(least.map_or(left, |l| l.min(left)));
            }
            group.pop();
        }
    }
    least
}

/// What a control group has left: its limit without what is used, but for what is kept of files only in case it is read again.
fn left_in(group: &Path, [limit, usage, kept]: [&str; 3]) -> Option<u64> {
    let number = |name: &str| fs::read_to_string(group.join(name)).ok()?.trim().parse::<u64>().ok();
    // No limit is the word `max`, or a number that no machine has.
    let limit = number(limit).filter(|l| *l < 1 << 60)?;
    let statistics = fs::read_to_string(group.join("memory.stat")).unwrap_or_default();
    let kept = statistics.lines().filter_map(|l| l.split_once(' ')).find(|(name, _)| *name == kept);
    let kept = kept.and_then(|(_, n)| n.trim().parse::<u64>().ok()).unwrap_or(0);
    Some(limit.saturating_sub(number(usage)?.saturating_sub(kept)))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A folder that looks like the root of a system.
    fn system(files: &[(&str, &str)]) -> tempfile::TempDir {
        let root = tempfile::tempdir().expect("a temporary folder");
        for (name, text) in files {
            let path = root.path().join(name);
            fs::create_dir_all(path.parent().expect("it lies in the root")).expect("the folder can be written");
            fs::write(path, text).expect("the folder can be written");
        }
        root
    }

    #[test]
    fn a_machine_has_what_is_available_and_its_swap_space() {
        let root = system(&[("proc/meminfo", "MemTotal: 100 kB\nMemAvailable:     40 kB\nSwapFree:  2 kB\n")]);
        assert_eq!(machine(root.path()), Some(42 * 1024));
        assert_eq!(machine(system(&[]).path()), None);
    }

    #[test]
    fn the_tightest_control_group_counts() {
        let two = [
            ("proc/self/cgroup", "0::/user/job\n"),
            ("sys/fs/cgroup/user/job/memory.max", "max\n"),
            ("sys/fs/cgroup/user/job/memory.current", "500\n"),
            ("sys/fs/cgroup/user/memory.max", "10000\n"),
            ("sys/fs/cgroup/user/memory.current", "3000\n"),
            ("sys/fs/cgroup/user/memory.stat", "anon 5\ninactive_file 1000\n"),
            ("sys/fs/cgroup/memory.max", "90000\n"),
            ("sys/fs/cgroup/memory.current", "4000\n"),
        ];
        assert_eq!(control_groups(system(&two).path()), Some(8000));
        // The first version; the path is that of the host.
        let one = [
            ("proc/self/cgroup", "5:cpu:/\n4:memory:/docker/abc\n"),
            ("sys/fs/cgroup/memory/memory.limit_in_bytes", "7000\n"),
            ("sys/fs/cgroup/memory/memory.usage_in_bytes", "6000\n"),
            ("sys/fs/cgroup/memory/memory.stat", "inactive_file 1\ntotal_inactive_file 500\n"),
        ];
        assert_eq!(control_groups(system(&one).path()), Some(1500));
        let none =
            [("proc/self/cgroup", "4:memory:/\n"), ("sys/fs/cgroup/memory/memory.limit_in_bytes", "9223372036854771712\n")];
        assert_eq!(control_groups(system(&none).path()), None);
    }
}
