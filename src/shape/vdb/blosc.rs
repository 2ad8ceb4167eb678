//! Blosc chunks, as OpenVDB packs the values of a node.
//!
//! Role: a chunk into the bytes that it was made of. Invariant: what comes out has the length that the caller asked for, and
//! memory is taken for that length only. Source: F. Alted, "Blosc Header Format" and the sources of C-Blosc 1.21.

/// Most bytes of a value whose bytes are compressed one by one, and fewest values for which they are.
const MAX_SPLITS: usize = 16;
const MIN_SPLIT: usize = 128;
/// Flags of the header; its highest three bits are the codec.
const SHUFFLED: u8 = 1;
const COPIED: u8 = 2;
const BITS_SHUFFLED: u8 = 4;
const WHOLE: u8 = 16;
/// How far back the short form of a BloscLZ match reaches.
const NEAR: usize = 8191;

/// Why a chunk cannot be unpacked.
pub(super) enum Fault {
    /// It breaks its format.
    Damaged(&'static str),
    /// It uses a part of it that is not read.
    Unsupported(String),
}

use Fault::{Damaged, Unsupported};

/// The `bytes` bytes that are in `chunk`.
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

/// The 32 bits at `at`.
fn number(bytes: &[u8], at: usize) -> Result<usize, Fault> {
    let chunk = bytes.get(at..).and_then(|rest| rest.first_chunk());
    chunk.map(|chunk| u32::from_le_bytes(*chunk) as usize).ok_or(Damaged("a number of it is cut off"))
}

/// A block of `size` bytes that was compressed in equal parts.
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

/// Appends the `size` bytes that `packed` is in BloscLZ.
fn blosclz(packed: &[u8], size: usize, unpacked: &mut Vec<u8>) -> Result<(), Fault> {
    const CUT: Fault = Damaged("a block of BloscLZ in it is cut off");
    let start = unpacked.len();
    let mut input = packed.iter().copied();
    let mut control = input.next().map(|byte| usize::from(byte) & 31); // the first one is of literals
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
                unpacked.push(unpacked[at]); // it may read what it has just written
            }
        }
        control = input.next().map(usize::from);
    }
    if unpacked.len() == start + size { Ok(()) } else { Err(Damaged("a block of BloscLZ in it is of another length")) }
}

