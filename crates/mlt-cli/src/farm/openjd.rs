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
    let parts = json!({
        "name": "Parts",
        "parameterSpace": {
            "taskParameterDefinitions": [{ "name": "Shard", "type": "INT", "range": format!("1-{}", job.tasks) }],
        },
        "script": script(job, &job.task("{{Task.Param.Shard}}")),
    });
    let merge = json!({
        "name": "Merge",
        "dependencies": [{ "dependsOn": "Parts" }],
        "script": script(job, &job.merge()),
    });
    let template = json!({ "specificationVersion": "jobtemplate-2023-09", "name": "mlt", "steps": [parts, merge] });
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
