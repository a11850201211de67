//! Seeing beside the image, from outside: channels, parts, previews, files on request.

use std::{
    fs,
    io::Read,
    net::TcpListener,
    path::Path,
    process::{Command, Output},
    thread,
};

use exr::prelude::*;
use mlt_cli::output::exr::read;
use serde_json::{Value, json};

fn run(folder: &Path, line: &str) -> Output {
    let output = Command::new(env!("CARGO_BIN_EXE_mlt")).current_dir(folder).args(line.split_whitespace()).output();
    output.expect("mlt starts")
}

fn made(folder: &Path, line: &str) -> String {
    let output = run(folder, line);
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(output.status.success(), "{line}: {said}");
    said
}

fn refused(folder: &Path, line: &str) -> String {
    let output = run(folder, line);
    assert_eq!(output.status.code(), Some(2), "{line}");
    String::from_utf8_lossy(&output.stderr).into_owned()
}

const RENDER: &str = "render cornell --size 24x16 --method pt --samples-per-pixel 8 --threads 1 -q";

/// Names and values of a file's channels.
fn channels(path: &Path) -> Vec<(String, Vec<f32>)> {
    let image = read_all_flat_layers_from_file(path).expect("an EXR");
    let list = &image.layer_data[0].channel_data.list;
    list.iter().map(|channel| (channel.name.to_string(), channel.sample_data.values_as_f32().collect())).collect()
}

#[test]
fn channels_have_the_names_that_viewers_know() {
    let folder = tempfile::tempdir().expect("a folder");
    made(folder.path(), &format!("{RENDER} -o plain.exr"));
    made(folder.path(), &format!("{RENDER} --aov depth,albedo,normal,position,stratum,stderr -o a.exr -o a.png"));
    let found = channels(&folder.path().join("a.exr"));
    let names: Vec<_> = found.iter().map(|channel| channel.0.as_str()).collect();
    let expected = "B G N.X N.Y N.Z P.X P.Y P.Z R Z albedo.B albedo.G albedo.R stderr.B stderr.G stderr.R stratum";
    assert_eq!(names.join(" "), expected);
    assert!(found.iter().flat_map(|channel| &channel.1).all(|value| value.is_finite()));
    let of = |name: &str| &found.iter().find(|channel| channel.0 == name).expect("there").1;
    assert!(of("Z").iter().all(|&depth| depth > 0.0) && of("stratum").contains(&0.0));
    // The image does not change, and a render that does not ask has no such channel.
    let plain = folder.path().join("plain.exr");
    assert!(read(&plain).expect("read").image.same_bits(&read(&folder.path().join("a.exr")).expect("read").image));
    assert_eq!(channels(&plain).len(), 6);
    assert!(refused(folder.path(), &format!("{RENDER} --aov depth -o a.png")).contains("add -o FILE.exr"));
    assert!(refused(folder.path(), &format!("{RENDER} --aov depht")).contains("'depth'"));
}

/// Mean over the pixels of a file, and its standard error.
fn mean(path: &Path, columns: std::ops::Range<usize>, rows: std::ops::Range<usize>) -> (f64, f64) {
    let file = read(path).expect("an EXR");
    let stderr = file.stderr.expect("errors");
    let inside = rows.flat_map(|y| columns.clone().map(move |x| y * file.image.width + x));
    let values: Vec<_> = inside.map(|i| (f64::from(file.image.rgb[i][1]), f64::from(stderr[i][1]))).collect();
    let n = values.len() as f64;
    (values.iter().map(|v| v.0).sum::<f64>() / n, values.iter().map(|v| v.1 * v.1).sum::<f64>().sqrt() / n)
}

