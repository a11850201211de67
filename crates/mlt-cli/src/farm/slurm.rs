//! Slurm: a job array, and a job that waits for it.

use super::Job;

/// A shell script that submits both jobs.
pub(super) fn script(job: &Job) -> String {
    let cpus = job.threads.map_or_else(String::new, |threads| format!(" --cpus-per-task={threads}"));
    // Slurm replaces %a and the like in names of files.
    let logs = job.parts.replace('%', "%%");
    format!(
        "\
#!/bin/sh
# Submits a render to Slurm: {tasks} parts, then their merge. Options of sbatch are its environment variables, as in
#   SBATCH_PARTITION=render SBATCH_TIMELIMIT=2:00:00 sh THIS
set -eu
cd {folder}
mkdir -p {parts}
parts=$(sbatch --parsable --job-name=mlt-parts --array=1-{tasks} --requeue --open-mode=append{cpus} \\
    --output={logs}/log-%a.txt <<'SCRIPT'
#!/bin/sh
exec {task}
SCRIPT
)
merge=$(sbatch --parsable --job-name=mlt-merge --dependency=\"afterok:${{parts%%;*}}\" --kill-on-invalid-dep=yes \\
    --output={logs}/log-merge.txt <<'SCRIPT'
#!/bin/sh
exec {merge}
SCRIPT
)
echo \"parts: job ${{parts%%;*}}; merge: job ${{merge%%;*}}\"
",
        tasks = job.tasks,
        folder = job.folder,
        parts = job.parts,
        task = job.task("\"$SLURM_ARRAY_TASK_ID\""),
        merge = job.merge(),
    )
}
