//! Data of the reference encoder, decoded.

use super::*;
use serde_json::json;

fn bytes(hex: &str) -> Vec<u8> {
    (0..hex.len() / 2).map(|i| u8::from_str_radix(&hex[2 * i..][..2], 16).unwrap()).collect()
}

/// 9 × 7 points of a grid.
fn points() -> Vec<u8> {
    let point = |i: u32| [(i % 9) as f32, (i / 9) as f32 * 0.5, ((i * 7) % 5) as f32 * 0.25];
    (0..63).flat_map(point).flat_map(f32::to_le_bytes).collect()
}

/// The triangles between them.
fn corners() -> Vec<u8> {
    let cell = |y: u32, x: u32| {
        let a = 9 * y + x;
        [a, a + 1, a + 9, a + 1, a + 10, a + 9]
    };
    (0..6).flat_map(|y| (0..8).flat_map(move |x| cell(y, x))).flat_map(u32::to_le_bytes).collect()
}

fn decode(mode: &str, [stride, count]: [usize; 2], content: &[u8]) -> Option<Vec<u8>> {
    let extension =
        json!({ "buffer": 0, "byteLength": content.len(), "byteStride": stride, "count": count, "mode": mode });
    Compressed::read(&extension)?.decode(content)
}

const VERSION_0: &str = "\
    a00000ff00ffff80804040404000ffff80804040404000ffff80804040404000ffff80804040404000ffff80804040404000ffff808040\
    40404000ffff80804040404000553800be007e817e2f800be0817e817e02f800be817e817e002f8008817e0000540c000300ff8000c000\
    308040000c00004011000030007e008000000000550cf33ccfff7f7fff7f7fff7f7f33ccf33cff7f7fff7f7fff7f7fcf33ccf3ff7f7fff\
    7f7fff7f7fff3ccf33cc7f7fff7f7fff7f7fff5531bc6f1b7e7d7e7d7e7dc6f1bc6f7e7d7e7d7e7d7e1bc6f1bc7d7e7d7e7d7e6f1bc6f0\
    7d7e7d7e7d7e0000000000000000000000000000000000000000000000000000000000000000";
const VERSION_1: &str = "\
    a15a0a5a00f8f3808040404040ff80804040e7cf4040ff808040404040ff80809f3f40404040ff808040404040ff7f7e808040404040ff\
    80804040404000060e7f01817f011c38817f01817f0170e0817f01817f01c001817f0154000880102080404000400500027e0400010038\
    e7ff807fff807fff807f9c73ff807fff807fff807fce39ff807fff807fff807fe71cff807fff807fff807f55357d5f577e7e7e7e7e7ed5\
    f57d5f7e7e7e7e7e7e7e57d5f57d7e7e7e7e7e7e5f57d5f47e7e7e7e7e7e000000000000000000000000000000000000000000010101";
const TURNED: &str = "\
    a1690a6a551c002700030309c002700303009c002703030009c00003aa0ff26131f8ff2613fcfc0ffcfc1f8ff26131f8ff260ffcfc0ffc\
    fc131f8ff26131f8ff0ffcfc0ffcfc26131f8ff26131f00ffcfc0f54000880102080404000400500027e040001aa0f247ff247ff247ffc\
    fdfcfdfcfdf247ff247ff247fffcfdfcfdfcfdfc247ff247ff247ff2fdfcfdfcfdfc47ff247ff247ff20fdfcfdfcfdfc00000000000000\
    0000000000000000000000000000320122";
const TRIANGLES: &str = "\
    e1fe1e100e100e100e100e100e100e100efe1e100e100e100e100e100e100e100efe1e100e100e100e100e100e100e100efe1e100e100e\
    100e100e100e100e100efe1e100e100e100e100e100e100e100efe1e100e100e100e100e100e100e100e0f120f020f020f020f020f0200\
    7687566778a9866589689801690000";
const SEQUENCE: &str = "\
    d10004201e24021e04201e24021e04201e24021e04201e24021e04201e24021e04201e24021e04201e24021e04201e24021a04201e2402\
    1e04201e24021e04201e24021e04201e24021e04201e24021e04201e24021e04201e24021e04201e24021a04201e24021e04201e24021e\
    04201e24021e04201e24021e04201e24021e04201e24021e04201e24021e04201e24021a04201e24021e04201e24021e04201e24021e04\
    201e24021e04201e24021e04201e24021e04201e24021e04201e24021a04201e24021e04201e24021e04201e24021e04201e24021e0420\
    1e24021e04201e24021e04201e24021e04201e24021a04201e24021e04201e24021e04201e24021e04201e24021e04201e24021e04201e\
    24021e04201e24021e04201e240200000000";

