//! Decompression of Blosc chunks in OpenVDB nodes.
//!
//! Invariant: the output has the requested length, and memory is allocated for no more. Source: F. Alted, "Blosc Header
//! Format", and the sources of C-Blosc 1.21.

/// Values are split by bytes if they have at most `MAX_SPLITS` bytes and a block has at least `MIN_SPLIT` values.
const MAX_SPLITS: usize = 16;
const MIN_SPLIT: usize = 128;
/// Flags of the header; the highest three bits are the codec.
const SHUFFLED: u8 = 1;
const COPIED: u8 = 2;
const BITS_SHUFFLED: u8 = 4;
const WHOLE: u8 = 16;
/// Longest distance in the short form of a BloscLZ match.
const NEAR: usize = 8191;

/// Error of a chunk.
pub(super) enum Fault {
    Damaged(&'static str),
    Unsupported(String),
}

use Fault::{Damaged, Unsupported};

/// Decompresses a chunk to `bytes` bytes.
pub(super) fn decode(chunk: &[u8], bytes: usize) -> Result<Vec<u8>, Fault> {
    let (header, data) = chunk.split_first_chunk::<16>().ok_or(Damaged("its Blosc header is cut off"))?;
    let [version, _, flags, width, ..] = *header;
    let width = usize::from(width);
    let (total, block) = (number(header, 4)?, number(header, 8)?);
    if !(1..=2).contains(&version) {
        return Err(Unsupported(format!("version {version}")));
    }
    if flags & BITS_SHUFFLED != 0 {
        return Err(Unsupported("shuffle of bits".into()));
    }
    if (total, number(header, 12)?) != (bytes, chunk.len()) {
        return Err(Damaged("its Blosc header is of another length"));
    }
    if flags & COPIED != 0 {
        return if data.len() == bytes { Ok(data.to_vec()) } else { Err(Damaged("its copy is of another length")) };
    }
    if block == 0 || block > bytes.max(1) || width == 0 {
        return Err(Damaged("its Blosc header has blocks of no or too many bytes"));
    }
    let mut decoded = Vec::with_capacity(bytes);
    for (index, at) in (0..bytes).step_by(block).enumerate() {
        let size = block.min(bytes - at);
        let is_split = flags & WHOLE == 0 && width <= MAX_SPLITS && block / width >= MIN_SPLIT && size == block;
        let parts = if is_split { width } else { 1 };
        let start = number(chunk, 16 + 4 * index)?;
        let unpacked = parts_of(chunk.get(start..).unwrap_or_default(), flags >> 5, parts, size)?;
        if flags & SHUFFLED != 0 && width > 1 {
            unshuffle(&unpacked, width, &mut decoded);
        } else {
            decoded.extend(unpacked);
        }
    }
    Ok(decoded)
}

/// 32-bit integer at `at`.
fn number(bytes: &[u8], at: usize) -> Result<usize, Fault> {
    let chunk = bytes.get(at..).and_then(|rest| rest.first_chunk());
    chunk.map(|chunk| u32::from_le_bytes(*chunk) as usize).ok_or(Damaged("a number of it is cut off"))
}

/// Decompresses a block that consists of equally long parts.
fn parts_of(mut packed: &[u8], codec: u8, parts: usize, size: usize) -> Result<Vec<u8>, Fault> {
    if !size.is_multiple_of(parts) {
        return Err(Damaged("its blocks do not split into whole values"));
    }
    let mut unpacked = Vec::with_capacity(size);
    for _ in 0..parts {
        let length = number(packed, 0)?;
        let part = packed.get(4..).and_then(|rest| rest.get(..length)).ok_or(Damaged("a block of it is cut off"))?;
        let start = unpacked.len();
        match codec {
            _ if length == size / parts => unpacked.extend(part),
            0 => blosclz(part, size / parts, &mut unpacked)?,
            1 => {
                unpacked.resize(start + size / parts, 0);
                let found = lz4_flex::block::decompress_into(part, &mut unpacked[start..]);
                if found.ok() != Some(size / parts) {
                    return Err(Damaged("a block of LZ4 in it is damaged"));
                }
            }
            2 => return Err(Unsupported("codec Snappy".into())),
            3 => return Err(Unsupported("codec zlib".into())),
            4 => return Err(Unsupported("codec Zstandard".into())),
            _ => return Err(Unsupported(format!("codec {codec}"))),
        }
        packed = &packed[4 + length..];
    }
    Ok(unpacked)
}

/// Appends `size` bytes decompressed from BloscLZ.
fn blosclz(packed: &[u8], size: usize, unpacked: &mut Vec<u8>) -> Result<(), Fault> {
    const CUT: Fault = Damaged("a block of BloscLZ in it is cut off");
    let start = unpacked.len();
    let mut input = packed.iter().copied();
    let mut control = input.next().map(|byte| usize::from(byte) & 31); // the first control byte is always literals
    while let Some(code) = control {
        if code < 32 {
            for _ in 0..=code {
                unpacked.push(input.next().ok_or(CUT)?);
            }
        } else {
            let mut length = (code >> 5) + 2;
            let mut more = code >> 5 == 7;
            while more {
                let byte = input.next().ok_or(CUT)?;
                length += usize::from(byte);
                more = byte == 255;
            }
            let low = usize::from(input.next().ok_or(CUT)?);
            let mut back = ((code & 31) << 8) + low + 1;
            if back > NEAR {
                let far = [input.next().ok_or(CUT)?, input.next().ok_or(CUT)?];
                back = usize::from(u16::from_be_bytes(far)) + NEAR + 1;
            }
            let from = unpacked.len().checked_sub(back).filter(|from| *from >= start);
            let from = from.ok_or(Damaged("a block of BloscLZ in it points before its start"))?;
            if length > start + size - unpacked.len().min(start + size) {
                return Err(Damaged("a block of BloscLZ in it is too long"));
            }
            for at in from..from + length {
                unpacked.push(unpacked[at]); // ranges may overlap
            }
        }
        control = input.next().map(usize::from);
    }
    if unpacked.len() == start + size { Ok(()) } else { Err(Damaged("a block of BloscLZ in it is of another length")) }
}

/// Appends values whose bytes are stored in planes.
fn unshuffle(bytes: &[u8], width: usize, values: &mut Vec<u8>) {
    let count = bytes.len() / width;
    values.extend((0..count * width).map(|at| bytes[at % width * count + at / width]));
    values.extend(&bytes[count * width..]);
}

#[cfg(test)]
mod tests {
    use super::*;
    use base64::Engine;
    use base64::engine::general_purpose::STANDARD;

