//! The report of `mlt bench` in a real browser, as wide as a desk's and as a phone's, light and dark: charts are there, the swipe moves,
//! nothing is wider than the page, the console stays empty.
//!
//! Needs Chromium in PATH, as Debian's package `chromium`; without one it says so and tests nothing.

use std::{
    env, fs,
    path::{Path, PathBuf},
    process::{Command, Output},
};

use tempfile::TempDir;

/// Added to a copy of the page: uses it as a reader would and tells the page around it what happened.
const READER: &str = r##"<script>
addEventListener("load", () => {
  const found = [];
  const say = (name, value) => found.push(`${name}=${value}`);
  const charts = [...document.querySelectorAll("svg.chart")];
  say("charts", charts.length);
  say("drawn", charts.every((chart) => chart.getBoundingClientRect().height > 50 && chart.children.length > 5));
  say("images", [...document.images].every((image) => image.complete && image.naturalWidth === 16));
  const swipe = document.querySelector(".swipe");
  const over = swipe.querySelector(".over");
  const slider = swipe.querySelector("input");
  const cut = () => getComputedStyle(over).clipPath;
  const before = cut();
  slider.value = 20;
  slider.dispatchEvent(new Event("input"));
  say("moved", before !== cut() && cut().includes("80%"));
  const [left, right] = swipe.querySelectorAll("select");
  say("choices", left.options.length === 5 && right.options.length === 5);
  const source = over.src;
  left.selectedIndex = 0;
  left.dispatchEvent(new Event("change"));
  say("chosen", over.src !== source && over.src === document.querySelector(".picture").src);
  say("fits", document.documentElement.scrollWidth <= innerWidth);
  const tables = [...document.querySelectorAll(".scroll")];
  say("tables", tables.length > 3 && tables.every((table) => table.clientWidth <= innerWidth));
  const brightness = (colour) => colour.match(/[\d.]+/g).slice(0, 3).reduce((sum, part) => sum + Number(part), 0) / 765;
  const page = brightness(getComputedStyle(document.body).backgroundColor);
  say("page", page > 0.9 ? "light" : page < 0.2 ? "dark" : page);
  const legible = (selector, property) => [...document.querySelectorAll(selector)].every(
    (part) => Math.abs(brightness(getComputedStyle(part)[property]) - page) > 0.25
  );
  say("legible", legible("p, td, th, dd, a", "color") && legible("svg text", "fill") && legible(".median", "stroke"));
  parent.postMessage(`READER ${found.join(" ")} END`, "*");
});
</script>"##;

fn chromium() -> Option<PathBuf> {
    let folders: Vec<PathBuf> = env::split_paths(&env::var_os("PATH")?).collect();
    let names = ["chromium", "chromium-browser", "google-chrome"];
    names.iter().flat_map(|name| folders.iter().map(move |folder| folder.join(name))).find(|path| path.is_file())
}

fn report(folder: &TempDir) -> String {
    let line = "bench cornell --methods mlt:2x2:rounds=2,pt --seeds 3 --mutations 32,64 --reference-samples 8 --size 16x16 -q -o out";
    let mut mlt = Command::new(env!("CARGO_BIN_EXE_mlt"));
    let status = mlt.current_dir(folder.path()).args(line.split_whitespace()).status().expect("mlt starts");
    assert!(status.success());
    fs::read_to_string(folder.path().join("out/report.html")).expect("the report")
}

/// Shows a page in a frame of a width, since a browser's own window cannot be as narrow as a phone's.
const FRAME: &str = r#"<!DOCTYPE html><body style="margin: 0"><iframe src="page.html" width="WIDTH" height="900" style="border: 0"></iframe>
<script>addEventListener("message", (event) => document.body.append(event.data));</script>"#;

/// Opens a page in a frame of this width; what it told on standard output, its console on standard error.
fn open(chromium: &Path, folder: &TempDir, page: &str, width: u32, option: &str) -> Output {
    let file = |name: &str, text: &str| {
        let path = folder.path().join(name);
        fs::write(&path, text).expect("written");
        path
    };
    file("page.html", page);
    let frame = file("frame.html", &FRAME.replace("WIDTH", &width.to_string()));
    Command::new(chromium)
        .args(["--headless", "--no-sandbox", "--disable-gpu", "--disable-dev-shm-usage", "--enable-logging=stderr"])
        .args(["--window-size=1280,900", "--virtual-time-budget=5000", "--dump-dom", option])
        .arg(format!("--user-data-dir={}", folder.path().join("profile").display()))
        .arg(format!("file://{}", frame.display()))
        .output()
        .expect("Chromium starts")
}

/// The page's output on the console.
fn console(output: &Output) -> Vec<String> {
    let text = String::from_utf8_lossy(&output.stderr);
    text.lines().filter(|line| line.contains("CONSOLE")).map(str::to_owned).collect()
}

#[test]
fn the_report_works_in_a_browser() {
    let Some(chromium) = chromium() else {
        eprintln!("NOT TESTED: no Chromium in PATH, so the report was not opened; install Debian's package chromium");
        return;
    };
    let folder = tempfile::tempdir().expect("a folder");
    let page = report(&folder);
    let read = page.replace("</body>", &format!("{READER}</body>"));
    for (width, option, shade) in [(1280, "--mute-audio", "light"), (400, "--force-dark-mode", "dark")] {
        let output = open(&chromium, &folder, &read, width, option);
        let document = String::from_utf8_lossy(&output.stdout);
        let found =
            document.split_once("READER ").and_then(|(_, rest)| rest.split_once(" END")).map(|(found, _)| found);
        let expected = format!(
            "charts=3 drawn=true images=true moved=true choices=true chosen=true fits=true tables=true page={shade} legible=true"
        );
        assert_eq!(found, Some(&*expected), "Chromium says: {}", String::from_utf8_lossy(&output.stderr));
        assert_eq!(console(&output), Vec::<String>::new());
    }

    // The negative control: an error on the page is seen, and so is an address that the page may not load.
    let broken = page.replace("</body>", "<script>missing();</script><img src=\"http://localhost:9/a.png\"></body>");
    let errors = console(&open(&chromium, &folder, &broken, 1280, "--mute-audio")).join("\n");
    assert!(errors.contains("missing is not defined") && errors.contains("Content Security Policy"), "{errors}");
}

/// Holds without a browser as well: the page names nothing that lies outside of it.
#[test]
fn the_report_is_one_file() {
    let folder = tempfile::tempdir().expect("a folder");
    let page = report(&folder);
    for outside in ["http:", "https:", "file:", "src=\"/", "@import", "url("] {
        assert!(!page.contains(outside), "{outside}");
    }
    for (part, count) in [("<svg class=\"chart", 3), ("src=\"data:image/png;base64,", 5)] {
        assert_eq!(page.matches(part).count(), count, "{part}");
    }
}
