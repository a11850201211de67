//! Open Job Description: the format of jobs that several schedulers read.
//!
//! Source: Open Job Description, template schemas, revision 2023-09.

use anyhow::Context;
use serde_json::{Value, json};

use super::Job;

/// Time that a task has to write its checkpoint when it is cancelled, s.
const NOTICE: u32 = 30;

/// A job template, in JSON.
pub(super) fn template(job: &Job) -> anyhow::Result<String> {
    let job = &job.with_words(literal);
    let tasks = json!({
        "name": job.name(),
        "parameterSpace": { "taskParameterDefinitions": [{ "name": "Number", "type": "INT", "range": job.numbers() }] },
        "script": script(job, &job.task("{{Task.Param.Number}}")),
    });
    let merge = |command: String| json!({ "name": "merge", "dependencies": [{ "dependsOn": job.name() }], "script": script(job, &command) });
    let steps: Vec<_> = std::iter::once(tasks).chain(job.merge().map(merge)).collect();
    let template = json!({ "specificationVersion": "jobtemplate-2023-09", "name": "mlt", "steps": steps });
    Ok(serde_json::to_string_pretty(&template).context("cannot encode the template")? + "\n")
}

/// A step that runs a command of a shell in the job's folder.
fn script(job: &Job, command: &str) -> Value {
    json!({
        "embeddedFiles": [{ "name": "Run", "type": "TEXT", "data": format!("set -eu\ncd {}\nexec {command}\n", job.folder) }],
        "actions": {
            "onRun": {
                "command": "sh",
                "args": ["{{Task.File.Run}}"],
                "cancelation": { "mode": "NOTIFY_THEN_TERMINATE", "notifyPeriodInSeconds": NOTICE },
            },
        },
    })
}

/// Quoted words of a shell that hold no `{{`, which would begin a reference: a brace is always between single quotes, which end and begin
/// again behind it.
fn literal(words: &str) -> String {
    words.replace('{', "{''")
}
