//! Sums with a right checksum: what decodes can be merged and encoded again, and comes back as it was.
#![no_main]

use libfuzzer_sys::fuzz_target;
use mlt_core::engine::sealed;
use mlt_core::transport::render::Sums;

/// As `Sums` writes them.
const MAGIC: [u8; 8] = *b"mlt-sums";
const VERSION: u32 = 2;

fuzz_target!(|bytes: &[u8]| {
    let decoded = |bytes: &[u8]| Sums::from_bytes(&sealed(MAGIC, VERSION, |to| to.extend(bytes)));
    let (first, second) = bytes.split_at(bytes.len() / 2);
    for part in [bytes, first] {
        let Ok(mut sums) = decoded(part) else { continue };
        let again = Sums::from_bytes(&sums.to_bytes()).expect("as it was written");
        assert_eq!(again.to_bytes(), sums.to_bytes());
        assert!(sums.merge(&again).is_err() || sums.rounds().count() == 0, "a round that counts twice");
        let _ = decoded(second).map(|other| sums.merge(&other));
        let _ = (sums.film().means(), sums.film().relative_error([1.0; 3]), sums.tally().chains().warnings());
    }
});
