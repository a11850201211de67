//! `mlt bench`, from outside: its files, going on after a stop, reports that repeat, and what it says about bad input.

use std::{
    collections::HashSet,
    fs,
    path::Path,
    process::{Command, Output},
};

use mlt_cli::{image::Image, output::exr};
use serde_json::Value;
use tempfile::TempDir;

/// A study of a second: two methods, two budgets, two seeds.
const SMALL: &str = "bench cornell --methods mlt:2x2:weights=power:rounds=2,pt --seeds 2 --mutations 32,64 --reference-samples 8 --size 16x16";

fn command(folder: &TempDir, line: &str) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_mlt"));
    command.current_dir(folder.path()).args(line.split_whitespace());
    command
}

fn mlt(folder: &TempDir, line: &str) -> Output {
    command(folder, line).output().expect("mlt starts")
}

fn stderr(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

fn made(folder: &TempDir, line: &str) -> Output {
    let output = mlt(folder, line);
    assert!(output.status.success(), "{line}: {}", stderr(&output));
    output
}

fn folder() -> TempDir {
    tempfile::tempdir().expect("a folder")
}

fn text(folder: &TempDir, name: &str) -> String {
    fs::read_to_string(folder.path().join(name)).expect(name)
}

fn rows(folder: &TempDir, name: &str) -> Vec<Value> {
    let json: Value = serde_json::from_str(&text(folder, name)).expect("JSON");
    json["rows"].as_array().expect("rows").clone()
}

/// Lines of progress that tell of a run.
fn runs_made(output: &Output) -> usize {
    stderr(output).lines().filter(|line| line.starts_with('[')).count()
}

#[test]
fn every_run_is_a_row_in_each_file() {
    let folder = folder();
    let output = made(&folder, &format!("{SMALL} -o out"));
    assert_eq!(runs_made(&output), 8);

    let rows = rows(&folder, "out/results.json");
    assert_eq!(rows.len(), 8);
    let key = |row: &Value| format!("{} {} {}", row["method"], row["budget"], row["seed"]);
    assert_eq!(rows.iter().map(key).collect::<HashSet<_>>().len(), 8);
    for row in &rows {
        for name in ["seconds", "relative_diff", "rel_mse", "mape", "flip", "rays", "b"] {
            assert!(row[name].as_f64().expect(name) > 0.0, "{name}: {row}");
        }
        let per_pixel = if row["budget"] == "32 per pixel" { 32 } else { 64 };
        let work = if row["method"] == "pt" { &row["samples"] } else { &row["mutations"] };
        assert_eq!(work.as_u64(), Some(per_pixel * 256), "{row}");
        assert_eq!(row["strata_list"].as_array().map(Vec::len), Some(if row["method"] == "pt" { 0 } else { 4 }));
    }

    let csv = text(&folder, "out/results.csv");
    let lines: Vec<Vec<&str>> = csv.lines().map(|line| line.split(',').collect()).collect();
    assert_eq!(lines.len(), 9);
    let column = lines[0].iter().position(|name| *name == "rel_mse").expect("a column");
    for (line, row) in lines[1..].iter().zip(&rows) {
        assert_eq!((line.len(), line[column].parse::<f64>().ok()), (lines[0].len(), row["rel_mse"].as_f64()));
    }
}

/// Charts stand by themselves, too: for a document, light and dark.
#[test]
fn charts_are_files() {
    let folder = folder();
    made(&folder, &format!("{SMALL} -o out"));
    for axis in ["rays", "work"] {
        let svg = text(&folder, &format!("out/charts/cornell.{axis}.svg"));
        assert!(
            svg.starts_with("<svg xmlns=\"http://www.w3.org/2000/svg\"") && svg.trim_end().ends_with("</svg>"),
            "{svg}"
        );
        assert!(svg.contains("prefers-color-scheme: dark") && svg.contains("class=\"median m0\""), "{svg}");
        assert_eq!(svg.matches("<style>").count(), 1);
    }
    assert!(!folder.path().join("out/charts/cornell.seconds.svg").exists());
}

#[test]
fn the_same_study_makes_the_same_report() {
    let (one, other) = (folder(), folder());
    let report = |folder: &TempDir, line: &str| {
        made(folder, line);
        text(folder, "out/report.html")
    };
    let line = format!("{SMALL} --threads 1 -q -o out");
    let first = report(&one, &line);
    assert_eq!(first, report(&other, &line));
    assert!(!first.contains("seconds"), "a count budget's report tells of time");
    assert!(first.contains(&format!("<dd>mlt {line}</dd>")), "the report does not tell its command");

    // The results do not depend on the number of threads, which is told.
    made(&other, &line.replace("--threads 1", "--threads 3").replace("-o out", "-o more"));
    let errors = |folder, name| rows(folder, name).iter().map(|row| row["rel_mse"].clone()).collect::<Vec<_>>();
    assert_eq!(errors(&one, "out/results.json"), errors(&other, "more/results.json"));
    assert!(first.contains("<dt>Threads</dt><dd>1</dd>"));
    assert!(text(&other, "more/report.html").contains("<dt>Threads</dt><dd>3</dd>"));

    // The negative control: another seed more is another report.
    assert_ne!(first, report(&one, &line.replace("--seeds 2", "--seeds 3")));
}

#[test]
fn the_report_begins_with_who_is_ahead() {
    let folder = folder();
    made(&folder, &format!("{} --threads 1 -q -o out", SMALL.replace("--seeds 2", "--seeds 4")));
    let report = text(&folder, "out/report.html");
    let [lead, scene] = ["<h2>Least error</h2>", "<h2>cornell</h2>"].map(|part| report.find(part).expect(part));
    assert!(lead < scene);
    assert!(["<td>ahead</td>", "<td>not decided</td>"].iter().any(|verdict| report[lead..scene].contains(verdict)));
    // Two budgets make no slope, and so the lines' ends have none.
    assert!(report.contains(">pt</text>"));
}

#[test]
fn a_study_goes_on_where_it_was_cut() {
    let folder = folder();
    let line = format!("{SMALL} -o out");
    made(&folder, &line);
    let report = text(&folder, "out/report.html");
    assert_eq!(runs_made(&made(&folder, &line)), 0);

    // Three whole lines and a half one are left: five runs are missing.
    let journal = text(&folder, "out/runs.jsonl");
    let ends: Vec<usize> = journal.match_indices('\n').map(|(at, _)| at).collect();
    fs::write(folder.path().join("out/runs.jsonl"), &journal[..ends[2] + 40]).expect("cut");
    assert_eq!(runs_made(&made(&folder, &line)), 5);
    assert_eq!(text(&folder, "out/report.html"), report);

    // An image that has gone is made again, and with it its run.
    fs::remove_file(folder.path().join("out/images/cornell-pt-64_per_pixel.exr")).expect("there");
    assert_eq!(runs_made(&made(&folder, &line)), 1);
    assert_eq!(text(&folder, "out/report.html"), report);

    // A larger study takes over what there is.
    assert_eq!(runs_made(&made(&folder, &line.replace("--seeds 2", "--seeds 3"))), 4);
    assert_eq!(rows(&folder, "out/results.json").len(), 12);
}

#[test]
fn budgets_in_rays_and_time_are_met() {
    let folder = folder();
    made(&folder, "bench cornell --methods mlt,pt --seeds 1 --rays 200 --reference-samples 4 --size 16x16 -q -o rays");
    for row in rows(&folder, "rays/results.json") {
        let rays = row["rays"].as_f64().expect("rays") / 256.0;
        assert!((150.0..260.0).contains(&rays), "{rays} rays per pixel: {row}");
    }
    made(&folder, "bench cornell --methods pt --seeds 1 --times 300ms --reference-samples 4 --size 16x16 -q -o time");
    let row = &rows(&folder, "time/results.json")[0];
    assert!(row["seconds"].as_f64().is_some_and(|seconds| seconds > 0.1), "{row}");
    assert!(text(&folder, "time/report.html").contains("Threads"));
}

#[test]
fn the_papers_table_has_its_rows_and_verdicts() {
    let folder = folder();
    let output = made(&folder, "bench --paper --size 8x8 --seeds 3 --reference-samples 20 -o paper");
    let table = String::from_utf8_lossy(&output.stdout).into_owned();
    for scene in ["ring", "cornell", "suzanne"] {
        assert_eq!(table.lines().filter(|line| line.starts_with(scene)).count(), 3, "{table}");
    }
    let json: Value = serde_json::from_str(&text(&folder, "paper/results.json")).expect("JSON");
    assert_eq!(json["paper"].as_array().map(Vec::len), Some(3));
    assert_eq!(json["paper"][0]["unstratified"]["paper_relative_diff"], 0.013);
    assert!(text(&folder, "paper/report.html").contains("The paper’s table"));
}

fn write_image(path: &Path, width: usize, value: f32) {
    let image = Image::new(width, width, vec![[value; 3]; width * width]).expect("an image");
    fs::write(path, exr::encode(&image, None, &[]).expect("encoded")).expect("written");
}

#[test]
fn a_reference_file_is_used_and_gives_the_size() {
    let folder = folder();
    write_image(&folder.path().join("grey.exr"), 12, 0.25);
    made(&folder, "bench cornell --methods pt --seeds 1 --mutations 1 --reference grey.exr -q -o out");
    assert_eq!(rows(&folder, "out/results.json")[0]["width"], 12);
}

#[test]
fn bad_input_is_one_sentence_and_renders_nothing() {
    let folder = folder();
    write_image(&folder.path().join("small.exr"), 4, 0.25);
    write_image(&folder.path().join("black.exr"), 16, 0.0);
    write_image(&folder.path().join("nan.exr"), 16, f32::NAN);
    fs::write(folder.path().join("file"), "").expect("written");
    let with = |more: &str| format!("{SMALL} {more}").replace("--reference-samples 8 ", "");
    for (line, code, part) in [
        ("bench -o out".into(), 2, "required"),
        ("bench cornell -o out".into(), 2, "required"),
        (SMALL.to_owned(), 2, "--output"),
        (format!("{SMALL} -o out").replace("pt", "photon"), 2, "invalid value 'photon'"),
        (format!("{SMALL} -o out").replace("2x2", "4x"), 2, "as in 4x4"),
        (format!("{SMALL} -o out").replace("mlt:2x2:weights=power:rounds=2", "pt"), 2, "given twice"),
        (format!("{SMALL} -o out").replace("cornell", "nowhere"), 2, "nowhere"),
        (format!("{SMALL} --paper -o out"), 2, "cannot be used with"),
        (format!("{SMALL} -o file"), 1, "file: cannot be created"),
        (with("-o out --reference none.exr"), 1, "none.exr"),
        (with("-o out --reference file"), 1, "file"),
        (with("-o out --reference small.exr"), 1, "small.exr: 4x4 pixels, but the renders have 16x16"),
        (with("-o out --reference black.exr"), 1, "black"),
        (with("-o out --reference nan.exr"), 1, "NaN"),
        (with("-o out --reference small.exr --reference black.exr"), 2, "2 references for 1 scenes"),
    ] {
        let output = mlt(&folder, &(line.clone() + " -q"));
        let text = stderr(&output);
        assert_eq!(output.status.code(), Some(code), "{line}: {text}");
        assert!(output.stdout.is_empty(), "{line}");
        assert!(text.starts_with("error: ") && text.lines().count() == 1 && text.contains(part), "{line}: {text}");
        assert!(!folder.path().join("out/report.html").exists(), "{line}");
    }
}

/// Ctrl-C between runs: what is finished is reported, and the same command goes on.
#[cfg(unix)]
#[test]
fn an_interrupted_study_goes_on() {
    use std::{
        io::{BufRead, BufReader},
        process::Stdio,
    };
    let folder = folder();
    let line = "bench cornell --methods pt --seeds 400 --mutations 4 --reference-samples 8 --size 16x16 -o out";
    let mut child = command(&folder, line).stderr(Stdio::piped()).stdout(Stdio::null()).spawn().expect("mlt starts");
    let mut lines = BufReader::new(child.stderr.take().expect("piped")).lines().map_while(Result::ok);
    assert!(lines.any(|line| line.starts_with("[3/400]")));
    let kill = Command::new("kill").args(["-INT", &child.id().to_string()]).status();
    assert!(kill.expect("kill starts").success());
    let rest: Vec<String> = lines.collect();
    assert_eq!(child.wait().expect("mlt ends").code(), Some(130));
    assert!(rest.last().is_some_and(|line| line.starts_with("error: interrupted")), "{rest:?}");

    let finished = rows(&folder, "out/results.json").len();
    assert!((3..400).contains(&finished), "{finished}");
    let small = line.replace("400", &(finished + 1).to_string());
    assert_eq!(runs_made(&made(&folder, &small)), 1);
}