/// Every method's part has the brightness that path tracing's whole has there; another part is the control.
#[test]
fn a_part_is_the_whole_there() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = |name: &str| folder.path().join(name);
    let render = "render cornell --size 24x16 --threads 1 -q --samples-per-pixel 256";
    made(folder.path(), &format!("{render} --method pt -o whole.exr"));
    let (whole, error) = mean(&path("whole.exr"), 4..12, 2..10);
    let (elsewhere, _) = mean(&path("whole.exr"), 5..13, 6..14);
    for (method, crop) in [
        ("pt", "4,2,12,10"),
        ("bdpt", "4,2,12,10"),
        ("mlt", "4,2,12,10"),
        ("mlt --strata 2x2", "4,2,12,10"),
        ("pssmlt", "0.166667,0.125,0.5,0.625"),
        ("mmlt", "4,2,12,10"),
        ("auto", "4,2,12,10"),
    ] {
        made(folder.path(), &format!("{render} --method {method} --crop {crop} -o part.exr -o part.png"));
        let (part, part_error) = mean(&path("part.exr"), 0..8, 0..8);
        let sigma = 4.5 * error.hypot(2.0 * part_error);
        assert!((part - whole).abs() < sigma, "{method}: {part} ± {part_error}, whole {whole} ± {error}");
        assert!((part - elsewhere).abs() > sigma, "{method}: {part} is {elsewhere}, too");
    }
    let file = read_all_flat_layers_from_file(path("part.exr")).expect("an EXR");
    assert_eq!(file.attributes.display_window.size, Vec2(24, 16));
    assert_eq!((file.layer_data[0].attributes.layer_position, file.layer_data[0].size), (Vec2(4, 2), Vec2(8, 8)));
    let facts = String::from_utf8(run(folder.path(), "info part.png").stdout).expect("text");
    assert!(facts.contains("8x8") && facts.contains("--crop=4,2,12,10 --size=24x16"), "{facts}");
    assert!(refused(folder.path(), &format!("{RENDER} --crop 0,0,25,4")).contains("24x16 pixels"));
}

/// A part goes on and is merged as a whole is.
#[test]
fn parts_of_the_image_are_kept_and_merged() {
    let folder = tempfile::tempdir().expect("a folder");
    let line = format!("{RENDER} --crop 4,2,12,10");
    made(folder.path(), &format!("{line} -o whole.exr"));
    made(folder.path(), &format!("{line} --shard 1/2 -o 1.mltp"));
    made(folder.path(), &format!("{line} --shard 2/2 -o 2.mltp"));
    let report = run(folder.path(), "merge 1.mltp 2.mltp --json -o merged.exr").stdout;
    let report: Value = serde_json::from_slice(&report).expect("JSON");
    assert_eq!(report["crop"], json!({ "size": [24, 16], "corner": [4, 2] }));
    let [whole, merged] = ["whole.exr", "merged.exr"].map(|name| read(&folder.path().join(name)).expect("read"));
    assert!(whole.image.same_bits(&merged.image));
    let file = read_all_flat_layers_from_file(folder.path().join("merged.exr")).expect("an EXR");
    assert_eq!(file.layer_data[0].attributes.layer_position, Vec2(4, 2));
    let other = refused(folder.path(), &format!("{RENDER} --crop 4,2,12,11 --resume 1.mltp -o b.exr"));
    assert!(other.contains("crop is 4,2,12,10"), "{other}");
}

/// A number of a packet of tev's protocol.
fn number<const N: usize>(packet: &mut &[u8]) -> [u8; N] {
    let (number, rest) = packet.split_first_chunk().expect("long enough");
    *packet = rest;
    *number
}

fn text(packet: &mut &[u8]) -> String {
    let end = packet.iter().position(|&byte| byte == 0).expect("an end");
    let text = String::from_utf8(packet[..end].to_vec()).expect("UTF-8");
    *packet = &packet[end + 1..];
    text
}

/// All packets that come to a listener, without their lengths.
fn packets(listener: TcpListener) -> Vec<Vec<u8>> {
    let mut bytes = Vec::new();
    listener.accept().expect("a caller").0.read_to_end(&mut bytes).expect("read");
    let (mut rest, mut packets) = (&bytes[..], Vec::new());
    while let Some((length, _)) = rest.split_first_chunk() {
        let (packet, next) = rest.split_at(u32::from_le_bytes(*length) as usize);
        packets.push(packet[4..].to_vec());
        rest = next;
    }
    packets
}