    /// 340 floats, of which only the last 40 do not compress.
    fn numbers() -> Vec<u8> {
        let smooth = (0..300).map(|index| (index / 7) as f32 * 0.25);
        let rough = (0..40_u32).map(|index| f32::from_bits(index.wrapping_mul(2_654_435_769) >> 2));
        smooth.chain(rough).flat_map(f32::to_le_bytes).collect()
    }

    /// The numbers compressed by C-Blosc 1.21: BloscLZ and LZ4, each with and without shuffle.
    const PACKED: [&str; 4] = [
        "AgEBBFAFAABQBQAAlgEAABQAAAAyAAAAIwAAAADg/yEDH27cSrknlQNy4E68K5kHdeRSwC6dC3nnVsQyoA9961nIBjakEoHvXcsyAAAAIwAAAADg/yEDH968m3lYNhXz0bCObUsqCObFo4JgPx372riXdVQyEO/NBqyKaUclBOLKAAAAJwAAAAAAAACAgACgDQBAgACAEwGAoIAAAMCAAADggACgKQAQgAAAIIAAADCAAIA9AUBQgAAAYIAAAHCAAKBTAIiAAACQgAAAmIAAgGcBoKiAAACwgAAAuIAAgHwBwMiAAADQgAAA2IAAgJEB4OiAAADwgAAA+IAAoKcABIAAAAiAAAAMgACAuwEQFIAAABiAAAAcgACA0AEgJIAAAChgAB8AjRupN8VT4W78ihimNMJQ3Wv5hxWjMb5M2mj2hBKgLQe7Sddl84EPnEQAAAAnAAAAAAAAAD6AAAA/4CAAAEDgngAAQeBCAB8AJw82HgUtFDwjCzMaAikROCAHLxc+Jg01HAQrEzsiCgcxGQAoDzcfBg==",
        "AgEABFAFAABQBQAAawIAABQAAABNAAAAIwAAAADgEQMBgD7gEQMBAD/gEQMBQD/gEQMBgD/gEQMBoD/gEQMBwD/gEQMB4D/gEQMBAEDgEQMBEEDgEQMBIEDgEQMBMEDgEQMBQEBRAAAAIwAAQEDgDQMBUEDgEQMBYEDgEQMBcEDgEQMBgEDgEQMBiEDgEQMBkEDgEQMBmEDgEQMBoEDgEQMBqEDgEQMBsEDgEQMBuEDgEQMFwEAAAMBAVQAAACMAAMBA4AkDAchA4BEDAdBA4BEDAdhA4BEDAeBA4BEDAehA4BEDAfBA4BEDAfhA4BEDAQBB4BEDAQRB4BEDAQhB4BEDAQxB4BEDCRBBAAAQQQAAEEFUAQAAAAAQQQAAEEEAABBBAAAQQQAAFEEAABRBAAAUQQAAFEEAABRBAAAUQQAAFEEAABhBAAAYQQAAGEEAABhBAAAYQQAAGEEAABhBAAAcQQAAHEEAABxBAAAcQQAAHEEAABxBAAAcQQAAIEEAACBBAAAgQQAAIEEAACBBAAAgQQAAIEEAACRBAAAkQQAAJEEAACRBAAAkQQAAJEEAACRBAAAoQQAAKEEAAChBAAAoQQAAKEEAAChBAAAAAG7ejSfcvBsPSpupNrl5Nx4nWMUFlTZTLQMV4RRy82484NH8I06wigu8jhgzK22mGplLNAIHKsIpdQhQEeTm3ThSxWsgwKP5By6Chy+dYBUXCz+jPnkdMSbn+74NVtpMNcS42hwyl2gEoHX2Kw9UhBN9MhI76xCgIlnvLQrIzbsxNqxJGaSK1wASaWUogUfzD+8lgTddBA8fy+KcBg==",
        "AgEhBFAFAABQBQAAlgEAABQAAAAvAAAAHwABAP8a8Bhu3Eq5J5UDcuBOvCuZB3XkUsAunQt551bEMqAPfetZyDakEoHvXcsvAAAAHwABAP8a8BjevJt5WDYV89Gwjm1LKgjmxaOCYD8d+9q4l3VUMhDvzayKaUclBOLTAAAAEgABABKAAQACDQAiAEABAAIUACKAoAEAEsABABLgAQADKgASEAEAEiABABIwAQACPgAiQFABABJgAQAScAEAA1QAEogBABKQAQASmAEAAmgAIqCoAQASsAEAErgBAAJ9ACLAyAEAEtABABLYAQACkgAi4OgBABLwAQAS+AEAA6gAEgQBABIIAQASDAEAArwAIhAUAQASGAEAEhwBAALRACIgJAEAESgBAPAZAI0bqTfFU+Fu/IoYpjTCUN1r+YcVozG+TNpo9oQSoC27Sddl84EPnEEAAAASAAEAEj4BAB8/AQAWH0ABAJQfQQEAOPAZACcPNh4FLRQ8IwszGgIpETggBy8XPiYNNRwEKxM7IgoxGQAoDzcfBg==",
        "AgEgBFAFAABQBQAAvgEAABQAAABFAAAAHwABAAovgD4EAAcvAD8EAAcfQAQACB+ABAAIH6AEAAgfwAQACB/gBAAILwBABAAHHxAEAAgfIAQACB8wBAAFUEAAAEBARgAAAE8AAEBABAADH1AEAAgfYAQACB9wBAAIH4AEAAgfiAQACB+QBAAIH5gEAAgfoAQACB+oBAAIH7AEAAgfuAQACGDAQAAAwEBKAAAATgAAwEAEAB/IBAAIH9AEAAgf2AQACB/gBAAIH+gEAAgf8AQACB/4BAAILwBBBAAHHwQEAAgfCAQACB8MBAAIoBBBAAAQQQAAEEHFAAAASgAAEEEEAB8UBAAIHxgEAAgfHAQACB8gBAAIHyQEAAgfKAQABPCPAABu3o0n3LwbD0qbqTa5eTceJ1jFBZU2Uy0DFeEUcvNuPODR/CNOsIoLvI4YMyttphqZSzQCByrCKXUIUBHk5t04UsVrIMCj+QcugocvnWAVFws/oz55HTEm5/u+DVbaTDXEuNocMpdoBKB19isPVIQTfTISO+sQoCJZ7y0KyM27MTasSRmkitcAEmllKIFH8w/vJYE3XQQPH8vinAY=",
    ];

