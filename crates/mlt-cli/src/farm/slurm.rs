//! Slurm: a job array, and a job that waits for it where there is something to merge.

use super::Job;

/// A shell script that submits them.
pub(super) fn script(job: &Job) -> String {
    let (folder, parts, name) = (&job.folder, &job.parts, job.name());
    let cpus = job.threads.map_or_else(String::new, |threads| format!(" --cpus-per-task={threads}"));
    let options = format!("--array={} --requeue --open-mode=append{cpus}", job.numbers());
    let tasks = submission(job, name, &options, "%a", &job.task("\"$SLURM_ARRAY_TASK_ID\""));
    let options = format!("--dependency=\"afterok:${{{name}%%;*}}\" --kill-on-invalid-dep=yes");
    let merge = job.merge().map(|command| submission(job, "merge", &options, "merge", &command));
    let told = if merge.is_some() { "; merge: job ${merge%%;*}" } else { "" };
    format!(
        "\
#!/bin/sh
# Submits a render to Slurm. Options of sbatch are its environment variables, as in
#   SBATCH_PARTITION=render SBATCH_TIMELIMIT=2:00:00 sh THIS
set -eu
cd {folder}
mkdir -p {parts}
{tasks}{merge}echo \"{name}: job ${{{name}%%;*}}{told}\"
",
        merge = merge.unwrap_or_default(),
    )
}

/// A command of a shell that submits a job and keeps its number under a name; `log`: what its log is told apart by.
fn submission(job: &Job, name: &str, options: &str, log: &str, command: &str) -> String {
    // Slurm replaces %a and the like in names of files.
    let logs = job.parts.replace('%', "%%");
    format!(
        "\
{name}=$(sbatch --parsable --job-name=mlt-{name} {options} \\
    --output={logs}/log-{log}.txt <<'SCRIPT'
#!/bin/sh
exec {command}
SCRIPT
)
"
    )
}