#[test]
fn what_was_encoded_comes_back() {
    for text in [VERSION_0, VERSION_1, TURNED] {
        assert!(decode("ATTRIBUTES", [12, 63], &bytes(text)) == Some(points()));
    }
    for (mode, text) in [("TRIANGLES", TRIANGLES), ("INDICES", SEQUENCE)] {
        let found = decode(mode, [4, 288], &bytes(text)).unwrap();
        // The first codec may turn triangles.
        let triangle = |all: &[u8], i: usize| {
            let mut triangle = [0, 1, 2].map(|k| all[12 * i + 4 * k]);
            let least = (0..3).min_by_key(|&k| triangle[k]).unwrap();
            triangle.rotate_left(least);
            triangle
        };
        assert!((0..96).all(|i| triangle(&found, i) == triangle(&corners(), i)), "{mode}");
    }
}

#[test]
fn filters_give_unit_vectors_rotations_and_numbers_back() {
    let directions = [[0.0, 0.0, 1.0], [1.0, 0.0, 0.0], [0.6, 0.0, -0.8], [-0.48, 0.6, -0.64]];
    let small = octahedral("00007f007f007f007f497f00ad5c7f00", 4);
    let large = octahedral("00000000ff7f0000ff7f0000ff7f0000ff7f2449ff7f0000a7ac475cff7f0000", 8);
    for (i, direction) in directions.iter().enumerate() {
        for (k, x) in direction.iter().enumerate() {
            let found = [f32::from(small[4 * i + k] as i8) / 127.0, component(&large[8 * i..], k)];
            assert!((found[0] - x).abs() < 0.02 && (found[1] - x).abs() < 2e-4, "{found:?} {x}");
        }
    }
    let mut rotations = bytes("000000000000ff7f825a825a825afc7f00009c6c0000ff7f000064930000fc7f");
    filter::quaternion(&mut rotations);
    let expected = [[0.0, 0.0, 0.0, 1.0], [0.5; 4], [0.0, 0.6, 0.0, 0.8], [-0.8, 0.0, 0.6, 0.0]];
    for (i, expected) in expected.iter().enumerate() {
        let dot: f32 = (0..4).map(|k| component(&rotations[8 * i..], k) * expected[k]).sum();
        assert!((dot.abs() - 1.0).abs() < 1e-3, "{i}: {dot}");
    }
    let mut numbers =
        bytes("0000008e0000008e0000008e002000f3000000f3001000f3002000f4000000f4001000f4003000f4000000f4000400f4");
    filter::exponential(&mut numbers);
    for (found, expected) in numbers.chunks(4).zip(points().chunks(4)) {
        let [found, expected] = [found, expected].map(|b| f32::from_le_bytes([b[0], b[1], b[2], b[3]]));
        assert!((found - expected).abs() < 1e-3, "{found} {expected}");
    }
}

fn octahedral(hex: &str, stride: usize) -> Vec<u8> {
    let mut elements = bytes(hex);
    filter::octahedral(&mut elements, stride);
    elements
}

fn component(element: &[u8], k: usize) -> f32 {
    f32::from(i16::from_le_bytes([element[2 * k], element[2 * k + 1]])) / 32767.0
}

/// Whatever is cut off or changed: an error or as many elements as were asked for, never a panic.
#[test]
fn damaged_data_end_in_nothing_worse() {
    for (mode, size, text) in [
        ("ATTRIBUTES", [12, 63], VERSION_0),
        ("ATTRIBUTES", [12, 63], TURNED),
        ("TRIANGLES", [4, 288], TRIANGLES),
        ("INDICES", [4, 288], SEQUENCE),
    ] {
        let whole = bytes(text);
        for end in 0..whole.len() {
            assert_eq!(decode(mode, size, &whole[..end]), None, "{mode} cut at {end}");
        }
        for at in 0..whole.len() {
            let mut changed = whole.clone();
            changed[at] ^= 0x5a;
            assert!(decode(mode, size, &changed).is_none_or(|found| found.len() == size[0] * size[1]));
        }
    }
    for (mode, stride) in [("ATTRIBUTES", 6), ("ATTRIBUTES", 260), ("TRIANGLES", 3), ("POINTS", 4)] {
        assert_eq!(decode(mode, [stride, 3], &[]), None);
    }
}