    fn fault(chunk: &[u8], bytes: usize) -> String {
        match decode(chunk, bytes) {
            Ok(_) => "none".into(),
            Err(Damaged(what)) => what.into(),
            Err(Unsupported(what)) => what,
        }
    }

    #[test]
    fn what_c_blosc_packs_is_unpacked() {
        for packed in PACKED {
            let chunk = STANDARD.decode(packed).unwrap();
            assert!(decode(&chunk, 1360).is_ok_and(|unpacked| unpacked == numbers()), "{packed}");
        }
    }

    #[test]
    fn damaged_chunks_fail_or_keep_the_declared_length() {
        for packed in PACKED {
            let chunk = STANDARD.decode(packed).unwrap();
            for end in 0..chunk.len() {
                assert_ne!(fault(&chunk[..end], 1360), "none", "{end}");
            }
            for at in 0..chunk.len() {
                for bit in 0..8 {
                    let mut bent = chunk.clone();
                    bent[at] ^= 1 << bit;
                    assert!(
                        decode(&bent, 1360).is_ok_and(|unpacked| unpacked.len() == 1360)
                            || fault(&bent, 1360) != "none"
                    );
                }
            }
        }
        let chunk = STANDARD.decode(PACKED[0]).unwrap();
        assert_eq!(fault(&chunk, 1359), "its Blosc header is of another length");
        for (codec, name) in [(3, "codec zlib"), (4, "codec Zstandard")] {
            let mut other = chunk.clone();
            other[2] = other[2] & 31 | codec << 5;
            assert_eq!(fault(&other, 1360), name);
        }
    }
}