/// Source of the format: tev's README, "Inter-process communication".
#[test]
fn tev_is_told_the_image() {
    const CREATE: u8 = 4;
    const UPDATE: u8 = 6;
    let folder = tempfile::tempdir().expect("a folder");
    let listener = TcpListener::bind("127.0.0.1:0").expect("a port");
    let address = listener.local_addr().expect("an address");
    let heard = thread::spawn(move || packets(listener));
    made(folder.path(), &format!("{RENDER} --preview tev:{address} -o a.exr"));
    let packets = heard.join().expect("the listener ends");

    let mut create = &packets[0][..];
    assert_eq!((number::<1>(&mut create), number::<1>(&mut create)), ([CREATE], [1]));
    assert_eq!(text(&mut create), "mlt: cornell");
    assert_eq!([(); 3].map(|()| u32::from_le_bytes(number(&mut create))), [24, 16, 3]);
    assert_eq!([(); 3].map(|()| text(&mut create)), ["R", "G", "B"]);

    let mut last = &packets.last().expect("an update")[..];
    assert_eq!((number::<1>(&mut last), number::<1>(&mut last)), ([UPDATE], [0]));
    assert_eq!(text(&mut last), "mlt: cornell");
    assert_eq!(u32::from_le_bytes(number(&mut last)), 3);
    assert_eq!([(); 3].map(|()| text(&mut last)), ["R", "G", "B"]);
    assert_eq!([(); 4].map(|()| u32::from_le_bytes(number(&mut last))), [0, 0, 24, 16]);
    assert_eq!([(); 6].map(|()| u64::from_le_bytes(number(&mut last))), [0, 1, 2, 3, 3, 3]);
    let values: Vec<_> =
        last.chunks_exact(4).map(|bytes| f32::from_le_bytes(bytes.try_into().expect("four"))).collect();
    assert_eq!(values, read(&folder.path().join("a.exr")).expect("read").image.rgb.as_flattened());
}

#[test]
fn a_viewer_that_is_not_there_is_told_of_at_once() {
    let folder = tempfile::tempdir().expect("a folder");
    let gone = TcpListener::bind("127.0.0.1:0").expect("a port").local_addr().expect("an address");
    assert!(refused(folder.path(), &format!("{RENDER} --preview tev:{gone} -o a.exr")).contains("start tev first"));
    assert_eq!(fs::read_dir(folder.path()).expect("readable").count(), 0);
}

#[test]
fn a_preview_may_be_the_file_of_the_image() {
    let folder = tempfile::tempdir().expect("a folder");
    made(folder.path(), &format!("{RENDER} --preview a.png --preview b.jpg -o a.png"));
    let facts = String::from_utf8(run(folder.path(), "info a.png").stdout).expect("text");
    assert!(facts.contains("command"), "the image is written last: {facts}");
    assert!(folder.path().join("b.jpg").is_file());
    assert!(refused(folder.path(), &format!("{RENDER} --preview none/a.png -o b.png")).contains("does not exist"));
}

#[cfg(unix)]
#[test]
fn files_are_written_on_request() {
    use std::{process::Stdio, time::Duration};
    let folder = tempfile::tempdir().expect("a folder");
    let line = "render cornell --size 24x16 --method pt --time 60s --threads 1 -q --preview p.png -o a.exr";
    let mut child = Command::new(env!("CARGO_BIN_EXE_mlt"))
        .current_dir(folder.path())
        .args(line.split_whitespace())
        .stderr(Stdio::null())
        .spawn()
        .expect("mlt starts");
    let signal = |name: &str| {
        let kill = Command::new("kill").args([format!("-{name}"), child.id().to_string()]).status();
        assert!(kill.expect("kill starts").success());
    };
    let appears = |name: &str| {
        let there = || folder.path().join(name).is_file();
        (0..300).any(|_| {
            thread::sleep(Duration::from_millis(100));
            there()
        })
    };
    // The handler is there once rounds are made.
    assert!(appears("p.png") && !folder.path().join("a.exr").exists());
    signal("USR1");
    assert!(appears("a.exr"), "no file on request");
    signal("INT");
    assert_eq!(child.wait().expect("the child ends").code(), Some(130));
}

/// With the library where there is one, and without it in any case.
#[test]
fn a_denoised_image_lies_beside_and_says_so() {
    let folder = tempfile::tempdir().expect("a folder");
    let line = format!("{RENDER} --denoise -o a.exr -o a.png");
    if mlt_cli::denoise::Denoiser::load().is_err() {
        assert!(refused(folder.path(), &line).contains("Open Image Denoise 2"));
        return;
    }
    made(folder.path(), &line);
    made(folder.path(), &format!("{RENDER} -o plain.exr"));
    let image = |name: &str| read(&folder.path().join(name)).expect("an EXR");
    assert!(image("a.exr").image.same_bits(&image("plain.exr").image));
    assert!(!image("a.denoised.exr").image.same_bits(&image("plain.exr").image));
    let facts = String::from_utf8(run(folder.path(), "info a.denoised.png").stdout).expect("text");
    assert!(facts.contains("biased: filtered by Open Image Denoise 2."), "{facts}");
    assert!(!String::from_utf8(run(folder.path(), "info a.png").stdout).expect("text").contains("biased"));
}