/// Appends values whose first bytes come first, then all second bytes, and so on.
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

    /// 250 numbers that compress well, and 30 that do not.
    fn mixed() -> Vec<u8> {
        let smooth = (0..250).map(|index| (index / 7) as f32 * 0.25);
        let rough = (0..30_u32).map(|index| f32::from_bits(index.wrapping_mul(2_654_435_769) >> 2));
        smooth.chain(rough).flat_map(f32::to_le_bytes).collect()
    }

    /// Numbers that fill five blocks, the last one not whole.
    fn steps() -> Vec<u8> {
        (0..70_001).flat_map(|index| ((index / 5000) as f32 * 0.5).to_le_bytes()).collect()
    }

    fn start() -> Vec<u8> {
        mixed()[..100].to_vec()
    }

    /// What they are, what is in them, and chunks that C-Blosc 1.21.7 wrote of that.
    fn chunks() -> Vec<(&'static str, Vec<u8>, Vec<u8>)> {
        let decoded = |(name, data, text): (_, _, &str)| (name, data, STANDARD.decode(text).unwrap());
        CHUNKS.map(|(name, data, text)| decoded((name, data(), text))).to_vec()
    }

    fn fault(chunk: &[u8], bytes: usize) -> String {
        match decode(chunk, bytes) {
            Ok(found) => panic!("{found:?}"),
            Err(Damaged(what)) => what.into(),
            Err(Unsupported(what)) => what,
        }
    }

    #[test]
    fn chunks_of_c_blosc_are_what_was_put_into_them() {
        for (name, data, chunk) in chunks() {
            assert!(decode(&chunk, data.len()).is_ok_and(|found| found == data), "{name}");
        }
    }

    #[test]
    fn damaged_chunks_are_refused_and_never_grow() {
        for (name, data, chunk) in chunks().into_iter().take(4) {
            for length in 0..chunk.len() {
                assert!(decode(&chunk[..length], data.len()).is_err(), "{name}, {length} bytes");
            }
            for at in (0..chunk.len()).step_by(3) {
                for byte in [0, 1, 31, 255] {
                    let mut bad = chunk.clone();
                    bad[at] = byte;
                    assert!(decode(&bad, data.len()).map_or(true, |found| found.len() == data.len()), "{name}, {at}");
                }
            }
        }
    }

    #[test]
    fn what_is_not_read_is_named() {
        let (_, data, chunk) = chunks().swap_remove(2);
        let with = |at: usize, byte: u8| {
            let mut bad = chunk.clone();
            bad[at] = byte;
            fault(&bad, data.len())
        };
        assert_eq!(with(0, 3), "version 3");
        assert_eq!(with(2, 0x24), "shuffle of bits");
        for (codec, name) in [(2, "Snappy"), (3, "zlib"), (4, "Zstandard"), (6, "6")] {
            assert_eq!(with(2, codec << 5 | 1), format!("codec {name}"));
        }
        assert_eq!(with(4, 7), "its Blosc header is of another length");
        assert_eq!(with(3, 0), "its Blosc header has blocks of no or too many bytes");
        assert_eq!(with(16, 255), "a block of it is cut off");
        assert_eq!(fault(&chunk, data.len() - 1), "its Blosc header is of another length");
        assert_eq!(fault(&chunk[..9], data.len()), "its Blosc header is cut off");
    }

    /// What a chunk is, what is in it, and itself.
    type Chunk = (&'static str, fn() -> Vec<u8>, &'static str);

    const CHUNKS: [Chunk; 7] = [
        (
            "BloscLZ, of split values",
            mixed,
            "AgEBBGAEAABgBAAAUAEAABQAAAAmAAAAIwAAAADg7gMcbtxKuSeVA3LgTrwrmQd15FLALp0LeedWxDKgD30mAAAAIwAAAADg7gMc\
         3rybeVg2FfPRsI5tSyoI5sWjgmA/HfvauJd1VDKnAAAAJwAAAAAAAACAgACgDQBAgACAEwGAoIAAAMCAAADggACgKQAQgAAAIIAA\
         ADCAAIA9AUBQgAAAYIAAAHCAAKBTAIiAAACQgAAAmIAAgGcBoKiAAACwgAAAuIAAgHwBwMiAAADQgAAA2IAAgJEB4OiAAADwgAAA\
         +IAAoKcABIAAAAiAAB8MDAwMDACNG6k3xVPhbvyKGKY0wlDda/mHFaMxvkzaaAL2hBI5AAAAJwAAAAAAAAA+gAAAP+AgAABA4J4A\
         AEHgEAAdACcPNh4FLRQ8IwszGgIpETggBy8XPiYNNRwEKxM7",
        ),
        (
            "BloscLZ, of bytes",
            mixed,
            "AgEAAWAEAABgBAAAbAEAABQAAABUAQAAIwAAAADgEQMBgD7gEQMBAD/gEQMBQD/gEQMBgD/gEQMBoD/gEQMBwD/gEQMB4D/gEQMB\
         AEDgEQMBEEDgEQMBIEDgEQMBMEDgEQMBQEDgEQMBUEDgEQMBYEDgEQMBcEDgEQMBgEDgEQMBiEDgEQMBkEDgEQMBmEDgEQMBoEDg\
         EQMBqEDgEQMBsEDgEQMBuEDgEQMBwEDgEQMByEDgEQMB0EDgEQMB2EDgEQMB4EDgEQMB6EDgEQMB8EDgEQMB+EDgEQMBAEHgEQMB\
         BEHgEQMBCEHgEQMBDEHgCQMfAABu3o0n3LwbD0qbqTa5eTceJ1jFBZU2Uy0DFeEUcvMfbjzg0fwjTrCKC7yOGDMrbaYamUs0Agcq\
         wil1CFAR5OYf3ThSxWsgwKP5By6Chy+dYBUXCz+jPnkdMSbn+74NVtoVTDXEuNocMpdoBKB19isPVIQTfTISOw==",
        ),
        (
            "LZ4, of shuffled values",
            mixed,
            "AgEhBGAEAABgBAAAUAEAABQAAAAkAAAAHwABAOfwDm7cSrknlQNy4E68K5kHdeRSwC6dC3nnVsQyoA99JAAAAB8AAQDn8A7evJt5\
         WDYV89Gwjm1LKgjmxaOCYD8d+9q4l3VUMq0AAAASAAEAEoABAAINACIAQAEAAhQAIoCgAQASwAEAEuABAAMqABIQAQASIAEAEjAB\
         AAI+ACJAUAEAEmABABJwAQADVAASiAEAEpABABKYAQACaAAioKgBABKwAQASuAEAAn0AIsDIAQAS0AEAEtgBAAKSACLg6AEAEvAB\
         ABL4AQADqAASBAEAEggBABAMAQDwDwCNG6k3xVPhbvyKGKY0wlDda/mHFaMxvkzaaPaEEjcAAAASAAEAEj4BAB8/AQAWH0ABAJQf\
         QQEABvAPACcPNh4FLRQ8IwszGgIpETggBy8XPiYNNRwEKxM7",
        ),
        (
            "LZ4, of split bytes",
            mixed,
            "AgEgAmAEAABgBAAAVQEAABQAAABtAAAAHwABAAovgD4EAAcvAD8EAAcfQAQACB+ABAAIH6AEAAgfwAQACB/gBAAILwBABAAHHxAE\
         AAgfIAQACB8wBAAIH0AEAAgfUAQACB9gBAAIH3AEAAgfgAQACB+IBAAIH5AEAAgfmAQAAVBAAACYQMwAAABPAACgQAQABx+oBAAI\
         H7AEAAgfuAQACB/ABAAIH8gEAAgf0AQACB/YBAAIH+AEAAgf6AQACB/wBAAIH/gEAAgvAEEEAAcfBAQACB8IBAAIHwwEAADwZwAA\
         bt6NJ9y8Gw9Km6k2uXk3HidYxQWVNlMtAxXhFHLzbjzg0fwjTrCKC7yOGDMrbaYamUs0Agcqwil1CFAR5ObdOFLFayDAo/kHLoKH\
         L51gFRcLP6M+eR0xJuf7vg1W2kw1xLjaHDKXaASgdfYrD1SEE30yEjs=",
        ),
        (
            "LZ4, of several blocks",
            steps,
            "AgEhBMRFBAAAAAEArwUAACQAAABtAQAAugIAAAMEAABRBQAASwAAAB8AAQD/////////////////////////////////////////\
         ////////////////////////////////////////////J1AAAAAAAEsAAAAfAAEA////////////////////////////////////\
         /////////////////////////////////////////////////ydQAAAAAABUAAAAHwABAP//////////////////////////////\
         /////////////////////yMfgAEA/////////////////////////4cfwAEA//////9UUMDAwMDATwAAAB8AAQD/////////////\
         ////////////hx8/AQD//////////////////////////////////////////////////////////4tQPz8/Pz9LAAAAHwABAP//\
         //////////////////////////////////////////////////////////////////////////////////8nUAAAAAAASwAAAB8A\
         AQD/////////////////////////////////////////////////////////////////////////////////////J1AAAAAAAFgA\
         AAAfwAEA//////////////////8aHwABAP////////////////////////+HHyABAP////////////////////////+HH0ABAP//\
         ///////////BUEBAQEBATwAAAB8/AQD//////////////////xofQAEA////////////////////////////////////////////\
         //////////////////////hQQEBAQEBLAAAAHwABAP//////////////////////////////////////////////////////////\
         //////////////////////////8nUAAAAAAASwAAAB8AAQD/////////////////////////////////////////////////////\
         ////////////////////////////////J1AAAAAAAFgAAAAfQAEA//////////+sH2ABAP////////////////////////+HH4AB\
         AP////////////////////////+HH5ABAP////////////////////8vUJCQkJCQSwAAAB9AAQD/////////////////////////\
         ////////////////////////////////////////////////////////////J1BAQEBAQEsAAAAfAAEA////////////////////\
         /////////////////////////////////////////////////////////////////ydQAAAAAABLAAAAHwABAP//////////////\
         //////////////////////////////////////////////////////////////////////8nUAAAAAAAXQAAAB+QAQD///8/H6AB\
         AP////////////////////////+HH7ABAP////////////////////////+HH8ABAP////////////////////////+HH9ABAP//\
         AVDQ0NDQ0EsAAAAfQAEA////////////////////////////////////////////////////////////////////////////////\
         /////ydQQEBAQEBaAAAAHwABAP/////////////////////////////////////////////wH9ABAP//////////////////////\
         bS/gQAEA//////////////////////9pUEBAQEBA",
        ),
        (
            "BloscLZ, of several blocks",
            steps,
            "AgEBBMRFBAAAAAEA0QUAACQAAAB0AQAAygIAABoEAABwBQAATAAAACMAAAAA4P//////////////////////////////////////\
         //////////////////////////////////////////////8wAwIAAABMAAAAIwAAAADg////////////////////////////////\
         /////////////////////////////////////////////////////zADAgAAAFcAAAAjAAAAAOD/////////////////////////\
         //////////////////////////8pAwEAgOD/////////////////////////kAABgMDg//////9gAALAwMBRAAAAIwAAAADg////\
         /////////////////////40DAQA/4P//////////////////////////////////////////////////////////lwACPz8/TAAA\
         ACMAAAAA4P////////////////////////////////////////////////////////////////////////////////////8wAwIA\
         AABMAAAAIwAAAADg////////////////////////////////////////////////////////////////////////////////////\
         /zADAgAAAFwAAAAjwMDAwOD//////////////////yADAcAA4P////////////////////////+QAAEAIOD/////////////////\
         ////////kAABIEDg/////////////80AAkBAQFIAAAAjPz8/P+D//////////////////yADAT9A4P//////////////////////\
         ////////////////////////////////////////////BQACQEBATAAAACMAAAAA4P//////////////////////////////////\
         //////////////////////////////////////////////////8wAwIAAABMAAAAIwAAAADg////////////////////////////\
         /////////////////////////////////////////////////////////zADAgAAAFwAAAAjQEBAQOD//////////7IDAUBg4P//\
         //////////////////////+QAAFggOD/////////////////////////kAABgJDg/////////////////////zsAApCQkEwAAAAj\
         QEBAQOD/////////////////////////////////////////////////////////////////////////////////////MAMCQEBA\
         TAAAACMAAAAA4P////////////////////////////////////////////////////////////////////////////////////8w\
         AwIAAABMAAAAIwAAAADg////////////////////////////////////////////////////////////////////////////////\
         /////zADAgAAAGIAAAAjkJCQkOD///9FAwGQoOD/////////////////////////kAABoLDg/////////////////////////5AA\
         AbDA4P////////////////////////+QAAHA0OD//w0AAtDQ0EwAAAAjQEBAQOD/////////////////////////////////////\
         ////////////////////////////////////////////////MAMCQEBAXQAAACMAAAAA4P//////////////////////////////\
         ///////////////2AwEA0OD//////////////////////3YAAtDgQOD//////////////////////3UAAkBAQA==",
        ),
        (
            "a copy",
            start,
            "AgEzBGQAAABkAAAAdAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAIA+AACAPgAAgD4AAIA+AACAPgAAgD4AAIA+AAAA\
         PwAAAD8AAAA/AAAAPwAAAD8AAAA/AAAAPwAAQD8AAEA/AABAPwAAQD8=",
        ),
    ];
}
