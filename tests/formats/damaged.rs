//! Files that are cut, damaged or wrong about their sizes: an error or a recording, never a panic and never memory without bound.

use std::fs;

use recording::files::source_error::render;
use recording::{ChannelMap, MAX_UNPACKED_BYTES, Recording, RecordingError};

use crate::fixture;

const FILES: [&str; 16] = [
    "vectors.mat",
    "vectors_packed.mat",
    "structure.mat",
    "simulink.mat",
    "packed_0.mf4",
    "packed_2.mf4",
    "two_groups.mf4",
    "pyarrow.parquet",
    "plain.parquet",
    "version4.mat",
    "controldesk.mat",
    "composed.mf4",
    "states.mf4",
    "spark.parquet",
    "run.xlsx",
    "run.csv.gz",
];

/// Reads bytes; returns the recording if there is one.
fn reads(name: &str, bytes: &[u8]) -> Option<Recording> {
    match recording::read_from(name, bytes, &ChannelMap::default()) {
        Ok(recording) => {
            assert!(recording.time_s().windows(2).all(|pair| pair[0] < pair[1]), "{name}");
            Some(recording)
        }
        Err(error) => {
            assert!(render(&error).contains("expected"), "{name}");
            None
        }
    }
}

#[test]
pub(crate) fn a_file_that_is_cut_is_refused_or_lacks_what_is_not_there() {
    for name in FILES {
        let bytes = fs::read(fixture(name)).unwrap();
        let whole = reads(name, &bytes).unwrap();
        for length in (0..bytes.len()).step_by(bytes.len() / 300 + 1).chain(bytes.len() - 40..bytes.len()) {
            // A file that is cut after a variable lacks the later ones; the earlier ones are unchanged.
            for column in reads(name, &bytes[..length]).iter().flat_map(Recording::columns) {
                assert_eq!(whole.signal(column.signal), Some(column.values.as_slice()), "{name}: {length} bytes");
            }
        }
    }
}

#[test]
pub(crate) fn flipped_bits_make_an_error_or_a_recording() {
    // Our own random number generator, so that a failure can be repeated.
    let mut state = 1_u64;
    let mut next = |below: usize| {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        usize::try_from(state >> 33).unwrap_or(0) % below
    };
    for name in FILES {
        let whole = fs::read(fixture(name)).unwrap();
        for trial in 0..400 {
            let mut bytes = whole.clone();
            for _ in 0..=trial % 4 {
                // Sizes and links are at the beginning and, in Parquet, at the end.
                let at = match trial % 3 {
                    0 => next(bytes.len()),
                    1 => next(bytes.len().min(1024)),
                    _ => bytes.len() - 1 - next(bytes.len().min(1024)),
                };
                bytes[at] ^= if trial % 5 == 0 { 0xff } else { 1 << next(8) };
            }
            reads(name, &bytes);
        }
    }
}

#[test]
pub(crate) fn no_size_is_believed() {
    // Words of sizes, overwritten with large ones at every position.
    for name in FILES {
        let whole = fs::read(fixture(name)).unwrap();
        for at in (0..whole.len().min(3000) - 8).step_by(4) {
            for huge in [u64::MAX, 0x7fff_ffff_7fff_fff8, 0x0000_0001_0000_0000] {
                let mut bytes = whole.clone();
                bytes[at..at + 8].copy_from_slice(&huge.to_le_bytes());
                reads(name, &bytes);
            }
        }
    }
}

#[test]
pub(crate) fn what_unpacks_to_too_much_is_refused_before_it_is_unpacked() {
    let whole = fs::read(fixture("vectors_packed.mat")).unwrap();
    // A variable of 1.5 GiB, of which the packed bytes hold only the beginning.
    let mut packed = flate2::write::ZlibEncoder::new(Vec::new(), flate2::Compression::fast());
    let length = u32::try_from(MAX_UNPACKED_BYTES + (MAX_UNPACKED_BYTES >> 1)).unwrap();
    let content = [14_u32.to_le_bytes(), length.to_le_bytes(), [0; 4], [0; 4]].concat();
    std::io::Write::write_all(&mut packed, &content).unwrap();
    let packed = packed.finish().unwrap();
    let size = u32::try_from(packed.len()).unwrap();
    let bytes = [&whole[..128], &15_u32.to_le_bytes(), &size.to_le_bytes(), &packed].concat();
    let error = recording::read_from("bomb.mat", bytes.as_slice(), &ChannelMap::default()).unwrap_err();
    assert!(matches!(error, RecordingError::TooLarge { .. }), "{error}");
}

#[test]
pub(crate) fn files_of_other_versions_say_how_to_save_them() {
    let refused = |name: &str, bytes: &[u8]| {
        let error = recording::read_from(name, bytes, &ChannelMap::default()).unwrap_err();
        assert!(matches!(error, RecordingError::Unsupported { .. } | RecordingError::NotOfFormat { .. }), "{error}");
        error.to_string()
    };
    let told = refused("new.mat", b"MATLAB 7.3 MAT-file, Platform: GLNXA64");
    assert_eq!(
        told,
        "new.mat: an HDF5 file, as MATLAB's version 7.3 is; expected a MAT-file of version 7: in MATLAB save('run.mat', '-v7', …), \
         or export as CSV or Parquet"
    );
    assert!(refused("x.h5", b"\x89HDF\r\n\x1a\n\0\0\0\0").contains("an HDF5 file"));
    let mut old = b"MDF     3.30    asammdf".to_vec();
    old.resize(200, 0);
    assert!(refused("old.dat", &old).contains("an MDF file of version 3.30; expected version 4"));
    for (begins, what) in [
        (&b"\x89PNG\r\n\x1a\n"[..], "a picture (PNG)"),
        (b"\xff\xd8\xff\xe0", "a picture (JPEG)"),
        (b"GIF89a", "a picture (GIF)"),
        (b"{\\rtf1", "a document (RTF)"),
        (b"\x7fELF\x02", "a program"),
        (b"{\"time\": [0, 1]}", "a JSON file"),
        (b"\xff\xfe\0\0t\0\0\0", "a text in UTF-32"),
    ] {
        assert!(refused("run.csv", begins).contains(what), "{what}");
    }
    assert!(refused("open.mf4", b"UnFinMF 4.10    ").contains("that its recorder has not closed"));
    assert!(refused("no.mat", b"\0\0\0\0\x0a\0\0\0").contains("neither text nor a MAT-file, as its name says"));
}
