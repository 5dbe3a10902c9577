//! The size of an OBJ tile, estimated.

use crate::error::TileError;
use crate::source::open_regular;
use crate::types::TileHeader;
use memchr::memchr_iter;
use std::fs::File;
use std::io::{self, Read, Seek, SeekFrom};
use std::path::Path;

const SAMPLES: u64 = 64;
const SAMPLE_BYTES: u64 = 1024;

/// Estimates vertices and triangles: an OBJ has no header, so 64 samples of 1 KiB, evenly spread over the file, are
/// counted and scaled by file size / sampled size. Files up to 64 KiB are counted whole. On real tiles
/// (ContextCapture, levels 17 to 19: 115 to 142 bytes a triangle) the estimate lies within 10 per cent.
///
/// # Errors
/// `Io`, `Unsupported` (no regular file).
pub(crate) fn read_header(path: &Path) -> Result<TileHeader, TileError> {
    let (mut file, metadata) = open_regular(path)?;
    let bytes = metadata.len();
    let sampled = sample(&mut file, bytes).map_err(|e| TileError::io(path, "read", e))?;
    let scale = |count: u64| {
        (u128::from(count) * u128::from(bytes)).div_ceil(u128::from(sampled.bytes.max(1))) as u64
    };
    Ok(TileHeader { vertices: scale(sampled.vertices), triangles: scale(sampled.triangles), bytes })
}

#[derive(Default)]
struct Counts {
    bytes: u64,
    vertices: u64,
    triangles: u64,
}

fn sample(file: &mut File, length: u64) -> io::Result<Counts> {
    let mut counts = Counts::default();
    if length <= SAMPLES * SAMPLE_BYTES {
        let mut whole = vec![b'\n'];
        file.take(SAMPLES * SAMPLE_BYTES).read_to_end(&mut whole)?;
        whole.push(b'\n');
        count_lines(&whole, &mut counts);
        return Ok(counts);
    }
    let mut chunk = Vec::new();
    for k in 0..SAMPLES {
        chunk.clear();
        let start = (length - SAMPLE_BYTES) / (SAMPLES - 1) * k;
        file.seek(SeekFrom::Start(start))?;
        file.take(SAMPLE_BYTES).read_to_end(&mut chunk)?;
        count_lines(&chunk, &mut counts);
    }
    Ok(counts)
}

/// Counts the lines that lie in the chunk with both ends.
fn count_lines(chunk: &[u8], counts: &mut Counts) {
    let ends: Vec<usize> = memchr_iter(b'\n', chunk).collect();
    for pair in ends.windows(2) {
        let line = &chunk[pair[0] + 1..pair[1]];
        match line.trim_ascii_start() {
            [b'v', b' ' | b'\t', ..] => counts.vertices += 1,
            [b'f', b' ' | b'\t', rest @ ..] => {
                let corners = rest.split(u8::is_ascii_whitespace).filter(|word| !word.is_empty()).count();
                counts.triangles += corners.saturating_sub(2) as u64;
            }
            _ => {}
        }
    }
    if let [first, .., last] = ends[..] {
        counts.bytes += (last - first) as u64;
    }
}
